"""Records of which a program has tens of thousands: leaves, operands, instructions, places."""

from __future__ import annotations

from dataclasses import field
from typing import TypeVar

from typing_extensions import dataclass_transform

from .dataclass import dataclass

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def record(cls: type[T]) -> type[T]:
    """Make a class a dataclass that the type checker takes for a frozen one.

    A frozen dataclass calls `object.__setattr__` for each field, which takes three times as long.

    >>> @record
    ... class Spot:
    ...     at: int
    >>> Spot(3) == Spot(3), hash(Spot(3)) == hash(Spot(3)), Spot(3)
    (True, True, Spot(at=3))
    """
    return dataclass(slots=True, unsafe_hash=True)(cls)
