"""Numbers of a rack's machines, in addition to the images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from scanrack.io_images.image import Image
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.number_formats import NumberFormat
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.modules.record import ModuleWithFigures, ModuleWithFormats

PER_SLOT = 4
"""Numbers per slot: shaft, encoder, mask of energized inputs, shaft position of position 0."""


@dataclass(slots=True)
class _Zero:
    """The shaft position at which a module's position is 0, in steps from the position at power-up.

    Only homing and presets change it, so lost steps stay visible as the difference between the shaft and the
    module's position.
    """

    words: ModuleWords
    shaft_of_zero: int = 0
    position: int = 0
    shaft: int = 0
    resting: bool = True
    invalid: bool = True

    def read(self, image: Image, shaft: int, format: NumberFormat) -> int:
        """Update this position from an input image and the shaft position, and return it.

        Args:
            format: format of the position if the module's configuration selects it.
        """
        inputs, quantity = list(image), self.words.quantity("position")
        if quantity is None or self.words.configures("I", inputs):
            return self.shaft_of_zero  # in configuration mode the words mirror the configuration
        high, low = inputs[quantity.word : quantity.word + 2]
        position = (quantity.format or format).reported(high, low)
        resting = not self._any_on(inputs, "MOVING_CW", "MOVING_CCW")
        invalid = self._any_on(inputs, "POSITION_INVALID")
        was_preset = resting and self.resting and shaft == self.shaft and position != self.position
        may_be_homed = self.invalid and (resting or not invalid)
        if was_preset or may_be_homed:
            self.shaft_of_zero = shaft - position
        self.position, self.shaft, self.resting, self.invalid = position, shaft, resting, invalid
        return self.shaft_of_zero

    def _any_on(self, inputs: Sequence[int], *names: str) -> bool:
        bits = filter(None, map(self.words.place, names))
        return any(inputs[bit.word] >> bit.bit & 1 for bit in bits)


class _WatchedMachine(NamedTuple):
    device: ModuleWithFigures
    inputs: Image
    zero: _Zero

    def read(self) -> tuple[int, ...]:
        """Return the machine's numbers, see `PER_SLOT`."""
        figures = self.device.figures()
        formats = self.device if isinstance(self.device, ModuleWithFormats) else None
        format = NumberFormat.THOUSANDS if formats is None else formats.number_format
        return *figures, self.zero.read(self.inputs, figures[0], format)


class MachineFigures:
    """The machines of a rack, as `runtime.live.tap.Figures`."""

    def __init__(self, rack: Rack) -> None:
        self._machines: list[_WatchedMachine] = []
        self.slots: list[int] = []  # the slots with a readable machine, `PER_SLOT` numbers each
        for slot in rack.slots.values():
            module: Any = slot.module
            device = getattr(module, "module", module)  # unwrap injected faults
            if isinstance(device, ModuleWithFigures):
                self._machines.append(_WatchedMachine(device, slot.inputs, _Zero(slot.words)))
                self.slots.append(slot.number)

    def read(self, now_ns: int) -> tuple[int, ...]:
        """Return the numbers of all machines at the instant of the latest scan."""
        return tuple(number for machine in self._machines for number in machine.read())
