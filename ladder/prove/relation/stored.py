"""Places of a scan on terms: reading, writing, unknown values, and the paths of an instruction.

`value_here` reads a term that is simplified under the condition that the current instruction is reached, so
the term is wrong elsewhere. `_kept` has the stored terms, which are right everywhere. Only `_assign` changes
stored terms, and it keeps the old term where the instruction is not reached. Therefore a simplified term is
never stored where it is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from itertools import count
from types import MappingProxyType
from typing import Any

from scanrack.io_images.site import Site

from ...interpreter import Interpreter
from ...model.operands import Place, Resolved
from ...model.tags import Leaf
from ...state.lowered import LoweredProgram
from ..algebra.meaning import F32, F64, INT
from ..algebra.numbers import add, bitop, div, eq, le, least, lt, rem, to_float, wrap
from ..algebra.terms import FALSE, TRUE, T, and_, const, ite, not_, or_, var
from .faults import TermFaults
from .paths import Path, PathFault, Paths, faults_of, merged, result_of, written_by
from .places import AGE, CLOCK, Key, TermArgument, TermMemory, kind_of, name_of
from .symbols import TermSymbol, UnmodeledError, term_of, truth_of, whole_of
from .undo import UndoLog
from .unknowns import ONLY, UnknownOrigin

MOST_FACTS = 64
"""Maximum number of conditions known to be true at a place in the program."""

MOST_OPEN = 4096
"""Maximum number of elements of a leaf that are arguments of instructions without a model."""

Lost = tuple[T, Site]
"""Condition under which a leaf's elements beyond `MOST_OPEN` became unknown, and the instruction to blame."""


