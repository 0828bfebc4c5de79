"""Numbers of the machines of a rack, beside the images."""

from __future__ import annotations

from typing import Any

from ...runtime.loop.rack import Rack
from ...runtime.modules.record import ModuleWithFigures

PER_SLOT = 3
"""Shaft, encoder, mask of energized inputs."""


class MachineFigures:
    """Reads the machines of a rack; see `runtime.live.tap.Figures`."""

    def __init__(self, rack: Rack) -> None:
        self._machines: list[ModuleWithFigures] = []
        self.slots: list[int] = []  # the slots with a readable machine, `PER_SLOT` numbers each
        for slot in rack.slots.values():
            module: Any = slot.module
            device = getattr(module, "module", module)  # inside of incidents
            if isinstance(device, ModuleWithFigures):
                self._machines.append(device)
                self.slots.append(slot.number)

    def read(self, now_ns: int) -> tuple[int, ...]:
        """Return the numbers of all machines at the instant of the latest scan."""
        return tuple(number for machine in self._machines for number in machine.figures())
