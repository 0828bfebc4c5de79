"""A function is read at a glance: none has more than eighty lines."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from house import ROOMS

ROOT = Path(__file__).parents[3]
MOST_LINES = 80
"""Options of a command are fields of a dataclass, see `scanrack/terminal/grouped.py`."""


def functions(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines and the name of each function."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno is not None
            yield node.end_lineno - node.lineno + 1, node.name


def test_a_function_is_as_long_as_its_lines() -> None:
    assert list(functions("x = 1\ndef one(\n    a,\n):\n    return a\n")) == [(4, "one")]


@pytest.mark.slow
def test_no_function_is_long() -> None:
    files = [file for room in ROOMS for file in (ROOT / room).rglob("*.py")]
    assert len(files) > 1_000
    assert [
        f"{file.relative_to(ROOT)}: {name} has {lines} lines"
        for file in files
        for text in [file.read_text(encoding="utf-8")]
        if text.count("\n") > MOST_LINES  # a shorter file needs no tree
        for lines, name in functions(text)
        if lines > MOST_LINES
    ] == []
