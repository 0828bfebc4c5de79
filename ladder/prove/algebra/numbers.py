"""Operations on whole numbers and floats, simplified using intervals and constants."""

from __future__ import annotations

from typing import Any

from .meaning import BOOL, FAR, INT, meaning
from .meaning import div as _quotient
from .terms import FALSE, TRUE, T, bits_of, const, iff, interval_of, ite, memo, mk, not_

# --- whole numbers


def _folded(op: str, *operands: T, val: Any = None) -> T | None:
    """Return the constant result of an operation on constant operands."""
    if any(operand.op != "const" for operand in operands):
        return None
    return const(meaning(op, INT, val)(*[operand.val for operand in operands]))


def add(a: T, b: T) -> T:
    """Return the sum."""
    if a.op == "const":
        a, b = b, a
    if b.op == "const":
        if b.val == 0:
            return a
        if a.op == "add" and a.args[1].op == "const":
            return add(a.args[0], const(a.args[1].val + b.val))
    return mk("add", (a, b), INT, lo=a.lo + b.lo, hi=a.hi + b.hi)


def sub(a: T, b: T) -> T:
    """Return the difference."""
    if b.op == "const":
        return add(a, const(-b.val))
    if a is b:
        return const(0)
    return mk("sub", (a, b), INT, lo=a.lo - b.hi, hi=a.hi - b.lo)


def mul(a: T, b: T) -> T:
    """Return the product."""
    if a.op == "const":
        a, b = b, a
    if b.op == "const" and b.val == 1:
        return a
    ends = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    return mk("mul", (a, b), INT, lo=min(ends), hi=max(ends))


def div(a: T, b: T) -> T:
    """Return the quotient, rounded toward zero; 0 for a divisor of 0."""
    folded = _folded("div", a, b)
    if folded is not None:
        return folded
    if b.lo > 0:  # the smallest divisor gives the quotient farthest from 0
        lo = _quotient(a.lo, b.lo if a.lo < 0 else b.hi)
        hi = _quotient(a.hi, b.lo if a.hi > 0 else b.hi)
        return mk("div", (a, b), INT, lo=lo, hi=hi)
    most = max(abs(a.lo), abs(a.hi))
    return mk("div", (a, b), INT, lo=-most, hi=most)


def rem(a: T, b: T) -> T:
    """Return the remainder with the sign of a; 0 for a divisor of 0."""
    folded = _folded("rem", a, b)
    if folded is not None:
        return folded
    most = min(max(abs(b.lo), abs(b.hi)), max(abs(a.lo), abs(a.hi)))
    return mk("rem", (a, b), INT, lo=-most if a.lo < 0 else 0, hi=most if a.hi > 0 else 0)


def bitop(op: str, a: T, b: T) -> T:
    """Return `band`, `bor` or `bxor` of two patterns."""
    folded = _folded(op, a, b)
    if folded is not None:
        return folded
    if op == "band" and (a.lo >= 0 or b.lo >= 0):
        return mk(op, (a, b), INT, lo=0, hi=min(term.hi for term in (a, b) if term.lo >= 0))
    lo, hi = interval_of(max(bits_of(a.lo, a.hi), bits_of(b.lo, b.hi)))
    return mk(op, (a, b), INT, lo=0 if a.lo >= 0 and b.lo >= 0 else lo, hi=hi)


def inv(a: T) -> T:
    """Return a number with every bit inverted."""
    return sub(const(-1), a)


def shr(a: T, n: int) -> T:
    """Shift right by n >= 0 bits and keep the sign."""
    return _folded("shr", a, val=n) or mk("shr", (a,), INT, n, lo=a.lo >> n, hi=a.hi >> n)


def wrap(a: T, n: int) -> T:
    """Return the low |n| bits, signed for positive n."""
    lo, hi = interval_of(n)
    if lo <= a.lo and a.hi <= hi:
        return a
    return _folded("wrap", a, val=n) or mk("wrap", (a,), INT, n, lo, hi)


def least(a: T, most: int) -> T:
    """Return the smaller of a number and a constant."""
    if most >= a.hi:
        return a
    return mk("ite", (lt(const(most), a), const(most), a), INT, lo=a.lo, hi=most)


def greatest(a: T, least: int) -> T:
    """Return the larger of a number and a constant."""
    if least <= a.lo:
        return a
    return mk("ite", (lt(a, const(least)), const(least), a), INT, lo=least, hi=a.hi)


