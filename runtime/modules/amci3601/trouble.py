"""The input image of a 3601 during a fault, bit by bit.

[3601 manual, chapter 6, The Module OK Flag; readings A-88, A-117]
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.image import WORDS

from ...loop.module_fault import ModuleFault
from .indicators import ASIC_LOST, DIAGNOSTICS_FAILED, UNPOWERED, Indicators

EVERY_BIT = 0xFFFF

FATAL_CLEARS = (
    StatusMsw.MODULE_OK
    | StatusMsw.MOVING_CW
    | StatusMsw.MOVING_CCW
    | StatusMsw.ACCELERATING
    | StatusMsw.DECELERATING
).value


class FaultImage(NamedTuple):
    """The input image during a fault.

    Attributes:
        kept: mask of the bits of each input word that keep their value; all others are 0.
        linked: whether the PLC can reach the module; see `Slot.fault`.
        lights: lights of the front panel; None for the lights shown without a link.
    """

    kept: tuple[int, ...]
    linked: bool = False
    lights: Indicators | None = None


FROZEN = (EVERY_BIT,) * WORDS

FAULT_IMAGES: Mapping[ModuleFault, FaultImage] = {
    ModuleFault.LINK_LOST: FaultImage(FROZEN),
    ModuleFault.ASIC_LOST: FaultImage(FROZEN, lights=ASIC_LOST),
    ModuleFault.REMOVED: FaultImage((0,) * WORDS, lights=UNPOWERED),
    ModuleFault.FATAL_ERROR: FaultImage(
        (EVERY_BIT & ~FATAL_CLEARS, *FROZEN[1:]), linked=True, lights=DIAGNOSTICS_FAILED
    ),
}
"""The effect of each fault on the last image before the fault."""
