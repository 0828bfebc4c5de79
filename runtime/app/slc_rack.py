"""A rack file for an export of RSLogix 500: a 3601 in each slot where the export has one."""

from __future__ import annotations

from pathlib import Path

from ...ladder.slc import Imported
from .toml_text import comment, text


def rack_of_slc(imported: Imported, path: Path) -> str:
    """Return the text of a rack file.

    Args:
        imported: the export.
        path: its file, which the rack file names.
    """
    slots = imported.document.slots.values()
    lines = [f"program = {text(path.name)}", 'controller = "micrologix"']
    for slot in slots:
        if slot.number and slot.is_3601:
            lines += ["", "[[slot]]", f"number = {slot.number}", 'module = "amci3601"']
        elif slot.number:
            lines += [
                "",
                comment(f"slot {slot.number}: {slot.text}: memory, unless another module sits there"),
            ]
    if "[[slot]]" not in lines:
        lines += ["", "# the export names no 3601", "[[slot]]", "number = 1", 'module = "amci3601"']
    for refused in sorted({each.reason for each in imported.report.refused}):
        lines += [comment(refused)] * ("there is no instruction" in refused)
    return "\n".join(lines) + "\n"
