"""Tests that need an extra of the package: `@pytest.mark.extra("plot")`.

They are skipped with their reason where the extra is not installed; `pytest -m extra` runs them alone.
"""

from __future__ import annotations

import re
from importlib.metadata import requires
from importlib.util import find_spec

import pytest
from scanrack.io_images.installing import how_to_install


def modules(extra: str) -> list[str]:
    """Return the distributions that an extra adds; each has one module of its name.

    Raises:
        ValueError: the package has no extra of that name.
    """
    found = [
        re.split(r"[^\w.-]", line)[0]
        for line in requires("scanrack") or ()
        if re.search(rf"""extra == ["']{re.escape(extra)}["']""", line)
    ]
    if not found:
        raise ValueError(f"scanrack has no extra {extra!r}")
    return found


def skip_without_extras(items: list[pytest.Item]) -> None:
    """Mark the tests whose extra is not installed as skipped."""
    missing: dict[str, list[str]] = {}
    for item in items:
        for mark in item.iter_markers("extra"):
            (extra,) = mark.args
            if extra not in missing:
                missing[extra] = [name for name in modules(extra) if find_spec(name) is None]
            if missing[extra]:
                reason = f"{missing[extra][0]} is not installed: {how_to_install(extra)}"
                item.add_marker(pytest.mark.skip(reason=reason))
