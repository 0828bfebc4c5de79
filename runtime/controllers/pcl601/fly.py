"""Output on the fly: positions of an index move at which output 1 switches on [Output on the fly].

    first position D, spacing C, number ^:   D, D + C, D + 2C, ...   ^ times
    C = 0 or ^ = 0:                          once

A downward move subtracts the spacing from D. Only positions that the move reaches
count, none after its start. Pulses of 50 µs that overlap merge.
"""

from __future__ import annotations

from collections import deque

from scanrack.io_images.pcl601 import Register
from scanrack.io_images.pcl601.terminals import ON_FLY_PULSE_NS

from .register_values import Values

REMEMBERED = 100_000
"""Number of pulses whose positions are kept; the oldest are dropped."""


class OutputOnFly:
    """Output 1 during index moves."""

    def __init__(self) -> None:
        self.next_position: int | None = None  # position of the next pulse, None if no more are due
        self.positions: deque[int] = deque(maxlen=REMEMBERED)  # position register at each pulse so far
        self.until_ns: int | None = None  # end of the present pulse, None between pulses
        self._spacing = 0
        self._left = 0

    def begin(self, values: Values, direction: int) -> None:
        """Read the settings for an index move in a direction, +1 or -1."""
        first, spacing = values[Register.FIRST_OUTPUT_POSITION], values[Register.STEPS_BETWEEN_OUTPUTS]
        is_ahead = (first - values[Register.POSITION]) * direction > 0
        self.next_position = first if values[Register.OUTPUT_ON_FLY] and is_ahead else None
        self._spacing = direction * spacing
        self._left = max(1, values[Register.NUMBER_OF_OUTPUTS]) if spacing else 1

    def end(self) -> None:
        """End the move; a pulse in progress is completed."""
        self.next_position = None

    def power_off(self) -> None:
        """End the move and its pulse."""
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
