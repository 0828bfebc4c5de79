"""The individual values that a number in a ladder program can have: constants, tables, calculations.

MOV(Stops[At],Target)DIV(Target,1000,O.Data[2])    word 2 is one of the thousands of `Stops`
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from scanrack.io_images.image import WORD_MAX, WORD_MIN
from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved

from ..choices import UNKNOWN_CHOICES, Choices, combined
from .number_ranges import Values, is_whole
from .operands import path_of

DEPTH = 8
"""Maximum number of tags that are followed to find a value."""

MOST = 64
"""Maximum number of options."""


OPERATIONS: Mapping[str, Callable[..., float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "MOD": math.fmod,
    "NEG": lambda a: -a,
    "ABS": abs,
    "TRN": math.trunc,
    "TRUNC": math.trunc,
}
"""Operators and functions by name [1756-RM003: DIV of integers truncates, MOD has the dividend's sign]."""


class OperandOptions:
    """The possible values of a program's numbers."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._busy: set[str] = set()

    def word(self, operand: Resolved | None) -> Choices:
        """Return the possible values of a word."""
        choices = UNKNOWN_CHOICES if operand is None else self.evaluate(operand)
        options = tuple(map(round, choices.options))
        if not options or not all(WORD_MIN <= option <= WORD_MAX for option in options):
            return UNKNOWN_CHOICES
        return Choices(options, choices.source, choices.names)

    def evaluate(self, operand: Resolved, depth: int = DEPTH) -> Choices:
        """Return the options of an operand; none if the program does not determine them."""
        if isinstance(operand, Constant):
            return Choices((operand.value,))
        if isinstance(operand, Place) and depth:
            return self._evaluate_place(operand, depth)
        if isinstance(operand, Calculation) and operand.name in OPERATIONS:
            return _calculated(operand, [self.evaluate(part, depth) for part in operand.operands])
        return UNKNOWN_CHOICES

    def _evaluate_place(self, place: Place, depth: int) -> Choices:
        """Return the options of a number: elements of its constant table, or the values written to it."""
        path = path_of(place)
        if place.bit is not None or place.leaf.slot is not None or place.leaf.frame:
            return UNKNOWN_CHOICES
        constants = self._values.constants(path)
        if constants is not None:
            return _table_elements(place, constants)
        if place.indices or path in self._busy:
            return UNKNOWN_CHOICES
        self._busy.add(path)  # a number that depends on itself adds no options
        sources = [source for source in self._values.sources(place) if source is not None]
        written = [self.evaluate(source, depth - 1) for source in sources]
        self._busy.discard(path)
        return _joined(place, written)


def _joined(place: Place, written: Sequence[Choices]) -> Choices:
    """Return the options of a number that can have any of the written values, each option with a name."""
    options = [value for choices in written for value in choices.options][:MOST]
    names = [
        name for choices in written for name in choices.names or _names(place.leaf.path, choices.options)
    ]
    if place.type.is_integer:
        options = list(map(round, options))
    source = path_of(place) if len(options) > 1 else ""
    return Choices(tuple(options), source, tuple(names[:MOST]))


def _names(text: str, options: Iterable[float]) -> Iterator[str]:
    return (f"{text} = {value:.10g}" for value in options)


def _table_elements(place: Place, elements: Sequence[float]) -> Choices:
    """Return the options of an element of a table that is never written."""
    values = tuple(elements)
    if not place.indices:
        return Choices(values) if len(values) == 1 else UNKNOWN_CHOICES
    index = place.fixed_index
    if index is not None:
        return Choices((values[index],)) if 0 <= index < len(values) else UNKNOWN_CHOICES
    names = tuple(f"{place.leaf.path}[{number}] = {value:.10g}" for number, value in enumerate(values))
    return Choices(values[:MOST], place.text.upper() if len(values) > 1 else "", names[:MOST])


def _calculated(operand: Calculation, parts: Sequence[Choices]) -> Choices:
    """Return the results of an expression, one for each option of its single source."""
    choices = combined(parts, OPERATIONS[operand.name])
    if operand.name == "/" and all(map(is_whole, operand.operands)):
        return choices._replace(options=tuple(map(math.trunc, choices.options)))
    return choices
