"""Sentences that explain a tag's value by its last change."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from scanrack.io_images.times import seconds

from ..model.operands import Constant, Group, Place, fixed_index_in
from ..model.types import HIDDEN, count_of
from ..state.lowered import LoweredProgram
from ..state.memory import element_text
from .cells import is_counted
from .crossref import Mention, overlap
from .watched import Change, shown


def changes_of(history: Iterable[Change], operand: Place | Group) -> list[Change]:
    """Return the changes in a place or in parts of a group, oldest first, without hidden members."""
    return [change for change in history if HIDDEN not in change.leaf.path and _concerns(change, operand)]


def most_relevant(changes: Sequence[Change], operand: Place | Group) -> Change | None:
    """Return the most relevant change: the last one; for a timer or counter, the last one in a status bit."""
    bits = [change for change in changes if change.leaf.type.is_bool] if is_counted(operand) else []
    ranked = bits or changes
    return ranked[-1] if ranked else None


def state_of(operand: Place | Group, value: object) -> str:
    """Describe a tag's value; a timer reads `EN = 1, TT = 1, DN = 0, ACC = 437 of PRE = 1000`."""
    if not is_counted(operand) or not isinstance(value, Mapping):
        return shown(value)
    bits = [f"{name} = {shown(bit)}" for name, bit in value.items() if isinstance(bit, bool)]
    return f"{', '.join(bits)}, ACC = {value['ACC']} of PRE = {value['PRE']}"


def _concerns(change: Change, operand: Place | Group) -> bool:
    """Return whether a change is in a group's element, or in the value or bit of a place."""
    if isinstance(operand, Group):
        leaf = change.leaf
        changed = Place(leaf, (), None, leaf.path)
        return overlap(operand, changed) and _same_element(change, operand)
    if change.leaf is not operand.leaf or change.index != (operand.fixed_index or 0):
        return False
    if not isinstance(operand.bit, Constant):
        return True
    return (int(change.before) ^ int(change.after)) >> int(operand.bit.value) & 1 == 1


def _same_element(change: Change, group: Group) -> bool:
    """Return whether a change concerns an element of the group."""
    dims = change.leaf.dims
    index = fixed_index_in(dims, group.indices)
    return index is None or change.index // count_of(dims[len(group.indices) :]) == index


def explain_unchanged(tag: str, value: object, writers: Sequence[Mention]) -> str:
    """Return a sentence about an unchanged tag and its possible writers."""
    if not writers:
        return f"{tag} is {shown(value)}: no rung writes it."
    listed = "\n".join(f"    {writer}" for writer in writers)
    return f"{tag} is {shown(value)} and has not changed while watched. Its writers:\n{listed}"


def explain_change(
    lowered: LoweredProgram, tag: str, operand: Place | Group, change: Change, value: object
) -> str:
    """Explain a tag's value: the time and rung of its last change, and the rung's false conditions."""
    head = _change_sentence(lowered, tag, operand, change)
    return f"{tag}: {state_of(operand, value)}\n{head}" if is_counted(operand) else head


def _change_sentence(lowered: LoweredProgram, tag: str, operand: Place | Group, change: Change) -> str:
    """Return the value, time and cause of a change as text; a part of a group is named by its address."""
    name = tag if isinstance(operand, Place) else _element(change)
    after: object = change.after
    if isinstance(operand, Place) and isinstance(operand.bit, Constant):
        after = bool(int(change.after) >> int(operand.bit.value) & 1)
    time_text = f"scan {change.scan:,} ({seconds(change.now_ns)} s)"
    return f"{name} is {shown(after)} since {time_text}: {explain_cause(lowered, change)}"


def explain_cause(lowered: LoweredProgram, change: Change) -> str:
    """Return the rung or statement that made a change, and its false conditions."""
    if change.site is None:
        return "it was set from outside the rungs."
    site = change.site
    instance = f" of {change.instance}" if change.instance else ""
    writer = f"{site.instruction} in routine {site.routine}{instance}, {site.place}"
    if change.mode:
        return f"{change.mode} of {writer}."
    if site.unit != "rung":
        return "\n".join(_statement_lines(change, writer))
    rung = lowered.routines[site.routine.upper()].lines[site.rung or 0].text
    lines = [f"{writer}, whose rung was {str(change.power).lower()}:", f"    {rung}"]
    if not change.power:
        lines += [f"  false was {blocker}" for blocker in change.blockers]
    return "\n".join(lines)


def _statement_lines(change: Change, head: str) -> Iterator[str]:
    """Yield a line with the values that a statement read, and a line for each condition around it."""
    values = ", ".join(f"{tag} = {shown(value)}" for tag, value in change.read)
    yield f"{head}, with {values}" if values else head
    yield from (f"  inside of {outer}" for outer in reversed(change.inside))


def _element(change: Change) -> str:
    """Return the address of the changed value, with its subscripts."""
    return element_text(change.leaf.path, change.leaf.dims, change.index)
