"""Edits a logic class between two scans: fields keep their values, and sequences continue.

The instance gets the edited class, so waits, commands and lambdas that refer to it continue. An edit affects
names as follows:

| name | |
|---|---|
| a field that a method assigns | keeps its value; a new or retyped field gets its initial value |
| a constant of a class or module | has its new value in the next scan |
| a part with the same declaration, a timer or counter with another preset | keeps its state |
| a part with another declaration | restarts; a sequence that waits for it is refused |
| a sequence that waits | continues at the matching `await`, or is refused; it may be restarted instead |
| a new sequence | begins |
| a removed sequence | is closed: its `finally` runs without further awaits |
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from inspect import getattr_static
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import sites_of
from scanrack.io_images.times import seconds

from ..sequences.coroutine import Sequence
from ..sequences.logic import Logic
from ..sequences.parts import Part
from .edition import Edition
from .field_plan import EditRefusal, FieldPlan, body_fields, own_fields, plan_fields
from .fields import forced_fields, hold_forces, release
from .placing import EditContext, NotPlacedError, SequenceMove, plan_moves


@dataclass(frozen=True, slots=True)
class LogicEdit:
    """The result of an online edit of a logic class."""

    now_ns: int  # virtual time of the previous scan
    kept: tuple[str, ...]  # fields and parts that continue
    new: tuple[str, ...]
    changed: tuple[str, ...]  # fields and parts that restart, constants with a new value
    dropped: tuple[str, ...]
    continued: tuple[str, ...]  # sequences, each with the line where it waits
    restarted: tuple[str, ...]
    restated: tuple[str, ...] = ()  # kept values that differ from the class: `rounds 7, not 5`

    @property
    def keeps(self) -> str:
        """Text with the number of unchanged values."""
        return f"{len(self.kept)} fields and parts keep their values"

    @property
    def groups(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The affected names, grouped by effect."""
        return (
            ("new", self.new),
            ("changed", self.changed),
            ("gone", self.dropped),
            ("keep their value", self.restated),
            ("continue", self.continued),
            ("restart", self.restarted),
        )

    def __str__(self) -> str:
        groups = [f"{effect}: {', '.join(names)}" for effect, names in self.groups if names]
        return "; ".join([f"edited at {seconds(self.now_ns)} s, {self.keeps}", *groups])


@dataclass(slots=True)
class EditPlan:
    """A possible edit."""

    logic: Logic
    fresh: Logic  # an instance of the edited class
    old: Edition
    new: Edition
    fields: FieldPlan
    parts: PartPlan
    moves: list[SequenceMove]
    restarts: tuple[str, ...]
    edit: LogicEdit


def edit_logic(logic: Logic, fresh: Logic, restart: Collection[str] = ()) -> LogicEdit:
    """Continue an instance with the class of another instance from the next scan on.

    Args:
        logic: the instance, which has run at least one scan.
        fresh: an instance of the edited class, loaded from the edited file.
        restart: names of sequences to end, and to restart in the edited program.

    Raises:
        EditRefusal: it is not certain that the instance can continue; nothing has changed.
        ValueError: a declared place is not in the rack.
    """
    plan = plan_edit(logic, fresh, restart)
    _apply(plan)
    return plan.edit


def plan_edit(logic: Logic, fresh: Logic, restart: Collection[str] = ()) -> EditPlan:
    """Plan an edit, see `edit_logic`, without changing anything."""
    old, new = _editions(logic, fresh)
    parts = _plan_parts(logic, fresh)
    moves, continued = _plan_sequences(logic, fresh, _context(logic, parts, old, new), restart)
    fields = plan_fields(logic, fresh, old, new)
    restarts = tuple(sequence.name for sequence in fresh._logic_sequences if sequence.name in restart)
    new_names = _names_in_order(fresh, new)
    restarting = {*parts.changed, *fields.values} - {*fields.kept}
    constants = {name for name in new.constants() if f".{name}" in new.changed_from(old)}
    old_names = _names_in_order(logic, old)
    edit = LogicEdit(
        logic._logic_clock.now_ns,
        kept=(*fields.kept, *parts.kept),
        new=tuple(name for name in new_names if name not in old_names),
        changed=tuple(name for name in new_names if name in old_names and name in restarting | constants),
        dropped=tuple(name for name in old_names if name not in new_names and name not in fields.kept),
        continued=continued,
        restarted=restarts,
        restated=fields.restated,
    )
    return EditPlan(
        logic, fresh, old, new, fields=fields, parts=parts, moves=moves, restarts=restarts, edit=edit
    )


