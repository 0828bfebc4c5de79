"""Writes rack files with a scenario, so that `scanrack run` shows a failure, or without events."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import tomli_w
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.runtime.config.rackfile import parse_toml
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.loop.incidents import InjectedFault
from scanrack.runtime.machine import MasterTurn, TimelineEntry
from scanrack.runtime.machine.spec import input_name
from scanrack.traces.files.portable import relative

from ...load.program import is_python
from .scenario import Scenario, of_slot

Table = dict[str, Any]


def rack_text(rack_file: Path, spec: RackSpec, scenario: Scenario, scans: int, folder: Path) -> str:
    """Return the text of a rack file with a scenario. Running it records to `again.mcap` in its folder.

    Args:
        rack_file: the TOML rack file without the scenario.
        folder: folder of the new file. Paths in the file are relative to it.

    Raises:
        OSError: the rack file can't be read.
    """
    document: Table = parse_toml(read_input_text(rack_file, TextKind.TOML), rack_file)
    for table in (document, *document.get("unit", ())):
        if "program" in table:
            table["program"] = relative(rack_file.parent / str(table["program"]), folder)
    _move_files(document, rack_file.parent, folder)
    document["run_for_s"] = _seconds(scans * spec.scan_ns)
    document["trace"] = "again.mcap"
    for table, slot in zip(document["slot"], spec.slot, strict=True):
        _add_to_slot(table, slot, scenario)
    _extend(document, "incident", map(_incident_row, scenario.incidents))
    return tomli_w.dumps(document)


def _add_to_slot(table: Table, slot: SlotSpec, scenario: Scenario) -> None:
    """Add the parts of a scenario for a slot to the slot's table."""
    changed_slot = scenario.laid_over_slot(slot)
    machine, changed_machine = slot.machine, changed_slot.machine
    if changed_slot.firmware != slot.firmware:
        table["firmware"] = changed_slot.firmware
    machine_table: Table = table.setdefault("machine", {})
    for shift in of_slot(scenario.shifts, slot):
        _shift(machine_table, shift.steps)
    new_slips = changed_machine.slips[len(machine.slips) :]
    _extend(machine_table, "slips", ({"at": slip.at, "steps": slip.steps} for slip in new_slips))
    new_entries = changed_machine.timeline[len(machine.timeline) :]
    _extend(machine_table, "timeline", map(_timeline_row, new_entries))
    if changed_machine.turns != machine.turns:
        machine_table["turns"] = [_turn_row(turn) for turn in changed_machine.turns]
    if changed_slot.options != slot.options:
        rows: Any = changed_slot.options["timeline"]
        table.setdefault("options", {})["timeline"] = [_plain_row(row) for row in rows]


def bare_rack_text(rack_file: Path, program: str) -> str:
    """Return the text of a rack file without timed events, in which all controllers are simulated.

    Raises:
        OSError: the rack file can't be read.
    """
    document: Table = parse_toml(read_input_text(rack_file, TextKind.TOML), rack_file)
    document["program"] = program
    document.pop("incident", None)
    document.pop("trace", None)
    for table in document["slot"]:
        table.get("machine", {}).pop("timeline", None)
        for key in ("port", "address"):
            table.pop(key, None)
    return tomli_w.dumps(document)


def _move_files(document: Table, old_folder: Path, folder: Path) -> None:
    """Make the paths of modules and stubs relative to a new folder."""
    modules, stubs = document.get("modules", {}), document.get("stubs", {})
    for name, file_name in modules.items():
        modules[name] = relative(old_folder / file_name, folder)
    for name, file_name in stubs.items():
        if isinstance(file_name, str) and is_python(file_name):
            stubs[name] = relative(old_folder / file_name, folder)


def _extend(table: Table, key: str, new_rows: Iterable[Table]) -> None:
    """Add rows to a list in a table; if there are no rows, add no list."""
    rows = [*table.get(key, ()), *new_rows]
    if rows:
        table[key] = rows


def _shift(machine: Table, steps: int) -> None:
    """Displace the switches and stations in a table."""
    for switch in machine.get("switches", ()):
        for end in ("first", "last"):
            if end in switch:
                switch[end] += steps
    for station in machine.get("stations", ()):
        station["position"] += steps


def _seconds(time_ns: int) -> Decimal | int:
    whole_seconds, fraction = divmod(time_ns, 1_000_000_000)
    return Decimal(time_ns).scaleb(-9).normalize() if fraction else whole_seconds


def _ms(time_ns: int) -> Decimal | int:
    whole_ms, fraction = divmod(time_ns, 1_000_000)
    return Decimal(time_ns).scaleb(-6) if fraction else whole_ms


def _timeline_row(entry: TimelineEntry) -> Table:
    level = "wired" if entry.energized is None else entry.energized
    return {"at_ms": _ms(entry.at_ns), "input": input_name(entry.input), "energized": level}


def _turn_row(turn: MasterTurn) -> Table:
    return {"at_ms": _ms(turn.at_ns), "counts": turn.counts, "for_ms": _ms(turn.for_ns)}


def _plain_row(row: Mapping[str, object]) -> Table:
    """Return a row with whole floats as integers, the way a person would write them."""
    return {
        name: int(value) if isinstance(value, float) and value == int(value) else value
        for name, value in row.items()
    }


def _incident_row(incident: InjectedFault) -> Table:
    """Return the row of a fault in a rack file, with only the keys that its kind needs."""
    table: Table = {"at_ms": _ms(incident.at_ns), "what": incident.what.value}
    if incident.slot:
        table["slot"] = incident.slot
    if incident.for_ns:
        table["for_ms"] = _ms(incident.for_ns)
    if incident.late_words:
        table["late_words"] = list(incident.late_words)
    if incident.state:
        table["state"] = incident.state
    return table
