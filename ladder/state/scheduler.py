"""The scheduler of a controller's programs, in virtual time.

A scan of the rack runs each due task once, then the continuous task:

    scan            |             |             |
    periodic 4 ms   due  due  due due  due  due      -> runs once per scan, two overlaps each
    with preempt    runs at the end of the rung that is executing at 4 ms, 8 ms, ...

The time of a scan is its start time. For `preempt`, the rungs of the continuous task evenly share the time
from one scan to the next: rung `n` of `m` ends after `n / m` of that time.
"""

from __future__ import annotations

from collections.abc import Callable

from ..model.errors import LadderFault
from ..model.schedule import Schedule, ScheduledProgram, ScheduledTask, TaskKind
from ..model.tags import OVERRIDE, STATUS_FLAGS
from .fault_log import FaultLog
from .lowered import LoweredProgram
from .memory import Memory

PROGRAM_FAULT = 4
"""Type of the major faults that a fault routine may clear [1756-PM014]."""

Run = Callable[[str, int], object]
"""Runs a routine: its name in capitals, the time in ns."""


class Scheduler:
    """Runs the tasks of one controller."""

    def __init__(
        self, lowered: LoweredProgram, schedule: Schedule, memory: Memory, fault_log: FaultLog
    ) -> None:
        self._schedule, self._memory, self._fault_log = schedule, memory, fault_log
        layout = lowered.layout
        self._first = layout.leaf("S:FS")
        self._override = layout.leaf(OVERRIDE) if lowered.override else None
        self._flags = tuple(layout.leaf(name) for name in (*STATUS_FLAGS, OVERRIDE) if name != "S:MINOR")
        self._continuous, self._other_tasks = schedule.continuous, schedule.called
        self._preempting = tuple(task for task in self._other_tasks if task.task.preempt)
        self._total = max(1, _rungs_of(lowered, schedule))  # rungs of the continuous task
        self._run: Run = lambda _name, _now_ns: None
        self._start_ns = self._end_ns = 0  # of the scan, which is assumed to be as long as the previous one
        self._rungs = 0  # rungs of the continuous task that this scan has done
        self.handled = 0  # major faults so far that reached a fault routine
        self.period_ns = 0  # rate of the running task; 0 if it is not periodic

    def begin(self, now_ns: int, *, started: bool = False) -> None:
        """Initialize the state for a first scan; if `started` is set, S:FS is off in that scan."""
        write = self._memory.write
        write(self._schedule.previous_scan, 0, -1)
        for program in self._schedule.programs:
            for leaf, value in ((program.started, started), (program.fault_type, 0), (program.fault_code, 0)):
                write(leaf, 0, value)
        for task in self._schedule.tasks:
            rate = task.task.rate_ns
            write(task.due, 0, -(-now_ns // rate) * rate if rate else 0)
            write(task.pending, 0, False)
            write(task.overlaps, 0, 0)

    def scan(self, now_ns: int, run: Run) -> None:
        """Run the due tasks, then the continuous one; raise a LadderFault for an uncleared major fault."""
        self._run = run
        previous_ns = int(self._memory.read(self._schedule.previous_scan))
        self._memory.write(self._schedule.previous_scan, 0, now_ns)
        self._start_ns, self._rungs = now_ns, 0
        length_ns = now_ns - previous_ns if previous_ns >= 0 else 0  # -1 before the first scan
        self._end_ns = now_ns + length_ns
        for task in self._other_tasks:
            self._run_if_due(task, now_ns)
        if self._continuous is not None:
            self._run_task(self._continuous, now_ns)

    def rung_done(self) -> None:
        """Run the preempting tasks that are due at the end of a rung of the continuous task."""
        self._rungs += 1
        elapsed_ns = min(self._rungs, self._total) * (self._end_ns - self._start_ns) // self._total
        now_ns = min(self._start_ns + elapsed_ns, self._end_ns - 1)
        for task in self._preempting:
            if self._is_due(task, now_ns):
                saved_flags = [self._memory.read(leaf) for leaf in self._flags]
                self._run_if_due(task, now_ns)
                for leaf, value in zip(self._flags, saved_flags, strict=True):
                    self._memory.write(leaf, 0, value)

    def trigger(self, task: ScheduledTask) -> None:
        """Make an event task due; count an overlap if it is already due."""
        if self._memory.read(task.pending):
            self._count_overlaps(task, 1)
        self._memory.write(task.pending, 0, True)

    def _is_due(self, scheduled: ScheduledTask, now_ns: int) -> bool:
        if scheduled.task.kind is TaskKind.EVENT:
            return bool(self._memory.read(scheduled.pending))
        return int(self._memory.read(scheduled.due)) <= now_ns

    def _run_if_due(self, scheduled: ScheduledTask, now_ns: int) -> None:
        """Run a task if it is due; if it missed periods, count them as overlaps."""
        if not self._is_due(scheduled, now_ns):
            return
        if scheduled.task.kind is TaskKind.EVENT:
            self._memory.write(scheduled.pending, 0, False)
        else:
            due, rate = int(self._memory.read(scheduled.due)), scheduled.task.rate_ns
            missed = (now_ns - due) // rate
            self._memory.write(scheduled.due, 0, due + (missed + 1) * rate)
            if missed:
                self._count_overlaps(scheduled, missed)
        self._run_task(scheduled, now_ns)

    def _count_overlaps(self, scheduled: ScheduledTask, count: int) -> None:
        self._memory.write(scheduled.overlaps, 0, int(self._memory.read(scheduled.overlaps)) + count)

    def _run_task(self, scheduled: ScheduledTask, now_ns: int) -> None:
        """Run the programs of a task; set `period_ns` to its rate, and restore it even after a fault."""
        outer_period_ns, self.period_ns = self.period_ns, scheduled.task.rate_ns
        try:
            for program in scheduled.programs:
                if program.main is not None:
                    self._run_program(program, program.main, now_ns)
        finally:
            self.period_ns = outer_period_ns

    def _run_program(self, program: ScheduledProgram, main: str, now_ns: int) -> None:
        """Run a program's main routine, and its fault routine after a major fault."""
        write = self._memory.write
        first = not self._memory.read(program.started)
        write(self._first, 0, first)
        write(program.started, 0, True)
        if self._override is not None:
            write(self._override, 0, False)
        depth = self._fault_log.depth
        try:
            self._run(main, now_ns)
        except LadderFault as fault:
            self._fault_log.depth = depth
            if fault.type != PROGRAM_FAULT or program.fault is None:
                raise
            self._run_fault_routine(program, program.fault, fault, now_ns)
        finally:
            write(self._first, 0, False)

    def _run_fault_routine(
        self, program: ScheduledProgram, routine: str, fault: LadderFault, now_ns: int
    ) -> None:
        """Run a fault routine; if it clears the fault, the rest of the program's scan is skipped."""
        self.handled += 1
        write, read = self._memory.write, self._memory.read
        write(program.fault_type, 0, fault.type)
        write(program.fault_code, 0, fault.code)
        if self._override is not None:
            write(self._override, 0, False)
        self._run(routine, now_ns)
        if read(program.fault_type) or read(program.fault_code):
            raise fault


def _rungs_of(lowered: LoweredProgram, schedule: Schedule) -> int:
    """Count the rungs of the continuous task's programs."""
    return sum(
        len(routine.lines) for routine in lowered.routines.values() if lowered.is_preempted(routine.name)
    )
