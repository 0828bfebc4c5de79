"""The conditions that instructions and expressions of a ladder program test.

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
"""Prefix in the names of one-shots, whose power does not show the state of their bits."""


@dataclass(slots=True)
class RungConditionNames:
    """Names of values, which change whenever the program writes the value."""

    places: dict[str, Place]
    timers: frozenset[str]  # on-delay timers
    written: dict[str, int] = field(default_factory=dict)
    all: int = 0
    turns: Iterator[int] = field(default_factory=lambda: count(1))

    def of(self, place: Place) -> str:
        """Return the name of a value."""
        key = key_of(place)
        if "?" in key:
            self.forget()  # it may be another element each time
        self.places.setdefault(key, place)
        mark = ON_DELAY if key.rpartition(".")[0] in self.timers else ""
        return f"{key}#{self.all}.{self.written.get(path_of(place), 0)}{mark}"

    def note(self, step: LoweredStep) -> None:
        """Rename what an instruction writes."""
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
        """Return the present names, which later writes do not change."""
        return replace(self, written=dict(self.written))


def on_delays(steps: Iterable[LoweredStep]) -> frozenset[str]:
    """Return the keys of timers that are run only by TON and RTO, so that DN and TT are never on together."""
    timers = [(step.name, group_of(step, ("TON", "RTO", "TOF"))) for step in steps]
    named = [(name, timer.text.upper()) for name, timer in timers if timer is not None]
    return frozenset(text for _, text in named) - {text for name, text in named if name == "TOF"}


class Conditions:
    """Makes the conditions of a program.

    Args:
        values: ranges of the program's numbers.
        timers: keys of on-delay timers, in capitals.
    """

    def __init__(self, values: Values, timers: frozenset[str]) -> None:
        self._values, self._timers = values, timers
        self.places: dict[str, Place] = {}  # operands by key
        self.names = RungConditionNames(self.places, timers)

    def begin(self) -> None:
        """Begin a rung or routine, in which no value has been renamed."""
        self.names = RungConditionNames(self.places, self._timers)

    def decided(self, step: LoweredStep) -> Condition:
        """Return the condition that an instruction tests."""
        operands = step.operands
        if step.name in ("XIC", "XIO") and isinstance(operands[0], Place):
            return Bit(self.names.of(operands[0]), step.name == "XIC")
        if step.name in COMPARISONS:
            return self.compared(operands[0], COMPARISONS[step.name], operands[1])
        if step.name == "ONS" and isinstance(operands[0], Place):
            self.names.forget()
            return Bit(f"{EDGE}{self.names.of(operands[0])}")
        if step.name == "LIM":
            return self._limited(*operands)
        if step.name in ("CMP", "IF"):
            return self.condition(operands[0])
        return {"AFI": FALSE, "NOP": TRUE, "LBL": TRUE, "EXIT": TRUE, "CASE": TRUE}.get(step.name, UNKNOWN)

    def _limited(self, low: Resolved, test: Resolved, high: Resolved) -> Condition:
        if isinstance(low, Constant) and isinstance(high, Constant):
            limits = self.compared(test, ">=", low), self.compared(test, "<=", high)
            return AllOf(limits) if low.value <= high.value else AnyOf(limits)
        return UNKNOWN

    def condition(self, operand: Resolved) -> Condition:
        """Return an expression as a condition."""
        match operand:
            case Constant():
                return FixedTruth(bool(operand.value))
            case Place() if operand.type.is_bool:
                return Bit(self.names.of(operand))
            case Calculation(name, (one, other)) if name in RELATIONS:
                return self.compared(one, name, other)
            case Calculation("NOT", (one,)):
                return negated(self.condition(one))
            case Calculation("AND" | "OR" as name, parts):
                return (AllOf if name == "AND" else AnyOf)(tuple(map(self.condition, parts)))
        return UNKNOWN

    def compared(self, one: Resolved, relation: str, other: Resolved) -> Condition:
        """Return a comparison as a condition."""
        if isinstance(one, Constant) and not isinstance(other, Constant):
            return self.compared(other, MIRRORED[relation], one)
        if isinstance(other, Constant):
            return self._with_constant(one, relation, other.value)
        if isinstance(one, Place) and isinstance(other, Place) and key_of(one) == key_of(other):
            is_same = relation in ("=", "<=", ">=")
            return FixedTruth(is_same) if "?" not in key_of(one) and one.type.is_integer else UNKNOWN
        return UNKNOWN

    def _with_constant(self, one: Resolved, relation: str, value: float) -> Condition:
        """Return a comparison with a constant as a condition."""
        is_equality = relation in ("=", "<>")
        if isinstance(one, Place) and one.type.is_bool:
            return Bit(self.names.of(one), (relation == "=") == bool(value)) if is_equality else UNKNOWN
        if is_equality and self._is_none_of(one, value):
            return FixedTruth(relation == "<>")
        limits = self._limits(one)
        name = self.names.of(one) if isinstance(one, Place) else f"{one!r}#{self.names.all}"
        if isinstance(one, Place | Calculation | Constant):
            return Compare(name, relation, value, limits.least, limits.most, limits.whole)
        return UNKNOWN

    def _is_none_of(self, operand: Resolved, value: float) -> bool:
        """Whether a number gets only constants, all different from a value."""
        choices = self._values.choices(operand) if isinstance(operand, Place) and not operand.frame else ()
        known = len(choices) > 2 and all(choice.is_constant for choice in choices)
        return known and all(choice.least != value for choice in choices)

    def _limits(self, operand: Resolved) -> Range:
        """Return the range of a compared number: that of the constants written to it, or that of its type."""
        if isinstance(operand, Constant):
            return self._values.of(operand)
        if not isinstance(operand, Place):
            return ANY
        is_tag = operand.type.is_integer and operand.leaf.slot is None and not operand.frame
        values_written = self._values.written(operand) if is_tag and operand.bit is None else []
        is_chosen = len(values_written) > 1 and all(write.is_constant for write in values_written)
        return self._values.of(operand) if is_chosen else type_range(operand.type)
