"""Steps at many instants at once: `Segment.steps_at` of each, computed by numpy.

    instants   first_ns, first_ns + every_ns, first_ns + 2 * every_ns, ...
    steps      floor(P(k) / step), P a polynomial of the index k with whole coefficients

At constant speed the remainders fit 64 bits, and integers suffice. A ramp's do not: floats estimate its
quotients with an error below `error`; within that distance of a whole number the segment itself decides.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .segment import Segment

_INT64_ROOM = 1 << 62
_ROUNDINGS = 16
"""Units of 2**-53, per sum of its terms, by which a cubic in floats may be wrong: Horner's bound is 7."""


def steps_at_all(segment: Segment, first_ns: int, every_ns: int, count: int) -> NDArray[np.int64]:
    """Return the whole steps made since the motion began, at `count` instants `every_ns` apart."""
    terms = segment.terms(first_ns, every_ns)
    step = segment.step
    index = _indices(count)
    if terms[2:] == (0, 0) and step * (count + 1) < _INT64_ROOM:
        whole_steps, remainder = divmod(terms[0], step)
        per_instant, excess = divmod(terms[1], step)
        steps_made = whole_steps + per_instant * index
        # a division is the slowest operation
        return steps_made + (remainder + excess * index) // step if excess else steps_made
    return _estimated(segment, first_ns, every_ns, index)


@lru_cache(maxsize=4)
def _indices(count: int) -> NDArray[np.int64]:
    return np.arange(count)


def _estimated(segment: Segment, first_ns: int, every_ns: int, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the steps made, in floats; where rounding might matter, they are computed exactly."""
    terms, step = segment.terms(first_ns, every_ns), segment.step
    whole_steps, remainder = divmod(terms[0], step)
    powers = (remainder / step, *(term / step for term in terms[1:]))  # each is the float nearest to it
    k = index.astype(np.float64)
    steps = ((powers[3] * k + powers[2]) * k + powers[1]) * k + powers[0]
    highest_index = float(len(index))
    error = _ROUNDINGS * 2.0**-53 * (1 + sum(abs(power) * highest_index**n for n, power in enumerate(powers)))
    floors = np.floor(steps)
    steps_exact = floors.astype(np.int64) + whole_steps
    doubtful = (steps - floors < error) | (floors + 1 - steps < error)
    for place in np.flatnonzero(doubtful).tolist():
        steps_exact[place] = segment.steps_at(first_ns + place * every_ns)
    return steps_exact
