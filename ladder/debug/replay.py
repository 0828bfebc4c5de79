"""Repeats scans of a program in separate memory.

A program is deterministic: its memory, the input images and the time determine the next state of its memory.
The program therefore normally runs compiled. To explain a scan, the program repeats it from an earlier
snapshot:

    snapshot      inputs inputs inputs ...      snapshot      inputs ...
    scan 512      512    513    514             scan 576      576

Snapshots and inputs come from a `Source`: the journal of a debugger, or the rows of a session.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import chain, islice, pairwise
from typing import Any, Protocol

from ..compiler.observed import LineKey
from ..model.errors import LadderFault
from ..model.tags import Leaf
from ..state.memory import Memory, Value, same
from ..state.snapshots import restore
from .cells import Cell, place_in_snapshot
from .forces import Forces
from .stretch import PlainInputs, ReplayStretch, ScanInputs
from .watching import WatchedEngine

NO_FORCES: Forces = {}

Truths = Mapping[LineKey, tuple[bool, ...]]
"""Power after each instruction, by uppercase routine name and rung number."""


ONE_BY_ONE = 24
"""Maximum number of stretches with equal values at both ends that are searched one by one."""

FIRST_ONE_BY_ONE = 4
"""If there are more than `ONE_BY_ONE`, this many of the latest run one by one, the others in parallel."""

MOST_LAST_CHANGES = 256
"""Maximum number of search results that are kept."""

SIDE_BY_SIDE = 5_000
"""Maximum number of stretches in one parallel search."""


class Source(Protocol):
    """A store of snapshots and inputs of a program."""

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the numbers of scans with a snapshot before them, backwards from a scan."""

    def snapshot(self, scan: int) -> tuple[Mapping[str, Any], Forces]:
        """Return the values before a scan, by identifier, and the forces."""

    def inputs(self, first: int, last: int) -> tuple[int, Iterator[ScanInputs]]:
        """Return the number of contiguous known scans that begin with `first`, and their inputs."""

    def plain(self, first: int, last: int) -> PlainInputs | None:
        """Return the inputs of scans as arrays; None if they are not plain or are unknown."""
        count, recorded = self.inputs(first, last)
        return plain_inputs(list(recorded)) if count == last - first + 1 else None


