"""The state of a drive that its motions read and write."""

from __future__ import annotations

from dataclasses import dataclass

from scanrack.io_images.drives.bits import StatusBit
from scanrack.io_images.drives.configuration import DriveConfiguration


class StatusLatches:
    """The latched status bits."""

    def __init__(self) -> None:
        self.bits = StatusBit.MODULE_OK

    def clear(self, bits: int) -> None:
        """Clear the bits in a mask."""
        self.bits &= ~StatusBit(bits)


@dataclass(slots=True)
class DriveState:
    """The state that the 3601's home search uses: inputs by function, and latched bits."""

    latches: StatusLatches
    configuration: DriveConfiguration | None = None
    active: int = 0  # mask of active functions; see `ROLES`
    risen: int = 0  # mask of functions that became active at this tick
    shown: int = 0  # mask of active inputs by number
    captured: int = 0  # last captured position or encoder count
    proximity: bool = False  # the backplane proximity bit
