"""Output on the fly: positions of an index move at which output 1 switches on [Output on the fly].

    first position D, spacing C, number ^:   D, D + C, D + 2C, ...   ^ times
    C = 0 or ^ = 0:                          once

A downward move subtracts the spacing from D. Only positions ahead of the move's start count. Overlapping
pulses of 50 µs merge.
"""

from __future__ import annotations

from collections import deque

from scanrack.io_images.pcl601 import Register
from scanrack.io_images.pcl601.terminals import ON_FLY_PULSE_NS

from .register_values import Values

POSITIONS_MAX = 100_000
"""Maximum number of pulse positions to keep; older ones are dropped."""


class OutputOnFly:
    """Output 1 during index moves.

    Attributes:
        next_position: position of the next pulse, or None if there is none.
        positions: position register at each pulse so far.
        until_ns: end of the current pulse, or None between pulses.
    """

    def __init__(self) -> None:
        self.next_position: int | None = None
        self.positions: deque[int] = deque(maxlen=POSITIONS_MAX)
        self.until_ns: int | None = None
        self._spacing = 0  # with the sign of the direction
        self._pulses_left = 0

    def begin(self, values: Values, direction: int) -> None:
        """Read the registers for an index move in a direction, +1 or -1."""
        first, spacing = values[Register.FIRST_OUTPUT_POSITION], values[Register.STEPS_BETWEEN_OUTPUTS]
        is_ahead = (first - values[Register.POSITION]) * direction > 0
        self.next_position = first if values[Register.OUTPUT_ON_FLY] and is_ahead else None
        self._spacing = direction * spacing
        self._pulses_left = max(1, values[Register.NUMBER_OF_OUTPUTS]) if spacing else 1

    def end(self) -> None:
        """End the move; the current pulse continues."""
        self.next_position = None

    def power_off(self) -> None:
        """End the move and its pulse."""
        self.end()
        self.until_ns = None

    def settle(self, now_ns: int, position: int) -> bool:
        """Begin or end a pulse if due; return whether one was due."""
        if self.until_ns is not None and now_ns >= self.until_ns:
            self.until_ns = None
            return True
        if position != self.next_position:
            return False
        self._pulses_left -= 1
        self.next_position = position + self._spacing if self._pulses_left else None
        self.positions.append(position)
        self.until_ns = now_ns + ON_FLY_PULSE_NS
        return True
