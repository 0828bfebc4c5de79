"""Handles standard streams that are closed or full, or a pipe without a reader.

Commands write without checks. If a write fails, `LostOutput` ends the command; no handler for errors of other
files catches it. Later writes have no effect, so that no further message appears when the interpreter ends.
Writes to a closed terminal are dropped, and its SIGHUP ends the command.

Files and pipes get UTF-8 with line feeds, the same bytes on every system, unless PYTHONIOENCODING chooses an
encoding. A terminal gets the characters that it can show, and ? for all others.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Any

from scanrack.runtime.loop.faults import Ending

from .status import CANNOT_WRITE, PIPE_CLOSED

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class LostOutput(Ending):
    """Standard output can't be written.

    It is not an Exception, so that no command handles it as an error of one of its files.
    """

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.error = error

    @property
    def status(self) -> int:
        """The exit status."""
        return PIPE_CLOSED if isinstance(self.error, BrokenPipeError) else CANNOT_WRITE


class _GuardedFile(io.FileIO):
    """A file descriptor that fails once, and then drops all writes."""

    def __init__(self, fd: int, *, reported: bool) -> None:
        super().__init__(fd, "w", closefd=False)
        self._reported = reported
        self._lost = False

    def write(self, data: ReadableBuffer, /) -> int:
        """Write data; after a failed write, drop all data and report success.

        The first failure raises `LostOutput` if it is to be reported.
        """
        if not self._lost:
            try:
                return super().write(data)
            except OSError as error:
                self._lost = True
                if self._reported:
                    raise LostOutput(error) from error
        return memoryview(data).nbytes


def closed_streams_plugged() -> None:
    """Occupy the numbers of closed standard streams, so that files opened later do not get them.

    A socket with number 0 would be closed with standard input. Writing to such a number fails.
    """
    while (fd := os.open(os.devnull, os.O_RDONLY)) < 3:
        pass
    os.close(fd)


@contextmanager
def guarded_output() -> Iterator[None]:
    """End the block with `LostOutput` if standard output can't be written.

    Failed writes to standard error and to a terminal are dropped. Standard input also uses UTF-8. Streams
    without a file descriptor and the console of Windows are left unchanged.
    """
    original_streams = sys.stdout, sys.stderr
    if isinstance(sys.stdin, io.TextIOWrapper) and _has_our_encoding(sys.stdin):
        sys.stdin.reconfigure(encoding="utf-8")
    sys.stdout, sys.stderr = (
        _guarded(sys.stdout or _closed(1), reported=True),
        _guarded(sys.stderr or _closed(2), reported=False),
    )
    try:
        yield
    finally:
        streams = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = original_streams
        for stream in streams:
            if stream is not None:
                stream.flush()


def _closed(number: int) -> IO[str]:
    return open(number, "w", encoding="utf-8", newline="\n", closefd=False)


def _guarded(stream: Any, *, reported: bool) -> Any:
    """Return a stream to the same file that survives failed writes, with scanrack's encoding.

    Streams without a descriptor and the console of Windows are returned unchanged.
    """
    fd = _descriptor(stream)
    is_terminal = fd is not None and os.isatty(fd)
    is_windows_console = is_terminal and sys.platform == "win32"
    if fd is None or is_windows_console:
        return stream
    stream.flush()
    is_own = _has_our_encoding(stream)
    return io.TextIOWrapper(
        io.BufferedWriter(_GuardedFile(fd, reported=reported and not is_terminal)),
        encoding="utf-8" if is_own else stream.encoding,
        errors="replace" if stream.errors == "strict" else stream.errors,
        newline="\n" if is_own else None,
        line_buffering=stream.line_buffering,
    )


def _has_our_encoding(stream: IO[str]) -> bool:
    """Return whether scanrack, and not a terminal or the user, chooses the encoding."""
    return not stream.isatty() and "PYTHONIOENCODING" not in os.environ


def _descriptor(stream: IO[str] | None) -> int | None:
    """Return the descriptor of a stream, or None."""
    try:
        return None if stream is None else stream.fileno()
    except (OSError, ValueError):
        return None
