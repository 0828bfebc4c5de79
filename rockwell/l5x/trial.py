"""Runs a trial of an imported controller in both back ends, scan by scan, from the same memory.

A rung counts as run if its program completed all scans, and both back ends had the same values in all
variables and the same fault after each scan. Refused rungs are empty in a trial. A major fault that both back
ends report ends the scan, not the trial. A watchdog fault ends the trial, because the program never completes
a scan. Programs that no task runs, and add-on instructions, run in their own controllers.

The interpreter counts rungs and statements, because loops and nested calls can make a scan endless. A trial
ends at a maximum count. The limit is a count and not a time, so that reports are reproducible.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.lowering.runnable import LadderLogic
from scanrack.ladder.model.errors import WATCHDOG_TYPE, BuildError, LadderFault, OutOfLinesError, TooLongError
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.schedule import Task
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.memory import same
from scanrack.ladder.state.tag_bytes import TagBytes

from .assembly import Parts, harness_of, idle_routine, implicit_task, owner_of, trial_tasks
from .importer import L5xImport

SCANS = 100
"""Number of scans in a trial."""

MOST_IN_SCAN = 1_000_000
"""Maximum rungs and statements per scan, more than a controller executes within its 500 ms watchdog."""

MOST_IN_ALL = 4_000_000
"""Maximum rungs and statements in a trial, more than twice the number for 15,000 rungs in 100 scans."""


def run_trial(imported: L5xImport, scans: int = SCANS) -> None:
    """Run an import; add the rungs that ran, faults and differences to its report."""
    parts, report, work = imported.parts, imported.report, Work(scans)
    if imported.controller is not None:
        tasks = parts.tasks or implicit_task([program.name for program in parts.programs.values()])
        scheduled = {name.upper() for task in tasks for name in task.programs}
        unscheduled = [program.name for name, program in parts.programs.items() if name not in scheduled]
        _run(imported, parts, tasks, imported.controller, work)
        if unscheduled:
            _run(imported, parts, trial_tasks(parts, unscheduled), None, work)
    if parts.add_ons:
        harness = harness_of(parts)
        _run(imported, harness, harness.tasks, None, work)
    report.ran = min(report.ran, report.imported)


class Work:
    """The budget of a trial."""

    def __init__(self, scans: int = SCANS) -> None:
        self.scans = scans  # per controller
        self.left = MOST_IN_ALL  # remaining rungs and statements of all controllers

    def scan(self, interpreted: Engine) -> LadderFault | None:
        """Run a scan in the interpreter; return its fault.

        Raises:
            OutOfLinesError: the budget is exhausted.
        """
        if self.left <= 0:
            raise OutOfLinesError(f"more than {MOST_IN_ALL:,} rungs and statements have run")
        interpreter = interpreted.interpreter
        interpreter.lines_left = allowed = min(self.left, MOST_IN_SCAN)
        try:
            return _scan(interpreted)
        except OutOfLinesError:
            raise OutOfLinesError(f"more than {allowed:,} rungs and statements run in it") from None
        finally:
            self.left -= allowed - interpreter.lines_left


def _run(
    imported: L5xImport, parts: Parts, tasks: Sequence[Task], controller: Controller | None, work: Work
) -> None:
    """Run the programs of tasks together, and count the rungs that ran.

    After a fault, they run again with fault routines that clear faults. If they still do not complete the
    scans, or the back ends differ, each program runs alone.

    Args:
        controller: the built controller with these tasks; None to build it.
    """
    names = [name for task in tasks for name in task.programs]
    report = imported.report
    try:
        outcome = lockstep(controller or parts.assemble(report, tasks), work)
    except TooLongError as error:
        _refuse_too_long(imported, parts, tasks, error, work)
        return
    except BuildError as error:  # every rung can be built, so one of the programs as a whole is the cause
        report.faults[names[0] if names else parts.name] = f"it can't be tried: {error.problems[0].text}"
        if len(names) > 1:
            _run_each(imported, parts, names, work)
        return
    if outcome.fault:
        report.faults[outcome.program or parts.name] = outcome.fault
        if len(names) > 1:
            outcome = lockstep(parts.with_fault_routines().assemble(report, tasks), work)
    if outcome.scans and not outcome.difference:
        _count_run_rungs(imported, names)
    elif len(names) == 1:
        report.faults[names[0]] = outcome.difference or outcome.fault
    else:
        _run_each(imported, parts, names, work)


def _refuse_too_long(
    imported: L5xImport, parts: Parts, tasks: Sequence[Task], error: TooLongError, work: Work
) -> None:
    """Refuse the routine that is too long, and run the programs of tasks without it."""
    owner, routine = owner_of(error.site.routine)
    if imported.reader.refuse_routine(owner, routine, error.reason, error.remedy):
        _empty(parts, owner, routine)
        _run(imported, parts, tasks, None, work)
    else:
        imported.report.faults[owner] = error.reason


def _run_each(imported: L5xImport, parts: Parts, names: Iterable[str], work: Work) -> None:
    """Run each program alone."""
    for name in names:
        _run(imported, parts, trial_tasks(parts, [name]), None, work)


def _empty(parts: Parts, owner: str, routine: str) -> None:
    """Empty a routine of a program or an add-on."""
    key = routine.upper()
    part, definition = parts.programs.get(owner.upper()), parts.add_ons.get(owner.upper())
    if part is not None and key in part.routines:
        part.functions[key] = idle_routine(part.routines.pop(key).name)
    elif definition is not None:
        other_routines = [other for other in definition.routines if other.name.upper() != key]
        parts.add_ons[owner.upper()] = definition.with_routines((Routine(routine, ()), *other_routines))


def _count_run_rungs(imported: L5xImport, names: Iterable[str]) -> None:
    """Count the imported rungs of programs and add-ons as run."""
    counted = {name.upper() for name in names}
    for owner, routine in imported.parts.all_routines():
        if owner.upper() in counted:
            imported.report.ran += imported.reader.imported_rungs(owner, routine.name)
            imported.reader.mark_run(owner, routine.name)


@dataclass(slots=True)
class Outcome:
    """The outcome of a trial."""

    scans: bool = False  # whether all scans were completed
    fault: str = ""  # the first major fault; "" without one
    program: str = ""  # the program of the fault
    difference: str = ""  # the first difference between the back ends; "" without one


def lockstep(controller: LadderLogic, work: Work) -> Outcome:
    """Run a controller or program on both back ends, and compare them after each scan; return the outcome.

    After a major fault, the scans continue, so that later rungs also run. A difference, an expired watchdog
    or an exhausted budget ends the trial.
    """
    outcome = Outcome()
    compiled, interpreted = controller.compile(), controller.interpret()
    for number in range(work.scans):
        try:
            interpreted_fault = work.scan(interpreted)
        except OutOfLinesError as error:
            outcome.fault, outcome.program = f"scan {number}: {error}", ""
            return outcome
        fault = _scan(compiled)
        if str(fault) != str(interpreted_fault):
            outcome.difference = f"scan {number}: compiled {fault}, interpreted {interpreted_fault}"
            return outcome
        if fault is None:
            difference = memory_difference(compiled, interpreted)
            if difference:
                outcome.difference = f"scan {number}: {difference}"
                return outcome
            continue
        if not outcome.fault:
            outcome.fault, outcome.program = f"scan {number}: {fault}", fault.site.program
        if fault.type == WATCHDOG_TYPE:
            return outcome
    outcome.scans = True
    return outcome


def _scan(engine: Engine) -> LadderFault | None:
    """Run a scan; return its major fault, or None."""
    try:
        engine.step()
    except LadderFault as fault:
        return fault
    return None


def memory_difference(compiled: Engine, interpreted: Engine) -> str:
    """Return the first variable that differs, with both values; "" if all are equal."""
    interpreted_cells = interpreted.memory.cells
    for name, cell in compiled.memory.cells.items():
        if cell.cell_contents == interpreted_cells[name].cell_contents:
            continue
        value, interpreted_value = _plain(cell.cell_contents), _plain(interpreted_cells[name].cell_contents)
        if not same(value, interpreted_value):  # two NaNs are the same
            return f"{name} is {value!r} compiled and {interpreted_value!r} interpreted"[:300]
    return ""


def _plain(value: Any) -> Any:
    """Return a value that can be compared and printed: bytes or a list for memory."""
    if isinstance(value, TagBytes):
        return value.saved()
    return value.tolist() if isinstance(value, memoryview) else value
