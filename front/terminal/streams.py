"""Standard input and output that may be closed, full, or a pipe whose reader has gone.

Commands write as if writing always worked. On a failure `LostOutput` ends the command, past
every handler of errors of other files; after that, writing has no effect, so that no further message
appears when the interpreter ends.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Any

from ..runtime.loop.faults import Ending
from .status import CANNOT_WRITE, PIPE_CLOSED

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class LostOutput(Ending):
    """Standard output can't be written.

    It is no Exception, so that no command takes it for an error of one of its files.
    """

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.error = error

    @property
    def status(self) -> int:
        """The exit status."""
        return PIPE_CLOSED if isinstance(self.error, BrokenPipeError) else CANNOT_WRITE


class _GuardedFile(io.FileIO):
    """A file descriptor that fails once, and accepts everything from then on."""

    def __init__(self, fd: int, *, told: bool) -> None:
        super().__init__(fd, "w", closefd=False)
        self._told = told
        self._lost = False

    def write(self, data: ReadableBuffer, /) -> int:
        if not self._lost:
            try:
                return super().write(data)
            except OSError as error:
                self._lost = True
                if self._told:
                    raise LostOutput(error) from error
        return memoryview(data).nbytes


def closed_streams_plugged() -> None:
    """Keep the numbers of closed standard streams from files that are opened later.

    A socket with number 0 would be closed with standard input. Writing to the plug of an output fails.
    """
    while (fd := os.open(os.devnull, os.O_RDONLY)) < 3:
        pass
    os.close(fd)


@contextmanager
def guarded_output() -> Iterator[None]:
    """End the block with `LostOutput` if standard output can't be written.

    Failed writes to standard error are dropped. Terminals, closed streams and streams of other owners
    are left unchanged.
    """
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (
        _guarded(sys.stdout or _closed(1), told=True),
        _guarded(sys.stderr or _closed(2), told=False),
    )
    try:
        yield
    finally:
        ours = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = before
        for stream in ours:
            if stream is not None:
                stream.flush()


def _closed(number: int) -> IO[str]:
    return open(number, "w", encoding="utf-8", closefd=False)


def _guarded(stream: Any, *, told: bool) -> Any:
    fd = _descriptor(stream)
    if fd is None or os.isatty(fd):
        return stream
    stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_GuardedFile(fd, told=told)),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
    )


def _descriptor(stream: IO[str] | None) -> int | None:
    """Return the descriptor of a stream, or None."""
    try:
        return None if stream is None else stream.fileno()
    except (OSError, ValueError):
        return None
