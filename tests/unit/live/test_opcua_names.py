"""The OPC UA server uses private names of asyncua, which has no public ones: hence the bound below 2.2.

asyncua's own start opens another socket, and nothing public stands between its messages and its services.
"""

from __future__ import annotations

import ast
from importlib.util import find_spec
from pathlib import Path

import pytest

LIVE = Path(__file__).parents[3] / "runtime" / "live"


def private_names(file: Path) -> set[str]:
    """Return the private names that a file takes from what is not its own `self`."""
    return {
        node.attr
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute)
        and node.attr.startswith("_")
        and not node.attr.startswith("__")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))
    }


@pytest.mark.extra("opcua")
def test_private_names_are_there() -> None:
    spec = find_spec("asyncua")
    assert spec is not None
    assert spec.submodule_search_locations
    theirs = "".join(
        each.read_text(encoding="utf-8")
        for folder in ("server", "common")
        for each in (Path(spec.submodule_search_locations[0]) / folder).rglob("*.py")
    )
    used = set().union(*(private_names(each) for each in LIVE.glob("opcua_*.py")))
    assert used
    assert {name for name in used if name not in theirs} == set()
