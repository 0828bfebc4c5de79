"""Ranges of the numbers of a ladder program.

The range of a tag covers its initial value and all values that the program writes to it. If one of these
values is unknown or depends on the tag itself, the range is that of the type.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from operator import itemgetter
from typing import Any

from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.model.predefined.slc_types import SLC_COUNTER, SLC_TIMER
from scanrack.ladder.model.tags import Tag, tag_in
from scanrack.ladder.model.types import COUNTER, FBD_COUNTER, FBD_TIMER, TIMER, Elementary
from scanrack.ladder.state.lowered import LoweredStep

from ..groups import grouped
from ..ranges import ANY, OPERATIONS, Range, exactly, joined
from .operands import around, path_of, written_by

RESULTS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "NEG": "NEG", "ABS": "ABS"}
"""Instructions that write an operator's result to their last operand."""

COPIES = ("MOV", "TRN")
"""Instructions that write their first operand to their second one."""

ASSIGNMENTS = (":=", "[:=]", "CPT")
"""Instructions that write their second operand to their first one."""

BY_PEOPLE = re.compile(r"HMI|SCADA|PANEL|OPERATOR|RECIPE|SETPOINT", re.IGNORECASE)
"""Finds, in the names of tags, words for tags that people read and write from outside the program."""

DEPTH = 8
"""Maximum number of tags that are followed to find a value."""


def type_range(kind: Elementary) -> Range:
    """Return the range of a type."""
    if kind.is_bool:
        return Range(0, 1)
    if not kind.is_integer:
        return ANY
    return Range(kind.lowest, kind.highest)


def written_value(step: LoweredStep) -> Resolved | None:
    """Return the expression that an instruction writes to its only target; None for other instructions."""
    operands: Sequence[Any] = step.operands
    if step.name in RESULTS:
        return Calculation(RESULTS[step.name], tuple(operands[:-1]))
    if step.name == "TRN":
        return Calculation("TRN", (operands[0],))
    if step.name == "CLR":
        return Constant(0, operands[0].type)
    value: Resolved | None = None
    if step.name in COPIES:
        value = operands[0]
    elif step.name in ASSIGNMENTS:
        value = operands[1]
    return value


def target_of(step: LoweredStep) -> Place | None:
    """Return the only number that an instruction writes; None for other instructions."""
    if step.name in RESULTS or step.name in COPIES:
        target = step.operands[-1]
    elif step.name in ASSIGNMENTS or step.name == "CLR":
        target = step.operands[0]
    else:
        return None
    return target if isinstance(target, Place) else None


