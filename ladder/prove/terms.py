"""Terms: truths, exact whole numbers with a known interval, floats. Shared, simplified, evaluated.

A whole number is a mathematical one. Its interval says how many bits hold it, so nothing overflows unseen:
`wrap` and `setbit` are the only operations that cut bits off.

Equal terms are one object, compared with `is`. `forget` empties the table that shares them: call it where a
proof begins. Terms made before stay valid; new ones are not the same objects. Ids only grow, and an operand's
is smaller than its term's.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from itertools import count
from typing import Any

from .meaning import BOOL, F32, F64, FAR, INT, meaning
from .meaning import div as _quotient


class T:
    """A term: operation, operands, kind, setting or value, interval of a whole number."""

    __slots__ = ("args", "hi", "id", "kind", "lo", "op", "val")

    def __init__(self, op: str, args: tuple[T, ...], kind: str, val: Any, lo: int, hi: int) -> None:
        self.op, self.args, self.kind, self.val, self.lo, self.hi = op, args, kind, val, lo, hi
        self.id = next(_ids)

    def __repr__(self) -> str:
        if not self.args:
            return str(self.val)
        shown = [*map(repr, self.args), *([] if self.val is None else [repr(self.val)])]
        return f"{self.op}({', '.join(shown)})"


_ids = count()
_table: dict[tuple[Any, ...], T] = {}
_memo: dict[tuple[Any, ...], T] = {}


def mk(op: str, args: tuple[T, ...], kind: str, val: Any = None, lo: int = 0, hi: int = 0) -> T:
    """Return the term, the same object for the same parts; one whole number in the interval is a constant."""
    if kind == INT and lo == hi and op != "const":
        return const(lo)
    key = (op, kind, struct.pack("<d", val) if isinstance(val, float) else val, lo, hi, *[a.id for a in args])
    known = _table.get(key)
    if known is None:
        known = _table[key] = T(op, args, kind, val, lo, hi)
    return known


def const(value: Any, kind: str | None = None) -> T:
    """Return a constant: a float if a kind of floats is named, else a truth or a whole number."""
    if kind in (F32, F64):
        return mk("const", (), kind, meaning("f2f", kind, None)(value))
    if value is True or value is False:
        return TRUE if value else FALSE
    number = int(value)
    return mk("const", (), INT, number, number, number)


TRUE, FALSE = (T("const", (), BOOL, truth, 0, 0) for truth in (True, False))


def forget() -> None:
    """Share no more with terms made so far: their memory is free once nothing holds them."""
    _table.clear()
    _memo.clear()


def known() -> int:
    """Return how many terms are shared now."""
    return len(_table)


def var(name: str, kind: str = BOOL, lo: int = 0, hi: int = 0) -> T:
    """Return a variable; a whole number needs its interval."""
    return mk("var", (), kind, name, lo, hi)


def bits_of(lo: int, hi: int) -> int:
    """Return how many bits a signed pattern needs for the interval.

    >>> bits_of(0, 1), bits_of(-128, 127), bits_of(0, 255)
    (2, 8, 9)
    """
    return max((end if end >= 0 else -end - 1).bit_length() for end in (lo, hi)) + 1


def interval_of(width: int) -> tuple[int, int]:
    """Return the numbers of |width| bits, signed for a positive width."""
    return (-(1 << width - 1), (1 << width - 1) - 1) if width > 0 else (0, (1 << -width) - 1)


# --- truths


def not_(a: T) -> T:
    """Negate a truth."""
    if a.op == "const":
        return FALSE if a.val else TRUE
    return a.args[0] if a.op == "not" else mk("not", (a,), BOOL)


def and_(a: T, b: T) -> T:
    """Both truths."""
    if a is b or b is TRUE:
        return a
    if a is TRUE:
        return b
    if a is FALSE or b is FALSE or not_(a) is b:
        return FALSE
    if b.op == "and" and a in b.args:
        return b
    if a.op == "and" and b in a.args:
        return a
    return mk("and", (a, b) if a.id < b.id else (b, a), BOOL)


def or_(a: T, b: T) -> T:
    """At least one of two truths."""
    return not_(and_(not_(a), not_(b)))


def iff(a: T, b: T) -> T:
    """Two truths agree."""
    if a is b:
        return TRUE
    for one, other in ((a, b), (b, a)):
        if one.op == "const":
            return other if one.val else not_(other)
    if not_(a) is b:
        return FALSE
    return mk("iff", (a, b) if a.id < b.id else (b, a), BOOL)


def ite(c: T, a: T, b: T) -> T:
    """A if c, else b; both of one kind."""
    if c is TRUE or a is b:
        return a
    if c is FALSE:
        return b
    if c.op == "not":
        return ite(c.args[0], b, a)
    if a.op == "ite" and a.args[0] is c:
        a = a.args[1]
    if b.op == "ite" and b.args[0] is c:
        b = b.args[2]
    if a is b:
        return a
    if a.kind == BOOL:
        simpler = _truth_of(c, a, b)
        if simpler is not None:
            return simpler
    return mk("ite", (c, a, b), a.kind, None, min(a.lo, b.lo), max(a.hi, b.hi))


def _truth_of(c: T, a: T, b: T) -> T | None:
    if a is TRUE or a is c:
        return or_(c, b)
    if a is FALSE:
        return and_(not_(c), b)
    if b is TRUE:
        return or_(not_(c), a)
    if b is FALSE or b is c:
        return and_(c, a)
    return iff(c, a) if not_(a) is b else None


# --- whole numbers


def _folded(op: str, *operands: T, val: Any = None) -> T | None:
    """Return the constant of constant operands."""
    if any(a.op != "const" for a in operands):
        return None
    return const(meaning(op, INT, val)(*[a.val for a in operands]))


def add(a: T, b: T) -> T:
    """Sum."""
    if a.op == "const":
        a, b = b, a
    if b.op == "const":
        if b.val == 0:
            return a
        if a.op == "add" and a.args[1].op == "const":
            return add(a.args[0], const(a.args[1].val + b.val))
    return mk("add", (a, b), INT, None, a.lo + b.lo, a.hi + b.hi)


def sub(a: T, b: T) -> T:
    """Difference."""
    if b.op == "const":
        return add(a, const(-b.val))
    if a is b:
        return const(0)
    return mk("sub", (a, b), INT, None, a.lo - b.hi, a.hi - b.lo)


def mul(a: T, b: T) -> T:
    """Product."""
    if a.op == "const":
        a, b = b, a
    if b.op == "const" and b.val == 1:
        return a
    ends = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    return mk("mul", (a, b), INT, None, min(ends), max(ends))


def div(a: T, b: T) -> T:
    """Quotient toward zero; 0 for a divisor of 0."""
    folded = _folded("div", a, b)
    if folded is not None:
        return folded
    if b.lo > 0:
        lo = _quotient(a.lo, b.lo if a.lo < 0 else b.hi)
        hi = _quotient(a.hi, b.lo if a.hi > 0 else b.hi)
        return mk("div", (a, b), INT, None, lo, hi)
    most = max(abs(a.lo), abs(a.hi))
    return mk("div", (a, b), INT, None, -most, most)


def rem(a: T, b: T) -> T:
    """Remainder with the sign of a; 0 for a divisor of 0."""
    folded = _folded("rem", a, b)
    if folded is not None:
        return folded
    most = min(max(abs(b.lo), abs(b.hi)), max(abs(a.lo), abs(a.hi)))
    return mk("rem", (a, b), INT, None, -most if a.lo < 0 else 0, most if a.hi > 0 else 0)


def bitop(op: str, a: T, b: T) -> T:
    """`band`, `bor` or `bxor` of two patterns."""
    folded = _folded(op, a, b)
    if folded is not None:
        return folded
    if op == "band" and (a.lo >= 0 or b.lo >= 0):
        return mk(op, (a, b), INT, None, 0, min(each.hi for each in (a, b) if each.lo >= 0))
    lo, hi = interval_of(max(bits_of(a.lo, a.hi), bits_of(b.lo, b.hi)))
    return mk(op, (a, b), INT, None, 0 if a.lo >= 0 and b.lo >= 0 else lo, hi)


def inv(a: T) -> T:
    """Every bit turned over."""
    return sub(const(-1), a)


def shr(a: T, n: int) -> T:
    """Shift right by n >= 0 bits; the sign stays."""
    return _folded("shr", a, val=n) or mk("shr", (a,), INT, n, a.lo >> n, a.hi >> n)


def wrap(a: T, n: int) -> T:
    """Low |n| bits, signed for positive n."""
    lo, hi = interval_of(n)
    if lo <= a.lo and a.hi <= hi:
        return a
    return _folded("wrap", a, val=n) or mk("wrap", (a,), INT, n, lo, hi)


def least(a: T, most: int) -> T:
    """The smaller of a number and a constant."""
    return mk("ite", (lt(const(most), a), const(most), a), INT, None, a.lo, most) if most < a.hi else a


def greatest(a: T, least: int) -> T:
    """The larger of a number and a constant."""
    return mk("ite", (lt(a, const(least)), const(least), a), INT, None, least, a.hi) if least > a.lo else a


def clip(a: T, lo: int, hi: int) -> T:
    """The nearest number of an interval: for one that lies in it wherever its value counts."""
    if a.hi < lo or a.lo > hi:
        return const(lo if a.hi < lo else hi)
    return greatest(least(a, hi), lo)


def b2i(a: T) -> T:
    """0 or 1."""
    return const(int(a.val)) if a.op == "const" else mk("b2i", (a,), INT, None, 0, 1)


def bit(a: T, k: int) -> T:
    """Bit k of a whole number; bits beyond its pattern are its sign."""
    k = min(k, bits_of(a.lo, a.hi) - 1)
    if a.op == "const":
        return const(bool(a.val >> k & 1))
    if a.op == "setbit":
        return a.args[1] if a.val[0] == k else bit(a.args[0], k)
    if a.op == "ite":
        known = _memo.get((a.id, k))
        if known is None:
            known = _memo[a.id, k] = ite(a.args[0], bit(a.args[1], k), bit(a.args[2], k))
        return known
    if a.lo >= 0 and k == bits_of(a.lo, a.hi) - 1:
        return FALSE
    return mk("bit", (a,), BOOL, k)


def setbit(a: T, k: int, b: T, n: int) -> T:
    """A word of |n| bits, signed for positive n, with bit k set to b; `a` lies in the word's interval."""
    if a.op == "setbit" and a.val[0] == k:
        a = a.args[0]
    lo, hi = interval_of(n)
    return _folded("setbit", a, b, val=(k, n)) or mk("setbit", (a, b), INT, (k, n), lo, hi)


