"""Watches a program in the interpreter: the power of its rungs, and all changes in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field, replace
from itertools import chain
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site
from typing_extensions import override

from ..interpreter import Interpreter
from ..model.errors import LadderFault
from ..model.operands import Place
from ..model.spec import InstructionKind
from ..model.tags import OWN, Leaf
from ..model.types import HIDDEN
from ..state.lowered import Body, LoweredLine, LoweredRoutine, LoweredStep, Node, Parallel
from ..state.memory import NOTHING, InterpretedAddOnStore, Memory, Passed, Value, same
from ..state.tag_bytes import TagBytes
from .cells import places_in
from .forces import (
    ForcedBytes,
    ForcedList,
    ForcedValue,
    Forces,
    forced_in_lists,
    forced_in_variables,
    forced_values,
)


def shown(value: object) -> str:
    """Return a value as text; a bit as 0 or 1."""
    return str(int(value)) if isinstance(value, bool) else str(value)


@dataclass(frozen=True, slots=True)
class Blocker:
    """A condition that blocked the power of a rung."""

    instruction: str  # the condition as text
    values: tuple[tuple[str, Value], ...]  # the tags in the condition, with their values at that time

    def __str__(self) -> str:
        values = ", ".join(f"{tag} = {shown(value)}" for tag, value in self.values)
        return f"{self.instruction} [{values}]" if values else self.instruction


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a value by the program."""

    scan: int  # number of the scan among the watched scans, from 0
    now_ns: int
    leaf: Leaf
    index: int  # flat index in the leaf
    before: Value
    after: Value
    site: Site | None  # the instruction; None for a Python routine or a test
    power: bool  # whether the rung was true before the instruction
    blockers: tuple[Blocker, ...]  # the false conditions before it
    mode: str  # prescan or postscan, if this wrote it, else ""
    read: tuple[tuple[str, Value], ...] = ()  # in structured text: the values that the statement read
    inside: tuple[Blocker, ...] = ()  # conditions around a statement of structured text, outermost first
    instance: str = ""  # the instance, if it is in an add-on instruction; "" in a program


@dataclass(slots=True)
class _CurrentRung:
    """The rung that is being executed."""

    routine: str
    line: LoweredLine
    truth: list[bool] = field(default_factory=list)
    blocked: list[LoweredStep] = field(default_factory=list)


