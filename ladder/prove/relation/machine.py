"""One scan of a program on terms: the interpreter's own rows, forked inside an instruction, merged behind it.

`ScanMachine` is an interpreter whose values are terms. Power, and whether a place in the program is reached
(`active`), are terms too. A row that only reads and writes through the machine needs nothing else; one that
jumps, calls or loops has `Spec.prove`. What neither covers havocs: each place that it may write gets a new
variable, which may have any value.

A scan that faults goes on, and what is havocked may be anything: the relation has more behaviours than the
program, never fewer. Where it stops following the program, `deep` says under which condition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from types import MappingProxyType
from typing import Any

from ....io_images.site import Site
from ...instructions.slc.processor import before_scan, has_status
from ...instructions.slc.status import STATUS
from ...model.operands import Calculation, Constant, Group, Place, Resolved, StringConstant, leaves_in
from ...model.schedule import ScheduledTask, TaskKind
from ...model.spec import InstructionKind, Use
from ...model.tags import OVERRIDE, OWN, Leaf
from ...model.types import HIDDEN, leaves_of
from ...state.lowered import (
    BROKEN,
    AddOnCall,
    Arms,
    Body,
    Call,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)
from ..algebra.meaning import BOOL, INT
from ..algebra.numbers import le, lt
from ..algebra.terms import FALSE, TRUE, T, and_, const, ite, not_, or_
from .places import Key
from .symbols import UnmodelledError, term_of
from .values import TermValues

MOST_PASSES = 64
"""Maximum passes of a loop whose end is not known."""

MOST_PASSES_OF_A_SCAN = 192
"""The same of all loops in a scan."""

MOST_KNOWN_PASSES = 2048
"""Maximum passes of a loop in all."""

MOST_CALLS = 12
"""Maximum nesting of calls."""

_READ = frozenset(
    (
        *(Use.BIT, Use.NUMBER, Use.TEXT_OR_NUMBER, Use.INTEGER, Use.TEXT, Use.EXPRESSION, Use.CONDITION),
        *(Use.TRUTH, Use.SWITCH, Use.IGNORED, Use.SOURCE, Use.TABLE, Use.ITEM, Use.CONSTANT, Use.MODE),
        *(Use.KEYWORD, Use.LABEL),
    )
)
"""Uses of operands that an instruction does not write."""

_NEVER_WRITTEN = {Use.TIMER: (".PRE",), Use.COUNTER: (".PRE",), Use.CONTROL: (".LEN",)}
"""Members that an instruction of that use only reads."""

_ELSEWHERE = frozenset(("SSV", "EVENT", "SFR", "SFP", "EOT"))
"""Instructions that write more than their operands."""

_REFUSED = (
    *(UnmodelledError, TypeError, AttributeError, KeyError, ValueError, IndexError, ArithmeticError),
    RecursionError,
)
"""What a row on terms raises if it does something that has none."""

_OF_ROUTINE = ("active", "site", "inputs", "_pending", "_labels", "_number", "_answers", "_depth")
"""What a call keeps and restores."""

NOTHING: Mapping[Key, Any] = MappingProxyType({})

Answer = tuple[T, tuple[Any, ...]]
"""Results of a routine, and where it returns them."""


class ScanMachine(TermValues):
    """Builds the terms of one scan.

    Args:
        lowered: the program.
        dt: least and most ms since the scan before.
        known: values that no scan changes, by place: such as LEN of a CONTROL, which bounds loops.

    Attributes:
        state: the term of each place after the scan, as far as it is used.
        vars: the variable of each place before the scan.
        kinds: the leaf of each place.
        written: the places that the scan may write.
        rungs: each rung and statement with whether it is reached, and the power at its end.
        havocs: variables of what is not modelled, with the instruction.
        cut: each instruction that is not modelled, its name, and why.
        faults: numbers of instructions with the condition of a major fault.
        deep: where the relation does not follow the program.
    """

    def __init__(
        self, lowered: LoweredProgram, dt: tuple[int, int] = (1, 1000), known: Mapping[Key, Any] = NOTHING
    ) -> None:
        super().__init__(lowered, dt, known)
        self.deep: T = FALSE
        self.rungs: list[tuple[LoweredLine, T, T]] = []
        self.cut: list[tuple[Site, str, str]] = []
        self._labels: Mapping[str, int] = {}
        self._pending: dict[str, T] = {}  # where a jump to a label further down is taken
        self._number = 0  # of the rung that runs
        self._answers: list[Answer] = []
        self._exits: T = FALSE
        self._depth = 0
        self._passes = 0  # of all loops whose end is not known
        self._ended: T = FALSE  # where the scan has ended
        self.scheduler = TermScheduler(self)  # type: ignore[assignment]

    def scan_terms(self) -> None:
        """Run one scan."""
        if self.lowered.override:
            self.set_status(OVERRIDE, False)
        self._scan()
        self.active, self._ended = TRUE, FALSE  # what runs behind the scan does so wherever it ended

    def _scan(self) -> None:
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
        """Return whether a task runs: a periodic one may, and does if the scan took its period."""
        if task.task.kind is TaskKind.EVENT:
            pending = self.peek(task.pending, 0)
            self.poke(task.pending, 0, FALSE)
            return pending
        period = const(-(-task.task.rate_ns // 1_000_000))
        runs = or_(self.unknown(BOOL), le(period, self.dt))
        self.havoc(task.overlaps)
        return runs

    def _task(self, task: ScheduledTask) -> None:
        """Run the programs of a task; S:FS is set in the first scan of each."""
        first = self.lowered.layout.leaf("S:FS")
        for program in task.programs:
            if program.main is None:
                continue
            self.poke(first, 0, not_(self.peek(program.started, 0)))
            self.poke(program.started, 0, TRUE)
            if self.lowered.override:
                self.set_status(OVERRIDE, False)
            self.call_routine(program.main, ())
            self.poke(first, 0, FALSE)

    # --- rungs

    def _series(self, nodes: tuple[Node, ...], power: Any) -> Any:
        for node in nodes:
            power = self._branch(node, power) if isinstance(node, Parallel) else self.execute(node, power)
        return power

    def _branch(self, branch: Parallel, power: Any) -> Any:
        behind = FALSE
        for leg in branch.legs:
            behind = or_(behind, self._series(leg, power))
        return behind

    def _line(self, line: LoweredLine, inputs: Sequence[Any], *, statement: bool = False) -> Any:
        self.inputs = inputs
        power = TRUE
        if self.lowered.override and not statement:
            power = not_(term_of(self.status(OVERRIDE), BOOL))
        after = self._series(line.nodes, power)
        self.rungs.append((line, self.active, after))
        return after

    def execute(self, step: LoweredStep, power: Any) -> Any:
        """Run an instruction; return the power after it."""
        if self.paths.path is not None:
            raise UnmodelledError("an instruction that runs others")
        self.site = step.site
        spec, before, frame = step.spec, self.active, self.frame
        if power is FALSE and spec.kind is not InstructionKind.BOTH and not spec.decides:
            return FALSE
        try:
            if spec.prove is not None:
                return spec.prove(self, power, *step.operands)
            return self._derived(step, power)
        except _REFUSED as why:
            self.active, self.frame, self.site = before, frame, step.site
            return self._havoc(step, power, why)

    def _derived(self, step: LoweredStep, power: T) -> T:
        """Run the row of the interpreter on terms."""
        spec = step.spec
        if spec.leaves:
            raise UnmodelledError("it leaves the rung")
        if spec.kind is InstructionKind.BOTH or spec.decides:
            after = self.on_paths(lambda: spec.run(self, self.symbol(power), *step.operands))
            return after if spec.decides else power
        with self.when(power):
            after = self.on_paths(lambda: spec.run(self, *step.operands))
        return and_(power, after) if spec.kind is InstructionKind.INPUT else power

    @contextmanager
    def when(self, power: T) -> Iterator[None]:
        """Run the body where power holds."""
        before = self.active
        self.active = and_(before, power)
        try:
            yield
        finally:
            self.active = and_(before, not_(self._ended))

    # --- what is not modelled

    def _havoc(self, step: LoweredStep, power: T, why: Exception) -> T:
        """Let all that a step may write, and the power after it, be anything."""
        spec, site = step.spec, self.lowered.sites[step.site]
        self.cut.append((site, step.name, str(why)))
        acts = spec.kind is InstructionKind.BOTH or spec.decides
        if spec.leaves or step.name in _ELSEWHERE or not all(map(_is_plain, step.operands)):
            self.deep = or_(self.deep, and_(self.active, power))
        with self.when(TRUE if acts else power):
            self._havoc_operands(step)
            for flag in ("S:MINOR", *(("S:V", "S:Z", "S:N", "S:C") if self.lowered.flags else ())):
                self.havoc(self.lowered.layout.leaf(flag))
            if before_scan in self.lowered.opening and has_status(self):
                self.havoc(self.lowered.layout.leaf(STATUS))
        if spec.decides:
            return self.unknown(BOOL)
        return and_(power, self.unknown(BOOL)) if spec.kind is InstructionKind.INPUT else power

    def _havoc_operands(self, step: LoweredStep) -> None:
        uses = step.uses
        for number, operand in enumerate(step.operands):
            use = uses[number] if number < len(uses) else Use.ANYTHING
            if use not in _READ and isinstance(operand, (Place, Group)):
                for leaf in (*leaves_in(operand), *hidden_in(operand)):
                    if not leaf.path.upper().endswith(_NEVER_WRITTEN.get(use, ())):
                        self.havoc(self._in_program(leaf))

    def _in_program(self, leaf: Leaf) -> Leaf:
        """Return the leaf that an add-on instruction's leaf stands for."""
        if not leaf.root:
            return leaf
        return self.lowered.layout.leaf(self.frame[leaf.root].path + leaf.rest)  # type: ignore[attr-defined]

    # --- routines

    def call_routine(self, name: str, inputs: Sequence[Any]) -> list[Answer]:
        """Run a routine; return its results, each with the condition of its return."""
        routine = self.lowered.routines.get(name)
        if routine is None:
            raise UnmodelledError("a routine in Python")
        if self._depth >= MOST_CALLS:
            raise UnmodelledError(f"calls more than {MOST_CALLS} deep")
        kept = {each: getattr(self, each) for each in _OF_ROUTINE}
        self._pending, self._labels, self._answers = {}, routine.labels, []
        self._depth += 1
        try:
            self._lines(routine, inputs)
            return self._answers
        finally:
            for each, value in kept.items():
                setattr(self, each, value)
            self.active = and_(self.active, not_(self._ended))

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Any]) -> None:
        if routine.body is not None:
            self._body(routine.body, inputs)
            return
        labels: dict[int, list[str]] = {}
        for label, number in routine.labels.items():
            labels.setdefault(number, []).append(label)
        for number, line in enumerate(routine.lines):
            for label in labels.get(number, ()):
                self.active = or_(self.active, self._pending.pop(label, FALSE))
            self._number = number
            self._line(line, inputs)

    def jump_to(self, power: T, label: str) -> T:
        """Go on at a label further down where power holds."""
        if self._labels[label] <= self._number:
            raise UnmodelledError("a jump backwards")
        self._pending[label] = or_(self._pending.get(label, FALSE), and_(self.active, power))
        return self._left(power)

    def return_from(self, power: T, values: tuple[Any, ...]) -> T:
        """Leave the routine with results where power holds."""
        self._answers.append((and_(self.active, power), values))
        return self._left(power)

    def end_scan(self, power: T) -> T:
        """End the scan where power holds."""
        self._ended = or_(self._ended, and_(self.active, power))
        return self._left(power)

    def exit_loop(self, power: T) -> T:
        """Leave the innermost loop where power holds."""
        self._exits = or_(self._exits, and_(self.active, power))
        return self._left(power)

    def _left(self, power: T) -> T:
        self.active = and_(self.active, not_(power))
        return FALSE

    def take_values(self, places: Sequence[Place | Group], values: Sequence[Any]) -> None:
        """Set tags to arguments or results, as many as both have."""
        for place, value in zip(places, values, strict=False):
            self.on_paths(partial(self.take, [place], [value]))

    def enter_with(self, power: T, places: Sequence[Place | Group]) -> T:
        """Take the arguments of the routine where power holds."""
        with self.when(power):
            self.take_values(places, self.inputs)
        return power

    def values_of(self, operands: Sequence[Resolved]) -> tuple[Any, ...]:
        """Return values to pass to a routine or out of it."""
        return tuple(map(self.value, operands))

    def call_with(self, power: T, call: Call) -> T:
        """Call a routine where power holds, and take its results."""
        with self.when(power):
            if self.active is not FALSE:
                answers = self.call_routine(call.routine, self.values_of(call.inputs))
                for where, values in answers:
                    with self.when(where):
                        self.take_values(call.returns, values)
        return power

    def loop_call(self, power: T, call: Call, index: Place, *bounds: Resolved) -> T:
        """Call a routine again and again while an index goes from one bound to another."""
        initial, terminal, step = bounds
        with self.when(power):
            self._set_index(index, lambda: self.integer(initial))
            passes = 0
            for _ in range(MOST_KNOWN_PASSES):
                entry = self.active
                self.active = and_(entry, not_(self._is_over(index, terminal, step)))
                passes += self.active is not entry
                if self.active is FALSE or self._is_long(passes):
                    break
                for where, values in self.call_routine(call.routine, ()):
                    if values is BROKEN:
                        self.active = and_(self.active, not_(where))
                self._set_index(index, lambda: self.integer(index) + self.integer(step))
            self._cut_pass(self.site)
        return power

    def _is_long(self, passes: int) -> bool:
        """Whether a loop, or all of the scan, has had too many passes without a known end."""
        self._passes += passes > 0
        return passes > MOST_PASSES or self._passes > MOST_PASSES_OF_A_SCAN

    def _is_over(self, index: Place, terminal: Resolved, step: Resolved) -> T:
        count, last, by = (term_of(self.integer(each), INT) for each in (index, terminal, step))
        return ite(lt(by, const(0)), lt(count, last), lt(last, count))

    def _set_index(self, index: Place, value: Callable[[], Any]) -> None:
        self.on_paths(lambda: self.put(index, self.converted(index.type, value())))

    # --- add-on instructions

    def call_add_on(self, power: T, call: AddOnCall) -> T:
        """Copy in, run the routine for the rung's state if there is one, copy out."""
        site, after = self.site, FALSE
        self._copies(call.inputs)
        self._put_power(call, power)
        for routine, condition in ((call.logic, power), (call.otherwise, not_(power))):
            if routine is None or condition is FALSE:
                continue
            with self.when(condition):
                self._run_add_on(call, routine)
                self.site = site
                self._copies(call.outputs)
                done = self.on_paths(lambda: self.get(call.enable_out))
            after = or_(after, and_(condition, done))
        return after

    def _put_power(self, call: AddOnCall, power: T) -> None:
        def put() -> None:
            self.put(call.enable_in, self.symbol(power))
            self.put(call.enable_out, self.symbol(power))

        self.on_paths(put)

    def _run_add_on(self, call: AddOnCall, routine: str) -> None:
        """Run a routine on the instance and the arguments of a call."""
        frames: list[dict[str, Any]] = []

        def look() -> None:
            frame = {name: self.handed(operand) for name, operand in call.handed.items()}
            frames.append({**frame, OWN: self.handed(call.instance)})

        self.on_paths(look)
        if len(frames) > 1:
            raise UnmodelledError("arguments that depend on the path")
        outer = self.frame
        for self.frame in frames:  # none if all paths fault
            self.call_routine(routine, ())
        self.frame = outer

    def _copies(self, copies: tuple[tuple[Node, ...], ...]) -> None:
        site, inputs = self.site, self.inputs
        for series in copies:
            self._series(series, TRUE)
        self.site, self.inputs = site, inputs

    # --- structured text

    def _arms(self, arms: Arms, inputs: Sequence[Any]) -> None:
        entry, left, ends = self.active, TRUE, FALSE
        for line, body in arms.arms:
            self.active = and_(entry, left)
            truth = self._line(line, inputs, statement=True)
            ends = or_(ends, self._body_where(and_(self.active, truth), body, inputs))
            left = and_(left, not_(truth))
        self.active = or_(ends, self._body_where(and_(entry, left), arms.otherwise, inputs))

    def _body_where(self, active: T, body: Body, inputs: Sequence[Any]) -> T:
        """Run statements where a truth holds; return where their end is reached."""
        self.active = active
        self._body(body, inputs)
        return self.active

    def _selection(self, selection: Selection, inputs: Sequence[Any]) -> None:
        self._line(selection.line, inputs, statement=True)
        value, entry, left, ends = self.selected, self.active, TRUE, FALSE
        for ranges, body in selection.choices:
            chosen = FALSE
            for bounds in ranges:
                low, high = (self.number(each, selection.width) for each in bounds)  # constants
                chosen = or_(chosen, and_(term_of(low <= value, BOOL), term_of(value <= high, BOOL)))
            ends = or_(ends, self._body_where(and_(entry, and_(left, chosen)), body, inputs))
            left = and_(left, not_(chosen))
        self.active = or_(ends, self._body_where(and_(entry, left), selection.otherwise, inputs))

    def _loop(self, loop: Loop, inputs: Sequence[Any]) -> None:
        if loop.start is not None:
            self._line(loop.start, inputs, statement=True)
        outer, self._exits = self._exits, FALSE
        ends, passes = FALSE, 0
        for _ in range(MOST_KNOWN_PASSES):
            entry = self.active
            ends = or_(ends, self._left_by(loop.test, inputs, ends_if=False))
            passes += self.active is not entry
            if self.active is FALSE or self._is_long(passes):
                break
            self._body(loop.body, inputs)
            if loop.advance is not None:
                self._line(loop.advance, inputs, statement=True)
            entry = self.active
            ends = or_(ends, self._left_by(loop.until, inputs, ends_if=True))
            passes += self.active is not entry
        self._cut_pass(loop.site)
        self.active = or_(ends, self._exits)
        self._exits = outer

    def _left_by(self, line: LoweredLine | None, inputs: Sequence[Any], *, ends_if: bool) -> T:
        """Run the condition of a loop; return where it ends the loop."""
        if line is None:
            return FALSE
        truth = self._line(line, inputs, statement=True)
        ends = truth if ends_if else not_(truth)
        left = and_(self.active, ends)
        self.active = and_(self.active, not_(ends))
        return left

    def _cut_pass(self, site: int) -> None:
        if self.active is not FALSE:
            self.cut.append((self.lowered.sites[site], "loop", f"more than {MOST_PASSES} passes"))
            self.deep = or_(self.deep, self.active)

    def select(self, power: T, value: Callable[[], Any]) -> T:
        """Take the selector of a CASE."""
        self.selected = value()
        return power


def hidden_in(operand: Place | Group) -> Iterator[Leaf]:
    """Yield the hidden leaves of a structure, at any depth."""
    if isinstance(operand, Group):
        for path, _, _ in leaves_of(operand.type):
            if path.rpartition(".")[2].startswith(HIDDEN):
                yield operand.layout.leaf(f"{operand.path}.{path}")


def _is_plain(operand: object) -> bool:
    """Whether an operand is all that an instruction may write by it; a routine or an axis is not."""
    return isinstance(operand, (Place, Group, Constant, Calculation, StringConstant, str))


class TermScheduler:
    """The tasks that EVENT makes due."""

    def __init__(self, machine: ScanMachine) -> None:
        self._machine = machine

    def trigger(self, task: ScheduledTask) -> None:
        """Make an event task due; if it is due already, it may count an overlap."""
        self._machine.poke(task.pending, 0, TRUE)
        self._machine.poke(task.overlaps, 0, self._machine.unknown_of(task.overlaps))
