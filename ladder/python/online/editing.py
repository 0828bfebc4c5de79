"""An edit of a class of logic between two scans: fields keep their values, sequences continue.

The instance stays and takes the edited class; a wait, a command and a lambda that refer to it go on.
What an edit does to each name:

| name | |
|---|---|
| a field, which a method assigns | keeps its value; a new one, or one of another type, begins anew |
| a constant of class or module | has its new value from the next scan on |
| a part with the same declaration, a timer or counter with another preset | keeps its state |
| a part with another declaration | begins anew; a sequence that waits for it is refused |
| a sequence that waits | continues at the matching `await`, or is refused; it may be restarted instead |
| a new sequence | begins |
| a sequence that is gone | is closed: its `finally` runs without further awaits |
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ....io_images.site import SiteError, sites_of
from ..sequences.coroutine import Sequence
from ..sequences.logic import Field, Logic
from ..sequences.parts import Part
from ..sequences.signals import Signal, place_of
from .edition import Edition
from .fields import forced_fields, hold_forces, release
from .placing import EditContext, NotPlacedError, SequenceMove, foreign, plan_moves


class EditRefusal(SiteError):  # noqa: N818 - it is an answer
    """An edit that can't continue for certain; nothing has changed.

    Attributes:
        sequences: the sequences that can't continue; restarting them makes the edit possible.
    """

    sequences: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LogicEdit:
    """What an online edit of a class of logic has done."""

    now_ns: int  # virtual time of the previous scan
    kept: tuple[str, ...]  # fields and parts that continue
    new: tuple[str, ...]
    changed: tuple[str, ...]  # fields and parts that begin anew, constants with another value
    dropped: tuple[str, ...]
    continued: tuple[str, ...]  # sequences, each with the line where it waits
    restarted: tuple[str, ...]

    def __str__(self) -> str:
        groups = (
            ("new", self.new),
            ("changed", self.changed),
            ("gone", self.dropped),
            ("continue", self.continued),
            ("begin anew", self.restarted),
        )
        said = [f"{what}: {', '.join(names)}" for what, names in groups if names]
        text = f"edited at {self.now_ns / 1e9:g} s, {len(self.kept)} fields and parts keep their values"
        return text + "".join(f"; {each}" for each in said)


@dataclass(slots=True)
class EditPlan:
    """An edit that is possible."""

    logic: Logic
    fresh: Logic  # an instance of the edited class
    old: Edition
    new: Edition
    values: dict[str, Any]  # fields that take a value, by name
    dropped_fields: tuple[str, ...]
    parts: dict[str, Part]  # the parts from now on
    kept_parts: tuple[str, ...]
    moves: list[SequenceMove]
    restarts: tuple[str, ...]
    edit: LogicEdit


def edit_logic(logic: Logic, fresh: Logic, restart: Collection[str] = ()) -> LogicEdit:
    """Continue an instance with the class of another one, from the next scan on.

    Args:
        logic: the instance; it has had a scan.
        fresh: an instance of the edited class, loaded from the edited file.
        restart: names of sequences that end, and begin anew in the edited program.

    Raises:
        EditRefusal: it can't continue for certain; nothing has changed.
        ValueError: a declared place is not in the rack.
    """
    plan = plan_edit(logic, fresh, restart)
    _carry_out(plan)
    return plan.edit


def plan_edit(logic: Logic, fresh: Logic, restart: Collection[str] = ()) -> EditPlan:
    """Plan an edit, see `edit_logic`; nothing changes."""
    slots = logic._logic_slots
    if slots is None:
        raise EditRefusal("the program has had no scan: load it again")
    if type(logic).__name__ != type(fresh).__name__:
        raise EditRefusal(f"{type(fresh).__name__} is another class than {type(logic).__name__}")
    if fresh._logic_slots is not slots:
        fresh.__attach_logic__(slots)
    old, new = Edition(type(logic)), Edition(type(fresh))
    parts, kept, changed = _parts(logic, fresh)
    before = {each.name: each for each in logic._logic_parts}
    gone = tuple(each for name, each in before.items() if name not in parts)
    names = new.changed_from(old)
    anew = tuple(before[name] for name in changed if name in before)
    codes = frozenset(vars(logic).get("_logic_codes", ()))
    texts = vars(logic).setdefault("_logic_texts", {})
    context = EditContext(old, new, codes, anew + gone, names, texts)
    moves, continued = _sequences(logic, fresh, context, restart)
    values, fields, dropped = _fields(logic, fresh, old, new)
    restarts = tuple(each.name for each in fresh._logic_sequences if each.name in restart)
    begins = {*changed, *values} - {*fields}
    other = begins | {name for name in new.constants() if f".{name}" in names}
    known, there = _names(logic, old), _names(fresh, new)
    edit = LogicEdit(
        logic._logic_clock.now_ns,
        (*fields, *kept),
        tuple(name for name in there if name not in known),
        tuple(name for name in there if name in known and name in other),
        tuple(name for name in known if name not in there and name not in fields),
        continued,
        restarts,
    )
    return EditPlan(logic, fresh, old, new, values, dropped, parts, kept, moves, restarts, edit)


def _names(logic: Logic, edition: Edition) -> list[str]:
    """Return the names of fields, constants, parts and sequences, in order of definition."""
    parts = [each.name for each in logic._logic_parts]
    sequences = [each.name for each in logic._logic_sequences]
    values = _body_fields(logic, edition) | _own_fields(logic) | edition.constants()
    return list(dict.fromkeys([*values, *parts, *sequences]))


# --- sequences


def _sequences(
    logic: Logic, fresh: Logic, context: EditContext, restart: Collection[str]
) -> tuple[list[SequenceMove], tuple[str, ...]]:
    """Plan how the sequences continue; return their moves and sentences.

    Raises:
        EditRefusal: one or more can't.
    """
    there = {each.name for each in fresh._logic_sequences}
    unknown = [each for each in restart if each not in there]
    if unknown:
        raise EditRefusal(f"there is no sequence {unknown[0]}: {', '.join(sorted(there))}")
    moves: list[SequenceMove] = []
    errors: dict[str, NotPlacedError] = {}
    said = []
    for each in logic._logic_sequences:
        if each.over or each.name in restart or each.name not in there:
            continue
        try:
            own = plan_moves(each, context)
        except NotPlacedError as error:
            errors[each.name] = error
            continue
        moves += own
        frames = own[0].frames
        line = frames[-1].after[1].node.lineno if frames else each.line
        said.append(f"{each.name} at line {line}")
    if errors:
        names = ", ".join(errors)
        text = "\n".join(map(str, errors.values()))
        refused = EditRefusal(
            f"{text}\nthe edit is possible if {names} begins anew",
            *(site for error in errors.values() for site in sites_of(error)),
        )
        refused.sequences = tuple(errors)
        raise refused
    return moves, tuple(said)


# --- parts


def _parts(logic: Logic, fresh: Logic) -> tuple[dict[str, Part], tuple[str, ...], tuple[str, ...]]:
    """Return the parts from now on, and the names of those that continue and of those that do not."""
    before = {each.name: each for each in logic._logic_parts}
    parts: dict[str, Part] = {}
    kept: list[str] = []
    changed: list[str] = []
    for each in fresh._logic_parts:
        own = before.get(each.name)
        continues = own is not None and own.continues_as(each)
        parts[each.name] = own if own is not None and continues else each
        (kept if continues else changed).append(each.name)
    return parts, tuple(kept), tuple(changed)


# --- fields


def _fields(
    logic: Logic, fresh: Logic, old: Edition, new: Edition
) -> tuple[dict[str, Any], tuple[str, ...], tuple[str, ...]]:
    """Return the fields that take a value, the those that keep theirs, and those that are gone."""
    own, theirs = _own_fields(logic), _own_fields(fresh)
    bodies, others = _body_fields(logic, old), _body_fields(fresh, new)
    values: dict[str, Any] = {}
    kept = []
    before, after = bodies | own, others | theirs
    for name, initial in after.items():
        if name not in before:
            if name in theirs:
                values[name] = initial
            continue
        value, first = before[name], (bodies | _first_values(old, name)).get(name, before[name])
        if _is_of_another_type(first, initial):
            values[name] = initial
            continue
        kept.append(name)
        values[name] = _taken_over(name, value, old, new)
    alive = new.stored | {*dir(type(fresh)), *theirs}
    dropped = tuple(name for name in before if name not in alive)
    for name in own:
        if name not in after and name not in dropped:
            kept.append(name)
            values[name] = _taken_over(name, own[name], old, new)
    return values, tuple(kept), dropped


def _first_values(edition: Edition, name: str) -> dict[str, Any]:
    found = getattr(edition.kind, name, None)
    return {} if found is None else {name: found}


def _own_fields(logic: Logic) -> dict[str, Any]:
    return {
        name: value
        for name, value in vars(logic).items()
        if not name.startswith("_logic_") and name != "_places" and not isinstance(value, Part | Sequence)
    }


def _body_fields(logic: Logic, edition: Edition) -> dict[str, Any]:
    """Return the initial values of a class body that methods assign."""
    found = {}
    for name in dir(type(logic)):
        value = getattr(type(logic), name)
        plain = not callable(value) and not hasattr(type(value), "__get__") and not isinstance(value, Part)
        if plain and name in edition.stored and not name.startswith(("__", "_logic_")):
            found[name] = value
    return found


def _is_of_another_type(one: Any, other: Any) -> bool:
    return isinstance(one, Field) and isinstance(other, Field) and type(one) is not type(other)


def _taken_over(name: str, value: Any, old: Edition, new: Edition) -> Any:
    """Return a field's value for the edited program; an EditRefusal if it is of a class that is no more."""
    kind = type(value)
    if isinstance(value, Enum) and kind.__module__ in old.modules:
        edited: Any = new.modules.get(kind.__module__, {}).get(kind.__qualname__)
        if isinstance(edited, type) and issubclass(edited, Enum) and value.name in edited.__members__:
            return edited[value.name]
    why = foreign(value, old)
    if why:
        raise EditRefusal(f"field {name} is {why}: its value can't be taken over")
    return value


