"""Parallel random runs of a system. They only suggest results, so variety matters more than number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random

import numpy as np

from ..algebra.batch import LANES, Array, BatchEvaluator, dtype_of, filled, is_wide
from ..algebra.meaning import BOOL, INT
from ..algebra.terms import T
from ..system import TURNED, System

_NEAR = np.array([0, 1, 2, 3, 5, 10, 100, 1000])
"""Numbers that are often chosen as random values."""


class Runs:
    """Parallel random runs of a system from power-up.

    Args:
        system: the system that runs.
        cone: the relevant variables.
        roots: the terms to observe.
        seed: seed of the random values.
        lanes: number of runs, a multiple of 8.
    """

    def __init__(
        self, system: System, cone: Mapping[str, T], roots: Sequence[T], seed: int = 0, lanes: int = LANES
    ) -> None:
        self._system, self._cone, self._rng, self._lanes = system, cone, Random(seed), lanes
        self._states = [name for name in cone if name in system.next]
        self._free = [name for name in cone if system.role(name) == "free"]
        self._roots = roots
        every = [*[system.next[name] for name in self._states], *roots, system.contract]
        self._terms = BatchEvaluator(every, lanes)
        self._chances = {name: self._rare_and_often() for name in self._free}
        self.restart()

    @property
    def size(self) -> int:
        """Number of terms that a scan computes."""
        return len(self._terms)

    def restart(self) -> None:
        """Restart all runs from power-up."""
        initial = self._system.initial
        self._values = {
            name: filled(variable, initial[name], self._lanes)
            for name, variable in self._cone.items()
            if name in initial
        }
        self._first = True

    def scan(self) -> tuple[list[Array], Array]:
        """Run a scan; return the roots' values, and a mask of the runs that kept the contract.

        The other runs keep their old state.
        """
        values = self._values | self._chosen()
        *results, keeps_contract = self._terms(values)
        new_states = dict(zip(self._states, results, strict=False))
        if keeps_contract.all():
            self._values = values | new_states
        else:
            old_values = self._values
            changed = values | new_states
            self._values = {
                name: np.where(keeps_contract, lanes, old_values[name]) if name in old_values else lanes
                for name, lanes in changed.items()
            }
        self._first = False
        return results[len(self._states) :], keeps_contract

    def _chosen(self) -> dict[str, Array]:
        """Return values of the free variables; some variables change in some runs."""
        chosen = {}
        for name in self._free:
            if self._first and name in self._system.late:
                continue
            variable, previous = self._cone[name], self._values.get(name)
            new = self._random_values(name, variable, previous)
            if previous is None or name == TURNED:
                chosen[name] = new
            else:
                chosen[name] = np.where(self._changing(), new, previous)
        return chosen

    def _rare_and_often(self) -> tuple[int, int]:
        """Return the runs in which a bit is rarely on, and the runs in which it is often on."""
        first, second = self._rng.getrandbits(self._lanes), self._rng.getrandbits(self._lanes)
        return first & second, first & ~second

    def _changing(self) -> Array:
        """Return random Booleans that are true in a quarter of the runs."""
        return self._bits(self._rng.getrandbits(self._lanes) & self._rng.getrandbits(self._lanes))

    def _bits(self, pattern: int) -> Array:
        """Return the bits of a number as Booleans, one for each run."""
        packed = np.frombuffer(pattern.to_bytes(self._lanes // 8, "big"), dtype=np.uint8)
        return np.unpackbits(packed).view(np.bool_)

    def _random_values(self, name: str, v: T, previous: Array | None) -> Array:
        """Return a random value of a variable for each run."""
        if v.kind == BOOL:
            return self._bits(self._truths(name))
        if v.kind != INT:
            return np.array([self._real() for _ in range(self._lanes)], dtype_of(v))
        if is_wide(v):
            low = max(v.lo, min(-(1 << 63), v.hi + 1 - (1 << 64)))  # 64 random bits are enough
            return self._raw().astype(object) % (v.hi - low + 1) + low
        return self._numbers(name, v, previous)

    def _truths(self, name: str) -> int:
        """Return random Booleans that are rarely true in some runs and often in others."""
        rare, often = self._chances[name]

        def draw() -> int:
            return self._rng.getrandbits(self._lanes)

        half, few = draw(), draw() & draw()
        if name == TURNED:
            return few & draw() & draw() & draw() & rare
        return half & ~rare & ~often | half & few & rare | (half | ~few) & often

    def _real(self) -> float:
        return self._rng.choice((0.0, 1.0, self._rng.uniform(-100, 100)))

    def _numbers(self, name: str, v: T, previous: Array | None) -> Array:
        """Return random numbers: mostly small, sometimes arbitrary, or the last one with one bit inverted."""
        likely = self._system.likely.get(name)
        if likely is not None:
            words = np.array([word if word <= v.hi else word - 0x10000 for word in likely])  # signed
            numbers = words[self._draws() % len(words)]
        else:
            numbers = np.clip(_NEAR[self._draws() % len(_NEAR)], v.lo, v.hi)
        anything = (self._raw() % np.uint64(v.hi - v.lo + 1)).astype(np.int64) + v.lo
        numbers = np.where(self._draws() < 50, anything, numbers)  # in a fifth of the runs
        if previous is not None:
            inverted = previous ^ (1 << self._draws() % max(1, (v.hi - v.lo).bit_length()))
            is_inverted = (self._draws() < 80) & (v.lo <= inverted) & (inverted <= v.hi)
            numbers = np.where(is_inverted, inverted, numbers)  # in up to a third of the runs
        return numbers

    def _raw(self) -> Array:
        """Return random numbers of 64 bits."""
        return np.frombuffer(self._rng.randbytes(8 * self._lanes), np.uint64)

    def _draws(self) -> Array:
        """Return random numbers from 0 to 255."""
        return np.frombuffer(self._rng.randbytes(self._lanes), np.uint8).astype(np.int64)
