"""Counters and timers that no instruction runs, and subscripts that count without a bound.

GEQ(Parts.ACC,10)        but no CTU(Parts,...) anywhere
ADD(Next,1,Next) MOV(Weight,Weights[Next])     but nothing compares or resets Next

A subscript out of bounds is a major fault, type 4, code 20.
"""

from __future__ import annotations

import re
import sys
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, repeat
from typing import NamedTuple, TypeGuard

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import AddOnCall, Call

from ..facts import Access, Facts, FileLine, Variable, overlap
from ..logic import TRUE, Bit, Compare, Condition, base_of, compares, leaves
from .accesses import in_first_scan
from .conditions import EDGE
from .number_ranges import BY_PEOPLE, Values, written_value
from .operands import is_input, is_zero, key_of, parts_of, uses_of
from .view import LadderView
from .walk import Point

RUN = {
    "COUNTER": "counts",
    "FBD_COUNTER": "counts",
    "SLC_COUNTER": "counts",
    "TIMER": "times",
    "FBD_TIMER": "times",
    "SLC_TIMER": "times",
}
"""By type of structure: the verb for an instruction that runs it."""

PART = re.compile(r"(?:\.(\w+))?((?:\[[^\]]*\])*+)")
"""Finds the member in a part, with the subscripts of its structure: ".DN[3]"."""

RESULTS = frozenset(("ACC", "DN", "TT", "CU", "CD", "OV", "UN", "EN"))
"""Members that change while a counter or timer runs."""


def never_run(facts: Facts) -> None:
    """Note counters and timers whose result is read but that no instruction runs."""
    for variable, accesses in facts.by_variable():
        if variable.type in RUN and not BY_PEOPLE.search(variable.name):
            note_never_run(variable, accesses, facts)


def note_never_run(variable: Variable, accesses: Sequence[Access], facts: Facts) -> None:
    """Note a counter or timer if its result is read but no instruction runs it."""
    running_elements = [_member(access.part)[1] for access in accesses if _runs(access)]
    for access in accesses:
        member, element = _member(access.part)
        is_result = access.reads and member in RESULTS
        if is_result and not any(overlap(element, running) for running in running_elements):
            read = access.text or variable.name
            name = read.rpartition(".")[0] or variable.name
            text = f"{read} is read, but no instruction {RUN[variable.type]} {name}"
            facts.remark("never-run", access.place, text)
            return


def _runs(access: Access) -> bool:
    """Whether an access runs a counter or timer, or writes its result. A reset does not count."""
    return access.writes and not access.zero and _member(access.part)[0] in ("", *RESULTS)


def _member(part: str) -> tuple[str, str]:
    """Return the member in a part, and the element that it belongs to."""
    match = PART.fullmatch(part)
    return (match[1] or "", match[2]) if match else ("?", "")


BUTTONS = re.compile(r"reset|clear|start|ack|new", re.IGNORECASE)
"""Finds, in the names of inputs, words for buttons, which people may press at any time."""


def unbounded(view: LadderView, facts: Facts) -> None:
    """Note subscripts that count up or down without a limit."""
    subscripts: dict[str, Subscript] = {}
    for subscript in chain.from_iterable(map(_subscripts, view.points)):
        subscripts.setdefault(key_of(subscript.number), subscript)
    counting = [key for key, used in subscripts.items() if _only_counts(used.number, view.values)]
    limits, resets = _bounds(view.points if counting else (), subscripts, view.places)
    for key in counting:
        _note_reached(subscripts[key], limits[key], resets[key], facts)


Bounds = defaultdict[str, list[Point]]
"""Instructions by the key of a subscript."""


def _bounds(
    points: Sequence[Point], subscripts: Collection[str], places: Mapping[str, Place]
) -> tuple[Bounds, Bounds]:
    """Return the instructions that limit each subscript, and the instructions that reset it."""
    limits, resets = Bounds(list), Bounds(list)
    for point in points:
        target = key_of(point.target) if point.target is not None else ""
        is_counting = target in subscripts and _counts(written_value(point.step), target)
        for key in _limited(point, target if is_counting else ""):
            limits[key].append(point)
        if target in subscripts and not is_counting and not _at_will(point, places):
            resets[target].append(point)
    return limits, resets


class Subscript(NamedTuple):
    """A number that is used in a subscript.

    Attributes:
        number: the number.
        text: the operand that contains the subscript.
        last: the last legal value; `sys.maxsize` if it is unknown.
    """

    number: Place
    place: FileLine
    text: str
    last: int


