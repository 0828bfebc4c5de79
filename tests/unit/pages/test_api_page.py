"""docs/api.md has every public name of scanrack, the bench and its parts, and the fixtures of pytest."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest
import scanrack
from scanrack import pytest_plugin
from scanrack.jobs import bench as bench_package

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "api.md").read_text(encoding="utf-8")
ENTRY = re.compile(r"^\.\. (currentmodule|auto\w+):: ([\w.]+)$((?:\n   .*)*)", re.MULTILINE)


def entries() -> dict[str, tuple[Any, str]]:
    """Return what the page describes by its name, each with the options of its line."""
    found: dict[str, tuple[Any, str]] = {}
    module = ""
    for directive, name, options in ENTRY.findall(PAGE):
        if directive == "currentmodule":
            module = name
        else:
            found[name] = (getattr(importlib.import_module(module), name), options)
    return found


def test_every_public_name_is_on_the_page_or_with_the_instructions() -> None:
    instructions = set(re.findall(r"\b[A-Z]{2,}\b", (DOCS / "instructions.md").read_text(encoding="utf-8")))
    missing = set(dir(scanrack)) - entries().keys() - instructions - {"__version__"}
    assert sorted(name for name in missing if f"`{name}`" not in PAGE) == []


@pytest.mark.parametrize("name", [*bench_package.__all__])
def test_what_a_bench_gives_is_on_the_page(name: str) -> None:
    if name != "ObservedLogic":  # a protocol of scanrack's own
        assert name in entries()


def test_a_public_member_of_what_is_shown_with_its_members_says_what_it_is() -> None:
    silent = [
        f"{name}.{member}"
        for name, (thing, options) in entries().items()
        if ":members:" in options
        for member, value in vars(thing).items()
        if (not member.startswith("_") or member in options)
        and (inspect.isfunction(value) or isinstance(value, property))
        and not inspect.getdoc(getattr(thing, member))
    ]
    assert silent == []
    assert ":special-members: __getitem__, __setitem__" in entries()["Bench"][1]


def test_every_fixture_is_on_the_page() -> None:
    source = inspect.getsource(pytest_plugin)
    fixtures = re.findall(r"^@pytest\.fixture\ndef (\w+)\(", source, re.MULTILINE)
    assert len(fixtures) >= 3
    assert [name for name in fixtures if not re.search(rf"^\| `{name}` \|", PAGE, re.MULTILINE)] == []


def test_a_test_can_name_the_type_of_its_bench() -> None:
    assert scanrack.Bench is bench_package.Bench
