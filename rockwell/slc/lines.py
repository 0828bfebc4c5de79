"""Splits an export into lines, with their words and the comments between two %.

    SOR XIC B3:0/1 OTE O:0/0 EOR        % what it does %        words, and a comment
    % TITLE/RUNG DESCRIPTION
    50 % of the speed
    %                                                            one comment, up to a line that ends in %

A % in quotation marks is a plain character. A % is a word if a new section begins before the comment ends.
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
    """A line."""

    number: int  # from 1
    words: tuple[str, ...]
    comments: tuple[str, ...]  # including a multi-line comment that begins in it

    @property
    def plain(self) -> str:
        """The text without comments."""
        return " ".join(self.words)

    @property
    def begins_rung(self) -> bool:
        """Whether a rung begins in this line."""
        return bool(self.words) and self.words[0].upper().startswith("SOR")


def lines_of(text: str) -> Iterator[Line]:
    """Yield the lines of an export, except lines inside comments."""
    lines = text.splitlines()
    index = 0
    searched = 0  # no comment can end before this line: searched once, since every % would search again
    while index < len(lines):
        words: list[str] = []
        comments: list[str] = []
        next_index = index + 1
        for piece in _PIECE.finditer(lines[index]):
            comment, word, _, opening = piece.groups()
            if word:
                words.append(word)
            elif comment is not None:
                comments.append(comment)
            elif opening:
                is_closed = False
                if searched <= index + 1:
                    searched, is_closed = _end_of_comment(lines, index + 1)
                if not is_closed:
                    words.append(opening)
                    continue
                inner_lines = [lines[index][piece.end() :], *lines[index + 1 : searched]]
                comments.append("\n".join((*inner_lines, lines[searched].rstrip()[:-1])))
                next_index = searched + 1
                break
        yield Line(index + 1, tuple(words), tuple(comments))
        index = next_index


def _end_of_comment(lines: list[str], begin: int) -> tuple[int, bool]:
    """Return the index of the line that ends a comment or begins a section; True if it ends the comment."""
    for index in range(begin, len(lines)):
        if _SECTION.match(lines[index]):
            return index, False
        if lines[index].rstrip().endswith("%"):
            return index, True
    return len(lines), False
