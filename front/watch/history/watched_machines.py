"""Numbers of the machines of a rack, beside the images."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...io_images.amci3601 import StatusMsw
from ...io_images.image import Image
from ...io_images.thousands import join_reported
from ...runtime.loop.rack import Rack
from ...runtime.modules.record import ModuleWithFigures

PER_SLOT = 4
"""Shaft, encoder, mask of energized inputs, place of position 0 on the shaft's scale."""

_MOVING = StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW


@dataclass(slots=True)
class _Zero:
    """Where a module's position 0 lies on the shaft's scale, steps since power-up.

    The place changes with home and preset only: lost steps stay visible as the distance between the
    shaft and the module's position.
    """

    at: int = 0
    position: int = 0
    shaft: int = 0
    resting: bool = True
    invalid: bool = True

    def read(self, inputs: Image, shaft: int) -> int:
        """Return the place as of an input image of a 3601 and its shaft."""
        bits = inputs[0]
        if bits < 0:
            return self.at  # configuration mode: the words are a mirror
        position, resting = join_reported(inputs[2], inputs[3]), not bits & _MOVING
        invalid = bool(bits & StatusMsw.POSITION_INVALID)
        preset = resting and self.resting and shaft == self.shaft and position != self.position
        if preset or (self.invalid and (resting or not invalid)):
            self.at = shaft - position
        self.position, self.shaft, self.resting, self.invalid = position, shaft, resting, invalid
        return self.at


class MachineFigures:
    """Reads the machines of a rack; see `runtime.live.tap.Figures`."""

    def __init__(self, rack: Rack) -> None:
        self._machines: list[tuple[ModuleWithFigures, Image, _Zero]] = []
        self.slots: list[int] = []  # the slots with a readable machine, `PER_SLOT` numbers each
        for slot in rack.slots.values():
            module: Any = slot.module
            device = getattr(module, "module", module)  # inside of incidents
            if isinstance(device, ModuleWithFigures):
                self._machines.append((device, slot.inputs, _Zero()))
                self.slots.append(slot.number)

    def read(self, now_ns: int) -> tuple[int, ...]:
        """Return the numbers of all machines at the instant of the latest scan."""
        found: list[int] = []
        for machine, inputs, zero in self._machines:
            figures = machine.figures()
            found += *figures, zero.read(inputs, figures[0])
        return tuple(found)
