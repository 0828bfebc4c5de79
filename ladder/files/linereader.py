"""Lines of a program file without their comments, and errors that name file, line and column."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NoReturn

from scanrack.io_images.site import Site

from ..model.errors import RungTextError
from ..model.spec import Spec
from ..model.tree import Block
from ..st import parse_statements

_CODE = re.compile(r"""(?:'(?:[^'$]++|\$.)*+'|"(?:[^"\\]++|\\.)*+"|(?!//).)*+""")
"""A line without its comment."""


def cut_comment(line: str) -> str:
    """Return the part of a line before a `//` that is not in quotes."""
    code = _CODE.match(line)
    assert code is not None, "it may match nothing"
    return code.group()


def without_comment(line: str) -> str:
    """Return a line without its comment and the space around it."""
    return cut_comment(line).strip()


class LineReader:
    """Reads lines from the index `start` up to `end`; `specs` are the known instructions."""

    end_shown = "the end of the file"
    """Name of the end of the lines in messages."""

    def __init__(self, lines: list[str], start: int, end: int, file: str, specs: Mapping[str, Spec]) -> None:
        self._lines, self._line_index, self._end, self._file, self._specs = lines, start, end, file, specs

    def _peek(self) -> str | None:
        """Return the next line with content, without its comment; None at the end."""
        while self._line_index < self._end:
            line = without_comment(self._lines[self._line_index])
            if line:
                return line
            self._line_index += 1
        return None

    def _fail(self, expected: str, actual: str = "") -> NoReturn:
        """Raise a RungTextError at the next line; `actual` defaults to the text of that line."""
        text = self._lines[self._line_index] if self._line_index < self._end else ""
        column = len(text) - len(text.lstrip()) + 1
        shown = repr(text.strip()) if text.strip() else self.end_shown
        site = Site(file=self._file, line=self._line_index + 1, column=column)
        raise RungTextError(expected, actual or shown, site)

    def _statements(self, start: int, end: int) -> Block:
        """Read the lines from `start` up to `end` as structured text."""
        text = "\n".join(self._lines[start:end])
        return parse_statements(text, file=self._file, line=start + 1, specs=self._specs)
