"""Operations of expressions on terms, by their names in programs."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from ..algebra.meaning import BOOL
from ..algebra.numbers import add, bitop, div, eq, fop, inv, lt, mul, rem, sub, to_float, to_int
from ..algebra.terms import T, and_, const, iff, ite, mk, not_, or_

FAR_AWAY = 2.0**62
"""Floats of this size and above have no exact term as a whole number."""


def is_nan(t: T) -> T:
    """Return whether a float is NaN."""
    return mk("fnan", (t,), BOOL)


def is_finite(t: T) -> T:
    """Return whether a float is neither infinite nor NaN."""
    return mk("ffin", (t,), BOOL)


def is_large(t: T) -> T:
    """Return whether a float has no exact term as a whole number; NaN counts as large."""
    return not_(and_(lt(t, const(FAR_AWAY, t.kind)), lt(const(-FAR_AWAY, t.kind), t)))


def absolute(t: T) -> T:
    """Return the absolute value of a whole number."""
    return t if t.lo >= 0 else ite(lt(t, const(0)), sub(const(0), t), t)


DIVISIONS = {"/": div, "MOD": rem}

WHOLE: dict[str, Callable[..., T]] = {
    "+": add,
    "-": sub,
    "*": mul,
    "AND": lambda a, b: bitop("band", a, b),
    "OR": lambda a, b: bitop("bor", a, b),
    "XOR": lambda a, b: bitop("bxor", a, b),
    "NOT": inv,
    "NEG": lambda a: sub(const(0), a),
    "ABS": absolute,
    "TRN": lambda a: a,
}


def remainder(a: T, b: T) -> T:
    """Return the remainder with the sign of a, even if the remainder is 0."""
    size, divisor, zero = fop("fabs", a), fop("fabs", b), const(0.0, a.kind)
    near = fop("frem", size, divisor)
    remaining = ite(lt(near, zero), fop("fadd", near, divisor), near)
    signed = ite(lt(a, zero), fop("fneg", remaining), remaining)
    return ite(and_(eq(a, zero), eq(remaining, zero)), a, signed)  # `a` may be -0.0, which is not below 0


def truncated(t: T) -> T:
    """Return a float without its fraction; 0 for infinity and NaN."""
    whole = to_float(to_int(t, "rtz"), t.kind)
    large = is_large(t)
    return ite(is_finite(t), ite(large, t, whole), const(0.0, t.kind))


REAL: dict[str, Callable[..., T]] = {
    "+": partial(fop, "fadd"),
    "-": partial(fop, "fsub"),
    "*": partial(fop, "fmul"),
    "/": partial(fop, "fdiv"),
    "NEG": partial(fop, "fneg"),
    "ABS": partial(fop, "fabs"),
    "MOD": remainder,
    "SQR": lambda a: fop("fsqrt", fop("fabs", a)),
    "TRN": truncated,
}

FACTORS = {"DEG": 180 / math.pi, "RAD": math.pi / 180}

UNKNOWN = frozenset(("SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG", "**"))
"""Functions of floats that are not modeled, so the result can be any number."""

TRUTH: dict[str, Callable[..., T]] = {
    "AND": and_,
    "OR": or_,
    "XOR": lambda a, b: not_(iff(a, b)),
    "NOT": not_,
    "=": iff,
    "<>": lambda a, b: not_(iff(a, b)),
    "<": lambda a, b: and_(not_(a), b),
    "<=": lambda a, b: or_(not_(a), b),
    ">": lambda a, b: and_(a, not_(b)),
    ">=": lambda a, b: or_(a, not_(b)),
}
