"""Serves a stack of simulated drives on Modbus TCP and EtherNet/IP, in real time.

At each request, the drives first advance to the current time, and then the registers answer. All axes share
one set of registers. Each axis has its own inputs, machine, flash, power and cable.
"""

from __future__ import annotations

import selectors
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from scanrack.io_images.drives.configuration import broken_rules
from scanrack.io_images.drives.models import MODELS, Model
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.line.ports import LineListener, ModbusTcpPort, Server
from scanrack.runtime.loop.pace import Clock
from scanrack.runtime.machine import Machine, MachineSpec
from scanrack.runtime.modules.drives.conditions import action
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.drive_options import options_of
from scanrack.runtime.modules.drives.nonvolatile import DriveMemory
from scanrack.runtime.modules.drives.registers import DriveRegisters
from scanrack.runtime.tag_servers.drive_adapter import DriveAdapter
from typing_extensions import override

from ..run.served_units import ServedUnit
from .drive_server import DriveServer, EnipPort, LineTap
from .line import LineService, PortChoice, socket_address
from .machines import addressed_file, slot_in
from .memory_file import ControllerMemory

CONNECTIONS = 6
"""Maximum number of concurrent Modbus TCP connections; additional connections are closed [SMD p. 121]."""


class DriveService(LineService):
    """Drives and their registers.

    Args:
        axes: number of axes in the stack.
        machines: rack files, as FILE for the only axis or AXIS:FILE for one of several axes.
        memory: file of the drives' flash; None = no file.

    Raises:
        ValueError: the number of axes, a file, a machine or the memory is unusable.
    """

    def __init__(
        self, model: Model, clock: Clock, axes: int, machines: Sequence[str], memory: ControllerMemory | None
    ) -> None:
        if not 1 <= axes <= model.axes:
            axis_range = f"1 to {model.axes}" if model.axes > 1 else "1"
            raise ValueError(f"--axes {axes}: a stack of the {model.title} has {axis_range}")
        self.model = model
        self._clock = clock
        self._tap = LineTap(clock, None)
        self._server: DriveServer | None = None
        slots = _slots(model, machines, axes)
        flash = _flash(model, memory, axes)
        self.axes = [_drive(model, slots.get(axis), flash[axis - 1]) for axis in range(1, axes + 1)]
        self.registers = DriveRegisters(self.axes)
        # only the EDS file of a single drive of some models is available
        self._adapter = DriveAdapter(self.axes[0]) if model.identity is not None and axes == 1 else None
        self.units = [self._unit(axis, drive) for axis, drive in enumerate(self.axes, 1)]
        if memory is not None:
            memory.follow([partial(getattr, axis, "memory") for axis in self.axes])

    @property
    @override
    def title(self) -> str:
        count = len(self.axes)
        return self.model.name if count == 1 else f"{self.model.name} with {count} axes"

    def advance(self, now_ns: int) -> None:
        """Advance all axes."""
        for axis in self.axes:
            axis.advance(max(now_ns, axis.now_ns))
            axis.events.clear()
            axis.machine.events.clear()

    @override
    def set_fault(self, text: str) -> None:
        raise ValueError(f"{text!r}: the {self.model.title} has no faults of a line; choose from its pins")

    @override
    def server(
        self, choice: PortChoice, clock: Clock, listener: LineListener | None = None
    ) -> tuple[Server, str]:
        """Open the requested ports; return their server, and their addresses for clients."""
        if choice.tcp is None and choice.ethernet_ip is None:
            raise ValueError(f"{self.model.name}: give --tcp [HOST:]PORT, --ethernet-ip [HOST:]PORT or both")
        selector, self._tap = selectors.DefaultSelector(), LineTap(clock, listener)
        with ExitStack() as opened:
            opened.callback(selector.close)
            modbus = enip = None
            if choice.tcp is not None:
                modbus = ModbusTcpPort(*socket_address(choice.tcp), CONNECTIONS, selector)
                opened.callback(modbus.close)
            if choice.ethernet_ip is not None:
                if self._adapter is None:
                    titles = ", ".join(model.title for model in MODELS.values() if model.identity is not None)
                    problem = f"not possible with the {self.title}; only with a single {titles}"
                    raise ValueError(f"--ethernet-ip: {problem}")
                address = socket_address(choice.ethernet_ip, "--ethernet-ip")
                enip = EnipPort(self._adapter, address, choice.io_port, selector, self._tap)
            opened.pop_all()  # keep the ports open, since none has failed
        names = [] if modbus is None else [modbus.name]
        if enip is not None:
            names.append(f"{enip.name} EtherNet/IP, UDP {enip.io_port}")
        self._server = DriveServer(modbus, self._reply, enip, self._advance_to_now, selector)
        return self._server, "  ".join(names)

    def _advance_to_now(self) -> None:
        self.advance(self._clock.now_ns())

    def _reply(self, unit: int, pdu: bytes) -> bytes:
        """Return the reply to a Modbus request PDU at the current time."""
        self._advance_to_now()
        head = bytes((unit,))
        self._tap.received(head + pdu)
        reply = self.registers.answer(pdu)
        self._tap.sent(head + reply)
        return reply

    def _unit(self, number: int, drive: DriveUnit) -> ServedUnit:
        """Return an axis as a unit, with functions that read its state and set its inputs."""
        wired = drive.machine.spec.fed_inputs
        return ServedUnit(
            address=number,
            status=partial(_status, number, drive, self._adapter),
            values=partial(_values, drive, self._adapter),
            wire=partial(self._wire, drive, wired),
        )

    def _wire(self, drive: DriveUnit, wired: int, name: str, state: str) -> None:
        self._advance_to_now()
        action(drive, name, state, wired)()
        if name == "power" and len(self.axes) == 1 and self._server is not None:
            self._server.drop_all()


