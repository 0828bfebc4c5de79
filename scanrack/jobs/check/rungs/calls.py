"""Calls of routines: their conditions, and instructions that run twice in a scan."""

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
"""Uses of operands that store an instruction's state from scan to scan."""


class Run(NamedTuple):
    """A path to a routine: its condition, and the line of the call."""

    when: Condition
    line: int


class RoutineCalls:
    """The calls of a program's routines."""

    def __init__(self, points: Sequence[Point]) -> None:
        self._points = points
        self._calls: dict[str, list[Point]] = {}  # by called routine, in capitals
        for point in points:
            for operand in point.step.operands:
                if isinstance(operand, Call):
                    self._calls.setdefault(operand.routine.upper(), []).append(point)

    def calls_to(self, routine: str) -> Sequence[Point]:
        """Return the calls of a routine."""
        return self._calls.get(routine.upper(), ())

    def runs(self, routine: LoweredRoutine, depth: int = DEPTH) -> list[Run]:
        """Return the paths to a routine, except paths from chart actions, whose steps exclude each other."""
        calls = self.calls_to(routine.name)
        if not calls or depth == 0:
            return [Run(TRUE, 0)]
        runs = []
        for point in calls:
            if point.routine.chart is None and point.step.name == "JSR":
                for run in self.runs(point.routine, depth - 1):
                    runs.append(Run(AllOf((run.when, plain(point.condition))), point.place.line))
        return runs

    def exclude(self, first: Point, second: Point) -> bool:
        """Whether two instructions are in routines that never run in the same scan."""
        if first.routine is second.routine:
            return False
        pairs = product(self.runs(first.routine), self.runs(second.routine))
        return all(never(AllOf((run.when, other_run.when))) for run, other_run in pairs)

    def mixed(self, *, latches: bool) -> Iterator[Violation]:
        """Yield structured text assignments to bits that an OTE also writes in every scan.

        Args:
            latches: include assignments of constants under a condition, see `data.coil_and_latch`.
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
        """Yield the instructions with these names, each with the key of the bit that it writes."""
        for point in self._points:
            bit = first_of(point.step, names) if point.is_rung is in_rungs else None
            if isinstance(bit, Place):
                yield point, key_of(bit)

    def note_repeats(self, facts: Facts) -> None:
        """Note timers, blocks and similar instructions in a routine that runs twice in a scan."""
        pairs: dict[str, tuple[Run, Run] | None] = {}  # by routine: two runs in the same scan
        for point in self._points:
            name = point.routine.name
            operand = _state_operand(point) if self.calls_to(name) else ""
            if not operand:
                continue
            if name not in pairs:
                pairs[name] = self._two_runs(point.routine)
            pair = pairs[name]
            if pair is not None:
                lines = " and ".join(str(line) for line in sorted({run.line for run in pair}))
                text = f"{operand} runs twice in a scan: lines {lines} both lead to routine {name}"
                facts.remark("block-twice", point.place, text)

    def _two_runs(self, routine: LoweredRoutine) -> tuple[Run, Run] | None:
        """Return two paths to a routine that may both be taken in one scan; None if there are none."""
        for first, second in combinations(self.runs(routine), 2):
            if not never(AllOf((first.when, second.when))):
                return first, second
        return None


def _is_latch(point: Point) -> bool:
    """Whether an assignment writes a constant under a condition."""
    return point.condition != TRUE and isinstance(point.step.operands[-1], Constant)


def _state_operand(point: Point) -> str:
    """Return the timer, counter, one-shot or instance that stores an instruction's state; "" if none does."""
    for use, operand in uses_of(point.step):
        if use in REMEMBERING and isinstance(operand, Group | Place) and is_fixed(operand):
            return operand.text
    return ""


def exclusive_repeats(
    remarks: Sequence[Violation], points: Iterable[Point], calls: RoutineCalls
) -> Iterator[Violation]:
    """Yield the remarks on repeated coils and timers, except in routines that never run in the same scan."""
    writers = [point for point in points if _written_operand(point)] if remarks else []
    by_place = grouped(writers, lambda point: point.place)
    by_operand = grouped(writers, _written_operand)
    for remark in remarks:
        excluded = (  # lazy: the first pair that can both run decides, and n coils have n² pairs
            calls.exclude(point, other)
            for point in by_place.get(remark.place, ())
            for other in by_operand[_written_operand(point)]
            if other is not point
        )
        is_first_excluded = next(excluded, False)  # without a pair, the remark remains
        if not is_first_excluded or not all(excluded):
            yield remark


def _written_operand(point: Point) -> str:
    """Return the bit or timer that only this instruction should write; "" for other instructions."""
    for use, operand in uses_of(point.step):
        if use in (Use.COIL, Use.TIMER, Use.STORAGE) and isinstance(operand, Group | Place):
            return operand.text.upper()
    return ""
