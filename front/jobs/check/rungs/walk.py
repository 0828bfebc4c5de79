"""Each instruction of a ladder program with the condition under which it acts.

    XIC(A)[XIC(B)OTL(C),XIO(B)]OTE(D);    OTL(C): A and B;   OTE(D): A and (B or not B)
    IF A THEN C := 1; END_IF;             C := 1: A

A bit that the program writes has another name from there on in the rung: its value may be another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ....ladder.debug.crossref import TARGETS
from ....ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from ....ladder.model.operators import RELATIONS
from ....ladder.model.spec import InstructionKind
from ....ladder.state.lowered import (
    ADD_ON,
    Act,
    AddOnCall,
    Arms,
    Body,
    Loop,
    LoweredLine,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)
from ..logic import (
    FALSE,
    MIRRORED,
    TRUE,
    UNKNOWN,
    AllOf,
    AnyOf,
    Bit,
    Compare,
    Condition,
    FixedTruth,
    negated,
)
from ..ranges import Range
from .values import Values, type_range

COMPARISONS = {"EQU": "=", "NEQ": "<>", "LES": "<", "LEQ": "<=", "GRT": ">", "GEQ": ">="}


EDGE = "ONS "
"""Begins the names of one-shots, whose power says nothing about their bits."""


@dataclass(frozen=True, slots=True)
class Point:
    """An instruction, and when it acts.

    Attributes:
        condition: what holds whenever it acts; of an instruction that decides, before it.
        own: what it decides itself; TRUE for an output.
        value: the condition that it assigns to a bit; TRUE for another instruction.
        argument: whether it copies an argument of an add-on instruction.
    """

    routine: LoweredRoutine
    line: LoweredLine
    step: LoweredStep
    condition: Condition
    own: Condition
    argument: bool = False
    value: Condition = TRUE

    @property
    def is_rung(self) -> bool:
        """Whether it is in a rung, not in structured text."""
        return self.routine.body is None


def key_of(place: Place) -> str:
    """Return the name of a value: equal for equal places; "?" in it where a subscript is computed."""
    indices = "".join(f"[{_fixed(each)}]" for each in place.indices)
    bit = "" if place.bit is None else f".{_fixed(place.bit)}"
    return f"{place.leaf.path.upper()}{indices}{bit}"


def part_of(place: Place | Group, tag: str) -> str:
    """Return what of a tag a place is: the rest of its path, its subscripts, its bit."""
    path = place.leaf.path if isinstance(place, Place) else place.path
    indices = "".join(f"[{_fixed(each)}]" for each in place.indices)
    bit = f".{_fixed(place.bit)}" if isinstance(place, Place) and place.bit is not None else ""
    return f"{path[len(tag) :].upper()}{indices}{bit}"


def _fixed(index: Resolved) -> str:
    return str(index.value) if isinstance(index, Constant) else "?"


@dataclass(slots=True)
class _Names:
    """The names of values, which change as the program writes them."""

    places: dict[str, Place] = field(default_factory=dict)
    written: dict[str, int] = field(default_factory=dict)
    all: int = 0

    def of(self, place: Place) -> str:
        key = key_of(place)
        if "?" in key:
            self.all += 1  # another element each time
        self.places.setdefault(key, place)
        return f"{key}#{self.all}.{self.written.get(place.leaf.path.upper(), 0)}"

    def note(self, step: LoweredStep) -> None:
        """Give what an instruction writes another name."""
        if step.name in ("JSR", "SBR", "FOR", ADD_ON):
            self.all += 1
        for use, operand in zip(step.uses, step.operands, strict=False):
            if use not in TARGETS:
                continue
            if isinstance(operand, Place):
                path = operand.leaf.path.upper()
                self.written[path] = self.written.get(path, 0) + 1
            else:
                self.all += 1


class Walker:
    """Walks over routines.

    Args:
        values: ranges of the program's numbers.
    """

    def __init__(self, values: Values) -> None:
        self._values = values
        self.places: dict[str, Place] = {}  # operands by their keys
        self._names = _Names(self.places)
        self._routine: LoweredRoutine
        self._points: list[Point] = []

    def points(self, routine: LoweredRoutine) -> list[Point]:
        """Return the points of a routine in order of execution."""
        self._routine, self._points = routine, []
        if routine.body is None:
            for line in routine.lines:
                self._names = _Names(self.places)
                self._series(line, line.nodes, TRUE)
        else:
            self._names = _Names(self.places)
            self._body(routine.body, TRUE if routine.chart is None else UNKNOWN)
        return self._points

    # --- rungs

    def _series(self, line: LoweredLine, nodes: Sequence[Node], before: Condition) -> Condition:
        """Walk over a series; return what it decides."""
        parts: list[Condition] = []
        for node in nodes:
            reached = _both(before, *parts)
            if isinstance(node, Parallel):
                legs = [self._series(line, leg, reached) for leg in node.legs]
                parts.append(AnyOf(tuple(legs)))
                continue
            parts.append(self._step(line, node, reached))
        return _both(*parts)

    def _step(self, line: LoweredLine, step: LoweredStep, reached: Condition) -> Condition:
        own = self.decided(step) if step.kind is InstructionKind.INPUT else TRUE
        for call in step.operands:
            if isinstance(call, AddOnCall):
                for copies in (*call.inputs, *call.outputs):
                    self._copies(line, copies, reached)
                own = UNKNOWN  # EnableOut
        is_bit = step.name in (":=", "[:=]") and isinstance(step.operands[1], Calculation)
        target = step.operands[0] if is_bit else None
        value: Condition = TRUE
        if isinstance(target, Place) and target.type.is_bool:
            value = self.condition(step.operands[1])
        self._points.append(Point(self._routine, line, step, reached, own, value=value))
        self._names.note(step)
        return own

    def _copies(self, line: LoweredLine, nodes: Sequence[Node], reached: Condition) -> None:
        """Note the copies of arguments, which happen on a false rung, too."""
        for node in nodes:
            if isinstance(node, LoweredStep):
                self._points.append(Point(self._routine, line, node, UNKNOWN, TRUE, argument=True))

    # --- structured text

    def _body(self, body: Body, reached: Condition) -> None:
        for each in body:
            match each:
                case Act(line):
                    self._act(line, reached)
                case Arms():
                    self._arms(each, reached)
                case Selection():
                    self._selection(each, reached)
                case Loop():
                    self._loop(each, reached)

    def _act(self, line: LoweredLine, reached: Condition) -> Condition:
        return self._series(line, line.nodes, reached)

    def _arms(self, arms: Arms, reached: Condition) -> None:
        for line, body in arms.arms:
            decided = self._act(line, reached)
            self._body(body, _both(reached, decided))
            reached = _both(reached, negated(decided))
        self._body(arms.otherwise, reached)

    def _selection(self, selection: Selection, reached: Condition) -> None:
        self._act(selection.line, reached)
        (step,) = selection.line.nodes
        assert isinstance(step, LoweredStep)
        selector, rest = step.operands[0], reached
        choices = []
        for labels, body in selection.choices:
            chosen = AnyOf(
                tuple(
                    _both(self.compared(selector, ">=", low), self.compared(selector, "<=", high))
                    for low, high in labels
                )
            )
            choices.append((_both(rest, chosen), body))
            rest = _both(rest, negated(chosen))
        for condition, body in choices:
            self._body(body, condition)
        self._body(selection.otherwise, rest)

    def _loop(self, loop: Loop, reached: Condition) -> None:
        if loop.start is not None:
            self._act(loop.start, reached)
        self._names.all += 1  # another pass has written what its body writes
        first = self._first_pass(loop)
        decided = self._act(loop.test, _both(reached, first)) if loop.test is not None else TRUE
        self._body(loop.body, _both(reached, decided) if loop.start is None else reached)
        for line in (loop.advance, loop.until):
            if line is not None:
                self._act(line, reached)
        self._names.all += 1

    def _first_pass(self, loop: Loop) -> Condition:
        """Return what holds in the first pass of FOR: the count has its first value."""
        (start,) = loop.start.nodes if loop.start is not None else (None,)
        if not isinstance(start, LoweredStep) or not isinstance(start.operands[1], Constant):
            return TRUE
        return self.compared(start.operands[0], "=", start.operands[1])

    # --- conditions

    def decided(self, step: LoweredStep) -> Condition:
        """Return what an instruction decides."""
        given = step.operands
        if step.name in ("XIC", "XIO") and isinstance(given[0], Place):
            return Bit(self._names.of(given[0]), step.name == "XIC")
        if step.name in COMPARISONS:
            return self.compared(given[0], COMPARISONS[step.name], given[1])
        if step.name == "ONS" and isinstance(given[0], Place):
            self._names.all += 1
            return Bit(f"{EDGE}{self._names.of(given[0])}")
        if step.name == "LIM":
            return self._limited(*given)
        if step.name in ("CMP", "IF"):
            return self.condition(given[0])
        return {"AFI": FALSE, "NOP": TRUE, "EXIT": TRUE, "CASE": TRUE}.get(step.name, UNKNOWN)

    def _limited(self, low: Resolved, test: Resolved, high: Resolved) -> Condition:
        if isinstance(low, Constant) and isinstance(high, Constant):
            inside = self.compared(test, ">=", low), self.compared(test, "<=", high)
            return AllOf(inside) if low.value <= high.value else AnyOf(inside)
        return UNKNOWN

    def condition(self, operand: Resolved) -> Condition:
        """Return the condition that an expression is."""
        if isinstance(operand, Constant):
            return FixedTruth(bool(operand.value))
        if isinstance(operand, Place) and operand.type.is_bool:
            return Bit(self._names.of(operand))
        if not isinstance(operand, Calculation):
            return UNKNOWN
        if operand.name in RELATIONS:
            return self.compared(operand.operands[0], operand.name, operand.operands[1])
        if operand.name not in ("AND", "OR", "NOT"):
            return UNKNOWN
        parts = tuple(map(self.condition, operand.operands))
        return (
            negated(parts[0])
            if operand.name == "NOT"
            else AllOf(parts)
            if operand.name == "AND"
            else AnyOf(parts)
        )

    def compared(self, one: Resolved, relation: str, other: Resolved) -> Condition:
        """Return the condition that a comparison is."""
        if isinstance(one, Constant) and not isinstance(other, Constant):
            return self.compared(other, MIRRORED[relation], one)
        if isinstance(one, Place) and one.type.is_bool and isinstance(other, Constant):
            is_on = (relation == "=") == bool(other.value)
            return Bit(self._names.of(one), is_on) if relation in ("=", "<>") else UNKNOWN
        if isinstance(other, Constant):
            if relation in ("=", "<>") and self._is_none_of(one, other.value):
                return FixedTruth(relation == "<>")
            limits = self._limits(one)
            name = self._names.of(one) if isinstance(one, Place) else f"{one!r}#{self._names.all}"
            if isinstance(one, Place | Calculation | Constant):
                return Compare(name, relation, other.value, limits.least, limits.most, limits.whole)
        if isinstance(one, Place) and isinstance(other, Place) and key_of(one) == key_of(other):
            is_same = relation in ("=", "<=", ">=")
            return FixedTruth(is_same) if "?" not in key_of(one) and one.type.is_integer else UNKNOWN
        return UNKNOWN

    def _is_none_of(self, operand: Resolved, value: float) -> bool:
        """Whether only other constants are written to a number."""
        choices = self._values.choices(operand) if isinstance(operand, Place) and not operand.frame else ()
        known = len(choices) > 2 and all(each.is_constant for each in choices)
        return known and all(each.least != value for each in choices)

    def _limits(self, operand: Resolved) -> Range:
        """Return the sure range of a compared number: its type's, or that of the constants written to it."""
        if not isinstance(operand, Place):
            found = self._values.of(operand) if isinstance(operand, Constant) else None
            return found or Range(-float("inf"), float("inf"), False)
        limits = type_range(operand.type)
        if (
            operand.type.is_integer
            and operand.bit is None
            and operand.leaf.slot is None
            and not operand.frame
        ):
            written = self._values.written(operand)
            if len(written) > 1 and all(each.is_constant for each in written):
                return self._values.of(operand)
        return limits


def _both(*parts: Condition) -> Condition:
    kept = tuple(each for each in parts if each != TRUE)
    return AllOf(kept) if len(kept) > 1 else kept[0] if kept else TRUE
