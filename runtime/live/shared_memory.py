"""Memory that two processes see: one makes it, the other opens it by its place.

    Linux      a file without a name, in memory only; its descriptor
    macOS      a temporary file without a name; its descriptor
    Windows    memory with a name; the name

The memory is released when the last process has closed it, or has ended.
"""

from __future__ import annotations

import mmap
import os
import secrets
import sys
import tempfile


class SharedMemory:
    """Memory that another process can open.

    Args:
        size: in bytes; a new memory is zero.
        place: place of the other process's memory; None = create memory.

    Attributes:
        map: the memory.
        place: a descriptor, which this one owns, or on Windows a name.
    """

    def __init__(self, size: int, place: int | str | None = None) -> None:
        self.size = size
        self.place = _new_place(size) if place is None else place
        if sys.platform == "win32":
            self.map = mmap.mmap(-1, size, tagname=str(self.place))
        else:
            self.map = mmap.mmap(int(self.place), size)

    def close(self) -> None:
        """Close it; `map` stays open as long as something uses it."""
        if isinstance(self.place, int):
            os.close(self.place)


def _new_place(size: int) -> int | str:
    if sys.platform == "win32":
        return f"scanrack-{secrets.token_hex(16)}"
    else:  # noqa: RET505 - a type checker reads one branch
        if hasattr(os, "memfd_create"):
            descriptor: int = os.memfd_create("scanrack")
        else:
            with tempfile.TemporaryFile() as memory_file:
                descriptor = os.dup(memory_file.fileno())
        os.ftruncate(descriptor, size)
        return descriptor
