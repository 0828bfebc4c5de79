"""Encoder autocorrect, which makes up for missing motor steps after an index move [Encoder Commands].

expected = encoder at the start + distance * ratio
|expected - encoder| <= window        done
else, up to `retries` times           round(missing / ratio) steps at base speed, wait, check again
"""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.pcl601 import Register

NS_PER_MS = 1_000_000


class Autocorrect:
    """The encoder check of one index move.

    Attributes:
        delay_ns: wait between the end of the motion and the reading of the encoder.
        retries_left: remaining corrections.

    Args:
        registers: register values at the start of the move.
        distance: steps of the move, with sign.
    """

    def __init__(self, registers: Mapping[Register, int], distance: int) -> None:
        self.delay_ns = registers[Register.ENCODER_DELAY] * NS_PER_MS
        self.retries_left = registers[Register.ENCODER_RETRIES]
        self._ratio = registers[Register.ENCODER_RATIO]
        self._window = registers[Register.ENCODER_WINDOW]
        # the reading of the encoder after a move without lost steps
        self._expected = registers[Register.ENCODER_POSITION] + distance * self._ratio

    def missing(self, encoder: int) -> int | None:
        """Return the missing motor steps, with sign; None if the error is within the window."""
        pulses = self._expected - encoder
        if abs(pulses) <= self._window:
            return None
        steps = (2 * abs(pulses) + self._ratio) // (2 * self._ratio)  # halves away from zero
        return steps if pulses > 0 else -steps
