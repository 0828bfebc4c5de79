"""Translates terms to a solver's terms: bit vectors as wide as their intervals, floats, Booleans.

A solver is any object that accepts operations by their SMT-LIB 2.6 names: bitwuzla or a text writer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

from ...model.arithmetic import wrap
from ..algebra.meaning import BOOL, F32, F64, FAR, INT
from ..algebra.terms import T, bits_of, const

Sort = str | int
"""`BOOL`, `F32`, `F64`, or the width of a bit vector."""

FIELDS = {F32: (8, 24), F64: (11, 53)}
"""Number of bits of the exponent and of the significand."""

WIDEST_DIRECT = 54
"""Wider whole numbers are rounded to double, then to single, as in the instructions of Logix."""


class Sink(Protocol):
    """Makes the terms of one solver."""

    def declare(self, sort: Sort, name: str) -> Any:
        """Return a new variable."""

    def value(self, sort: Sort, value: Any) -> Any:
        """Return a constant; for a bit vector, `value` is its signed value."""

    def apply(self, op: str, args: Sequence[Any], indices: Sequence[int] = ()) -> Any:
        """Return the result of an operation, given its SMT-LIB name."""

    def state(self, formula: Any) -> None:
        """Assert a condition."""


def width(t: T) -> int:
    """Return the width of a whole number's signed pattern, in bits."""
    return bits_of(t.lo, t.hi)


def sort_of(t: T) -> Sort:
    """Return the solver's sort of a term."""
    return width(t) if t.kind == INT else t.kind


def declare(sink: Sink, t: T, name: str) -> Any:
    """Return a new variable; assert that it lies in the interval of its term."""
    variable = sink.declare(sort_of(t), name)
    for condition in interval_conditions(sink, t, variable):
        sink.state(condition)
    return variable


def interval_conditions(sink: Sink, t: T, formula: Any) -> Iterator[Any]:
    """Yield the conditions that keep a whole number in its interval, if its bits allow values outside."""
    bits = width(t) if t.kind == INT else 0
    if bits and t.lo != -(1 << bits - 1):
        yield sink.apply("bvsle", [sink.value(bits, t.lo), formula])
    if bits and t.hi != (1 << bits - 1) - 1:
        yield sink.apply("bvsle", [formula, sink.value(bits, t.hi)])


def literal(sink: Sink, v: T, value: Any) -> Any:
    """Return a value of a variable as a constant."""
    if v.kind == INT:
        return sink.value(width(v), int(value))
    return sink.value(v.kind, bool(value) if v.kind == BOOL else const(value, v.kind).val)


def translate(sink: Sink, root: T, lookup: Callable[[T], Any], memo: dict[int, Any]) -> Any:
    """Return the solver's term for a term.

    Args:
        lookup: returns the solver's term for a variable.
        memo: caches the solver's terms by id.
    """
    missing: dict[int, T] = {}
    todo = [root]
    while todo:
        term = todo.pop()
        if term.id not in memo and term.id not in missing:
            missing[term.id] = term
            todo.extend(term.args)
    for number in sorted(missing):
        term = missing[number]
        memo[number] = (
            lookup(term)
            if term.op == "var"
            else _translated(sink, term, [memo[argument.id] for argument in term.args])
        )
    return memo[root.id]


def fit(sink: Sink, formula: Any, width: int, new_width: int) -> Any:
    """Extend or truncate a signed pattern."""
    if new_width > width:
        return sink.apply("sign_extend", [formula], [new_width - width])
    return sink.apply("extract", [formula], [new_width - 1, 0]) if new_width < width else formula


