"""A debugger's journal: snapshots of its program, and the inputs of the scans after each snapshot."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..state.memory import Memory
from ..state.snapshots import snapshot
from .forces import Forces
from .replay import NO_FORCES, Source
from .stretch import PlainInputs, ScanInputs

EVERY = 64
"""Number of scans per snapshot."""

MOST = 8_000
"""Maximum number of snapshots, enough for half a million scans."""


@dataclass(slots=True)
class Chapter:
    """A snapshot and the scans after it; `scan` is the number of the first scan."""

    scan: int
    memory: dict[str, Any]
    entries: list[ScanInputs]


class Journal(Source):
    """The inputs of the latest scans, with at most `most` snapshots; see `replay.Source`."""

    def __init__(self, most: int = MOST) -> None:
        self._chapters: deque[Chapter] = deque(maxlen=most)

    @property
    def first(self) -> int:
        """Number of the first remembered scan."""
        return self._chapters[0].scan

    @property
    def latest(self) -> int:
        """Number of the latest recorded scan."""
        last = self._chapters[-1]
        return last.scan + len(last.entries) - 1

    def begin(self, memory: Memory, scan: int) -> None:
        """Take a snapshot before a scan if one is due: before the first scan, then every `EVERY` scans."""
        if not self._chapters or len(self._chapters[-1].entries) == EVERY:
            self._chapters.append(Chapter(scan, snapshot(memory), []))

    def restart(self, memory: Memory, scan: int) -> None:
        """Forget all scans and take a snapshot, because some scans were not recorded."""
        self._chapters.clear()
        self.begin(memory, scan)

    def note(self, entry: ScanInputs) -> None:
        """Record the inputs of a scan that is about to run."""
        self._chapters[-1].entries.append(entry)

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the numbers of scans that begin a chapter, backwards from a scan."""
        return (chapter.scan for chapter in reversed(self._chapters) if chapter.scan <= scan)

    def snapshot(self, scan: int) -> tuple[dict[str, Any], Forces]:
        """Return the values before a scan that begins a chapter; the chapter's entries have the forces."""
        return self._chapters[self._chapter_index(scan)].memory, NO_FORCES

    def inputs(self, first: int, last: int) -> tuple[int, Iterator[ScanInputs]]:
        """Return the entries of scans, up to the latest one."""
        chapters, index = self._chapters, self._chapter_index(first)
        chosen = (chapters[number] for number in range(index, self._chapter_index(last) + 1))
        entries = chain.from_iterable(
            chapter.entries[max(0, first - chapter.scan) : last - chapter.scan + 1] for chapter in chosen
        )
        return min(last, self.latest) - first + 1, entries

    def _chapter_index(self, scan: int) -> int:
        """Return the index of the chapter that a scan belongs to."""
        return bisect_right(self._chapters, scan, key=lambda chapter: chapter.scan) - 1


class RecordedPast:
    """The scans of a recording, with its snapshots; see `replay.Source`.

    Args:
        snapshots: values by the number of the following scan, in any order; scan 0 is included.
        between: returns the inputs of a range of scans, first and last included.
        plain: returns the inputs as arrays, see `replay.Source`.
        latest: number of the last known scan.
    """

    def __init__(
        self,
        snapshots: Mapping[int, Mapping[str, Any]],
        between: Callable[[int, int], Iterator[ScanInputs]],
        plain: Callable[[int, int], PlainInputs | None],
        latest: int,
    ) -> None:
        self.plain = plain
        self._snapshots, self._between, self.latest = snapshots, between, latest
        self._scans = sorted(snapshots)

    def begin(self, memory: Memory, scan: int) -> None:
        """Do nothing: the recording already has its snapshots."""

    restart = begin

    def note(self, entry: ScanInputs) -> None:
        """Do nothing: the recording already has its scans."""

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the numbers of scans with a snapshot before them, backwards from a scan."""
        return reversed(self._scans[: bisect_right(self._scans, scan)])

    def snapshot(self, scan: int) -> tuple[Mapping[str, Any], Forces]:
        """Return the values before a scan with a snapshot."""
        return self._snapshots[scan], NO_FORCES

    def inputs(self, first: int, last: int) -> tuple[int, Iterator[ScanInputs]]:
        """Return the inputs of scans, up to the latest one."""
        last = min(last, self.latest)
        return last - first + 1, self._between(first, last)