class Replayer:
    """Repeats scans.

    Args:
        engine: runs the program; nothing else uses its memory.
        source: the program's snapshots and inputs.
        most: maximum number of scans to run to reach a scan.
        stretches: number of latest snapshots from which changes are searched; None for all.
    """

    def __init__(
        self, engine: WatchedEngine, source: Source, most: int = 1 << 62, stretches: int | None = None
    ) -> None:
        self.engine = engine  # the engine after scan `at`
        self.at: int | None = None  # the scan that was run last; None before the first run
        self._last_changes: dict[tuple[Cell, ...], tuple[int, int | None]] = {}  # searched scan, last change
        self.truths: Truths = {}  # the power in the scan that was shown last
        self.source, self._most, self._stretches = source, most, stretches
        self.images = input_leaves(engine.memory)  # the leaves of `ScanInputs.images`
        self._images = image_bytes(engine.memory)

    def show(self, scan: int) -> bool:
        """Run to a scan and note its power; return whether the scan could be repeated."""
        return self._run_to(scan, watched=False)

    def again(self, scan: int, *, noted: bool = False) -> WatchedEngine:
        """Run from a snapshot to a scan, watch that scan, and return the engine after it.

        Args:
            scan: the scan.
            noted: only note the power, in the compiled program, which is faster; a scan that faults is still
                watched.

        Raises:
            ValueError: the scan can't be repeated.
        """
        self.at = None
        if not self._run_to(scan, watched=not noted):
            raise ValueError(f"scan {scan} can no longer be repeated")
        return self.again(scan) if noted and self.engine.broken_off else self.engine

    def inputs(self, scan: int) -> ScanInputs | None:
        """Return the inputs of a scan; None if they are unknown."""
        count, recorded = self.source.inputs(scan, scan)
        return next(recorded, None) if count == 1 else None

    def walk(self, first: int, last: int, *, noted: bool = False) -> Iterator[int]:
        """Run scans in turn; yield each scan's time, in ns, with the engine in the state after the scan.

        Stop before the first scan that can't be repeated.

        Args:
            noted: note the power of all lines.
        """
        if self.at == first:
            self.at = None  # the engine is after this scan, but the scan must run again
        start = self._start(first)
        count, recorded = (0, iter(())) if start is None else self.source.inputs(start, last)
        if start is None or not count:
            self.at = None
            return
        self._observe_nothing()
        if noted:
            self.engine.note_all()
        for scan, inputs in enumerate(recorded, start):
            self.at = scan
            self._do(inputs)
            if scan >= first:
                yield inputs.now_ns

    def last_change(self, read: Callable[[WatchedEngine], Any], end: int) -> int | None:
        """Return the last scan up to `end` that changed a value; None if there is none.

        Args:
            read: reads the value.
        """
        for start in islice(self.source.snapshots(end), self._stretches):
            if start <= end:
                scan = self._change_in(start, end, read)
                if scan is not None:
                    return scan
                end = start - 1
        return None

    def looked_back(self, end: int) -> int:
        """Return the number of the last scan before the scans that `last_change` searches."""
        return min(islice(self.source.snapshots(end), self._stretches), default=end + 1) - 1

    def last_change_of(self, cells: Sequence[Cell], end: int) -> int | None:
        """Return the last scan up to `end` that changed any of the cells; None if there is none.

        Results are cached, because `why` and a chain search for the same cells.
        """
        until, scan = self._last_changes.get(tuple(cells), (-1, None))
        searched_other_stretches = scan is None and self._stretches is not None and end < until
        if end > until or searched_other_stretches or (scan is not None and scan > end):
            until = end
            scan = next((found for found in self._search(cells, end) if found is not None), None)
            self._last_changes[tuple(cells)] = until, scan
            if len(self._last_changes) > MOST_LAST_CHANGES:
                del self._last_changes[next(iter(self._last_changes))]
        return scan

    def _search(self, cells: Sequence[Cell], end: int) -> Iterator[int | None]:
        """Yield the last change in each part of the past, latest first; None for a part without a change.

        A stretch with different snapshots at its ends contains a change. In later stretches, values can only
        have changed and changed back.
        """

        def read(engine: WatchedEngine) -> list[Value]:
            return [cell.masked(engine.memory.read(cell.leaf, cell.index)) for cell in cells]

        snapshots = (snapshot for snapshot in self.source.snapshots(end) if snapshot <= end)
        starts = list(islice(snapshots, self._stretches))
        lasts = [end, *(start - 1 for start in starts)]
        begin = 0
        for changing in chain(self._changing_stretches(cells, starts), [len(starts)]):
            few = changing if changing - begin <= ONE_BY_ONE else begin + FIRST_ONE_BY_ONE
            for number in range(begin, few):
                yield self._change_in(starts[number], lasts[number], read)
            for number in range(few, changing, SIDE_BY_SIDE):
                many = starts[number - 1 : min(number + SIDE_BY_SIDE, changing)]
                yield self._change_in_many(many, cells, read)
            if changing < len(starts):
                yield self._change_in(starts[changing], lasts[changing], read)
            begin = changing + 1

    def _changing_stretches(self, cells: Sequence[Cell], starts: Sequence[int]) -> Iterator[int]:
        """Yield the indices of the stretches whose two snapshots differ, latest first."""
        positions = [place_in_snapshot(self.engine.memory, cell) for cell in cells]
        later_values: list[Value] | None = None
        if None in positions:  # a value in bytes
            return
        for number, start in enumerate(starts):
            snapshot = self.source.snapshot(start)[0]
            values = [
                cell.masked(snapshot[ident] if index is None else snapshot[ident][index])
                for cell, (ident, index) in zip(cells, filter(None, positions), strict=True)
            ]
            if later_values is not None and not same(values, later_values):
                yield number
            later_values = values

    def _change_in_many(
        self, starts: Sequence[int], cells: Sequence[Cell], read: Callable[[WatchedEngine], Any]
    ) -> int | None:
        """Return the last change in the stretches that begin at any snapshot except the first."""
        stretches = [self._stretch(start, end) for end, start in pairwise(starts)]
        for stretch, change in zip(stretches, self._lanes.last_changes(cells, stretches), strict=True):
            scan: int | None = change.scan
            if not change.known:
                scan = self._change_in(stretch.first, stretch.last, read)
            if scan is not None:
                return scan
        return None

    def _stretch(self, start: int, end: int) -> ReplayStretch:
        """Return the scans between two snapshots; their inputs are None if there are forces."""
        values, forces = self.source.snapshot(start)
        inputs = None if forces else self.source.plain(start, end - 1)
        return ReplayStretch(start, end - 1, values, inputs, self.source.snapshot(end)[0])

    @cached_property
    def _lanes(self) -> Any:
        from .lanes import Lanes  # most runs search nothing

        return Lanes(self.engine.lowered, self.engine.memory, self.images)

    def _change_in(self, start: int, last: int, read: Callable[[WatchedEngine], Any]) -> int | None:
        """Return the last scan of a stretch that changed a value; None if there is none."""
        count, recorded = self.source.inputs(start, last)
        if count != last - start + 1:
            return None
        self._restore(start)
        changed, previous = None, read(self.engine)
        for scan, inputs in enumerate(recorded, start):
            self.at = scan
            self._do(inputs)
            value = read(self.engine)
            if not same(value, previous):
                changed, previous = scan, value
        return changed

    def _run_to(self, scan: int, *, watched: bool) -> bool:
        """Run to a scan, which is watched or noted; return whether all scans up to it could be repeated."""
        start = self._start(scan)
        if start is None:
            return False
        count, recorded = self.source.inputs(start, scan)
        if count != scan - start + 1:
            self.at = None
            return False
        if count:
            self._observe_nothing()
            for inputs in islice(recorded, count - 1):
                self._do(inputs)
            self._do_last(next(recorded), watched=watched)
        self.at = scan
        return True

    def _do_last(self, inputs: ScanInputs, *, watched: bool) -> None:
        """Run a scan and set `truths` to its power: in the interpreter if `watched`, or else compiled."""
        engine = self.engine
        if watched:
            engine.watching = True
        else:
            engine.note_all()
        if self._do(inputs):
            self.truths = engine.truths
        engine.watching = False

    def _start(self, scan: int) -> int | None:
        """Set the engine to the first scan to run; return its number, or None if no snapshot is close."""
        snapshot, current = next(self.source.snapshots(scan), None), self.at
        if (
            current is not None
            and current <= scan <= current + self._most
            and (snapshot is None or snapshot <= current + 1)
        ):
            return current + 1
        if snapshot is None or snapshot < scan - self._most:
            return None
        self._restore(snapshot)
        return snapshot

    def _restore(self, scan: int) -> None:
        """Set the engine to the snapshot before a scan, with its forces and nothing observed."""
        engine = self.engine
        values, forces = self.source.snapshot(scan)
        engine.hold(NO_FORCES)
        self._observe_nothing()
        restore(engine.memory, values)
        engine.scans = scan
        engine.hold(forces)
        self.at = scan - 1

    def _observe_nothing(self) -> None:
        self.engine.watching = False
        self.engine.note(())

    def _do(self, inputs: ScanInputs) -> bool:
        """Repeat a scan; return whether the logic ran."""
        return repeat(self.engine, self._images, inputs)


