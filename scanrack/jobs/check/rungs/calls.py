"""Calls of routines: under which conditions each one runs, and what runs twice in a scan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import Call, LoweredRoutine, LoweredStep

from ..facts import Facts, FileLine, LocalFinding
from ..logic import TRUE, AllOf, Condition, never, plain
from .conditions import key_of
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

DEPTH = 6
"""Routines in routines that are followed."""

REMEMBERING = (Use.STORAGE, Use.TIMER, Use.COUNTER, Use.SLC_TIMER, Use.SLC_COUNTER, Use.BLOCK)
"""Uses of what an instruction keeps from scan to scan."""


class Run(NamedTuple):
    """A way to a routine: when it runs, and the line of its call."""

    when: Condition
    line: int


class RoutineCalls:
    """The calls of a program's routines."""

    def __init__(self, points: Placed) -> None:
        self._points = points
        self._of: dict[str, list[tuple[Point, FileLine]]] = {}
        for point, place in points:
            for each in point.step.operands:
                if isinstance(each, Call):
                    self._of.setdefault(each.routine.upper(), []).append((point, place))

    def of(self, routine: str) -> Sequence[tuple[Point, FileLine]]:
        """Return the calls of a routine."""
        return self._of.get(routine.upper(), ())

    def runs(self, routine: LoweredRoutine, depth: int = DEPTH) -> list[Run]:
        """Return the ways to a routine; none from actions of charts, whose steps exclude each other."""
        calls = self.of(routine.name)
        if not calls or depth == 0:
            return [Run(TRUE, 0)]
        found = []
        for point, place in calls:
            if point.routine.chart is None and point.step.name == "JSR":
                for each in self.runs(point.routine, depth - 1):
                    found.append(Run(AllOf((each.when, plain(point.condition))), place.line))
        return found

    def exclude(self, one: Point, other: Point) -> bool:
        """Whether two instructions are in routines that never run in one scan."""
        ways = [(a, b) for a in self.runs(one.routine) for b in self.runs(other.routine)]
        return one.routine is not other.routine and all(never(AllOf((a.when, b.when))) for a, b in ways)

    def mixed(self, written: Callable[[LoweredStep], str], *, latches: bool) -> Iterator[LocalFinding]:
        """Yield the assignments of structured text to bits that an OTE writes in every scan.

        Args:
            written: returns an instruction as it is written.
            latches: whether those of constants under a condition count, see `data.coil_and_latch`.
        """
        coils: dict[str, tuple[Point, FileLine]] = {}
        for point, place in self._points:
            if point.is_rung and point.step.name == "OTE" and isinstance(point.step.operands[0], Place):
                coils.setdefault(key_of(point.step.operands[0]), (point, place))
        for point, place in self._points:
            if point.is_rung or point.step.name not in (":=", "[:=]"):
                continue
            target = point.step.operands[0]
            key = key_of(target) if isinstance(target, Place) else "?"
            coil, at = coils.get(key, (None, place))
            is_latch = (
                not latches and point.condition != TRUE and isinstance(point.step.operands[-1], Constant)
            )
            if coil is not None and "?" not in key and not is_latch and not self.exclude(coil, point):
                text = f"{written(point.step)} and {written(coil.step)} of line {at.line} write one bit"
                yield LocalFinding(place, text)

    def twice(self, facts: Facts) -> None:
        """Note what keeps its state from scan to scan, in routines that run twice in one."""
        ways: dict[str, tuple[Run, Run] | None] = {}
        for point, place in self._points:
            name = point.routine.name
            kept = _kept(point) if self.of(name) else ""
            if kept and name not in ways:
                pairs = combinations(self.runs(point.routine), 2)
                ways[name] = next(
                    (each for each in pairs if not never(AllOf((each[0].when, each[1].when)))), None
                )
            both = ways.get(name) if kept else None
            if both is not None:
                lines = " and ".join(str(each) for each in sorted({each.line for each in both}))
                text = f"{kept} runs twice in a scan: lines {lines} both lead to routine {name}"
                facts.remark("block-twice", place, text)


def _kept(point: Point) -> str:
    """Return the timer, counter, one-shot or instance that an instruction keeps; "" if it keeps none."""
    step = point.step
    for use, operand in zip(step.uses, step.operands, strict=False):
        is_named = isinstance(operand, Group | Place) and use in REMEMBERING
        if is_named and all(isinstance(each, Constant) for each in operand.indices):
            return str(operand.text)
    return ""


def exclusive_repeats(
    remarks: Sequence[LocalFinding], points: Placed, calls: RoutineCalls
) -> Iterator[LocalFinding]:
    """Yield the remarks on repeated coils and timers, without those of routines that exclude each other."""
    at: dict[FileLine, list[tuple[str, Point]]] = {}
    writers: dict[str, list[Point]] = {}
    for point, place in points if remarks else ():
        name = _written(point)
        if name:
            at.setdefault(place, []).append((name, point))
            writers.setdefault(name, []).append(point)
    for each in remarks:
        excluded = (
            calls.exclude(point, other)
            for name, point in at.get(each.place, ())
            for other in writers[name]
            if other is not point
        )
        if not next(excluded, False) or not all(excluded):
            yield each


def _written(point: Point) -> str:
    """Return the bit or the timer that only one instruction should write; "" for another one."""
    step = point.step
    for use, operand in zip(step.uses, step.operands, strict=False):
        if use in (Use.COIL, Use.TIMER, Use.STORAGE) and isinstance(operand, Group | Place):
            return operand.text.upper()
    return ""
