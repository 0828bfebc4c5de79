"""Terms: Booleans, exact whole numbers with a known interval, and floats; simplified and shared.

Whole numbers are mathematical integers. The interval determines how many bits they need. Only `wrap` and
`setbit` drop bits.

Equal terms are the same object and are compared with `is`. `forget` empties the table of shared terms; call
it at the beginning of a proof. Earlier terms stay valid, but equal new terms are different objects. Ids
increase, so an operand has a smaller id than its term.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from itertools import count
from typing import Any

from .meaning import BOOL, F32, F64, INT, meaning


class T:
    """A term.

    Attributes:
        op: its operation (see `meaning`), "var" or "const".
        args: its operands.
        kind: `BOOL`, `INT`, `F32` or `F64`.
        val: the setting of the operation, the value of a constant, or the name of a variable.
        lo: the lowest value of a whole number.
        hi: the highest value of a whole number.
        id: identifies the term.
    """

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
memo: dict[tuple[Any, ...], T] = {}
"""Terms that were simplified before, by operation and operands."""


def mk(op: str, args: tuple[T, ...], kind: str, val: Any = None, lo: int = 0, hi: int = 0) -> T:
    """Return the shared term with these parts; a constant if the interval has only one number."""
    if kind == INT and lo == hi and op != "const":
        return const(lo)
    key = (
        op,
        kind,
        struct.pack("<d", val) if isinstance(val, float) else val,  # -0.0 and 0.0 are equal, but not the same
        lo,
        hi,
        *[argument.id for argument in args],
    )
    existing = _table.get(key)
    if existing is None:
        existing = _table[key] = T(op, args, kind, val, lo, hi)
    return existing


def const(value: Any, kind: str | None = None) -> T:
    """Return a constant: a float if `kind` is a kind of float, else a Boolean or a whole number."""
    if kind in (F32, F64):
        return mk("const", (), kind, meaning("f2f", kind, None)(value))
    if value is True or value is False:
        return TRUE if value else FALSE
    number = int(value)
    return mk("const", (), INT, number, number, number)


TRUE, FALSE = (T("const", (), BOOL, truth, lo=0, hi=0) for truth in (True, False))


def forget() -> None:
    """Empty the table of shared terms; new terms share nothing with earlier ones, which can be freed."""
    _table.clear()
    memo.clear()


def var(name: str, kind: str = BOOL, lo: int = 0, hi: int = 0) -> T:
    """Return a variable; a whole number needs its interval."""
    return mk("var", (), kind, name, lo, hi)


def bits_of(lo: int, hi: int) -> int:
    """Return the number of bits that an interval needs in two's complement.

    >>> bits_of(0, 1), bits_of(-128, 127), bits_of(0, 255)
    (2, 8, 9)
    """
    return max((end if end >= 0 else -end - 1).bit_length() for end in (lo, hi)) + 1


def interval_of(width: int) -> tuple[int, int]:
    """Return the lowest and highest numbers of |width| bits, signed if the width is positive."""
    return (-(1 << width - 1), (1 << width - 1) - 1) if width > 0 else (0, (1 << -width) - 1)


# --- Booleans


def not_(a: T) -> T:
    """Return the negation."""
    if a.op == "const":
        return FALSE if a.val else TRUE
    return a.args[0] if a.op == "not" else mk("not", (a,), BOOL)


def and_(a: T, b: T) -> T:
    """Return the conjunction."""
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
    """Return the disjunction."""
    return not_(and_(not_(a), not_(b)))


def all_of(truths: Iterable[T]) -> T:
    """Return the conjunction of any number of Booleans."""
    return reduce(and_, truths, TRUE)


def any_of(truths: Iterable[T]) -> T:
    """Return the disjunction of any number of Booleans."""
    return reduce(or_, truths, FALSE)


def iff(a: T, b: T) -> T:
    """Return whether two Booleans are equal."""
    if a is b:
        return TRUE
    for constant, partner in ((a, b), (b, a)):
        if constant.op == "const":
            return partner if constant.val else not_(partner)
    if not_(a) is b:
        return FALSE
    return mk("iff", (a, b) if a.id < b.id else (b, a), BOOL)


def ite(c: T, a: T, b: T) -> T:
    """Return a if c is true, else b; both have the same kind."""
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
    return mk("ite", (c, a, b), a.kind, lo=min(a.lo, b.lo), hi=max(a.hi, b.hi))


def _truth_of(c: T, a: T, b: T) -> T | None:
    """Return a choice between Booleans in a form without `ite`; None if no simpler form exists."""
    if a is TRUE or a is c:
        return or_(c, b)
    if a is FALSE:
        return and_(not_(c), b)
    if b is TRUE:
        return or_(not_(c), a)
    if b is FALSE or b is c:
        return and_(c, a)
    return iff(c, a) if not_(a) is b else None


# --- walks


def replaced(t: T, replacements: Mapping[str, T], memo: dict[int, T]) -> T:
    """Return a term with the named variables replaced; `memo` caches results by id."""
    unfinished = [t]
    while unfinished:
        term = unfinished[-1]
        missing = [] if term.id in memo else [argument for argument in term.args if argument.id not in memo]
        if missing:
            unfinished += missing
            continue
        unfinished.pop()
        if term.id in memo:
            continue
        if term.op == "var":
            memo[term.id] = replacements.get(term.val, term)
        else:
            args = tuple(memo[argument.id] for argument in term.args)
            memo[term.id] = mk(term.op, args, term.kind, term.val, term.lo, term.hi)
    return memo[t.id]


def reach(roots: Iterable[T]) -> list[T]:
    """Return the roots and all terms in them, operands first."""
    reached: dict[int, T] = {}
    open_terms = list(roots)
    while open_terms:
        term = open_terms.pop()
        if term.id not in reached:
            reached[term.id] = term
            open_terms.extend(term.args)
    return [reached[number] for number in sorted(reached)]


def variables(roots: Iterable[T]) -> list[T]:
    """Return the variables in the roots."""
    return [term for term in reach(roots) if term.op == "var"]


def variables_by_root(roots: Iterable[T]) -> dict[T, list[T]]:
    """Return the variables in each root, found in one walk over all roots."""
    roots, leaves, masks = list(roots), list[T](), dict[int, int]()
    for term in reach(roots):
        mask = 0
        for operand in term.args:
            mask |= masks[operand.id]
        if term.op == "var":
            mask = 1 << len(leaves)
            leaves.append(term)
        masks[term.id] = mask
    return {root: [leaves[number] for number in numbers_in(masks[root.id])] for root in roots}


def numbers_in(mask: int) -> Iterator[int]:
    """Yield the numbers of the bits that are set in a mask.

    >>> list(numbers_in(0b1010))
    [1, 3]
    """
    while mask:
        yield (mask & -mask).bit_length() - 1
        mask &= mask - 1
