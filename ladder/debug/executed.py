r"""One executed scan: its instructions in order, each with its power, reads and writes.

    order   0        1              2            3
            XIC A    reads A = 1    OTE B        writes B: 0 -> 1
            \_____ of the run of one rung _______________/

The interpreter records it only when a scan is rerun to explain a value, see `causes`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from typing_extensions import override

from ..model.errors import LadderFault
from ..model.operands import Calculation, Constant, Group, Place, Resolved
from ..model.spec import InstructionKind, Use
from ..model.tags import Leaf
from ..model.types import HIDDEN
from ..state.lowered import Body, LoweredLine, LoweredStep
from ..state.memory import InterpretedAddOnStore, Passed, Value, same
from .cells import Cell
from .watched import WatchedInterpreter, WatchedMemory
from .watching import WatchedEngine

COPIES = ("COP", "CPS")
"""Instructions that copy values byte by byte."""


@dataclass(frozen=True, slots=True)
class Read:
    """A value that an instruction read."""

    cell: Cell
    value: Value  # the value of the cell
    text: str  # as written in the program; in an add-on instruction, the tag's name

    def part(self, cell: Cell) -> Read:
        """Return the read of part of the value: the same cell, or some of its bits."""
        return Read(cell, cell.masked(self.value), cell.name if cell.mask else self.text)


@dataclass(frozen=True, slots=True)
class Write:
    """A change made by an instruction."""

    order: int
    cell: Cell  # the whole value
    before: Value  # the value before it
    after: Value  # the value after it
    writer: StepRun | None  # None if no instruction wrote it
    mode: str  # prescan or postscan if it wrote the value, else ""

    def changes(self, cell: Cell) -> bool:
        """Return whether the write changes the value of a cell."""
        if not self.cell.overlaps(cell):
            return False
        return not same(cell.masked(self.before), cell.masked(self.after))


@dataclass(eq=False, slots=True)
class LineRun:
    """A run of a rung, or of a statement."""

    key: tuple[object, ...]  # routine in capitals, number, instance, number of the run in the scan
    routine: str
    line: LoweredLine
    instance: str  # the instance, if it is in an add-on instruction
    caller: StepRun | None  # the instruction that runs the routine; None for a main routine
    heads: tuple[StepRun, ...]  # conditions around a statement, outermost first
    order: int  # order of the instruction executed before it
    steps: dict[int, StepRun] = field(default_factory=dict)  # runs by the id of the lowered step


@dataclass(eq=False, slots=True)
class StepRun:
    """A run of an instruction."""

    order: int
    step: LoweredStep
    run: LineRun
    power: bool  # power before it
    parent: StepRun | None  # the call whose parameters it copies
    ahead: tuple[StepRun, ...] = ()  # the contacts before it in such a copy
    truth: bool | None = None  # whether it conducts, or would with power; None if unknown
    reads: list[Read] = field(default_factory=list)
    copied: tuple[InterpretedAddOnStore, InterpretedAddOnStore] | None = None  # of a COP: source, destination

    @property
    def number(self) -> int:
        """The number of the instruction's site."""
        return self.step.site

    @property
    def instance(self) -> str:
        """Instance of the add-on instruction that the run belongs to, or whose parameters it copies."""
        return self.run.instance


@dataclass(slots=True)
class Execution:
    """An executed scan."""

    scan: int
    now_ns: int = 0
    runs: dict[tuple[object, ...], LineRun] = field(default_factory=dict)
    writes: list[Write] = field(default_factory=list)
    order: int = 0

    def next(self) -> int:
        """Return the number of the next instruction in execution order."""
        self.order += 1
        return self.order

    def changes(self, cell: Cell) -> bool:
        """Return whether a cell's value at the end of the scan differs from its value at the beginning."""
        overlapping = [write for write in self.writes if write.cell.overlaps(cell)]
        return bool(overlapping) and not same(
            cell.masked(overlapping[0].before), cell.masked(overlapping[-1].after)
        )

    def last_write(self, cell: Cell, order: int | None = None) -> Write | None:
        """Return the last change of a cell before a place in execution order; None if there is none."""
        for write in reversed(self.writes):
            if (order is None or write.order < order) and write.changes(cell):
                return write
        return None


