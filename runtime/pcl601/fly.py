"""Output on the fly: where output 1 goes on during an index move [Output on the fly].

    first position D, spacing C, number ^:   D, D + C, D + 2C, ...   ^ times
    C = 0 or ^ = 0:                          once

Going down the spacing is counted down from D. Only positions that the move
arrives at count: what lies behind its start is not caught up with.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...io_images.pcl601 import Register


class OutputOnFly:
    """The positions still to come in an index move.

    Attributes:
        next_position: where the next pulse is due, None if no more are.

    Args:
        taken: the registers as the move found them.
        position: position register at its start.
        direction: +1 or -1.
    """

    def __init__(self, taken: Mapping[Register, int], position: int, direction: int) -> None:
        first = taken[Register.FIRST_OUTPUT_POSITION]
        spacing = taken[Register.STEPS_BETWEEN_OUTPUTS]
        ahead = (first - position) * direction > 0
        self.next_position = first if taken[Register.OUTPUT_ON_FLY] and ahead else None
        self._spacing = direction * spacing
        self._left = max(1, taken[Register.NUMBER_OF_OUTPUTS]) if spacing else 1

    def pulsed(self, position: int) -> None:
        """Take note that the pulse at a position has been made."""
        self._left -= 1
        self.next_position = position + self._spacing if self._left else None
