"""Trials, in which an imported program runs in both back ends, scan by scan, like an L5X."""

from __future__ import annotations

from scanrack.ladder.model.errors import TooLongError

from ..l5x.trial import SCANS, Work, lockstep
from .importer import SlcImport


def run_trial(imported: SlcImport, scans: int = SCANS) -> None:
    """Run an import; add the rungs that ran, a fault or a difference to its report."""
    program, report = imported.program, imported.report
    if program is None:
        return
    try:
        outcome = lockstep(program, Work(scans))
    except TooLongError as error:
        report.faults[program.name] = str(error)
        return
    if outcome.difference or outcome.fault:
        report.faults[program.name] = outcome.difference or outcome.fault
    if outcome.scans and not outcome.difference:
        report.ran = report.imported
