"""Writes a run as a script for `scanrack drive`: the inputs of one module, request by request."""

from __future__ import annotations

import json
from typing import Any

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.loop.incidents import TROUBLES, FaultKind, InjectedFault
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.rack import Slot
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.machine.spec import input_name
from scanrack.runtime.modules.record import Trait
from typing_extensions import override

BENCH_TICK_NS = 250_000
"""The bench exchanges images at multiples of the module's 250 µs."""


REPLIES = {FaultKind.REPLIES_LOST: "drop_next", FaultKind.REPLIES_DAMAGED: "corrupt_next"}
"""Request keys of the bench for a single lost or damaged reply."""


def obstacle(spec: RackSpec, slot: SlotSpec) -> str | None:
    """Return a feature of a slot that the bench does not support, or None."""
    machine = slot.machine
    faults = [incident for incident in spec.incidents if incident.slot in (0, slot.number)]
    beyond: tuple[tuple[bool, str], ...] = (
        (not is_stepper(slot.words), f"module {slot.module}"),
        (bool(machine.slips or machine.jams), "slips and jams"),
        (machine.encoder is not None, "an encoder on the shaft"),
        (any(fault.what in TROUBLES for fault in faults), "lost links"),
        (any(fault.what in REPLIES and fault.for_ns for fault in faults), "replies that are lost for a time"),
        (
            spec.controller != "micrologix" or any(fault.what is FaultKind.TORN_UPDATE for fault in faults),
            "updates that do not wait for the scan's end",
        ),
        (bool(spec.scan_ns % BENCH_TICK_NS), "a scan that is not a multiple of 0.25 ms"),
    )
    return next((text for is_there, text in beyond if is_there), None)


def set_by_level(machine: MachineSpec) -> list[InputBit]:
    """Return the inputs that the bench's machine can't drive: the script sets them, up to a scan late.

    These are inputs with a failing sensor, a normally closed switch, or several switches.
    """
    feeds = [switch.input for switch in machine.switches]
    fails = {entry.input for entry in machine.timeline}
    closed = {switch.input for switch in machine.switches if switch.normally_closed}
    return [bit for bit in InputBit if bit in feeds and (bit in fails | closed or feeds.count(bit) > 1)]


def _fed_by_bench(machine: MachineSpec) -> list[Switch]:
    by_level = set_by_level(machine)
    return [switch for switch in machine.switches if switch.input not in by_level]


class DriveScript(QuietListener):
    """A listener that records the inputs of a module.

    Args:
        spec: the rack, without an `obstacle` for the slot.
    """

    def __init__(self, spec: RackSpec, slot: SlotSpec, live: Slot) -> None:
        module: Any = live.module.module if isinstance(live.module, ExposedModule) else live.module
        self._machine: Machine = module.machine
        self._outputs = live.outputs
        self._scan_ms = spec.scan_ns / 1e6
        fed = {switch.input for switch in _fed_by_bench(slot.machine)}
        self.by_level = set_by_level(slot.machine)  # switched inputs, see `set_by_level`
        self._free = [bit for bit in InputBit if bit not in fed]
        self._acts = _acts(spec.incidents, slot.number, spec.scan_ns)
        self._lines: list[dict[str, Any]] = [{"new": _bench(spec, slot)}]
        self._before: tuple[list[int], int] = ([0] * len(live.outputs), 0)
        self._scans = 0

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Begin a new request at each change of the inputs."""
        running = bool(flags & 1)
        words = list(self._outputs) if running else self._before[0]
        levels = self._machine.levels(now_ns)
        request: dict[str, Any] = dict(self._acts.pop(scan, {}))
        if words != self._before[0]:
            request["out"] = words
        changed_levels = levels ^ self._before[1]
        inputs = {input_name(bit): int(bool(levels & bit)) for bit in self._free if changed_levels & bit}
        if inputs:
            request["inputs"] = inputs
        if request or scan == 0:
            self._end()
            self._lines.append(request)
        self._before = words, levels
        self._scans += 1

    def _end(self) -> None:
        if self._scans:
            self._lines[-1]["for_ms"] = _number(self._scans * self._scan_ms)
            self._scans = 0

    @override
    def close(self) -> None:
        self._end()

    def text(self) -> str:
        """Return the script, one request per line."""
        return "".join(json.dumps(line) + "\n" for line in self._lines)


def _bench(spec: RackSpec, slot: SlotSpec) -> dict[str, Any]:
    table: dict[str, Any] = {"scan_ms": _number(spec.scan_ns / 1e6)}
    if slot.has(Trait.FIRMWARE):
        table = {"firmware": slot.firmware, **table}
    switches = _fed_by_bench(slot.machine)
    if switches:
        table["machine"] = {input_name(switch.input): [switch.first, switch.last] for switch in switches}
    if slot.wiring:
        table["wiring"] = slot.wiring
    if slot.options:
        table["options"] = dict(slot.options)
    return table


def _acts(incidents: tuple[InjectedFault, ...], slot: int, scan_ns: int) -> dict[int, dict[str, Any]]:
    """Return the requests other than words and levels, by scan."""
    acts: dict[int, dict[str, Any]] = {}
    for incident in incidents:
        scan = -(-incident.at_ns // scan_ns)
        end = -(-(incident.at_ns + incident.for_ns) // scan_ns)
        if incident.what is FaultKind.PROGRAM_MODE:
            acts.setdefault(scan, {})["plc_mode"] = "program"
            if incident.for_ns:
                acts.setdefault(end, {})["plc_mode"] = "run"
        elif incident.slot != slot:
            continue
        elif incident.what is FaultKind.POWER_CYCLE:
            acts.setdefault(scan, {})["power_cycle"] = True
        elif incident.what is FaultKind.CONTROLLER_POWER_CYCLE:
            acts.setdefault(scan, {})["device"] = "power_cycle"
        elif incident.what in REPLIES:
            acts.setdefault(scan, {})["link"] = {REPLIES[incident.what]: 1}
        elif incident.what is FaultKind.LINE_DOWN:
            acts.setdefault(scan, {})["link"] = "down"
            if incident.for_ns:
                acts.setdefault(end, {})["link"] = "up"
    return acts


def _number(value: float) -> int | float:
    return int(value) if value == int(value) else value
