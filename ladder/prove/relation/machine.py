"""One scan of a program on terms: the interpreter's rows fork inside an instruction and merge after it.

`ScanMachine` is an interpreter that computes with terms. Power is a term, and so is `active`, the condition
that a place in the program is reached. A row that only reads and writes through the machine runs
unchanged. A row that jumps, calls or loops has `Spec.prove`. Any other instruction is a havoc: each place
that it can write becomes a new variable with any value.

If `ends` is true, a major fault ends the scan: tags keep their values at that point, and no scan follows. If
it is false, the scan continues, which is correct if no fault can occur. Because of havocs, the relation can
have more behaviors than the program, but never fewer. `deep` is the condition under which the relation does
not follow the program.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from ...model.schedule import ScheduledTask, TaskKind
from ...model.tags import OVERRIDE
from ...state.lowered import Arms, Body, Loop, LoweredLine, LoweredProgram, Selection
from ..algebra.meaning import BOOL, F64, INT
from ..algebra.numbers import add, le, wrap
from ..algebra.terms import FALSE, TRUE, T, and_, const, ite, not_, or_
from .calls import MOST_KNOWN_PASSES, TermCalls
from .paths import Path, merged
from .places import Key, kind_of
from .shapes import world_of
from .symbols import term_of

NOTHING: Mapping[Key, Any] = MappingProxyType({})


class ScanMachine(TermCalls):
    """Builds the terms of one scan.

    Args:
        lowered: the program.
        dt: minimum and maximum time since the previous scan, in units of `tick_ns`.
        known: values that no scan changes, by place. An example is LEN of a CONTROL, which limits loops.

    Attributes:
        state: the term after the scan of each place in use.
        vars: the variable of each place before the scan.
        leaves: the leaf of each place, which contains its type.
        written: the places that the scan can write.
        unmodeled: variables of values that are not modeled, with the instruction that writes them.
        cut: each instruction that is not modeled, with its name and the reason.
        faults: the condition for a major fault of each instruction, by number.
        stops: the condition under which any of these faults stops the processor.
        origins: the functions of the variables in `unmodeled`.
        deep: the condition under which the relation does not follow the program.
    """

    def __init__(
        self, lowered: LoweredProgram, dt: tuple[int, int] = (1, 1000), known: Mapping[Key, Any] = NOTHING
    ) -> None:
        super().__init__(lowered, dt, known)
        self.scheduler = TermScheduler(self)  # type: ignore[assignment]

    def scan_terms(self) -> None:
        """Run one scan and build its terms."""
        if self.lowered.override:
            self.set_status(OVERRIDE, False)
        self._scan()
        self.begin_again()

    def begin_again(self) -> None:
        """Prepare to run more routines after the scan, even if the scan has ended early."""
        self.active = TRUE
        self._ended = self.faulted = FALSE

    def _scan(self) -> None:
        """Run the tasks that can be due, the continuous task last; without tasks, run the main routine."""
        schedule = self.lowered.schedule
        if schedule is None:
            self.call_routine(self.lowered.main, ())
            return
        for task in schedule.called:
            with self.when(self._is_due(task)):
                self._task(task)
        if schedule.continuous is not None:
            self._task(schedule.continuous)

    def _is_due(self, task: ScheduledTask) -> T:
        """Return the condition under which a task runs; a periodic task must run after its period."""
        if task.task.kind is TaskKind.EVENT:
            pending = self.value_here(task.pending, 0)
            self.poke(task.pending, 0, FALSE)
            return pending
        period = const(-(-task.task.rate_ns // self.tick_ns))
        may_run = self.computed(("due", task.task.name, world_of(self.lowered)), (BOOL, 0, 0))
        old_count = self.value_here(task.overlaps, 0)
        kind = kind_of(task.overlaps.type)
        new_count = self.computed(("overlaps", task.task.name, world_of(self.lowered)), kind, old_count)
        self.poke(task.overlaps, 0, new_count)
        return or_(may_run, le(period, self.dt))

    def _task(self, task: ScheduledTask) -> None:
        """Run the programs of a task; S:FS is set in each program's first scan."""
        first = self.lowered.layout.leaf("S:FS")
        self.scheduler.period_ns = task.task.rate_ns  # type: ignore[union-attr]
        for program in task.programs:
            if program.main is None:
                continue
            self.poke(first, 0, not_(self.value_here(program.started, 0)))
            self.poke(program.started, 0, TRUE)
            if self.lowered.override:
                self.set_status(OVERRIDE, False)
            self.call_routine(program.main, ())
            self.poke(first, 0, FALSE)

    # --- rungs

    def _line(self, line: LoweredLine, inputs: Sequence[Any], *, statement: bool = False) -> Any:
        """Run a rung or statement; return its power. A rung in a disabled MCR zone starts without power."""
        self.inputs = inputs
        power = TRUE
        if self.lowered.override and not statement:
            power = not_(term_of(self.status(OVERRIDE), BOOL))
        return self._series(line.nodes, power)

    # --- structured text

    def _arms(self, arms: Arms, inputs: Sequence[Any]) -> None:
        """Run each arm of an IF where its condition is the first true condition; then run ELSE."""
        entry, remaining, ends = self.active, TRUE, FALSE
        for line, body in arms.arms:
            self.active = self._going_on(and_(entry, remaining))
            truth = self._line(line, inputs, statement=True)
            ends = or_(ends, self._body_where(and_(self.active, truth), body, inputs))
            remaining = and_(remaining, not_(truth))
        last = self._going_on(and_(entry, remaining))
        self.active = or_(ends, self._body_where(last, arms.otherwise, inputs))

    def _body_where(self, active: T, body: Body, inputs: Sequence[Any]) -> T:
        """Run statements where a condition is true; return the condition that they reach their end."""
        self.active = active
        self._body(body, inputs)
        return self.active

    def _selection(self, selection: Selection, inputs: Sequence[Any]) -> None:
        """Run each choice of a CASE where it is the first with the selector; any choice, if not modeled."""
        self._line(selection.line, inputs, statement=True)
        value, entry, remaining, ends = self.selected, self.active, TRUE, FALSE
        for ranges, body in selection.choices:
            chosen = self.unknown(BOOL) if value is None else FALSE
            for bounds in ranges if value is not None else ():
                low, high = (self.number(bound, selection.width) for bound in bounds)  # constants
                chosen = or_(chosen, and_(term_of(low <= value, BOOL), term_of(value <= high, BOOL)))
            ends = or_(ends, self._body_where(and_(entry, and_(remaining, chosen)), body, inputs))
            remaining = and_(remaining, not_(chosen))
        self.active = or_(ends, self._body_where(and_(entry, remaining), selection.otherwise, inputs))

    def _loop(self, loop: Loop, inputs: Sequence[Any]) -> None:
        """Run passes of a FOR, WHILE or REPEAT until all paths have left it, or up to the limits."""
        if loop.start is not None:
            self._line(loop.start, inputs, statement=True)
        outer, self._exits = self._exits, FALSE
        ends, undecided = FALSE, 0  # undecided: tests that end the loop on some paths
        for _ in range(MOST_KNOWN_PASSES):
            entry = self.active
            ends = or_(ends, self._left_by(loop.test, inputs, ends_if=False))
            if self.active is not entry:
                undecided += 1
            if self.active is FALSE or self._count_pass(undecided):
                break
            self._body(loop.body, inputs)
            if loop.advance is not None:
                self._line(loop.advance, inputs, statement=True)
            entry = self.active
            ends = or_(ends, self._left_by(loop.until, inputs, ends_if=True))
            if self.active is not entry:
                undecided += 1
        self._cut_pass(loop.site)
        self.active = or_(ends, self._exits)
        self._exits = outer

    def _left_by(self, line: LoweredLine | None, inputs: Sequence[Any], *, ends_if: bool) -> T:
        """Run the condition of a loop; return the condition under which it ends the loop."""
        if line is None:
            return FALSE
        truth = self._line(line, inputs, statement=True)
        ends = truth if ends_if else not_(truth)
        leaving = and_(self.active, ends)
        self.active = and_(self.active, not_(ends))
        return leaving

    def select(self, power: T, value: Callable[[], Any]) -> T:
        """Evaluate a CASE selector; return None if it is not modeled, so any branch can run."""
        self.selected: Any = None
        chosen: list[Any] = []

        def run() -> Any:
            chosen.append(value())
            return chosen[-1]

        def number(path: Path) -> T:
            return const(0, kind) if path.result is None else term_of(path.result, kind)

        paths = self.merge_paths(run)
        kind = F64 if any(map(self.is_float, chosen)) else INT
        self.selected = self.symbol(merged(paths, number))
        return power


class TermScheduler:
    """Schedules the tasks that EVENT makes due."""

    def __init__(self, machine: ScanMachine) -> None:
        self._machine = machine

    def trigger(self, task: ScheduledTask) -> None:
        """Make an event task due; if it is already due, an overlap can be counted."""
        machine = self._machine
        counted, width = machine.value_here(task.overlaps, 0), task.overlaps.type.wraps
        missed = ite(machine.value_here(task.pending, 0), wrap(add(counted, const(1)), width), counted)
        machine.poke(task.overlaps, 0, missed)
        machine.poke(task.pending, 0, TRUE)
