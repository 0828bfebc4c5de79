"""Finds scans of a ladder program that repeat the previous scan, so that a search can skip them.

    scan            n     n + 1 ... n + k     n + k + 1
    inputs          R     R                   R, or others
    memory before   M     M                   M, or a timer is done now
    memory after    M

If a scan leaves the memory as it was and the inputs stay the same, the scans after it do the same. Only even
timers count (`program_clocks`). They are advanced by k scans, and all of these come before anything depends
on a count. The invariants must also keep their answers (`invariants.Watch`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import CellType
from typing import Any

from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.tag_bytes import TagBytes

from .invariants.invariants import FOREVER_NS
from .program_clocks import EvenTimer, ProgramClocks

NS_PER_MS = 1_000_000

LEAST = 3
"""Fewest scans that are worth skipping."""

SameUntil = Callable[[bool], int]
"""Takes whether timers count; returns the instant until which all invariants have the same answer, ns."""

Clocks = list[tuple[int, int]]
"""The count of each timer, and the time of its latest count."""


class RepeatedScans:
    """Finds the scans of one run that repeat the previous one, as a `runtime.loop.scans_ahead.RepeatFinder`.

    Args:
        period_ns: time from scan to scan, ns: whole milliseconds, so that a running timer counts in each
        scan.
        stops: numbers of scans that are always run, in ascending order.
    """

    def __init__(
        self, engine: Engine, clocks: ProgramClocks, period_ns: int, stops: Sequence[int], until: SameUntil
    ) -> None:
        self._period_ns, self._stops, self._until = period_ns, stops, until
        self._minor, self._memory = engine.fault_log.minor, engine.memory
        self._scanned = clocks.scanned
        self._timers = [timer for timer in clocks.timers if self._has(timer)]
        self._plain: list[CellType] = []
        self._bytes: list[TagBytes] = []
        self._lists: list[tuple[list[Any], list[int]]] = []
        self._sort_cells([*self._moved_leaves()])
        self._kept: tuple[Any, ...] = ()
        self._kept_clocks: Clocks = []

    def _moved_leaves(self) -> Iterator[Leaf]:
        """Yield the variables that change with time."""
        for timer in self._timers:
            yield from (timer.count, timer.last)
        if self._scanned is not None:
            yield self._scanned

    def _sort_cells(self, moved: list[Leaf]) -> None:
        """Sort the cells of the memory by kind: plain values, bytes, and lists with the places of clocks."""
        layout, idents = self._memory.layout, {leaf.ident for leaf in moved}
        spots = [spot for leaf in moved if (spot := layout.spot(leaf)) is not None]
        for ident, cell in self._memory.cells.items():
            value = cell.cell_contents
            if isinstance(value, list):
                self._lists.append((value, [spot.at(0) for spot in spots if spot.ident == ident]))
            elif isinstance(value, TagBytes):
                self._bytes.append(value)
            elif not isinstance(value, memoryview) and ident not in idents:  # the scan loop compares images
                self._plain.append(cell)

    def _has(self, timer: EvenTimer) -> bool:
        """Return whether a timer's members are variables or elements of a list."""
        layout, cells = self._memory.layout, self._memory.cells
        spots = [(leaf, layout.spot(leaf)) for leaf in (timer.count, timer.last, *timer.copies)]
        return all(leaf.ident in cells if spot is None else not spot.view for leaf, spot in spots)

    def _state(self) -> tuple[Any, ...]:
        """Return the program's memory without its clocks."""
        lists = [[*values] for values, _ in self._lists]
        for values, (_, clocks) in zip(lists, self._lists, strict=True):
            for place in clocks:
                values[place] = 0
        plain = [cell.cell_contents for cell in self._plain]
        minor_faults = self._minor[-1] if self._minor else None
        return plain, lists, [byte.saved() for byte in self._bytes], minor_faults

    def _clocks(self) -> Clocks:
        read = self._memory.read
        return [(int(read(timer.count)), int(read(timer.last))) for timer in self._timers]

    def keep(self) -> None:
        """Save the program's memory before the next scan."""
        self._kept, self._kept_clocks = self._state(), self._clocks()

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        """Return how many scans repeat the latest one, and advance the clocks by them."""
        if self._state() != self._kept:
            return 0
        place = bisect_left(self._stops, scan)
        if place < len(self._stops):
            most = min(most, self._stops[place] - scan)
        clocks = self._clocks()
        counting = clocks != self._kept_clocks
        if counting:
            most = min(most, self._until_seen(clocks, now_ns))
        if most >= LEAST:
            most = min(most, (self._until(counting) - now_ns) // self._period_ns)
        if most < LEAST:
            return 0
        self._advance(clocks, now_ns, most)
        return most

    def _until_seen(self, clocks: Clocks, now_ns: int) -> int:
        """Return the number of scans before anything depends on a count; 0 if a count is not even."""
        by_ms, least = self._period_ns // NS_PER_MS, FOREVER_NS
        read = self._memory.read
        for timer, before, now in zip(self._timers, self._kept_clocks, clocks, strict=True):
            if before == now:
                continue
            counted = now == (before[0] + by_ms, now_ns) and before[1] + self._period_ns == now_ns
            if not (counted and read(timer.counting)):
                return 0
            if any(read(leaf) in (before[0], now[0]) for leaf in timer.copies):
                return 0  # the latest scan may have copied the count
            for limit in (int(read(timer.preset)), *timer.constants):
                if before[0] <= limit <= now[0]:
                    return 0
                if now[0] < limit:
                    least = min(least, -(-(limit - now[0]) // by_ms) - 1)
        return least

    def _advance(self, clocks: Clocks, now_ns: int, scans: int) -> None:
        """Advance the clocks by a number of scans."""
        write, ms = self._memory.write, scans * self._period_ns // NS_PER_MS
        for timer, before, now in zip(self._timers, self._kept_clocks, clocks, strict=True):
            if before != now:
                write(timer.count, 0, now[0] + ms)
                write(timer.last, 0, now[1] + scans * self._period_ns)
        if self._scanned is not None:
            write(self._scanned, 0, now_ns + scans * self._period_ns)


def stops_of(instants_ns: Iterable[int], period_ns: int) -> list[int]:
    """Return the scans around the given instants; these scans are always run.

    >>> stops_of([4_000_000, 6_000_000], 2_000_000)
    [1, 2, 3, 4]
    """
    scans = {max(0, at_ns // period_ns + offset) for at_ns in instants_ns for offset in (-1, 0, 1)}
    return sorted(scans)
