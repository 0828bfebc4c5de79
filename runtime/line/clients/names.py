"""The names and allowed values that a client accepts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, TypeVar


class Settable(Protocol):
    """A row of a controller's table that can be set."""

    @property
    def allowed(self) -> str:
        """The allowed values, in words."""

    def allows(self, value: int) -> bool:
        """Whether a value may be sent."""


RowType = TypeVar("RowType")
SettableRow = TypeVar("SettableRow", bound=Settable)


def known(rows: Mapping[str, RowType], name: str, deed: str) -> RowType:
    """Return the row of a name that can be "read", or "set"; ValueError if the name is unknown."""
    if name not in rows:
        raise ValueError(f"{name} can't be {deed}: can be {', '.join(rows)}")
    return rows[name]


def settable(rows: Mapping[str, SettableRow], name: str, value: int) -> SettableRow:
    """Return the row of a name that can be set to a value.

    Raises:
        ValueError: the name is unknown, or the value is not allowed.
    """
    row = known(rows, name, "set")
    if not row.allows(value):
        raise ValueError(f"{name} {value}: must be {row.allowed}")
    return row
