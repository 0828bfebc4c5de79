"""Counters and timers that nothing runs, and subscripts that count without a bound.

GEQ(Parts.ACC,10)        and no CTU(Parts,...) anywhere
ADD(Next,1,Next) MOV(Weight,Weights[Next])     and nothing compares Next, or takes it back

A subscript that leaves its array is a major fault of type 4, code 20.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import AddOnCall, Call

from ..facts import Access, Facts, FileLine, Variable, overlap
from ..logic import TRUE, Bit, Compare, base_of, leaves
from .accesses import FIRST_SCAN
from .conditions import EDGE, key_of
from .number_ranges import BY_PEOPLE, Values, target_of, written_value
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

RUN = {
    "COUNTER": "counts",
    "FBD_COUNTER": "counts",
    "SLC_COUNTER": "counts",
    "TIMER": "times",
    "FBD_TIMER": "times",
    "SLC_TIMER": "times",
}
"""What an instruction does with a structure of these types; without it they stay as they are."""

PART = re.compile(r"(?:\.(\w+))?((?:\[[^\]]*\])*+)")
"""A member, with the subscripts of its structure: ".DN[3]"."""

RESULTS = frozenset(("ACC", "DN", "TT", "CU", "CD", "OV", "UN", "EN"))
"""The members that running gives."""


def never_run(facts: Facts) -> None:
    """Note counters and timers whose result is read, and that nothing runs."""
    for variable, accesses in facts.by_variable():
        if variable.type in RUN and not BY_PEOPLE.search(variable.name):
            is_run(variable, accesses, facts)


def is_run(variable: Variable, accesses: Sequence[Access], facts: Facts) -> None:
    """Note a counter or timer whose result is read, and that nothing runs."""
    running = []
    for each in accesses:
        member, element = _member(each.part)
        if each.writes and not each.zero and member in ("", *RESULTS):
            running.append(element)
    for each in accesses:
        member, element = _member(each.part)
        if each.reads and member in RESULTS and not any(overlap(element, other) for other in running):
            name = (each.text or variable.name).rpartition(".")[0] or variable.name
            text = f"{each.text or variable.name} is read, and no instruction {RUN[variable.type]} {name}"
            facts.remark("never-run", each.place, text)
            return


def _member(part: str) -> tuple[str, str]:
    """Return the member of a part, and the element that it belongs to."""
    found = PART.fullmatch(part)
    return (found[1] or "", found[2]) if found else ("?", "")


BUTTONS = re.compile(r"reset|clear|start|ack|new", re.IGNORECASE)
"""In names of inputs that people press: when they do, is their choice."""


def unbounded(points: Placed, values: Values, places: Mapping[str, Place], facts: Facts) -> None:
    """Note subscripts that count up or down, and that nothing limits."""
    used: dict[str, tuple[Place, FileLine, str, int]] = {}
    for point, place in points:
        for operand in point.step.operands:
            for index, text, most in _subscripts(operand):
                used.setdefault(key_of(index), (index, place, text, most))
    if not used:
        return
    limits: dict[str, list[Point]] = {}  # what reads it, but for subscripts and its own counting
    resets: dict[str, list[Point]] = {}
    for point, _ in points:
        target = target_of(point.step)
        own = "" if target is None else key_of(target)
        source = written_value(point.step)
        is_counting = own in used and source is not None and _counts(source, own)
        for use, operand in zip(point.step.uses, point.step.operands, strict=False):
            is_target = operand is target or use is Use.TARGET
            if not is_target and not (is_counting and own in set(_read(operand))):
                for key in _read(operand):
                    limits.setdefault(key, []).append(point)
        if own in used and not is_counting and not _at_will(point, places):
            resets.setdefault(own, []).append(point)
    for key, (index, place, text, most) in used.items():
        sources = values.sources(index)
        counts = any(each is not None and _counts(each, key) for each in sources)
        if not counts or None in sources:
            continue
        if key not in limits and key not in resets:
            facts.remark(
                "subscript", place, f"{text}: {index.text} counts, and nothing keeps it within the array"
            )
        reached = _reached(key, limits.get(key, ()), resets.get(key, ()))
        if reached is not None and reached > most:
            facts.remark("subscript", place, f"{text}: {index.text} reaches {reached:g}; must be 0 to {most}")


def _reached(key: str, limits: Sequence[Point], resets: Sequence[Point]) -> float | None:
    """Return what a subscript that counts up reaches: the one comparison of it takes it back, or None."""
    if len({id(each.step) for each in limits}) != 1 or not resets:
        return None
    found = [each for each in leaves(limits[0].own) if isinstance(each, Compare)]
    if len(found) != 1 or base_of(found[0].name) != key or found[0].relation not in (">", ">=", "="):
        return None
    by_it = all(
        any(isinstance(each, Compare) and base_of(each.name) == key for each in leaves(reset.condition))
        for reset in resets
    )
    return found[0].number - (found[0].relation != ">") if by_it else None


def _subscripts(operand: object) -> Iterator[tuple[Place, str, int]]:
    """Yield the single numbers in the subscripts of an operand, with its text and the last legal one."""
    if isinstance(operand, Calculation):
        for part in operand.operands:
            yield from _subscripts(part)
    elif isinstance(operand, Place | Group):
        sizes = operand.leaf.dims if isinstance(operand, Place) else operand.array
        for at, index in enumerate(operand.indices):
            place, last = index, (sizes[at] if at < len(sizes) else sys.maxsize) - 1
            if isinstance(index, Calculation) and index.name in ("+", "-"):
                place, last = index.operands[0], sys.maxsize
            if isinstance(place, Place) and place.bit is None and not place.frame and not place.can_fault:
                yield place, operand.text, last


def _counts(source: Resolved, key: str) -> bool:
    """Whether a number becomes itself and a constant."""
    if not isinstance(source, Calculation) or source.name not in ("+", "-") or len(source.operands) != 2:
        return False
    one, other = source.operands
    pairs = ((one, other), (other, one)) if source.name == "+" else ((one, other),)
    return any(
        isinstance(a, Place) and key_of(a) == key and isinstance(b, Constant) and b.value for a, b in pairs
    )


def _read(operand: object) -> Iterator[str]:
    """Yield the keys of the numbers that an operand reads, without those in subscripts."""
    if isinstance(operand, Place):
        yield key_of(operand)
    elif isinstance(operand, Calculation):
        for each in operand.operands:
            yield from _read(each)
    elif isinstance(operand, Call | AddOnCall):
        given = operand.inputs if isinstance(operand, Call) else operand.handed.values()
        for each in given:
            yield from _read(each)


def _at_will(point: Point, places: Mapping[str, Place]) -> bool:
    """Whether an instruction only acts in the first scan, or when a person presses a button."""
    parts = [each for each in leaves(point.condition) if each != TRUE]
    bits = [each for each in parts if isinstance(each, Bit) and not each.name.startswith(EDGE)]
    if any(each.on and each.name.startswith(FIRST_SCAN) for each in bits):
        return True
    return bool(bits) and all(
        isinstance(each, Bit) and (each.name.startswith(EDGE) or _is_button(places.get(base_of(each.name))))
        for each in parts
    )


def _is_button(place: Place | None) -> bool:
    return (
        place is not None
        and place.leaf.slot is not None
        and not place.leaf.output
        and BUTTONS.search(place.text) is not None
    )
