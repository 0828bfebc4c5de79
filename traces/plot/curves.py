"""Makers of a chart's curves, one for each kind of output."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

C_co = TypeVar("C_co", covariant=True)


class CurveMaker(Protocol[C_co]):
    """Makes a curve of values, block by block."""

    def add(self, time_ns: NDArray[np.int64], values: NDArray[Any]) -> None:
        """Add the values of a block; NaN means no value."""

    def curve(self) -> C_co:
        """Return the curve."""
