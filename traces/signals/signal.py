"""A named column of a trace."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from .stream import Block

Array = NDArray[Any]


class SignalKind(Enum):
    """Kind of a signal's values."""

    BIT = "bit"
    """True or false; an array of bool."""

    WORD = "word"
    """A signed word of the image; an array of int16, or of uint32 for the controller's flags."""

    VALUE = "value"
    """An integer combined from two words; an array of float64, NaN in configuration mode."""

    NUMBER = "number"
    """A number of the program; an array of the tag's own type."""

    CODE = "code"
    """An integer code for a name; an array of uint16."""

    MEASURED = "measured"
    """A number computed from several scans; an array of float64."""


@dataclass(frozen=True, slots=True)
class Signal:
    """A named column of a trace."""

    name: str  # its public name, such as "slot1.in.COMMAND_ERROR"
    kind: SignalKind
    read: Callable[[Block], Array]  # returns its values in a block, one per scan
    names: Mapping[int, str] = field(default_factory=dict)  # of kind CODE: meanings of the codes
    bits: int = 0  # of kind NUMBER: the bits of an integer; 0 for a float
    title: str = ""  # of a tag: its full name in the program, with the subscript of an element
    signed: bool = True  # of an integer: whether it is signed

    @property
    def path(self) -> tuple[str, ...]:
        """The parts of the signal's name: slot, direction, and the name itself."""
        return tuple(self.name.split("."))


def names_of(codes: Array, names: Mapping[int, str]) -> list[str]:
    """Return the names of codes; a code without a name becomes its number as text.

    >>> names_of(np.array([1, 0, 7]), {0: "IDLE", 1: "FILL"})
    ['FILL', 'IDLE', '7']
    """
    return [names.get(code, str(code)) for code in codes.tolist()]


def whole_numbers(values: Array) -> tuple[Array, Array]:
    """Return values of kind VALUE as integers (0 if missing), and a mask of the missing values.

    >>> numbers, missing = whole_numbers(np.array([4.0, np.nan]))
    >>> numbers.tolist(), missing.tolist()
    ([4, 0], [False, True])
    """
    is_missing = np.isnan(values)
    return np.where(is_missing, 0, values).astype(np.int64), is_missing
