"""Snapshots of a program's values in a recording: a question about it begins at one, not at the first scan.

    before scan   128        256        384   ...          text, a line each, compressed
    values        [0,1,...]  [0,1,...]  [0,1,...]

They are kept in memory and written as one attachment when the recording ends: a recording without an end
has none, nor has a short one, whose scans are soon repeated.
"""

from __future__ import annotations

from collections.abc import Callable

import zstandard

from ..format.snapshots import SNAPSHOTS_BYTES

EVERY = 128
"""Scans per snapshot, at first."""

WORTH_SCANS = 4096
"""A shorter recording has no snapshots."""

_BYTES_PER_SCAN = 16
"""Maximum text per scan: the larger the values, the rarer their snapshots, which bounds what they cost."""


class SnapshotLog:
    """The snapshots of one recording.

    Args:
        take: returns the present values as a line of text; None if they can no longer be snapshots.
    """

    def __init__(self, take: Callable[[], str | None]) -> None:
        self.every = EVERY
        self._take: Callable[[], str | None] = take
        self._lines: dict[int, str] = {}
        self._bytes = 0
        self._over = False

    def scan(self, scan: int) -> None:
        """Take a snapshot after a scan whose successor's number is a multiple of `every`."""
        text = None if self._over else self._take()
        if text is None:
            self._lines, self._over = {}, True
            return
        self._lines[scan + 1] = text
        self._bytes += len(text)
        while len(text) > _BYTES_PER_SCAN * self.every or self._bytes > SNAPSHOTS_BYTES:
            self.every *= 2
            self._lines = {at: line for at, line in self._lines.items() if not at % self.every}
            self._bytes = sum(map(len, self._lines.values()))

    def packed(self) -> bytes | None:
        """Return the data of the attachment; None if it has none."""
        if max(self._lines, default=0) < WORTH_SCANS:
            return None
        text = "\n".join(f"{at} {line}" for at, line in self._lines.items())
        data: bytes = zstandard.ZstdCompressor(level=1).compress(text.encode())
        return data
