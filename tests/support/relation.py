"""The relation of a program against its interpreter: equal values after scans from random memory.

A value that depends on what is not modeled is not compared. Whether it does is computed in each scan:
`ite(Go, ?3, Count)` is Count where Go is off.
"""

from __future__ import annotations

import math
import struct
from collections import Counter

from scanrack.ladder import LadderFault
from scanrack.ladder.instructions.slc.processor import MINOR_AT_END
from scanrack.ladder.prove.algebra.meaning import BOOL, meaning
from scanrack.ladder.prove.algebra.terms import FALSE, TRUE, forget, or_, reach
from scanrack.ladder.prove.relation.noting import NotingMachine
from scanrack.ladder.prove.relation.places import AGE, CLOCK

SCAN_MS = (1, 2, 10, 37, 100)


class Relation:
    """The terms of one scan of a program, to be computed again and again."""

    def __init__(self, program, lengths=3, *, turned=False):
        """Make the terms of a scan; `turned` adds a turn of the key behind it, which prescans."""
        self.program, self.turned = program, turned
        self.engine = None
        forget()
        self.lengths = lengths  # LEN of each CONTROL
        layout = program.build().layout
        known = {(leaf.path.upper(), at): lengths for leaf in _lengths(layout) for at in range(leaf.size)}
        self.machine = self._scanned(known)
        changed = known.keys() & self.machine.written.keys()
        if changed:  # a LEN that the program writes is no constant, see `ProgramSystem`
            self.machine = self._scanned({key: known[key] for key in known if key not in changed})
        self._state = self.machine.state
        if turned:
            self.machine.turn_key(TRUE)
            self._state = {key: self.machine.before_next(key) for key in self.machine.vars}
        fault = FALSE
        for _, condition in self.machine.faults:
            fault = or_(fault, condition)
        roots = [*self._state.values(), fault, self.machine.deep]
        self._terms = KnownValues(roots, self.machine.unmodeled)

    def _scanned(self, known):
        machine = NotingMachine(self.program.build(), (1, 1000), known)
        machine.scan_terms()
        return machine

    def values(self, memory, now_ms, dt):
        """Return the values of all variables."""
        found = {"~dt": dt}
        for (path, index), variable in self.machine.vars.items():
            raw = memory.read(self.machine.leaves[path, index], index)
            if path.endswith(CLOCK):
                raw = min(AGE, max(0, now_ms - raw // 1_000_000))
            found[variable.val] = raw
        return found

    def differences(self, rng, scans, count=None):
        """Run scans from random memory; return what differs, as texts."""
        count = Counter() if count is None else count
        found = []
        for _ in range(scans):
            found += self._scan(rng, count)
        return found

    def _start(self):
        self.engine = self.program.interpret()
        try:
            self.engine.step(10)
        except LadderFault:
            self.engine = None
        self.now = 0
        for leaf in _lengths(self.program.build().layout):
            for at in range(leaf.size):
                if self.engine is not None:
                    self.engine.memory.write(leaf, at, self.lengths)

    def _scan(self, rng, count):
        if self.engine is None:
            self._start()
        if self.engine is None:
            return []
        engine, machine = self.engine, self.machine
        randomize(engine.memory, rng)
        dt = rng.choice(SCAN_MS)
        *got, fault, deep = self._terms(self.values(engine.memory, self.now, dt))
        self.now += dt
        try:
            engine.step(dt)
            if self.turned:
                engine.interpreter.prescan()
        except LadderFault as error:
            count["scans that fault"] += 1
            self.engine = None
            faults = fault or deep or machine.cut or error.code == MINOR_AT_END
            return [] if faults else [f"the interpreter faults: {error}"]
        if fault is True and not machine.cut and not deep:
            return ["the relation faults"]
        count["scans"] += 1
        if deep:
            return []
        return self._compare(engine.memory, got, dt, count)

    def _compare(self, memory, got, dt, count):
        wanted, found = self.values(memory, self.now, dt), []
        by_key = dict(zip(self._state, got, strict=True))
        for key, variable in self.machine.vars.items():
            value = by_key[key]
            count["unknown values" if value is UNKNOWN else "values"] += 1
            if value is UNKNOWN or (key[0] == "S" and key[1] in PROCESSOR_WORDS):
                continue
            want = wanted[variable.val]
            if not same(want, value):
                found.append(f"{key[0]}[{key[1]}]: interpreter {want!r}, relation {value!r}")
        return found


UNKNOWN = object()
"""The value of a term that depends on what is not modeled; it is true, as a condition that may hold."""


class KnownValues:
    """Computes terms again and again; what depends on some of their variables is `UNKNOWN`.

    Args:
        roots: the terms.
        unknown: names of these variables.
    """

    def __init__(self, roots, unknown):
        order = reach(roots)
        slots = {t.id: slot for slot, t in enumerate(order)}
        self._found = [t.val for t in order]
        self._given = [
            (slot, UNKNOWN if t.val in unknown else None, t.val, False if t.kind == BOOL else 0)
            for slot, t in enumerate(order)
            if t.op == "var"
        ]
        self._steps = [
            (slot, t.op, meaning(t.op, t.kind, t.val), [slots[each.id] for each in t.args])
            for slot, t in enumerate(order)
            if t.op not in ("const", "var")
        ]
        self._roots = [slots[t.id] for t in roots]

    def __call__(self, values):
        """Compute the roots."""
        found = self._found
        for slot, unknown, name, default in self._given:
            found[slot] = unknown or values.get(name, default)
        for slot, op, function, operands in self._steps:
            given = [found[each] for each in operands]
            found[slot] = _of_unknown(op, given) if UNKNOWN in given else function(*given)
        return [found[slot] for slot in self._roots]


def _of_unknown(op, given):
    """Return the value of an operation of which some operands are unknown."""
    if op == "ite":
        condition, held, other = given
        if condition is not UNKNOWN:
            return held if condition else other
        return held if held is not UNKNOWN and other is not UNKNOWN and same(held, other) else UNKNOWN
    return False if op == "and" and any(each is False for each in given) else UNKNOWN


def same(a, b):
    """Whether two values are equal; NaN equals NaN, and 0.0 is not -0.0."""
    if isinstance(a, float) or isinstance(b, float):
        return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (a != a and b != b)
    return a == b


def _lengths(layout):
    """Return LEN of each CONTROL."""
    ends = {leaf.path.upper() for leaf in layout.leaves.values()}
    return [
        leaf
        for leaf in layout.leaves.values()
        if leaf.path.upper().endswith(".LEN") and f"{leaf.path.upper()[:-4]}.POS" in ends
    ]


PROCESSOR_WORDS = (1, 4, *range(37, 43))
"""Words of an SLC's status file that its processor writes beside the rungs."""

FLOATS = (0.0, -0.0, 1.5, -2.5, 100.0, 3.4e38, 1e-40, float("inf"), float("-inf"), float("nan"))


def randomize(memory, rng):
    """Set most values of tags to random ones."""
    lengths = _lengths(memory.layout)
    for leaf in memory.layout.leaves.values():
        if leaf.path.startswith("S:") or "~" in leaf.path or not memory.has(leaf) or leaf in lengths:
            continue
        for index in range(min(leaf.size, 64)):
            if rng.random() < 0.7:
                memory.write(leaf, index, random_value(leaf, rng))


def random_value(leaf, rng):
    """Return a random value of a leaf's type, often a small one or a limit."""
    kind = leaf.type
    if kind.is_bool:
        return rng.random() < 0.6
    if kind.is_real or kind.is_double:
        value = rng.choice((*FLOATS, rng.uniform(-1e6, 1e6), rng.uniform(-3, 3)))
        return struct.unpack("<f", struct.pack("<f", value))[0] if kind.is_real else value
    lo, hi = kind.lowest, kind.highest
    value = rng.choice((0, 1, 2, 3, 5, 7, 100, 100, 1, -1, lo, hi, rng.randint(lo, hi), rng.randint(-5, 12)))
    if leaf.path.upper().endswith((".PRE", ".ACC", ".LEN", ".POS")) and rng.random() < 0.9:
        value = abs(value) % (1000 if leaf.path.upper().endswith(("PRE", "ACC")) else 9)
    return max(lo, min(hi, value))
