"""Equality comparisons of values that are rarely equal, such as REALs, elapsed times and analog inputs.

MUL(Raw,0.1,Level); EQU(Level,10.0)     0.1 times 100 is 10.0, but not always in REALs
EQU(Wait.ACC,500)                       with scans of 10 ms it may go from 495 to 505
NEQ(Wanted,Seen) MOV(Wanted,Seen)       exact: one is a copy of the other
NEQ(Span,0.0) DIV(Part,Span,Share)      exact: a divisor is tested for 0

Constants, copies, values that people write, and sums of whole numbers are exact.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence

from scanrack.io_images.cards import KINDS
from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved
from scanrack.ladder.model.operators import COMPARISONS
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Facts
from .number_ranges import RESULTS, Values, written_value
from .operands import calculations_of, divisors_of, group_of, is_zero, key_of, parts_of, path_of, uses_of
from .view import LadderView
from .walk import Point

TIMERS = ("TON", "TOF", "RTO", "TONR", "TOFR", "RTOR")

EQUALITIES = ("=", "<>")
WHOLE = ("+", "-", "*", "NEG", "ABS")
"""Operators whose result is a whole number if their operands are."""

COPYING = ("COP", "CPS", "FLL", "MOV", ":=", "[:=]", "CLR")
"""Instructions that copy a value unchanged."""

MEASURED = re.compile(r":I\b", re.IGNORECASE)
"""Finds paths of module inputs that are not simulated, such as Local:7:I.Ch0Data."""

DEPTH = 8


def note_reals(view: LadderView, facts: Facts) -> None:
    """Note equality comparisons of a calculated REAL, an elapsed time or an analog input."""
    cards = ((slot.number, KINDS.get(slot.module)) for slot in view.spec.slot)
    analog = [number for number, kind in cards if kind is not None and kind.channels_in > 0]
    reals = _Reals(view.points, view.values)
    groups = (group_of(point.step, TIMERS) for point in view.points)
    timers = {path_of(timer) for timer in groups if timer is not None}
    for point in view.points:
        for left, relation, right in _comparisons(point.step):
            kind_of_value = _measured(left, right, timers, analog) if relation == "=" else ""
            if not kind_of_value and reals.is_inexact(left, relation, right):
                kind_of_value = "a calculated REAL"
            if kind_of_value:
                verb = "hardly ever equals" if relation == "=" else "nearly always differs from"
                text = f"{point.text}: {kind_of_value} {verb} another number"
                facts.remark("real-equality", point.place, text)
                break


class _Reals:
    """Finds comparisons of REALs that are not exact."""

    def __init__(self, points: Sequence[Point], values: Values) -> None:
        self._values = values
        self._divisors: set[str] = set()  # keys of numbers that the program divides by
        self._calculated: set[tuple[str, str]] = set()  # memory of results such as SCP's
        # by memory in add-on instructions: the expressions written to it, None for an unknown value
        self._in_frames: dict[tuple[str, str], list[Resolved | None]] = {}
        for point in points:
            self._divisors.update(key_of(part) for part in divisors_of(point.step) if isinstance(part, Place))
            self._calculated.update(map(_memory, _results(point.step)))
            target = point.target
            if target is not None and target.frame:
                self._in_frames.setdefault(_memory(target), []).append(written_value(point.step))

    def is_inexact(self, left: Resolved, relation: str, right: Resolved) -> bool:
        """Whether one of two compared operands is a REAL that is not exact."""
        sides = (left, right)
        has_zero = any(map(is_zero, sides))
        has_divisor = any(isinstance(side, Place) and key_of(side) in self._divisors for side in sides)
        if not any(map(_is_real, sides)) or (has_zero and (relation == "<>" or has_divisor)):
            return False
        if all(map(self._is_chosen, sides)) or all(map(self._is_whole, sides)):
            return False
        return not (self._copies(left, right) or self._copies(right, left))

    def _is_chosen(self, operand: Resolved, depth: int = DEPTH) -> bool:
        """Whether a value is a constant, a copy of constants, or entered by people."""
        if isinstance(operand, Constant):
            return True
        if not isinstance(operand, Place) or depth == 0:
            return False
        if operand.leaf.slot is not None or MEASURED.search(operand.leaf.path):
            return False
        if _memory(operand) in self._calculated:
            return False
        others = [source for source in self._sources(operand) if source is not None]
        return all(_is_same(source, operand) or self._is_chosen(source, depth - 1) for source in others)

    def _sources(self, operand: Place) -> Sequence[Resolved | None]:
        """Return the expressions written to a number; in an add-on instruction, only by its own routines."""
        if operand.frame:
            return self._in_frames.get(_memory(operand), ())
        return self._values.sources(operand)

    def _is_whole(self, operand: Resolved, depth: int = DEPTH) -> bool:
        """Whether a value is always a whole number, such as a sum or product of whole numbers."""
        if isinstance(operand, Constant):
            return operand.value == int(operand.value)
        if isinstance(operand, Calculation):
            return operand.name in WHOLE and all(self._is_whole(part, depth) for part in operand.operands)
        if not isinstance(operand, Place) or depth == 0:
            return False
        return operand.type.is_integer or self._gets_whole(operand, depth)

    def _gets_whole(self, operand: Place, depth: int) -> bool:
        """Whether a REAL starts with a whole number and is assigned only whole numbers."""
        sources, initial = self._sources(operand), self._values.initial(operand)
        if not sources or (initial is not None and initial.least != int(initial.least)):
            return False
        return all(
            source is not None and self._is_whole_source(source, operand, depth - 1) for source in sources
        )

    def _is_whole_source(self, source: Resolved, operand: Place, depth: int) -> bool:
        """Whether an expression is a whole number, provided that the operand is."""
        if _is_same(source, operand):
            return True
        if isinstance(source, Calculation) and source.name in WHOLE:
            return all(self._is_whole_source(part, operand, depth) for part in source.operands)
        return self._is_whole(source, depth)

    def _copies(self, copy: Resolved, source: Resolved) -> bool:
        """Whether one operand gets its value from the other."""
        if not isinstance(copy, Place) or not isinstance(source, Place):
            return False
        sources = (operand for operand in self._sources(copy) if isinstance(operand, Place))
        return key_of(source) in map(key_of, sources)


def _is_same(source: Resolved, operand: Place) -> bool:
    return isinstance(source, Place) and source.leaf is operand.leaf


def _measured(left: Resolved, right: Resolved, timers: Collection[str], analog: Collection[int]) -> str:
    """Return "an elapsed time" or "an analog input" if one of two operands is one; "" if neither is."""
    for place, number in ((left, right), (right, left)):
        if isinstance(place, Place) and place.bit is None:
            timer = path_of(place).removesuffix(".ACC")
            is_time = timer != path_of(place) and timer in timers
            if is_time and isinstance(number, Constant) and not is_zero(number):
                return "an elapsed time"
            if place.leaf.slot in analog and not place.leaf.output:
                return "an analog input"
    return ""


def _comparisons(step: LoweredStep) -> Iterator[tuple[Resolved, str, Resolved]]:
    """Yield the equality comparisons in an instruction, each as left operand, relation and right operand."""
    if step.name in ("EQU", "NEQ"):
        left, right = step.operands[:2]
        yield left, COMPARISONS[step.name], right
    for calculation in calculations_of(step, EQUALITIES):
        if len(calculation.operands) == 2:
            yield calculation.operands[0], calculation.name, calculation.operands[1]


def _is_real(operand: Resolved) -> bool:
    places = (part for part in parts_of(operand) if isinstance(part, Place))
    return any(not place.type.is_integer and not place.type.is_bool for place in places)


def _memory(place: Place) -> tuple[str, str]:
    """Return the add-on instruction and the path of a value, in capitals."""
    return place.frame, path_of(place)


def _results(step: LoweredStep) -> Iterator[Place]:
    """Yield the results of an instruction other than an operator, such as SCP or AVE."""
    if step.name not in (*COPYING, *RESULTS, "CPT"):
        for use, operand in uses_of(step):
            if use in (Use.TARGET, Use.OPTIONAL_TARGET) and isinstance(operand, Place):
                yield operand
