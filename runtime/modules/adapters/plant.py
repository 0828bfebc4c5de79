"""The parts of an adapter's device, line and machine that all adapters share."""

from __future__ import annotations

from abc import ABC, abstractmethod

from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.io_images.site import SettingError
from typing_extensions import override

from ...line.adapter_line import FaultyDevice, Line, SimulatedLine
from ...line.wire import ControllerDevice
from ...machine import Machine, Switch


def switches_of(machine: Machine, bit: InputBit) -> tuple[Switch, ...]:
    """Return the switches that feed an input."""
    return tuple(switch for switch in machine.spec.switches if switch.input is bit)


class LinkedController:
    """A device at the end of a line, and the machine that it moves.

    A real device uses this class directly, because a program can't change its time, wiring or power.

    Attributes:
        machine: the machine that the device drives.
        line: the line between device and adapter.
    """

    def __init__(self, machine: Machine, line: Line) -> None:
        self.machine = machine
        self.line = line

    def next_event_ns(self, now_ns: int) -> int | None:
        """Return the instant of the next event on the line, in the device or at the machine."""
        return self.line.next_event_ns()

    def run_until(self, now_ns: int) -> None:
        """Advance to `now_ns`; the caller must stop at every earlier event."""

    def sense(self, now_ns: int) -> None:
        """Update the machine from the motor, and the inputs from the machine."""

    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Wire the device as a configuration requires."""

    def power_cycle(self, now_ns: int) -> None:
        """Cycle the device's power; a reply on the line is lost."""


class SimulatedController(LinkedController):
    """A simulated device on a line that can be disturbed."""

    line: SimulatedLine

    def __init__(self, machine: Machine, device: ControllerDevice, line: SimulatedLine) -> None:
        super().__init__(machine, line)
        self.device = device

    @override
    def power_cycle(self, now_ns: int) -> None:
        self.device.power_cycle(now_ns)
        self.line.silence()


class Plant(SimulatedController, ABC):
    """A device on a serial line that turns the shaft of a machine.

    Raises:
        ValueError: the machine slips, jams or has a master encoder; only the 3601 simulates these.
    """

    def __init__(self, machine: Machine, device: ControllerDevice) -> None:
        if machine.spec.slips or machine.spec.jams:
            raise SettingError("machine", "machine: slips and jams are simulated with module amci3601 only")
        if machine.spec.turns or machine.spec.master_speed:
            raise SettingError("machine", "machine: a master encoder is simulated with module amci3601 only")
        super().__init__(machine, device, SimulatedLine(FaultyDevice(device)))
        self.levels = machine.levels(0)  # electrical levels of the machine's inputs, as a mask of `InputBit`
        self._held_bits = machine.held
        self._feedback = 0
        self._position_before = 0
        self._was_turning = False
        self.wire(0)

    # -- implemented for each device -----------------------------------------------------------

    @property
    @abstractmethod
    def pins(self) -> frozenset[str]:
        """The names of the pins that are wired."""

    @property
    def feedback(self) -> int:
        """Mask of the device's outputs that are wired to its inputs."""
        return 0

    @abstractmethod
    def wire(self, now_ns: int) -> None:
        """Wire every pin."""

    # -- time ---------------------------------------------------------------------------------

    @override
    def next_event_ns(self, now_ns: int) -> int | None:
        line_ns, change_ns = self.line.next_event_ns(), self.machine.next_change_ns(now_ns)
        if line_ns is None or change_ns is None:
            return change_ns if line_ns is None else line_ns
        return min(line_ns, change_ns)

    @override
    def run_until(self, now_ns: int) -> None:
        self.line.run_until(now_ns)
        self.sense(now_ns)

    @override
    def sense(self, now_ns: int) -> None:
        """Update the machine from the motor; wire the pins again if an input or feedback has changed."""
        self._follow(now_ns)
        levels, held_bits, feedback = self.machine.levels(now_ns), self.machine.held, self.feedback
        if (levels, held_bits, feedback) != (self.levels, self._held_bits, self._feedback):
            self.levels, self._held_bits, self._feedback = levels, held_bits, feedback
            self.wire(now_ns)

    @override
    def power_cycle(self, now_ns: int) -> None:
        super().power_cycle(now_ns)
        self.sense(now_ns)

    def feeds(self, bit: InputBit) -> tuple[Switch, ...]:
        """Return the switches that feed an input now, or none while the input is held at a level."""
        return () if self._held_bits & bit.value else switches_of(self.machine, bit)

    def _follow(self, now_ns: int) -> None:
        """Pass the motor's steps since the last call, and its start and stop, to the machine."""
        position, turns = self.device.motor_position, self.device.motor_turns
        steps = position - self._position_before
        if turns and not self._was_turning:
            self.machine.depart(now_ns)
        if steps:
            self.machine.follow(1 if steps > 0 else -1, abs(steps), now_ns)
        if self._was_turning and not turns:
            self.machine.rest(now_ns)
        self._position_before, self._was_turning = position, turns