class Values:
    """The ranges of a program's numbers.

    Args:
        steps: all instructions of the program.
        mentions: all operands of the program.
        tags: tags by name in capitals.
        presets: values of PRE and ACC in rungs, by path in capitals and by index.
        counted: counts of FOR: path, range in the body, and the instructions that count.
    """

    def __init__(
        self,
        steps: Iterable[LoweredStep],
        mentions: Iterable[Mention],
        tags: Mapping[str, Tag],
        presets: Mapping[tuple[str, int], int | float],
        counted: Iterable[tuple[str, Range, frozenset[int]]] = (),
    ) -> None:
        self._tags = tags
        self._presets: dict[str, list[float]] = {}
        for (path, _), value in presets.items():
            self._presets.setdefault(path.upper(), []).append(value)
        self._written: dict[str, list[Resolved | None]] = {}  # by path, or by element with a fixed index
        self._elements: dict[str, set[str]] = {}  # the written elements of a path
        self._unknown: set[str] = set()  # paths and elements that also get unknown values
        all_steps = list(steps)
        for step in all_steps:
            target = target_of(step)
            if target is not None and target.bit is None and not target.frame:
                element = _element(target)
                self._written.setdefault(element, []).append(written_value(step))
                self._elements.setdefault(path_of(target), set()).add(element)
        # mentions cover all writes: those that are more than the known ones are of unknown values
        known_writes = {element: len(values) for element, values in self._written.items()}
        for mention in mentions:
            if mention.writes:
                self._note_write(mention, known_writes)
        # ranges that are final, or that are being computed: the counts of FOR to begin with
        self._ranges: dict[str, Range] = dict(_counts_of_for(all_steps, list(counted)))

    def _note_write(self, mention: Mention, known_writes: dict[str, int]) -> None:
        """Note a write of unknown values.

        Args:
            known_writes: by element, the number of writes of known values that are still to come. Each such
                write reduces it by one.
        """
        where = mention.where
        path, element = path_of(where), _element(where)
        if known_writes.get(element, 0) > 0 and isinstance(where, Place) and where.bit is None:
            known_writes[element] -= 1
        elif mention.stretch:
            self._unknown.add(path)
        elif isinstance(where, Group) and where.type in COUNTING:
            self._unknown.update(f"{path}.{name}" for name in _CHANGING)  # PRE does not change
        else:
            self._unknown.add(element)
            self._elements.setdefault(path, set()).add(element)

    def range_of(self, operand: Resolved, depth: int = DEPTH) -> Range:
        """Return the range of an operand."""
        match operand:
            case Constant():
                return exactly(operand.value)
            case Place():
                return self._place_range(operand, depth)
            case Calculation(name, operands) if name in OPERATIONS:
                value = OPERATIONS[name](*(self.range_of(part, depth) for part in operands))
                is_truncated = name == "/" and all(map(is_whole, operands))
                return OPERATIONS["TRN"](value) if is_truncated else value
        return ANY

    def choices(self, operand: Resolved) -> tuple[Range, ...]:
        """Return a tag's initial value and written constants; a single range for other operands."""
        if not isinstance(operand, Place) or operand.bit is not None or operand.leaf.slot is not None:
            return (self.range_of(operand),)
        written = self.written(operand)
        constants = [value for value in written if value.is_constant]
        if not constants or len(constants) < len(written):
            return (self.range_of(operand), *constants)
        initial = self.initial(operand)
        return tuple(constants) if initial is None else (*constants, initial)

    def written(self, place: Place) -> list[Range]:
        """Return the ranges of the values written to a number; empty if any value is unknown."""
        if self._may_be_unknown(place):
            return []
        return [ANY if value is None else self.range_of(value, DEPTH - 1) for value in self._writes(place)]

    def sources(self, place: Place) -> Sequence[Resolved | None]:
        """Return the expressions that are written to a number, with None for an unknown value."""
        if self._may_be_unknown(place) or BY_PEOPLE.search(place.leaf.path):
            return (None,)
        return self._writes(place)

    def _may_be_unknown(self, place: Place) -> bool:
        """Whether an unknown value may be written to a number."""
        path, elements = path_of(place), self._possible_elements(place)
        return self._is_in_group(path) or not self._unknown.isdisjoint((path, *elements))

    def _writes(self, place: Place) -> list[Resolved | None]:
        """Return the expressions that are written to a number's element or to a computed element."""
        keys = dict.fromkeys((path_of(place), *self._possible_elements(place)))
        return [operand for key in keys for operand in self._written.get(key, ())]

    def _possible_elements(self, place: Place) -> Iterable[str]:
        """Return the possible elements for a number: a single element, or all if its index is computed."""
        path, element = path_of(place), _element(place)
        return (element,) if element != path else sorted(self._elements.get(path, ()))

    def constants(self, path: str) -> Sequence[float] | None:
        """Return the initial values of a tag that is never written; None if it has none or is written."""
        tag = self._tags.get(path.upper())
        if tag is None or tag.initial is None or self.is_written(path) or BY_PEOPLE.search(path):
            return None
        return _numbers(tag.initial)

    def elements(self, operand: Place | Group, count: int) -> list[Range]:
        """Return the ranges of elements of a never-written array; empty if they are unknown."""
        path = path_of(operand)
        initial = self._tags[path].initial if path in self._tags and not self.is_written(path) else None
        start = operand.fixed_index if isinstance(operand, Place) else 0
        if start is None or not isinstance(initial, list):
            return []
        numbers = [value for value in initial if isinstance(value, int | float)][start : start + count]
        return [*map(exactly, numbers), *[exactly(0)] * (count - len(numbers))]

    def is_written(self, path: str) -> bool:
        """Whether an instruction writes a path."""
        path = path.upper()
        return path in self._elements or path in self._unknown or self._is_in_group(path)

    def initial(self, place: Place) -> Range | None:
        """Return the range of a number's initial values; None if it does not belong to a tag."""
        path = path_of(place)
        tag = self._tags.get(tag_in(path))
        if tag is None or place.leaf.frame:
            return None
        numbers = [*_numbers(_member(tag.initial, path[len(tag.name) + 1 :])), *self._presets.get(path, ())]
        return joined(*map(exactly, numbers)) if numbers else exactly(0)

    def _place_range(self, place: Place, depth: int) -> Range:
        """Return the range of the values that a number can have; if unknown, the range of its type."""
        limits = type_range(place.type)
        path = path_of(place)
        if depth == 0 or place.bit is not None or place.leaf.slot is not None or place.leaf.frame:
            return limits
        if path in self._ranges:
            return self._ranges[path]  # only FOR writes it
        element = _element(place)
        if element not in self._ranges:
            self._ranges[element] = limits  # used if the number depends on itself
            self._ranges[element] = self._range_from_writes(place, path, limits, depth)
        return self._ranges[element]

    def _range_from_writes(self, place: Place, path: str, limits: Range, depth: int) -> Range:
        """Return the range of a tag's initial and written values; `limits` if these are unknown."""
        initial = self.initial(place)
        if initial is None or self._may_be_unknown(place) or BY_PEOPLE.search(path):
            return limits
        writes = self._writes(place)
        ranges = [limits if value is None else self.range_of(value, depth - 1) for value in writes]
        if place.type.is_integer:
            ranges = [_rounded(range_) for range_ in ranges]
        all_values = joined(initial, *ranges)
        return all_values if all_values.within(limits.least, limits.most) else limits

    def _is_in_group(self, path: str) -> bool:
        """Whether an instruction writes a structure that contains the path."""
        return "." in path and not self._unknown.isdisjoint(around(path))


