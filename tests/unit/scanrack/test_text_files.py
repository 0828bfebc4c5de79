"""Text files name their encoding, and where they are written their line ends: equal on every system."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from house import ROOMS

ROOT = Path(__file__).parents[3]
SOURCES = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
OTHERS = [
    path for each in ("tests", "examples", "benchmarks") for path in sorted((ROOT / each).rglob("*.py"))
]

PLACES = {"read_text": 0, "write_text": 1}
"""Methods of a path that open text, and the place of the encoding among their arguments."""

MAY_OPEN = re.compile(r"open\(|makefile\(|read_text|write_text|text=True")
"""Part of each source that opens text."""


def missing(source: str) -> Iterator[str]:
    """Yield what is not named where text is opened: the line and the option."""
    if not MAY_OPEN.search(source):
        return  # it needs no tree
    for call in ast.walk(ast.parse(source)):
        if not isinstance(call, ast.Call):
            continue
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        wanted = set(_wanted(name, call)) - {str(each.arg) for each in call.keywords}
        if not any(each.arg is None for each in call.keywords):  # `**options`
            yield from (f"{call.lineno}: {each}" for each in sorted(wanted))


def _wanted(name: str, call: ast.Call) -> Iterator[str]:
    """Yield the options that a call needs; `write_text` that is no method is our own."""
    if name in PLACES and isinstance(call.func, ast.Attribute):
        if len(call.args) <= PLACES[name]:
            yield "encoding"
        if name == "write_text":
            yield "newline"
    elif any(each.arg == "text" and getattr(each.value, "value", False) is True for each in call.keywords):
        yield "encoding"  # pipes of a process
    elif name in ("open", "fdopen", "makefile"):
        modes = [each.value for each in call.args if isinstance(each, ast.Constant)]
        mode = next((str(each) for each in modes if each and set(str(each)) <= set("rwxabt+")), None)
        if mode is not None and "b" not in mode:
            yield from ("encoding",) if mode == "r" else ("encoding", "newline")
        elif mode is None and isinstance(call.func, ast.Name):
            yield "encoding"


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("path.write_text(text)", ["1: encoding", "1: newline"]),
        ("path.write_text(text, 'utf-8', newline='')", []),
        ("write_text(path, text)", []),
        ("path.read_text()", ["1: encoding"]),
        ("path.open('w', encoding='utf-8')", ["1: newline"]),
        ("open(path)", ["1: encoding"]),
        ("open(path, 'xb')", []),
        ("open(path, mode, **options)", []),
        ("subprocess.run(words, stdout=PIPE, text=True)", ["1: encoding"]),
        ("subprocess.run(words, stdout=PIPE, text=True, encoding='utf-8')", []),
    ],
)
def test_what_is_not_named_is_found(source: str, found: list[str]) -> None:
    assert [*missing(source)] == found


@pytest.mark.slow
def test_every_text_file_of_the_product_has_its_encoding_and_its_line_ends() -> None:
    found = {str(path): [*missing(path.read_text(encoding="utf-8"))] for path in SOURCES}
    assert {path: lines for path, lines in found.items() if lines} == {}


@pytest.mark.slow
def test_every_text_file_of_tests_and_examples_has_its_encoding() -> None:
    """Their line ends are those of the system."""
    found = {str(path): [*missing(path.read_text(encoding="utf-8"))] for path in OTHERS}
    assert {path for path, lines in found.items() if any("encoding" in each for each in lines)} == set()
