"""Symbolic numbers that the Python code of instructions can calculate with.

A `TermSymbol` behaves like a Python number: its operators return symbols, or a number if the result is
constant. The machine decides on each path whether the symbol is true. Uses that need an actual number, such
as `int`, `float`, `range` or a key of a dict, raise an error.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn, Protocol

from ...model.tags import Leaf
from ...state.lowered import LoweredProgram
from ..algebra.meaning import BOOL, F32, F64, INT
from ..algebra.numbers import add, b2i, bitop, div, eq, fop, inv, le, lt, mul, rem, shr, sub, to_float, wrap
from ..algebra.terms import TRUE, T, and_, const, iff, mk, not_, or_

FLOATS = (F32, F64)

_EXACT = 1 << 53
"""Whole numbers up to this size are exact as doubles."""

Decide = Callable[[T], bool]
"""Decides a condition on the current path."""


class UnmodeledError(Exception):
    """Raised if an instruction can't run on terms; the places that it may write become unknown."""


class TermScan(Protocol):
    """The methods of `TermPlaces` that memory and faults need."""

    lowered: LoweredProgram
    paths: Any
    log: Any
    site: int

    def symbol(self, t: T) -> Any:
        """Return a term as a number."""

    def value_here(self, leaf: Leaf, index: int) -> T:
        """Return the term of a place where the current instruction is reached."""

    def poke(self, leaf: Leaf, index: int, t: T, guard: T = TRUE) -> None:
        """Set a place where the guard is true."""

    def here(self) -> T:
        """Return whether the current path is taken."""


def truth_of(t: T) -> T:
    """Return whether a number is not 0."""
    if t.kind == BOOL:
        return t
    return not_(eq(t, const(0) if t.kind == INT else const(0.0, t.kind)))


def whole_of(t: T) -> T:
    """Return a Boolean as 0 or 1; return a whole number unchanged."""
    if t.kind in FLOATS:
        raise UnmodeledError("a floating-point number where a whole one is needed")
    return b2i(t) if t.kind == BOOL else t


def term_of(value: Any, kind: str | None = None) -> T:
    """Return the term of a number or a symbol, converted to a kind if one is given."""
    if isinstance(value, TermSymbol):
        term = value.t
    elif isinstance(value, float):
        term = const(value, kind if kind in FLOATS else F64)
    else:
        term = const(value)
    if kind is None or term.kind == kind:
        return term
    if kind in FLOATS:
        return to_float(term, kind)
    return truth_of(term) if kind == BOOL else whole_of(term)


def alike(a: Any, b: Any) -> tuple[T, T]:
    """Return the terms of two numbers in a common kind: integer, or a float kind that fits both."""
    float_kinds = {_kind(a), _kind(b)} - {INT, BOOL}
    kind = INT
    if float_kinds:
        kind = F32 if float_kinds == {F32} else F64
    return term_of(a, kind), term_of(b, kind)


def _kind(value: Any) -> str:
    """Return the kind of a number or symbol; F32 for a float that single precision can represent."""
    if isinstance(value, TermSymbol):
        return value.t.kind
    if isinstance(value, float):
        return F32 if value != value or const(value, F32).val == value else F64
    return INT