def eq(a: T, b: T) -> T:
    """Two truths, whole numbers or floats are equal."""
    if a.kind == BOOL:
        return iff(a, b)
    if a.kind != INT:
        return mk("feq", (a, b), BOOL)
    if a is b:
        return TRUE
    if a.hi < b.lo or b.hi < a.lo:
        return FALSE
    if b.op == "const" and a.op == "ite" and "const" in (a.args[1].op, a.args[2].op):
        known = _memo.get((a.id, b.id, "eq"))
        if known is None:
            known = ite(a.args[0], eq(a.args[1], b), eq(a.args[2], b))
            _memo[a.id, b.id, "eq"] = known
        return known
    return mk("eq", (a, b), BOOL)


def lt(a: T, b: T) -> T:
    """A is less than b."""
    if a.kind != INT:
        return mk("flt", (a, b), BOOL)
    if a.hi < b.lo:
        return TRUE
    if a.lo >= b.hi or a is b:
        return FALSE
    return mk("lt", (a, b), BOOL)


def le(a: T, b: T) -> T:
    """A is less than or equal to b."""
    return mk("fle", (a, b), BOOL) if a.kind != INT else not_(lt(b, a))


# --- floats


def to_float(a: T, kind: str) -> T:
    """Round to a kind of floats."""
    if a.kind == BOOL:
        a = b2i(a)
    if a.kind == kind:
        return a
    op = "i2f" if a.kind == INT else "f2f"
    return const(meaning(op, kind, None)(a.val), kind) if a.op == "const" else mk(op, (a,), kind)


def fop(op: str, *args: T) -> T:
    """`fadd`, `fsub`, `fmul`, `fdiv`, `frem`, `fneg`, `fabs` or `fsqrt` of floats of one kind."""
    kind = args[0].kind
    if all(a.op == "const" for a in args):
        return const(meaning(op, kind, None)(*[a.val for a in args]), kind)
    return mk(op, args, kind)


def to_int(a: T, how: str) -> T:
    """Round a float half to even (`rne`) or cut it off (`rtz`); see `meaning` for the largest."""
    if a.op == "const":
        return const(meaning("f2i", INT, how)(a.val))
    return mk("f2i", (a,), INT, how, -FAR, FAR)


# --- walks


def reach(roots: Iterable[T]) -> list[T]:
    """Return all terms below the roots, operands first."""
    seen: dict[int, T] = {}
    todo = list(roots)
    while todo:
        t = todo.pop()
        if t.id not in seen:
            seen[t.id] = t
            todo.extend(t.args)
    return [seen[number] for number in sorted(seen)]


def variables(roots: Iterable[T]) -> list[T]:
    """Return the variables below the roots."""
    return [t for t in reach(roots) if t.op == "var"]
