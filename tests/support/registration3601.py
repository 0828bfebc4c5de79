"""Registration moves in words: started, released, given a minimum distance.

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:

    t (ms)      0     100     200     400
    steps       0     200     600    1600
    speed    1000    3000    5000    5000
    steps that a stop takes then, by shape, from 5000/s: 1200, 2400, 1600
"""

from __future__ import annotations

import pytest
from bench3601 import MANUAL_CCW, MANUAL_CW, Bench
from scanrack.io_images.thousands import split_thousands

STORE = 0x0400
"""Command LSW bit 10."""

STEPS = 3000

SHAPES = {"constant": 0, "triangular S": 1, "trapezoidal S": 3}
"""Command LSW of an acceleration type."""

TO_STOP = {"constant": 1200, "triangular S": 2400, "trapezoidal S": 1600}
"""Steps from 5000 to 1000/s at 10: 24e6/20,000, twice that, four thirds of it [chapter 2]."""


def register(bench: Bench, direction: int = 1, steps: int = STEPS, **parameters) -> Bench:
    """Start a registration move."""
    return bench.manual(direction, steps, **parameters)


def release(bench: Bench) -> Bench:
    """Reset the manual bit alone."""
    return bench.out(0, *list(bench.outputs)[1:])


def change(bench: Bench, *, direction: int = 1, **words: int) -> Bench:
    """Change single words, w1 to w7, while the bit stays set."""
    kept = list(bench.outputs)
    for name, value in words.items():
        kept[int(name[1:])] = value
    kept[0] = MANUAL_CW if direction > 0 else MANUAL_CCW
    return bench.out(*kept)


def store(bench: Bench, distance: int, *, idle: bool = True) -> Bench:
    """Store a minimum registration distance."""
    bench.out(0, STORE, *split_thousands(distance)).scan()
    return bench.out().scan() if idle else bench


def give_input(bench: Bench, by: str) -> Bench:
    """Give the registration input in one of its two ways."""
    return release(bench) if by == "release" else bench.inputs(external=1)


EITHER_INPUT = pytest.mark.parametrize("by", ["release", "external"])
