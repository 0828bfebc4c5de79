"""Finds the line of every key path in a TOML text.

`tomllib` returns the contents of a file without line numbers. After `tomllib` has accepted the text, this
scanner reads it again and stores the line of every table, key and array element. The scanner skips the
values.

    line 1   [[slot]]                     ("slot", 0)
    line 2   number = 1                   ("slot", 0, "number")
    line 3   machine.switches = [         ("slot", 0, "machine", "switches")
    line 4     {input = "home"},          ("slot", 0, "machine", "switches", 0, "input")
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cached_property

from scanrack.io_images.doors import toml_tables

KeyPath = tuple[str | int, ...]
"""Keys and array indexes from the top of a document."""

_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*+")
_BLANK = re.compile(r"[ \t]*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""(?!")))*+"""'
    r"|'''.*?'''(?!')'?'?"
    r'|"(?:[^"\\\n]++|\\.)*+"'
    r"|'[^'\n]*'",
    re.DOTALL,
)
_SCALAR = re.compile(r"[^,\]}#\n]+")


class KeyLines:
    r"""The lines of a TOML text by key path.

    >>> lines = KeyLines("name = 'x'\n[[slot]]\nnumber = 1\n")
    >>> lines.line(("slot", 0, "number")), lines.line(("slot", 0, "firmware"))
    (3, 2)
    """

    def __init__(self, text: str) -> None:
        self._text = text
        self._index = 0  # of the next character to read
        self._line_index, self._line = 0, 1  # an index in the text, and its line
        self._lines: dict[KeyPath, int] = {}
        self._table_counts: dict[KeyPath, int] = {}  # tables read so far of each array of tables

    @cached_property
    def paths(self) -> Mapping[KeyPath, int]:
        """Every key path with its line, from 1. The text is scanned on first use."""
        self._read_document()
        return self._lines

    def line(self, path: KeyPath) -> int:
        """Return the line of a key path, else of the innermost table that contains it, else 1."""
        while path and path not in self.paths:
            path = path[:-1]
        return self.paths.get(path, 1)

    # the document: headers and assignments

    def _read_document(self) -> None:
        """Read the text; store the line of each table, key and array element."""
        table: KeyPath = ()
        self._skip(_SPACE)
        while self._index < len(self._text):
            if self._text[self._index] == "[":
                table = self._read_header()
            else:
                self._read_assignment(table)
            self._skip(_SPACE)

    def _read_header(self) -> KeyPath:
        """Read `[table]` or `[[table]]`, and store its line; return the table's path, with its index."""
        line, repeated = self._line_here(), self._text.startswith("[[", self._index)
        bracket_count = 2 if repeated else 1
        self._index += bracket_count
        keys = self._read_key()
        self._index += bracket_count
        path: KeyPath = ()
        for key in keys[:-1]:
            path = self._last_element((*path, key))
            self._lines.setdefault(path, line)
        path = (*path, keys[-1])
        self._lines.setdefault(path, line)
        if repeated:
            self._table_counts[path] = self._table_counts.get(path, 0) + 1
            path = self._last_element(path)
            self._lines[path] = line
        return path

    def _last_element(self, path: KeyPath) -> KeyPath:
        """Return the path of the last table in an array of tables; for any other table, its own path."""
        count = self._table_counts.get(path, 0)
        return (*path, count - 1) if count else path

    def _read_assignment(self, table: KeyPath) -> None:
        """Read `key = value` in a table; store the line of the key, and the lines of keys in the value."""
        line = self._line_here()
        path = table
        for key in self._read_key():
            path = (*path, key)
            self._lines.setdefault(path, line)
        self._index += 1  # the equals sign
        self._skip(_BLANK)
        self._read_value(path)

    def _read_key(self) -> list[str]:
        """Read a dotted key and the blanks after it; return its parts."""
        keys = []
        while True:
            self._skip(_BLANK)
            keys.append(self._read_key_part())
            self._skip(_BLANK)
            if self._text[self._index] != ".":
                return keys
            self._index += 1

    def _read_key_part(self) -> str:
        if self._text[self._index] in "\"'":
            quoted = self._take(_STRING)
            return next(iter(toml_tables(f"{quoted} = 0")))
        return self._take(_BARE_KEY)

    # values are skipped, except the elements of arrays and the keys of inline tables

    def _read_value(self, path: KeyPath) -> None:
        """Skip a value; store the lines of the elements and keys in it."""
        first_character = self._text[self._index]
        if first_character == "[":
            self._read_array(path)
        elif first_character == "{":
            self._read_inline_table(path)
        else:
            self._take(_STRING if first_character in "\"'" else _SCALAR)

    def _read_array(self, path: KeyPath) -> None:
        """Skip an array; store the line of each element."""
        index = 0
        while not self._skip_to_end("]"):
            self._lines[(*path, index)] = self._line_here()
            self._read_value((*path, index))
            index += 1

    def _read_inline_table(self, path: KeyPath) -> None:
        while not self._skip_to_end("}"):
            self._read_assignment(path)

    def _skip_to_end(self, bracket: str) -> bool:
        """Skip the opening bracket or a comma; skip a closing bracket and return whether there was one."""
        self._skip(_SPACE)
        if self._text[self._index] != bracket:
            self._index += 1
            self._skip(_SPACE)
        if self._text[self._index] != bracket:
            return False
        self._index += 1
        return True

    def _skip(self, pattern: re.Pattern[str]) -> None:
        """Skip the text that matches a pattern, if any."""
        match = pattern.match(self._text, self._index)
        self._index = match.end() if match else self._index

    def _take(self, pattern: re.Pattern[str]) -> str:
        """Read the text that matches a pattern, and return it; raise a ValueError if it is empty."""
        match = pattern.match(self._text, self._index)
        if match is None or not match[0]:
            raise ValueError(f"line {self._line_here()}: this is not TOML")
        self._index = match.end()
        return match[0]

    def _line_here(self) -> int:
        """Return the line of the next character, counting on from the last call."""
        self._line += self._text.count("\n", self._line_index, self._index)
        self._line_index = self._index
        return self._line
