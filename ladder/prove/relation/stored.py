"""Places of a scan on terms: reading, writing, what is unknown, and the paths of an instruction.

There are two kinds of reading. `value_here` returns a term as it is where the current instruction is reached:
simplified, and false elsewhere. `_kept` has the stored terms, which hold everywhere. Only `_assign` changes
them, and where the instruction is not reached a place keeps its stored term. So no simplified term can be
stored for a condition under which it does not hold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from types import MappingProxyType
from typing import Any

from ....io_images.site import Site
from ...interpreter import Interpreter
from ...model.operands import Place, Resolved
from ...model.tags import Leaf
from ...state.lowered import LoweredProgram
from ..algebra.meaning import F32, F64, INT
from ..algebra.numbers import add, bitop, div, eq, le, least, lt, rem, to_float, wrap
from ..algebra.terms import FALSE, TRUE, T, and_, const, ite, not_, or_, var
from .faults import TermFaults
from .paths import Path, PathFault, Paths, faults_of, merged, result_of, written_by
from .places import AGE, CLOCK, Key, TermArgument, TermMemory, kind_of
from .symbols import TermSymbol, UnmodelledError, term_of, truth_of, whole_of
from .undo import UndoLog

MOST_FACTS = 64
"""Maximum truths that are known of a place in the program."""


Lost = tuple[T, Site]
"""Where a leaf has become unknown, and by which instruction."""


class TermPlaces(Interpreter):
    """Reads and writes terms; `active` is whether the current instruction is reached at all."""

    argument_type = TermArgument

    parts = False
    """Whether scan times have parts of a ms: then each timer may count one ms more in a scan."""

    begun: T = FALSE
    """Whether no time has passed before the scan."""

    def __init__(self, lowered: LoweredProgram, dt: tuple[int, int], known: Mapping[Key, Any]) -> None:
        self.known = known  # values that never change
        self.log = UndoLog()
        self._kept: dict[Key, T] = {}  # values now, wherever the scan is
        self.state: Mapping[Key, T] = MappingProxyType(self._kept)
        self.vars: dict[Key, T] = {}  # values before the scan: variables
        self.kinds: dict[Key, Leaf] = {}
        self.written: dict[Key, bool] = {}
        self.havocs: dict[str, Site] = {}  # variables for what is not modeled, and the instruction
        self._unknowns = count()
        self.faults: list[tuple[int, T]] = []  # major faults: number of the instruction, condition
        self._lost: dict[str, list[Lost]] = {}  # where all of a leaf has become unknown, by path in capitals
        self._asked: dict[str, list[int]] = {}  # elements with a variable, by path in capitals
        self.active: T = TRUE
        self._facts_of, self._known_facts = TRUE, frozenset[int]()
        self.dt = var("~dt", INT, *dt)
        self.paths = Paths()
        faults = TermFaults(self)
        super().__init__(lowered, TermMemory(self, lowered.layout), faults, _no_python)  # type: ignore[arg-type]

    @property
    def now_ns(self) -> int:
        """Raise UnmodelledError: proofs have no absolute time, only `start_clock` and `elapsed`."""
        raise UnmodelledError("the clock is read")

    @now_ns.setter
    def now_ns(self, _value: int) -> None:
        """Take no time."""

    def symbol(self, t: T) -> Any:
        """Return a term as a number for rows, a constant as its value."""
        return t.val if t.op == "const" else TermSymbol(t, self.paths.decide)

    def value_here(self, leaf: Leaf, index: int) -> T:
        """Return the term of a place where the current instruction is reached: it can't be stored."""
        key = leaf.path.upper(), index
        path = self.paths.path
        if path is not None and key in path.written:
            return path.written[key]
        if key not in self._kept:
            self._read_first(key, leaf)
        return self._reached(self._kept[key])

    def _reached(self, t: T) -> T:
        """Return a term as it is where the current instruction is reached, which is all that counts there."""
        while t.op == "ite" and self.active is not TRUE:
            condition, held, other = t.args
            facts = self._facts()
            if condition.id in facts:
                t = held
            elif not_(condition).id in facts:
                t = other
            else:
                break
        return t

    def _facts(self) -> frozenset[int]:
        """Return the ids of truths that hold where the current instruction is reached."""
        if self._facts_of is not self.active:
            todo, found = [self.active], set[int]()
            while todo and len(found) < MOST_FACTS:
                t = todo.pop(0)
                found.add(t.id)
                todo.extend(t.args if t.op == "and" else ())
            self._facts_of, self._known_facts = self.active, frozenset(found)
        return self._known_facts

    def _read_first(self, key: Key, leaf: Leaf) -> None:
        """Make the variable of a place, or the constant of one that never changes."""
        put = self.log.put
        self.log.append_at(self._asked, key[0], key[1])
        if key in self.known:
            put(self._kept, key, const(self.known[key], kind_of(leaf.type)[0]))
            return
        name = f"{key[0]}[{key[1]}]"
        if key[0].endswith(CLOCK):
            own = var(name, INT, 0, AGE)
            late = add(self.dt, var(f"~rest:{name}", INT, 0, 1)) if self.parts else self.dt
            now = least(add(own, ite(self.begun, const(0), late)), AGE)
        else:
            own = now = var(name, *kind_of(leaf.type))
        for where, site in self._lost.get(key[0], ()):
            now = ite(where, self.unknown_of(leaf, site), now)
            put(self.written, key, True)
        put(self.vars, key, own)
        put(self.kinds, key, leaf)
        put(self._kept, key, now)

    def _assign(self, key: Key, where: T, t: T) -> None:
        """Set a place where the current instruction is reached and a truth holds; elsewhere it is kept."""
        self.log.put(self._kept, key, ite(and_(self.active, where), t, self._kept[key]))

    def havoc(self, leaf: Leaf) -> None:
        """Let all elements of a leaf be anything where the current instruction is reached.

        Those that nothing has asked for so far become unknown once something does.
        """
        path = leaf.path.upper()
        for index in self._asked.get(path, ()):
            self.poke(leaf, index, self.unknown_of(leaf))
        self.log.append_at(self._lost, path, (self.active, self.lowered.sites[self.site]))

    def lost_at(self, path: str) -> list[Lost]:
        """Return where all of a leaf has become unknown, by its path in capitals."""
        return self._lost.get(path, [])

    def poke(self, leaf: Leaf, index: int, t: T, guard: T = TRUE) -> None:
        """Set a place where the guard holds, to a value of its type."""
        key = leaf.path.upper(), index
        here = self.value_here(leaf, index)
        self.log.put(self.written, key, True)
        t = self._fitting(t, leaf, key)
        path = self.paths.path
        if path is not None:
            path.written[key] = ite(guard, t, here)
        else:
            self._assign(key, guard, t)

    @staticmethod
    def _fitting(t: T, leaf: Leaf, key: Key) -> T:
        kind = leaf.type
        if kind.is_bool:
            return truth_of(t)
        if kind.is_real or kind.is_double:
            return to_float(t, F32 if kind.is_real else F64)
        return least(t, AGE) if key[0].endswith(CLOCK) else wrap(whole_of(t), kind.wraps)

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
        """Return a subscript or bit number below `length`, or fault."""
        value: Any = self.integer(index)
        if not isinstance(value, TermSymbol) and not isinstance(length, TermSymbol):
            if not 0 <= value < length:
                raise PathFault
            return value
        t, most = term_of(value, INT), term_of(length, INT)
        if self.paths.decide(or_(lt(t, const(0)), le(most, t))):
            raise PathFault
        return self.symbol(_below(t, most.hi))

    def start_clock(self, since: Place) -> None:
        """Begin to measure the time in a hidden place."""
        self.put(since, 0)

    def elapsed(self, since: Place, unit_ns: int) -> Any:
        """Return the whole units of time since then; the rest stays."""
        age, unit = term_of(self.get(since), INT), const(unit_ns // 1_000_000)
        if unit.val == 1:
            self.put(since, 0)
            return self.symbol(age)
        rest = ite(eq(age, const(AGE)), self.unknown(INT, 0, unit.val - 1), rem(age, unit))
        self.put(since, self.symbol(rest))
        return self.symbol(div(age, unit))

    def unknown(self, kind: str, lo: int = 0, hi: int = 0) -> T:
        """Return a variable for what is not modeled; see `Paths.unknown`."""
        self.note_unknown()
        return self._unknown(kind, lo, hi)

    def note_unknown(self) -> None:
        """Take note that the current instruction is not modeled, or not all of it."""

    def _unknown(self, kind: str, lo: int, hi: int) -> T:
        found = self.paths.unknown((kind, lo, hi), lambda: var(f"?{next(self._unknowns)}", kind, lo, hi))
        self.log.put(self.havocs, found.val, self.lowered.sites[self.site])
        return found

    def unknown_of(self, leaf: Leaf, site: Site | None = None) -> T:
        """Return a new variable for a leaf, with the instruction to blame, by default the current one."""
        is_clock = leaf.path.upper().endswith(CLOCK)
        if site is None:
            self.note_unknown()
        found = self._unknown(*((INT, 0, AGE) if is_clock else kind_of(leaf.type)))
        if site is not None:
            self.log.put(self.havocs, found.val, site)
        return found

    def on_paths(self, run: Callable[[], Any]) -> T:
        """Run on every path; write what they write; return the truth of the result."""
        return merged(self.merge_paths(run), result_of)

    def merge_paths(self, run: Callable[[], Any]) -> list[Path]:
        """Run on every path and write what they write; return the paths."""
        paths = self.paths.walk(run)
        self.write_paths(paths)
        bad = faults_of(paths)
        if bad is not FALSE:  # the scan ends there; here it continues, which allows more
            self.log.add(self.faults, (self.site, and_(self.active, bad)))
        return paths

    def write_paths(self, paths: list[Path]) -> None:
        """Write what paths write."""
        for key in written_by(paths):
            old = self._kept[key]
            now = merged(paths, lambda path, key=key, old=old: path.written.get(key, old))  # type: ignore[misc]
            self._assign(key, TRUE, now)

    def here(self) -> T:
        """Return whether the current path is taken."""
        return and_(self.active, self.paths.here())


def _no_python(name: str, _inputs: object) -> Any:
    raise UnmodelledError(f"routine {name} in Python")


def _below(t: T, most: int) -> T:
    """Return a number that is below a limit, and not negative, with an interval that says so."""
    mask = (1 << max(0, most - 1).bit_length()) - 1
    return t if t.lo >= 0 and t.hi <= mask else bitop("band", t, const(mask))
