"""The effects of an edit of a logic class on its fields: most keep their values."""

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
from .placing import foreign_object_in


class EditRefusal(SiteError):  # noqa: N818 - a refusal, not a defect
    """An edit that was refused because it might not continue correctly; nothing has changed.

    Attributes:
        sequences: the sequences that can't continue; if they are restarted, the edit is possible.
        refusals: the reason for each sequence; the sites are in the running program.
    """

    sequences: tuple[str, ...] = ()
    refusals: tuple[SiteError, ...] = ()


@dataclass(frozen=True, slots=True)
class FieldPlan:
    """The effects of an edit on the fields of an instance."""

    values: dict[str, Any]  # values after the edit, by name
    kept: tuple[str, ...]  # fields that keep their values
    dropped: tuple[str, ...]
    restated: tuple[str, ...]  # kept values that differ from the class: `rounds 7, not 5`


def plan_fields(logic: Logic, fresh: Logic, old: Edition, new: Edition) -> FieldPlan:
    """Plan the fields of an edit; raise an EditRefusal if a field's class no longer exists."""
    present, updated = own_fields(logic), own_fields(fresh)
    old_values, new_values = body_fields(logic, old) | present, body_fields(fresh, new) | updated
    existing = new.stored | {*dir(type(fresh)), *updated}
    dropped = tuple(name for name in old_values if name not in existing)
    common = [name for name in new_values if name in old_values]
    kept = [name for name in common if not _is_retyped(name, old_values, new_values, old)]
    kept += [name for name in present if name not in new_values and name not in dropped]
    values: dict[str, Any] = {}
    for name in (*new_values, *present):
        if name in kept:
            values[name] = _kept_value(name, old_values[name], old, new)
        elif name in updated or name in common:
            values[name] = new_values[name]
    return FieldPlan(values, tuple(kept), dropped, tuple(_restated(values, kept, old, new)))


def own_fields(logic: Logic) -> dict[str, Any]:
    """Return the fields in an instance's `__dict__`, with their values."""
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
    """Return whether an edit changes the type of a field's initial value."""
    initial = getattr(old.kind, name, None)
    earlier, later = before[name] if initial is None else initial, after[name]
    return isinstance(earlier, Field) and isinstance(later, Field) and type(earlier) is not type(later)


def _restated(values: Mapping[str, Any], kept: list[str], old: Edition, new: Edition) -> Iterator[str]:
    """Yield a text for each kept value that differs from its initial value in the edited class."""
    for name in kept:
        earlier, later = getattr(old.kind, name, None), getattr(new.kind, name, None)
        fields = isinstance(earlier, Field) and isinstance(later, Field)
        if fields and earlier != later and values[name] != later:
            yield f"{name} {values[name]}, not {later}"


def _kept_value(name: str, value: Any, old: Edition, new: Edition) -> Any:
    """Return a kept value for the edited program; raise an EditRefusal if the value's class is gone."""
    kind = type(value)
    if isinstance(value, Enum) and kind.__module__ in old.modules:
        edited: Any = new.modules.get(kind.__module__, {}).get(kind.__qualname__)
        if isinstance(edited, type) and issubclass(edited, Enum) and value.name in edited.__members__:
            return edited[value.name]
    description = foreign_object_in(value, old)
    if description:
        raise EditRefusal(f"field {name} is {description}; its value can't be kept")
    return value
