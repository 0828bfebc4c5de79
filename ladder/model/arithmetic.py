"""Logix arithmetic as pure functions on Python numbers: conversion, rounding, wrapping, division.

| conversion | rule | source |
|---|---|---|
| REAL to integer | to the nearest, half to even; upper bits are dropped | 1756-RM003N p. 653 |
| integer to a smaller one | low bits are kept: 65,665 as INT is 129, as SINT -127 | 1756-RM006K p. 544 |
| anything to REAL | rounded to single precision, half to even | 1756-RM003N p. 652 |
| anything to LREAL | rounded to double precision, half to even | as for REAL |

Functions on floating-point numbers compute in double precision. A computation in REAL rounds each result with
`real`; one in LREAL does not round.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

_SINGLE = struct.Struct("<f")
_pack, _unpack = _SINGLE.pack, _SINGLE.unpack


def real(value: float) -> float:
    """Round to single precision; a value that is too large becomes infinite.

    >>> real(0.1), real(1e39), real(16_777_217)
    (0.10000000149011612, inf, 16777216.0)
    """
    try:
        return _unpack(_pack(value))[0]  # type: ignore[no-any-return]
    except (OverflowError, struct.error):  # the value exceeds single precision, or any float
        return math.inf if value > 0 else -math.inf


def wrap(value: int, bits: int) -> int:
    """Keep the low bits as a signed number, or as an unsigned one if `bits` is negative.

    >>> wrap(65_665, 16), wrap(65_665, 8), wrap(2**31, 32), wrap(-1, -16)
    (129, -127, -2147483648, 65535)
    """
    if bits < 0:
        return value & (1 << -bits) - 1
    half = 1 << bits - 1
    return ((value + half) & (half + half - 1)) - half


finite, root = math.isfinite, math.sqrt


def whole(value: float) -> int:
    """Round to the nearest integer, half to even; return 0 for infinity and NaN.

    >>> [whole(x) for x in (2.5, 1.5, -1.5, -2.5, 1.4, -1.6)]
    [2, 2, -2, -2, 1, -2]
    """
    return round(value) if math.isfinite(value) else 0


def quotient(a: int, b: int) -> int:
    """Divide integers, truncating toward zero; b is not 0.

    >>> quotient(7, 2), quotient(-7, 2), quotient(7, -2)
    (3, -3, -3)
    """
    magnitude = abs(a) // abs(b)
    return magnitude if (a < 0) == (b < 0) else -magnitude


def remainder(a: int, b: int) -> int:
    """Return the remainder of a division, with the sign of a; b is not 0 [1756-RM003N p. 281].

    >>> remainder(7, 3), remainder(-7, 3), remainder(7, -3)
    (1, -1, 1)
    """
    return a - quotient(a, b) * b


def real_remainder(a: float, b: float) -> float:
    """Return the remainder of a floating-point division; NaN where it is undefined.

    >>> real_remainder(-7.5, 2.0)
    -1.5
    """
    if not math.isfinite(a) or math.isnan(b) or b == 0:
        return math.nan
    return math.fmod(a, b)


def real_quotient(a: float, b: float) -> float:
    """Divide floating-point values; infinite for a divisor of 0, NaN for 0/0."""
    if b == 0:
        if a == 0 or math.isnan(a):
            return math.nan
        return math.copysign(math.inf, a) * math.copysign(1.0, b)
    return a / b


def power(a: float, b: float) -> float:
    """Raise a to the power b; NaN if undefined, infinite if too large.

    >>> power(-1e200, 3.0), power(0.0, -1.0), power(-8.0, 0.5)
    (-inf, inf, nan)
    """
    try:
        result = a**b
    except ZeroDivisionError:
        return math.inf
    except OverflowError:
        return -math.inf if a < 0 and math.fmod(b, 2.0) else math.inf
    return math.nan if isinstance(result, complex) else result


def square_root(value: float) -> float:
    """Return the square root of the absolute value [1756-RM003N p. 284]."""
    return math.sqrt(abs(value))


def integer_root(value: int) -> int:
    """Return the truncated square root of an integer's absolute value."""
    return math.isqrt(abs(value))


MOST_DECIMAL = 10**8
"""The lowest number that does not fit into the eight BCD digits of a DINT."""


def to_digits(value: int) -> int:
    """Convert a number >= 0 to binary coded decimal."""
    return int(str(value), 16)


def from_digits(pattern: int) -> int:
    """Convert binary coded decimal to a number; a digit above 9 counts as its hexadecimal value.

    >>> from_digits(0x1254), from_digits(0x1A)
    (1254, 20)
    """
    value, weight = 0, 1
    while pattern:
        value += (pattern & 0xF) * weight
        pattern, weight = pattern >> 4, weight * 10
    return value