def _translated(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Return the solver's term for a term that is not a variable, given its operands' solver terms."""
    if t.op == "const":
        return sink.value(sort_of(t), t.val)
    special = _SPECIAL.get(t.op)
    if special is not None:
        return special(sink, t, operands)
    if t.op in _WHOLE:
        return _whole(sink, t, operands)
    rounded = [_ROUND, *operands] if t.op in ("fadd", "fsub", "fmul", "fdiv", "fsqrt") else operands
    return sink.apply(_DIRECT[t.op], rounded)


_ROUND = "RNE"
"""The rounding mode of arithmetic, the first operand."""

_DIRECT = {
    "not": "not",
    "and": "and",
    "iff": "=",
    "fadd": "fp.add",
    "fsub": "fp.sub",
    "fmul": "fp.mul",
    "fdiv": "fp.div",
    "fneg": "fp.neg",
    "fabs": "fp.abs",
    "fsqrt": "fp.sqrt",
    "frem": "fp.rem",
    "feq": "fp.eq",
    "fsame": "=",
    "flt": "fp.lt",
    "fle": "fp.leq",
    "fnan": "fp.isNaN",
}
_WHOLE = {
    "add": "bvadd",
    "sub": "bvsub",
    "mul": "bvmul",
    "div": "bvsdiv",
    "rem": "bvsrem",
    "band": "bvand",
    "bor": "bvor",
    "bxor": "bvxor",
    "eq": "=",
    "lt": "bvslt",
}


def _whole(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Translate with all operands as wide as the widest operand or the result, so nothing overflows."""
    bits = max(width(argument) for argument in t.args)
    if t.kind == INT:
        bits = max(bits, width(t)) + (t.op in ("div", "rem"))
    widened = [
        fit(sink, formula, width(argument), bits) for formula, argument in zip(operands, t.args, strict=True)
    ]
    result = sink.apply(_WHOLE[t.op], widened)
    if t.kind != INT:
        return result
    if t.op in ("div", "rem") and t.args[1].lo <= 0 <= t.args[1].hi:
        zero = sink.value(bits, 0)
        result = sink.apply("ite", [sink.apply("=", [widened[1], zero]), zero, result])
    return fit(sink, result, bits, width(t))


def _ite(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Translate a choice; both results get the width of the term."""
    if t.kind == INT:
        arms = [
            fit(sink, formula, width(argument), width(t))
            for formula, argument in zip(operands[1:], t.args[1:], strict=True)
        ]
        operands = [operands[0], *arms]
    return sink.apply("ite", operands)


def _shr(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Shift right; a distance beyond the width leaves only the sign."""
    bits = width(t.args[0])
    low = min(t.val, bits - 1)
    return fit(sink, sink.apply("extract", operands, [bits - 1, low]), bits - low, width(t))


def _wrap(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Keep the low `t.val` bits; a negative `t.val` means unsigned, so the sign bit 0 is added."""
    bits = abs(t.val)
    operand_width = width(t.args[0])
    low = sink.apply(
        "extract", [fit(sink, operands[0], operand_width, max(bits, operand_width))], [bits - 1, 0]
    )
    return low if t.val > 0 else sink.apply("zero_extend", [low], [1])


def _b2i(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Return 1 or 0, with a sign bit."""
    return sink.apply("ite", [operands[0], sink.value(2, 1), sink.value(2, 0)])


def _bit(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Return whether a bit is 1; bits beyond the width equal the sign."""
    number = min(t.val, width(t.args[0]) - 1)
    return sink.apply("=", [sink.apply("extract", operands, [number, number]), sink.value(1, -1)])


def _setbit(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Set a bit where the second operand is true; clear it elsewhere."""
    bits, (number, _) = width(t), t.val
    word = fit(sink, operands[0], width(t.args[0]), bits)
    set_mask, clear_mask = wrap(1 << number, bits), wrap(~(1 << number), bits)
    on = sink.apply("bvor", [word, sink.value(bits, set_mask)])
    off = sink.apply("bvand", [word, sink.value(bits, clear_mask)])
    return sink.apply("ite", [operands[1], on, off])


def _i2f(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Convert an integer to a float; a wide integer is converted to SINGLE through double."""
    if t.kind == F32 and width(t.args[0]) > WIDEST_DIRECT:
        double = sink.apply("to_fp_signed", [_ROUND, *operands], FIELDS[F64])
        return sink.apply("to_fp", [_ROUND, double], FIELDS[F32])
    return sink.apply("to_fp_signed", [_ROUND, *operands], FIELDS[t.kind])


def _f2f(sink: Sink, t: T, operands: list[Any]) -> Any:
    return sink.apply("to_fp", [_ROUND, *operands], FIELDS[t.kind])


def _f2i(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Round a float to an integer; the result is 0 for NaN, and for magnitudes of FAR or more."""
    bits, kind = width(t), t.args[0].kind
    near = [
        sink.apply("fp.lt", [operands[0], sink.value(kind, float(FAR))]),
        sink.apply("fp.lt", [sink.value(kind, -float(FAR)), operands[0]]),
    ]
    whole = sink.apply("fp.to_sbv", ["RNE" if t.val == "rne" else "RTZ", *operands], [bits])
    return sink.apply("ite", [sink.apply("and", near), whole, sink.value(bits, 0)])


def _ffin(sink: Sink, t: T, operands: list[Any]) -> Any:
    """Return whether a float is neither infinite nor NaN."""
    unusual = [sink.apply(name, operands) for name in ("fp.isInfinite", "fp.isNaN")]
    return sink.apply("not", [sink.apply("or", unusual)])


_SPECIAL: dict[str, Callable[[Sink, T, list[Any]], Any]] = {
    "ite": _ite,
    "shr": _shr,
    "wrap": _wrap,
    "b2i": _b2i,
    "bit": _bit,
    "setbit": _setbit,
    "i2f": _i2f,
    "f2f": _f2f,
    "f2i": _f2i,
    "ffin": _ffin,
}
