"""Mistakes with operands that several instructions share: CONTROLs, counters, bits of add-on instructions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Group, Place
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Facts, FileLine
from .operands import around, first_of, group_of, is_fixed, key_of, path_of, uses_of
from .view import LadderView
from .walk import Point

FAMILIES: Mapping[str, str] = {
    "FFL": "FIFO",
    "FFU": "FIFO",
    "LFL": "LIFO",
    "LFU": "LIFO",
    "SQI": "SQ",
    "SQO": "SQ",
    "SQL": "SQ",
}
"""Instructions that may share a CONTROL [1756-RM003, array (file)/shift, sequencer instructions]."""

LOADS = {"FFU": "FFL", "LFU": "LFL"}
"""The instruction that loads a queue, by the instruction that unloads it."""


def shared(view: LadderView, facts: Facts) -> None:
    """Note the mistakes of instructions that share an operand."""
    _never_reset(view, facts)
    in_rungs = [point for point in view.main if point.is_rung]
    _queues(in_rungs, facts)
    _controls(in_rungs, facts)
    _counters(in_rungs, facts)
    _outputs(view.main, facts)


def _queues(points: Sequence[Point], facts: Facts) -> None:
    """Note queues that are loaded and unloaded with different CONTROLs."""
    loading: dict[tuple[str, str], dict[str, FileLine]] = {}  # by instruction and array: CONTROLs and lines
    for point in points:
        if point.step.name in LOADS.values():
            loading.setdefault((point.step.name, _array(point.step)), {})[_control(point.step)] = point.place
    for point in points:
        load, step = LOADS.get(point.step.name, ""), point.step
        controls = loading.get((load, _array(step)), {}) if load else {}
        if controls and _control(step) not in controls:
            control, place = next(iter(controls.items()))
            text = (
                f"{step.name} unloads {_array(step)} with {_control(step)}, but "
                f"{load} of line {place.line} loads it with {control}: they need the same CONTROL"
            )
            facts.remark("control-mixed", point.place, text)


def _controls(points: Sequence[Point], facts: Facts) -> None:
    """Note a CONTROL that two unrelated instructions share."""
    first_uses: dict[str, Point] = {}
    for point in points:
        control = _control(point.step)
        first = first_uses.setdefault(control, point) if control else point
        if _family(first.step) != _family(point.step):
            first_use = f"{first.step.name} of line {first.place.line}"
            text = f"{control} controls both {point.step.name} here and {first_use}"
            facts.remark("control-mixed", point.place, text)


def _family(step: LoweredStep) -> str:
    """Return the group of instructions that may share a CONTROL; any other instruction is its own group."""
    return FAMILIES.get(step.name, f"{step.name} {step.site}")


def _counters(points: Sequence[Point], facts: Facts) -> None:
    """Note a counter that counts in two rungs of a routine. Both rungs share one edge bit."""
    first_lines: dict[tuple[str, str, str], FileLine] = {}
    for point in points:
        group = group_of(point.step, ("CTU", "CTD"))
        if group is not None and is_fixed(group):
            key = point.routine.name, point.step.name, group.text.upper()
            first = first_lines.setdefault(key, point.place)
            if first != point.place:
                text = f"{group.text} counts here and already in line {first.line}: it confuses their edges"
                facts.remark("repeated-coil", point.place, text)


COUNTING = ("RTO", "CTU", "CTD")


def _never_reset(view: LadderView, facts: Facts) -> None:
    """Note RTOs and counters whose DN is read but that are never reset, so that DN stays on forever."""
    kinds: dict[str, set[str]] = {}
    groups = ((group_of(point.step, COUNTING), point) for point in view.main)
    counting = [(group, point) for group, point in groups if group is not None]
    for group, point in counting:
        kinds.setdefault(path_of(group), set()).add(point.step.name)
    paths_written = set(_written_otherwise(view.mentions))
    for group, point in counting:
        path = path_of(group)
        is_reset = len(kinds[path]) > 1 or not paths_written.isdisjoint((path, f"{path}.ACC", *around(path)))
        if point.step.name != "CTD" and not group.frame and f"{path}.DN" in view.read and not is_reset:
            text = f"{group.text} is never reset: once its DN is on, it stays on"
            facts.remark("latch-never-cleared", point.place, text)


def _written_otherwise(mentions: Sequence[Mention]) -> Iterator[str]:
    """Yield the paths that instructions other than an RTO or a counter write."""
    for mention in mentions:
        if mention.writes and mention.site.instruction.partition("(")[0] not in COUNTING:
            yield path_of(mention.where)


def _outputs(points: Sequence[Point], facts: Facts) -> None:
    """Note bits that an add-on instruction writes and that a coil or another instruction also writes."""
    first_writes: dict[str, Point] = {}
    for point in points:
        target = first_of(point.step, ("OTE",))
        if not isinstance(target, Place) or target.can_fault or _is_input(point, target):
            continue
        first = first_writes.setdefault(key_of(target), point)
        if first is not point and (first.argument or point.argument):
            text = f"{target.text} is written here and already in line {first.place.line}"
            facts.remark("repeated-coil", point.place, text)


def _is_input(point: Point, target: Place) -> bool:
    """Whether an instruction copies an argument to an input of an add-on instruction."""
    return point.argument and target.leaf.slot is None and "." in target.leaf.path


def _control(step: LoweredStep) -> str:
    """Return the CONTROL of an instruction; "" if it has none, or if its subscript is computed."""
    for use, operand in uses_of(step):
        if use is Use.CONTROL and isinstance(operand, Group) and is_fixed(operand):
            return operand.text
    return ""


def _array(step: LoweredStep) -> str:
    arrays = (operand.text for use, operand in uses_of(step) if use is Use.ARRAY)
    return next(arrays, "").partition("[")[0]
