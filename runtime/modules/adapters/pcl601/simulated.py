"""A simulated PCL601 with a machine and the adapter's wiring.

3601 terminal    PCL601
home             home, input 6
CW, CCW limit    hard limit +, -; by option limit_sense inputs 1 and 5, and no hard limit where active low
external         input 3; also input 2 if it is active high and option registration has its default
emergency stop   input 4; both hard limits through diodes
capture          input 5, unless a limit uses it
encoder          encoder

Jumpers: output 7 to input 2, unless registration is polled; by option proximity output 6 to both soft limits.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.io_images.pcl601 import Register
from typing_extensions import override

from ....controllers.pcl601.line import Pcl601
from ....machine import Machine
from ....machine.contacts import GROUND, OPEN, Contact, Parallel, contacts_of
from ..plant import Plant, switches_of
from .driver import MARK_OUTPUT, PROXIMITY_OUTPUT
from .pcl601_capabilities import external_sets_mark
from .pcl601_options import Pcl601Options

WIRING: dict[InputBit, tuple[str, ...]] = {
    InputBit.HOME: ("home", "in6"),
    InputBit.CW_LIMIT: ("hard_plus",),
    InputBit.CCW_LIMIT: ("hard_minus",),
    InputBit.EXTERNAL: ("in3", "in2"),
    InputBit.ESTOP: ("in4", "hard_plus", "hard_minus"),
    InputBit.CAPTURE: ("in5",),
}
"""Pins wired to each terminal of the 3601."""

LIMITS_ON_INPUTS: dict[InputBit, tuple[str, ...]] = {
    InputBit.CW_LIMIT: ("hard_plus", "in1"),
    InputBit.CCW_LIMIT: ("hard_minus", "in5"),
    InputBit.CAPTURE: (),
}
"""Wiring changed by option limit_sense."""

HARD_LIMITS = {InputBit.CW_LIMIT: "hard_plus", InputBit.CCW_LIMIT: "hard_minus"}
MARK_PIN = "in2"
PROXIMITY_PINS = ("soft_plus", "soft_minus")

Wire = tuple[InputBit, str]
"""A wire from a terminal to a pin."""


def _mask(output: int) -> int:
    return 1 << output - 1


WIRED_OUTPUTS = _mask(MARK_OUTPUT) | _mask(PROXIMITY_OUTPUT)


class SimulatedPcl601(Plant):
    """A PCL601, its line and its machine.

    Args:
        machine: the machine; its shaft follows every step.
        device: the simulated device; by default a new one.

    Raises:
        ValueError: the machine slips or jams, which is not simulated here.
    """

    device: Pcl601

    def __init__(self, machine: Machine, options: Pcl601Options, device: Pcl601 | None = None) -> None:
        self.device = device or Pcl601()
        self._options = options
        self._wiring = WIRING | (LIMITS_ON_INPUTS if options.limit_sense == "inputs" else {})
        self._open_wires: frozenset[Wire] = frozenset()
        self._counts_before = machine.encoder_counts(0)
        self._switch_contacts = {  # by terminal
            bit: tuple(contact for switch in switches_of(machine, bit) for contact in contacts_of(switch))
            for bit in InputBit
        }
        super().__init__(machine, self.device)

    @property
    @override
    def pins(self) -> frozenset[str]:
        return frozenset(pin for pins in (*self._wiring.values(), *self._jumpers.values()) for pin in pins)

    @property
    @override
    def feedback(self) -> int:
        return self.device.controller.outputs & WIRED_OUTPUTS

    @override
    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Open the wires that a configuration forbids."""
        open_wires = frozenset(self._forbidden_wires(configuration))
        if open_wires != self._open_wires:
            self._open_wires = open_wires
            self.wire(now_ns)

    def _forbidden_wires(self, configuration: Configuration) -> Iterable[Wire]:
        """Yield wires to pins that would act when grounded although the 3601's input must not.

        Without its wire, input 2 is wired only to output 7, and a normally closed limit only to its input.
        """
        used_low = configuration.inputs_used & ~configuration.active_high
        if not external_sets_mark(configuration, self._options):
            yield InputBit.EXTERNAL, MARK_PIN
        for bit, pin in HARD_LIMITS.items():
            if used_low & bit.value:
                yield bit, pin

    @override
    def sense(self, now_ns: int) -> None:
        """Update the machine from the motor, and then the inputs and the encoder from the machine."""
        super().sense(now_ns)
        counts = self.machine.encoder_counts(now_ns)
        if counts != self._counts_before:
            self.device.controller.values[Register.ENCODER_POSITION] += counts - self._counts_before
            self._counts_before = counts

    @override
    def wire(self, now_ns: int) -> None:
        """Connect every pin to its contacts."""
        contacts_of_pin: dict[str, list[Contact]] = defaultdict(list)
        for bit, pins in self._wiring.items():
            for pin in pins:
                contacts_of_pin[pin] += () if (bit, pin) in self._open_wires else self._contacts(bit)
        for output, pins in self._jumpers.items():
            for pin in pins:
                contacts_of_pin[pin] += (GROUND,) if self.feedback & _mask(output) else ()
        for pin, contacts in contacts_of_pin.items():
            self.device.controller.pins.connect(pin, Parallel(contacts=tuple(contacts)))
        self.device.controller.settle(now_ns)

    @property
    def _jumpers(self) -> dict[int, tuple[str, ...]]:
        """The pins that the options connect to outputs, by output."""
        jumpers: dict[int, tuple[str, ...]] = {}
        if self._options.registration != "polled":
            jumpers[MARK_OUTPUT] = (MARK_PIN,)
        if self._options.proximity == "jumper":
            jumpers[PROXIMITY_OUTPUT] = PROXIMITY_PINS
        return jumpers

    def _contacts(self, bit: InputBit) -> Iterable[Contact]:
        """Return the contacts of a terminal: its switches, or a contact for the level at which it is held."""
        if self.feeds(bit):
            return self._switch_contacts[bit]
        return (GROUND if self.levels & bit.value else OPEN,)