def _only_counts(index: Place, values: Values) -> bool:
    """Whether a number counts and is assigned only known values."""
    sources = values.sources(index)
    return None not in sources and any(_counts(source, key_of(index)) for source in sources)


def _limited(point: Point, counted: str) -> Iterator[str]:
    """Yield the numbers that an instruction reads outside subscripts, in operands without `counted`."""
    for use, operand in uses_of(point.step):
        if operand is not point.target and use is not Use.TARGET:
            read = list(_read(operand))
            yield from read if counted not in read else ()


def _note_reached(
    subscript: Subscript, limits: Sequence[Point], resets: Sequence[Point], facts: Facts
) -> None:
    """Note a counting subscript if it has no limit, or if its limit is beyond its array."""
    text = f"{subscript.text}: {subscript.number.text}"
    if not limits and not resets:
        text = f"{text} counts, but nothing keeps it within the array"
        facts.remark("subscript", subscript.place, text)
    highest = _highest(key_of(subscript.number), limits, resets)
    if highest is not None and highest > subscript.last:
        text = f"{text} reaches {highest:g}: must be 0 to {subscript.last}"
        facts.remark("subscript", subscript.place, text)


def _highest(key: str, limits: Sequence[Point], resets: Sequence[Point]) -> float | None:
    """Return the value that a subscript reaches before its only comparison resets it; None if unknown."""
    is_single = len({id(limit.step) for limit in limits}) == 1
    if not is_single or not all(_tests(reset.condition, key) for reset in resets):
        return None
    match [leaf for leaf in leaves(limits[0].own) if isinstance(leaf, Compare)]:
        case [Compare(relation=">" | ">=" | "=" as relation) as limit] if resets and compares(limit, key):
            return limit.number if relation == ">" else limit.number - 1
    return None


def _tests(condition: Condition, key: str) -> bool:
    """Whether a condition compares a number."""
    return any(compares(leaf, key) for leaf in leaves(condition))


def _subscripts(point: Point) -> Iterator[Subscript]:
    """Yield the single numbers that are used in an instruction's subscripts."""
    for part in chain.from_iterable(map(parts_of, point.step.operands)):
        if isinstance(part, Place | Group):
            for number, last in _numbers(part):
                yield Subscript(number, point.place, part.text, last)


def _numbers(operand: Place | Group) -> Iterator[tuple[Place, int]]:
    """Yield the single numbers in subscripts, each with its last legal value, which is unknown for a sum."""
    sizes = operand.leaf.dims if isinstance(operand, Place) else operand.array
    for index, size in zip(operand.indices, chain(sizes, repeat(sys.maxsize)), strict=False):
        if isinstance(index, Calculation) and index.name in ("+", "-") and _is_single(index.operands[0]):
            yield index.operands[0], sys.maxsize
        elif _is_single(index):
            yield index, size - 1


def _is_single(operand: Resolved) -> TypeGuard[Place]:
    """Whether an operand is a single number of the program."""
    return isinstance(operand, Place) and operand.bit is None and not operand.frame and not operand.can_fault


def _counts(source: Resolved | None, key: str) -> bool:
    """Whether a number is assigned the sum of itself and a constant."""
    match source:
        case Calculation("+", (Constant() as increment, Place() as counted)) | Calculation(
            "+" | "-", (Place() as counted, Constant() as increment)
        ):
            return key_of(counted) == key and not is_zero(increment)
    return False


def _read(operand: object) -> Iterator[str]:
    """Yield the keys of the numbers that an operand reads, except in subscripts."""
    operands: Iterable[object] = (operand,)
    if isinstance(operand, Call | AddOnCall):
        operands = operand.inputs if isinstance(operand, Call) else operand.handed.values()
    for part in chain.from_iterable(map(parts_of, operands)):
        if isinstance(part, Place):
            yield key_of(part)


def _at_will(point: Point, places: Mapping[str, Place]) -> bool:
    """Whether an instruction acts only in the first scan or when a person presses a button."""
    parts = set(leaves(point.condition)) - {TRUE}
    bits = [part for part in parts if isinstance(part, Bit)]
    levels = [bit for bit in bits if not bit.name.startswith(EDGE)]
    is_pressed = bool(levels) and all(_is_button(level, places) for level in levels)
    return in_first_scan(levels) or (is_pressed and len(bits) == len(parts))


def _is_button(bit: Bit, places: Mapping[str, Place]) -> bool:
    place = places.get(base_of(bit.name))
    return is_input(place) and BUTTONS.search(place.text) is not None