# --- the edit


def _carry_out(plan: EditPlan) -> None:
    logic, fresh = plan.logic, plan.fresh
    own: dict[str, Any] = vars(logic)
    kind: type[Logic] = type(fresh)
    _share_modules(logic, fresh, plan.old, plan.new)
    release(type(logic), list(forced_fields(logic)))
    logic.__class__ = kind
    for name in [each for each in plan.dropped_fields if each in own]:
        del own[name]
    own.update(plan.values)
    logic._logic_forced = {
        name: value for name, value in forced_fields(logic).items() if own.get(name) == value
    }
    hold_forces(logic)
    _take_parts(plan, own)
    sequences = _take_sequences(plan, own)
    logic._logic_sequences = sequences
    logic._logic_made = fresh._logic_made
    logic._logic_codes = tuple(code for each in plan.moves for code in each.move())


def _take_parts(plan: EditPlan, own: dict[str, Any]) -> None:
    logic, slots = plan.logic, plan.logic._logic_slots
    assert slots is not None, "it has had a scan"
    for name in [name for name, each in own.items() if isinstance(each, Part)]:
        del own[name]
    fresh = {each.name: each for each in plan.fresh._logic_parts}
    for name, part in plan.parts.items():
        if name in plan.kept_parts:
            part.continue_as(fresh[name])
        else:
            part.attach(slots, logic._logic_clock)
            part.reset_part()
        if not hasattr(type(part), "__get__"):
            own[name] = part
    logic._logic_parts = tuple(plan.parts.values())
    logic._places = {
        each.name: place_of(each, slots) for each in plan.parts.values() if isinstance(each, Signal)
    }
    logic._logic_take_turns()


