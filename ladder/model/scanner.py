"""A text with a read position, for messages."""

from __future__ import annotations

import re
from typing import NoReturn

from scanrack.io_images.site import Site

from .errors import RungTextError

_SPACE = re.compile(r"\s*")


class Scanner:
    """Reads a text from left to right from position `at`; `line` and `rung` are numbers for messages."""

    def __init__(self, text: str, *, file: str, line: int, rung: int | None) -> None:
        self.text, self.at = text.rstrip(), 0
        self._file, self._line, self._rung = file, line, rung
        self._skip_space()

    def ended(self) -> bool:
        """Whether everything has been read."""
        return self.at == len(self.text)

    def skip(self, mark: str) -> bool:
        """Move past `mark` and white space, if present."""
        if not self.text.startswith(mark, self.at):
            return False
        self._move_to(self.at + len(mark))
        return True

    def fail(self, expected: str, found: str | None = None) -> NoReturn:
        """Raise a RungTextError at the current position."""
        text_read = self.text[: self.at]
        line = self._line + text_read.count("\n")
        column = self.at - (text_read.rfind("\n") + 1) + 1
        if found is None:
            next_word = re.match(r"\w+|.", self.text[self.at :])
            found = next_word.group() if next_word else "the end of the text"
        site = Site(file=self._file, line=line, column=column, rung=self._rung)
        raise RungTextError(expected, found, site)

    def _match(self, pattern: re.Pattern[str]) -> str | None:
        """Move past a match and the white space after it; return the match, or None without moving."""
        match = pattern.match(self.text, self.at)
        if match is None:
            return None
        self._move_to(match.end())
        return match.group()

    def _move_to(self, at: int) -> None:
        match = _SPACE.match(self.text, at)
        self.at = match.end() if match else at

    def _skip_space(self) -> None:
        self._move_to(self.at)
