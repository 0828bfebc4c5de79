"""Writes the inputs of one module in a run as a script for `scanrack drive`."""

from __future__ import annotations

import json
from collections import defaultdict
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
"""Period of the module's updates. The bench exchanges images only at its multiples."""

REPLIES = {FaultKind.REPLIES_LOST: "drop_next", FaultKind.REPLIES_DAMAGED: "corrupt_next"}
"""Keys of the bench's requests for a single lost or damaged reply."""


def obstacle(spec: RackSpec, slot: SlotSpec) -> str | None:
    """Return a feature of a slot that the bench does not support, or None."""
    machine = slot.machine
    faults = [incident for incident in spec.incidents if incident.slot in (0, slot.number)]
    fault_kinds = {fault.what for fault in faults}
    has_early_updates = spec.controller != "micrologix" or FaultKind.TORN_UPDATE in fault_kinds
    has_lasting_reply_faults = any(fault.what in REPLIES and fault.for_ns for fault in faults)
    features: tuple[tuple[bool, str], ...] = (
        (not is_stepper(slot.words), f"module {slot.module}"),
        (bool(machine.slips or machine.jams), "slips and jams"),
        (machine.encoder is not None, "an encoder on the shaft"),
        (not fault_kinds.isdisjoint(TROUBLES), "lost links"),
        (has_lasting_reply_faults, "several lost or damaged replies in a row"),
        (has_early_updates, "updates before the end of the scan"),
        (bool(spec.scan_ns % BENCH_TICK_NS), "a scan time that is not a multiple of 0.25 ms"),
    )
    return next((text for is_present, text in features if is_present), None)


def set_by_level(machine: MachineSpec) -> list[InputBit]:
    """Return the inputs that the bench's machine can't drive. The script sets them, up to a scan late.

    These are inputs with a failing sensor, a normally closed switch, or several switches.
    """
    switch_inputs = [switch.input for switch in machine.switches]
    undrivable = {entry.input for entry in machine.timeline}
    undrivable |= {switch.input for switch in machine.switches if switch.normally_closed}
    undrivable |= {bit for bit in switch_inputs if switch_inputs.count(bit) > 1}
    return [bit for bit in InputBit if bit in switch_inputs and bit in undrivable]


def _driven_switches(machine: MachineSpec) -> list[Switch]:
    """Return the switches that the bench's machine drives."""
    by_level = set_by_level(machine)
    return [switch for switch in machine.switches if switch.input not in by_level]


class DriveScript(QuietListener):
    """A listener that records the inputs of a module.

    Args:
        spec: the rack; the slot must not have an `obstacle`.
        slot: the module's slot in the rack.
        rack_slot: the same slot of the running rack.

    Attributes:
        by_level: inputs of switches that the script sets, see `set_by_level`.
    """

    def __init__(self, spec: RackSpec, slot: SlotSpec, rack_slot: Slot) -> None:
        wrapped = rack_slot.module
        module: Any = wrapped.module if isinstance(wrapped, ExposedModule) else wrapped
        self._machine: Machine = module.machine
        self._outputs = rack_slot.outputs
        self._scan_ms = spec.scan_ns / 1e6
        driven = {switch.input for switch in _driven_switches(slot.machine)}
        self.by_level = set_by_level(slot.machine)
        # inputs that follow no switch on the bench, so the script sets their levels
        self._set_inputs = [bit for bit in InputBit if bit not in driven]
        self._fault_requests = _fault_requests(spec.incidents, slot.number, spec.scan_ns)
        self._requests: list[dict[str, Any]] = [{"new": _bench_table(spec, slot)}]
        self._last_words, self._last_levels = [0] * len(rack_slot.outputs), 0
        self._scans = 0  # since the beginning of the last request

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Begin a new request each time the inputs change."""
        is_running = bool(flags & 1)
        words = list(self._outputs) if is_running else self._last_words
        levels = self._machine.levels(now_ns)
        request: dict[str, Any] = dict(self._fault_requests.pop(scan, {}))
        if words != self._last_words:
            request["out"] = words
        changed = levels ^ self._last_levels
        inputs = {input_name(bit): int(bool(levels & bit)) for bit in self._set_inputs if changed & bit}
        if inputs:
            request["inputs"] = inputs
        if request or scan == 0:
            self._end_request()
            self._requests.append(request)
        self._last_words, self._last_levels = words, levels
        self._scans += 1

    def _end_request(self) -> None:
        if self._scans:
            self._requests[-1]["for_ms"] = _number(self._scans * self._scan_ms)
            self._scans = 0

    @override
    def close(self) -> None:
        self._end_request()

    def text(self) -> str:
        """Return the script, one request per line."""
        return "".join(json.dumps(request) + "\n" for request in self._requests)


def _bench_table(spec: RackSpec, slot: SlotSpec) -> dict[str, Any]:
    """Return the settings of the script's bench."""
    table: dict[str, Any] = {"scan_ms": _number(spec.scan_ns / 1e6)}
    if slot.has(Trait.FIRMWARE):
        table = {"firmware": slot.firmware, **table}
    switches = _driven_switches(slot.machine)
    if switches:
        table["machine"] = {input_name(switch.input): [switch.first, switch.last] for switch in switches}
    if slot.wiring:
        table["wiring"] = slot.wiring
    if slot.options:
        table["options"] = dict(slot.options)
    return table


def _fault_requests(
    incidents: tuple[InjectedFault, ...], slot: int, scan_ns: int
) -> dict[int, dict[str, Any]]:
    """Return the requests for injected faults of a slot and of the CPU, by scan.

    Program mode and an open line without a duration last until the end of the run.
    """
    requests: dict[int, dict[str, Any]] = defaultdict(dict)
    for incident in incidents:
        scan = -(-incident.at_ns // scan_ns)  # rounded up: the first scan that is not before it
        end_scan = -(-(incident.at_ns + incident.for_ns) // scan_ns)
        if incident.what is FaultKind.PROGRAM_MODE:
            requests[scan]["plc_mode"] = "program"
            if incident.for_ns:
                requests[end_scan]["plc_mode"] = "run"
        elif incident.slot != slot:
            continue
        elif incident.what is FaultKind.POWER_CYCLE:
            requests[scan]["power_cycle"] = True
        elif incident.what is FaultKind.CONTROLLER_POWER_CYCLE:
            requests[scan]["device"] = "power_cycle"
        elif incident.what in REPLIES:
            requests[scan]["link"] = {REPLIES[incident.what]: 1}
        elif incident.what is FaultKind.LINE_DOWN:
            requests[scan]["link"] = "down"
            if incident.for_ns:
                requests[end_scan]["link"] = "up"
    return requests


def _number(value: float) -> int | float:
    return int(value) if value == int(value) else value
