"""Many runs of a relation at once: each value is an array with a place for each run.

Random scans only suggest: they need not be many, but broad. Truths and whole numbers of up to 62 bits are
arrays of numpy; wider ones are Python's numbers in arrays of objects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Any

import numpy as np

from .meaning import BOOL, F32, FAR, INT, meaning
from .system import System
from .terms import T, reach

Array = np.ndarray[Any, np.dtype[Any]]

LANES = 256
"""Runs at once."""

_NEAR = np.array([0, 1, 2, 3, 5, 10, 100, 1000])
"""Numbers that random values often are."""


class BatchEvaluator:
    """Computes terms for many values of their variables at once.

    Args:
        roots: the terms.

    Attributes:
        variables: those that decide them.
    """

    def __init__(self, roots: Sequence[T], lanes: int = LANES) -> None:
        order = reach(roots)
        slots = {t.id: number for number, t in enumerate(order)}
        self.variables = [t for t in order if t.op == "var"]
        self._inputs = [(slot, t) for slot, t in enumerate(order) if t.op == "var"]
        self._found: list[Any] = [filled(t, t.val, lanes) if t.op == "const" else None for t in order]
        self._steps = [
            (slot, _function(t), [slots[a.id] for a in t.args])
            for slot, t in enumerate(order)
            if t.op not in ("const", "var")
        ]
        self._roots = [slots[t.id] for t in roots]

    def __call__(self, values: Mapping[str, Array]) -> list[Array]:
        """Compute the roots; `values` has an array for each variable."""
        found = self._found
        for slot, t in self._inputs:
            found[slot] = values[t.val]
        with np.errstate(all="ignore"):
            for slot, function, operands in self._steps:
                found[slot] = function(*[found[each] for each in operands])
        return [found[slot] for slot in self._roots]


def filled(t: T, value: Any, lanes: int = LANES) -> Array:
    """Return the array of a term that has the same value in all runs."""
    return np.full(lanes, value, dtype=_dtype(t))


def _is_wide(t: T) -> bool:
    return t.kind == INT and not -FAR < t.lo <= t.hi < FAR


def _dtype(t: T) -> Any:
    if t.kind == INT:
        return object if _is_wide(t) else np.int64
    return np.bool_ if t.kind == BOOL else np.float32 if t.kind == F32 else np.float64


def _function(t: T) -> Callable[..., Array]:
    if _is_wide(t) or any(map(_is_wide, t.args)):
        return _each(t)
    if t.op in _PLAIN:
        return _PLAIN[t.op]
    if t.op == "bit":
        number = min(t.val, 62)
        return lambda a: (a >> number & 1).astype(np.bool_)
    if t.op == "shr":
        return lambda a: a >> min(t.val, 62)
    if t.op == "wrap":
        return lambda a: _wrapped(a, t.val)
    if t.op == "setbit":
        number, bits = t.val
        return lambda a, truth: _wrapped(a & ~(1 << number) | truth.astype(np.int64) << number, bits)
    if t.op in ("f2f", "i2f"):
        kind = _dtype(t)
        return lambda a: a.astype(np.float64).astype(kind)
    return _each(t)


def _wrapped(a: Array, bits: int) -> Array:
    """Keep low bits, of at most 62, as `arithmetic.wrap` does."""
    if bits < 0:
        return a & (1 << -bits) - 1
    half = 1 << bits - 1
    return (a + half & half + half - 1) - half


def _each(t: T) -> Callable[..., Array]:
    """Compute run by run, as `meaning` says."""
    function, kind = meaning(t.op, t.kind, t.val), _dtype(t)

    def computed(*operands: Array) -> Array:
        lists = [each.tolist() for each in operands]
        return np.array([function(*each) for each in zip(*lists, strict=True)], dtype=kind)

    return computed


_PLAIN: dict[str, Callable[..., Array]] = {
    "not": np.logical_not,
    "and": np.logical_and,
    "iff": np.equal,
    "ite": np.where,
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "band": np.bitwise_and,
    "bor": np.bitwise_or,
    "bxor": np.bitwise_xor,
    "b2i": lambda a: a.astype(np.int64),
    "eq": np.equal,
    "lt": np.less,
    "fadd": np.add,
    "fsub": np.subtract,
    "fmul": np.multiply,
    "fneg": np.negative,
    "fabs": np.abs,
    "feq": np.equal,
    "flt": np.less,
    "fle": np.less_equal,
    "fnan": np.isnan,
    "ffin": np.isfinite,
}


# --- runs


class Runs:
    """Random runs of a system from power-up, side by side.

    Args:
        system: what runs.
        cone: the variables that count.
        roots: what is watched.
        seed: of the random values.
    """

    def __init__(self, system: System, cone: Mapping[str, T], roots: Sequence[T], seed: int = 0) -> None:
        self._system, self._cone, self._rng = system, cone, Random(seed)
        self._states = [name for name in cone if name in system.next]
        self._free = [name for name in cone if system.role(name) == "free"]
        self._roots = roots
        every = [*[system.next[name] for name in self._states], *roots, system.contract]
        self._terms = BatchEvaluator(every)
        self._chances = {name: self._rare_and_often() for name in self._free}
        self.restart()

    def restart(self) -> None:
        """Power up all runs."""
        initial = self._system.initial
        self._values = {name: filled(v, initial[name]) for name, v in self._cone.items() if name in initial}
        self._first = True

    def scan(self) -> tuple[list[Array], Array]:
        """Do a scan; return what is watched, and in which runs the scan keeps the contract: others stay."""
        values = self._values | self._chosen()
        *got, kept = self._terms(values)
        after = dict(zip(self._states, got, strict=False))
        if kept.all():
            self._values = values | after
        else:
            before = self._values
            changed = values | after
            self._values = {
                name: np.where(kept, each, before[name]) if name in before else each
                for name, each in changed.items()
            }
        self._first = False
        return got[len(self._states) :], kept

    def _chosen(self) -> dict[str, Array]:
        """Return values of the free variables: some new ones in some runs."""
        found = {}
        for name in self._free:
            if self._first and name in self._system.late:
                continue
            v, before = self._cone[name], self._values.get(name)
            new = self._any(name, v, before)
            found[name] = new if before is None else np.where(self._changing(), new, before)
        return found

    def _rare_and_often(self) -> tuple[int, int]:
        """Return the runs in which a bit is rarely on, and those in which it is often."""
        one, other = self._rng.getrandbits(LANES), self._rng.getrandbits(LANES)
        return one & other, one & ~other

    def _changing(self) -> Array:
        """Return truths that hold in every fourth run."""
        return self._bits(self._rng.getrandbits(LANES) & self._rng.getrandbits(LANES))

    def _bits(self, pattern: int) -> Array:
        packed = np.frombuffer(pattern.to_bytes(LANES // 8, "big"), dtype=np.uint8)
        return np.unpackbits(packed).view(np.bool_)

    def _any(self, name: str, v: T, before: Array | None) -> Array:
        if v.kind == BOOL:
            return self._bits(self._truths(name))
        if v.kind != INT:
            return np.array([self._real() for _ in range(LANES)], _dtype(v))
        if _is_wide(v):
            return np.array([self._rng.randint(v.lo, v.hi) for _ in range(LANES)], object)
        return self._numbers(name, v, before)

    def _truths(self, name: str) -> int:
        """Return truths that are rare in some runs and frequent in others."""
        draw, (rare, often) = self._rng.getrandbits, self._chances[name]
        one, few = draw(LANES), draw(LANES) & draw(LANES)
        return one & ~rare & ~often | one & few & rare | (one | ~few) & often

    def _real(self) -> float:
        return self._rng.choice((0.0, 1.0, self._rng.uniform(-100, 100)))

    def _numbers(self, name: str, v: T, before: Array | None) -> Array:
        """Return small numbers mostly, sometimes any, or such as differ from those before in a bit."""
        likely = self._system.likely.get(name)
        if likely is not None:
            words = np.array([word if word <= v.hi else word - 0x10000 for word in likely])
            found = words[self._draws() % len(words)]
        else:
            found = np.clip(_NEAR[self._draws() % len(_NEAR)], v.lo, v.hi)
        raw = np.frombuffer(self._rng.randbytes(8 * LANES), np.uint64)
        anything = (raw % np.uint64(v.hi - v.lo + 1)).astype(np.int64) + v.lo
        found = np.where(self._draws() < 50, anything, found)
        if before is not None:
            turned = before ^ (1 << self._draws() % max(1, (v.hi - v.lo).bit_length()))
            fits = (self._draws() < 80) & (v.lo <= turned) & (turned <= v.hi)
            found = np.where(fits, turned, found)
        return found

    def _draws(self) -> Array:
        """Return numbers from 0 to 255."""
        return np.frombuffer(self._rng.randbytes(LANES), np.uint8).astype(np.int64)