class WatchedMemory(Memory):
    """Memory that reports changes and applies forces.

    Attributes:
        watcher: called for each change in a watched scan.
        outside: collects external writes between scans, or None.
        on_outside: called after each external write.
        forces: the forces; `hold` replaces the mapping and never modifies it.
        forced_by_key: the forced values by leaf identifier and index.
    """

    watcher: Callable[[Leaf, int, Value, Value], None] | None = None
    outside: list[tuple[Leaf, int, Value]] | None = None
    on_outside: Callable[[], object] = staticmethod(lambda: None)
    forces: Forces = NOTHING  # type: ignore[assignment]  # it is empty
    forced_by_key: Mapping[tuple[str, int], ForcedValue] = NOTHING  # type: ignore[assignment]

    def hold(self, forces: Forces) -> tuple[ForcedValue, ...]:
        """Replace all forces; return the forced values that have their own variables."""
        values = forced_values(self.layout, forces)
        self.forces = forces
        self.forced_by_key = {(forced.leaf.ident, forced.index): forced for forced in values}
        lists = forced_in_lists(self.layout, values)
        for ident, cell in self.cells.items():
            contents = cell.cell_contents
            if isinstance(contents, TagBytes):
                free = contents.free if isinstance(contents, ForcedBytes) else contents
                self._put_list(ident, ForcedBytes(free, lists[ident]) if ident in lists else free)
            elif ident in lists:
                self._put_list(ident, ForcedList(contents, lists[ident]))
            elif isinstance(contents, ForcedList):
                self._put_list(ident, list(contents))
        return forced_in_variables(self.layout, values)

    def _put_list(self, ident: str, values: Any) -> None:
        """Replace a list or the bytes of a tag, wherever the memory refers to them."""
        self.cells[ident].cell_contents = values
        if ident in self._lists:
            self._lists[ident] = values

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value unless it is forced; report a change."""
        watcher = self.watcher
        after = self.forced(leaf, index, value) if self.forced_by_key else value
        if watcher is None:
            super().write(leaf, index, after)
            if self.outside is not None:
                self.outside.append((leaf, index, after))
                self.on_outside()
            return
        before = self.read(leaf, index)
        super().write(leaf, index, after)
        if not same(before, after):
            watcher(leaf, index, before, after)

    @override
    def column(self, leaf: Leaf, begin: int, step: int, count: int) -> None:
        """Return None, so that values are written one by one."""

    @override
    def bytes_at(self, leaf: Leaf, index: int) -> None:
        """Return None, so that values are written one by one."""

    def forced(self, leaf: Leaf, index: int, value: Value) -> Value:
        """Return a value with the force on its place applied, if there is one."""
        forced = self.forced_by_key.get((leaf.ident, index))
        return value if forced is None else forced.merged(value)


class WatchedInterpreter(Interpreter):
    """An interpreter that records the power in every rung."""

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)  # type: ignore[arg-type]  # the arguments of the base class
        self.truths: dict[tuple[str, int], tuple[bool, ...]] = {}  # by routine in capitals and number
        self.running: list[_CurrentRung] = []  # the innermost one last
        self.heads: list[Blocker] = []  # conditions around the current statement
        self.read: tuple[tuple[str, Value], ...] = ()  # values that the current statement read
        self.power = True  # before the current instruction
        self.mode = ""  # prescan, postscan, or "" in an ordinary scan
        self._routines: list[str] = []  # running, in capitals, the innermost last
        self._silent = 0  # nested copies of parameters

    @override
    def scan(self, now_ns: int) -> None:
        """Run a scan after clearing the records of the previous scan."""
        self.truths.clear()
        self.running.clear()
        self.heads.clear()
        self._routines.clear()
        self._silent = 0
        super().scan(now_ns)

    @override
    def prescan(self, name: str | None = None) -> None:
        with self._in_mode("prescan"):
            super().prescan(name)

    @override
    def postscan(self, name: str) -> None:
        with self._in_mode("postscan"):
            super().postscan(name)

    @contextmanager
    def _in_mode(self, mode: str) -> Iterator[None]:
        """Set the mode in the body of a `with` statement."""
        outer, self.mode = self.mode, mode
        try:
            yield
        finally:
            self.mode = outer

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Passed]) -> None:
        """Run a routine with its own conditions; record it even while parameters are copied."""
        self._routines.append(routine.name.upper())
        silent, self._silent = self._silent, 0
        heads, self.heads = self.heads, []
        try:
            super()._lines(routine, inputs)
        finally:
            self._silent, self.heads = silent, heads
            self._routines.pop()

    def _line(self, line: LoweredLine, inputs: Sequence[Passed], *, statement: bool = False) -> bool:
        """Run a line and record its power, even if a fault ends it."""
        running = _CurrentRung(self._routines[-1], line)
        self.running.append(running)
        try:
            return super()._line(line, inputs, statement=statement)
        finally:
            key = running.routine, line.number
            self.truths[key] = self._statement_truth(running, key) if statement else tuple(running.truth)
            self.running.pop()

    def _statement_truth(self, running: _CurrentRung, key: tuple[str, int]) -> tuple[bool, ...]:
        """Return whether a line of structured text was true in any of its statements and loop passes."""
        was_left = not running.truth  # by EXIT, RETURN or a fault
        return (was_left or running.truth[-1] or self.truths.get(key, (False,))[-1],)

    def _inside(self, head: LoweredLine, body: Body, inputs: Sequence[Passed]) -> None:
        """Record a body's condition, with the values that it read, while the body runs."""
        (step,) = head.nodes
        assert isinstance(step, LoweredStep)
        site = self.lowered.sites[step.site]
        if site.rung is not None and site.rung < 0:  # the condition belongs to a whole chart
            super()._inside(head, body, inputs)
            return
        self.heads.append(Blocker(f"{head.text} in {site.unit} {head.number}", self._values(step)))
        try:
            super()._inside(head, body, inputs)
        finally:
            self.heads.pop()

    def _step(self, step: LoweredStep, power: bool) -> bool:
        """Run an instruction; record its power, its reads, and whether it blocked power."""
        if self._silent:
            return super()._step(step, power)
        self.power = power
        running = self.running[-1]
        self.read = self._values(step) if self.lowered.sites[step.site].unit != "rung" else ()
        power_after = super()._step(step, power)
        running.truth.append(power_after)
        if power and not power_after and step.kind is InstructionKind.INPUT:
            running.blocked.append(step)
        return power_after

    def _branch(self, branch: Parallel, power: bool) -> bool:
        """Run a branch; if one leg conducts, the others do not block."""
        if self._silent:
            return super()._branch(branch, power)
        blocked = self.running[-1].blocked
        count_before = len(blocked)
        power_after = super()._branch(branch, power)
        if power_after:
            del blocked[count_before:]
        return power_after

    def copy_parameters(self, copies: tuple[tuple[Node, ...], ...], *, prescan: bool = False) -> None:
        """Copy parameters without recording, because the copying rungs are not part of the program."""
        self._silent += 1
        try:
            super().copy_parameters(copies, prescan=prescan)
        finally:
            self._silent -= 1

    def blockers(self) -> tuple[Blocker, ...]:
        """Return the conditions of the current rung that have blocked power so far."""
        return tuple(map(self._blocker, self.running[-1].blocked)) if self.running else ()

    def _blocker(self, step: LoweredStep) -> Blocker:
        return Blocker(self.lowered.sites[step.site].instruction, self._values(step))

    def _values(self, step: LoweredStep) -> tuple[tuple[str, Value], ...]:
        """Return the tags that a step reads, with their values."""
        read = step.operands[1:] if step.name in (":=", "[:=]") else step.operands
        places: list[Place] = []
        for place in chain.from_iterable(map(places_in, read)):
            places += (place, *self._timer_numbers(place))
        site = self.site
        self.site = step.site
        try:
            values = {place.text: self.get(place) for place in places if HIDDEN not in place.leaf.path}
            return tuple(values.items())
        except LadderFault:
            return ()  # a subscript is out of range, so the step itself will fault
        finally:
            self.site = site

    def _timer_numbers(self, place: Place) -> tuple[Place, ...]:
        """Return ACC and PRE if a place is DN of a timer or counter."""
        path, dot, name = place.leaf.path.upper().rpartition(".")
        acc, pre = (self.lowered.layout.find(f"{path}.{member}") for member in ("ACC", "PRE"))
        if not dot or name != "DN" or acc is None or pre is None:
            return ()
        text = place.text[: -len(name)]
        return replace(place, leaf=acc, text=f"{text}ACC"), replace(place, leaf=pre, text=f"{text}PRE")

    @property
    def instance(self) -> str:
        """The current instance; "" outside add-on instructions."""
        store = self.frame.get(OWN)
        return store.text if isinstance(store, InterpretedAddOnStore) else ""

    @property
    def present(self) -> Site | None:
        """The current instruction; None outside rungs."""
        return self.lowered.sites[self.site] if self.running or self.mode else None
