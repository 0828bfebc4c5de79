"""Opens files that a user names; refuses irregular and oversized files.

Opening a FIFO would block, and `/dev/zero` has no end. Rack files and programs are read twice, which is not
possible with a FIFO, so process substitution, `<(...)`, is refused. A link to a file with another suffix is
refused, because messages quote unexpected text, which may be secret: `notes.rung -> /etc/shadow`.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from os.path import realpath
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

from .text_limits import LIMITS, TextKind, check_text

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def open_input(path: Path) -> BinaryIO:
    """Open a regular file for reading; raise an OSError with the reason in `strerror`."""
    if path.suffix and Path(realpath(path)).suffix.lower() != path.suffix.lower():
        raise OSError(errno.EINVAL, f"it is a link to a file that is not {path.suffix}", str(path))
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        kind = stat.S_IFMT(os.fstat(descriptor).st_mode)
        if kind in _KINDS:
            raise OSError(errno.EINVAL, f"it is {_KINDS[kind]}, not a file", str(path))
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


_UNSAVED: ContextVar[Mapping[str, bytes]] = ContextVar("_UNSAVED", default=MappingProxyType({}))


@contextmanager
def unsaved(texts: Mapping[Path, str]) -> Iterator[None]:
    """Make `read_input` return an editor's unsaved texts instead of the files at those paths."""
    token = _UNSAVED.set({realpath(path): text.encode() for path, text in texts.items()})
    try:
        yield
    finally:
        _UNSAVED.reset(token)


def read_input(path: Path, most: int) -> bytes:
    """Read a regular file of at most `most` bytes; raise an OSError with the reason in `strerror`."""
    data = _UNSAVED.get().get(realpath(path)) if _UNSAVED.get() else None
    if data is None:
        with open_input(path) as file:
            data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it has more than {most:,} bytes", str(path))
    return data


def read_input_text(path: Path, kind: TextKind) -> str:
    """Read a UTF-8 file within the size limit of its kind; raise OSError or UnicodeDecodeError."""
    return read_input(path, LIMITS[kind].size).decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")


def read_checked(path: Path, kind: TextKind) -> str:
    """Read a UTF-8 file like `read_input_text`; raise a TextLimitError if it exceeds its limits."""
    text = read_input_text(path, kind)
    check_text(text, kind)
    return text