COUNTING = (TIMER, COUNTER, FBD_TIMER, FBD_COUNTER, SLC_TIMER, SLC_COUNTER)
"""Types of timers and counters."""

_CHANGING = ("ACC", "DN", "TT", "EN", "CU", "CD", "OV", "UN", "UA")
"""Members that the timer or counter instruction writes."""


def _counts_of_for(
    steps: Iterable[LoweredStep], loops: Sequence[tuple[str, Range, frozenset[int]]]
) -> Iterator[tuple[str, Range]]:
    """Yield the paths that only FOR writes, with their ranges.

    Args:
        loops: path, range and counting instructions of each FOR.
    """
    if not loops:
        return
    counting_sites = frozenset().union(*(sites for _, _, sites in loops))
    other_steps = (step for step in steps if step.site not in counting_sites)
    operands = chain.from_iterable(map(written_by, other_steps))
    written = {path_of(operand) for operand in operands if isinstance(operand, Place | Group)}
    for path, path_loops in sorted(grouped(loops, itemgetter(0)).items()):
        if path not in written:
            yield path, joined(*(range_ for _, range_, _ in path_loops))


def _element(where: Place | Group) -> str:
    """Return the path of a value, with its subscripts if all of them are constants."""
    if not isinstance(where, Place) or not where.indices or where.fixed_index is None:
        return path_of(where)
    return f"{path_of(where)}[{where.fixed_index}]"


def _member(initial: object, path: str) -> object:
    """Return the initial value at a path of members, from all elements of arrays on the path."""
    for name in path.split(".") if path else ():
        rows = initial if isinstance(initial, list) else [initial]
        initial = [value for row in rows if isinstance(row, dict) for key, value in row.items()
                   if str(key).upper() == name]  # fmt: skip
    return initial


def _numbers(initial: object) -> list[float]:
    if isinstance(initial, list):
        return [number for value in initial for number in _numbers(value)]
    return [initial] if isinstance(initial, int | float) else []


def is_whole(operand: Resolved) -> bool:
    """Whether an expression contains only integers."""
    if isinstance(operand, Constant | Place):
        return operand.type.is_integer
    return isinstance(operand, Calculation) and all(map(is_whole, operand.operands))


def _rounded(number: Range) -> Range:
    return Range(round(number.least), round(number.most)) if number.is_known else number