def decimal(value: int) -> int:
    """Return TOD in an expression: the last eight digits in BCD; 0 for a negative number.

    >>> hex(decimal(1254)), hex(decimal(123_456_789)), decimal(-1)
    ('0x1254', '0x23456789', 0)
    """
    return to_digits(value % MOST_DECIMAL) if value > 0 else 0


def real_decimal(value: float) -> float:
    """Return TOD of a REAL, without its fraction; 0 for infinity and NaN."""
    return float(decimal(int(value))) if math.isfinite(value) else 0.0


def from_decimal(value: int) -> int:
    """Return FRD in an expression, computed in 32 bits.

    >>> from_decimal(0x1254), from_decimal(-1)
    (1254, 166666665)
    """
    return from_digits(value & 0xFFFF_FFFF)


def real_from_decimal(value: float) -> float:
    """Return FRD of a REAL, without its fraction; 0 for infinity and NaN."""
    return float(from_decimal(int(value))) if math.isfinite(value) else 0.0


def _or_nan(function: Callable[[float], float], at_zero: float | None = None) -> Callable[[float], float]:
    """Wrap a function to return NaN where it is undefined, and `at_zero` at 0 unless that is None."""

    def compute(value: float) -> float:
        if value == 0 and at_zero is not None:
            return at_zero
        try:
            return function(value)
        except ValueError:
            return math.nan

    compute.__name__ = function.__name__
    return compute


sine, cosine, tangent = map(_or_nan, (math.sin, math.cos, math.tan))
arc_sine, arc_cosine, arc_tangent = map(_or_nan, (math.asin, math.acos, math.atan))
natural_log, common_log = _or_nan(math.log, -math.inf), _or_nan(math.log10, -math.inf)
"""Trigonometric functions use radians; logarithms are -inf at 0.

>>> natural_log(1.0), natural_log(0.0), natural_log(-1.0), common_log(1000.0)
(0.0, -inf, nan, 3.0)
"""


def degrees(value: float) -> float:
    """Convert radians to degrees."""
    return value * (180 / math.pi)


def radians(value: float) -> float:
    """Convert degrees to radians."""
    return value * (math.pi / 180)


def truncated(value: float) -> int:
    """Truncate to an integer; return 0 for infinity and NaN.

    >>> truncated(-357.06)
    -357
    """
    return math.trunc(value) if math.isfinite(value) else 0


def real_truncated(value: float) -> float:
    """Truncate a floating-point value."""
    return float(truncated(value))


def swapped(value: int, bits: int, mode: str) -> int:
    """Reorder the bytes of an INT or DINT; any mode swaps the two bytes of an INT.

    >>> [hex(swapped(0x41424344, 32, mode)) for mode in ("REVERSE", "WORD", "HIGH/LOW")]
    ['0x44434241', '0x43444142', '0x42414443']
    >>> hex(swapped(0x4142, 16, "WORD"))
    '0x4241'
    """
    order = _ORDERS.get(mode, _REVERSED) if bits == 32 else (1, 0)
    moved = sum((value >> 8 * source & 0xFF) << 8 * target for target, source in enumerate(order))
    return wrap(moved, bits)


_REVERSED = (3, 2, 1, 0)
_ORDERS = {"REVERSE": _REVERSED, "WORD": (2, 3, 0, 1), "HIGH/LOW": (1, 0, 3, 2)}
"""For each byte of a result, lowest first, the number of the source byte."""


def distributed(source: int, source_bit: int, target: int, target_bit: int, length: int, bits: int) -> int:
    """Copy a field of bits into a number; bits beyond its width are lost [1756-RM003N p. 303].

    >>> bin(distributed(0b1100, 2, 0, 6, 4, 8) & 0xFF)
    '0b11000000'
    """
    field = (1 << length) - 1
    moved = (source >> source_bit & field) << target_bit
    return wrap(target & ~(field << target_bit) | moved, bits)


# --- scaling


def scaled(value: float, low: float, high: float, least: float, most: float) -> float:
    """Scale linearly from low .. high to least .. most; a span of 0 leaves the value unchanged.

    >>> scaled(5.0, 0.0, 10.0, 100.0, 200.0), scaled(5.0, 1.0, 1.0, 0.0, 9.0)
    (150.0, 5.0)
    """
    return value if low == high else least + (value - low) * (most - least) / (high - low)


def percent(value: float, low: float, high: float) -> float:
    """Return a number as a percentage of a span; a span of 0 leaves the number unchanged."""
    span = high - low
    return value * 100 / span if span else value
