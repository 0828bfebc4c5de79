"""Declared tasks, and the schedule that the back ends follow.

| task | runs |
|---|---|
| continuous | once per scan; at most one |
| periodic | at multiples of its rate after power-up |
| event | after EVENT has triggered it |

Between two scans of the continuous task, all due tasks run, lowest priority number first. Tasks of equal
priority run in order of declaration. A task that becomes due again before it has run counts an overlap.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from scanrack.io_images.dataclass import dataclass

from .errors import LadderError
from .tags import Layout, Leaf
from .types import BOOL, DINT, INT, LINT

PRIORITIES = range(1, 16)
"""Priorities of a task; 1 runs first [1756-PM005, tasks]."""

LONGEST_NS = 2_000_000 * 1_000_000
"""The longest period of a periodic task: 2,000 s [1756-PM005, tasks]."""


class TaskKind(Enum):
    """Condition that makes a task due."""

    CONTINUOUS = "CONTINUOUS"
    PERIODIC = "PERIODIC"
    EVENT = "EVENT"


@dataclass(frozen=True, slots=True)
class Task:
    """A task of a controller; raises a LadderError if its rate or priority is out of range or not allowed."""

    name: str
    kind: TaskKind
    programs: tuple[str, ...]  # in order of execution
    rate_ns: int = 0  # period of a periodic task, else 0
    priority: int = 10  # 1 to 15, 1 first
    preempt: bool = False  # whether it also runs at the end of a rung of the continuous task
    comment: str = ""

    def __post_init__(self) -> None:
        if self.kind is TaskKind.PERIODIC:
            if not 0 < self.rate_ns <= LONGEST_NS:
                raise LadderError(
                    f"task {self.name}: rate is {self.rate_ns} ns; must be above 0 and at most 2,000 s"
                )
        elif self.rate_ns:
            raise LadderError(f"task {self.name} is {self.kind.value}, so it can't have a rate")
        if self.priority not in PRIORITIES:
            raise LadderError(f"task {self.name}: priority is {self.priority}; must be 1 to 15")
        if self.preempt and self.kind is TaskKind.CONTINUOUS:
            raise LadderError(f"task {self.name} is CONTINUOUS, so it can't preempt")


@dataclass(frozen=True, slots=True)
class ScheduledProgram:
    """A program in a schedule."""

    name: str
    main: str | None  # its main routine, in capitals; None without routines
    fault: str | None  # its fault routine, in capitals; None without one
    started: Leaf  # leaf that is true from its first scan on
    fault_type: Leaf  # leaf with the type of its latest major fault, 0 without one
    fault_code: Leaf  # leaf with the code of its latest major fault, 0 without one


@dataclass(frozen=True, slots=True)
class ScheduledTask:
    """A task in a schedule."""

    task: Task
    programs: tuple[ScheduledProgram, ...]
    due: Leaf  # leaf with the time at which it is due next, ns
    pending: Leaf  # leaf that is true while an event task is due
    overlaps: Leaf  # leaf with the number of its overlaps


@dataclass(frozen=True, slots=True)
class Schedule:
    """The tasks in order of declaration; their state is in the memory, so snapshots include it."""

    tasks: tuple[ScheduledTask, ...]
    previous_scan: Leaf  # leaf with the time of the previous scan, ns; -1 before the first

    @property
    def continuous(self) -> ScheduledTask | None:
        """The continuous task, or None."""
        return next((task for task in self.tasks if task.task.kind is TaskKind.CONTINUOUS), None)

    @property
    def called(self) -> tuple[ScheduledTask, ...]:
        """The other tasks, by priority and declaration."""
        called = [task for task in self.tasks if task.task.kind is not TaskKind.CONTINUOUS]
        return tuple(sorted(called, key=lambda scheduled: scheduled.task.priority))

    @property
    def programs(self) -> tuple[ScheduledProgram, ...]:
        """All programs in task order."""
        return tuple(program for task in self.tasks for program in task.programs)

    @property
    def roots(self) -> frozenset[str]:
        """Main and fault routines, in capitals."""
        return frozenset(name for program in self.programs for name in (program.main, program.fault) if name)

    @property
    def preempted(self) -> frozenset[str]:
        """Programs, in capitals, that another task can interrupt after a rung."""
        if self.continuous is None or not any(task.task.preempt for task in self.tasks):
            return frozenset()
        return frozenset(program.name.upper() for program in self.continuous.programs)


@dataclass(frozen=True, slots=True)
class ProgramRoutines:
    """Full names of a program's main and fault routines, in capitals; None for a missing routine."""

    name: str
    main: str | None
    fault: str | None


def schedule_of(layout: Layout, tasks: Iterable[Task], programs: Iterable[ProgramRoutines]) -> Schedule:
    """Return the schedule of tasks, with leaves for their state."""
    programs_by_name = {program.name.upper(): _scheduled_program(layout, program) for program in programs}
    scheduled = tuple(
        _scheduled_task(layout, task, tuple(programs_by_name[name.upper()] for name in task.programs))
        for task in tasks
    )
    return Schedule(scheduled, layout.hidden("~scan.before", LINT))


def _scheduled_program(layout: Layout, program: ProgramRoutines) -> ScheduledProgram:
    """Return a program for the schedule, with new leaves for its state."""
    path = f"~program.{program.name}"
    return ScheduledProgram(
        program.name,
        program.main,
        program.fault,
        started=layout.hidden(f"{path}.started", BOOL),
        fault_type=layout.hidden(f"{path}.fault_type", INT),
        fault_code=layout.hidden(f"{path}.fault_code", INT),
    )


def _scheduled_task(layout: Layout, task: Task, programs: tuple[ScheduledProgram, ...]) -> ScheduledTask:
    """Return a task for the schedule, with new leaves for its state."""
    path = f"~task.{task.name}"
    return ScheduledTask(
        task,
        programs,
        due=layout.hidden(f"{path}.due", LINT),
        pending=layout.hidden(f"{path}.pending", BOOL),
        overlaps=layout.hidden(f"{path}.overlaps", DINT),
    )


def task_named(tasks: Iterable[ScheduledTask], name: str) -> ScheduledTask | None:
    """Return a task by its name in any case; None if it does not exist."""
    return next((task for task in tasks if task.task.name.upper() == name.upper()), None)
