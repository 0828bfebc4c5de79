"""The interpreter: it executes a lowered program step by step, as the reference for the compiler.

Power flows from left to right. An input instruction reached by power determines the power after it. An output
instruction reached by power acts. Each instruction's function is in its `Spec`. This module executes rungs,
branches, statements, calls of routines, prescan and postscan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NoReturn

from ..model.errors import SUBSCRIPT_CODE, LadderError, LadderFault, OutOfLinesError
from ..model.operands import Constant, Group, Place, Resolved, first_leaf, place_of
from ..model.spec import InstructionKind
from ..model.tags import IGNORES_ARRAY_FAULTS, OVERRIDE, OWN
from ..model.types import count_of, size_of
from ..state.fault_log import FaultLog
from ..state.lowered import (
    Act,
    AddOnCall,
    Arms,
    Body,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)
from ..state.memory import InterpretedAddOnStore, Memory, Passed, Value
from ..state.scheduler import Scheduler
from .files import Elements
from .place_values import PlaceValues

Caller = Callable[[str, Sequence[Passed]], Sequence[Passed]]
"""Calls a Python routine by its name in capitals with input values, and returns its output values."""


LINES_OF_CALL = 30
"""Number of rungs that a call of an add-on instruction counts as."""


class _Jump(Exception):  # noqa: N818 - control flow, not an error
    def __init__(self, label: str, site: int) -> None:
        self.label, self.site = label, site


class _Return(Exception):  # noqa: N818
    def __init__(self, values: tuple[Passed, ...]) -> None:
        self.values = values


class _Exit(Exception):  # noqa: N818
    pass


class Interpreter(PlaceValues):
    """Runs a lowered program on a memory."""

    argument_type: type[InterpretedAddOnStore] = InterpretedAddOnStore
    """Class of the arguments of add-on instructions."""

    def __init__(
        self, lowered: LoweredProgram, memory: Memory, fault_log: FaultLog, call_python: Caller
    ) -> None:
        super().__init__(lowered, memory, fault_log)
        self.inputs: Sequence[Passed] = ()  # arguments of the current routine
        self.selected: Value = 0  # selector of the current CASE
        self.scheduler: Scheduler | None = None  # a controller's scheduler; None if a scan calls one routine
        self.prescanned: set[str] = set()  # recursive routines in prescan or postscan, in capitals
        self.lines_left = -1  # rungs and statements until an OutOfLinesError; negative without limit
        self._call_python = call_python
        self._preempted = frozenset(filter(lowered.is_preempted, lowered.routines))

    def scan(self, now_ns: int) -> None:
        """Run the main routine once, or the due tasks; can raise a LadderFault."""
        if self.scheduler is not None:
            self.scheduler.scan(now_ns, self._scheduled)
            return
        self.now_ns = now_ns
        if self.lowered.override:
            self.set_status(OVERRIDE, False)
        self.run(self.lowered.main, ())

    def _scheduled(self, name: str, now_ns: int) -> None:
        """Run a routine at the given instant, and restore the current instant afterward."""
        outer_now_ns, self.now_ns = self.now_ns, now_ns
        try:
            self.run(name, ())
        finally:
            self.now_ns = outer_now_ns

    def run(self, name: str, inputs: Sequence[Passed]) -> tuple[Passed, ...]:
        """Run a routine; return its results."""
        if name in self.lowered.functions:
            return tuple(self._call_python(name, inputs))
        routine = self.lowered.routines[name]
        try:
            self._lines(routine, inputs)
        except _Return as returned:
            return returned.values
        return ()

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Passed]) -> None:
        """Run a routine's structured text, or its rungs with jumps.

        Each jump backward counts toward a fault. After each rung of a preempted routine, the scheduler can
        run other tasks.
        """
        if routine.body is not None:
            self._body(routine.body, inputs)
            return
        number = 0
        while number < len(routine.lines):
            try:
                self._line(routine.lines[number], inputs)
                number += 1
                if self.scheduler is not None and routine.name.upper() in self._preempted:
                    self.scheduler.rung_done()
            except _Jump as jump:
                target = routine.labels[jump.label]
                if target <= number:
                    self.fault_log.jumped_back(jump.site)
                number = target

    def _line(self, line: LoweredLine, inputs: Sequence[Passed], *, statement: bool = False) -> bool:
        """Run a rung or statement, with power off in a disabled MCR zone; return the power after it."""
        self._count()
        power = statement or not (self.lowered.override and self.status(OVERRIDE))
        self.inputs = inputs
        return self._series(line.nodes, power)

    def _count(self) -> None:
        self.lines_left -= 1
        if self.lines_left == 0:
            raise OutOfLinesError

    def _series(self, nodes: tuple[Node, ...], power: bool) -> bool:
        for node in nodes:
            power = self._branch(node, power) if isinstance(node, Parallel) else self._step(node, power)
        return power

    def _branch(self, branch: Parallel, power: bool) -> bool:
        legs = [self._series(leg, power) for leg in branch.legs]
        return any(legs)  # all legs run

    def _step(self, step: LoweredStep, power: bool) -> bool:
        return self.execute(step, power)

    def execute(self, step: LoweredStep, power: bool) -> bool:
        """Run an instruction; return the power after it."""
        self.site = step.site
        spec = step.spec
        if spec.decides:
            return bool(spec.run(self, power, *step.operands))
        if spec.kind is InstructionKind.BOTH:
            spec.run(self, power, *step.operands)
            return power
        if not power:
            return False
        passed = spec.run(self, *step.operands)
        return bool(passed) if spec.kind is InstructionKind.INPUT else True

    # --- structured text

    def _body(self, body: Body, inputs: Sequence[Passed]) -> None:
        for statement in body:
            if isinstance(statement, Act):
                self._line(statement.line, inputs, statement=True)
            elif isinstance(statement, Arms):
                self._arms(statement, inputs)
            elif isinstance(statement, Selection):
                self._selection(statement, inputs)
            else:
                self._loop(statement, inputs)

    def _inside(self, _head: LoweredLine, body: Body, inputs: Sequence[Passed]) -> None:
        """Run the body of a statement."""
        self._body(body, inputs)

    def _arms(self, arms: Arms, inputs: Sequence[Passed]) -> None:
        """Run the body of the first arm with a true condition, otherwise the body of ELSE."""
        for line, body in arms.arms:
            if self._line(line, inputs, statement=True):
                self._inside(line, body, inputs)
                return
        last_line, _ = arms.arms[-1]
        self._inside(last_line, arms.otherwise, inputs)

    def _selection(self, selection: Selection, inputs: Sequence[Passed]) -> None:
        """Run the body of the first choice that contains the selector, otherwise the body of ELSE."""
        self._line(selection.line, inputs, statement=True)
        value = self.selected
        for ranges, body in selection.choices:
            for bounds in ranges:
                low, high = (self.number(bound, selection.width) for bound in bounds)
                if low <= value <= high:
                    self._inside(selection.line, body, inputs)
                    return
        self._inside(selection.line, selection.otherwise, inputs)

    def _loop(self, loop: Loop, inputs: Sequence[Passed]) -> None:
        """Run a loop until a condition or EXIT ends it; each repetition counts toward a fault."""
        if loop.start is not None:
            self._line(loop.start, inputs, statement=True)
        try:
            while loop.test is None or self._line(loop.test, inputs, statement=True):
                self._inside(loop.condition, loop.body, inputs)
                if loop.advance is not None:
                    self._line(loop.advance, inputs, statement=True)
                if loop.until is not None and self._line(loop.until, inputs, statement=True):
                    return
                self.fault_log.jumped_back(loop.site)
        except _Exit:
            return

    def leave_loop(self) -> NoReturn:
        """Leave the innermost loop."""
        raise _Exit

    # --- program control

    def jump(self, label: str) -> NoReturn:
        """Continue at the rung with a label."""
        raise _Jump(label, self.site)

    def leave(self, values: tuple[Passed, ...]) -> NoReturn:
        """Leave the routine with results."""
        raise _Return(values)

    def call(self, name: str, inputs: Sequence[Passed]) -> tuple[Passed, ...]:
        """Run a routine for the current instruction; return its results."""
        site, caller_inputs = self.site, self.inputs
        results = self.run(name, inputs)
        self.site, self.inputs = site, caller_inputs
        return results

    @contextmanager
    def within(self, call: AddOnCall) -> Iterator[None]:
        """Run the body of the `with` with the instance and arguments of a call."""
        if self.lines_left > 0:
            self.lines_left = max(1, self.lines_left - LINES_OF_CALL)
        frame = {name: self.handed(operand) for name, operand in call.handed.items()}
        site = self.lowered.sites[self.site]
        outer, self.frame = self.frame, {**frame, OWN: self.handed(call.instance)}
        try:
            yield
        except LadderFault as fault:
            fault.called_by(site)
            raise
        finally:
            self.frame = outer

    def handed(self, operand: Place | Group) -> InterpretedAddOnStore:
        """Return an operand as a store for an add-on instruction.

        An argument of the calling add-on instruction, or a part of one, is passed on as the original tag.
        """
        leaf = first_leaf(operand)
        indexed_dims = self.dims_of(leaf)[: len(operand.indices)]
        element = 0
        for index, length in zip(operand.indices, indexed_dims, strict=True):
            element = element * length + self.subscript(index, length, operand.text)
        element *= count_of(operand.dims)
        path, first, bit = operand.path, 0, None
        outer = self.frame[leaf.root] if leaf.root else None
        if outer is not None:  # the operand is an argument of the calling add-on instruction, or in one
            assert isinstance(outer, InterpretedAddOnStore)
            below_operand = len(leaf.path) - len(operand.path)
            path = outer.path + leaf.rest[: len(leaf.rest) - below_operand]
            first, bit = outer.first, outer.bit
        if outer is not None and leaf.root == operand.path.upper():
            left = outer.left - element
        else:
            array_length = count_of(operand.dims or operand.array)
            left = array_length - element % array_length
        elements_per_argument = count_of((*indexed_dims, *operand.dims)[leaf.outer :])
        if isinstance(operand, Place) and operand.bit is not None:
            bit = self.subscript(operand.bit, leaf.type.bits, operand.text)
        return self.argument_type(self.memory, path, first * elements_per_argument + element, left, bit)

    def value(self, operand: Resolved) -> Passed:
        """Return a value to pass to a routine; a structure or an array is passed as bytes."""
        if isinstance(operand, Group):
            return Elements(self, operand).take(0, count_of(operand.dims))
        return operand.value if isinstance(operand, Constant) else self.get(place_of(operand))

    def take(self, places: Sequence[Place | Group], values: Sequence[Passed]) -> None:
        """Set tags to arguments or results; extra tags or values are ignored."""
        for place, value in zip(places, values, strict=False):
            if isinstance(place, Group):
                self._take_group(place, value)
                continue
            self.clear_flags()
            self.store(place, value)  # type: ignore[arg-type]  # `checks` pairs bytes with structures

    def _take_group(self, group: Group, data: Passed) -> None:
        """Set a structure or an array from the bytes of another one of the same type."""
        count, size = count_of(group.dims), size_of(group.type)
        if not isinstance(data, bytes) or len(data) != size * count:
            text = f"a routine in Python returned {data!r} for {group.text}"
            raise LadderError(f"{text}; return {size * count} bytes")
        Elements(self, group).put(0, data, count)

    def copy_parameters(self, copies: tuple[tuple[Node, ...], ...], *, prescan: bool = False) -> None:
        """Run the rungs that copy parameters; in prescan, skip a subscript out of range."""
        site = self.site
        for series in copies:
            try:
                self._series(series, True)
            except LadderFault:
                if not prescan:
                    raise
        self.site = site

    # --- prescan

    def prescan(self, name: str | None = None) -> None:
        """Prescan a routine and the routines it calls, by default all main routines in task order.

        Prescan ignores jumps. It skips an instruction with a subscript out of range, because the subscript is
        possibly not set yet.
        """
        if name is None:
            schedule = self.lowered.schedule
            mains = [self.lowered.main] if schedule is None else [owner.main for owner in schedule.programs]
            for routine in (*filter(None, mains), *self.lowered.monitors):
                self.prescan(routine)
            return
        for step in self._steps_in_order(self.lowered.routines.get(name)):
            self._prescan_step(step)

    def _steps_in_order(self, routine: LoweredRoutine | None) -> Iterator[LoweredStep]:
        """Yield the instructions of a routine in order, without jumps."""
        for line in routine.lines if routine else ():
            self._count()
            yield from line.steps

    def _prescan_step(self, step: LoweredStep) -> None:
        """Prescan an instruction; skip it if it faults."""
        self.site = step.site
        if step.spec.prescan is None:
            return
        try:
            step.spec.prescan(self, *step.operands)
        except LadderFault as fault:
            if fault.site is not self.lowered.sites[step.site]:
                raise  # the fault is in a routine that the instruction runs

    # --- postscan

    def postscan(self, name: str) -> None:
        """Postscan a routine and the routines it calls, as an SFC does on the last scan of an action.

        Instructions run as on false rungs, or as their `Spec.postscan` says. Postscan ignores jumps
        [1756-PM006, automatic reset option].

        Args:
            name: the routine, in capitals; a routine in Python is not scanned.

        Raises:
            LadderFault: a subscript is out of range, unless the controller ignores such faults.
        """
        routine = self.lowered.routines.get(name)
        site = self.site
        for step in self._steps_in_order(routine):
            self.site = step.site
            try:
                if step.spec.postscan is not None:
                    step.spec.postscan(self, *step.operands)
                elif routine is not None and routine.body is None:
                    self.execute(step, False)
            except LadderFault as fault:
                ignorable = fault.site is self.lowered.sites[step.site] and fault.code == SUBSCRIPT_CODE
                if not ignorable or not self._ignores_array_faults:
                    raise
        self.site = site

    @property
    def _ignores_array_faults(self) -> bool:
        """Whether postscan skips an instruction with a subscript out of range [1756-RM003N]."""
        leaf = self.lowered.layout.find(IGNORES_ARRAY_FAULTS)
        return leaf is not None and self.memory.read(leaf) == 1
