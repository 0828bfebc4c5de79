"""The dependencies of a wait. A scan need not poll the wait until one of them changes.

    Edge, until(input)      a masked word of an input image
    dwell                   the time
    a command               its flag

Other waits are polled in each scan.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import NamedTuple, Protocol

NEVER_NS = 1 << 63
"""A time later than all others, ns."""


class Flag(Protocol):
    """An object that ends once, such as a command."""

    ended: bool


class _NeverEnds:
    def __init__(self) -> None:
        self.ended = False  # an instance attribute: reading a class attribute would take longer


class Watch(NamedTuple):
    """The dependencies of a wait; by default, none."""

    words: Sequence[int] = array("h", [0])  # an image
    word: int = 0  # index of its word
    mask: int = 0  # the bits in the word
    until_ns: int = NEVER_NS  # the wait may be over from this time on, ns
    flag: Flag = _NeverEnds()
    at_once: bool = False  # whether the wait may be over in the first scan without a change


NOTHING = Watch()
"""The dependencies of a sequence without a wait."""
