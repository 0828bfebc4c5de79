"""Finds scans of a ladder program that repeat the previous scan, so that a search can skip them.

    scan            n     n + 1 ... n + k     n + k + 1
    inputs          R     R                   R, or others
    memory before   M     M                   M, or a timer is done now
    memory after    M

If a scan does not change the memory and the inputs stay the same, the next scans do not change it either.
Only even timers can count in these scans (see `program_clocks`). They are advanced by k scans, and the
skipped scans end before anything depends on a count. The results of the invariants must also stay the same
(`invariants.Watch`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import CellType
from typing import Any, NamedTuple

from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.tag_bytes import TagBytes

from .invariants.invariants import FOREVER_NS
from .program_clocks import EvenTimer, ProgramClocks

NS_PER_MS = 1_000_000

LEAST = 3
"""Minimum number of scans to skip."""

SameUntil = Callable[[bool], int]
"""Returns the instant before which no invariant's result changes, ns. Argument: whether timers count."""


class Clock(NamedTuple):
    """The state of a timer."""

    count_ms: int
    last_ns: int  # time of the latest count


class RepeatedScans:
    """Finds the scans of one run that repeat the previous one, as a `runtime.loop.scans_ahead.RepeatFinder`.

    Args:
        period_ns: time from scan to scan, ns. It is a whole number of milliseconds, so a running timer counts
            in each scan.
        stops: numbers of scans that must run, in ascending order.
        same_until_ns: see `SameUntil`.
    """

    def __init__(
        self,
        engine: Engine,
        clocks: ProgramClocks,
        period_ns: int,
        stops: Sequence[int],
        same_until_ns: SameUntil,
    ) -> None:
        self._period_ns, self._stops, self._same_until_ns = period_ns, stops, same_until_ns
        self._minor_faults, self._memory = engine.fault_log.minor, engine.memory
        self._scanned = clocks.scanned
        self._timers = [timer for timer in clocks.timers if self._is_movable(timer)]
        self._plain_cells: list[CellType] = []
        self._tag_bytes: list[TagBytes] = []
        self._lists: list[tuple[list[Any], list[int]]] = []  # each with the indices of its clocks
        self._sort_cells([*self._clock_leaves()])
        self._saved_memory: tuple[Any, ...] = ()
        self._saved_clocks: list[Clock] = []

    def _clock_leaves(self) -> Iterator[Leaf]:
        """Yield the variables that change with time."""
        for timer in self._timers:
            yield from (timer.count, timer.last)
        if self._scanned is not None:
            yield self._scanned

    def _sort_cells(self, clock_leaves: list[Leaf]) -> None:
        """Sort the cells of the memory by kind: plain values, bytes, and lists."""
        layout, clock_idents = self._memory.layout, {leaf.ident for leaf in clock_leaves}
        spots = [spot for leaf in clock_leaves if (spot := layout.spot(leaf)) is not None]
        for ident, cell in self._memory.cells.items():
            value = cell.cell_contents
            if isinstance(value, list):
                self._lists.append((value, [spot.at(0) for spot in spots if spot.ident == ident]))
            elif isinstance(value, TagBytes):
                self._tag_bytes.append(value)
            elif isinstance(value, memoryview):
                pass  # the scan loop compares images
            elif ident not in clock_idents:
                self._plain_cells.append(cell)

    def _is_movable(self, timer: EvenTimer) -> bool:
        """Return whether a timer can be advanced: its members are variables or elements of a list."""
        layout, cells = self._memory.layout, self._memory.cells
        spots = [(leaf, layout.spot(leaf)) for leaf in (timer.count, timer.last, *timer.copies)]
        return all(leaf.ident in cells if spot is None else not spot.view for leaf, spot in spots)

    def _memory_without_clocks(self) -> tuple[Any, ...]:
        """Return copies of the program's values, with 0 for its clocks, and the last minor fault."""
        lists = []
        for values, clock_indices in self._lists:
            copied_values = [*values]
            for index in clock_indices:
                copied_values[index] = 0
            lists.append(copied_values)
        plain_values = [cell.cell_contents for cell in self._plain_cells]
        last_minor_fault = self._minor_faults[-1] if self._minor_faults else None
        return plain_values, lists, [tag_bytes.saved() for tag_bytes in self._tag_bytes], last_minor_fault

    def _read_clocks(self) -> list[Clock]:
        read = self._memory.read
        return [Clock(int(read(timer.count)), int(read(timer.last))) for timer in self._timers]

    def keep(self) -> None:
        """Save the program's memory before the next scan."""
        self._saved_memory, self._saved_clocks = self._memory_without_clocks(), self._read_clocks()

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        """Return how many of the next scans repeat the latest scan, and advance the clocks accordingly.

        Args:
            scan: number of the next scan.
            most: maximum number of scans.
        """
        if self._memory_without_clocks() != self._saved_memory:
            return 0
        stop_index = bisect_left(self._stops, scan)
        if stop_index < len(self._stops):
            most = min(most, self._stops[stop_index] - scan)
        clocks = self._read_clocks()
        is_counting = clocks != self._saved_clocks
        if is_counting:
            most = min(most, self._scans_without_effect(clocks, now_ns))
        if most >= LEAST:
            most = min(most, (self._same_until_ns(is_counting) - now_ns) // self._period_ns)
        if most < LEAST:
            return 0
        self._advance(clocks, now_ns, most)
        return most

    def _scans_without_effect(self, clocks: list[Clock], now_ns: int) -> int:
        """Return the number of scans before anything depends on a count; 0 if a count was not even."""
        period_ms, scans = self._period_ns // NS_PER_MS, FOREVER_NS
        read = self._memory.read
        for timer, before, after in zip(self._timers, self._saved_clocks, clocks, strict=True):
            if before == after:
                continue
            is_regular = before.last_ns + self._period_ns == now_ns
            if not is_regular or after != (before.count_ms + period_ms, now_ns) or not read(timer.counting):
                return 0
            if any(read(leaf) in (before.count_ms, after.count_ms) for leaf in timer.copies):
                return 0  # the latest scan may have copied the count
            for limit in (int(read(timer.preset)), *timer.constants):
                if before.count_ms <= limit <= after.count_ms:
                    return 0
                if after.count_ms < limit:
                    scans = min(scans, -(-(limit - after.count_ms) // period_ms) - 1)
        return scans

    def _advance(self, clocks: list[Clock], now_ns: int, scans: int) -> None:
        """Advance the clocks by a number of scans."""
        write, ms = self._memory.write, scans * self._period_ns // NS_PER_MS
        for timer, before, after in zip(self._timers, self._saved_clocks, clocks, strict=True):
            if before != after:
                write(timer.count, 0, after.count_ms + ms)
                write(timer.last, 0, after.last_ns + scans * self._period_ns)
        if self._scanned is not None:
            write(self._scanned, 0, now_ns + scans * self._period_ns)


def stops_of(instants_ns: Iterable[int], period_ns: int) -> list[int]:
    """Return the numbers of the scans around the instants. These scans must run.

    >>> stops_of([4_000_000, 6_000_000], 2_000_000)
    [1, 2, 3, 4]
    """
    scans = {max(0, at_ns // period_ns + offset) for at_ns in instants_ns for offset in (-1, 0, 1)}
    return sorted(scans)
