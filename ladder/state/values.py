"""Checks values against elementary types."""

from __future__ import annotations

from ..model.arithmetic import real
from ..model.types import Elementary


def checked(name: str, kind: Elementary, value: object) -> bool | int | float:
    """Return a value as a tag's type stores it; raise a ValueError for a wrong type or range."""
    if kind.is_bool:
        if value in (0, 1) and isinstance(value, int):
            return bool(value)
        raise ValueError(f"{name}: {value!r} is not a BOOL: must be False or True")
    if type(value) is int and kind.is_integer and kind.lowest <= value <= kind.highest:
        return value  # most values of an export
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name}: {value!r} is not of type {kind.name}")
    if kind.is_real or kind.is_double:
        return real(value) if kind.is_real else float(value)
    if isinstance(value, float):
        raise ValueError(f"{name}: {value!r} is not of type {kind.name}: must be a whole number")
    if not kind.lowest <= value <= kind.highest:
        raise ValueError(f"{name}: {value} is out of range: must be {kind.lowest} to {kind.highest}")
    return value
