"""A simulated PMC006x3s with a machine and the adapter's wiring.

    3601 terminal                              PMC006
    home, CCW limit                            EXT1
    CW limit                                   EXT2
    emergency stop, or capture, or external    FSET

The opto-coupler of an energised terminal conducts and pulls the pin low.
"""

from __future__ import annotations

from dataclasses import dataclass

from typing_extensions import override

from .....io_images.amci3601 import Configuration, InputBit
from ....controllers.pmc006 import pins
from ....controllers.pmc006.controller import Pmc006Controller
from ....controllers.pmc006.line import Pmc006
from ....controllers.pmc006.pins import Pin
from ....machine import Machine, Switch
from ..plant import Plant
from .capabilities import FSET_INPUTS

UNIT = 1


@dataclass(frozen=True, slots=True)
class PulledPin(pins.SwitchPin):
    """A pin that is low while any of its switches energises the terminal."""

    switches: tuple[Switch, ...] = ()

    @override
    def high(self, position: int) -> bool:
        return not any(switch.closed(position) for switch in self.switches)

    @override
    def next_change(self, position: int, direction: int) -> int | None:
        edges = [edge for switch in self.switches for edge in _edges(switch)]
        if direction > 0:
            return min((edge for edge in edges if edge > position), default=None)
        return max((edge - 1 for edge in edges if edge <= position), default=None)


def _edges(switch: Switch) -> list[int]:
    """Return the positions at which a switch changes on the way up."""
    edges = [] if switch.first is None else [switch.first]
    return edges if switch.last is None else [*edges, switch.last + 1]


class SimulatedPmc006(Plant):
    """A controller, its line and its machine, whose shaft follows every step.

    Raises:
        ValueError: the machine slips or jams, which this controller's simulation lacks.
    """

    device: Pmc006

    def __init__(self, machine: Machine) -> None:
        self.device = Pmc006(Pmc006Controller(address=UNIT))
        self._on_fset = InputBit.ESTOP
        super().__init__(machine, self.device)

    @override
    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Wire FSET to the input that is used."""
        used = [bit for bit in FSET_INPUTS if configuration.inputs_used & bit.value]
        wired = used[0] if used else self._on_fset
        if wired is not self._on_fset:
            self._on_fset = wired
            self.wire(now_ns)

    @override
    def wire(self, now_ns: int) -> None:
        self._pull(Pin.EXT1, InputBit.HOME, InputBit.CCW_LIMIT)
        self._pull(Pin.EXT2, InputBit.CW_LIMIT)
        self._pull(Pin.FSET, self._on_fset)

    def _pull(self, pin: Pin, *bits: InputBit) -> None:
        switches = tuple(switch for bit in bits for switch in self.feeds(bit))
        held = any(self.levels & bit.value and not self.feeds(bit) for bit in bits)
        self.device.controller.set_pin(pin, False if held else PulledPin(0, False, switches))
