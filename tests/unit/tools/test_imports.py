"""An import says which room it takes a name from: another room by its full name, the own one relatively."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from house import ROOMS, ROOT

FILES = sorted(path.relative_to(ROOT) for room in ROOMS for path in (ROOT / room).rglob("*.py"))


def module_of(path: Path) -> list[str]:
    """Return the parts of a file's dotted name: scanrack, room, ..."""
    parts = list(path.with_suffix("").parts)
    return parts if parts[0] == "scanrack" else ["scanrack", *parts]


def broken(path: Path, text: str) -> Iterator[str]:
    """Yield imports that leave the room by dots, that name it, or that find no file in the checkout."""
    here = module_of(path)
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.ImportFrom):
            continue
        module = (node.module or "").split(".") if node.module else []
        target = [*here[: -node.level], *module] if node.level else module
        if target[:1] != ["scanrack"]:
            continue
        own = len(here) > 2 and target[1:2] == here[1:2]
        folder = ROOT.joinpath(*target if target[1:2] and target[1] not in ROOMS else target[1:])
        if own != bool(node.level) or not (folder.is_dir() or folder.with_suffix(".py").is_file()):
            yield f"{path}:{node.lineno}: from {'.' * node.level}{node.module or ''} import ..."


@pytest.mark.slow
def test_imports_name_other_rooms_and_stay_relative_in_their_own() -> None:
    assert [each for path in FILES for each in broken(path, (ROOT / path).read_text("utf-8"))] == []


@pytest.mark.parametrize(
    ("line", "is_broken"),
    [
        ("from ..model.tree import Rung", False),
        ("from scanrack.io_images.image import Image", False),
        ("from scanrack.jobs.load.loading import load_rack", False),
        ("from ...io_images.image import Image", True),
        ("from scanrack.ladder.model.tree import Rung", True),
        ("from scanrack.io_images.nowhere import Image", True),
        ("from ..model.nowhere import Rung", True),
        ("from pathlib import Path", False),
    ],
)
def test_which_imports_are_broken(line: str, is_broken: bool) -> None:
    assert bool(list(broken(Path("ladder/debug/causes.py"), line))) is is_broken
