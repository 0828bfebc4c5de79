"""Arithmetic on integers of 16 and 32 bits and on floats [1747-RM001, chapter "Math instructions"].

A result that does not fit becomes the nearest limit, 32,767 or -32,768. If S:2/14 is set, its low bits are
kept instead. Both cases set S:0/1 and the trap S:5/0. Quotients and floating point results are rounded to the
nearest integer, halves away from zero. Logic instructions set zero and sign, and clear carry and overflow.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ...interpreter import Interpreter
from ...interpreter.files import Elements
from ...model.arithmetic import wrap
from ...model.operands import DOUBLE, Place, Resolved, is_integer
from ...model.types import LINT
from .status import Status

_WIDE = LINT.bits


def rounded(machine: Interpreter, value: float) -> int:
    """Round to the nearest integer, halves away from zero."""
    whole = machine.whole(value)
    if value == whole:
        return whole
    return machine.whole(value + 0.5 if value >= 0 else value - 0.5)


def quotient(a: int, b: int) -> int:
    """Divide and round to the nearest integer, halves away from zero.

    >>> quotient(7, 2), quotient(-7, 2), quotient(7, 3)
    (4, -4, 2)
    """
    size = (2 * abs(a) + abs(b)) // (2 * abs(b))
    return size if (a < 0) == (b < 0) else -size


def store(machine: Interpreter, target: Place, value: float, *, carry: bool = False) -> None:
    """Store a result and set the flags.

    For an integer, NaN becomes 0, and a result that does not fit becomes the nearest limit, or with S:2/14
    its low bits.
    """
    status, kind = Status(machine), target.type
    if not kind.is_integer:
        stored = machine.converted(kind, value)
        machine.put(target, stored)
        finite = not (machine.is_infinite(value) or machine.is_nan(value))
        status.set_flags(stored, overflow=finite and machine.is_infinite(stored))
        return
    if machine.is_nan(value):
        value = 0
    elif machine.is_infinite(value):
        value = kind.highest + 1 if value > 0 else kind.lowest - 1
    exact = rounded(machine, value)
    fits = kind.lowest <= exact <= kind.highest
    if not fits:
        limit = kind.highest if exact > 0 else kind.lowest
        exact = wrap(exact, kind.bits) if status.keeps_low_bits else limit
    machine.put(target, exact)
    status.set_flags(exact, carry=carry, overflow=not fits)


def store_bits(machine: Interpreter, target: Place, value: int) -> None:
    """Store the result of a move or a logic instruction, which always fits."""
    stored = wrap(value, target.type.bits)
    machine.put(target, stored)
    Status(machine).set_flags(stored)


def number(machine: Interpreter, operand: Resolved) -> float:
    """Return the value of an operand as an exact integer or a floating-point number."""
    return machine.number(operand, _WIDE if is_integer(operand) else DOUBLE)


def _low(machine: Interpreter, value: float) -> int:
    """Return the low 16 bits of an integer."""
    return machine.whole(value) & 0xFFFF


def _is_whole(*operands: Resolved) -> bool:
    return all(map(is_integer, operands))


# --- two operands


def add(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
    """Run ADD; the carry is from bit 15."""
    x, y = number(machine, a), number(machine, b)
    whole = _is_whole(a, b, target)
    store(machine, target, x + y, carry=whole and _low(machine, x) + _low(machine, y) > 0xFFFF)


def subtract(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
    """Run SUB; the carry is the borrow."""
    x, y = number(machine, a), number(machine, b)
    whole = _is_whole(a, b, target)
    store(machine, target, x - y, carry=whole and _low(machine, x) < _low(machine, y))


def multiply(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
    """Run MUL; the full product is stored in the math register."""
    value = number(machine, a) * number(machine, b)
    if _is_whole(a, b):
        Status(machine).register = machine.whole(value)
    store(machine, target, value)


def divide(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
    """Run DIV: store the rounded quotient in the target, the truncated one in S:14, the remainder in S:13."""
    x, y = number(machine, a), number(machine, b)
    if y == 0:
        store(machine, target, machine.infinity(x))
    elif _is_whole(a, b):
        _whole_quotient(machine, machine.whole(x), machine.whole(y), target)
    else:
        store(machine, target, x / y)


def divide_double(machine: Interpreter, a: Resolved, target: Place) -> None:
    """Run DDV: divide the math register by a number."""
    divisor = machine.whole(number(machine, a))
    dividend = Status(machine).register
    if divisor == 0:
        store(machine, target, machine.infinity(dividend))
    else:
        _whole_quotient(machine, dividend, divisor, target)


def _whole_quotient(machine: Interpreter, x: int, y: int, target: Place) -> None:
    """Store the rounded quotient in the target, the truncated one in S:14, and the remainder in S:13."""
    status = Status(machine)
    truncated = abs(x) // abs(y) * (1 if (x < 0) == (y < 0) else -1)
    status[14], status[13] = truncated, x - truncated * y
    store(machine, target, quotient(x, y))


def power(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
    """Run XPY; a result that is not a real number is an overflow."""
    try:
        value = float(number(machine, a)) ** float(number(machine, b))
    except (OverflowError, ZeroDivisionError):
        value = math.inf
    store(machine, target, value if isinstance(value, float) else math.inf)


# --- one operand


def one_source(function: Callable[[float], float]) -> Callable[[Interpreter, Resolved, Place], None]:
    """Return the executor of an instruction that stores a function of its source."""

    def run(machine: Interpreter, source: Resolved, target: Place) -> None:
        """Store the function of the source, or infinity if it is undefined, which is an overflow."""
        try:
            value = function(number(machine, source))
        except (ValueError, OverflowError, ZeroDivisionError):
            value = math.inf
        store(machine, target, value)

    return run


def negate(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run NEG; the carry is set unless the result is zero or does not fit."""
    value = -number(machine, source)
    kind = target.type
    fits = not kind.is_integer or kind.lowest <= value <= kind.highest
    store(machine, target, value, carry=fits and value != 0)


