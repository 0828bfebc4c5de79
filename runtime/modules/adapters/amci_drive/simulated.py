"""A simulated drive with its machine, and the network that connects to it.

    adapter --request, whole--> drive --reply, whole--> adapter        each takes 250 us

A damaged segment counts as lost, since TCP's checksum rejects it.
"""

from __future__ import annotations

from typing_extensions import override

from ....line.adapter_line import FaultyDevice, SimulatedLine
from ....line.ports.modbustcp import reply_to
from ....line.segments import SegmentBus
from ....line.wire import LineFormat
from ....machine import Machine
from ...drives.drive import DriveUnit
from ...drives.registers import DriveRegisters
from ..plant import SimulatedController
from .amci_drive_options import AmciDriveOptions
from .driver import LINE_FORMAT


class DriveDevice:
    """A stack of drives with their Modbus TCP server; one axis has a machine.

    Attributes:
        drive: the axis that the adapter uses.
    """

    def __init__(self, machine: Machine, options: AmciDriveOptions) -> None:
        inputs = {"in1": options.in1, "in2": options.in2}
        wired_inputs = {terminal: name for terminal, name in inputs.items() if name != "none"}
        self.drive = DriveUnit(options.row, machine, wired_inputs)
        # the other axes of the stack, which have no machine
        lower_axes = [DriveUnit(options.row) for _ in range(options.axis - 1)]
        self._registers = DriveRegisters([*lower_axes, self.drive])
        self._reply = b""

    @property
    def line_format(self) -> LineFormat:
        """The line format of the adapter."""
        return LINE_FORMAT

    @property
    def next_wake_ns(self) -> int | None:
        """The instant at which the reply is due."""
        return self.drive.now_ns if self._reply else None

    @property
    def turnaround_ns(self) -> int:
        """The time between a request and its reply: 0."""
        return 0

    @property
    def motor_position(self) -> int:
        """Physical position of the motor, steps."""
        return self.drive.machine.shaft

    @property
    def motor_turns(self) -> bool:
        """Whether the motor is turning."""
        return self.drive.axis.moving

    def receive(self, now_ns: int, data: bytes) -> None:
        """Answer a request frame."""
        for axis in self._registers.axes:
            axis.advance(now_ns)
        self._reply += reply_to(data, lambda _unit, pdu: self._registers.answer(pdu))

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the reply."""
        for axis in self._registers.axes:
            axis.advance(now_ns)
            axis.events.clear()
        reply, self._reply = self._reply, b""
        return reply

    def power_cycle(self, now_ns: int) -> None:
        """Remove and restore the stack's power."""
        self._reply = b""
        for axis in self._registers.axes:
            axis.advance(now_ns)
            axis.power_cycle()


class FaultyNetwork(FaultyDevice):
    """A device on a network that may fail."""

    @override
    def damaged(self, data: bytes) -> bytes:
        return b""


class SimulatedDrive(SimulatedController):
    """A drive, its network link and its machine."""

    device: DriveDevice

    def __init__(self, machine: Machine, options: AmciDriveOptions) -> None:
        device = DriveDevice(machine, options)
        super().__init__(machine, device, SimulatedLine(FaultyNetwork(device), SegmentBus))

    @override
    def run_until(self, now_ns: int) -> None:
        self.line.run_until(now_ns)
        self.device.advance(now_ns)

    @override
    def sense(self, now_ns: int) -> None:
        """Sample the inputs after an external change."""
        self.device.drive.look_again()