class TracedMemory(WatchedMemory):
    """Memory that records reads while `noted` is a list."""

    noted: list[tuple[Leaf, int, Value]] | None = None

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""
        value = super().read(leaf, index)
        if self.noted is not None:
            self.noted.append((leaf, index, value))
        return value

    @override
    def elements(self, leaf: Leaf, begin: int, count: int) -> list[Value]:
        """Return elements; record a read of each."""
        if self.noted is None:
            return super().elements(leaf, begin, count)
        return [self.read(leaf, index) for index in range(begin, begin + count)]

    @override
    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value without recording the reads that this causes."""
        with self.unnoted():
            super().write(leaf, index, value)

    @contextmanager
    def unnoted(self) -> Iterator[None]:
        """Do not record reads in the body of a `with` statement."""
        noted, self.noted = self.noted, None
        try:
            yield
        finally:
            self.noted = noted


class TracedInterpreter(WatchedInterpreter):
    """An interpreter that records executed instructions while `execution` is set."""

    memory: TracedMemory
    execution: Execution | None = None

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)
        self._runs: list[LineRun] = []  # current runs, the innermost last
        self._steps: list[StepRun] = []  # as `_runs`
        self._heads: tuple[StepRun, ...] = ()  # conditions around the current statement
        self._ahead: tuple[StepRun, ...] = ()  # contacts just before the current instruction
        self._times: Counter[tuple[object, ...]] = Counter()  # runs of each line in this scan

    @property
    def step_run(self) -> StepRun | None:
        """The instruction that is being executed."""
        return self._steps[-1] if self._steps else None

    @override
    def scan(self, now_ns: int) -> None:
        """Run a scan; forget the runs of the previous scan."""
        self._runs.clear()
        self._steps.clear()
        self._times.clear()
        self._heads = ()
        super().scan(now_ns)

    @override
    def _line(self, line: LoweredLine, inputs: Sequence[Passed], *, statement: bool = False) -> bool:
        """Run a line and record its run, numbered among the line's runs in this scan."""
        execution = self.execution
        if execution is None:
            return super()._line(line, inputs, statement=statement)
        routine = self._routines[-1]
        site = (routine, line.number, id(line), self.instance)
        key = (*site, self._times[site])
        self._times[site] += 1
        run = LineRun(key, routine, line, self.instance, self.step_run, self._heads, execution.order)
        execution.runs[key] = run
        self._runs.append(run)
        try:
            return super()._line(line, inputs, statement=statement)
        finally:
            self._runs.pop()

    @override
    def _inside(self, head: LoweredLine, body: Body, inputs: Sequence[Passed]) -> None:
        """Run a body with the latest run of its condition as the innermost condition."""
        outer = self._heads
        execution = self.execution
        if execution is not None:
            last = next((run for run in reversed(execution.runs.values()) if run.line is head), None)
            self._heads = (*outer, *(last.steps.values() if last else ()))
        try:
            super()._inside(head, body, inputs)
        finally:
            self._heads = outer

    @override
    def _step(self, step: LoweredStep, power: bool) -> bool:
        """Run an instruction; record its run with its power, its reads, and whether it conducts."""
        execution = self.execution
        if execution is None or not self._runs:
            return super()._step(step, power)
        parent = self._steps[-1] if self._silent else None
        ahead = self._ahead if parent else ()
        entry = StepRun(execution.next(), step, self._runs[-1], power, parent, ahead)
        entry.run.steps[id(step)] = entry
        outer, self.memory.noted = self.memory.noted, []
        heads, self._heads = self._heads, ()
        self._steps.append(entry)
        if power and step.name in COPIES:
            entry.copied = self._copied(step)
        try:
            power_after = super()._step(step, power)
            entry.truth = power_after if power or step.spec.decides else self._would_conduct(step)
            return power_after
        finally:
            entry.reads += [
                _read_of_cell(leaf, index, value) for leaf, index, value in self.memory.noted or ()
            ]
            self._steps.pop()
            self._ahead = (*entry.ahead, entry) if step.kind is InstructionKind.INPUT else ()
            self.memory.noted, self._heads = outer, heads

    def _copied(self, step: LoweredStep) -> tuple[InterpretedAddOnStore, InterpretedAddOnStore] | None:
        """Return the stores that a COP copies between; None for a constant, or if an address faults."""
        source, destination = step.operands[:2]
        if not isinstance(source, (Place, Group)):
            return None
        try:
            with self.memory.unnoted():
                return self.handed(source), self.handed(destination)
        except LadderFault:
            return None

    @override
    def _values(self, step: LoweredStep) -> tuple[tuple[str, Value], ...]:
        with self.memory.unnoted():
            return super()._values(step)

    def _would_conduct(self, step: LoweredStep) -> bool | None:
        """Return whether a plain contact without power would conduct; None for anything else."""
        if (
            step.kind is not InstructionKind.INPUT
            or not set(step.uses) <= _READING_USES
            or any(map(_may_fault, step.operands))
        ):
            return None
        try:
            return bool(step.spec.run(self, *step.operands))
        except LadderFault:
            return None

    @override
    def get(self, place: Place) -> Value:
        """Return a value; replace the memory's note of its word with a read of the value or bit."""
        value = super().get(place)
        noted = self.memory.noted
        if noted and self._steps:
            leaf, index, _ = noted.pop()
            if HIDDEN not in leaf.path or self.lowered.sites[self.site].unit != "element":
                self._steps[-1].reads.append(self._read(place, leaf, index, value))
        return value

    def _read(self, place: Place, leaf: Leaf, index: int, value: Value) -> Read:
        """Return a read of a place: its cell, or its bit; in an add-on instruction, named by the cell."""
        mask = None
        store = self.store_of(place.leaf.root)
        if place.bit is not None:
            with self.memory.unnoted():
                mask = 1 << self.subscript(place.bit, place.leaf.type.bits, place.text)
        elif isinstance(store, InterpretedAddOnStore) and store.bit is not None:
            mask = 1 << store.bit
        cell = Cell(leaf, index, mask)
        in_add_on = bool(place.leaf.root)
        return Read(cell, value, cell.name if in_add_on or place.can_fault else place.text)

    @override
    def put(self, place: Place, value: Value) -> None:
        with self.memory.unnoted():  # setting a bit reads its word, which is not a cause
            super().put(place, value)


