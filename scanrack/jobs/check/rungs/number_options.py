"""What a number of a ladder program may be, one option after the other: constants, tables, sums of them.

MOV(Stops[At],Target)DIV(Target,1000,O.Data[2])    word 2 is one of the thousands of `Stops`
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice, repeat
from typing import NamedTuple

from scanrack.io_images.image import WORD_MAX, WORD_MIN
from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved

from ..written import UNKNOWN_WORD, WordValue
from .number_ranges import Values, is_whole
from .operands import path_of

DEPTH = 8
"""Levels of tags that a tag gets its value from."""

MOST = 64
"""Options that are looked at."""


class NumberOptions(NamedTuple):
    """The options of a number, and where they come from."""

    options: tuple[float, ...] = ()
    source: str = ""
    names: tuple[str, ...] = ()


NONE = NumberOptions()

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
"""Operators and functions by their names [1756-RM003: DIV of integers truncates, MOD has its sign]."""


class OperandOptions:
    """The options of a program's numbers."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._busy: set[str] = set()

    def word(self, operand: Resolved | None) -> WordValue:
        """Return what a word gets."""
        found = NONE if operand is None else self.of(operand)
        options = tuple(map(round, found.options))
        if not options or not all(WORD_MIN <= each <= WORD_MAX for each in options):
            return UNKNOWN_WORD
        return WordValue(options, found.source, found.names)

    def of(self, operand: Resolved, depth: int = DEPTH) -> NumberOptions:
        """Return the options of an operand; none if the text does not determine them."""
        if isinstance(operand, Constant):
            return NumberOptions((operand.value,))
        if isinstance(operand, Place) and depth:
            return self._of_place(operand, depth)
        if isinstance(operand, Calculation) and operand.name in OPERATIONS:
            return _calculated(operand, [self.of(each, depth) for each in operand.operands])
        return NONE

    def _of_place(self, place: Place, depth: int) -> NumberOptions:
        path = path_of(place)
        if place.bit is not None or place.leaf.slot is not None or place.leaf.frame:
            return NONE
        found = self._values.constants(path)
        if found is not None:
            return _of_table(place, found)
        if place.indices or path in self._busy:
            return NONE
        self._busy.add(path)
        parts = [self.of(each, depth - 1) for each in self._values.sources(place) if each is not None]
        self._busy.discard(path)
        return _one_of(place, parts)


def _one_of(place: Place, parts: Sequence[NumberOptions]) -> NumberOptions:
    """Return the options of a number to which one of the parts is written."""
    options = [value for each in parts for value in each.options][:MOST]
    names = [name for each in parts for name in each.names or _names(place.leaf.path, each.options)]
    if place.type.is_integer:
        options = list(map(round, options))
    source = path_of(place) if len(options) > 1 else ""
    return NumberOptions(tuple(options), source, tuple(names[:MOST]))


def _names(text: str, options: Iterable[float]) -> Iterator[str]:
    return (f"{text} = {value:.10g}" for value in options)


def _of_table(place: Place, found: Sequence[float]) -> NumberOptions:
    """Return the elements of a table that nothing writes."""
    values = tuple(found)
    if not place.indices:
        return NumberOptions(values) if len(values) == 1 else NONE
    at = place.fixed_index
    if at is not None:
        return NumberOptions((values[at],)) if 0 <= at < len(values) else NONE
    names = tuple(f"{place.leaf.path}[{number}] = {value:.10g}" for number, value in enumerate(values))
    return NumberOptions(values[:MOST], place.text.upper() if len(values) > 1 else "", names[:MOST])


def _calculated(operand: Calculation, parts: Sequence[NumberOptions]) -> NumberOptions:
    """Return the results for each option of the one source in an expression."""
    several = [each for each in parts if len(each.options) > 1]
    if not all(each.options for each in parts) or len({each.source for each in several}) > 1:
        return NONE
    first = several[0] if several else NONE
    columns = [each.options if len(each.options) > 1 else repeat(each.options[0]) for each in parts]
    rows = islice(zip(*columns, strict=False), len(first.options) or 1)
    try:
        results = tuple(OPERATIONS[operand.name](*given) for given in rows)
    except (ArithmeticError, ValueError):
        return NONE
    if operand.name == "/" and all(map(is_whole, operand.operands)):
        results = tuple(map(math.trunc, results))
    return NumberOptions(results, first.source, first.names)
