"""Calls of routines: the conditions under which they run, and what runs twice in a scan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple

from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import Call, LoweredRoutine

from ..facts import Facts, Violation
from ..groups import grouped
from ..logic import TRUE, AllOf, Condition, never, plain
from .operands import first_of, is_fixed, key_of, uses_of
from .walk import Point

DEPTH = 6
"""Maximum depth of calls that are followed."""

REMEMBERING = (Use.STORAGE, Use.TIMER, Use.COUNTER, Use.SLC_TIMER, Use.SLC_COUNTER, Use.BLOCK)
"""Uses of operands in which an instruction keeps its state from scan to scan."""


class Run(NamedTuple):
    """A path to a routine: its condition, and the line of the call."""

    when: Condition
    line: int


class RoutineCalls:
    """The calls of a program's routines."""

    def __init__(self, points: Sequence[Point]) -> None:
        self._points = points
        self._of: dict[str, list[Point]] = {}
        for point in points:
            for operand in point.step.operands:
                if isinstance(operand, Call):
                    self._of.setdefault(operand.routine.upper(), []).append(point)

    def of(self, routine: str) -> Sequence[Point]:
        """Return the calls of a routine."""
        return self._of.get(routine.upper(), ())

    def runs(self, routine: LoweredRoutine, depth: int = DEPTH) -> list[Run]:
        """Return the paths to a routine, except those from chart actions, whose steps exclude each other."""
        calls = self.of(routine.name)
        if not calls or depth == 0:
            return [Run(TRUE, 0)]
        runs_so_far = []
        for point in calls:
            if point.routine.chart is None and point.step.name == "JSR":
                for run in self.runs(point.routine, depth - 1):
                    runs_so_far.append(Run(AllOf((run.when, plain(point.condition))), point.place.line))
        return runs_so_far

    def exclude(self, one: Point, other: Point) -> bool:
        """Whether two instructions are in routines that never run in the same scan."""
        if one.routine is other.routine:
            return False
        ways = product(self.runs(one.routine), self.runs(other.routine))
        return all(never(AllOf((run.when, other_run.when))) for run, other_run in ways)

    def mixed(self, *, latches: bool) -> Iterator[Violation]:
        """Yield structured text assignments to bits that an OTE also writes in every scan.

        Args:
            latches: whether to include assignments of constants under a condition, see `data.coil_and_latch`.
        """
        coils: dict[str, Point] = {}
        for point, key in self._bits(("OTE",), in_rungs=True):
            if "?" not in key:
                coils.setdefault(key, point)
        for point, key in self._bits((":=", "[:=]"), in_rungs=False):
            coil = coils.get(key)
            if coil is not None and (latches or not _is_latch(point)) and not self.exclude(coil, point):
                line = coil.place.line
                yield Violation(point.place, f"{point.text} and {coil.text} of line {line} write one bit")

    def _bits(self, names: Sequence[str], *, in_rungs: bool) -> Iterator[tuple[Point, str]]:
        """Yield the instructions with the given names, each with the key of the bit it writes."""
        for point in self._points:
            bit = first_of(point.step, names) if point.is_rung is in_rungs else None
            if isinstance(bit, Place):
                yield point, key_of(bit)

    def twice(self, facts: Facts) -> None:
        """Note what keeps its state from scan to scan but is in a routine that runs twice in a scan."""
        ways: dict[str, tuple[Run, Run] | None] = {}
        for point in self._points:
            name = point.routine.name
            kept = _kept(point) if self.of(name) else ""
            if kept and name not in ways:
                ways[name] = self._both_ways(point.routine)
            run_pair = ways.get(name) if kept else None
            if run_pair is not None:
                lines = " and ".join(str(line) for line in sorted({run.line for run in run_pair}))
                text = f"{kept} runs twice in a scan: lines {lines} both lead to routine {name}"
                facts.remark("block-twice", point.place, text)

    def _both_ways(self, routine: LoweredRoutine) -> tuple[Run, Run] | None:
        """Return two paths to a routine that may both be taken in one scan; None if there are none."""
        pairs = combinations(self.runs(routine), 2)
        return next((both for both in pairs if not never(AllOf((both[0].when, both[1].when)))), None)


def _is_latch(point: Point) -> bool:
    """Whether an assignment writes a constant under a condition."""
    return point.condition != TRUE and isinstance(point.step.operands[-1], Constant)


def _kept(point: Point) -> str:
    """Return the timer, counter, one-shot or instance in which an instruction keeps its state; "" if none."""
    for use, operand in uses_of(point.step):
        if use in REMEMBERING and isinstance(operand, Group | Place) and is_fixed(operand):
            return operand.text
    return ""


def exclusive_repeats(
    remarks: Sequence[Violation], points: Iterable[Point], calls: RoutineCalls
) -> Iterator[Violation]:
    """Yield the remarks on repeated coils and timers, except in routines that never run in the same scan."""
    writing = [point for point in points if _written(point)] if remarks else []
    by_place = grouped(writing, lambda point: point.place)
    writers = grouped(writing, _written)
    for remark in remarks:
        excluded = (  # the first pair that can both run decides, as n coils have n² pairs
            calls.exclude(point, other)
            for point in by_place.get(remark.place, ())
            for other in writers[_written(point)]
            if other is not point
        )
        if not next(excluded, False) or not all(excluded):
            yield remark


def _written(point: Point) -> str:
    """Return the bit or timer that only this instruction should write; "" if there is none."""
    for use, operand in uses_of(point.step):
        if use in (Use.COIL, Use.TIMER, Use.STORAGE) and isinstance(operand, Group | Place):
            return operand.text.upper()
    return ""
