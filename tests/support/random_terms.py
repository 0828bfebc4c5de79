"""Random terms beside what Python computes for them, for tests of terms and of solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

from scanrack.ladder.prove.algebra import numbers
from scanrack.ladder.prove.algebra import terms as t
from scanrack.ladder.prove.algebra.meaning import INT
from scanrack.ladder.prove.algebra.terms import T


@dataclass
class Bench:
    """Terms made so far, each with the value Python gives it."""

    rng: Random
    whole: list[tuple[T, int]]
    truths: list[tuple[T, bool]]
    values: dict[str, Any]

    def any_whole(self) -> tuple[T, int]:
        if self.rng.random() < 0.2:
            number = self.rng.choice((0, 1, -1, 2, 3, 7, 255, -128, 32767, self.rng.randint(-70000, 70000)))
            return t.const(number), number
        return self.rng.choice(self.whole)

    def any_truth(self) -> tuple[T, bool]:
        if self.rng.random() < 0.1:
            truth = self.rng.random() < 0.5
            return t.const(truth), truth
        return self.rng.choice(self.truths)


def _quotient(a: int, b: int) -> int:
    return 0 if b == 0 else (-1 if (a < 0) != (b < 0) else 1) * (abs(a) // abs(b))


def _low(value: int, width: int) -> int:
    pattern = value % 2 ** abs(width)
    return pattern - 2**width if width > 0 and pattern >= 2 ** (width - 1) else pattern


OF_TWO: dict[Callable[[T, T], T], Callable[[int, int], int]] = {
    numbers.add: lambda a, b: a + b,
    numbers.sub: lambda a, b: a - b,
    numbers.mul: lambda a, b: a * b,
    numbers.div: _quotient,
    numbers.rem: lambda a, b: a - b * _quotient(a, b) if b else 0,
    lambda a, b: numbers.bitop("band", a, b): lambda a, b: a & b,
    lambda a, b: numbers.bitop("bor", a, b): lambda a, b: a | b,
    lambda a, b: numbers.bitop("bxor", a, b): lambda a, b: a ^ b,
}
TRUTHS_OF_TWO: dict[Callable[[T, T], T], Callable[[Any, Any], bool]] = {
    numbers.eq: lambda a, b: a == b,
    numbers.lt: lambda a, b: a < b,
    numbers.le: lambda a, b: a <= b,
}
LOGIC: dict[Callable[[T, T], T], Callable[[bool, bool], bool]] = {
    t.and_: lambda a, b: a and b,
    t.or_: lambda a, b: a or b,
    t.iff: lambda a, b: a == b,
}


def bench(seed: int, steps: int = 40) -> Bench:
    """Return a bench with terms of a few variables and `steps` random operations."""
    t.forget()
    rng = Random(seed)
    made = Bench(rng, [], [], {})
    for number, (lo, hi) in enumerate(((0, 100), (-128, 127), (0, 65535), (-(2**31), 2**31 - 1), (-3, 3))):
        value = rng.choice((lo, hi, rng.randint(lo, hi)))
        made.whole.append((t.var(f"n{number}", INT, lo, hi), value))
        made.values[f"n{number}"] = value
    for number in range(3):
        made.values[f"b{number}"] = rng.random() < 0.5
        made.truths.append((t.var(f"b{number}"), made.values[f"b{number}"]))
    for _ in range(steps):
        _step(made)
    return made


def _step(made: Bench) -> None:
    rng = made.rng
    kind = rng.randrange(9)
    (a, x), (b, y) = made.any_whole(), made.any_whole()
    (p, truth), (q, other) = made.any_truth(), made.any_truth()
    width = rng.choice((8, 16, 32, -8, -16))
    number = rng.randrange(abs(width))
    if kind <= 1:
        make, mean = rng.choice(list(OF_TWO.items()))
        if max(t.bits_of(a.lo, a.hi), t.bits_of(b.lo, b.hi)) <= 40:
            made.whole.append((make(a, b), mean(x, y)))
    elif kind == 2:
        make_truth, mean_truth = rng.choice(list(TRUTHS_OF_TWO.items()))
        made.truths.append((make_truth(a, b), mean_truth(x, y)))
    elif kind == 3:
        make, logic = rng.choice(list(LOGIC.items()))
        made.truths.append((make(p, q), logic(truth, other)))
    elif kind == 4:
        made.truths.append((t.not_(p), not truth))
        made.whole.append((numbers.b2i(p), int(truth)))
    elif kind == 5:
        made.whole.append((t.ite(p, a, b), x if truth else y))
        made.truths.append((t.ite(p, q, numbers.lt(a, b)), other if truth else x < y))
    elif kind == 6:
        made.whole.append((numbers.wrap(a, width), _low(x, width)))
        made.truths.append((numbers.bit(a, number), x // 2**number % 2 == 1))
    elif kind == 7:
        mask = 2**number
        word = numbers.setbit(numbers.wrap(a, width), number, p, width)
        low = _low(x, -abs(width))
        made.whole.append((word, _low(low | mask if truth else low & ~mask, width)))
    else:
        made.whole.append((numbers.shr(a, number), math.floor(x / 2**number)))
        made.whole.append((numbers.clip(a, -100, 1000), min(1000, max(-100, x))))
        made.whole.append((numbers.inv(b), -1 - y))
