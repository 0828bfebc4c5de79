"""States of an input as text, for command lines and rack files.

ground, open, high      fixed level; an open input 1 has no pull-up and is at 0 V
2.5V                    analog voltage on input 1
9000..  ..-3000  5..10  switch to ground, closed at these motor positions
"""

from __future__ import annotations

from fractions import Fraction

from scanrack.io_images.pcl601.terminals import INPUTS

from ...machine.contacts import FAR, GROUND, OPEN, Contact
from .pins import FULL_SCALE_VOLTS, Pcl601Pins

LEVELS = {"ground": GROUND, "open": OPEN, "high": OPEN}


def connect(pins: Pcl601Pins, name: str, state: str) -> None:
    """Set an input to a state in the notation above.

    Raises:
        ValueError: the input or state is unknown.
    """
    if name not in INPUTS:
        raise ValueError(f"no input {name}; choose from {', '.join(INPUTS)}")
    if name == "in1" and state.endswith("V"):
        pins.apply_volts(_volts(state))
    elif name == "in1" and state == "open":  # only input 1 lacks a pull-up
        pins.connect(name, GROUND)
    elif state in LEVELS:
        pins.connect(name, LEVELS[state])
    else:
        first, last = range_of(state)
        pins.connect(name, Contact(-FAR if first is None else first, FAR if last is None else last))


def _volts(state: str) -> Fraction:
    """Return the voltage in a state such as `2.5V`; raise a ValueError if it is not a voltage in range."""
    try:
        volts = Fraction(state.removesuffix("V").strip())
    except (ValueError, ZeroDivisionError):
        volts = Fraction(-1)
    if not 0 <= volts <= FULL_SCALE_VOLTS:
        raise ValueError(f"{state}: voltage must be 0V to {FULL_SCALE_VOLTS}V")
    return volts


def range_of(state: str) -> tuple[int | None, int | None]:
    """Return the first and last position of a range; None for an open end.

    >>> range_of("9000.."), range_of("..-3000"), range_of("-5..5")
    ((9000, None), (None, -3000), (-5, 5))

    Raises:
        ValueError: the text is not a range.
    """
    first_text, dots, last_text = state.partition("..")
    try:
        if not dots or not first_text + last_text:
            raise ValueError(state)
        return int(first_text) if first_text else None, int(last_text) if last_text else None
    except ValueError:
        allowed = "ground, open, high, 2.5V at in1, or positions such as 9000.. or ..-3000 or 5..10"
        raise ValueError(f"{state!r} is not a state of an input; choose from {allowed}") from None
