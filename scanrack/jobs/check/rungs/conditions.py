"""Conditions that instructions and expressions of a ladder program test.

A bit that the program writes is renamed for the rest of the rung, because its value may have changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count

from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved
from scanrack.ladder.model.operators import COMPARISONS, RELATIONS
from scanrack.ladder.state.lowered import ADD_ON, LoweredStep

from ..logic import (
    FALSE,
    MIRRORED,
    ON_DELAY,
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
from ..ranges import ANY, Range
from .number_ranges import Values, type_range
from .operands import group_of, key_of, path_of, written_by

EDGE = "ONS "
"""Prefix in the names of one-shots; their power does not show the state of their bits."""


@dataclass(slots=True)
class RungConditionNames:
    """Names of values. A name changes whenever the program writes the value.

    Attributes:
        places: operands by key.
        timers: keys of on-delay timers.
        written: number of the last write, by path.
        all: number of the last change of all names.
        turns: numbers for later writes and changes.
    """

    places: dict[str, Place]
    timers: frozenset[str]
    written: dict[str, int] = field(default_factory=dict)
    all: int = 0
    turns: Iterator[int] = field(default_factory=lambda: count(1))

    def name_of(self, place: Place) -> str:
        """Return the name of a value."""
        key = key_of(place)
        if "?" in key:
            self.forget()  # it may be another element each time
        self.places.setdefault(key, place)
        mark = ON_DELAY if key.rpartition(".")[0] in self.timers else ""
        return f"{key}#{self.all}.{self.written.get(path_of(place), 0)}{mark}"

    def note(self, step: LoweredStep) -> None:
        """Rename the values that an instruction writes."""
        if step.name in ("JSR", "SBR", "FOR", ADD_ON):
            self.forget()
        for operand in written_by(step):
            if isinstance(operand, Place):
                self.written[path_of(operand)] = next(self.turns)
            else:
                self.forget()

    def forget(self) -> None:
        """Rename every value."""
        self.all = next(self.turns)

    def copy(self) -> RungConditionNames:
        """Return a copy of the current names, which later writes do not change."""
        return replace(self, written=dict(self.written))


def on_delays(steps: Iterable[LoweredStep]) -> frozenset[str]:
    """Return the keys of timers that only TON and RTO run. Their DN and TT are never on together."""
    keys: dict[bool, set[str]] = {False: set(), True: set()}  # by whether a TOF runs the timer
    for step in steps:
        timer = group_of(step, ("TON", "RTO", "TOF"))
        if timer is not None:
            keys[step.name == "TOF"].add(timer.text.upper())
    return frozenset(keys[False] - keys[True])


class Conditions:
    """Converts the instructions and expressions of a program to conditions.

    Args:
        values: ranges of the program's numbers.
        timers: keys of on-delay timers, in capitals.
    """

    def __init__(self, values: Values, timers: frozenset[str]) -> None:
        self._values, self._timers = values, timers
        self.places: dict[str, Place] = {}  # operands by key
        self.names = RungConditionNames(self.places, timers)

    def begin(self) -> None:
        """Begin a rung or routine: use the original names again."""
        self.names = RungConditionNames(self.places, self._timers)

    def decided(self, step: LoweredStep) -> Condition:
        """Return the condition that an instruction tests; UNKNOWN if it is not analyzed.

        An ONS renames every value, so its condition does not equal any earlier condition.
        """
        operands = step.operands
        if step.name in ("XIC", "XIO") and isinstance(operands[0], Place):
            return Bit(self.names.name_of(operands[0]), step.name == "XIC")
        if step.name in COMPARISONS:
            return self.compared(operands[0], COMPARISONS[step.name], operands[1])
        if step.name == "ONS" and isinstance(operands[0], Place):
            self.names.forget()
            return Bit(f"{EDGE}{self.names.name_of(operands[0])}")
        if step.name == "LIM":
            return self._limit_test(*operands)
        if step.name in ("CMP", "IF"):
            return self.condition(operands[0])
        return {"AFI": FALSE, "NOP": TRUE, "LBL": TRUE, "EXIT": TRUE, "CASE": TRUE}.get(step.name, UNKNOWN)

    def _limit_test(self, low: Resolved, test: Resolved, high: Resolved) -> Condition:
        """Return the condition of a LIM; if its low limit is above the high limit, it excludes the range."""
        if isinstance(low, Constant) and isinstance(high, Constant):
            limits = self.compared(test, ">=", low), self.compared(test, "<=", high)
            return AllOf(limits) if low.value <= high.value else AnyOf(limits)
        return UNKNOWN

    def condition(self, operand: Resolved) -> Condition:
        """Return an expression as a condition; UNKNOWN if it is not analyzed."""
        match operand:
            case Constant():
                return FixedTruth(bool(operand.value))
            case Place() if operand.type.is_bool:
                return Bit(self.names.name_of(operand))
            case Calculation(name, (left, right)) if name in RELATIONS:
                return self.compared(left, name, right)
            case Calculation("NOT", (inverted,)):
                return negated(self.condition(inverted))
            case Calculation("AND" | "OR" as name, parts):
                return (AllOf if name == "AND" else AnyOf)(tuple(map(self.condition, parts)))
        return UNKNOWN

    def compared(self, left: Resolved, relation: str, right: Resolved) -> Condition:
        """Return a comparison as a condition."""
        if isinstance(left, Constant) and not isinstance(right, Constant):
            return self.compared(right, MIRRORED[relation], left)
        if isinstance(right, Constant):
            return self._with_constant(left, relation, right.value)
        if isinstance(left, Place) and isinstance(right, Place) and key_of(left) == key_of(right):
            is_true = relation in ("=", "<=", ">=")
            return FixedTruth(is_true) if "?" not in key_of(left) and left.type.is_integer else UNKNOWN
        return UNKNOWN

    def _with_constant(self, operand: Resolved, relation: str, value: float) -> Condition:
        """Return a comparison with a constant as a condition."""
        is_equality = relation in ("=", "<>")
        if isinstance(operand, Place) and operand.type.is_bool:
            is_on = (relation == "=") == bool(value)
            return Bit(self.names.name_of(operand), is_on) if is_equality else UNKNOWN
        if is_equality and self._never_gets(operand, value):
            return FixedTruth(relation == "<>")
        if not isinstance(operand, Place | Calculation | Constant):
            return UNKNOWN
        limits = self._limits(operand)
        name = f"{operand!r}#{self.names.all}"
        if isinstance(operand, Place):
            name = self.names.name_of(operand)
        return Compare(name, relation, value, limits.least, limits.most, limits.whole)

    def _never_gets(self, operand: Resolved, value: float) -> bool:
        """Whether a number is assigned only constants, none of which equals a value."""
        choices = self._values.choices(operand) if isinstance(operand, Place) and not operand.frame else ()
        are_constants = len(choices) > 2 and all(choice.is_constant for choice in choices)
        return are_constants and all(choice.least != value for choice in choices)

    def _limits(self, operand: Resolved) -> Range:
        """Return the range of a compared number: of the constants written to it, or else of its type."""
        if isinstance(operand, Constant):
            return self._values.range_of(operand)
        if not isinstance(operand, Place):
            return ANY
        is_tag = operand.type.is_integer and operand.leaf.slot is None and not operand.frame
        written = self._values.written(operand) if is_tag and operand.bit is None else []
        gets_constants = len(written) > 1 and all(value.is_constant for value in written)
        return self._values.range_of(operand) if gets_constants else type_range(operand.type)
