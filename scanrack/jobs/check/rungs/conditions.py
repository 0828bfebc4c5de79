"""What an instruction or an expression of a ladder program decides, as a condition.

A bit that the program writes has another name from there on in the rung: its value may be another one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import count

from scanrack.ladder.debug.crossref import TARGETS
from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.model.operators import RELATIONS
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
from ..ranges import Range
from .number_ranges import Values, type_range

COMPARISONS = {"EQU": "=", "NEQ": "<>", "LES": "<", "LEQ": "<=", "GRT": ">", "GEQ": ">="}


EDGE = "ONS "
"""Begins the names of one-shots, whose power says nothing about their bits."""


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
class RungConditionNames:
    """The names of values, which change as the program writes them."""

    places: dict[str, Place]
    timers: frozenset[str]  # on-delay timers
    written: dict[str, int] = field(default_factory=dict)
    all: int = 0
    turns: Iterator[int] = field(default_factory=lambda: count(1))

    def of(self, place: Place) -> str:
        """Return the name of a value."""
        key = key_of(place)
        if "?" in key:
            self.forget()  # another element each time
        self.places.setdefault(key, place)
        mark = ON_DELAY if key.rpartition(".")[0] in self.timers else ""
        return f"{key}#{self.all}.{self.written.get(place.leaf.path.upper(), 0)}{mark}"

    def note(self, step: LoweredStep) -> None:
        """Give what an instruction writes another name."""
        if step.name in ("JSR", "SBR", "FOR", ADD_ON):
            self.forget()
        for use, operand in zip(step.uses, step.operands, strict=False):
            if use not in TARGETS:
                continue
            if isinstance(operand, Place):
                path = operand.leaf.path.upper()
                self.written[path] = next(self.turns)
            else:
                self.forget()

    def forget(self) -> None:
        """Give every value another name."""
        self.all = next(self.turns)

    def state(self) -> tuple[dict[str, int], int]:
        """Return the names at this place, for `go_back`."""
        return dict(self.written), self.all

    def go_back(self, state: tuple[dict[str, int], int]) -> None:
        """Go back to the names of another place."""
        self.written, self.all = dict(state[0]), state[1]


def on_delays(steps: Iterable[LoweredStep]) -> frozenset[str]:
    """Return the keys of timers that only TON and RTO run: their DN and TT are never on together."""
    timers = [
        step for step in steps if step.name in ("TON", "RTO", "TOF") and isinstance(step.operands[0], Group)
    ]
    off = {step.operands[0].text.upper() for step in timers if step.name == "TOF"}
    return frozenset(step.operands[0].text.upper() for step in timers) - off


class Conditions:
    """The conditions of a program.

    Args:
        values: ranges of the program's numbers.
        timers: keys of on-delay timers, in capitals.
    """

    def __init__(self, values: Values, timers: frozenset[str]) -> None:
        self._values, self._timers = values, timers
        self.places: dict[str, Place] = {}  # operands by their keys
        self.names = RungConditionNames(self.places, timers)

    def begin(self) -> None:
        """Begin a rung, or a routine: no value has another name yet."""
        self.names = RungConditionNames(self.places, self._timers)

    def decided(self, step: LoweredStep) -> Condition:
        """Return what an instruction decides."""
        given = step.operands
        if step.name in ("XIC", "XIO") and isinstance(given[0], Place):
            return Bit(self.names.of(given[0]), step.name == "XIC")
        if step.name in COMPARISONS:
            return self.compared(given[0], COMPARISONS[step.name], given[1])
        if step.name == "ONS" and isinstance(given[0], Place):
            self.names.forget()
            return Bit(f"{EDGE}{self.names.of(given[0])}")
        if step.name == "LIM":
            return self._limited(*given)
        if step.name in ("CMP", "IF"):
            return self.condition(given[0])
        return {"AFI": FALSE, "NOP": TRUE, "LBL": TRUE, "EXIT": TRUE, "CASE": TRUE}.get(step.name, UNKNOWN)

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
            return Bit(self.names.of(operand))
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
            return Bit(self.names.of(one), is_on) if relation in ("=", "<>") else UNKNOWN
        if isinstance(other, Constant):
            if relation in ("=", "<>") and self._is_none_of(one, other.value):
                return FixedTruth(relation == "<>")
            limits = self._limits(one)
            name = self.names.of(one) if isinstance(one, Place) else f"{one!r}#{self.names.all}"
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
