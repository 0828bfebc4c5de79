"""A simulated PCL601 bolted to a machine, wired as the adapter expects it.

3601 terminal    PCL601
home             home, input 6
CW, CCW limit    hard limit +, -
external         input 3; input 2, too, where it is active high (and by option registration)
emergency stop   input 4; both hard limits through diodes
capture          input 5
encoder          encoder
input 2 also to output 7
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ....io_images.amci3601 import Configuration, InputBit
from ....io_images.pcl601 import Register
from ...machine import Machine, Switch
from ...pcl601.line import Pcl601
from ...pcl601.pins import FAR, GROUND, OPEN, Contact
from ..plant import Plant, switches_of
from .driver import MARK_OUTPUT

WIRING: dict[InputBit, tuple[str, ...]] = {
    InputBit.HOME: ("home", "in6"),
    InputBit.CW_LIMIT: ("hard_plus",),
    InputBit.CCW_LIMIT: ("hard_minus",),
    InputBit.EXTERNAL: ("in3", "in2"),
    InputBit.ESTOP: ("in4", "hard_plus", "hard_minus"),
    InputBit.CAPTURE: ("in5",),
}
"""Pins that each terminal of the 3601 is wired to."""

MARK_PIN = "in2"


@dataclass(frozen=True, slots=True)
class Parallel(Contact):
    """Contacts in parallel: closed while any of them is.

    Attributes:
        contacts: the single ones.
    """

    contacts: tuple[Contact, ...] = ()

    def closed(self, position: int) -> bool:
        """Whether the input is grounded."""
        return any(contact.closed(position) for contact in self.contacts)

    def edge_after(self, position: int, direction: int) -> int | None:
        """Return the next position on the way at which one of them is otherwise."""
        edges = [contact.edge_after(position, direction) for contact in self.contacts]
        return min(
            (edge for edge in edges if edge is not None),
            key=lambda edge: abs(edge - position),
            default=None,
        )


def contacts_of(switch: Switch) -> tuple[Contact, ...]:
    """Return the contacts that are closed where a switch energises its input."""
    first = -FAR if switch.first is None else switch.first
    last = FAR if switch.last is None else switch.last
    if switch.normally_closed:
        return Contact(-FAR, first - 1), Contact(last + 1, FAR)
    return (Contact(first, last),)


class SimulatedPcl601(Plant):
    """A controller, its line and the machine that it moves.

    Attributes:
        device: the controller on its line.
        external_on_mark: the external input is wired to input 2.

    Args:
        machine: what is bolted to it; its shaft follows every step.
        has_jumper: input 2 is wired to output 7 alone (option registration).

    Raises:
        ValueError: the machine slips or jams, which this controller's simulation has no notion of.
    """

    def __init__(self, machine: Machine, *, has_jumper: bool = False) -> None:
        self.device = Pcl601()
        self.external_on_mark = True
        self._has_jumper = has_jumper
        self._counts_before = machine.encoder_counts(0)
        self._fixed = {
            bit: tuple(contact for switch in switches_of(machine, bit) for contact in contacts_of(switch))
            for bit in InputBit
        }
        super().__init__(machine, self.device)

    @property
    def motor_position(self) -> int:
        """Where the motor stands."""
        return self.device.controller.motor.position

    @property
    def motor_turns(self) -> bool:
        """Whether a motion is under way."""
        return self.device.controller.axis.busy

    @property
    def feedback(self) -> int:
        """The mark's output, which is wired to an input."""
        return self.device.controller.outputs >> MARK_OUTPUT - 1 & 1

    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Wire input 2 to the external input where that grounds it when active; else to output 7 alone."""
        used_high = configuration.inputs_used & configuration.active_high & InputBit.EXTERNAL.value
        external_on_mark = bool(used_high) and not self._has_jumper
        if external_on_mark != self.external_on_mark:
            self.external_on_mark = external_on_mark
            self.wire(now_ns)

    def power_cycle(self, now_ns: int) -> None:
        """Take the controller's power away and give it back; nothing else changes."""
        self.device.power_cycle(now_ns)
        self.sense(now_ns)

    def sense(self, now_ns: int) -> None:
        """Let the machine follow the motor, inputs and encoder the machine."""
        super().sense(now_ns)
        counts = self.machine.encoder_counts(now_ns)
        self.device.controller.values[Register.ENCODER_POSITION] += counts - self._counts_before
        self._counts_before = counts

    def wire(self, now_ns: int) -> None:
        """Connect every pin to what grounds it."""
        parts: dict[str, list[Contact]] = {pin: [] for pins in WIRING.values() for pin in pins}
        for bit, pins in WIRING.items():
            for pin in pins:
                if pin != MARK_PIN or self.external_on_mark:
                    parts[pin] += self._contacts(bit)
        if self.feedback:
            parts[MARK_PIN].append(GROUND)
        for pin, contacts in parts.items():
            self.device.controller.pins.connect(pin, Parallel(contacts=tuple(contacts)))
        self.device.controller.settle(now_ns)

    def _contacts(self, bit: InputBit) -> Iterable[Contact]:
        """What grounds a terminal: switches that the motor passes, or what people and stations do."""
        if self._fixed[bit]:
            return self._fixed[bit]
        return (GROUND if self.levels & bit.value else OPEN,)
