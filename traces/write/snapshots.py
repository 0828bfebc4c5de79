"""Snapshots of a program's values in a recording. An explanation repeats the scans from a snapshot on.

    before scan   128        256        384   ...          text, a line each, compressed
    values        [0,1,...]  [0,1,...]  [0,1,...]

Snapshots are kept in memory and written as one attachment when the recording ends. A recording without an end
has no snapshots. A short recording has none either, since its scans can be repeated quickly.
"""

from __future__ import annotations

from collections.abc import Callable

import zstandard

from ..format.snapshots import SNAPSHOTS_BYTES

EVERY = 128
"""Initial number of scans per snapshot."""

WORTH_SCANS = 4096
"""Minimum number of scans in a recording that gets snapshots."""

_BYTES_PER_SCAN = 16
"""Maximum text per scan, bytes; larger snapshots are taken less often, which limits their cost."""


class SnapshotLog:
    """The snapshots of one recording.

    Args:
        take: returns the current values as a line of text; None if no more snapshots can be taken.

    Attributes:
        every: number of scans per snapshot; it doubles when the text becomes too long.
    """

    def __init__(self, take: Callable[[], str | None]) -> None:
        self.every = EVERY
        self._take: Callable[[], str | None] = take
        self._lines: dict[int, str] = {}  # snapshots by the number of the scan that follows
        self._bytes = 0  # of these lines
        self._ended = False

    def scan(self, scan: int) -> None:
        """Take a snapshot after a scan; while the snapshots are too long, drop every second one.

        If the program can't take a snapshot, all earlier snapshots are dropped.

        Args:
            scan: number of the scan; the number of the next one must be a multiple of `every`.
        """
        text = None if self._ended else self._take()
        if text is None:
            self._lines, self._ended = {}, True
            return
        self._lines[scan + 1] = text
        self._bytes += len(text)
        while len(text) > _BYTES_PER_SCAN * self.every or self._bytes > SNAPSHOTS_BYTES:
            self.every *= 2
            self._lines = {number: line for number, line in self._lines.items() if not number % self.every}
            self._bytes = sum(map(len, self._lines.values()))

    def packed(self) -> bytes | None:
        """Return the data of the attachment; None if the recording gets no snapshots."""
        if max(self._lines, default=0) < WORTH_SCANS:
            return None
        text = "\n".join(f"{number} {line}" for number, line in self._lines.items())
        data: bytes = zstandard.ZstdCompressor(level=1).compress(text.encode())
        return data