class TracedEngine(WatchedEngine):
    """An engine that records watched scans as `execution` while `traced` is set."""

    memory_type = TracedMemory
    interpreter_type = TracedInterpreter
    memory: TracedMemory
    interpreter: TracedInterpreter
    traced = False
    execution: Execution | None = None

    @override
    def _scan_at(self, now_ns: int, first: bool) -> None:
        """Run a scan; if it is watched and traced, record it as a new `execution`."""
        if self.watching and self.traced:
            self.execution = self.interpreter.execution = Execution(self.scans, now_ns)
        try:
            super()._scan_at(now_ns, first)
        finally:
            self.interpreter.execution = None

    @override
    def _changed(self, leaf: Leaf, index: int, before: Value, after: Value) -> None:
        """Record a change as a write of the current instruction; prescan and postscan have no writer."""
        super()._changed(leaf, index, before, after)
        interpreter = self.interpreter
        execution = interpreter.execution
        if execution is not None:
            cell, order = Cell(leaf, index), execution.next()
            writer = None if interpreter.mode else interpreter.step_run
            execution.writes.append(Write(order, cell, before, after, writer, interpreter.mode))


_READING_USES = frozenset({Use.BIT, Use.NUMBER, Use.TEXT_OR_NUMBER, Use.INTEGER, Use.TRUTH})
"""Operand uses of contacts that only read."""


def _may_fault(operand: Resolved) -> bool:
    """Return whether reading an operand can fault or record a fault."""
    return (
        isinstance(operand, Calculation)
        or (isinstance(operand, Place) and operand.can_fault)
        or not isinstance(operand, (Place, Constant))
    )


def _read_of_cell(leaf: Leaf, index: int, value: Value) -> Read:
    cell = Cell(leaf, index)
    return Read(cell, value, cell.name)
