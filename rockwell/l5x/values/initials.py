"""What all readers of values share: what starts with zero is left out, and arrays are lists of lists."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ....ladder.model.types import DataType, Elementary
from .value_texts import unsaid, value_of


@dataclass(frozen=True, slots=True)
class How:
    """How values are read.

    Attributes:
        keep: whether zeros are values, too: the type starts with something else.
        say: is told of what does not fit and is left out or cut.
    """

    keep: bool = False
    say: Callable[[str], None] = unsaid


def scalar(text: str | None, kind: Elementary, how: How) -> Any:
    """Return a value of an elementary type, None for what it starts with.

    Raises:
        ValueTextError: it is none.
    """
    if text is None:
        return None
    value = value_of(text, kind, how.say)
    return value if value or how.keep else None


def nested(values: list[Any], kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return flat values as a list per dimension; missing ones are zeros."""
    blank: Callable[[], Any] = {}.copy
    if isinstance(kind, Elementary):
        zero = kind.zero

        def blank() -> Any:
            return zero
    elif kind.is_string:
        blank = str
    flat = [blank() if each is None else each for each in values]
    for length in reversed(dims[1:]):
        flat = [flat[start : start + length] for start in range(0, len(flat), length)]
    return flat
