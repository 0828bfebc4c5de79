"""Connects a served controller to a machine: a rack file's switches, stations and people act on its inputs.

rack file            [slot.machine] of the slot with the controller's adapter, or with a 3601
wiring               as for the adapter, see docs/adapters.md; a normally closed limit feeds no hard limit
time                 a timeline begins when the service begins
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from scanrack.io_images.amci3601 import ALL_INPUTS, Configuration, InputBit
from scanrack.io_images.site import SettingError
from scanrack.runtime.config.rackfile import load_rack_file
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line.wire import ControllerDevice, LineFormat
from scanrack.runtime.machine import Machine
from scanrack.runtime.modules.adapters.pcl601.pcl601_options import Pcl601Options
from scanrack.runtime.modules.adapters.pcl601.simulated import SimulatedPcl601
from scanrack.runtime.modules.adapters.plant import Plant
from scanrack.runtime.modules.adapters.pmc006.simulated import SimulatedPmc006
from typing_extensions import override

from ..run.served_units import Unit

BARE = Pcl601Options(registration="polled")
"""Options for the machine of a 3601, without an output that is wired to an input."""


class DeviceOnMachine(ControllerDevice):
    """A controller on a line, with a machine that follows its motor and operates its inputs."""

    def __init__(self, plant: Plant) -> None:
        self._plant, self._device = plant, plant.device
        self._now_ns = 0

    @property
    def line_format(self) -> LineFormat:
        """The current format of characters on the line."""
        return self._device.line_format

    @property
    def turnaround_ns(self) -> int:
        """Silence between a request and its reply, ns."""
        return self._device.turnaround_ns

    @property
    def motor_position(self) -> int:
        """Physical position of the motor, steps."""
        return self._device.motor_position

    @property
    def motor_turns(self) -> bool:
        """Whether the motor is moving."""
        return self._device.motor_turns

    @property
    def next_wake_ns(self) -> int | None:
        """Time of the next event on the line, in the controller or at the machine, ns; None = no event."""
        times = (self._device.next_wake_ns, self._plant.machine.next_change_ns(self._now_ns))
        return min((time_ns for time_ns in times if time_ns is not None), default=None)

    @override
    def receive(self, now_ns: int, data: bytes) -> None:
        self._device.receive(now_ns, data)

    @override
    def advance(self, now_ns: int) -> bytes:
        """Advance through all events of the controller and machine; return the bytes for the line."""
        reply = b""
        while (due_ns := self.next_wake_ns) is not None and self._now_ns < due_ns < now_ns:
            reply += self._step(due_ns)
        return reply + self._step(now_ns)

    def _step(self, now_ns: int) -> bytes:
        reply = self._device.advance(now_ns)
        self._plant.sense(now_ns)
        self._now_ns = now_ns
        return reply

    @override
    def power_cycle(self, now_ns: int) -> None:
        self._plant.power_cycle(now_ns)


def on_machines(units: list[Unit], texts: list[str]) -> list[Unit]:
    """Return the units, with machines connected to some of them.

    Args:
        texts: rack files, as FILE for the only unit or ADDRESS:FILE for one of several units.

    Raises:
        ValueError: a file or its machine can't be used, or its unit does not exist.
    """
    units_by_address = {unit.address: unit for unit in units}
    for text in texts:
        address, file = addressed_file(text, list(units_by_address))
        if isinstance(units_by_address[address].device, DeviceOnMachine):
            raise ValueError(f"--machine {text}: unit {address} already has a machine")
        units_by_address[address] = _on_machine(units_by_address[address], Path(file))
    return list(units_by_address.values())


def addressed_file(text: str, addresses: list[int]) -> tuple[int, str]:
    """Return the address and file from FILE or ADDRESS:FILE; raise ValueError for an unknown address."""
    address, colon, file = text.partition(":")
    if colon and address.isdecimal():
        if int(address) not in addresses:
            known = ", ".join(map(str, addresses))
            raise ValueError(f"--machine {text}: no unit {address}; addresses: {known}")
        return int(address), file
    if len(addresses) > 1:
        raise ValueError(f"--machine {text}: must be ADDRESS:FILE if several units are served")
    return addresses[0], text


def _on_machine(unit: Unit, file: Path) -> Unit:
    """Return a unit with the machine of a rack file; raise ValueError if its settings can't be used."""
    try:
        plant = _plant(unit.device, file)
    except SettingError as error:
        raise ValueError(f"--machine {file}: {error}") from error
    plant.rewire(0, _wired_as(plant.machine))
    device = DeviceOnMachine(plant)
    return replace(unit, device=device, wire=partial(_wire, plant.pins, unit.wire))


def _plant(device: ControllerDevice, file: Path) -> Plant:
    """Return a controller with the machine of its adapter's slot, or else of a 3601's slot."""
    if isinstance(device, Pcl601):
        slot = slot_in(file, "pcl601-adapter", "amci3601")
        options = Pcl601Options.of(slot.options) if slot.module == "pcl601-adapter" else BARE
        return SimulatedPcl601(Machine(slot.machine), options, device)
    assert isinstance(device, Pmc006)
    return SimulatedPmc006(Machine(slot_in(file, "pmc006-adapter", "amci3601").machine), device)


def slot_in(file: Path, *modules: str) -> SlotSpec:
    """Return the only slot with the first of the given modules that a rack file has.

    Raises:
        ValueError: the file can't be used, or it has none of the modules, or several slots with the first.
    """
    slots = load_rack_file(file).spec.slot
    for module in modules:
        matching = [slot for slot in slots if slot.module == module]
        if len(matching) == 1:
            return matching[0]
        if matching:
            raise ValueError(f"--machine {file}: {len(matching)} slots have an {module}; only one may")
    raise ValueError(f"--machine {file}: no slot has a {', '.join(modules[:-1])} or an {modules[-1]}")


def _wired_as(machine: Machine) -> Configuration:
    """Return a configuration that uses the machine's inputs; a normally closed switch is active low."""
    normally_closed = sum({switch.input.value for switch in machine.spec.switches if switch.normally_closed})
    used = machine.spec.fed_inputs | InputBit.HOME.value | InputBit.CW_LIMIT.value  # always used
    return Configuration(inputs_used=used, active_high=ALL_INPUTS & ~normally_closed, starting_speed=1)


def _wire(wired: frozenset[str], wire: Callable[[str, str], None], name: str, state: str) -> None:
    """Set an input, unless the machine operates it."""
    if name in wired:
        raise ValueError(f"{name}: the machine operates this input, like all of {', '.join(sorted(wired))}")
    wire(name, state)
