"""A program as a transition system: which values are state, which are free in each scan, which are held.

| value before a scan | role |
|---|---|
| the scan may write it, or it is the time since an instant | state |
| of a module's input image or fault, of a consumed tag, of the status file of an SLC | free |
| a bit that nothing writes | free |
| a number that nothing writes | held at its initial value, unless `free` names it |
| a bit of a number, if the program names it and does not write it | free, from the second scan on |
| a number with the name of a module's inputs, as `I:2` or `Rack:3:I` | free |
| named by `written_outside` | free, from the second scan on |
| what an instruction that is not modelled leaves | free |

States have their values after prescan before the first scan.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from typing import Any, Protocol

from ..instructions.slc.processor import before_scan
from ..instructions.slc.status import STATUS
from ..model.errors import LadderError, LadderFault
from ..model.operands import Calculation, Constant, Place
from ..model.tags import Layout, Leaf, tag_in
from ..run.engine import Engine
from ..run.view import Tags
from ..state.lowered import Call, LoweredProgram, steps_of
from .algebra import terms
from .algebra.meaning import BOOL, INT
from .algebra.numbers import bit, setbit
from .algebra.terms import FALSE, TRUE, T, and_, var, variables
from .relation.noting import NotingMachine

Key = tuple[str, int]
"""A place: path of the leaf in capitals, flat index."""

CLOCK = "~LAST_NS"
"""End of the path of a hidden member whose term is the ms since an instant."""

DT = "~dt"
"""Name of the variable with the ms since the scan before."""

TOLD = "~told:"
"""Start of the name of a variable whose bits somebody outside writes into a number before the next scan."""

FIRST_SCAN = ("S:FS", 0)


class Runnable(Protocol):
    """A program that runs on an interpreter, and compiled."""

    def build(self) -> LoweredProgram:
        """Return the lowered program."""

    def interpret(self) -> Engine:
        """Return an engine on the interpreter."""

    def compile(self) -> Engine:
        """Return an engine on the compiled program."""


@dataclass(frozen=True, slots=True)
class ScanBounds:
    """Least and most time between two scans, ms; `whole` if it is always whole ms.

    With parts of a ms the bounds are cut off: 2.5 to 10.2 ms are 2 to 10, and each timer may count one more.

    Raises:
        ValueError: not 0 < low <= high, or more than a day.
    """

    low_ms: int = 1
    high_ms: int = 1000
    whole: bool = True

    def __post_init__(self) -> None:
        if not 0 <= self.low_ms <= self.high_ms <= 86_400_000 or self.high_ms == 0:
            raise ValueError(
                f"scan time from {self.low_ms} to {self.high_ms} ms; allowed are 1 ms to a day, least first"
            )

    @classmethod
    def of(cls, low_ms: float, high_ms: float) -> ScanBounds:
        """Return bounds of times that need not be whole.

        >>> ScanBounds.of(2.5, 10)
        ScanBounds(low_ms=2, high_ms=10, whole=False)
        """
        whole = float(low_ms).is_integer() and float(high_ms).is_integer()
        return cls(math.floor(low_ms), math.floor(high_ms), whole)

    def done(self, ms: int) -> int:
        """Return the whole ms that a run has for a scan time of the solver: within the bounds, if any is."""
        return ms if self.whole else min(self.high_ms, max(ms, self.low_ms + 1))


@dataclass(slots=True)
class System:
    """States, their next values, and what else decides them.

    Attributes:
        next: the term after a scan of each state, by the name of its variable.
        initial: values of states and held values, and of free ones that the first scan finds unchanged.
        held: names of variables that keep their initial value.
        late: names of free variables that have their initial value in the first scan.
        contract: what holds in each scan of a run in question.
        kept: contracts of modules; each counts for what its module's inputs decide, see `narrowed`.
        deep: where the relation does not follow the program.
        havocs: variables of what is not modelled, and what to blame.
        key_of: the place of each variable that has one.
        likely: values that random scans give a free variable often, by its name.
        least_ms: least time between scans.
        follows: whether `deep` never holds; None before it is known.
        invariants: found so far, by contract and cone.
    """

    next: dict[str, T] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    held: set[str] = field(default_factory=set)
    late: set[str] = field(default_factory=set)
    contract: T = TRUE
    kept: list[T] = field(default_factory=list)
    deep: T = FALSE
    havocs: dict[str, str] = field(default_factory=dict)
    key_of: dict[str, Key] = field(default_factory=dict)
    likely: dict[str, Sequence[int]] = field(default_factory=dict)
    least_ms: int = 1
    follows: bool | None = None
    invariants: dict[tuple[T, frozenset[str]], Any] = field(default_factory=dict)

    def role(self, name: str) -> str:
        """`state`, `held`, or `free`."""
        return "state" if name in self.next else "held" if name in self.held else "free"

    def cone(self, roots: Iterable[T]) -> dict[str, T]:
        """Return the variables that decide terms in any number of scans, the nearest first."""
        seen: dict[str, T] = {}
        todo = [*roots, *([] if self.contract is TRUE else [self.contract])]
        while todo:
            fresh = [v for v in variables(todo) if v.val not in seen]
            seen.update((v.val, v) for v in fresh)
            todo = [self.next[v.val] for v in fresh if v.val in self.next]
        return seen

    def narrowed(self, roots: Iterable[T]) -> T:
        """Return the contract with those of modules whose inputs decide terms."""
        roots, contract, left = list(roots), self.contract, [*self.kept]
        while True:
            inputs = {name for name in self.cone([*roots, contract]) if self.role(name) == "free"}
            counts = [each for each in left if any(v.val in inputs for v in variables([each]))]
            if not counts:
                return contract
            left = [each for each in left if each not in counts]
            for each in counts:
                contract = and_(contract, each)

    def blame(self, cone: Iterable[str]) -> tuple[str, ...]:
        """Return the instructions that are not modelled and decide a cone."""
        return tuple(dict.fromkeys(self.havocs[name] for name in cone if name in self.havocs))

    def limits_met(self) -> tuple[str, ...]:
        """Return where the relation does not follow the program."""
        return ("a loop or call beyond the limits",)


Contract = Callable[["ProgramSystem"], T]
"""Makes a truth of each scan; `ProgramSystem.now` and `ProgramSystem.before` give it values."""


class ProgramSystem(System):
    """A program of which something is to be proved.

    Args:
        program: with or without monitors, see `monitors.monitored`.
        bounds: of the time between scans.
        free: tags whose numbers are free in each scan: `Recipe`, `Recipe.*`.
        written_outside: tags that both the program and somebody outside write.
        assume: bits that are true after each scan of a run in question.
        contracts: truths of inputs that hold in each scan.
        beside: another problem, whose terms stay shared: to compare two programs.

    Raises:
        LadderError: what is not proved about, by name; a name in `free` or `written_outside` that no tag has.
    """

    def __init__(
        self,
        program: Runnable,
        bounds: ScanBounds = ScanBounds(),
        *,
        free: Sequence[str] = (),
        written_outside: Sequence[str] = (),
        assume: Sequence[Key] = (),
        contracts: Sequence[Contract] = (),
        beside: ProgramSystem | None = None,
    ) -> None:
        super().__init__()
        self.open: dict[Key, int] = {}  # masks of the bits of numbers that somebody outside writes
        if beside is None:
            terms.forget()
        self.program, self.bounds, self.assume = program, bounds, tuple(assume)
        self.engine = program.interpret()
        self.lowered = self.engine.lowered
        refuse(self.lowered)
        self._free = _named(self.lowered.layout, "free", free)
        self._outside = _named(self.lowered.layout, "written_outside", written_outside)
        self._beside = _written_beside(self.lowered)
        self.settings: dict[str, Any] = {
            "free": free,
            "written_outside": written_outside,
            "assume": assume,
            "contracts": contracts,
        }
        self._begin()
        self.machine = self._scanned({})
        self.lengths = self._constant_lengths()
        if self.lengths:
            again = self._scanned(self.lengths)
            if not self.lengths.keys() & again.written:
                self.machine = again
        self.rungs = list(self.machine.rungs)
        self.machine.noting = False  # monitors are no part of the program
        self._run_monitors()
        self.least_ms = bounds.low_ms
        self._settle()
        for each in assume:
            self.contract = and_(self.contract, self.after(each))
        self.kept = [make(self) for make in contracts]
        self._settle()
        self._open_bits()
        self._note_prescanned()

    def _scanned(self, known: Mapping[Key, Any]) -> NotingMachine:
        """Return the machine behind one scan."""
        machine = NotingMachine(self.lowered, (self.bounds.low_ms, self.bounds.high_ms), known)
        machine.parts = not self.bounds.whole
        machine.scan_terms()
        return machine

    def _constant_lengths(self) -> dict[Key, Any]:
        """Return LEN of each CONTROL that nothing writes, in the program or outside: it bounds loops."""
        machine, named = self.machine, _named_bits(self.lowered)
        found = {}
        for key, v in machine.vars.items():
            leaf, path = machine.kinds[key], key[0]
            if not _is_length(self.lowered.layout, path) or key in machine.written or key in named:
                continue
            if path not in self._outside and not self._changes_outside(path, leaf, v):
                found[key] = self.engine.memory.read(leaf, key[1])
        return found

    def _run_monitors(self) -> None:
        """Run the monitors; a LadderError if one of them acts on the program."""
        machine, names = self.machine, self.lowered.monitors
        if not names:
            return
        from .monitors import is_monitors_own, monitoring

        before, written = dict(machine.state), set(machine.written)
        with monitoring(machine):
            for name in names:
                machine.call_routine(name, ())
        for key in sorted(machine.written):
            path = key[0]
            if path.startswith(("S:", "~")) or is_monitors_own(path):
                continue
            acts = key in before and machine.state[key] is not before[key]
            if acts or (key not in written and machine.kinds[key].slot is not None):
                raise LadderError(
                    f"a routine NEVER writes {shown(_name_of(key))}, which the program uses: "
                    "a monitor has tags of its own"
                )

    def _begin(self) -> None:
        try:
            self.engine.interpreter.prescan()
        except LadderFault:
            return
        if self.engine.scheduler is not None:
            self.engine.scheduler.begin(0)

    def _note_prescanned(self) -> None:
        """Let bits that prescan clears be free from the second scan on: the first one finds them cleared."""
        free = [
            (name, self.machine.kinds[key], key[1])
            for name, key in self.key_of.items()
            if self.role(name) == "free" and self.machine.kinds[key].slot is None
        ]
        bits = [each for each in free if each[1].type.is_bool]
        if not bits:
            return
        engine = self.program.interpret()
        for _, leaf, index in bits:
            engine.memory.write(leaf, index, True)
        with suppress(LadderFault):
            engine.interpreter.prescan()
        self.late.update(name for name, leaf, index in bits if not engine.memory.read(leaf, index))

    def _settle(self) -> None:
        """Find the role of each variable that has none yet."""
        machine = self.machine
        self.deep = machine.deep
        for name, site in machine.havocs.items():
            self.havocs.setdefault(name, f"{site.routine} {site.place}: {site.instruction}, not modelled")
        for key, v in list(machine.vars.items()):
            if v.val not in self.key_of:
                self.key_of[v.val] = key
                self._give_role(key, v)
            elif v.val in self.next:
                self.next[v.val] = self._next(key)

    def _next(self, key: Key) -> T:
        if key == FIRST_SCAN and self.lowered.schedule is None:
            return FALSE
        after, mask = self.machine.state[key], self.open.get(key, 0)
        if not mask:
            return after
        v = self.machine.vars[key]
        told = var(f"{TOLD}{v.val}", INT, v.lo, v.hi)
        width = self.machine.kinds[key].type.wraps
        for number in _numbers(mask):
            after = setbit(after, number, bit(told, number), width)
        return after

    def _open_bits(self) -> None:
        """Free the bits of numbers that the program names as bits and does not write."""
        machine, named = self.machine, _named_bits(self.lowered)
        for key, v in list(machine.vars.items()):
            mask = named.get(key, 0)
            known = v.val in self.held or v.val in self.next
            if not mask or not known or key[0].startswith(("~", "S:")) or machine.kinds[key].slot is not None:
                continue
            mask &= ~_written_bits(machine.state[key], v)
            if mask:
                self.open[key] = mask
                self.held.discard(v.val)
                self.next[v.val] = self._next(key)

    def _give_role(self, key: Key, v: T) -> None:
        path, leaf = key[0], self.machine.kinds[key]
        is_state = key in self.machine.written or path.endswith(CLOCK)
        if key == FIRST_SCAN and self.lowered.schedule is None:
            self.next[v.val], self.initial[v.val] = FALSE, True
            return
        value = 0 if path.endswith(CLOCK) else self.engine.memory.read(leaf, key[1])
        self.initial[v.val] = value
        if path in self._outside:
            self.late.add(v.val)
        elif is_state and not self._is_written_beside(path):
            self.next[v.val] = self._next(key)
        elif not self._changes_outside(path, leaf, v):
            self.held.add(v.val)

    def _changes_outside(self, path: str, leaf: Leaf, v: T) -> bool:
        """Whether a value that nothing writes is free in each scan."""
        if leaf.slot is not None:
            return not leaf.output
        if path in self._free or self._is_written_beside(path) or _INPUTS.match(path):
            return True
        if (self.lowered.connections or self.lowered.replies) and not path.startswith(("~", "S:")):
            return True  # a consumed tag, or one that gets the reply of a message, may be any of them
        return (v.kind == BOOL and not path.startswith(("~", "S:"))) or path == FIRST_SCAN[0]

    def _is_written_beside(self, path: str) -> bool:
        return any(path == each or path.startswith(each + ".") for each in self._beside)

    # --- values for contracts and questions

    def leaf(self, key: Key) -> Leaf:
        """Return the leaf of a place."""
        return self.lowered.layout.leaf(key[0])

    def after(self, key: Key) -> T:
        """Return the term of a place after a scan."""
        known = self.machine.state.get(key)
        if known is None:
            known = self.machine.peek(self.leaf(key), key[1])
            self._settle()
        return known

    def now(self, key: Key) -> T:
        """Return the value of a place before a scan: of an input, that of this scan."""
        self.after(key)
        return self.machine.vars[key]

    def before(self, name: str, value: T, first: bool | int) -> T:
        """Return the value that a term had in the scan before, `first` in the first scan.

        Args:
            name: tells it from others; the same name is the same term.
        """
        known = var(f"~was:{name}", value.kind, value.lo, value.hi)
        self.next[known.val], self.initial[known.val] = value, first
        return known

    # --- what a verdict depends on

    def limits_met(self) -> tuple[str, ...]:
        """Return where the relation does not follow the program."""
        return tuple(
            f"{site.routine} {site.place}: {name}, {why}" for site, name, why in self.machine.cut[:3]
        )

    def assumed(self, cone: Iterable[str]) -> tuple[str, ...]:
        """Return the numbers of a cone that are held."""
        cone = list(cone)
        held = {name: self.initial[name] for name in cone if name in self.held and not name.startswith("~")}
        held.update((_name_of(key), self.lengths[key]) for key in self.lengths_in(cone))
        return tuple(f"{shown(name)} = {held[name]}" for name in sorted(held))

    def lengths_in(self, cone: Iterable[str]) -> list[Key]:
        """Return the constant lengths of the CONTROLs in a cone: the relation has their values."""
        paths = {self.key_of[name][0] for name in cone if name in self.key_of}
        return [key for key in self.lengths if any(path.startswith(key[0][:-3]) for path in paths)]


_INPUTS = re.compile(r"I:\d|[^.\[]*:(?:S?I|S)\d{0,2}(?![\w:])")
"""Beginning of the path, in capitals, of a module's inputs that are tags here."""


