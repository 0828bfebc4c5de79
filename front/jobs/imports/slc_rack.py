"""A rack file for an export of RSLogix 500; `export_slots` has its slots."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path

from ...rockwell.slc import SlcImport
from ...rockwell.slc.records import SlotRecord
from .export_slots import STEPPER, ExportSlot, simulated, slot_tables, with_steppers
from .toml_text import comment, text


def rack_of_slc(imported: SlcImport, path: Path, steppers: Collection[str] = ()) -> str:
    """Return the text of a rack file; ValueError if the export has no such slot.

    Args:
        path: its file, which the rack file names.
        steppers: slots of modules that are 3601s.
    """
    slots = with_steppers(slots_of_slc(imported.document.slots.values()), steppers)
    lines = [f"program = {text(path.name)}", 'controller = "micrologix"', *slot_tables(slots)]
    for refused in sorted({each.reason for each in imported.report.refused}):
        lines += [comment(refused)] * ("there is no instruction" in refused)
    return "\n".join(lines) + "\n"


def slots_of_slc(slots: Iterable[SlotRecord]) -> list[ExportSlot]:
    """Return the slots beside the processor's."""
    return [_slot(each) for each in slots if each.number]


def _slot(slot: SlotRecord) -> ExportSlot:
    kind = STEPPER if slot.is_3601 else simulated(slot.catalog)
    sizes = [
        f"{way}:{slot.number} of {words} words"
        for way, words in (("I", slot.inputs), ("O", slot.outputs))
        if words
    ]
    return ExportSlot(slot.number, slot.catalog, slot.comment, ", ".join(sizes), kind)