class TermPlaces(Interpreter):
    """Reads and writes terms; `active` is the condition that the current instruction is reached."""

    argument_type = TermArgument

    tick_ns = 1_000_000
    """Unit of scan times and elapsed times, in ns."""

    begun: T = FALSE
    """The condition that no time has passed before the scan."""

    ends = False
    """Whether a major fault ends the scan; otherwise the scan continues, as if faults were impossible."""

    def __init__(self, lowered: LoweredProgram, dt: tuple[int, int], known: Mapping[Key, Any]) -> None:
        # terms take the place of the memory and the fault log
        super().__init__(lowered, TermMemory(self, lowered.layout), TermFaults(self), _no_python)  # type: ignore[arg-type]
        self.log = UndoLog()
        self.active: T = TRUE
        self.dt = var("~dt", INT, *dt)
        self.paths = Paths()

        # stored values, by place
        self.known = known  # values that never change
        self._kept: dict[Key, T] = {}  # current values, right everywhere
        self.state: Mapping[Key, T] = MappingProxyType(self._kept)
        self.vars: dict[Key, T] = {}  # values before the scan, as variables
        self.leaves: dict[Key, Leaf] = {}
        self.written: dict[Key, bool] = {}
        self._in_use: dict[str, list[int]] = {}  # elements that have a variable, by path in capitals

        # unknown values
        self.unmodeled: dict[str, Site] = {}  # variables of values that are not modeled, and the instruction
        self.origins: dict[T, UnknownOrigin] = {}  # the functions of the variables in `unmodeled`
        self._unknowns = count()
        self._computed: dict[tuple[Any, ...], T] = {}  # unknown results, by function and operands
        self._lost: dict[str, list[Lost]] = {}  # where a whole leaf became unknown, by path in capitals

        # faults
        self.faults: list[tuple[int, T]] = []  # conditions of major faults, by number of the instruction
        self.may_fault: dict[str, Site] = {}  # variables for faults of instructions without a model
        self.stops: T = FALSE  # condition of a major fault that stops the processor
        self.faulted: T = FALSE  # condition that it has ended the scan, if `ends`

        # facts: ids of conditions that hold under a value of `active`, see `_facts`
        self._facts_of, self._known_facts = TRUE, frozenset[int]()

    @property
    def most_age(self) -> int:
        """Maximum elapsed time that a term can represent, in ticks."""
        return AGE * (1_000_000 // self.tick_ns)

    @property
    def now_ns(self) -> int:
        """Raise UnmodeledError, because proofs have no absolute time, only `start_clock` and `elapsed`."""
        raise UnmodeledError("the clock is read")

    @now_ns.setter
    def now_ns(self, _value: int) -> None:
        """Ignore an assigned time."""

    def symbol(self, t: T) -> Any:
        """Return a term as a number that rows can use; return the value of a constant."""
        return t.val if t.op == "const" else TermSymbol(t, self.paths.decide)

    def value_here(self, leaf: Leaf, index: int) -> T:
        """Return the term of a place under the condition that the instruction is reached; don't store it."""
        key = leaf.path.upper(), index
        path = self.paths.path
        if path is not None and key in path.written:
            return path.written[key]
        if key not in self._kept:
            self._read_first(key, leaf)
        return self._reached(self._kept[key])

    def _reached(self, t: T) -> T:
        """Simplify a term under the condition that the current instruction is reached."""
        while t.op == "ite" and self.active is not TRUE:
            condition, if_true, if_false = t.args
            facts = self._facts()
            if condition.id in facts:
                t = if_true
            elif not_(condition).id in facts:
                t = if_false
            else:
                break
        return t

    def _facts(self) -> frozenset[int]:
        """Return the ids of conditions that are true where the current instruction is reached."""
        if self._facts_of is not self.active:
            todo, facts = [self.active], set[int]()
            while todo and len(facts) < MOST_FACTS:
                term = todo.pop(0)
                facts.add(term.id)
                todo.extend(term.args if term.op == "and" else ())
            self._facts_of, self._known_facts = self.active, frozenset(facts)
        return self._known_facts

    def _read_first(self, key: Key, leaf: Leaf) -> None:
        """Create the variable of a place, or the constant of a place that never changes.

        A clock is stored as its age, and the time of the scan is added to it. An element of a leaf that
        became unknown earlier in the scan is unknown under the same conditions.
        """
        put = self.log.put
        self.log.append_at(self._in_use, key[0], key[1])
        if key in self.known:
            put(self._kept, key, const(self.known[key], kind_of(leaf.type)[0]))
            return
        name = name_of(key)
        if key[0].endswith(CLOCK):
            age = var(name, INT, 0, self.most_age)
            current = least(add(age, ite(self.begun, const(0), self.dt)), self.most_age)
        else:
            age = current = var(name, *kind_of(leaf.type))
        for condition, site in self._lost.get(key[0], ()):
            current = ite(condition, self.unknown_of(leaf, key[1], site=site), current)
            put(self.written, key, True)
        put(self.vars, key, age)
        put(self.leaves, key, leaf)
        put(self._kept, key, current)

    def _assign(self, key: Key, condition: T, t: T) -> None:
        """Set a place where the instruction is reached and `condition` is true; keep it elsewhere."""
        self.log.put(self._kept, key, ite(and_(self.active, condition), t, self._kept[key]))

    def havoc(self, leaf: Leaf, origin: UnknownOrigin = ONLY) -> None:
        """Make all elements of a leaf unknown where the current instruction is reached.

        Elements beyond `MOST_OPEN` that are not in use become unknown when they are first used.

        Args:
            origin: the origin of the unknown values, with the instruction.
        """
        path = leaf.path.upper()
        for index in self.elements_in_use(leaf):
            self.poke(leaf, index, self.unknown_of(leaf, index, origin))
        if leaf.size > MOST_OPEN:
            self.log.append_at(self._lost, path, (self.active, self.lowered.sites[self.site]))

    def elements_in_use(self, leaf: Leaf) -> list[int]:
        """Create variables for a leaf's elements up to `MOST_OPEN`; return the elements that have one."""
        for index in range(min(leaf.size, MOST_OPEN)):
            self.value_here(leaf, index)
        return self._in_use.get(leaf.path.upper(), [])

    @property
    def partly_lost(self) -> list[str]:
        """Return the paths, in capitals, of leaves with unknown elements that have no variables."""
        return sorted(self._lost)

    def poke(self, leaf: Leaf, index: int, t: T, guard: T = TRUE) -> None:
        """Set a place to a value of its type where the guard is true."""
        key = leaf.path.upper(), index
        present = self.value_here(leaf, index)
        self.log.put(self.written, key, True)
        t = self._fitting(t, leaf, key)
        path = self.paths.path
        if path is not None:
            path.written[key] = ite(guard, t, present)
        else:
            self._assign(key, guard, t)

    def _fitting(self, t: T, leaf: Leaf, key: Key) -> T:
        """Return a value converted to the type of a place; the age of a clock stays within `most_age`."""
        kind = leaf.type
        if kind.is_bool:
            return truth_of(t)
        if kind.is_real or kind.is_double:
            return to_float(t, F32 if kind.is_real else F64)
        return least(t, self.most_age) if key[0].endswith(CLOCK) else wrap(whole_of(t), kind.wraps)

    def get(self, place: Place) -> Any:
        """Return the value of a place."""
        value = self.store_of(place.leaf.root).read(place.leaf, self._index(place))
        if place.bit is None:
            return value
        number = self.subscript(place.bit, place.leaf.type.bits, place.text)
        return self.memory.bit_of(value, number)  # type: ignore[attr-defined]

    def put(self, place: Place, value: Any) -> None:
        """Set a place to a value of its type."""
        index, store = self._index(place), self.store_of(place.leaf.root)
        if place.bit is not None:
            number = self.subscript(place.bit, place.leaf.type.bits, place.text)
            word = store.read(place.leaf, index)
            value = self.memory.with_bit(word, number, value, place.leaf.type)  # type: ignore[attr-defined]
        store.write(place.leaf, index, value)

    def subscript(self, index: Resolved, length: Any, tag: str) -> Any:
        """Return a subscript or bit number; fault unless it is at least 0 and less than `length`."""
        value: Any = self.integer(index)
        if not isinstance(value, TermSymbol) and not isinstance(length, TermSymbol):
            if not 0 <= value < length:
                raise PathFault
            return value
        term, most = term_of(value, INT), term_of(length, INT)
        if self.paths.decide(or_(lt(term, const(0)), le(most, term))):
            raise PathFault
        return self.symbol(_below(term, most.hi))

    def start_clock(self, since: Place) -> None:
        """Start a clock in a hidden place."""
        self.put(since, 0)

    def elapsed(self, since: Place, unit_ns: int) -> Any:
        """Return the whole units of time since the clock started, and keep the remainder."""
        age = term_of(self.get(since), INT)
        if unit_ns == self.tick_ns:
            self.put(since, 0)
            return self.symbol(age)
        if unit_ns % self.tick_ns:
            raise UnmodeledError("a time that is not counted in parts of it")
        unit = const(unit_ns // self.tick_ns)
        unknown_rest = self.computed(("rest", unit_ns), (INT, 0, unit.val - 1), age, strict=True)
        remainder = ite(eq(age, const(self.most_age)), unknown_rest, rem(age, unit))
        self.put(since, self.symbol(remainder))
        return self.symbol(div(age, unit))

    # --- unknown values

    def unknown(self, kind: str, lo: int = 0, hi: int = 0, origin: UnknownOrigin = ONLY) -> T:
        """Return a variable for a value that is not modeled; see `Paths.unknown`."""
        symbol = self.paths.unknown((kind, lo, hi), lambda: self._new_unknown(kind, lo, hi))
        return self._noted(symbol, origin, self.lowered.sites[self.site])

    def computed(self, name: Hashable, kind: tuple[str, int, int], *operands: T, strict: bool = False) -> T:
        """Return the unknown result of a computation, which is the same for the same operands.

        Args:
            name: identifies the computation.
            kind: kind and interval of the result.
            strict: see `UnknownOrigin`.
        """
        key = name, kind, *[operand.id for operand in operands]
        if key not in self._computed:
            self._computed[key] = self._new_unknown(*kind)
        origin = UnknownOrigin((name, kind), dict(enumerate(operands)), strict)
        return self._noted(self._computed[key], origin, self.lowered.sites[self.site])

    def unknown_of(self, leaf: Leaf, index: int, origin: UnknownOrigin = ONLY, site: Site | None = None) -> T:
        """Return a new variable for an element; the instruction to blame is the current one by default."""
        path = leaf.path.upper()
        kind = (INT, 0, self.most_age) if path.endswith(CLOCK) else kind_of(leaf.type)
        symbol = self._new_unknown(*kind)
        return self._noted(symbol, origin.of((path, index)), site or self.lowered.sites[self.site])

    def _new_unknown(self, kind: str, lo: int, hi: int) -> T:
        return var(f"?{next(self._unknowns)}", kind, lo, hi)

    def _noted(self, variable: T, origin: UnknownOrigin, site: Site) -> T:
        self.log.put(self.unmodeled, variable.val, site)
        self.log.put(self.origins, variable, origin)
        return variable

    # --- paths

    def on_paths(self, run: Callable[[], Any]) -> T:
        """Run a function on every path and store all writes; return the result as a condition."""
        return merged(self.merge_paths(run), result_of)

    def merge_paths(self, run: Callable[[], Any]) -> list[Path]:
        """Run a function on every path and store all writes; return the paths."""
        paths = self.paths.walk(run)
        self.write_paths(paths)
        bad = faults_of(paths)
        if bad is not FALSE:
            self.log.add(self.faults, (self.site, and_(self.active, bad)))
            self.stop(bad)
        return paths

    def stop(self, bad: T) -> None:
        """Stop the processor where a condition is true; if `ends`, the scan ends there."""
        stopped = and_(self.active, bad)
        self.stops = or_(self.stops, stopped)
        if self.ends:
            self.faulted = or_(self.faulted, stopped)
            self.active = and_(self.active, not_(bad))

    def write_paths(self, paths: list[Path]) -> None:
        """Write the merged values of paths."""
        for key in written_by(paths):
            old = self._kept[key]
            new = merged(paths, lambda path, key=key, old=old: path.written.get(key, old), all_=self.ends)  # type: ignore[misc]
            self._assign(key, TRUE, new)

    def here(self) -> T:
        """Return the condition that the current path is taken."""
        return and_(self.active, self.paths.here())


def _no_python(name: str, _inputs: object) -> Any:
    raise UnmodeledError(f"routine {name} in Python")


def _below(t: T, most: int) -> T:
    """Return a number known to be at least 0 and below `most` as a term with a suitable interval."""
    mask = (1 << max(0, most - 1).bit_length()) - 1
    return t if t.lo >= 0 and t.hi <= mask else bitop("band", t, const(mask))