def _drive(model: Model, slot: SlotSpec | None, memory: DriveMemory | None) -> DriveUnit:
    spec = MachineSpec() if slot is None else slot.machine
    options = slot.options if slot is not None and slot.module == model.name else None
    return DriveUnit(model, Machine(spec), options, memory)


def _slots(model: Model, texts: Sequence[str], axes: int) -> dict[int, SlotSpec]:
    """Return the slots whose machines the axes move, by axis number."""
    slots: dict[int, SlotSpec] = {}
    for text in texts:
        axis, file = addressed_file(text, list(range(1, axes + 1)))
        if axis in slots:
            raise ValueError(f"--machine {text}: axis {axis} already has a machine")
        slots[axis] = slot_in(Path(file), model.name, "amci-drive", "amci3601")
    return slots


def _flash(model: Model, memory: ControllerMemory | None, axes: int) -> Sequence[DriveMemory | None]:
    """Return the flash of each axis from the file; None for a new drive.

    Raises:
        ValueError: the file has a different number of axes, or an invalid configuration.
    """
    if memory is None or not memory.records:
        return [None] * axes
    memory.check_number(axes)
    build = options_of(model).of(None).build
    flash = [record for record in memory.records if isinstance(record, DriveMemory)]
    for number, record in enumerate(flash):
        rules = () if record.configuration is None else broken_rules(record.configuration, model, build)
        for rule in rules:
            raise ValueError(f"{memory.path}: units.{number}.configuration: {rule.text} [{rule.id}]")
    return flash


def _status(number: int, drive: DriveUnit, adapter: DriveAdapter | None) -> dict[str, str]:
    """Return the state of an axis as text, by title."""
    words = drive.inputs()
    shaft, _, _ = drive.figures()
    late_packets: dict[str, str] = {}
    if adapter is not None and adapter.used:
        late_packets["late packets"] = f"{adapter.late_received:,} received, {adapter.late_sent:,} sent"
    return {
        "axis": str(number),
        "status 0": f"{words[0] & 0xFFFF:04x}h",
        "status 1": f"{words[1] & 0xFFFF:04x}h",
        "shaft": f"{shaft:,}",
        "motion": "moving" if drive.axis.moving else "idle",
        "flash writes": f"{drive.memory.writes:,}",
        **late_packets,
    }


def _values(drive: DriveUnit, adapter: DriveAdapter | None) -> dict[str, int]:
    """Return the words by name (in.NAME and out.NAME), and the values that no word contains."""
    shaft, counts, energized = drive.figures()
    words = drive.model.words
    late_packets: dict[str, int] = {}
    if adapter is not None:
        late_packets = {"late_received": adapter.late_received, "late_sent": adapter.late_sent}
    return {
        **{f"in.{name}": word & 0xFFFF for name, word in zip(words.inputs, drive.inputs(), strict=True)},
        **{f"out.{name}": word for name, word in zip(words.outputs, drive.words, strict=True)},
        "shaft": shaft,
        "encoder_counts": counts,
        "energized": energized,
        "flash_writes": drive.memory.writes,
        **late_packets,
    }
