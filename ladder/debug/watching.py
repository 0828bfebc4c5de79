"""A program that is watched while it runs: the truth of its rungs, and every change of its memory.

It is the interpreter that is watched: it executes the tree plainly, and the compiler has to equal it. Scans
that nobody looks into run compiled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from typing_extensions import override

from ..arithmetic import wrap
from ..compiler import Scanner
from ..engine import Engine
from ..errors import LadderFault, Site
from ..interpreter import Interpreter
from ..lowered import Body, Line, Lowered, LoweredRoutine, Node, Parallel, Step
from ..memory import Memory, Named, Value, same
from ..operands import Calculation, Place
from ..spec import Kind
from ..tags import OWN, Leaf


def shown(value: object) -> str:
    """Return a value as it stands in a sentence; bits as 0 and 1."""
    return str(int(value)) if isinstance(value, bool) else str(value)


@dataclass(frozen=True, slots=True)
class Blocker:
    """A condition at which the power of a rung ended.

    Attributes:
        instruction: the instruction as text.
        values: its tags and their values then.
    """

    instruction: str
    values: tuple[tuple[str, Value], ...]

    def __str__(self) -> str:
        values = ", ".join(f"{tag} = {shown(value)}" for tag, value in self.values)
        return f"{self.instruction} [{values}]" if values else self.instruction


@dataclass(frozen=True, slots=True)
class Change:
    """A value of the memory that a program has changed.

    Attributes:
        scan: number of the scan, from 0 for the first that was watched.
        now_ns: its virtual time, ns.
        leaf: what was changed.
        index: which element of it, 0 for a single value.
        before: its value before.
        after: its value then.
        site: the instruction, None if a Python routine or somebody from outside wrote it.
        power: whether the rung was true in front of that instruction.
        blockers: the conditions of the rung that were false in front of it.
        prescan: whether it was prescan that wrote.
        read: of structured text: what the statement has read, and its values.
        inside: of structured text: the conditions that the statement stands in, the outermost first.
        instance: in an add-on instruction, the instance whose routine it was; "" in a program.
    """

    scan: int
    now_ns: int
    leaf: Leaf
    index: int
    before: Value
    after: Value
    site: Site | None
    power: bool
    blockers: tuple[Blocker, ...]
    prescan: bool
    read: tuple[tuple[str, Value], ...] = ()
    inside: tuple[Blocker, ...] = ()
    instance: str = ""


@dataclass(slots=True)
class _Running:
    """The rung that is being executed.

    Attributes:
        routine: its routine, in capitals.
        line: the rung.
        truth: power behind each instruction so far.
        blocked: instructions so far at which power ended.
    """

    routine: str
    line: Line
    truth: list[bool] = field(default_factory=list)
    blocked: list[Step] = field(default_factory=list)


class WatchedMemory(Memory):
    """Memory that tells of changes, and in which values can be forced.

    Attributes:
        watcher: told of every change while a scan is watched.
        outside: collects what is written between scans, None while it is not wanted.
        forces: mask and value of forced values by identifier and index; a mask of None is the whole value.
    """

    watcher: Callable[[Leaf, int, Value, Value], None] | None = None
    outside: list[tuple[Leaf, int, Value]] | None = None
    forces: dict[tuple[str, int], tuple[int | None, Value]]

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value, as far as it is not forced; tell if that changes it."""
        watcher = self.watcher
        if watcher is None:
            if self.outside is not None:
                self.outside.append((leaf, index, value))
            super().write(leaf, index, value)
            return
        before = self.read(leaf, index)
        after = self.forced(leaf, index, value)
        super().write(leaf, index, after)
        if not same(before, after):
            watcher(leaf, index, before, after)

    def forced(self, leaf: Leaf, index: int, value: Value) -> Value:
        """Return a value with the forces of its place in it."""
        force = self.forces.get((leaf.ident, index))
        if force is None:
            return value
        mask, forced = force
        if mask is None:
            return forced
        bits = leaf.type.bits
        merged = (int(value) & ~mask | int(forced) & mask) & (1 << bits) - 1
        return wrap(merged, leaf.type.wraps)


