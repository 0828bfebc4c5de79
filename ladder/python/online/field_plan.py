"""What an edit of a logic class does to its fields: most keep their values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import SiteError

from ..sequences.coroutine import Sequence
from ..sequences.logic import Field, Logic
from ..sequences.parts import Part
from .edition import Edition, is_plain
from .placing import foreign


class EditRefusal(SiteError):  # noqa: N818 - it is an answer
    """An edit that was refused because it might not continue correctly; nothing has changed.

    Attributes:
        sequences: the sequences that can't continue; restarting them makes the edit possible.
        refusals: the reason for each; their sites are in the running program.
    """

    sequences: tuple[str, ...] = ()
    refusals: tuple[SiteError, ...] = ()


@dataclass(frozen=True, slots=True)
class FieldPlan:
    """What an edit does to the fields of an instance."""

    values: dict[str, Any]  # fields that take a value, by name
    kept: tuple[str, ...]  # fields that keep their values
    dropped: tuple[str, ...]
    restated: tuple[str, ...]  # `rounds 7, not 5`: kept, though the class gives another initial value


def plan_fields(logic: Logic, fresh: Logic, old: Edition, new: Edition) -> FieldPlan:
    """Plan the fields of an edit; raise an EditRefusal if a field's class no longer exists."""
    present, updated = own_fields(logic), own_fields(fresh)
    before, after = body_fields(logic, old) | present, body_fields(fresh, new) | updated
    alive = new.stored | {*dir(type(fresh)), *updated}
    dropped = tuple(name for name in before if name not in alive)
    stays = [name for name in after if name in before and not _is_retyped(name, before, after, old)]
    stays += [name for name in present if name not in after and name not in dropped]
    common = before.keys() & after.keys()
    takes = [name for name in (*after, *present) if name in stays or name in updated or name in common]
    values = {
        name: _taken_over(name, before[name], old, new) if name in stays else after[name] for name in takes
    }
    return FieldPlan(values, tuple(stays), dropped, tuple(_restated(values, stays, old, new)))


def own_fields(logic: Logic) -> dict[str, Any]:
    """Return the fields that are stored in an instance itself, with their values."""
    return {
        name: value
        for name, value in vars(logic).items()
        if not name.startswith("_logic_") and name != "_places" and not isinstance(value, Part | Sequence)
    }


def body_fields(logic: Logic, edition: Edition) -> dict[str, Any]:
    """Return the initial values, from a class body, of the fields that methods assign."""
    kind = type(logic)
    values = {name: getattr(kind, name) for name in dir(kind) if name in edition.stored}
    return {name: value for name, value in values.items() if is_plain(name, value)}


def _is_retyped(name: str, before: Mapping[str, Any], after: Mapping[str, Any], old: Edition) -> bool:
    """Whether an edit gives a field a different type from that of its initial value."""
    first = getattr(old.kind, name, None)
    earlier, later = before[name] if first is None else first, after[name]
    return isinstance(earlier, Field) and isinstance(later, Field) and type(earlier) is not type(later)


def _restated(values: Mapping[str, Any], kept: list[str], old: Edition, new: Edition) -> Iterator[str]:
    """Yield the fields that keep their value although the class body now gives another."""
    for name in kept:
        earlier, later = getattr(old.kind, name, None), getattr(new.kind, name, None)
        fields = isinstance(earlier, Field) and isinstance(later, Field)
        if fields and earlier != later and values[name] != later:
            yield f"{name} {values[name]}, not {later}"


def _taken_over(name: str, value: Any, old: Edition, new: Edition) -> Any:
    """Return a field's value for the edited program; raise an EditRefusal if its class no longer exists."""
    kind = type(value)
    if isinstance(value, Enum) and kind.__module__ in old.modules:
        edited: Any = new.modules.get(kind.__module__, {}).get(kind.__qualname__)
        if isinstance(edited, type) and issubclass(edited, Enum) and value.name in edited.__members__:
            return edited[value.name]
    description = foreign(value, old)
    if description:
        raise EditRefusal(f"field {name} is {description}: its value can't be taken over")
    return value
