"""The journal of a run: a program's external inputs, so that any scan can be run again.

A program is deterministic: its memory, the input images and the time make the next memory. So it runs
compiled, and a query about a scan runs that scan again, watched, on a memory of its own:

    snapshot      entry  entry  entry ...      snapshot      entry ...
    scan 512      512    513    514            scan 768      768
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from ..compiler import ObservedScanner, Scanner
from ..compiler.observed import Observation
from ..model.errors import LadderFault
from ..model.tags import Leaf
from ..state.lowered import LoweredProgram
from ..state.memory import Memory, Value
from .forces import Forces
from .watching import WatchedEngine

EVERY = 64
"""Scans per snapshot."""

MOST = 8_000
"""Maximum snapshots, the latest ones: half a million scans."""

NO_FORCES: Forces = {}
"""No forces."""

Write = tuple[Leaf, int, Value]
"""A value set from outside of the program."""


@dataclass(frozen=True, slots=True)
class Entry:
    """The inputs of a scan.

    Attributes:
        now_ns: its virtual time.
        first: whether it began with prescan.
        images: the input images in use, in the layout's order.
        writes: values set from outside since the previous scan.
        forces: the forces.
    """

    now_ns: int
    first: bool
    images: tuple[bytes, ...]
    writes: tuple[Write, ...]
    forces: Forces


@dataclass(slots=True)
class Chapter:
    """A snapshot by identifier, the number of the scan after it, and the scans from there."""

    scan: int
    memory: dict[str, Any]
    entries: list[Entry]


class Journal:
    """The inputs of the latest scans.

    Args:
        scanner: the compiled program.
        variants: compiled variants for observers, see `WatchedEngine`.
        most: maximum snapshots.
    """

    def __init__(
        self,
        lowered: LoweredProgram,
        scanner: Scanner,
        variants: dict[Observation, ObservedScanner],
        most: int = MOST,
    ) -> None:
        self._lowered, self._scanner, self._variants = lowered, scanner, variants
        self._chapters: deque[Chapter] = deque(maxlen=most)
        self._images = [leaf for leaf in lowered.layout.images if not leaf.output]
        self._again: WatchedEngine | None = None

    @property
    def scans(self) -> range:
        """Numbers of the remembered scans."""
        if not self._chapters:
            return range(0)
        last = self._chapters[-1]
        return range(self._chapters[0].scan, last.scan + len(last.entries))

    def begin(self, memory: Memory, scan: int) -> None:
        """Take a snapshot before scan number `scan` if one is due: at the start, and every `EVERY` scans."""
        if not self._chapters or len(self._chapters[-1].entries) == EVERY:
            self._chapters.append(Chapter(scan, snapshot(memory), []))

    def begin_anew(self, memory: Memory, scan: int) -> None:
        """Drop all scans and take a snapshot: earlier scans have not been noted."""
        self._chapters.clear()
        self.begin(memory, scan)

    def note(self, entry: Entry) -> None:
        """Append the inputs of the next scan."""
        self._chapters[-1].entries.append(entry)

    def entry(
        self,
        memory: Memory,
        now_ns: int,
        *,
        first: bool,
        writes: tuple[Write, ...],
        forces: Forces,
    ) -> Entry:
        """Return the inputs of the next scan: images from `memory`, external writes and forces."""
        images = tuple(bytes(memory.cells[leaf.ident].cell_contents) for leaf in self._images)
        return Entry(now_ns, first, images, writes, forces)

    def again(self, scan: int, *, noted: bool = False) -> WatchedEngine:
        """Run again up to a scan, watch that one, and return the engine after it.

        Args:
            noted: only note its power in the compiled program, which is faster; a scan with a fault is
                watched anyway.

        Raises:
            ValueError: the scan is not remembered.
        """
        if scan not in self.scans:
            raise ValueError(
                f"scan {scan} is not remembered: {self.scans.start} to {self.scans.stop - 1} are"
            )
        chapter = next(each for each in reversed(self._chapters) if each.scan <= scan)
        engine = self._engine(chapter)
        *before, wanted = chapter.entries[: scan - chapter.scan + 1]
        for entry in before:
            self._do(engine, entry, watched=False)
        if noted:
            engine.note_all()
        self._do(engine, wanted, watched=not noted)
        return self.again(scan) if noted and engine.broken_off else engine

    def last_change(self, read: Callable[[WatchedEngine], Any]) -> int | None:
        """Return the last scan that changed the value that `read` returns, or None."""
        for chapter in reversed(self._chapters):
            found = None
            for scan, before, after in self._values(chapter, read):
                if before != after:
                    found = scan
            if found is not None:
                return found
        return None

    def _values(
        self, chapter: Chapter, read: Callable[[WatchedEngine], Any]
    ) -> Iterator[tuple[int, Any, Any]]:
        engine = self._engine(chapter)
        value = read(engine)
        for entry in chapter.entries:
            scan = engine.scans
            self._do(engine, entry, watched=False)
            before, value = value, read(engine)
            yield scan, before, value

    def _engine(self, chapter: Chapter) -> WatchedEngine:
        if self._again is None:
            self._again = WatchedEngine(self._lowered, self._scanner)
            self._again.variants = self._variants
        self._again.hold(NO_FORCES)
        self._again.note(())
        restore(self._again.memory, chapter.memory)
        self._again.scans = chapter.scan
        return self._again

    def _do(self, engine: WatchedEngine, entry: Entry, *, watched: bool) -> None:
        memory = engine.memory
        for leaf, image in zip(self._images, entry.images, strict=True):
            memory.cells[leaf.ident].cell_contents.cast("B")[:] = image
        engine.watching = watched
        engine.hold(entry.forces)
        engine.outside = entry.writes
        with suppress(LadderFault):  # it has stopped that scan then, too
            engine.do(entry.now_ns, first=entry.first)


def snapshot(memory: Memory) -> dict[str, Any]:
    """Return all values of a memory by identifier."""
    images = {leaf.ident for leaf in memory.layout.images}
    found: dict[str, Any] = {}
    for ident, cell in memory.cells.items():
        value = cell.cell_contents
        if ident in images:
            value = value.tolist()
        found[ident] = list(value) if isinstance(value, list) else value
    return found


def restore(memory: Memory, values: dict[str, Any]) -> None:
    """Set all values of a memory from a snapshot."""
    for ident, cell in memory.cells.items():
        value = values[ident]
        if not isinstance(value, list):
            cell.cell_contents = value
            continue
        if isinstance(cell.cell_contents, list):
            cell.cell_contents[:] = value
            continue
        for index, word in enumerate(value):
            cell.cell_contents[index] = word
