"""Mistakes with what several instructions share: CONTROLs, counters, bits of add-on instructions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Facts, FileLine
from .conditions import key_of
from .output_writes import path_of
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

FAMILIES: Mapping[str, str] = {
    "FFL": "FIFO",
    "FFU": "FIFO",
    "LFL": "LIFO",
    "LFU": "LIFO",
    "SQI": "SQ",
    "SQO": "SQ",
    "SQL": "SQ",
}
"""Instructions that share a CONTROL with others [1756-RM003, array (file)/shift, sequencer instructions]."""

LOADS = {"FFU": "FFL", "LFU": "LFL"}
"""By instruction that takes from a queue, the one that fills it."""


def shared(points: Placed, mentions: Sequence[Mention], facts: Facts) -> None:
    """Note the mistakes of instructions that share something.

    Args:
        mentions: all operands of the program.
    """
    _never_reset(points, mentions, facts)
    own = [(point, place) for point, place in points if point.is_rung]
    _queues(own, facts)
    _controls(own, facts)
    _counters(own, facts)
    _outputs(points, facts)


def _queues(points: Placed, facts: Facts) -> None:
    """Note queues that are filled with one CONTROL and emptied with another one."""
    filled: dict[tuple[str, str], dict[str, FileLine]] = {}
    for point, place in points:
        if point.step.name in LOADS.values():
            filled.setdefault((point.step.name, _array(point.step)), {})[_control(point.step)] = place
    for point, place in points:
        step = point.step
        others = filled.get((LOADS.get(step.name, ""), _array(step) if step.name in LOADS else ""), {})
        if others and _control(step) not in others:
            name, at = next(iter(others.items()))
            text = (
                f"{step.name} takes from {_array(step)} with {_control(step)}, and "
                f"{LOADS[step.name]} of line {at.line} fills it with {name}: they need the same CONTROL"
            )
            facts.remark("control-mixed", place, text)


def _controls(points: Placed, facts: Facts) -> None:
    """Note a CONTROL of two instructions that do not belong together."""
    first: dict[str, tuple[str, LoweredStep, FileLine]] = {}
    for point, place in points:
        control = _control(point.step)
        family = FAMILIES.get(point.step.name, f"{point.step.name} {point.step.site}")
        if not control:
            continue
        before, step, at = first.setdefault(control, (family, point.step, place))
        if before != family:
            text = f"{control} controls {point.step.name} here, and {step.name} of line {at.line}"
            facts.remark("control-mixed", place, text)


def _counters(points: Placed, facts: Facts) -> None:
    """Note a counter that counts in two rungs of a routine: each one's edge is the other one's."""
    first: dict[tuple[str, str, str], FileLine] = {}
    for point, place in points:
        group = point.step.operands[0] if point.step.name in ("CTU", "CTD") else None
        if isinstance(group, Group) and all(isinstance(each, Constant) for each in group.indices):
            key = point.routine.name, point.step.name, group.text.upper()
            at = first.setdefault(key, place)
            if at != place:
                text = (
                    f"{group.text} counts here, and in line {at.line} already: it takes one edge for another"
                )
                facts.remark("repeated-coil", place, text)


def _never_reset(points: Placed, mentions: Sequence[Mention], facts: Facts) -> None:
    """Note RTO and counters whose DN is read, and that nothing sets back: it stays on for good."""
    counting = {"RTO", "CTU", "CTD"}
    kinds: dict[str, set[str]] = {}
    for point, _ in points:
        first = point.step.operands[0] if point.step.name in counting else None
        if isinstance(first, Group):
            kinds.setdefault(first.path.upper(), set()).add(point.step.name)
    written = {
        path_of(each.where)
        for each in mentions
        if each.writes and each.site.instruction.partition("(")[0] not in counting
    }
    read = {path_of(each.where) for each in mentions if each.reads}
    for point, place in points:
        group = point.step.operands[0] if point.step.name in ("RTO", "CTU") else None
        path = group.path.upper() if isinstance(group, Group) and not group.frame else ""
        is_open = path in written or f"{path}.ACC" in written or len(kinds.get(path, ())) > 1
        names = path.split(".")
        around = any(".".join(names[:at]) in written for at in range(1, len(names)))
        if group is not None and path and f"{path}.DN" in read and not is_open and not around:
            text = f"{group.text} is never set back: once its DN is on, it stays on"
            facts.remark("latch-never-cleared", place, text)


def _outputs(points: Placed, facts: Facts) -> None:
    """Note bits that an add-on instruction writes, and a coil or another one, too."""
    first: dict[str, tuple[Point, FileLine]] = {}
    for point, place in points:
        target = point.step.operands[0] if point.step.name == "OTE" else None
        if not isinstance(target, Place) or target.can_fault or _is_input(point, target):
            continue
        before, at = first.setdefault(key_of(target), (point, place))
        if before is not point and (before.argument or point.argument):
            text = f"{target.text} is written here, and in line {at.line} already"
            facts.remark("repeated-coil", place, text)


def _is_input(point: Point, target: Place) -> bool:
    """Whether this copies an argument to an input of an add-on instruction."""
    return point.argument and target.leaf.slot is None and "." in target.leaf.path


def _control(step: LoweredStep) -> str:
    """Return the CONTROL of an instruction; "" if it has none, or a computed one."""
    return next(_controls_of(step), "")


def _controls_of(step: LoweredStep) -> Iterator[str]:
    for use, operand in zip(step.uses, step.operands, strict=False):
        is_group = use is Use.CONTROL and isinstance(operand, Group)
        if is_group and all(isinstance(each, Constant) for each in operand.indices):
            yield operand.text


def _array(step: LoweredStep) -> str:
    found = (operand.text for use, operand in zip(step.uses, step.operands, strict=False) if use is Use.ARRAY)
    return next(found, "").partition("[")[0]
