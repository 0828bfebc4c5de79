"""Memory that two processes share: one creates it, and the other opens it by its handle.

    Linux      an unnamed file in memory; the handle is its descriptor
    macOS      an unnamed temporary file; the handle is its descriptor
    Windows    named memory; the handle is its name

The memory is released when the last process has closed it or has ended.
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
        size: number of bytes; new memory is filled with zeros.
        handle: handle of memory that the other process created; None = create memory.

    Attributes:
        map: the memory.
        handle: a descriptor, which this object closes, or a name on Windows.
    """

    def __init__(self, size: int, handle: int | str | None = None) -> None:
        self.size = size
        self.handle = _new_handle(size) if handle is None else handle
        if sys.platform == "win32":
            self.map = mmap.mmap(-1, size, tagname=str(self.handle))
        else:
            self.map = mmap.mmap(int(self.handle), size)

    def close(self) -> None:
        """Close the handle; `map` stays open as long as something uses it."""
        if isinstance(self.handle, int):
            os.close(self.handle)


def _new_handle(size: int) -> int | str:
    """Return the handle of new memory: a name on Windows, else the descriptor of an unnamed file."""
    if sys.platform == "win32":
        return f"scanrack-{secrets.token_hex(16)}"
    else:  # noqa: RET505 - a type checker reads only the branch of its platform
        if hasattr(os, "memfd_create"):
            descriptor: int = os.memfd_create("scanrack")
        else:
            with tempfile.TemporaryFile() as memory_file:
                descriptor = os.dup(memory_file.fileno())
        os.ftruncate(descriptor, size)
        return descriptor
