"""Output on the fly: where output 1 goes on during an index move [Output on the fly].

    first position D, spacing C, number ^:   D, D + C, D + 2C, ...   ^ times
    C = 0 or ^ = 0:                          once

Going down, the spacing counts down from D. Only positions that the move arrives
at count, none behind its start. Pulses closer together than their 50 µs merge.
"""

from __future__ import annotations

from collections import deque

from ....io_images.pcl601 import Register
from ....io_images.pcl601.terminals import ON_FLY_PULSE_NS
from .values import Values

REMEMBERED = 100_000
"""Pulses whose positions are kept; older ones are forgotten."""


class OutputOnFly:
    """Output 1 as index moves switch it.

    Attributes:
        next_position: where the next pulse is due, None if no more are.
        positions: position register at each pulse so far.
        until_ns: end of the present pulse, None between pulses.
    """

    def __init__(self) -> None:
        self.next_position: int | None = None
        self.positions: deque[int] = deque(maxlen=REMEMBERED)
        self.until_ns: int | None = None
        self._spacing = 0
        self._left = 0

    def begin(self, values: Values, direction: int) -> None:
        """Take the settings for an index move that begins in a direction, +1 or -1."""
        first, spacing = values[Register.FIRST_OUTPUT_POSITION], values[Register.STEPS_BETWEEN_OUTPUTS]
        ahead = (first - values[Register.POSITION]) * direction > 0
        self.next_position = first if values[Register.OUTPUT_ON_FLY] and ahead else None
        self._spacing = direction * spacing
        self._left = max(1, values[Register.NUMBER_OF_OUTPUTS]) if spacing else 1

    def end(self) -> None:
        """Note the end of the move; a pulse under way is finished."""
        self.next_position = None

    def power_off(self) -> None:
        """End the pulse, too."""
        self.end()
        self.until_ns = None

    def settle(self, now_ns: int, position: int) -> bool:
        """Begin or end a pulse, if one is due; return whether one was."""
        if self.until_ns is not None and now_ns >= self.until_ns:
            self.until_ns = None
            return True
        if position != self.next_position:
            return False
        self._left -= 1
        self.next_position = position + self._spacing if self._left else None
        self.positions.append(position)
        self.until_ns = now_ns + ON_FLY_PULSE_NS
        return True
