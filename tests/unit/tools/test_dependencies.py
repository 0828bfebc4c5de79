"""What each room imports is declared in `pyproject.toml`: requirements for all rooms, extras for some."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # each file of the product is parsed

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ROOMS: dict[str, frozenset[str]] = {
    "scanrack": frozenset({"check", "cluster", "conform", "editor", "opcua", "test"}),
    "io_images": frozenset(),
    "ladder": frozenset({"prove"}),
    "rockwell": frozenset(),
    "runtime": frozenset({"opcua"}),
    "traces": frozenset({"frames", "parquet", "plot"}),
}
"""The rooms, each with the extras that it uses."""

DISTRIBUTIONS = {
    "annotationlib": "",  # of Python 3.14
    "_typeshed": "",  # for type checkers only
    "pydantic_core": "pydantic",  # comes with it, in exactly its version
    "serial": "pyserial",
    "vcd": "pyvcd",
    "z3": "z3-solver",
}
"""Modules that are not called like their distribution."""


def distribution_of(module: str) -> str:
    name = module.partition(".")[0]
    return DISTRIBUTIONS.get(name, name.replace("_", "-"))


def names(requirements: list[str]) -> set[str]:
    return {re.split(r"[^\w.-]", each)[0].lower() for each in requirements}


REQUIRED = names(PROJECT["dependencies"])
EXTRAS = {name: names(each) for name, each in PROJECT["optional-dependencies"].items()}


def imported(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the modules that a file imports, each with the extra that the call names, or ""."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module, ""
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            words = [each.value for each in node.args if isinstance(each, ast.Constant)]
            if node.func.id == "import_module" and words and not str(words[0]).startswith("."):
                yield str(words[0]), ""
            elif node.func.id == "need" and len(words) == 2:
                yield str(words[0]), str(words[1])


@cache
def found(room: str) -> set[tuple[str, str]]:
    """Return the distributions that a room imports, each with the extra of its call."""
    pairs: set[tuple[str, str]] = set()
    for file in (ROOT / room).rglob("*.py"):
        for module, extra in imported(ast.parse(file.read_text(encoding="utf-8"))):
            top = module.partition(".")[0]
            if top not in sys.stdlib_module_names and top not in ("scanrack", *ROOMS):
                pairs.add((distribution_of(module), extra))
    return {pair for pair in pairs if pair[0]}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_what_is_declared(room: str) -> None:
    pairs = found(room)
    allowed = REQUIRED.union(*(EXTRAS[each] for each in ROOMS[room]))
    assert {each for each, _ in pairs} <= allowed
    assert all(each in EXTRAS[extra] for each, extra in pairs if extra)
    assert all(EXTRAS[extra] & {each for each, _ in pairs} for extra in ROOMS[room])


def test_what_is_required_is_imported() -> None:
    everything = {each for room in ROOMS for each, _ in found(room)}
    assert everything >= REQUIRED
    own = {extra: names for extra, names in EXTRAS.items() if extra not in ("docs", "test", "dev")}
    assert {name for names in own.values() for name in names} <= everything
