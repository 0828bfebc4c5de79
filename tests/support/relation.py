"""The relation of a program against its interpreter: equal values after scans from random memory."""

from __future__ import annotations

import struct
from collections import Counter

from scanrack.ladder import LadderFault
from scanrack.ladder.instructions.slc.processor import MINOR_AT_END
from scanrack.ladder.prove.algebra.evaluation import Evaluator
from scanrack.ladder.prove.algebra.terms import FALSE, T, forget, or_, reach
from scanrack.ladder.prove.relation.machine import ScanMachine
from scanrack.ladder.prove.relation.places import AGE, CLOCK

SCAN_MS = (1, 2, 10, 37, 100)


class Relation:
    """The terms of one scan of a program, to be computed again and again."""

    def __init__(self, program, lengths=3):
        self.program = program
        self.engine = None
        forget()
        self.lengths = lengths  # LEN of each CONTROL, which no scan changes
        layout = program.build().layout
        known = {(leaf.path.upper(), at): lengths for leaf in _lengths(layout) for at in range(leaf.size)}
        self.machine = ScanMachine(program.build(), (1, 1000), known)
        self.machine.scan_terms()
        fault = FALSE
        for _, condition in self.machine.faults:
            fault = or_(fault, condition)
        roots = [*self.machine.state.values(), fault, self.machine.deep]
        self._terms = Evaluator(roots)
        unknown = _that_need(roots, self.machine.havocs)
        self.known = [t.id not in unknown for t in roots]

    def values(self, memory, now_ms, dt):
        """Return the values of all variables."""
        found = {"~dt": dt}
        for (path, index), variable in self.machine.vars.items():
            raw = memory.read(self.machine.kinds[path, index], index)
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
        randomise(engine.memory, rng)
        dt = rng.choice(SCAN_MS)
        *got, fault, deep = self._terms(self.values(engine.memory, self.now, dt))
        self.now += dt
        try:
            engine.step(dt)
        except LadderFault as error:
            count["scans that fault"] += 1
            self.engine = None
            faults = fault or deep or not self.known[-2] or machine.cut or error.code == MINOR_AT_END
            return [] if faults else [f"the interpreter faults: {error}"]
        if fault and self.known[-2] and not machine.cut and not deep:
            return ["the relation faults"]
        count["scans"] += 1
        if deep or not self.known[-1]:
            return []
        return self._compare(engine.memory, got, dt, count)

    def _compare(self, memory, got, dt, count):
        wanted, found = self.values(memory, self.now, dt), []
        for (key, variable), value, known in zip(
            self.machine.vars.items(), self._in_order(got), self._known_in_order, strict=True
        ):
            count["values" if known else "unknown values"] += 1
            if key[0] == "S" and key[1] in PROCESSOR_WORDS:
                continue
            want = wanted[variable.val]
            if known and not same(want, value):
                found.append(f"{key[0]}[{key[1]}]: interpreter {want!r}, relation {value!r}")
        return found

    def _in_order(self, got):
        by_key = dict(zip(self.machine.state, got, strict=True))
        return [by_key[key] for key in self.machine.vars]

    @property
    def _known_in_order(self):
        by_key = dict(zip(self.machine.state, self.known[:-2], strict=True))
        return [by_key[key] for key in self.machine.vars]


def _that_need(roots: list[T], names) -> set[int]:
    """Return the ids of the terms that depend on a variable."""
    found: set[int] = set()
    for t in reach(roots):
        if (t.op == "var" and t.val in names) or any(each.id in found for each in t.args):
            found.add(t.id)
    return found


def same(a, b):
    """Whether two values are equal; NaN equals NaN."""
    if isinstance(a, float) or isinstance(b, float):
        return a == b or (a != a and b != b)
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

FLOATS = (0.0, 1.5, -2.5, 100.0, 3.4e38, 1e-40, float("inf"), float("-inf"), float("nan"))


def randomise(memory, rng):
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
