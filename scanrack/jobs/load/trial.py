"""Tries out an export: imports it and runs some scans of its program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.input_files import open_input
from scanrack.io_images.text_limits import EXPORT_MIB
from scanrack.ladder.lowering.checks import IDEAL, ideal_motion_of
from scanrack.ladder.model.stubs import Stubs
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.report import Report
from scanrack.rockwell.l5x.trial import SCANS, run_trial
from scanrack.rockwell.slc import import_slc
from scanrack.rockwell.slc.trial import run_trial as run_slc_trial

from .program import SLC_SUFFIXES

if TYPE_CHECKING:
    from scanrack.rockwell.l5x import L5xImport
    from scanrack.rockwell.slc import SlcImport


@dataclass(frozen=True, slots=True)
class Trial:
    """Settings for the trial of an export."""

    scans: int = SCANS
    stand_in: bool = False  # whether to declare names that an L5X uses but lacks
    memory_mib: int = EXPORT_MIB  # largest memory for its tags, MiB


def tried(path: Path, trial: Trial = Trial()) -> L5xImport | SlcImport:
    """Import an export and run a trial; raise LadderError if the file can't be used."""
    if is_slc(path):
        program = import_slc(path, trial=True)
        run_slc_trial(program, trial.scans)
        return program
    stubs = Stubs(missing_tags=trial.stand_in)
    imported = import_l5x(path, stubs, trial=True, memory_mib=trial.memory_mib)
    run_trial(imported, trial.scans)
    if imported.controller is not None:
        for axis, names in ideal_motion_of(imported.controller.build()).items():
            _note_axis(imported.report, axis, names)
    return imported


def _note_axis(report: Report, axis: str, names: list[str]) -> None:
    """Note in the report which motion instructions of an axis move an ideal axis, and which end with ER."""
    ideal = [name for name in names if name in IDEAL]
    unsupported = [name for name in names if name not in IDEAL]
    if ideal:
        report.note(axis, f"{', '.join(ideal)} move an ideal axis, unless [axes] binds it to a 3601")
    if unsupported:
        report.note(
            axis, f"{', '.join(unsupported)} end with ER, ERR 25: an ideal axis does not support them"
        )


def is_slc(path: Path) -> bool:
    """Return whether a file is an RSLogix 500 export: by suffix, or because it does not begin like XML."""
    if path.suffix in SLC_SUFFIXES or path.suffix.upper() == ".L5X":
        return path.suffix in SLC_SUFFIXES
    try:
        with open_input(path) as file:
            begin = file.read(200)
    except OSError:
        return False
    return bool(begin.strip()) and b"<" not in begin and b"\0" not in begin