def _is_length(layout: Layout, path: str) -> bool:
    """Whether a path, in capitals, is LEN of a CONTROL; a string has LEN and no POS."""
    return path.endswith(".LEN") and layout.find(f"{path[:-4]}.POS") is not None


def _numbers(mask: int) -> Iterator[int]:
    """Yield the numbers of the bits of a mask."""
    return (number for number in range(mask.bit_length()) if mask >> number & 1)


def _named_bits(lowered: LoweredProgram) -> dict[Key, int]:
    """Return masks of the bits that operands name in numbers; not of what an add-on instruction is passed."""
    found: dict[Key, int] = {}
    operands = [
        operand
        for routine in lowered.routines.values()
        for line in routine.lines
        for step in steps_of(line.nodes)
        for operand in step.operands
    ]
    for place in _places_in(operands):
        if place.bit is None or place.leaf.root:
            continue
        mask = (
            1 << int(place.bit.value) if isinstance(place.bit, Constant) else (1 << place.leaf.type.bits) - 1
        )
        index = place.fixed_index
        for each in range(place.leaf.size) if index is None else (index,):
            key = place.leaf.path.upper(), each
            found[key] = found.get(key, 0) | mask
    return found


def _places_in(operands: Iterable[Any]) -> Iterator[Place]:
    """Yield the places in operands, those in expressions, subscripts and calls included."""
    todo = list(operands)
    while todo:
        each = todo.pop()
        if isinstance(each, Place):
            yield each
            todo += [*each.indices, each.bit]
        elif isinstance(each, Calculation):
            todo += each.operands
        elif isinstance(each, Call):
            todo += each.inputs


