"""Fields of a logic class, which can be set and forced from outside like tags.

A forced field has its forced value everywhere, and assignments in the program have no effect. Once released,
it keeps that value until the program assigns another.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..sequences.logic import Field, Logic, fields_of, parts_of
from ..sequences.signals import Signal


class ForcedField:
    """A class attribute for a field that is forced in an instance; other instances keep their values."""

    def __init__(self, name: str, kind: type[Logic]) -> None:
        self._name = name
        self._class_attribute = vars(kind).get(name, self)  # the original; `self` if the class has none
        self._initial = getattr(kind, name, None)

    def __get__(self, logic: Logic | None, owner: type) -> Any:
        if logic is None:
            return self._initial
        return vars(logic).get(self._name, self._initial)

    def __set__(self, logic: Logic, value: object) -> None:
        if self._name not in forced_fields(logic):
            vars(logic)[self._name] = value

    def remove(self, kind: type[Logic]) -> None:
        """Restore the original attribute of the class."""
        if self._class_attribute is self:
            delattr(kind, self._name)
        else:
            setattr(kind, self._name, self._class_attribute)


def forced_fields(logic: Logic) -> dict[str, Field]:
    """Return the forced fields of an instance with their values."""
    forced: dict[str, Field] = vars(logic).get("_logic_forced", {})
    return forced


class Fields:
    """The fields of a program by name, such as `stations.rounds`; they can be set and forced.

    Args:
        logic: returns the program, which an edit may replace.

    Attributes:
        on_outside: called after a field is set, forced or released from outside.
    """

    def __init__(self, logic: Callable[[], Logic]) -> None:
        self._logic = logic
        self.on_outside: Callable[[], object] = lambda: None

    @property
    def forces(self) -> dict[str, Field]:
        """The forced fields by name, with their values."""
        logic = self._logic()
        prefix = type(logic).__name__.lower()
        return {f"{prefix}.{name}": value for name, value in forced_fields(logic).items()}

    @property
    def tags(self) -> Fields:
        """The fields by name."""
        return self

    def __contains__(self, name: str) -> bool:
        try:
            self._field(name)
        except ValueError:
            return False
        return True

    def __getitem__(self, name: str) -> Field:
        return fields_of(self._logic())[self._field(name)]

    def __setitem__(self, name: str, value: object) -> None:
        field = self._field(name)
        if field in forced_fields(self._logic()):
            raise ValueError(f"{name} is forced; remove the force first")
        vars(self._logic())[field] = self._fitting(field, value)
        self.on_outside()

    def force(self, name: str, value: object) -> None:
        """Force a field to a value; raise a ValueError for an unknown field or a wrong type."""
        logic, field = self._logic(), self._field(name)
        vars(logic)[field] = fitting = self._fitting(field, value)
        logic._logic_forced = {**forced_fields(logic), field: fitting}
        hold_forces(logic)
        self.on_outside()

    def address_of(self, name: str) -> str | None:
        """Return the address of an input or output of the program; None for other names."""
        logic = self._logic()
        field_name = name.removeprefix(f"{type(logic).__name__.lower()}.")
        signals = [part for part in parts_of(logic) if isinstance(part, Signal) and part.name == field_name]
        return str(signals[0].at) if signals and signals[0].at is not None else None

    def unforce(self, name: str | None = None) -> None:
        """Release a field, or all fields; raise a ValueError if it is not forced."""
        logic = self._logic()
        forced = forced_fields(logic)
        names = [self._field(name)] if name is not None else list(forced)
        if not forced.keys() >= set(names):
            raise ValueError(f"{name} is not forced; forced: {', '.join(forced) or 'none'}")
        logic._logic_forced = {field: value for field, value in forced.items() if field not in names}
        release(type(logic), names)
        self.on_outside()

    def _field(self, name: str) -> str:
        """Return the bare name of a field, given its full name; raise a ValueError if it is unknown."""
        logic = self._logic()
        owner, _, field = name.rpartition(".")
        fields = fields_of(logic)
        prefix = type(logic).__name__.lower()
        if owner != prefix or field not in fields:
            choices = ", ".join(f"{prefix}.{field_name}" for field_name in fields)
            raise ValueError(f"no field {name}; choose from {choices}")
        return field

    def _fitting(self, field: str, value: object) -> Field:
        """Return a value converted to the type of a field."""
        kind = type(fields_of(self._logic())[field])
        if kind is bool and value in (0, 1):
            return bool(value)
        if kind is float and type(value) is int:
            return float(value)
        if type(value) is not kind or not isinstance(value, Field):
            raise ValueError(f"{field} = {value!r} is not allowed; must be {kind.__name__}")
        return value


def hold_forces(logic: Logic) -> None:
    """Force the forced fields of an instance again in its current class."""
    kind = type(logic)
    for name in forced_fields(logic):
        if not isinstance(vars(kind).get(name), ForcedField):
            setattr(kind, name, ForcedField(name, kind))


def release(kind: type[Logic], names: list[str]) -> None:
    """Restore the attributes of a class for fields that were forced."""
    for name in names:
        attribute = vars(kind).get(name)
        if isinstance(attribute, ForcedField):
            attribute.remove(kind)