class WatchedInterpreter(Interpreter):
    """An interpreter that notes the truth of every rung it executes."""

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)  # type: ignore[arg-type]  # as the base takes them
        self.truths: dict[tuple[str, int], tuple[bool, ...]] = {}
        self.running: list[_Running] = []
        self.heads: list[Blocker] = []
        self.read: tuple[tuple[str, Value], ...] = ()
        self.power = True
        self.prescanning = False
        self._routines: list[str] = []
        self._silent = 0

    @override
    def scan(self, now_ns: int) -> None:
        self.truths.clear()
        self.running.clear()
        self.heads.clear()
        self._routines.clear()
        self._silent = 0
        super().scan(now_ns)

    @override
    def prescan(self, name: str | None = None) -> None:
        outer, self.prescanning = self.prescanning, True
        try:
            super().prescan(name)
        finally:
            self.prescanning = outer

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Value]) -> None:
        self._routines.append(routine.name.upper())
        silent, self._silent = self._silent, 0
        heads, self.heads = self.heads, []
        try:
            super()._lines(routine, inputs)
        finally:
            self._silent, self.heads = silent, heads
            self._routines.pop()

    def _line(self, line: Line, inputs: Sequence[Value], *, statement: bool = False) -> bool:
        running = _Running(self._routines[-1], line)
        self.running.append(running)
        try:
            return super()._line(line, inputs, statement=statement)
        finally:
            key = running.routine, line.number
            self.truths[key] = self._ran(running, key) if statement else tuple(running.truth)
            self.running.pop()

    def _ran(self, running: _Running, key: tuple[str, int]) -> tuple[bool, ...]:
        """Return the truth of a line of structured text: of any of its statements, in any pass of a loop."""
        left = not running.truth  # by EXIT or RETURN, or because of a fault
        return (left or running.truth[-1] or self.truths.get(key, (False,))[-1],)

    def _inside(self, head: Line, body: Body, inputs: Sequence[Value]) -> None:
        """Note the condition under which a body runs, with its values before."""
        (step,) = head.nodes
        assert isinstance(step, Step)
        text = f"{head.text} in line {head.number}"
        self.heads.append(Blocker(text, self._values(step)))
        try:
            super()._inside(head, body, inputs)
        finally:
            self.heads.pop()

    def _step(self, step: Step, power: bool) -> bool:
        if self._silent:
            return super()._step(step, power)
        self.power = power
        running = self.running[-1]
        self.read = self._values(step) if self.lowered.sites[step.site].unit == "line" else ()
        behind = super()._step(step, power)
        running.truth.append(behind)
        if power and not behind and step.kind is Kind.INPUT:
            running.blocked.append(step)
        return behind

    def _branch(self, branch: Parallel, power: bool) -> bool:
        """Where one leg conducts, the others do not block."""
        if self._silent:
            return super()._branch(branch, power)
        blocked = self.running[-1].blocked
        before = len(blocked)
        behind = super()._branch(branch, power)
        if behind:
            del blocked[before:]
        return behind

    def copy_parameters(self, copies: tuple[tuple[Node, ...], ...], *, prescan: bool = False) -> None:
        """The rungs that copy arguments in and results out are not instructions of the rung."""
        self._silent += 1
        try:
            super().copy_parameters(copies, prescan=prescan)
        finally:
            self._silent -= 1

    def blockers(self) -> tuple[Blocker, ...]:
        """Return the conditions of the present rung at which power has ended so far."""
        return tuple(map(self._blocker, self.running[-1].blocked)) if self.running else ()

    def _blocker(self, step: Step) -> Blocker:
        return Blocker(self.lowered.sites[step.site].instruction, self._values(step))

    def _values(self, step: Step) -> tuple[tuple[str, Value], ...]:
        """Return the tags that a step reads, with their values; of an assignment those of its value."""
        read = step.operands[1:] if step.name in (":=", "[:=]") else step.operands
        places = [place for each in read for place in _places(each)]
        told = [each for place in places for each in (place, *self._beside(place))]
        site = self.site
        self.site = step.site
        try:
            return tuple({each.text: self.get(each) for each in told}.items())
        except LadderFault:
            return ()  # a subscript is out of range: the step itself stops the scan
        finally:
            self.site = site

    def _beside(self, place: Place) -> tuple[Place, ...]:
        """Return ACC and PRE, if a place is DN of a timer or counter."""
        path, dot, name = place.leaf.path.upper().rpartition(".")
        leaves = self.lowered.layout.leaves
        parts = [leaves.get(f"{path}.{part}") for part in ("ACC", "PRE")]
        if not dot or name != "DN" or None in parts:
            return ()
        text = place.text[: -len(name)]
        return tuple(
            replace(place, leaf=leaf, text=f"{text}{part}")
            for leaf, part in zip(parts, ("ACC", "PRE"), strict=True)
            if leaf is not None
        )

    @property
    def instance(self) -> str:
        """The instance whose routine runs, "" outside of add-on instructions."""
        own = self.frame.get(OWN)
        return own.text if isinstance(own, Named) else ""

    @property
    def present(self) -> Site | None:
        """The instruction that executes, None outside of rungs."""
        return self.lowered.sites[self.site] if self.running or self.prescanning else None


