"""Checks that a file being written still exists under its name, with the written content.

Without this check, a writer does not notice that another program has removed, replaced or truncated its file:
all writes succeed, but the data is lost.
"""

from __future__ import annotations

import os
from pathlib import Path

HEAD_BYTES = 1 << 16
"""Number of bytes at the beginning of the file to compare when it is closed."""


class Presence:
    """Detects changes that another program makes to a file while it is written.

    Args:
        path: path of the file.
        number: descriptor of the file.
    """

    def __init__(self, path: Path, number: int) -> None:
        self._path, self._number = path.absolute(), number
        self._head = bytearray()
        self._is_cut = False

    def add(self, data: bytes) -> None:
        """Remember the next written bytes if they belong to the beginning of the file."""
        if len(self._head) < HEAD_BYTES:
            self._head += data[: HEAD_BYTES - len(self._head)]

    def check_size(self, size: int) -> None:
        """Note that the file was truncated if it is shorter than the `size` bytes written."""
        if os.fstat(self._number).st_size < size:
            self._is_cut = True

    def loss(self, size: int) -> str | None:
        """Describe the damage to the file, which should have `size` bytes; return None if it is intact."""
        self.check_size(size)
        own_status = os.fstat(self._number)
        try:
            path_status = os.stat(self._path)
        except OSError:
            return "it was removed or renamed by another program while it was being recorded"
        if (path_status.st_dev, path_status.st_ino) != (own_status.st_dev, own_status.st_ino):
            return "it was replaced by another program while it was being recorded"
        if self._is_cut or own_status.st_size != size or self._has_other_head():
            return "it was cut or overwritten by another program while it was being recorded"
        return None

    def _has_other_head(self) -> bool:
        """Return whether the file's first bytes differ from the bytes that were written."""
        try:
            with self._path.open("rb") as file:
                return file.read(len(self._head)) != self._head
        except OSError:  # the writer may not read the file
            return False
