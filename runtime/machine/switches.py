"""The inputs that switches energize, as a table over the shaft's position.

    shaft      ...  -1 | 0 ............ 2999 | 3000 .. 3500 | 3501 ...
    bounds             0                     3000           3501
    masks      CCW     -                     HOME           -

A table row ends only where an input changes; `steps_to_switch` uses these ends.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence

from .shaft import FAR
from .spec import Switch


class SwitchTable:
    """The levels of the inputs that are wired to switches.

    Args:
        switches: switches already checked by MachineSpec, so that no input has both kinds of contact.
    """

    __slots__ = ("_bounds", "_masks")

    def __init__(self, switches: Sequence[Switch]) -> None:
        self._bounds: list[int] = []
        self._masks = [energized(switches, -FAR)]
        for bound in sorted(set(_edges(switches))):
            mask = energized(switches, bound)
            if mask != self._masks[-1]:
                self._bounds.append(bound)
                self._masks.append(mask)

    def row(self, shaft: int) -> tuple[int, int, int]:
        """Return (first, last, mask): the levels at `shaft`, and the range of positions with these levels.

        An open end is -FAR or FAR.
        """
        index = bisect_right(self._bounds, shaft)
        first_step = self._bounds[index - 1] if index else -FAR
        last_step = self._bounds[index] - 1 if index < len(self._bounds) else FAR
        return first_step, last_step, self._masks[index]


def _edges(switches: Iterable[Switch]) -> Iterable[int]:
    """Yield the positions where a switch may change: its first position, and the one after its last."""
    for switch in switches:
        if switch.first is not None:
            yield switch.first
        if switch.last is not None:
            yield switch.last + 1


def energized(switches: Iterable[Switch], shaft: int) -> int:
    """Return the mask of inputs that switches energize at a shaft position.

    An input's normally open switches are in parallel, and its normally closed switches are in series.

    >>> from scanrack.io_images.amci3601.bits import InputBit
    >>> limits = [Switch(InputBit.CW_LIMIT, 90, None, True), Switch(InputBit.CW_LIMIT, None, -90, True)]
    >>> energized(limits, -95), energized(limits, 0), energized(limits, 95)
    (0, 16, 0)
    """
    on_bits = off_bits = 0
    for switch in switches:
        if switch.closed(shaft):
            on_bits |= switch.input.value
        elif switch.normally_closed:
            off_bits |= switch.input.value
    return on_bits & ~off_bits
