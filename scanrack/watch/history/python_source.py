"""The text of a Python program or list of steps for pages, with the kinds of its tokens."""

from __future__ import annotations

import ast
import keyword
import tokenize
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from scanrack.runtime.loop.faults import Fault

from .catalog import Json, PageRoutine

Span = tuple[int, int, str]
"""Start, end and kind of a token in a line. Positions are in UTF-16 units, as in a browser."""

_KINDS = {tokenize.COMMENT: "comment", tokenize.NUMBER: "number", tokenize.STRING: "string"}
_F_STRING = {
    number for name in ("START", "MIDDLE", "END") if (number := getattr(tokenize, f"FSTRING_{name}", None))
}
"""Token types of f-strings in Python 3.12 and later."""


def spans_of(lines: Sequence[str]) -> dict[int, list[Span]]:
    """Return the spans of each line by line number, from 1; stop at text that can't be tokenized."""
    spans: dict[int, list[Span]] = {}
    for token, kind in _tokens(lines):
        (first, begin), (last, end) = token.start, token.end
        for number in range(first, last + 1):
            text = lines[number - 1]
            span_start = _units(text, begin) if number == first else 0
            span_end = _units(text, end) if number == last else _units(text, len(text))
            if span_start < span_end:
                spans.setdefault(number, []).append((span_start, span_end, kind))
    return spans


def _tokens(lines: Sequence[str]) -> Iterator[tuple[tokenize.TokenInfo, str]]:
    """Yield the tokens that have a kind, and their kinds; stop at text that can't be tokenized."""
    previous = ""
    try:
        for token in tokenize.generate_tokens((f"{line}\n" for line in lines).__next__):
            kind = "string" if token.type in _F_STRING else _KINDS.get(token.type, "")
            if token.type == tokenize.NAME and keyword.iskeyword(token.string):
                kind = "keyword"
            elif token.type == tokenize.NAME and previous in ("def", "class"):
                kind = "defined"
            if kind:
                yield token, kind
            previous = token.string
    except (tokenize.TokenError, SyntaxError):
        return


def _units(text: str, letters: int) -> int:
    """Return the number of UTF-16 units in a text's first `letters` characters."""
    return len(text[:letters].encode("utf-16-le", "surrogatepass")) // 2


class PythonSource:
    """The text of a Python program for pages, as loaded."""

    def __init__(self, file: Path) -> None:
        self._name = file.name
        try:
            self._lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            self._lines = []

    def routines(self) -> list[Json]:
        """Return the file as a single routine for `hello`."""
        kind = "steps" if self._name.endswith(".steps") else "python"
        return [{"name": self._name, "kind": kind, "comment": "", "lines": len(self._lines)}]

    def find(self, text: str) -> list[Json]:
        """Return the lines that contain a text, ignoring case."""
        return [
            {"text": line.strip(), "rung": f"{self._name}.{number}", "tag": None}
            for number, line in enumerate(self._lines, 1)
            if text.casefold() in line.casefold()
        ]

    def place_of_fault(self, fault: Fault) -> str | None:
        """Return the line of a fault, such as line.py.62; None if it is in another file."""
        file, _, line = fault.where.rpartition(":")
        return f"{self._name}.{line}" if Path(file).name == self._name else None

    def tags_of_fault(self, fault: Fault, values: Iterable[str]) -> list[str]:
        """Return the program's values that a fault's line reads, matched by the last part of their names."""
        place = self.place_of_fault(fault)
        number = int(place.rpartition(".")[2]) if place else 0
        names = set(_names_in(self._lines[number - 1])) if 0 < number <= len(self._lines) else set()
        return [value for value in values if value.rpartition(".")[2] in names]

    def show(self, names: tuple[str, ...]) -> tuple[PageRoutine, Json]:
        """Return the routine's contents, and the answer with its text."""
        spans = spans_of(self._lines)
        uses = uses_in("\n".join(self._lines))
        lines = [
            {"number": number, "text": text, "spans": spans.get(number, []), "uses": uses.get(number, [])}
            for number, text in enumerate(self._lines, 1)
        ]
        answer = {"routine": self._name, "file": self._name, "text": lines, "names": list(names)}
        return PageRoutine(self._name, rungs={}, lines=(), names=names), answer


def uses_in(text: str) -> dict[int, list[str]]:
    r"""Return the names and attributes in each line of a program: `line.step`, and `.step` of `self.step`.

    >>> uses_in("class Line:\n    def run(self):\n        self.step = line.count")
    {3: ['.step', 'line.count', 'line']}
    """
    uses: dict[int, dict[str, None]] = {}
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute):
            name = _dotted(node)
            if name and name != "self":
                uses.setdefault(node.lineno, {})[name.removeprefix("self")] = None
    return {line: list(names) for line, names in uses.items()}


def _dotted(node: ast.expr) -> str:
    """Return a name with its attributes, such as `line.step`; "" for another expression."""
    if isinstance(node, ast.Attribute):
        stem = _dotted(node.value)
        return f"{stem}.{node.attr}" if stem else ""
    return node.id if isinstance(node, ast.Name) else ""


def _names_in(line: str) -> Iterator[str]:
    """Yield the names and attributes that a line of Python reads; nothing for an incomplete statement."""
    statement = line.strip()
    try:
        tree = ast.parse(f"{statement} pass" if statement.endswith(":") else statement)
    except SyntaxError:
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Load):
            yield node.id if isinstance(node, ast.Name) else node.attr
