"""Scans of a ladder program that repeat the one before them: a search passes over them.

    scan            n     n + 1 ... n + k     n + k + 1
    inputs          R     R                   R, or others
    memory before   M     M                   M, or a timer is done now
    memory after    M

A scan follows from its inputs, the program's memory, and the time. If it leaves the memory as it was, and inputs
stay, so do all that follow. Only clocks go on: timers that no other instruction reads are moved on by k scans, and
the last of these comes before one of them is done.

`clocks_of` names the programs of which this holds: compiled ladder programs whose instructions depend on nothing
else. What is watched has to have the same answer, too, see `Watch`.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from types import CellType
from typing import Any

from ...ladder.debug.crossref import cross_reference
from ...ladder.instructions import timing
from ...ladder.model.operands import Group, Place
from ...ladder.run.engine import Engine
from ...ladder.state.lowered import AddOnCall, LoweredProgram, LoweredStep
from ...ladder.state.tag_bytes import TagBytes
from .invariants.invariants import FOREVER_NS

LEAST = 3
"""Fewest scans that are worth passing over."""

TIMERS = frozenset({timing.TON.name, timing.TOF.name, timing.RTO.name})

NS_PER_MS = 1_000_000

EVEN = frozenset(
    "addons arrays bits blocks compare compute control decimal files move sequencers shifts statements timing "
    "trigonometry".split()
)
"""Families of instructions that depend on their operands, and count time in whole milliseconds at most."""

STATE, LISTS, BYTES, CLOCKS = range(4)
"""Parts of a program's memory as `RepeatedScans` keeps it."""

Until = Callable[[int, bool], int]
"""Takes the time of the latest scan and whether timers count; returns the instant up to which all that is watched
has the same answer if nothing else changes, ns."""


@dataclass(frozen=True, slots=True)
class ProgramClocks:
    """The variables of a program that follow the time, by their identifiers.

    Attributes:
        timers: ACC, time of the latest count, PRE and TT of each timer that only timer instructions read.
        scanned: the time of the latest scan, of a controller with tasks; None without one.
    """

    timers: tuple[tuple[str, str, str, str], ...]
    scanned: str | None


_CLOCKS: list[tuple[LoweredProgram, ProgramClocks | None]] = []
"""The program that was looked at last: a search has one."""


def clocks_of(lowered: LoweredProgram) -> ProgramClocks | None:
    """Return the clocks of a program; None if its scans may differ for other reasons than inputs and memory."""
    if not _CLOCKS or _CLOCKS[0][0] is not lowered:
        _CLOCKS[:] = [(lowered, _found_clocks(lowered))]
    return _CLOCKS[0][1]


def _found_clocks(lowered: LoweredProgram) -> ProgramClocks | None:
    steps = list(_steps(lowered))
    schedule = lowered.schedule
    if lowered.functions or lowered.opening or lowered.closing or not all(map(_is_even, steps)):
        return None
    if schedule is not None and schedule.called:
        return None
    read = _read_otherwise(lowered)
    timers = {
        group.path.upper(): tuple(group.member(name).leaf.ident for name in ("ACC", "~last_ns", "PRE", "TT"))
        for group in (step.operands[0] for step in steps if step.name in TIMERS)
        if isinstance(group, Group) and not group.indices and group.path.upper() not in read
    }
    return ProgramClocks(tuple(timers.values()), None if schedule is None else schedule.before.ident)  # type: ignore[arg-type]


def _steps(lowered: LoweredProgram) -> Iterator[LoweredStep]:
    return (step for routine in lowered.routines.values() for line in routine.lines for step in line.all_steps)


def _is_even(step: LoweredStep) -> bool:
    family = getattr(step.spec.run, "__module__", "").rpartition(".instructions.")[2]
    return family in EVEN or any(isinstance(each, AddOnCall) for each in step.operands)


def _read_otherwise(lowered: LoweredProgram) -> set[str]:
    """Return the tags, in capitals, of which something but a timer instruction may read or write the count."""
    found = set()
    for each in cross_reference(lowered).mentions:
        where = each.where
        path = (where.leaf.path if isinstance(where, Place) else where.path).upper()
        name = "" if each.step is None else each.step.name
        if isinstance(where, Group) and name not in (*TIMERS, timing.RES.name):
            found.add(path)
        elif path.endswith(".ACC"):
            found.add(path.removesuffix(".ACC"))
    return found


