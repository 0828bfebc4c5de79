"""A trial: an imported controller runs in the interpreter and compiled, scan by scan, from the same memory.

A rung counts as run if its program did all scans and both back ends had the same values in all variables
and the same fault after each of them. Refused rungs are empty in it. A major fault that both report ends the
scan and not the trial; the watchdog ends the trial, since such a program does no second scan. Programs that
no task runs, and add-on instructions, run in controllers of their own.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..controller import Controller
from ..engine import Engine
from ..errors import WATCHDOG_TYPE, LadderFault
from ..memory import same
from ..runnable import LadderLogic
from .assembly import Parts, harness_of
from .importer import Imported, implicit_task

SCANS = 100
"""Scans of a trial."""


def run_trial(imported: Imported, scans: int = SCANS) -> None:
    """Run what was imported; count in its report the rungs that ran, and note faults and differences."""
    parts, report = imported.parts, imported.report
    if imported.controller is not None:
        run = [name for task in parts.tasks for name in task.programs]
        scheduled = [name for name in run if name.upper() in parts.programs]
        others = [each.name for each in parts.programs.values() if each.name not in scheduled]
        if not parts.tasks:
            scheduled, others = others, []
        for names, controller in ((scheduled, imported.controller), (others, None)):
            if names:
                _programs(imported, names, controller, scans)
    if parts.add_ons:
        _add_ons(imported, scans)
    report.ran = min(report.ran, report.imported)


def _programs(imported: Imported, names: list[str], controller: Controller | None, scans: int) -> None:
    """Run programs together; after a fault each alone, so that one does not keep the others from running."""
    made = controller or imported.parts.assemble(imported.report, implicit_task(names))
    outcome = lockstep(made, scans)
    if outcome.fault and len(names) > 1:
        for name in names:
            alone = imported.parts.assemble(imported.report, implicit_task([name]))
            _count(imported, [name], lockstep(alone, scans))
    else:
        _count(imported, names, outcome)


def _count(imported: Imported, names: Iterable[str], outcome: Outcome) -> None:
    for name in names:
        text = outcome.difference or outcome.fault
        if text:
            imported.report.faults[name] = text
        if outcome.scans and not outcome.difference:
            part = imported.parts.programs[name.upper()]
            imported.report.ran += sum(
                imported.reader.accepted(part.name, each.name) for each in part.routines.values()
            )


def _add_ons(imported: Imported, scans: int) -> None:
    parts: Parts = harness_of(imported.parts)
    outcome = lockstep(parts.assemble(imported.report), scans)
    if outcome.difference or outcome.fault:
        imported.report.faults["add-on instructions"] = outcome.difference or outcome.fault
    if outcome.scans and not outcome.difference:
        imported.report.ran += sum(
            imported.reader.accepted(each.name, role.name)
            for each in imported.parts.add_ons.values()
            for role in each.routines
        )


class Outcome:
    """What a trial showed.

    Attributes:
        scans: whether all scans were done.
        fault: the first major fault, "" without one.
        difference: the first difference, "" without one.
    """

    def __init__(self) -> None:
        self.scans = False
        self.fault = ""
        self.difference = ""


def lockstep(controller: LadderLogic, scans: int = SCANS) -> Outcome:
    """Run a controller or a program on both back ends and compare after each scan."""
    outcome = Outcome()
    compiled, interpreted = controller.compile(), controller.interpret()
    for number in range(scans):
        ours, theirs = _scan(compiled), _scan(interpreted)
        if str(ours) != str(theirs):
            outcome.difference = f"scan {number}: compiled {ours}, interpreted {theirs}"
            return outcome
        if ours is None:
            different = _different(compiled, interpreted)
            if different:
                outcome.difference = f"scan {number}: {different}"
                return outcome
        elif not outcome.fault:
            outcome.fault = f"scan {number}: {ours}"
        if ours is not None and ours.type == WATCHDOG_TYPE:
            return outcome
    outcome.scans = True
    return outcome


def _scan(engine: Engine) -> LadderFault | None:
    try:
        engine.step()
    except LadderFault as fault:
        return fault
    return None


def _different(ours: Engine, theirs: Engine) -> str:
    """Return a variable in which two memories differ, "" if there is none."""
    there = theirs.memory.cells
    for ident, cell in ours.memory.cells.items():
        one, other = cell.cell_contents, there[ident].cell_contents
        if one != other and not same(_plain(one), _plain(other)):
            return f"{ident} is {_plain(one)!r} compiled and {_plain(other)!r} interpreted"[:300]
    return ""


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, memoryview) else value
