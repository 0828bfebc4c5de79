"""A named column of a trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .stream import Block

Array = NDArray[Any]


class Kind(Enum):
    """What a signal's values are."""

    BIT = "bit"
    """True or false; an array of bool."""

    WORD = "word"
    """A signed word as it stands in the image; an array of int16, or of uint32 for the CPU's flags."""

    VALUE = "value"
    """A whole number joined from two words; an array of float64, NaN where the image has none."""

    MEASURED = "measured"
    """A number that is worked out from several scans; an array of float64."""


@dataclass(frozen=True, slots=True)
class Signal:
    """A named column of a trace.

    Attributes:
        name: its public name, such as "slot1.in.COMMAND_ERROR".
        kind: what its values are.
        read: returns its values in a block, one per scan.
    """

    name: str
    kind: Kind
    read: Callable[[Block], Array]

    @property
    def path(self) -> tuple[str, ...]:
        """The parts of its name: slot, direction, name proper."""
        return tuple(self.name.split("."))


def whole_numbers(values: Array) -> tuple[Array, Array]:
    """Split values of kind VALUE into whole numbers and a mask of those that are missing.

    >>> numbers, missing = whole_numbers(np.array([4.0, np.nan]))
    >>> numbers.tolist(), missing.tolist()
    ([4, 0], [False, True])
    """
    missing = np.isnan(values)
    return np.where(missing, 0, values).astype(np.int64), missing
