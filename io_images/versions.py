"""Finds versions of distributions without `importlib.metadata`, which would import all of `email`."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from typing import Any

UNKNOWN = "unknown"
"""Version of a distribution that is not installed."""


def distribution_version(distribution: str) -> str:
    """Return the version of a distribution; "unknown" if it is not installed.

    If scanrack runs from a checkout, the checkout's version is returned, even if another version is
    installed.
    `importlib.metadata` is used only for distributions that are not in a folder of `sys.path`, such as
    distributions in a zip file.

    >>> distribution_version("no such distribution")
    'unknown'
    """
    if distribution == "scanrack" and (project := own_project()):
        return str(project["version"])
    for path in _metadata_of(re.sub(r"[-_.]+", "_", distribution).lower()):
        with open(path, encoding="utf-8") as file:
            for line in file:
                key, colon, value = line.partition(":")
                if key.lower() == "version":
                    return value.strip()
                if not colon and not line.strip():  # the end of the header
                    break
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(distribution)
    except PackageNotFoundError:
        return UNKNOWN


def own_project() -> dict[str, Any] | None:
    """Return the `project` table of the checkout's `pyproject.toml`; None if scanrack is installed."""
    folders = sys.modules["scanrack"].__path__
    if len(folders) < 2:
        return None
    from .doors import toml_tables

    with open(os.path.join(folders[1], "pyproject.toml"), encoding="utf-8") as file:
        return toml_tables(file.read())["project"]  # type: ignore[no-any-return]


def _metadata_of(name: str) -> Iterator[str]:
    """Yield the paths of a distribution's metadata files, in the order of the search path."""
    for folder in sys.path:  # noqa: TID251 - it is only read
        try:
            entries = os.listdir(folder or ".")
        except OSError:  # it does not exist, or is not a folder
            continue
        for entry in entries:
            stem, suffix = os.path.splitext(entry.lower())
            is_distribution = re.sub(r"[-_.]+", "_", stem.partition("-")[0]) == name
            if is_distribution and suffix in (".dist-info", ".egg-info"):
                file_name = "METADATA" if suffix == ".dist-info" else "PKG-INFO"
                path = os.path.join(folder, entry, file_name)
                if os.path.isfile(path):
                    yield path
