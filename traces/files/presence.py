"""Whether a file that is being written is still there, under its name and with what was written.

Nothing tells a writer that another program has removed, replaced or cut its file: its writes succeed, and
there is nothing to read afterwards.
"""

from __future__ import annotations

import os
from pathlib import Path

HEAD_BYTES = 1 << 16
"""Bytes at the beginning that are compared at the end."""


class Presence:
    """Watches over a file.

    Args:
        path: its name.
        number: its descriptor.
    """

    def __init__(self, path: Path, number: int) -> None:
        self._path, self._number = path.absolute(), number
        self._head = bytearray()
        self._is_cut = False

    def add(self, data: bytes) -> None:
        """Take note of the bytes that come next."""
        if len(self._head) < HEAD_BYTES:
            self._head += data[: HEAD_BYTES - len(self._head)]

    def look(self, size: int) -> None:
        """Note whether the file has become shorter than what was written."""
        if os.fstat(self._number).st_size < size:
            self._is_cut = True

    def loss(self, size: int) -> str | None:
        """Return what has become of the file, which should have `size` bytes; None if all is well."""
        self.look(size)
        mine = os.fstat(self._number)
        try:
            there = os.stat(self._path)
        except OSError:
            return "it was removed or renamed by another program while it was being recorded"
        if (there.st_dev, there.st_ino) != (mine.st_dev, mine.st_ino):
            return "it was replaced by another program while it was being recorded"
        if self._is_cut or mine.st_size != size or self._begins_otherwise():
            return "it was cut or overwritten by another program while it was being recorded"
        return None

    def _begins_otherwise(self) -> bool:
        try:
            with self._path.open("rb") as file:
                return file.read(len(self._head)) != self._head
        except OSError:  # a file that its writer may not read
            return False
