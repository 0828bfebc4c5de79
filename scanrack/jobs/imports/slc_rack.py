"""Writes a rack file for an RSLogix 500 export; `export_slots` writes its slots."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from scanrack.ladder.model.stubs import ALL_MESSAGES
from scanrack.rockwell.l5x.report import Report
from scanrack.rockwell.slc import SlcImport
from scanrack.rockwell.slc.records import SlotRecord
from scanrack.runtime.config.rackspec import EMPTY, REFUSED

from .export_slots import STEPPER, ExportSlot, simulated, slot_tables, with_steppers
from .toml_text import comment, text

MESSAGES = "done after 20 ms"
"""Stub for message instructions."""


def rack_of_slc(imported: SlcImport, path: Path, steppers: Collection[str] = ()) -> str:
    """Return the text of a rack file; raise ValueError if the export lacks one of the `steppers`.

    Args:
        path: the program that the rack file names.
        steppers: slots whose modules are 3601s.
    """
    slots = with_steppers(slots_of_slc(imported.document.slots.values()), steppers)
    lines = [f"program = {text(path.as_posix())}", 'controller = "micrologix"', *_stubs(imported.report)]
    lines += slot_tables(slots)
    reasons = sorted({refusal.reason for refusal in imported.report.refused})
    lines += [comment(reason) for reason in reasons if "no instruction" in reason]
    return "\n".join(lines) + "\n"


def _stubs(report: Report) -> Iterator[str]:
    """Yield the stubs for messages and for refused instructions."""
    stubs = []
    if ALL_MESSAGES in report.stubs:
        stubs.append(f"{ALL_MESSAGES} = {text(MESSAGES)}")
    if not report.complete:
        stubs.append(f"{REFUSED} = {text(EMPTY)}    # refused parts do nothing")
    if stubs:
        yield from ("", "[stubs]", *stubs)


def slots_of_slc(slots: Iterable[SlotRecord]) -> list[ExportSlot]:
    """Return all slots except the processor's."""
    return [_slot(slot) for slot in slots if slot.number]


def _slot(slot: SlotRecord) -> ExportSlot:
    kind = STEPPER if slot.is_3601 else simulated(slot.catalog)
    images = {"I": slot.inputs, "O": slot.outputs}
    sizes = [f"{image}:{slot.number} of {words} words" for image, words in images.items() if words]
    return ExportSlot(slot.number, slot.catalog, slot.comment, ", ".join(sizes), kind)