def move(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run MOV."""
    store(machine, target, number(machine, source))


def clear(machine: Interpreter, target: Place) -> None:
    """Run CLR."""
    store(machine, target, 0)


def compute(machine: Interpreter, target: Place, expression: Resolved) -> None:
    """Run CPT: compute integers in 64 bits, other values in double precision, and round at the end."""
    store(machine, target, number(machine, expression))


def masked_move(machine: Interpreter, source: Resolved, mask: Resolved, target: Place) -> None:
    """Run MVM."""
    mask_bits = machine.whole(number(machine, mask))
    old_value = machine.whole(machine.get(target))
    store_bits(machine, target, old_value & ~mask_bits | machine.whole(number(machine, source)) & mask_bits)


def logic(function: Callable[[int, int], int]) -> Callable[[Interpreter, Resolved, Resolved, Place], None]:
    """Return the executor of an instruction that combines the bits of two integers."""

    def run(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
        left, right = (machine.whole(number(machine, operand)) for operand in (a, b))
        store_bits(machine, target, function(left, right))

    return run


def invert(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run NOT."""
    store_bits(machine, target, ~machine.whole(number(machine, source)))


def swap(machine: Interpreter, first: Resolved, length: Resolved) -> None:
    """Run SWP: exchange the bytes of words."""
    words = Elements(machine, first)
    for index in range(min(machine.integer(length), len(words))):
        value = machine.whole(words[index]) & 0xFFFF
        words[index] = wrap(value << 8 | value >> 8, 16)


# --- scaling


def scale(machine: Interpreter, source: Resolved, rate: Resolved, offset: Resolved, target: Place) -> None:
    """Run SCL: multiply the source by rate / 10,000, round, and add the offset."""
    product = number(machine, source) * number(machine, rate)
    if _is_whole(source, rate):
        scaled = quotient(machine.whole(product), 10_000)
    else:
        scaled = rounded(machine, product / 10_000)
    store(machine, target, scaled + number(machine, offset))


def scale_with_parameters(machine: Interpreter, *operands: Resolved) -> None:
    """Run SCP: scale on the line through two points; an integer destination is rounded."""
    *sources, target = operands
    value, low, high, first, last = (number(machine, source) for source in sources)
    assert isinstance(target, Place)
    if high == low:
        store(machine, target, math.inf)
        return
    if _is_whole(*sources, target):
        product, span = machine.whole((value - low) * (last - first)), machine.whole(high - low)
        store(machine, target, quotient(product, span) + first)
        return
    store(machine, target, (value - low) * (last - first) / (high - low) + first)


# --- decimal


def to_decimal(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run TOD for four digits; a larger or negative number is an overflow."""
    value = machine.whole(number(machine, source))
    fits = 0 <= value <= 9_999
    all_digits = _digits(machine.least(abs(value), 32_768))
    stored = all_digits if fits else 0x9999
    machine.put(target, wrap(stored, target.type.bits))
    Status(machine).set_flags(stored, overflow=not fits)
    Status(machine).register = all_digits


def _digits(value: int) -> int:
    """Return up to five decimal digits as BCD, four bits each."""
    return sum(value // weight % 10 << 4 * place for place, weight in enumerate((1, 10, 100, 1000, 10_000)))


def from_decimal(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run FRD for four digits; a digit above 9 is an overflow."""
    pattern = machine.whole(number(machine, source)) & 0xFFFF
    digits = [pattern >> shift & 0xF for shift in (12, 8, 4, 0)]
    value = sum(digit * weight for digit, weight in zip(digits, (1000, 100, 10, 1), strict=True))
    machine.put(target, wrap(value, target.type.bits))
    Status(machine).set_flags(value, overflow=any(digit > 9 for digit in digits))


# --- decoding and encoding bits


def decode(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run DCD: set the bit whose number is in the low four bits of the source."""
    number = machine.integer(source) & 0xF
    machine.put(target, wrap(sum((number == place) << place for place in range(16)), target.type.bits))


def encode(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Run ENC: store the number of the lowest set bit; several set bits are an overflow."""
    bits = machine.integer(source) & 0xFFFF
    lowest = bits & -bits
    value = sum(place * (lowest >> place & 1) for place in range(16))
    machine.put(target, value)
    Status(machine).set_flags(value, overflow=bits != lowest)