def _places(operand: object) -> Iterator[Place]:
    """Yield the places in an operand, those in its subscripts apart."""
    if isinstance(operand, Place):
        yield operand
    elif isinstance(operand, Calculation):
        for each in operand.operands:
            yield from _places(each)


class WatchedEngine(Engine):
    """An engine that can be watched: it runs compiled, or, while it is watched, in the interpreter.

    Attributes:
        watching: whether the next scans are watched.
        history: what has changed in scans that were watched.
        scans: number of scans so far.
        outside: what is written in front of the next scan, as somebody outside of the program did.

    Args:
        lowered: the program.
        scanner: the compiled program.
    """

    memory_type = WatchedMemory
    interpreter_type = WatchedInterpreter
    memory: WatchedMemory
    interpreter: WatchedInterpreter

    def __init__(self, lowered: Lowered, scanner: Scanner) -> None:
        super().__init__(lowered, scanner)
        self._compiled = self._scan
        self.watching = False
        self.history: list[Change] = []
        self.scans = 0
        self.outside: tuple[tuple[Leaf, int, Value], ...] = ()
        self.memory.forces = {}

    def do(self, now_ns: int, *, first: bool) -> None:
        """Do one scan, forced values held if it is watched.

        Raises:
            LadderFault: a major fault.
        """
        self._do(now_ns, first=first)

    def _do(self, now_ns: int, *, first: bool) -> None:
        self.history.clear()
        self.interpreter.truths.clear()
        self.now_ns = now_ns
        self._scan = self.interpreter.scan if self.watching else self._compiled
        self.memory.watcher = self._changed if self.watching else None
        try:
            for leaf, index, value in self.outside:
                self.memory.write(leaf, index, value)
            self.outside = ()
            if self.watching:
                self.apply_forces()
            super()._do(now_ns, first=first)
        finally:
            self.memory.watcher = None
            self.scans += 1

    def apply_forces(self) -> None:
        """Put the forced values into the memory."""
        leaves = {leaf.ident: leaf for leaf in self.lowered.layout.leaves.values()}
        for ident, index in self.memory.forces:
            leaf = leaves[ident]
            self.memory.write(leaf, index, self.memory.forced(leaf, index, self.memory.read(leaf, index)))

    def _changed(self, leaf: Leaf, index: int, before: Value, after: Value) -> None:
        interpreter = self.interpreter
        self.history.append(
            Change(
                self.scans,
                self.now_ns,
                leaf,
                index,
                before,
                after,
                interpreter.present,
                interpreter.power,
                interpreter.blockers(),
                interpreter.prescanning,
                interpreter.read,
                tuple(interpreter.heads),
                interpreter.instance,
            )
        )