class RepeatedScans:
    """Finds the scans of one run that repeat the one before them.

    Args:
        period_ns: time from scan to scan, whole milliseconds: a timer that runs counts in each scan.
        stops: numbers of scans that are run in any case, in ascending order.
        until: see `Until`.
    """

    def __init__(
        self, engine: Engine, clocks: ProgramClocks, period_ns: int, stops: Sequence[int], until: Until
    ) -> None:
        self._period_ns, self._stops, self._until = period_ns, stops, until
        self._minor = engine.fault_log.minor
        cells = engine.memory.cells
        timers = [tuple(cells[ident] for ident in timer) for timer in clocks.timers if timer[0] in cells]
        self._timers = [(acc, last, pre, tt) for acc, last, pre, tt in timers]
        self._scanned = cells[clocks.scanned] if clocks.scanned in cells else None
        self._moved: list[CellType] = [cell for acc, last, *_ in self._timers for cell in (acc, last)]
        moved = {id(cell) for cell in (*self._moved, self._scanned)}
        others = [cell for cell in cells.values() if id(cell) not in moved]
        self._lists = [cell.cell_contents for cell in others if type(cell.cell_contents) is list]
        self._bytes = [cell.cell_contents for cell in others if isinstance(cell.cell_contents, TagBytes)]
        apart = (list, TagBytes, memoryview)  # images are compared by the scan loop
        self._plain = [cell for cell in others if not isinstance(cell.cell_contents, apart)]
        self._kept: tuple[Any, ...] = ()

    def _memory(self) -> tuple[Any, ...]:
        return (
            [cell.cell_contents for cell in self._plain],
            [[*each] for each in self._lists],
            [each.saved() for each in self._bytes],
            [cell.cell_contents for cell in self._moved],
            self._minor[-1] if self._minor else None,
        )

    def keep(self) -> None:
        """Keep the program's memory before the next scan."""
        self._kept = self._memory()

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        """Return how many scans repeat the latest one, and move the timers on; see `RepeatFinder`."""
        before, now = self._kept, self._memory()
        if now[:CLOCKS] != before[:CLOCKS] or now[-1] is not before[-1]:
            return 0
        place = bisect_left(self._stops, scan)
        if place < len(self._stops):
            most = min(most, self._stops[place] - scan)
        counting = now[CLOCKS] != before[CLOCKS]
        if counting:
            most = min(most, self._until_done(before[CLOCKS], now[CLOCKS], now_ns))
        if most < LEAST:
            return 0
        most = min(most, (self._until(now_ns, counting) - now_ns) // self._period_ns)
        if most < LEAST:
            return 0
        self._move_on(before[CLOCKS], now[CLOCKS], now_ns, most)
        return most

    def _until_done(self, before: list[int], now: list[int], now_ns: int) -> int:
        """Return the number of scans until one before a timer is done; 0 if a clock does not go on evenly."""
        by_ms = self._period_ns // NS_PER_MS
        least = FOREVER_NS
        for place, (_, _, pre, tt) in enumerate(self._timers):
            count, last_ns = now[2 * place : 2 * place + 2]
            count_before, last_before_ns = before[2 * place : 2 * place + 2]
            if count == count_before and last_ns == last_before_ns:
                continue
            counted = last_ns == now_ns == last_before_ns + self._period_ns and count == count_before + by_ms
            if not (tt.cell_contents and counted):
                return 0
            least = min(least, -(-(pre.cell_contents - count) // by_ms) - 1)
        return least

    def _move_on(self, before: list[int], now: list[int], now_ns: int, scans: int) -> None:
        for cell, earlier, value in zip(self._moved, before, now, strict=True):
            cell.cell_contents = value + (value - earlier) * scans
        if self._scanned is not None:
            self._scanned.cell_contents = now_ns + scans * self._period_ns


def stops_of(instants_ns: Iterable[int], period_ns: int) -> list[int]:
    """Return the scans about some instants, which are run in any case.

    >>> stops_of([4_000_000, 6_000_000], 2_000_000)
    [1, 2, 3, 4]
    """
    scans = {max(0, at_ns // period_ns + near) for at_ns in instants_ns for near in (-1, 0, 1)}
    return sorted(scans)
