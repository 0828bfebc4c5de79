"""The jog inputs, which select the direction of a jog [Jog Inputs]."""

from __future__ import annotations

from scanrack.io_images.pcl601.terminals import HARD_LIMITS, JOG_INPUTS, SOFT_LIMITS

from .motor import Motor
from .pins import Pcl601Pins


class JogInputs:
    """Jog +, Jog - and Fast Jog.

    Attributes:
        allowed: whether the inputs have an effect.

    Args:
        motor: the motor that operates contacts by its position.
    """

    def __init__(self, pins: Pcl601Pins, motor: Motor) -> None:
        self.allowed = True
        self._pins, self._motor = pins, motor
        self._released = True

    def wait_for_release(self, waiting: bool = True) -> None:
        """Ignore the direction inputs until both are open."""
        self._released = not waiting

    def selected(self) -> int:
        """Return the selected direction if the limits allow it; 0 if none or both are selected."""
        position = self._motor.position
        directions = [
            direction for direction, name in JOG_INPUTS.items() if self._pins.grounded(name, position)
        ]
        if not directions:
            self._released = True
        if len(directions) != 1 or not self._released or not self.allowed:
            return 0
        (direction,) = directions
        limits = HARD_LIMITS[direction], SOFT_LIMITS[direction]
        return 0 if any(self._pins.grounded(limit, position) for limit in limits) else direction

    @property
    def fast(self) -> bool:
        """Whether the fast jog input is grounded."""
        return self._pins.grounded("fast_jog", self._motor.position)
