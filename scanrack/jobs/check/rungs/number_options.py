"""What a number of a ladder program may be, one option after the other: constants, tables, sums of them.

MOV(Stops[At],Target)DIV(Target,1000,O.Data[2])    word 2 is one of the thousands of `Stops`
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from scanrack.io_images.image import WORD_MAX, WORD_MIN
from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved

from ..written import UNKNOWN_WORD, WordValue
from .number_ranges import Values, is_whole

DEPTH = 8
"""Tags behind a tag."""

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
            return self._calculated(operand, [self.of(each, depth) for each in operand.operands])
        return NONE

    def _of_place(self, place: Place, depth: int) -> NumberOptions:
        path = place.leaf.path
        if place.bit is not None or place.leaf.slot is not None or place.leaf.frame:
            return NONE
        found = self._values.constants(path)
        if found is not None:
            return self._of_table(place, found)
        if place.indices or path.upper() in self._busy:
            return NONE
        self._busy.add(path.upper())
        parts = [self.of(each, depth - 1) for each in self._values.sources(place) if each is not None]
        self._busy.discard(path.upper())
        options = tuple(value for each in parts for value in each.options)[:MOST]
        names = tuple(
            name
            for each in parts
            for name in each.names or (f"{path} = {value:.10g}" for value in each.options)
        )[:MOST]
        rounded = tuple(map(round, options)) if place.type.is_integer else options
        return NumberOptions(rounded, path.upper() if len(options) > 1 else "", names)

    def _of_table(self, place: Place, found: Sequence[float]) -> NumberOptions:
        """Return the elements of a table that nothing writes."""
        values = (
            tuple(each for each in found if isinstance(each, int | float)) if isinstance(found, list) else ()
        )
        if not place.indices:
            return NumberOptions(values) if len(values) == 1 else NONE
        at = place.fixed_index
        if at is not None:
            return NumberOptions((values[at],)) if 0 <= at < len(values) else NONE
        names = tuple(f"{place.leaf.path}[{at}] = {value:.10g}" for at, value in enumerate(values))
        return NumberOptions(values[:MOST], place.text.upper() if len(values) > 1 else "", names[:MOST])

    @staticmethod
    def _calculated(operand: Calculation, parts: list[NumberOptions]) -> NumberOptions:
        """Return the results for each option of the one source in an expression."""
        several = [each for each in parts if len(each.options) > 1]
        if not all(each.options for each in parts) or len({each.source for each in several}) > 1:
            return NONE
        whole = operand.name == "/" and all(map(is_whole, operand.operands))
        results = []
        for at in range(len(several[0].options) if several else 1):
            given = [each.options[at] if len(each.options) > 1 else each.options[0] for each in parts]
            try:
                result = OPERATIONS[operand.name](*given)
            except (ArithmeticError, ValueError):
                return NONE
            results.append(math.trunc(result) if whole else result)
        first = several[0] if several else NONE
        return NumberOptions(tuple(results), first.source, first.names)
