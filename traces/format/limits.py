"""Limits for reading an untrusted trace: the size of an unpacked chunk, and the number of records."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from scanrack.io_images.dataclass import dataclass

SMALLEST_MESSAGE_BYTES = 31
"""Opcode, length, and the fields of a message without data."""

CHUNK_BYTES = 32 * 1024 * 1024
RECORDS = 200_000


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits for one trace.

    Attributes:
        chunk_bytes: maximum bytes of an unpacked chunk. scanrack's chunks are 1 MiB, and chunks of other
            writers are 4 MiB.
        records: maximum number of records in a chunk, or outside of the chunks in a file. More are allowed if
            their average size is at least the size of an empty message.
    """

    chunk_bytes: int = CHUNK_BYTES
    records: int = RECORDS

    def too_many(self, count: int, size: int) -> bool:
        """Return whether `count` records in `size` bytes exceed the limits.

        >>> Limits(records=10).too_many(10, 90), Limits(records=10).too_many(11, 99)
        (False, True)
        >>> Limits(records=10).too_many(11, 11 * 31)
        False
        """
        return count > self.records and count * SMALLEST_MESSAGE_BYTES > size


_limits: ContextVar[Limits] = ContextVar("limits", default=Limits())  # noqa: B039 - it is frozen


def limits() -> Limits:
    """Return the current limits."""
    return _limits.get()


def set_limits(new_limits: Limits) -> None:
    """Set the limits of this process permanently; call this when the process starts."""
    _limits.set(new_limits)


@contextmanager
def limited(new_limits: Limits) -> Iterator[None]:
    """Use other limits in a `with` block."""
    token = _limits.set(new_limits)
    try:
        yield
    finally:
        _limits.reset(token)
