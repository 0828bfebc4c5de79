"""A program as a transition system for proofs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Set
from contextlib import suppress
from typing import Any, ClassVar, Protocol

from ...model.errors import LadderError, LadderFault
from ...model.tags import Leaf
from ...run.edit import is_retained
from ...run.engine import Engine
from ...state.lowered import LoweredProgram
from ..algebra import terms
from ..algebra.meaning import BOOL, INT
from ..algebra.numbers import add, bit, least, setbit
from ..algebra.terms import FALSE, T, and_, const, ite, not_, numbers_in, or_, var
from ..relation.noting import NotingMachine
from ..relation.places import CLOCK, Key, kind_of, name_of
from .events import LOST_LINK, PROGRAM_MODE, RETAINED_START
from .held import held_bits, held_numbers
from .outside import INPUTS, is_length, named_bits, named_paths, refuse, written_beside, written_bits
from .transition import (
    BEGUN,
    FIRST_SCAN,
    OFF,
    RETAINED,
    STOPPED,
    THEN,
    TURNED,
    WRITTEN,
    HeldNumber,
    ScanBounds,
    System,
    shown,
)


class Runnable(Protocol):
    """A program that can run on the interpreter and compiled."""

    def build(self) -> LoweredProgram:
        """Return the lowered program."""

    def interpret(self) -> Engine:
        """Return an engine on the interpreter."""

    def compile(self) -> Engine:
        """Return an engine on the compiled program."""


Contract = Callable[["ProgramSystem"], T]
"""Builds a condition on each scan from the values of `ProgramSystem.now` and `ProgramSystem.before`."""


def _unknown(_problem: ProgramSystem, _truth: T) -> bool:
    return False


ANY_BOUNDS = ScanBounds()


class ProgramSystem(System):
    """A program as a transition system.

    Args:
        program: the program, with or without monitors, see `monitors.monitored`.
        bounds: bounds of the time between scans.
        free: tags with numbers that are free in each scan: `Recipe`, `Recipe.*`.
        written_outside: tags that the program writes and that also change from outside.
        assume: bits that are true after each scan; runs that break them are not considered.
        contracts: conditions on the inputs in each scan.
        happens: names of the possible events between two scans, see `events`.
        beside: another problem to compare with; both share their terms.
        kept: paths of tags, in capitals, that the other program of a comparison writes; they don't change
            from outside.

    Attributes:
        engine: the interpreter's engine after prescan, with the initial values.
        machine: the relation of one scan.
        open: masks of the bits of numbers that are written from outside.
        stops: the condition that a major fault stops the processor.
        prescans: the condition that a prescan follows a scan.

    Raises:
        LadderError: proofs don't support a part of the program, or no tag has a name in `free` or
            `written_outside`.
    """

    never_holds: ClassVar[Callable[[ProgramSystem, T], bool]] = staticmethod(_unknown)
    """Returns whether a condition is proved never to be true, to rule out faults; `induction` sets it."""

    def __init__(
        self,
        program: Runnable,
        bounds: ScanBounds = ANY_BOUNDS,
        *,
        free: Sequence[str] = (),
        written_outside: Sequence[str] = (),
        assume: Sequence[Key] = (),
        contracts: Sequence[Contract] = (),
        happens: Collection[str] = (PROGRAM_MODE,),
        beside: ProgramSystem | None = None,
        kept: Set[str] = frozenset(),
    ) -> None:
        """Build the relation of a scan, and build it again if a major fault can end a scan."""
        super().__init__()
        if beside is None:
            terms.forget()
        self.program, self.bounds, self.assume = program, bounds, tuple(assume)
        self.engine = program.interpret()
        self.lowered = self.engine.lowered
        refuse(self.lowered)
        self._free = named_paths(self.lowered.layout, "free", free)
        self._outside = named_paths(self.lowered.layout, "written_outside", written_outside)
        self._beside = written_beside(self.lowered)
        self._kept = kept
        self.settings: dict[str, Any] = {
            "free": free,
            "written_outside": written_outside,
            "assume": assume,
            "contracts": contracts,
            "happens": happens,
        }
        self.happens = happens
        self._begin()
        self._build(ends=False)
        if self.stops is not FALSE and not type(self).never_holds(self, self.stops):
            self._build(ends=True)

    def _build(self, *, ends: bool) -> None:
        """Build the relation of a scan, and find the role of each value.

        Args:
            ends: whether a major fault ends a scan.
        """
        bounds, happens = self.bounds, self.happens
        System.__init__(self)
        self.open: dict[Key, int] = {}  # masks of the bits that are written from outside
        self._lost = FALSE  # where the module of the current contracts has lost its link
        if RETAINED_START in happens:
            self.next[BEGUN], self.initial[BEGUN] = var(RETAINED), False
        self.machine = self._scanned({}, ends=ends)
        self.lengths = self._constant_lengths()
        if self.lengths:
            scanned = self._scanned(self.lengths, ends=ends)
            if self.lengths.keys() & scanned.written:
                self.lengths = {}
            else:
                self.machine = scanned
        self.machine.noting = False  # monitors are not part of the program
        self._run_monitors()
        self.stops = self.machine.stops
        if ends:
            self.next[STOPPED], self.initial[STOPPED] = self.stops, False
            self.contract = not_(var(STOPPED))
        self.prescans = or_(
            var(TURNED) if PROGRAM_MODE in happens else FALSE,
            var(RETAINED) if RETAINED_START in happens else FALSE,
        )
        if self.prescans is not FALSE:
            self._prescan_after()
        self.least, self.tick_ns = bounds.ticks[0], bounds.tick_ns
        self._settle()
        for key in self.assume:
            self.contract = and_(self.contract, self.after(key))
        self.kept = [self._kept_by(number, make) for number, make in enumerate(self.settings["contracts"])]
        self._settle()
        self._open_bits()
        self._note_prescanned()

    def _prescan_after(self) -> None:
        """Prescan after the scan, for program mode and for a start with retained tags."""
        machine, bit_masks = self.machine, named_bits(self.lowered)
        written = machine.written  # places that the scan writes; prescan has another list
        blank = self.program.interpret().memory

        def begins(key: Key, t: T) -> T:
            """Return a place's value before prescan; at a retained start, other tags have initial values."""
            leaf = machine.leaves.get(key)
            if RETAINED_START not in self.happens or leaf is None or is_retained(self.lowered.layout, leaf):
                return t
            value = 0 if key[0].endswith(CLOCK) else blank.read(leaf, key[1])
            return ite(var(RETAINED), const(value, t.kind), t)

        def reads(key: Key, t: T) -> T:
            """Return the value that prescan reads: any value, if it may have been written from outside."""
            path, variable = key[0], machine.vars[key]
            outside, is_given = path in self._outside, self._is_given(path, machine.leaves[key])
            unwritten = key not in written and self._changes_outside(path, machine.leaves[key], variable)
            written_value = var(f"{THEN}{variable.val}", variable.kind, variable.lo, variable.hi)
            if outside or is_given or (unwritten and not path.endswith(CLOCK)):
                return written_value
            for number in numbers_in(self._open_mask(key, variable, bit_masks)):
                t = setbit(t, number, bit(written_value, number), machine.leaves[key].type.wraps)
            return t

        machine.turn_key(self.prescans, begins, reads)

    def _scanned(self, known: Mapping[Key, Any], *, ends: bool) -> NotingMachine:
        """Run one scan on a new machine and return the machine."""
        machine = NotingMachine(self.lowered, self.bounds.ticks, known)
        machine.tick_ns, machine.ends = self.bounds.tick_ns, ends
        machine.begun = var(BEGUN) if RETAINED_START in self.happens else FALSE
        machine.scan_terms()
        return machine

    def _constant_lengths(self) -> dict[Key, Any]:
        """Return the LEN of each CONTROL that nothing writes, as a bound for loops."""
        layout, written = self.lowered.layout, {*self.machine.written, *named_bits(self.lowered)}
        lengths = {}
        for leaf in layout.leaves.values():
            path = leaf.path.upper()
            if leaf.root or not is_length(layout, path) or path in self._outside:
                continue
            for index in range(leaf.size):
                variable = var(name_of((path, index)), *kind_of(leaf.type))
                if (path, index) not in written and not self._changes_outside(path, leaf, variable):
                    lengths[path, index] = self.engine.memory.read(leaf, index)
        return lengths

    def _run_monitors(self) -> None:
        """Run the monitors; raise a LadderError if one of them changes a value of the program."""
        machine, names = self.machine, self.lowered.monitors
        if not names:
            return
        from ..monitors import is_claims, is_monitors_own, monitoring

        state_before, written = dict(machine.state), set(machine.written)
        saved_ends, machine.ends = machine.ends, True
        with monitoring(machine):
            for name in names:
                faults, stops = len(machine.faults), machine.stops
                machine.call_routine(name, ())
                machine.begin_again()
                if is_claims(name):  # the claim is broken, see `monitors`
                    del machine.faults[faults:]
                    machine.stops = stops
        machine.ends = saved_ends
        for key in sorted(machine.written):
            path = key[0]
            if path.startswith(("S:", "~")) or is_monitors_own(path):
                continue
            acts = key in state_before and machine.state[key] is not state_before[key]
            if acts or (key not in written and machine.leaves[key].slot is not None):
                raise LadderError(
                    f"a routine NEVER writes {shown(name_of(key))}, which the program uses: "
                    "a monitor has its own tags"
                )

    def _begin(self) -> None:
        """Prescan the engine, so that its memory has the values before the first scan.

        A major fault ends prescan, as in the controller.
        """
        if self.engine.lowered.resume is not None:
            raise LadderError("a proof begins with prescan, but this program keeps its values")
        try:
            self.engine.interpreter.prescan()
        except LadderFault:
            return
        if self.engine.scheduler is not None:
            self.engine.scheduler.begin(0)

    def _note_prescanned(self) -> None:
        """Free the bits that prescan clears, but only from the second scan on; they are off in the first."""
        free = [
            (name, self.machine.leaves[key], key[1])
            for name, key in self.key_of.items()
            if self.role(name) == "free" and self.machine.leaves[key].slot is None
        ]
        bits = [place for place in free if place[1].type.is_bool]
        if not bits:
            return
        engine = self.program.interpret()
        for _, leaf, index in bits:
            engine.memory.write(leaf, index, True)
        with suppress(LadderFault):
            engine.interpreter.prescan()
        self.late.update(name for name, leaf, index in bits if not engine.memory.read(leaf, index))

    def _settle(self) -> None:
        """Assign a role to each variable that has none."""
        machine = self.machine
        self.deep = machine.deep
        for name, site in machine.unmodeled.items():
            self.unmodeled.setdefault(name, f"{site.routine} {site.place}: {site.instruction}, not modeled")
        for key, variable in list(machine.vars.items()):
            if variable.val not in self.key_of:
                self.key_of[variable.val] = key
                self._give_role(key, variable)
            elif variable.val in self.next:
                self.next[variable.val] = self._next(key)

    def _next(self, key: Key) -> T:
        """Return a value after a scan and after the events before the next scan."""
        if key == FIRST_SCAN and self.lowered.schedule is None:
            return self.prescans
        next_term = self.machine.state[key] if self.prescans is FALSE else self.machine.before_next(key)
        if key[0].endswith(CLOCK):
            off = (
                and_(self.prescans, not_(var(RETAINED))) if RETAINED_START in self.happens else self.prescans
            )
            most = self.machine.most_age
            return ite(off, least(add(next_term, var(OFF, INT, 0, most)), most), next_term)
        return self._with_open_bits(key, next_term, self.open.get(key, 0))

    def _with_open_bits(self, key: Key, next_term: T, mask: int) -> T:
        """Return a number after a scan, with its open bits written from outside."""
        variable = self.machine.vars[key]
        written = var(f"{WRITTEN}{variable.val}", INT, variable.lo, variable.hi)
        width = self.machine.leaves[key].type.wraps
        for number in numbers_in(mask):
            next_term = setbit(next_term, number, bit(written, number), width)
        return next_term

    def _open_bits(self) -> None:
        """Free the bits of numbers that the program names but does not write."""
        machine, bit_masks = self.machine, named_bits(self.lowered)
        for key, variable in list(machine.vars.items()):
            has_value = variable.val in self.held or variable.val in self.next
            mask = self._open_mask(key, variable, bit_masks) if has_value else 0
            if mask:
                self.open[key] = mask
                self.held.discard(variable.val)
                self.next[variable.val] = self._next(key)

    def _open_mask(self, key: Key, v: T, bit_masks: Mapping[Key, int]) -> int:
        """Return a mask of the bits of a number that the program names but does not write."""
        mask = bit_masks.get(key, 0)
        if not mask or key[0].startswith(("~", "S:")) or self.machine.leaves[key].slot is not None:
            return 0
        return mask & ~written_bits(self.machine.state[key], v)

    def _give_role(self, key: Key, v: T) -> None:
        """Make a value a state, held or late, with an initial value, or leave it free in each scan."""
        path, leaf = key[0], self.machine.leaves[key]
        is_state = key in self.machine.written or path.endswith(CLOCK)
        if key in self.machine.prescanned_places and not self._changes_outside(path, leaf, v):
            is_state = True  # a value that nothing else writes may still change with each prescan
        if key == FIRST_SCAN and self.lowered.schedule is None:
            self.next[v.val], self.initial[v.val] = self._next(key), True
            return
        value = 0 if path.endswith(CLOCK) else self.engine.memory.read(leaf, key[1])
        self.initial[v.val] = value
        if path in self._outside:
            self.late.add(v.val)
        elif is_state and not self._is_given(path, leaf):
            self.next[v.val] = self._next(key)
        elif not self._changes_outside(path, leaf, v):
            self.held.add(v.val)

    def _is_given(self, path: str, leaf: Leaf) -> bool:
        """Return whether a place gets a new value from outside in each scan, even if rungs write it."""
        if leaf.slot is not None:
            return not leaf.output
        return path in self._free or self.is_written_beside(path) or INPUTS.match(path) is not None

    def _changes_outside(self, path: str, leaf: Leaf, v: T) -> bool:
        """Return whether a value that nothing writes is free in each scan."""
        if leaf.slot is not None or self._is_given(path, leaf):
            return self._is_given(path, leaf)
        if path in self._kept:
            return False
        if (self.lowered.connections or self.lowered.replies) and not path.startswith(("~", "S:")):
            return True  # any tag may be consumed, or receive the reply to a message
        return (v.kind == BOOL and not path.startswith(("~", "S:"))) or path == FIRST_SCAN[0]

    def is_written_beside(self, path: str) -> bool:
        """Return whether something other than rungs writes a value, by its path in capitals."""
        return any(path == prefix or path.startswith(prefix + ".") for prefix in self._beside)

    # --- values for contracts and questions

    def leaf(self, key: Key) -> Leaf:
        """Return the leaf of a place."""
        return self.lowered.layout.leaf(key[0])

    def after(self, key: Key) -> T:
        """Return the term of a place after a scan."""
        term = self.machine.state.get(key)
        if term is None:
            term = self.machine.value_here(self.leaf(key), key[1])
            self._settle()
        return term

    def now(self, key: Key) -> T:
        """Return the value of a place before a scan; for an input, the value that the scan reads."""
        self.after(key)
        return self.machine.vars[key]

    def before(self, name: str, value: T, first: bool | int) -> T:
        """Return the value that a term had in the previous scan, or `first` in the first scan.

        Args:
            name: identifies the term; the same name means the same term.
        """
        state = var(f"~was:{name}", value.kind, value.lo, value.hi)
        broken = or_(self.prescans, self._lost)
        if broken is not FALSE:  # then any input may follow any other
            value = ite(broken, var(f"~any:{name}", value.kind, value.lo, value.hi), value)
        self.next[state.val], self.initial[state.val] = value, first
        return state

    def _kept_by(self, number: int, make: Contract) -> T:
        """Return the condition that a module fulfills its contract or has lost its link."""
        if LOST_LINK in self.happens:
            self._lost = var(f"~lost:{number}")
        condition, self._lost = or_(self._lost, make(self)), FALSE
        return condition

    # --- dependencies of a verdict

    def limits_met(self) -> tuple[str, ...]:
        """Return the places where the relation does not follow the program."""
        return tuple(
            f"{site.routine} {site.place}: {name}, {reason}" for site, name, reason in self.machine.cut[:3]
        )

    def held_numbers(self, cone: Iterable[str], roots: Sequence[T]) -> tuple[HeldNumber, ...]:
        """Return the numbers and bits that terms and their cone read and that nothing writes."""
        cone = list(cone)
        paths = {self.key_of[name][0] for name in cone if name in self.key_of}
        numbers = list(held_numbers(self, cone, roots, self._written_masks()))
        for key, value in self.lengths.items():
            if any(path.startswith(key[0].removesuffix("LEN")) for path in paths):
                numbers.append(HeldNumber(key, None, value))
        return tuple(numbers)

    def next_of_any(self, roots: Sequence[T]) -> dict[str, T]:
        """Return the next values of states; bits that terms read and nothing writes are free."""
        next_states = dict(self.next)
        for name, mask in held_bits(self, self.next, roots, self._written_masks()).items():
            next_states[name] = self._with_open_bits(self.key_of[name], next_states[name], mask)
        return next_states

    def _written_masks(self) -> dict[str, int]:
        """Return masks of the written bits, for numbers in which a scan writes only some bits."""
        masks = {}
        for key, variable in self.machine.vars.items():
            is_own = self.machine.leaves[key].slot is None and not key[0].startswith(("~", "S:"))
            if variable.kind == INT and is_own and variable.val in self.next:
                mask = written_bits(self.next[variable.val], variable)
                if mask != -1:
                    masks[variable.val] = mask
        return masks
