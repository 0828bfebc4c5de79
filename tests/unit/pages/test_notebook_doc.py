"""docs/notebook.md: each cell of the page runs as printed, on the trace that its first lines make."""

from __future__ import annotations

import ast
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

PAGE = (Path(__file__).parents[3] / "docs" / "notebook.md").read_text(encoding="utf-8")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
FRAMES = re.compile(r"to_(?:pandas|polars)\(")


def made(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Do in a folder what the page's block of commands says."""
    monkeypatch.chdir(folder)
    (commands,) = re.findall(r"^```console\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    for line in commands.splitlines():
        command, *words = shlex.split(line.removeprefix("$ "))
        if command == "cd":
            monkeypatch.chdir(words[0])
        else:
            done = CliRunner().invoke(build(), words)
            assert done.exit_code == 0, done.output


def shown(cell: str, names: dict[str, Any]) -> list[Any]:
    """Run a cell; return the value of each of its expressions."""
    found = []
    for each in ast.parse(cell).body:
        text = ast.unparse(each)
        if isinstance(each, ast.Expr):
            found.append(eval(text, names))
        else:
            exec(text, names)
    return found


def cells(*, frames: bool) -> list[str]:
    """Return the cells of the page, without the lines that make frames if these are not wanted."""
    found = PYTHON.findall(PAGE)
    assert len(found) >= 3
    lines = [[line for line in each.splitlines() if frames or not FRAMES.search(line)] for each in found]
    return ["\n".join(each) for each in lines]


@pytest.mark.slow
@pytest.mark.parametrize("frames", [False, pytest.param(True, marks=pytest.mark.extra("frames"))])
def test_each_cell_shows_something(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, frames: bool) -> None:
    made(tmp_path, monkeypatch)
    names: dict[str, Any] = {}
    values = [value for cell in cells(frames=frames) for value in shown(cell, names)]
    assert [value is None for value in values].count(True) == PAGE.count("\nbench.run_until(")
    assert f"`{names['trace']!r}`" in PAGE
    pictured = re.findall(r"^\| `([\w.]+[.(\[].*?)` \|", PAGE, re.MULTILINE)
    assert len(pictured) >= 2
    for each in pictured:
        (value,) = shown(each, names)
        assert value._repr_html_().startswith("<")
    for each in re.findall(r"`((?:bench|print)[.(][^`]*)`", PAGE.rpartition("```")[2]):
        shown(each, names)
    names["trace"].close()
