"""Values that are compared for equality, and hardly ever are equal: REALs, running times, analog inputs.

MUL(Raw,0.1,Level); EQU(Level,10.0)     10.0 is 0.1 times 100, and in REALs not always
EQU(Wait.ACC,500)                       a scan of 10 ms goes from 495 to 505
NEQ(Wanted,Seen) MOV(Wanted,Seen)       exact: one is a copy of the other
NEQ(Span,0.0) DIV(Part,Span,Share)      exact: a divisor is tested for 0

Values that are only chosen (constants, copies, what people write) and sums of whole numbers are exact.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Facts, FileLine
from .conditions import COMPARISONS, key_of
from .number_ranges import RESULTS, Values, target_of, written_value
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

TIMERS = ("TON", "TOF", "RTO", "TONR", "TOFR", "RTOR")

EQUALITIES = ("=", "<>")
WHOLE = ("+", "-", "*", "NEG", "ABS")
"""Operators whose result is whole if their operands are."""

COPYING = ("COP", "CPS", "FLL", "MOV", ":=", "[:=]", "CLR")
"""Instructions that give a value as it is."""

MEASURED = re.compile(r":I\b", re.IGNORECASE)
"""In paths of inputs of a module that is not simulated, such as Local:7:I.Ch0Data."""

DEPTH = 8


def note_reals(
    points: Placed,
    values: Values,
    analog: Collection[int],
    facts: Facts,
    written: Callable[[LoweredStep], str],
) -> None:
    """Note the comparisons of a calculated REAL, a running time or an analog input for equality.

    Args:
        analog: slots of cards with analog inputs.
        written: returns an instruction as it is written.
    """
    reals = _Reals(points, values)
    timers = {
        point.step.operands[0].path.upper()
        for point, _ in points
        if point.step.name in TIMERS and isinstance(point.step.operands[0], Group)
    }
    for point, place in points:
        for one, relation, other in _comparisons(point.step):
            what = _measured(one, other, timers, analog) if relation == "=" else ""
            if not what and reals.differ(one, relation, other):
                what = "a calculated REAL"
            if what:
                says = "hardly ever equals" if relation == "=" else "nearly always differs from"
                text = f"{written(point.step)}: {what} {says} another number"
                facts.remark("real-equality", place, text)
                break


class _Reals:
    def __init__(self, points: Placed, values: Values) -> None:
        self._values = values
        self._divisors: set[str] = set()
        self._calculated: set[tuple[str, str]] = set()  # what an instruction calculates in a way of its own
        self._in_frames: dict[tuple[str, str], list[Resolved | None]] = {}
        for point, _ in points:
            self._divisors.update(_divisors(point.step))
            self._calculated.update(map(_memory, _results(point.step)))
            target = target_of(point.step)
            if target is not None and target.frame:
                self._in_frames.setdefault(_memory(target), []).append(written_value(point.step))

    def differ(self, one: Resolved, relation: str, other: Resolved) -> bool:
        """Whether two operands have a REAL among them that is not exact."""
        sides = (one, other)
        if not any(map(_is_real, sides)) or any(_is_zero(each) for each in sides if relation == "<>"):
            return False
        if any(_is_zero(each) for each in sides) and any(_key(each) in self._divisors for each in sides):
            return False
        if all(map(self._is_chosen, sides)) or all(self._is_whole(each) for each in sides):
            return False
        return not (self._copies(one, other) or self._copies(other, one))

    def _is_chosen(self, operand: Resolved, depth: int = DEPTH) -> bool:
        """Whether a value is a constant or a copy of constants, or given by people."""
        if isinstance(operand, Constant):
            return True
        if not isinstance(operand, Place) or depth == 0:
            return False
        if operand.leaf.slot is not None or MEASURED.search(operand.leaf.path):
            return False
        if _memory(operand) in self._calculated:
            return False
        return all(
            each is None or self._is_self(each, operand) or self._is_chosen(each, depth - 1)
            for each in self._sources(operand)
        )

    def _sources(self, operand: Place) -> Sequence[Resolved | None]:
        """Return what the program writes to a number; of an add-on instruction, what its routines do."""
        if operand.frame:
            return self._in_frames.get(_memory(operand), ())
        return self._values.sources(operand)

    def _is_whole(self, operand: Resolved, depth: int = DEPTH) -> bool:
        """Whether a value is a whole number: sums and products of whole numbers."""
        if isinstance(operand, Constant):
            return operand.value == int(operand.value)
        if isinstance(operand, Calculation):
            return operand.name in WHOLE and all(self._is_whole(each, depth) for each in operand.operands)
        if not isinstance(operand, Place) or depth == 0:
            return False
        if operand.type.is_integer:
            return True
        sources = self._sources(operand)
        initial = self._values.initial(operand)
        return (
            bool(sources)
            and (initial is None or initial.least == int(initial.least))
            and all(each is not None and self._is_whole_source(each, operand, depth - 1) for each in sources)
        )

    def _is_whole_source(self, source: Resolved, operand: Place, depth: int) -> bool:
        if self._is_self(source, operand):
            return True
        if isinstance(source, Calculation) and source.name in WHOLE:
            return all(self._is_whole_source(each, operand, depth) for each in source.operands)
        return self._is_whole(source, depth)

    @staticmethod
    def _is_self(source: Resolved, operand: Place) -> bool:
        return isinstance(source, Place) and source.leaf is operand.leaf

    def _copies(self, copy: Resolved, source: Resolved) -> bool:
        """Whether one operand gets the value of the other."""
        if not isinstance(copy, Place) or not isinstance(source, Place):
            return False
        sources = self._sources(copy)
        return any(isinstance(each, Place) and key_of(each) == key_of(source) for each in sources)


def _measured(one: Resolved, other: Resolved, timers: Collection[str], analog: Collection[int]) -> str:
    """Return the running time or the analog input among two operands, in words; "" without one."""
    for place, number in ((one, other), (other, one)):
        if not isinstance(place, Place) or place.bit is not None:
            continue
        path, dot, member = place.leaf.path.upper().rpartition(".")
        is_constant = isinstance(number, Constant) and bool(number.value)
        if dot and member == "ACC" and path in timers and is_constant:
            return "a running time"
        if place.leaf.slot in analog and not place.leaf.output:
            return "an analog input"
    return ""


def _comparisons(step: LoweredStep) -> Iterator[tuple[Resolved, str, Resolved]]:
    if step.name in ("EQU", "NEQ"):
        one, other = step.operands[:2]
        yield one, COMPARISONS[step.name], other
    for operand in step.operands:
        yield from _equalities(operand)


def _equalities(operand: object) -> Iterator[tuple[Resolved, str, Resolved]]:
    if isinstance(operand, Calculation):
        if operand.name in EQUALITIES and len(operand.operands) == 2:
            yield operand.operands[0], operand.name, operand.operands[1]
        for each in operand.operands:
            yield from _equalities(each)


def _is_real(operand: Resolved) -> bool:
    if isinstance(operand, Calculation):
        return any(map(_is_real, operand.operands))
    return isinstance(operand, Place) and not operand.type.is_integer and not operand.type.is_bool


def _is_zero(operand: Resolved) -> bool:
    return isinstance(operand, Constant) and not operand.value


def _key(operand: Resolved) -> str:
    return key_of(operand) if isinstance(operand, Place) else ""


def _divisors(step: LoweredStep) -> Iterator[str]:
    if step.name in ("DIV", "MOD") and isinstance(step.operands[1], Place):
        yield key_of(step.operands[1])
    for operand in step.operands:
        yield from _dividing(operand)


def _dividing(operand: object) -> Iterator[str]:
    if isinstance(operand, Calculation):
        if operand.name in ("/", "MOD") and isinstance(operand.operands[1], Place):
            yield key_of(operand.operands[1])
        for each in operand.operands:
            yield from _dividing(each)


def _memory(place: Place) -> tuple[str, str]:
    """Return the add-on instruction and the path of a value, in capitals."""
    return place.frame, place.leaf.path.upper()


def _results(step: LoweredStep) -> Iterator[Place]:
    """Yield what an instruction calculates that is no operator, such as SCP or AVE."""
    if step.name in (*COPYING, *RESULTS, "CPT"):
        return
    for use, operand in zip(step.uses, step.operands, strict=False):
        if use.name in ("TARGET", "OPTIONAL_TARGET") and isinstance(operand, Place):
            yield operand