def _editions(logic: Logic, fresh: Logic) -> tuple[Edition, Edition]:
    """Return both editions of a program, and attach the edited one to the rack.

    Raises:
        EditRefusal: the editions can't be compared.
    """
    slots = logic._logic_slots
    if slots is None:
        raise EditRefusal("the program has had no scan; load it again")
    if type(logic).__name__ != type(fresh).__name__:
        raise EditRefusal(f"{type(fresh).__name__} is a different class from {type(logic).__name__}")
    if fresh._logic_slots is not slots:
        fresh.__attach_logic__(slots)
    return Edition(type(logic)), Edition(type(fresh))


def _context(logic: Logic, parts: PartPlan, old: Edition, new: Edition) -> EditContext:
    """Return the data that an edit needs to place its sequences."""
    present_parts = {part.name: part for part in logic._logic_parts}
    restarted = tuple(present_parts[name] for name in parts.changed if name in present_parts)
    dropped = tuple(part for name, part in present_parts.items() if name not in parts.parts)
    codes = frozenset(vars(logic).get("_logic_codes", ()))
    texts = vars(logic).setdefault("_logic_texts", {})
    return EditContext(old, new, codes, restarted + dropped, new.changed_from(old), texts)


def _names_in_order(logic: Logic, edition: Edition) -> list[str]:
    """Return the names of fields, constants, parts and sequences, in order of definition."""
    parts = [part.name for part in logic._logic_parts]
    sequences = [sequence.name for sequence in logic._logic_sequences]
    values = body_fields(logic, edition) | own_fields(logic) | edition.constants()
    return list(dict.fromkeys([*values, *parts, *sequences]))


# --- sequences


def _plan_sequences(
    logic: Logic, fresh: Logic, context: EditContext, restart: Collection[str]
) -> tuple[list[SequenceMove], tuple[str, ...]]:
    """Plan how the sequences continue; return their moves, and texts with the lines where they continue.

    Raises:
        EditRefusal: one or more sequences can't continue.
    """
    new_names = {fresh_sequence.name for fresh_sequence in fresh._logic_sequences}
    unknown = [name for name in restart if name not in new_names]
    if unknown:
        raise EditRefusal(f"no sequence {unknown[0]}; choose from {', '.join(sorted(new_names))}")
    moves: list[SequenceMove] = []
    errors: dict[str, NotPlacedError] = {}
    lines = []
    for sequence in logic._logic_sequences:
        if sequence.over or sequence.name in restart or sequence.name not in new_names:
            continue
        try:
            planned = plan_moves(sequence, context)
        except NotPlacedError as error:
            errors[sequence.name] = error
        else:
            moves += planned
            lines.append(_continued_text(sequence, planned))
    if errors:
        raise _refusal(errors)
    return moves, tuple(lines)


def _continued_text(sequence: Sequence, moves: list[SequenceMove]) -> str:
    """Return text with the line where a sequence continues."""
    frames = moves[0].frames
    line = frames[-1].target.point.node.lineno if frames else sequence.line
    return f"{sequence.name} at line {line}"


def _refusal(errors: Mapping[str, NotPlacedError]) -> EditRefusal:
    """Return the refusal of an edit, with the sequences that can't continue."""
    names, text = ", ".join(errors), "\n".join(map(str, errors.values()))
    sites = (site for error in errors.values() for site in sites_of(error))
    refused = EditRefusal(f"{text}\nthe edit is possible if you restart {names}", *sites)
    refused.sequences, refused.refusals = tuple(errors), tuple(errors.values())
    return refused


# --- parts


@dataclass(frozen=True, slots=True)
class PartPlan:
    """The effects of an edit on the parts of an instance."""

    parts: dict[str, Part]  # parts after the edit
    kept: tuple[str, ...]  # parts that continue
    changed: tuple[str, ...]  # parts that restart, and new parts


