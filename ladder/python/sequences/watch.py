"""What a wait depends on, so that scans in which nothing of it changes need not ask the wait.

    Edge, until(input)      a masked word of an input image
    dwell                   the time
    a command               its flag

While all of these stay, polling the wait has no effect. Any other wait is polled in each scan.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import NamedTuple, Protocol

NEVER_NS = 1 << 63
"""After all times."""


class Flag(Protocol):
    """Something that ends once."""

    ended: bool


class _NeverEnds:
    def __init__(self) -> None:
        self.ended = False  # its own: an attribute of the class would take longer to read


class Watch(NamedTuple):
    """What a wait depends on; by default nothing."""

    words: Sequence[int] = array("h", [0])  # an image
    word: int = 0  # index of its word
    mask: int = 0  # the bits of it
    until_ns: int = NEVER_NS  # it may hold from this time on
    flag: Flag = _NeverEnds()
    at_once: bool = False  # it may hold in the first scan although nothing changes


NOTHING = Watch()
"""What a sequence without a wait depends on."""