def _take_sequences(plan: EditPlan, own: dict[str, Any]) -> tuple[Sequence, ...]:
    """Give the instance the sequences of the edited class; those that are gone are closed."""
    before = {each.name: each for each in plan.logic._logic_sequences}
    found = []
    for each in plan.fresh._logic_sequences:
        sequence = before.pop(each.name, None)
        method = vars_of(type(plan.fresh), each.name)
        make = method.function.__get__(plan.logic)
        if sequence is None:
            sequence = each
            if each.starts:
                sequence.restart()
        sequence._make, sequence.starts = make, method.starts
        if each.name in plan.restarts:
            sequence.restart()
        own[each.name] = sequence
        found.append(sequence)
    for name, gone in before.items():
        own.pop(name, None)
        gone.close()
    return tuple(found)


def vars_of(kind: type, name: str) -> Any:
    """Return an attribute of a class or its bases without binding it."""
    return next(vars(each)[name] for each in kind.__mro__ if name in vars(each))


def _share_modules(logic: Logic, fresh: Logic, old: Edition, new: Edition) -> None:
    """Let functions of earlier editions, such as a lambda in a wait, read the edited module."""
    edited = new.modules
    for names in edited.values():
        for name, value in list(names.items()):
            if value is fresh:
                names[name] = logic
    earlier: list[dict[str, Any]] = vars(logic).setdefault("_logic_modules", [])
    earlier += [each for each in old.modules.values() if not any(each is other for other in earlier)]
    for module in earlier:
        present: Mapping[str, Any] | None = edited.get(module.get("__name__", ""))
        if present is not None and present is not module:
            module.clear()
            module.update(present)
