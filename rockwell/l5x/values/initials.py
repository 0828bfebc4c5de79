"""Common parts of the value readers: zeros are omitted, and arrays are lists of lists."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from scanrack.ladder.model.types import DataType, Elementary

from .layouts import Layouts
from .value_texts import ignored, value_of


@dataclass(frozen=True, slots=True)
class ValueReading:
    """The options for reading a value, and the remarks on it."""

    keep_zeros: bool = False  # whether zeros are kept, because the type has other initial values
    remark: Callable[[str], None] = ignored  # called with a text on each omitted or truncated value
    layouts: Layouts = field(default_factory=lambda: Layouts(eights=True))
    unread: list[str] = field(default_factory=list)  # names of inner types whose memory layout is unknown


def scalar(text: str | None, kind: Elementary, reading: ValueReading) -> Any:
    """Return an elementary value; None for the type's initial value.

    Raises:
        ValueTextError: the text is not a value of the type.
    """
    if text is None:
        return None
    value = value_of(text, kind, reading.remark)
    return value if value or reading.keep_zeros else None


def nested(values: list[Any], kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return an array's values as lists of lists, with one level per dimension and zeros for None."""

    def zero() -> Any:
        if isinstance(kind, Elementary):
            return kind.zero
        return "" if kind.is_string else {}

    flat = [zero() if value is None else value for value in values]
    for length in reversed(dims[1:]):
        flat = [flat[start : start + length] for start in range(0, len(flat), length)]
    return flat
