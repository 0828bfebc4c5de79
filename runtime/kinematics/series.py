"""`Segment.steps_at` for many instants at once, computed by numpy.

    instants   first_ns, first_ns + every_ns, first_ns + 2 * every_ns, ...
    steps      floor(P(k) / step), where P is a polynomial of the index k with integer coefficients

At constant speed the numbers fit 64-bit integers. In a ramp they do not, so floats estimate the quotients
with an error below `error`. Quotients within `error` of a whole number are computed exactly.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .segment import Segment

_INT64_ROOM = 1 << 62
_ROUNDINGS = 16
"""Largest error of a cubic in floats, as a multiple of 2**-53 * the sum of its terms; Horner's bound is 7."""


def steps_at_all(segment: Segment, first_ns: int, every_ns: int, count: int) -> NDArray[np.int64]:
    """Return the whole steps made since the motion began, at `count` instants `every_ns` apart."""
    terms = segment.terms(first_ns, every_ns)
    step = segment.step
    index = _indices(count)
    if terms[2:] == (0, 0) and step * (count + 1) < _INT64_ROOM:
        whole_steps, remainder = divmod(terms[0], step)
        per_instant, excess = divmod(terms[1], step)
        steps_made = whole_steps + per_instant * index
        # skip the division, the slowest operation, where it is not needed
        return steps_made + (remainder + excess * index) // step if excess else steps_made
    return _estimated(segment, first_ns, every_ns, index)


@lru_cache(maxsize=4)
def _indices(count: int) -> NDArray[np.int64]:
    return np.arange(count)


def _estimated(segment: Segment, first_ns: int, every_ns: int, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the steps made, computed in floats, or exactly where rounding might matter."""
    (constant, *higher_terms), step = segment.terms(first_ns, every_ns), segment.step
    whole_steps, remainder = divmod(constant, step)
    c0, c1, c2, c3 = coefficients = [term / step for term in (remainder, *higher_terms)]
    k = index.astype(np.float64)
    steps = ((c3 * k + c2) * k + c1) * k + c0
    highest_k = float(len(index))
    sum_of_terms = sum(abs(coefficient) * highest_k**power for power, coefficient in enumerate(coefficients))
    error = _ROUNDINGS * 2.0**-53 * (1 + sum_of_terms)
    floors = np.floor(steps)
    steps_exact = floors.astype(np.int64) + whole_steps
    doubtful = (steps - floors < error) | (floors + 1 - steps < error)
    for doubtful_k in np.flatnonzero(doubtful).tolist():
        steps_exact[doubtful_k] = segment.steps_at(first_ns + doubtful_k * every_ns)
    return steps_exact
