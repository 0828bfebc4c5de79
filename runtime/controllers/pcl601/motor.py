"""The motor that the clock output drives, and the encoder on its shaft.

Encoder models:

    ideal             counts every step, including corrections
    stuck             never counts, though the motor turns
    lose_steps_once   in the first index move the shaft loses some steps from the 101st on, and the
                      encoder counts the shaft's motion
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

EncoderKind = Literal["ideal", "stuck", "lose_steps_once"]

STEPS_BEFORE_LOSS = 100
"""Number of steps in the first index move before the loss."""


@dataclass(frozen=True, slots=True)
class EncoderModel:
    """Model of an encoder on the motor's shaft."""

    ratio: int = 1  # counts per motor step
    model: EncoderKind = "ideal"  # see above
    steps: int = 0  # motor steps lost, for "lose_steps_once"


class Motor:
    """The motor's position and encoder.

    Args:
        encoder: the encoder on its shaft, or None.
    """

    def __init__(self, encoder: EncoderModel | None = None) -> None:
        self.position = 0  # physical position, steps; 0 at the start
        self._ratio = 0  # counts per step
        self._steps_before_loss = 0  # remaining steps of this motion before the loss
        self._steps_to_lose = 0  # remaining steps to lose in this motion
        self._index_losses = 0  # steps to lose in the next index move
        if encoder is not None:
            self._ratio = 0 if encoder.model == "stuck" else encoder.ratio
            self._index_losses = encoder.steps if encoder.model == "lose_steps_once" else 0

    def begin_index(self) -> None:
        """Begin an index move."""
        self._steps_before_loss, self._steps_to_lose = STEPS_BEFORE_LOSS, self._index_losses
        self._index_losses = 0

    def end_motion(self) -> None:
        """End the motion; the shaft loses no more steps."""
        self._steps_to_lose = 0

    def steps_to(self, position: int) -> int:
        """Return the number of clock pulses needed to reach a position."""
        distance = abs(position - self.position)
        return distance + self._steps_to_lose if distance > self._steps_before_loss else distance

    def turn(self, direction: int, steps: int) -> int:
        """Turn by a number of clock pulses; return the change in encoder counts."""
        steps_made = steps
        if self._steps_to_lose:
            steps_before = min(steps, self._steps_before_loss)
            steps_lost = min(steps - steps_before, self._steps_to_lose)
            self._steps_before_loss -= steps_before
            self._steps_to_lose -= steps_lost
            steps_made -= steps_lost
        self.position += direction * steps_made
        return direction * steps_made * self._ratio