class TermSymbol:
    """A number that is known as a term."""

    __slots__ = ("decide", "t")

    def __init__(self, t: T, decide: Decide) -> None:
        self.t, self.decide = t, decide

    def __repr__(self) -> str:
        return "a term"  # the power may be large

    def __bool__(self) -> bool:
        return self.decide(truth_of(self.t))

    def _refuse(self, *_others: object) -> NoReturn:
        raise UnmodeledError("a Python number is needed")

    __int__ = __index__ = __float__ = __format__ = __str__ = __iter__ = __round__ = __trunc__ = _refuse
    __floor__ = __ceil__ = __len__ = _refuse

    def __hash__(self) -> int:
        self._refuse()

    def of(self, t: T) -> Any:
        """Return the symbol of another term, or its value if it is constant."""
        return t.val if t.op == "const" else TermSymbol(t, self.decide)

    # --- arithmetic

    def _arithmetic(self, a: Any, b: Any, whole: Callable[[T, T], T], real: str) -> Any:
        """Return the result of `whole` for whole numbers, or else of the double operation `real`."""
        if not (isinstance(a, (TermSymbol, int, float)) and isinstance(b, (TermSymbol, int, float))):
            return NotImplemented
        left, right = alike(a, b)
        if left.kind == INT:
            return self.of(whole(left, right))
        return self.of(fop(real, to_float(left, F64), to_float(right, F64)))  # as in Python

    def __add__(self, other: Any) -> Any:
        return self._arithmetic(self, other, _sum, "fadd")

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self._arithmetic(self, other, _difference, "fsub")

    def __rsub__(self, other: Any) -> Any:
        return self._arithmetic(other, self, _difference, "fsub")

    def __mul__(self, other: Any) -> Any:
        return self._arithmetic(self, other, mul, "fmul")

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self._quotient(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._quotient(other, self)

    def _quotient(self, a: Any, b: Any) -> Any:
        """Divide as doubles; rows check for a divisor of 0 first, which Python does not allow."""
        left, right = alike(a, b)
        if INT in (left.kind, right.kind) and max(-left.lo, left.hi, -right.lo, right.hi) > _EXACT:
            self._refuse()
        return self.of(fop("fdiv", to_float(left, F64), to_float(right, F64)))

    def __floordiv__(self, other: Any) -> Any:
        """Divide nonnegative numbers; rows check for a divisor of 0 first."""
        left, right = whole_of(self.t), term_of(other, INT)
        if left.lo < 0 or right.lo < 0:
            self._refuse()
        return self.of(div(left, right))

    def __rfloordiv__(self, other: Any) -> Any:
        return TermSymbol(const(other), self.decide) // self

    def __mod__(self, other: Any) -> Any:
        if not isinstance(other, int) or other <= 0 or self.t.kind != INT or self.t.lo < 0:
            self._refuse()
        return self.of(rem(self.t, const(other)))

    def __neg__(self) -> Any:
        if self.t.kind in FLOATS:
            return self.of(fop("fneg", self.t))
        return self.of(sub(const(0), whole_of(self.t)))

    def __abs__(self) -> Any:
        """Return the absolute value, whose interval is never negative."""
        if self.t.kind in FLOATS:
            return self.of(fop("fabs", self.t))
        term = whole_of(self.t)
        if term.lo >= 0:
            return self
        most = max(-term.lo, term.hi)
        return self.of(mk("ite", (lt(term, const(0)), sub(const(0), term), term), INT, None, 0, most))

    # --- bits

    def _bits(self, other: Any, op: str, truth: Callable[[T, T], T]) -> Any:
        """Return the result of a bit operation; for two Booleans, the result of `truth`."""
        if not isinstance(other, (TermSymbol, int)):
            return NotImplemented
        if self.t.kind == BOOL and _is_truth(other):
            return self.of(truth(self.t, term_of(other)))
        return self.of(bitop(op, term_of(self, INT), term_of(other, INT)))

    def __and__(self, other: Any) -> Any:
        return self._bits(other, "band", and_)

    def __or__(self, other: Any) -> Any:
        return self._bits(other, "bor", or_)

    def __xor__(self, other: Any) -> Any:
        return self._bits(other, "bxor", lambda a, b: not_(iff(a, b)))

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    def __invert__(self) -> Any:
        return self.of(inv(whole_of(self.t)))

    def __lshift__(self, count: Any) -> Any:
        if not isinstance(count, int):
            self._refuse()
        return self * (1 << count)

    def __rshift__(self, count: Any) -> Any:
        if not isinstance(count, int):
            self._refuse()
        return self.of(shr(whole_of(self.t), count))

    # --- comparisons

    def __eq__(self, other: object) -> Any:
        if not isinstance(other, (TermSymbol, int, float)):
            return NotImplemented
        if self.t.kind == BOOL and _is_truth(other):
            return self.of(iff(self.t, term_of(other)))
        return self.of(eq(*alike(self, other)))

    def __ne__(self, other: object) -> Any:
        equal = self == other
        return self.of(not_(equal.t)) if isinstance(equal, TermSymbol) else not equal

    def __lt__(self, other: Any) -> Any:
        return self.of(lt(*alike(self, other)))

    def __gt__(self, other: Any) -> Any:
        return self.of(lt(*alike(other, self)))

    def __le__(self, other: Any) -> Any:
        return self.of(le(*alike(self, other)))

    def __ge__(self, other: Any) -> Any:
        return self.of(le(*alike(other, self)))


def _is_truth(value: Any) -> bool:
    """Return whether a value is a Boolean or a symbol of one."""
    return value is True or value is False or (isinstance(value, TermSymbol) and value.t.kind == BOOL)


def _sum(a: T, b: T) -> T:
    return _wrapped(a, b) or add(a, b)


def _difference(a: T, b: T) -> T:
    return (_wrapped(a, const(-b.val)) if b.op == "const" else None) or sub(a, b)


def _wrapped(a: T, b: T) -> T | None:
    """Recognize ((x + half) & (2 * half - 1)) - half from `arithmetic.wrap`; return the low bits of x."""
    if b.op != "const" or b.val >= 0 or a.op != "band" or a.args[1].op != "const":
        return None
    half, mask = -b.val, a.args[1].val
    if mask != 2 * half - 1 or half & (half - 1):
        return None
    return wrap(add(a.args[0], const(-half)), half.bit_length())
