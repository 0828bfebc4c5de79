"""Common parts of the value readers: zeros are omitted, arrays are lists of lists."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from scanrack.ladder.model.types import DataType, Elementary

from .layouts import Layouts
from .value_texts import ignored, value_of


@dataclass(frozen=True, slots=True)
class ValueReading:
    """How values are read."""

    keep: bool = False  # whether zeros are kept, because the type has other initial values
    remark: Callable[[str], None] = ignored  # called with each value that is omitted or truncated
    layouts: Layouts = field(default_factory=lambda: Layouts(eights=True))
    unread: list[str] = field(default_factory=list)  # names of types in it whose memory layout is unknown


def scalar(text: str | None, kind: Elementary, how: ValueReading) -> Any:
    """Return an elementary value; None for the type's initial value.

    Raises:
        ValueTextError: the text is no such value.
    """
    if text is None:
        return None
    value = value_of(text, kind, how.remark)
    return value if value or how.keep else None


def nested(values: list[Any], kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return flat values as a list per dimension, padded with zeros."""
    blank: Callable[[], Any] = {}.copy
    if isinstance(kind, Elementary):
        zero = kind.zero

        def blank() -> Any:
            return zero
    elif kind.is_string:
        blank = str
    flat = [blank() if value is None else value for value in values]
    for length in reversed(dims[1:]):
        flat = [flat[start : start + length] for start in range(0, len(flat), length)]
    return flat
