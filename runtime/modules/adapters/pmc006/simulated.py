"""A simulated PMC006x3s with a machine and the adapter's wiring.

    3601 terminal                              PMC006
    home, CCW limit                            EXT1
    CW limit                                   EXT2
    emergency stop, or capture, or external    FSET

The opto-coupler of an energized terminal conducts and pulls the pin low.
"""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, InputBit
from typing_extensions import override

from ....controllers.pmc006.controller import Pmc006Controller
from ....controllers.pmc006.line import Pmc006
from ....controllers.pmc006.pins import Pin
from ....machine import Machine
from ....machine.contacts import Parallel, contacts_of
from ..plant import Plant
from .pmc006_capabilities import FSET_INPUTS

UNIT = 1


class SimulatedPmc006(Plant):
    """A PMC006x3s, its line and its machine; the shaft follows every step.

    Args:
        device: the simulated device; by default a new one.

    Raises:
        ValueError: the machine slips or jams, which is not simulated here.
    """

    device: Pmc006

    def __init__(self, machine: Machine, device: Pmc006 | None = None) -> None:
        self.device = device or Pmc006(Pmc006Controller(address=UNIT))
        self._on_fset = InputBit.ESTOP
        super().__init__(machine, self.device)

    @property
    @override
    def pins(self) -> frozenset[str]:
        return frozenset(str(pin.name).lower() for pin in (Pin.EXT1, Pin.EXT2, Pin.FSET))

    @override
    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Wire FSET to the input that the configuration uses."""
        used_bits = [bit for bit in FSET_INPUTS if configuration.inputs_used & bit.value]
        wired_bit = used_bits[0] if used_bits else self._on_fset
        if wired_bit is not self._on_fset:
            self._on_fset = wired_bit
            self.wire(now_ns)

    @override
    def wire(self, now_ns: int) -> None:
        self._pull(Pin.EXT1, InputBit.HOME, InputBit.CCW_LIMIT)
        self._pull(Pin.EXT2, InputBit.CW_LIMIT)
        self._pull(Pin.FSET, self._on_fset)

    def _pull(self, pin: Pin, *bits: InputBit) -> None:
        """Pull a pin low while one of its terminals is energized, by a switch or by a held level."""
        contacts = tuple(
            contact for bit in bits for switch in self.feeds(bit) for contact in contacts_of(switch)
        )
        is_held_low = any(self.levels & bit.value and not self.feeds(bit) for bit in bits)
        self.device.controller.set_pin(pin, False if is_held_low else Parallel(contacts=contacts))
