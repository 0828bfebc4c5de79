"""Computes, compares and converts values in a scan on terms; see `interpreter.place_values`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from ...model.errors import STRING_NUMBER_CODE
from ...model.operands import SINGLE, Calculation, Group, Place, Resolved, is_truth
from ...model.operators import RELATIONS
from ...model.tags import Leaf
from ...model.types import ULINT, Elementary, Field
from ..algebra.meaning import BOOL, F32, F64, INT
from ..algebra.numbers import bitop, clip, eq, fop, least, lt, to_float, to_int, wrap
from ..algebra.terms import FALSE, TRUE, T, all_of, and_, const, ite, not_, or_
from .copies import TermCopies
from .operations import DIVISIONS, FACTORS, REAL, TRUTH, UNKNOWN, WHOLE, is_finite, is_large, is_nan
from .patterns import Byte, constant_bytes, unpack
from .places import kind_of
from .symbols import FLOATS, TermSymbol, UnmodeledError, alike, term_of, truth_of, whole_of
from .texts import TermText, digits, number_in

_LARGEST = {F32: 1 << 128, F64: 1 << 1024}


class TermValues(TermCopies):
    """Implements the calculations of instructions on terms."""

    # --- conversions of rows

    def whole(self, value: Any) -> Any:
        """Return a number truncated to an integer, or a Boolean as 0 or 1."""
        if not isinstance(value, TermSymbol):
            return int(value)
        if value.t.kind in FLOATS:
            return self.symbol(self._cut(value.t))
        return self.symbol(term_of(value, INT))

    def truth(self, value: Any) -> Any:
        """Return whether a value is not 0."""
        return self.symbol(term_of(value, BOOL))

    def is_float(self, value: Any) -> bool:
        """Return whether a number is REAL or LREAL."""
        return value.t.kind in FLOATS if isinstance(value, TermSymbol) else isinstance(value, float)

    def is_infinite(self, value: Any) -> Any:
        """Return whether a number is infinite."""
        if not isinstance(value, TermSymbol) or value.t.kind not in FLOATS:
            return isinstance(value, float) and math.isinf(value)
        return self.symbol(and_(not_(is_finite(value.t)), not_(is_nan(value.t))))

    def is_nan(self, value: Any) -> Any:
        """Return whether a number is NaN."""
        if not isinstance(value, TermSymbol) or value.t.kind not in FLOATS:
            return isinstance(value, float) and math.isnan(value)
        return self.symbol(is_nan(value.t))

    def infinity(self, value: Any) -> Any:
        """Return infinity with the sign of a number; the sign is unknown for a float of 0 and for NaN."""
        if not isinstance(value, TermSymbol):
            return super().infinity(value)
        term, zero = value.t, const(0) if value.t.kind == INT else const(0.0, value.t.kind)
        unsigned = FALSE if term.kind == INT else and_(not_(lt(term, zero)), not_(lt(zero, term)))
        below = lt(term, zero)
        if unsigned is not FALSE:
            below = ite(unsigned, self.computed("sign", (BOOL, 0, 0), term, strict=True), below)
        return self.symbol(ite(below, const(-math.inf, F64), const(math.inf, F64)))

    def truncated(self, value: Any) -> Any:
        """Return a float without its fraction; 0 for infinity and NaN."""
        return self.symbol(self._cut(value.t)) if isinstance(value, TermSymbol) else super().truncated(value)

    def least(self, value: Any, most: int) -> Any:
        """Return the smaller of a number and a limit."""
        return self.symbol(least(term_of(value, INT), most))

    def chosen(self, truth: Any, one: Any, other: Any) -> Any:
        """Return one of two numbers without splitting the path."""
        return self.symbol(ite(term_of(truth, BOOL), *alike(one, other)))

    def converted(self, kind: Elementary, value: Any) -> Any:
        """Return a number converted to a type, without setting flags or causing faults."""
        if not isinstance(value, TermSymbol):
            return super().converted(kind, value)
        if kind.is_bool:
            return self.truth(value)
        if kind.is_real or kind.is_double:
            return self.symbol(to_float(value.t, F32 if kind.is_real else F64))
        if value.t.kind not in FLOATS:
            return self.symbol(wrap(whole_of(value.t), kind.wraps))
        return self.symbol(self._rounded_to(value.t, kind)[0])

    # --- arithmetic

    def rounded(self, value: Any, width: int) -> Any:
        """Round a number to SINGLE or DOUBLE precision; for an integer width, return it unchanged."""
        if not isinstance(value, TermSymbol):
            return super().rounded(value, width)
        return value if width > 0 else self.symbol(to_float(value.t, F32 if width == SINGLE else F64))

    def _calculate(self, name: str, values: Sequence[Any], width: int) -> Any:
        """Return the result of an operation; record zero divisors and overflows.

        An integer operation with a divisor of 0 returns its dividend.
        """
        if not any(isinstance(value, TermSymbol) for value in values):
            return super()._calculate(name, values, width)
        if width <= 0:
            return self.symbol(self._calculated_real(name, values, F32 if width == SINGLE else F64))
        terms = [term_of(value, INT) for value in values]
        if name in ("/", "MOD"):
            zero = eq(terms[1], const(0))
            self.fault_log.zero_divisor_if(zero)  # type: ignore[attr-defined]
            exact = DIVISIONS[name](*terms)
            return self.symbol(ite(zero, terms[0], self._wrapped(exact, width, not_(zero))))
        return self.symbol(self._wrapped(self._exact(name, terms), width))

    def _exact(self, name: str, terms: Sequence[T]) -> T:
        """Return an integer result that is not wrapped to a width."""
        if name not in WHOLE:
            raise UnmodeledError(f"{name} of integers")
        return WHOLE[name](*terms)

    def _wrapped(self, exact: T, width: int, guard: T = TRUE) -> T:
        """Return the low bits of a result; if bits are lost, record an overflow where the guard is true."""
        result = wrap(exact, width)
        self.overflow_if(and_(guard, not_(eq(result, exact))))
        return result

    def _calculated_real(self, name: str, values: Sequence[Any], kind: str) -> T:
        """Return a float result; record a zero divisor, and an infinite result of finite operands."""
        terms = [term_of(value, kind) for value in values]
        if name in ("/", "MOD"):
            self.fault_log.zero_divisor_if(not_(truth_of(terms[1])))  # type: ignore[attr-defined]
        result = self._real(name, terms, kind)
        if name not in ("NEG", "ABS"):
            finite = all_of(map(is_finite, terms))
            self.overflow_if(and_(finite, not_(is_finite(result))))
        return result

    def _real(self, name: str, terms: Sequence[T], kind: str) -> T:
        """Return a float result, or an unknown value if the operation is in `UNKNOWN`."""
        if name in REAL:
            return REAL[name](*terms)
        if name in FACTORS:
            product = fop("fmul", to_float(terms[0], F64), const(FACTORS[name], F64))
            return to_float(product, kind)
        if name in UNKNOWN:
            return self.computed(name, (kind, 0, 0), *terms)
        raise UnmodeledError(f"{name} of floating-point numbers")

    def overflow_if(self, t: T) -> None:
        """Record an overflow where a condition is true."""
        self.fault_log.overflow_if(t)  # type: ignore[attr-defined]

    def store(self, place: Place, value: Any) -> None:
        """Convert a value to the type of a place and store it."""
        kind = place.type
        if kind.is_bool:
            self.put(place, self.truth(value))
            return
        if not isinstance(value, TermSymbol):
            super().store(place, value)
            return
        stored = self.symbol(self._stored(value.t, kind))
        self.put(place, stored)
        self.set_flags(stored)

    def _stored(self, t: T, kind: Elementary) -> T:
        """Return a value converted to a type; record an overflow if it does not fit."""
        if kind.is_real or kind.is_double:
            stored = to_float(t, F32 if kind.is_real else F64)
            if kind.is_real and t.kind == F64:
                self.overflow_if(and_(not_(is_finite(stored)), is_finite(t)))
            return stored
        if t.kind not in FLOATS:
            return self._wrapped(whole_of(t), kind.wraps)
        stored, lost = self._rounded_to(t, kind)
        self.overflow_if(lost)
        return stored

    def _rounded_to(self, t: T, kind: Elementary) -> tuple[T, T]:
        """Return a float as an integer of a type, and whether it fails to fit.

        The low bits of a large REAL are 0. The low bits of a large LREAL are unknown, and so are the upper
        bits of a large REAL as a LINT.
        """
        exact = to_int(t, "rne")
        rounded = wrap(exact, kind.wraps)
        big = is_large(t)
        lost = or_(big, not_(eq(rounded, exact)))
        if t.kind == F64 or kind.bits > 32:
            far = and_(big, is_finite(t))
            rounded = ite(far, self.computed("rounded", kind_of(kind), t), rounded)
            lost = ite(far, self.computed(("lost", kind_of(kind)), (BOOL, 0, 0), t), lost)
        return rounded, lost

    def _cut(self, t: T) -> T:
        """Return a float without its fraction, as a whole number; the result is unknown for a large float."""
        far = and_(is_large(t), is_finite(t))
        cut = self.computed("cut", (INT, -_LARGEST[t.kind], _LARGEST[t.kind]), t)
        return ite(far, cut, to_int(t, "rtz"))

    # --- comparisons and texts

    def text(self, operand: Resolved) -> Any:
        """Return the characters of a string."""
        if not isinstance(operand, Group):
            return super().text(operand)
        store, data, counter, array_index = self._string_leaves(operand)
        room: int = data.dims[-1]
        codes = [term_of(store.read(data, array_index * room + number), INT) for number in range(room)]
        length = clip(term_of(store.read(counter, array_index), INT), 0, room)
        return TermText(self.symbol, length, [bitop("band", code, const(0xFF)) for code in codes])

    def set_text(self, target: Group, value: Any) -> None:
        """Set a string to characters that are truncated to its size and padded with 0."""
        store, data, counter, array_index = self._string_leaves(target)
        room: int = data.dims[-1]
        text = TermText.of(self.symbol, value)
        length = least(text.length, room)
        store.write(counter, array_index, self.symbol(length))
        for number in range(room):
            code = ite(lt(const(number), length), wrap(text.at(number), data.type.wraps), const(0))
            store.write(data, array_index * room + number, self.symbol(code))

    def _string_leaves(self, string: Group) -> tuple[Any, Leaf, Leaf, Any]:
        """Return the store of a string, the leaves of its DATA and LEN, and its index."""
        store, layout, path, array_index = self.string(string)
        return store, layout.leaf(f"{path}.DATA"), layout.leaf(f"{path}.LEN"), array_index

    def characters(self, name: str) -> Callable[..., Any]:
        """Return the function that a string instruction computes."""
        if name == "DTOS":
            return lambda _faults, _site, value: digits(self.symbol, self._nearest(value))
        if name == "STOD":
            return self._stod
        return super().characters(name)

    def _stod(self, _faults: Any, _site: int, text: Any, kind: Elementary, name: str) -> Any:
        """Return the first integer in a string as a value of a type; None for an empty string."""
        if not text:
            return None
        text = TermText.of(self.symbol, text)
        exact, is_exact = number_in(text)
        if kind.is_integer:
            stored = term_of(self.converted(kind, self.symbol(exact)), INT)
            fit = and_(is_exact, eq(stored, exact))
        else:
            stored, fit = to_float(to_float(exact, F64), kind_of(kind)[0]), is_exact
        far = self.computed("number in a text", kind_of(kind), text.length, *text.codes)
        stored = ite(is_exact, stored, far)
        if not self.paths.decide(fit):
            self.fault_log.record(self.site, name, STRING_NUMBER_CODE)
        return self.symbol(stored)

    def bytes_of(self, value: Any, size: int) -> Any:
        """Return the low bytes of an integer, lowest first, padded with 0."""
        if not isinstance(value, TermSymbol):
            return super().bytes_of(value, size)
        term = term_of(value, INT)
        return [
            *(Byte(term, place) for place in range(min(8, size))),
            *(Byte(const(0)) for _ in range(size - 8)),
        ]

    def integer_in(self, data: Any) -> Any:
        """Return the unsigned integer in bytes, lowest first."""
        if isinstance(data, bytes):
            return super().integer_in(data)
        data = [*data, *constant_bytes(bytes(8 - len(data)))]
        return self.symbol(unpack(data, 0, Field("", ULINT, 0), self))

    def _nearest(self, value: Any) -> Any:
        """Return a whole number unchanged; refuse a float, whose text has no term."""
        if self.is_float(value):
            raise UnmodeledError("the text of a floating-point number")
        return value

    def condition(self, condition: Resolved) -> Any:
        """Return the value of a condition, with no short-circuit evaluation."""
        if not isinstance(condition, Calculation):
            return super().condition(condition)
        if condition.name in RELATIONS and not any(map(is_truth, condition.operands)):
            return self.compare(condition.name, *condition.operands)
        terms = [term_of(self.condition(operand), BOOL) for operand in condition.operands]
        return self.symbol(TRUTH[condition.name](*terms))
