"""The names and values that a client accepts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, TypeVar

from .link import RefusedError


class Settable(Protocol):
    """A row of a device's table that can be set."""

    @property
    def allowed(self) -> str:
        """The allowed values, as text."""

    def allows(self, value: int) -> bool:
        """Return whether a value is allowed."""


RowType = TypeVar("RowType")
SettableRow = TypeVar("SettableRow", bound=Settable)


def row_of(rows: Mapping[str, RowType], name: str, verb: str) -> RowType:
    """Return the row for a name; raise ValueError if the name is unknown.

    Args:
        verb: "read" or "set", for the error.
    """
    if name not in rows:
        raise ValueError(f"{name} can't be {verb}; choose from {', '.join(rows)}")
    return rows[name]


def settable(rows: Mapping[str, SettableRow], name: str, value: int) -> SettableRow:
    """Return the row for a name, after checking that it can be set to a value.

    Raises:
        ValueError: the name is unknown, or the value is not allowed.
    """
    row = row_of(rows, name, "set")
    if not row.allows(value):
        raise ValueError(f"{name} {value}: must be {row.allowed}")
    return row


def check_read_back(name: str, value: int, value_read: int) -> None:
    """Raise RefusedError if the value read back differs from the value set."""
    if value_read != value:
        raise RefusedError(f"{name} was set to {value}, but reads {value_read}")