def repeat(engine: WatchedEngine, images: Sequence[memoryview], inputs: ScanInputs) -> bool:
    """Repeat a scan with its inputs; return whether the logic ran. A fault ends it, as in the original.

    Args:
        images: the program's input images as bytes, see `image_bytes`.
    """
    if inputs.forces is not None:
        engine.hold(inputs.forces)
        engine.outside = inputs.writes
    if inputs.images is None:
        engine.scans += 1
        return False
    for memory_image, image in zip(images, inputs.images, strict=True):
        memory_image[:] = image
    with suppress(LadderFault):
        engine.do(inputs.now_ns, first=inputs.first)
    return True


def image_bytes(memory: Memory) -> list[memoryview]:
    """Return the input images that a program uses, as writable bytes."""
    return [memory.cells[leaf.ident].cell_contents.cast("B") for leaf in input_leaves(memory)]


def input_leaves(memory: Memory) -> list[Leaf]:
    """Return the input images that a program uses, in the order of the layout."""
    return [leaf for leaf in memory.layout.images if not leaf.output]


def plain_inputs(inputs: Sequence[ScanInputs]) -> PlainInputs | None:
    """Return the inputs of scans as arrays; None if they are not plain."""
    import numpy as np  # most runs search nothing

    images = [recorded.images for recorded in inputs if recorded.images is not None and recorded.is_plain]
    if not images or len(images) < len(inputs):
        return None
    words = (
        np.frombuffer(b"".join(rows), np.int16).reshape(len(rows), -1) for rows in zip(*images, strict=True)
    )
    return PlainInputs(np.array([recorded.now_ns for recorded in inputs]), tuple(words))