def _plan_parts(logic: Logic, fresh: Logic) -> PartPlan:
    """Return which parts continue, and which are new or restart because their declaration has changed."""
    present_parts = {part.name: part for part in logic._logic_parts}
    parts: dict[str, Part] = {}
    kept: list[str] = []
    changed: list[str] = []
    for part in fresh._logic_parts:
        present_part = present_parts.get(part.name)
        if present_part is not None and present_part.continues_as(part):
            parts[part.name] = present_part
            kept.append(part.name)
        else:
            parts[part.name] = part
            changed.append(part.name)
    return PartPlan(parts, tuple(kept), tuple(changed))


# --- the edit


def _apply(plan: EditPlan) -> None:
    """Give the instance the edited class, and change its fields, forces, parts and sequences in place."""
    logic, fresh = plan.logic, plan.fresh
    fields: dict[str, Any] = vars(logic)
    kind: type[Logic] = type(fresh)
    _share_modules(logic, fresh, plan.old, plan.new)
    release(type(logic), list(forced_fields(logic)))
    logic.__class__ = kind
    for name in [field for field in plan.fields.dropped if field in fields]:
        del fields[name]
    fields.update(plan.fields.values)
    logic._logic_forced = {
        name: value for name, value in forced_fields(logic).items() if fields.get(name) == value
    }
    hold_forces(logic)
    _replace_parts(plan, fields)
    sequences = _replace_sequences(plan, fields)
    logic._logic_sequences = sequences
    logic._logic_made = fresh._logic_made
    logic._logic_codes = tuple(code for move in plan.moves for code in move.move())


def _replace_parts(plan: EditPlan, attributes: dict[str, Any]) -> None:
    """Give the instance its parts after the edit; continue the kept ones, attach and reset the others."""
    logic, slots = plan.logic, plan.logic._logic_slots
    assert slots is not None, "the program has had a scan"
    for name in [name for name, value in attributes.items() if isinstance(value, Part)]:
        del attributes[name]
    fresh = {fresh_part.name: fresh_part for fresh_part in plan.fresh._logic_parts}
    for name, part in plan.parts.parts.items():
        if name in plan.parts.kept:
            part.continue_as(fresh[name])
        else:
            part.attach(slots, logic._logic_clock)
            part.reset_part()
        if not hasattr(type(part), "__get__"):
            attributes[name] = part
    logic._logic_parts = tuple(plan.parts.parts.values())
    logic._logic_take_parts(slots)


def _replace_sequences(plan: EditPlan, attributes: dict[str, Any]) -> tuple[Sequence, ...]:
    """Give the instance the sequences of the edited class; close removed sequences."""
    removed = {sequence.name: sequence for sequence in plan.logic._logic_sequences}
    sequences = []
    for fresh in plan.fresh._logic_sequences:
        sequence = removed.pop(fresh.name, None)
        method = getattr_static(type(plan.fresh), fresh.name)
        make = method.function.__get__(plan.logic)
        if sequence is None:
            sequence = fresh
            if fresh.starts:
                sequence.restart()
        sequence._make, sequence.starts = make, method.starts
        if fresh.name in plan.restarts:
            sequence.restart()
        attributes[fresh.name] = sequence
        sequences.append(sequence)
    for name, dropped in removed.items():
        attributes.pop(name, None)
        dropped.close()
    return tuple(sequences)


def _share_modules(logic: Logic, fresh: Logic, old: Edition, new: Edition) -> None:
    """Replace the globals of earlier editions, which a lambda in a wait may read, with the edited ones."""
    edited = new.modules
    for names in edited.values():
        for name, value in list(names.items()):
            if value is fresh:
                names[name] = logic
    earlier: list[dict[str, Any]] = vars(logic).setdefault("_logic_modules", [])
    for namespace in old.modules.values():
        if not any(namespace is module for module in earlier):
            earlier.append(namespace)
    for module in earlier:
        present: Mapping[str, Any] | None = edited.get(module.get("__name__", ""))
        if present is not None and present is not module:
            module.clear()
            module.update(present)