def _written_bits(after: T, v: T) -> int:
    """Return a mask of the bits that a scan may change, from the term of a number after it."""
    mask, todo, seen = 0, [after], set()
    while todo:
        t = todo.pop()
        if t is v or t.id in seen:
            continue
        seen.add(t.id)
        if t.op == "setbit":
            mask |= 1 << t.val[0]
            todo.append(t.args[0])
        elif t.op == "ite":
            todo += t.args[1:]
        else:
            return -1
    return mask


def refuse(lowered: LoweredProgram) -> None:
    """Raise a LadderError for what no proof covers: it would be proved around."""
    schedule = lowered.schedule
    found = [f"routine {name} in Python" for name in sorted(lowered.functions)]
    if schedule is not None:
        found += [f"task {each.task.name}, which preempts" for each in schedule.tasks if each.task.preempt]
        found += [f"fault routine {each.fault}" for each in schedule.programs if each.fault is not None]
    found += [f"the sequential function chart {name}" for name in sorted(lowered.charts)]
    if lowered.axes or lowered.ideal is not None:
        found.append("motion axes")
    if found:
        raise LadderError(
            f"{lowered.name} has {', '.join(found)}: nothing is proved about such a program, "
            "as a proof does not cover it"
        )


def _written_beside(lowered: LoweredProgram) -> tuple[str, ...]:
    """Return starts of paths that others than rungs write: status file of an SLC, messages under way."""
    found = [STATUS] if before_scan in lowered.opening else []
    if any(isinstance(each, partial) for each in lowered.closing):
        ends = (".~WAITING", ".~STARTED_NS")
        found += [path[: path.rfind(".")] for path in lowered.layout.leaves if path.endswith(ends)]
    tags = Tags(lowered, None)  # type: ignore[arg-type]  # names are resolved without memory
    for to, _ in lowered.replies.values():  # what a message brings
        where = tags.where(to)
        path = where.leaf.path if isinstance(where, Place) else where.path
        found.append(tag_in(path).upper())
    return tuple(found)


def _named(layout: Layout, what: str, patterns: Sequence[str]) -> frozenset[str]:
    """Return the paths, in capitals, that patterns name; a structure names all its members."""
    found: set[str] = set()
    paths = [*layout.leaves] if patterns else []
    for each in patterns:
        wanted = each.upper().replace("[", "[[]")
        hits = [
            path
            for path in paths
            if path == each.upper() or path.startswith(each.upper() + ".") or fnmatchcase(path, wanted)
        ]
        if not hits:
            raise LadderError(f"{what}: no tag is called {each!r}")
        found.update(hits)
    return frozenset(found)


def _name_of(key: Key) -> str:
    return f"{key[0]}[{key[1]}]"


def shown(name: str) -> str:
    """Return a variable's name as a person writes it: without the subscript of what has none."""
    return name.removesuffix("[0]")
