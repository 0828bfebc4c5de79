"""Splits an export into lines, with their words and the comments between two %.

    SOR XIC B3:0/1 OTE O:0/0 EOR        % what it does %        words, and a comment
    % TITLE/RUNG DESCRIPTION
    50 % of the speed
    %                                                            one comment: up to a line that ends in %

A % in quotation marks is a plain character. A multi-line comment ends before a line that begins a section: an
unclosed % counts as a word.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

_PIECE = re.compile(r'%([^%]*)%|("[^"]*"|(?:(?!//)[^\s%])++)|(//.*)|(%)')
"""A comment, a word, a comment up to the end of the line, or the start of a multi-line comment."""

WORD = re.compile(r'"[^"]*"|\S+')
"""A word, or a text in quotation marks."""

_SECTION = re.compile(
    r'\s*(?:SOR\b|DATA\s+\S+\s*[:;]|FORCE\s+\S+\s*:|(?:LADDER|LAD|SLOT)\s+\d|(?:START|PROJECT)\s+[\S"])'
)
"""Beginning of a section or rung, which ends a multi-line comment."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line: its number, its words, and its comments, multi-line comments at their first line."""

    number: int
    words: tuple[str, ...]
    comments: tuple[str, ...]

    @property
    def plain(self) -> str:
        """Its text without comments."""
        return " ".join(self.words)

    @property
    def begins_rung(self) -> bool:
        """Whether a rung begins in it."""
        return bool(self.words) and self.words[0].upper().startswith("SOR")


def lines_of(text: str) -> Iterator[Line]:
    """Yield the lines of an export, except lines inside comments."""
    lines = text.splitlines()
    position = searched = 0  # no line from `position` up to `searched` ends a comment
    while position < len(lines):
        words: list[str] = []
        comments: list[str] = []
        after = position + 1
        for piece in _PIECE.finditer(lines[position]):
            comment, word, _, opened = piece.groups()
            if word:
                words.append(word)
            elif comment is not None:
                comments.append(comment)
            elif opened:
                searched, ends = (
                    (searched, False) if searched > position + 1 else _end_of_comment(lines, position + 1)
                )
                if not ends:
                    words.append(opened)
                    continue
                inside = [lines[position][piece.end() :], *lines[position + 1 : searched]]
                comments.append("\n".join((*inside, lines[searched].rstrip()[:-1])))
                after = searched + 1
                break
        yield Line(position + 1, tuple(words), tuple(comments))
        position = after


def _end_of_comment(lines: list[str], at: int) -> tuple[int, bool]:
    """Return the last line of a multi-line comment and whether a mark or a section ends it."""
    for number in range(at, len(lines)):
        if _SECTION.match(lines[number]):
            return number, False
        if lines[number].rstrip().endswith("%"):
            return number, True
    return len(lines), False