def clip(a: T, lo: int, hi: int) -> T:
    """Clamp a number to an interval.

    The caller ensures that the number is in the interval wherever its value matters.
    """
    if a.hi < lo or a.lo > hi:
        return const(lo if a.hi < lo else hi)
    return greatest(least(a, hi), lo)


def b2i(a: T) -> T:
    """Return a Boolean as 0 or 1."""
    return const(int(a.val)) if a.op == "const" else mk("b2i", (a,), INT, lo=0, hi=1)


def bit(a: T, k: int) -> T:
    """Return bit k of a whole number; bits beyond its pattern equal its sign."""
    k = min(k, bits_of(a.lo, a.hi) - 1)
    if a.op == "const":
        return const(bool(a.val >> k & 1))
    if a.op == "setbit":
        return a.args[1] if a.val[0] == k else bit(a.args[0], k)
    if a.op == "ite":
        simplified = memo.get((a.id, k))
        if simplified is None:
            simplified = memo[a.id, k] = ite(a.args[0], bit(a.args[1], k), bit(a.args[2], k))
        return simplified
    if a.lo >= 0 and k == bits_of(a.lo, a.hi) - 1:
        return FALSE
    return mk("bit", (a,), BOOL, k)


def setbit(a: T, k: int, b: T, n: int) -> T:
    """Return a word of |n| bits, signed for positive n, with bit k set to b."""
    if a.op == "setbit" and a.val[0] == k:
        a = a.args[0]
    lo, hi = interval_of(n)
    return _folded("setbit", a, b, val=(k, n)) or mk("setbit", (a, b), INT, (k, n), lo, hi)


def eq(a: T, b: T) -> T:
    """Return whether two Booleans, whole numbers or floats are equal."""
    if a.kind == BOOL:
        return iff(a, b)
    if a.kind != INT:
        return mk("feq", (a, b), BOOL)
    if a is b:
        return TRUE
    if a.hi < b.lo or b.hi < a.lo:
        return FALSE
    is_choice = a.op == "ite" and "const" in (a.args[1].op, a.args[2].op)
    if b.op == "const" and is_choice:  # at least one of the two comparisons becomes a constant
        simplified = memo.get((a.id, b.id, "eq"))
        if simplified is None:
            simplified = ite(a.args[0], eq(a.args[1], b), eq(a.args[2], b))
            memo[a.id, b.id, "eq"] = simplified
        return simplified
    return mk("eq", (a, b), BOOL)


def same(a: T, b: T) -> T:
    """Return whether two values of one kind are the same; 0.0 and -0.0 differ, NaN is the same as NaN."""
    if a is b:
        return TRUE
    if a.kind in (BOOL, INT):
        return eq(a, b)
    if a.op == b.op == "const":
        return const(meaning("fsame", BOOL, None)(a.val, b.val))
    return mk("fsame", (a, b) if a.id < b.id else (b, a), BOOL)


def lt(a: T, b: T) -> T:
    """Return whether a is less than b."""
    if a.kind != INT:
        return mk("flt", (a, b), BOOL)
    if a.hi < b.lo:
        return TRUE
    if a.lo >= b.hi or a is b:
        return FALSE
    return mk("lt", (a, b), BOOL)


def le(a: T, b: T) -> T:
    """Return whether a is less than or equal to b."""
    return mk("fle", (a, b), BOOL) if a.kind != INT else not_(lt(b, a))


# --- floats


def to_float(a: T, kind: str) -> T:
    """Round a number to a kind of float."""
    if a.kind == BOOL:
        a = b2i(a)
    if a.kind == kind:
        return a
    op = "i2f" if a.kind == INT else "f2f"
    return const(meaning(op, kind, None)(a.val), kind) if a.op == "const" else mk(op, (a,), kind)


def fop(op: str, *args: T) -> T:
    """Return `fadd`, `fsub`, `fmul`, `fdiv`, `frem`, `fneg`, `fabs` or `fsqrt` of floats of one kind."""
    kind = args[0].kind
    if all(argument.op == "const" for argument in args):
        return const(meaning(op, kind, None)(*[argument.val for argument in args]), kind)
    return mk(op, args, kind)


def to_int(a: T, rounding: str) -> T:
    """Round a float half to even (`rne`) or toward zero (`rtz`); for large floats, see `meaning`."""
    if a.op == "const":
        return const(meaning("f2i", INT, rounding)(a.val))
    return mk("f2i", (a,), INT, rounding, -FAR, FAR)
