"""A trial: an imported controller runs in both back ends, scan by scan, from the same memory.

A rung counts as run if its program did all scans and both back ends had the same values in all variables
and the same fault after each of them. Refused rungs are empty in a trial. A major fault that both report ends
the scan, not the trial; a watchdog fault ends the trial, because such a program does no second scan. Programs
that no task runs, and add-on instructions, run in their own controllers.

The interpreter counts rungs and statements, because loops and nested calls can make a scan endless. Too many
end the trial. The limit is a count, not a time, so that reports are reproducible.
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

from .assembly import Parts, does_nothing, harness_of, implicit_task, owner_of, trial_tasks
from .importer import L5xImport

SCANS = 100
"""Scans of a trial."""

MOST_IN_SCAN = 1_000_000
"""Maximum rungs and statements per scan: more than a controller executes within its watchdog of 500 ms."""

MOST_IN_ALL = 4_000_000
"""Maximum rungs and statements in a trial: over twice what 15,000 rungs take in 100 scans."""


def run_trial(imported: L5xImport, scans: int = SCANS) -> None:
    """Run an import; report executed rungs, faults and differences."""
    parts, report, work = imported.parts, imported.report, Work(scans)
    if imported.controller is not None:
        tasks = parts.tasks or implicit_task([program.name for program in parts.programs.values()])
        run = {name.upper() for task in tasks for name in task.programs}
        unrun = [program.name for name, program in parts.programs.items() if name not in run]
        _run(imported, parts, tasks, imported.controller, work)
        if unrun:
            _run(imported, parts, trial_tasks(parts, unrun), None, work)
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
    """Run the programs of tasks; after a fault run them again, with fault routines that clear it.

    After a fault that they can't clear, such as a watchdog fault, each program runs alone.
    """
    names = [name for task in tasks for name in task.programs]
    report = imported.report
    try:
        outcome = lockstep(controller or parts.assemble(report, tasks), work)
    except TooLongError as error:
        _refuse_too_long(imported, parts, tasks, error, work)
        return
    except BuildError as error:  # caused by one of the programs, since each rung can be built
        report.faults[names[0] if names else parts.name] = f"it can't be tried: {error.problems[0].text}"
        if len(names) > 1:
            _run_each(imported, parts, names, work)
        return
    if outcome.fault:
        report.faults[outcome.program or parts.name] = outcome.fault
        if len(names) > 1:
            outcome = lockstep(parts.with_fault_routines().assemble(report, tasks), work)
    if outcome.scans and not outcome.difference:
        _count(imported, names)
    elif len(names) == 1:
        report.faults[names[0]] = outcome.difference or outcome.fault
    else:
        _run_each(imported, parts, names, work)


def _refuse_too_long(
    imported: L5xImport, parts: Parts, tasks: Sequence[Task], error: TooLongError, work: Work
) -> None:
    """Run the programs of tasks, without the routine that is too long."""
    owner, routine = owner_of(error.site.routine)
    if imported.reader.refuse_routine(owner, routine, error.reason, error.remedy):
        _run(imported, _without(parts, owner, routine), tasks, None, work)
    else:
        imported.report.faults[owner] = error.reason


def _run_each(imported: L5xImport, parts: Parts, names: Iterable[str], work: Work) -> None:
    """Run each program alone."""
    for name in names:
        _run(imported, parts, trial_tasks(parts, [name]), None, work)


def _without(parts: Parts, owner: str, routine: str) -> Parts:
    """Return the parts with a routine emptied."""
    part, definition = parts.programs.get(owner.upper()), parts.add_ons.get(owner.upper())
    if part is not None and routine.upper() in part.routines:
        part.functions[routine.upper()] = does_nothing(part.routines.pop(routine.upper()).name)
    elif definition is not None:
        other_routines = (
            candidate for candidate in definition.routines if candidate.name.upper() != routine.upper()
        )
        parts.add_ons[owner.upper()] = definition.with_routines((Routine(routine, ()), *other_routines))
    return parts


def _count(imported: L5xImport, names: Iterable[str]) -> None:
    """Count the executed rungs of programs and add-ons."""
    for name in names:
        part = imported.parts.programs.get(name.upper())
        definition = imported.parts.add_ons.get(name.upper())
        routines = part.routines.values() if part else definition.routines if definition else ()
        for routine in routines:
            imported.report.ran += imported.reader.accepted(name, routine.name)
            imported.reader.ran(name, routine.name)


@dataclass(slots=True)
class Outcome:
    """The outcome of a trial."""

    scans: bool = False  # whether all scans were completed
    fault: str = ""  # the first major fault; "" if there was none
    program: str = ""  # its program
    difference: str = ""  # the first difference; "" if there was none


def lockstep(controller: LadderLogic, work: Work) -> Outcome:
    """Run a controller or program on both back ends; compare after each scan."""
    outcome = Outcome()
    compiled, interpreted = controller.compile(), controller.interpret()
    for number in range(work.scans):
        try:
            interpreted_scan = work.scan(interpreted)
        except OutOfLinesError as error:
            outcome.fault, outcome.program = f"scan {number}: {error}", ""
            return outcome
        compiled_scan = _scan(compiled)
        if str(compiled_scan) != str(interpreted_scan):
            outcome.difference = f"scan {number}: compiled {compiled_scan}, interpreted {interpreted_scan}"
            return outcome
        if compiled_scan is None:
            different = _different(compiled, interpreted)
            if different:
                outcome.difference = f"scan {number}: {different}"
                return outcome
        elif not outcome.fault:
            outcome.fault, outcome.program = f"scan {number}: {compiled_scan}", compiled_scan.site.program
        if compiled_scan is not None and compiled_scan.type == WATCHDOG_TYPE:
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
    """Return the name of a variable whose values differ; "" if there is none."""
    their_cells = theirs.memory.cells
    for ident, cell in ours.memory.cells.items():
        our_value, their_value = cell.cell_contents, their_cells[ident].cell_contents
        if our_value != their_value and not same(_plain(our_value), _plain(their_value)):
            return f"{ident} is {_plain(our_value)!r} compiled and {_plain(their_value)!r} interpreted"[:300]
    return ""


def _plain(value: Any) -> Any:
    if isinstance(value, TagBytes):
        return value.saved()
    return value.tolist() if isinstance(value, memoryview) else value
