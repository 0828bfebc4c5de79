"""The three lights on the front panel [chapter 1, Front Panel].

    light       solid               blinking                               off
    Module      owned by the PLC                                           no link
    Axis OK     no motion           motion, follower mode, one-shot held   not configured, or an error
    Axis Err    link to the PLC     an error: configuration, command,      no error
                interrupted         input, home invalid, invalid profile

Both axis lights alternate after failed power-up diagnostics. They blink together when the module's processor
has lost the backplane chip.
"""

from __future__ import annotations

from enum import Enum

from scanrack.io_images.dataclass import dataclass

from .latches import COMMAND_ERROR, CONFIG_ERROR, HOME_INVALID, INPUT_ERROR, INVALID_PROFILE

BLINKING_ERRORS = CONFIG_ERROR | COMMAND_ERROR | INPUT_ERROR | HOME_INVALID | INVALID_PROFILE


class Light(Enum):
    """State of a light."""

    OFF = "off"
    SOLID = "solid"
    BLINKING = "blinking"
    ALTERNATING = "alternating"


@dataclass(frozen=True, slots=True)
class Indicators:
    """The lights of a module at one instant."""

    module: Light  # Module, green
    axis_ok: Light
    axis_error: Light


def indicators(status: int, *, moving: bool, linked: bool = True) -> Indicators:
    """Return the lights of a module that has passed its diagnostics.

    >>> indicators(0x4000, moving=True).axis_ok
    <Light.BLINKING: 'blinking'>

    Args:
        status: latched bits of input word 0, and errors of word 1 from bit 16.
        moving: a motion or the follower mode is running, or the bit of a one-shot is still set.
    """
    has_error = status & BLINKING_ERRORS or status >> 16
    axis_ok = Light.BLINKING if moving else Light.SOLID
    axis_error = Light.OFF
    if has_error:
        axis_ok, axis_error = Light.OFF, Light.BLINKING
    if not linked:
        return Indicators(Light.OFF, axis_ok, Light.SOLID)
    return Indicators(Light.SOLID, axis_ok, axis_error)


DIAGNOSTICS_FAILED = Indicators(Light.SOLID, Light.ALTERNATING, Light.ALTERNATING)
ASIC_LOST = Indicators(Light.OFF, Light.BLINKING, Light.BLINKING)
UNPOWERED = Indicators(Light.OFF, Light.OFF, Light.OFF)
