"""The operations of terms on Python numbers, for constant folding and evaluation.

Booleans are `bool`, whole numbers are unbounded `int`, floats are `float`. A single-precision float is a
`float` that is rounded after each operation.

| operation | meaning |
|---|---|
| not, and, iff, ite | on Booleans; the last two operands of `ite` can be of any kind |
| add, sub, mul, div, rem | exact; `div` truncates toward zero; `div` and `rem` are 0 for a divisor of 0 |
| band, bor, bxor | on two's complement patterns of unlimited width |
| shr, wrap, bit, setbit, b2i | shift right, keep low bits, read a bit, write a bit, Boolean to 0 or 1 |
| eq, lt | on whole numbers |
| fadd, fsub, fmul, fdiv, fneg, fabs | on floats, rounded half to even |
| fsqrt, frem | root of a float >= 0; distance to the nearest multiple, as IEEE 754 defines it |
| feq, flt, fle, fnan, ffin | on floats, as IEEE 754 defines them; `ffin`: neither infinite nor NaN |
| fsame | on floats: the same value; -0.0 differs from 0.0, and NaN is the same as NaN |
| i2f, f2f, f2i | conversions; `f2i` is 0 for infinity, NaN, and floats of size 2**62 and above |
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from ...model.arithmetic import finite, quotient, real, real_quotient, remainder, wrap

BOOL, INT, F32, F64 = "b", "i", "f32", "f64"
"""Kinds of terms: Boolean, whole number, single and double float."""

FAR = 1 << 62
"""Floats of this size and above convert to 0."""


def div(a: int, b: int) -> int:
    """Divide, truncating toward zero; return 0 for a divisor of 0."""
    return quotient(a, b) if b else 0


def rem(a: int, b: int) -> int:
    """Return the remainder with the sign of a; 0 for a divisor of 0."""
    return remainder(a, b) if b else 0


def to_whole(value: float, rounding: str) -> int:
    """Round a float to a whole number: half to even (`rne`) or toward zero (`rtz`)."""
    if not finite(value) or abs(value) >= FAR:
        return 0
    return round(value) if rounding == "rne" else math.trunc(value)


def to_nearest(a: float, b: float) -> float:
    """Return the distance of a from the nearest multiple of b; NaN if it is undefined.

    >>> to_nearest(5.0, 3.0), to_nearest(7.0, 3.0)
    (-1.0, 1.0)
    """
    if not finite(a) or b != b or b == 0:
        return math.nan
    return math.remainder(a, b)


def to_float(value: float, kind: str) -> float:
    """Round a number to the nearest float of a kind; a whole number that is too large becomes infinite."""
    try:
        double = float(value)
    except OverflowError:
        double = math.inf if value > 0 else -math.inf
    return real(double) if kind == F32 else double


def write_bit(word: int, truth: bool, number: int, width: int) -> int:
    """Return a word of |width| bits with bit `number` set to a Boolean."""
    return wrap(word & ~(1 << number) | truth << number, width)


def same_float(a: float, b: float) -> bool:
    """Return whether two floats are the same value, including NaN and the sign of zero.

    >>> same_float(0.0, -0.0), same_float(math.nan, math.nan)
    (False, True)
    """
    if a != a or b != b:
        return a != a and b != b
    return a == b and math.copysign(1.0, a) == math.copysign(1.0, b)


PLAIN: dict[str, Callable[..., Any]] = {
    "not": operator.not_,
    "and": lambda a, b: a and b,
    "iff": operator.eq,
    "ite": lambda c, a, b: a if c else b,
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": div,
    "rem": rem,
    "band": operator.and_,
    "bor": operator.or_,
    "bxor": operator.xor,
    "b2i": int,
    "eq": operator.eq,
    "lt": operator.lt,
    "feq": operator.eq,
    "fsame": same_float,
    "flt": operator.lt,
    "fle": operator.le,
    "fnan": math.isnan,
    "ffin": math.isfinite,
}
"""Operations that depend only on their operands."""

FLOATS: dict[str, Callable[..., float]] = {
    "fadd": operator.add,
    "fsub": operator.sub,
    "fmul": operator.mul,
    "fdiv": real_quotient,
    "fneg": operator.neg,
    "fabs": abs,
    "fsqrt": math.sqrt,
    "frem": to_nearest,
}
"""Operations that round the result to the kind of the term."""

SETTLED: dict[str, Callable[[Any, Any], Any]] = {
    "shr": operator.rshift,
    "wrap": wrap,
    "bit": lambda word, number: bool(word >> number & 1),
    "f2i": to_whole,
}
"""Operations with a setting: a shift count, a width, a bit number, or a rounding mode."""


def meaning(op: str, kind: str, setting: Any) -> Callable[..., Any]:
    """Return the function that computes an operation from its operands.

    >>> meaning("wrap", INT, 8)(200), meaning("fdiv", F32, None)(1.0, 3.0)
    (-56, 0.3333333432674408)
    """
    if op in PLAIN:
        return PLAIN[op]
    if op in SETTLED:
        settled = SETTLED[op]
        return lambda a: settled(a, setting)
    if op in FLOATS:
        exact = FLOATS[op]
        return exact if kind == F64 else lambda *operands: real(exact(*operands))
    if op in ("i2f", "f2f"):
        return lambda a: to_float(a, kind)
    if op == "setbit":
        number, width = setting
        return lambda word, truth: write_bit(word, truth, number, width)
    raise ValueError(f"no operation {op!r}")
