"""Tables, lists and docstrings keep their layout: what wraps lines must not join rows, items or entries."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from house import ROOMS, ROOT

PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")])
ENTRY = re.compile(r"[\w*.]+(, [\w*.]+)*: ")


def misshapen(text: str) -> Iterator[str]:
    """Yield rows of tables that have other cells than their head, and lines that contain a list's mark."""
    cells = None
    for line in re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE).splitlines():
        if line.startswith("|"):
            count = len(re.findall(r"(?<!\\)\|", re.sub(r"`[^`]*`", "", line)))
            cells = cells or count
            if count != cells or not line.rstrip().endswith("|"):
                yield line
        else:
            cells = None
        if re.search(r"; \* \w", line):
            yield line


def unindented(text: str) -> Iterator[str]:
    """Yield lines of a docstring's Args, Attributes and Raises that continue an entry at its level."""
    indent = None
    for line in text.splitlines():
        if line in ("Args:", "Attributes:", "Raises:"):
            indent = 4
        elif indent and line and not line.startswith(" "):
            indent = None
        elif indent and re.match(r" {4}\S", line) and not ENTRY.match(line.strip()):
            yield line


def docstrings(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            yield ast.get_docstring(node) or ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_rows_and_items_have_lines_of_their_own(page: Path) -> None:
    assert list(misshapen(page.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("room", ROOMS)
def test_entries_of_docstrings_are_continued_with_an_indent(room: str) -> None:
    paths = [path for path in sorted((ROOT / room).rglob("*.py")) if not path.is_symlink()]
    assert paths
    assert [
        (path.name, line) for path in paths for text in docstrings(path) for line in unindented(text)
    ] == []


def test_what_is_misshapen_is_found() -> None:
    assert [*misshapen("| a | b |\n|---|---|\n| 1 | 2 | | 3 | 4 |\n\n* one; * two\n")] == [
        "| 1 | 2 | | 3 | 4 |",
        "* one; * two",
    ]
    assert [*misshapen("| a | `b | c` |\n|---|---|\n| 1 | 2\n")] == ["| 1 | 2"]
    assert [
        *unindented(
            "Do it.\n\nArgs:\n    size: bytes of the\n    file.\n    name: its name\n        in full.\n"
        )
    ] == ["    file."]
