"""Writes the rack file that `scanrack l5x --print-rack` prints for an export; `export_slots` adds its slots.

The file runs as printed. Instructions without an implementation have a stub, and a comment lists the possible
stubs. Other refused parts do nothing.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict, replace
from pathlib import Path

from scanrack.ladder.instructions import BY_NAME
from scanrack.rockwell.l5x import L5xImport
from scanrack.rockwell.l5x.modules import GENERIC, prefix_of, slot_of
from scanrack.rockwell.l5x.report import Refusal
from scanrack.rockwell.l5x.xml.records import ModuleRecord
from scanrack.runtime.config.rackspec import DECLARE, EMPTY, MISSING_TAGS, REFUSED

from .export_slots import STEPPER, ExportSlot, simulated, slot_tables, with_steppers
from .export_start import DOWNLOADED, ExportStart
from .toml_text import comment, key, text

BYTES_OUT, BYTES_IN = 16, (16, 20)
"""Sizes of a 3601's connection, bytes; 4 more input bytes are the Fault [3601 manual, chapter 2, "16+4"]."""

_CALL = re.compile(r"\b([A-Z_][A-Z0-9_]*)\(", re.IGNORECASE)
_US_PER_MS = 1000


def rack_of(
    imported: L5xImport,
    program: Path,
    steppers: Collection[str] = (),
    *,
    recorded: bool = True,
    export: ExportStart = DOWNLOADED,
) -> str:
    """Return a rack file as text; raise ValueError if the export lacks one of the `steppers`.

    Args:
        imported: the export, already imported for a trial.
        steppers: modules that are 3601s, by name or slot.
        recorded: whether the rack file names a recording.
        export: initial state of the program.
    """
    slots = with_steppers(slots_of(imported.document.modules), steppers)
    head = _head(imported, program, recorded=recorded)
    return "\n".join([*head, *_start(export), *_stubs(imported), *slot_tables(slots)]) + "\n"


def _head(imported: L5xImport, program: Path, *, recorded: bool) -> Iterator[str]:
    """Yield the lines above the tables: the program, the controller, the times and the recording."""
    report = imported.report
    name = report.controller or program.stem
    yield comment(f"{name}: {report.rungs} rungs, {len(report.refused)} refused.")
    yield ""
    yield f"name = {text(name)}"
    yield f"program = {text(program.as_posix())}"
    yield 'controller = "compactlogix"'
    rpis = [module.rpi_us for module in imported.document.modules if slot_of(module) and module.rpi_us]
    if rpis:
        yield f"rpi_ms = {min(rpis) / _US_PER_MS:g}"
    yield "scan_ms = 2           # a scan of the continuous task"
    yield "run_for_s = 10"
    if recorded:
        yield f"trace = {text(program.stem + '.mcap')}"
    yield '# tags = ["*"]        # variables to record, by name or pattern'


def _start(export: ExportStart) -> Iterator[str]:
    """Yield the table `[export]` with the settings that differ from a download; nothing if none differ."""
    defaults = asdict(DOWNLOADED)
    changed = {name: value for name, value in asdict(export).items() if value != defaults[name]}
    if changed:
        yield ""
        yield "[export]"
        yield from (f"{name} = {json.dumps(value)}" for name, value in changed.items())


def _stubs(imported: L5xImport) -> Iterator[str]:
    """Yield the table `[stubs]` for missing and refused parts of an export; nothing if it is complete."""
    report = imported.report
    declares = bool(report.declared) or any(refusal.tag for refusal in report.refused)
    if report.complete and not (report.stubs or declares):
        return
    yield ""
    yield '# Stubs of missing instructions: "false", "true", "done after 20 ms", or "plant.py:function".'
    yield "[stubs]"
    for name, line in _stub_lines(imported).items():
        yield f"{key(name)} = {line}"
    if declares:
        yield f"{MISSING_TAGS} = {text(DECLARE)}    # declare tags that the export leaves out, from their use"
    if not report.complete:
        yield f"{REFUSED} = {text(EMPTY)}    # other refused parts do nothing"


def _stub_lines(imported: L5xImport) -> dict[str, str]:
    """Return the stubs for unimplemented instructions and missing routines of an export."""
    report = imported.report
    stubs = {name: text(stub) for name, stub in report.stubs.items()}
    for name in map(_instruction, report.refused):
        if name and name not in BY_NAME:
            stubs.setdefault(name, text("false"))
    for refused_object in report.objects:
        if refused_object.routine:
            stubs.setdefault(refused_object.routine, f"{text('false')}    # a routine that is not imported")
    return stubs


def _instruction(refused: Refusal) -> str:
    """Return the instruction at the refused column of a rung; "" if there is none."""
    match = _CALL.search(refused.text, refused.column - 1)
    return match[1].upper() if match else ""


def all_modules(modules: Iterable[ModuleRecord]) -> list[ExportSlot]:
    """Return all modules of an export except the controller; a module on a network has slot 0."""
    slots = []
    for module in modules:
        slot = _slot(slot_of(module) or 0, module)
        if slot.number:
            slots.append(slot)
        elif module.tags:
            slots.append(replace(slot, module=None))
    return slots


def slots_of(modules: Iterable[ModuleRecord]) -> list[ExportSlot]:
    """Return the slots of the controller's own chassis."""
    numbered_modules = ((slot_of(module), module) for module in modules)
    return [_slot(number, module) for number, module in numbered_modules if number is not None]


def _slot(number: int, module: ModuleRecord) -> ExportSlot:
    """Return the slot of a module. The catalog number, or the sizes of generic data, can make it a 3601."""
    kind, why = simulated(module.catalog), ""
    if "3601" in module.catalog:
        kind = STEPPER
    elif module.catalog.partition("/")[0] == GENERIC and _has_the_sizes_of_a_3601(module):
        kind, why = STEPPER, "it has a 3601's sizes; if it is another module, remove these lines"
    sizes = [f"{prefix_of(module)}:{tag.suffix} of {tag.size} bytes" for tag in module.tags if tag.size]
    return ExportSlot(number, module.catalog, module.name, tags=", ".join(sizes), module=kind, why=why)


def _has_the_sizes_of_a_3601(module: ModuleRecord) -> bool:
    sizes = {tag.kind: tag.size for tag in module.tags}
    return sizes.get("OutputTag") == BYTES_OUT and sizes.get("InputTag") in BYTES_IN
