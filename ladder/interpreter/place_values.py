"""Reading, writing, computing, comparing and converting values in the interpreter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..model import arithmetic
from ..model.operands import (
    SINGLE,
    Calculation,
    Constant,
    Group,
    Place,
    Resolved,
    StringConstant,
    is_truth,
    place_of,
    width_of,
)
from ..model.operators import BITWISE, FUNCTIONS, RELATIONS
from ..model.tags import Layout, Leaf
from ..model.types import DINT, Elementary
from ..state.characters import FUNCTIONS as CHARACTERS
from ..state.fault_log import FaultLog
from ..state.lowered import LoweredProgram
from ..state.memory import Memory, Store, Value, set_text_in, text_in
from ..state.regions import ArrayRegion, End, converted, copy, fill, put, region_of, take

MOST_REGIONS = 1 << 16
"""Maximum number of cached regions of operands."""


class PlaceValues:
    """Reads, writes and computes a program's values; `frame` maps `Leaf.root` to an argument's store."""

    def __init__(self, lowered: LoweredProgram, memory: Memory, fault_log: FaultLog) -> None:
        self.lowered, self.memory, self.fault_log = lowered, memory, fault_log
        self.site = 0
        self.now_ns = 0
        self.frame: Mapping[str, Store] = {}
        self._regions: dict[int, tuple[Resolved, ArrayRegion]] = {}

    def store_of(self, root: str) -> Store:
        """Return the store of an operand by `Leaf.root`: the memory or an argument."""
        return self.frame[root] if root else self.memory

    def status(self, path: str) -> Value:
        """Return a status tag, such as `S:V`."""
        return self.memory.read(self.memory.layout.leaf(path))

    def set_status(self, path: str, value: Value) -> None:
        """Set a status tag."""
        self.memory.write(self.memory.layout.leaf(path), 0, value)

    def _index(self, place: Place) -> int:
        """Return the index of a place in its leaf; fault if a subscript is out of range."""
        if not place.indices:
            return 0
        flat = 0
        for index, length in zip(place.indices, self.dims_of(place.leaf), strict=True):
            flat = flat * length + self.subscript(index, length, place.text)
        return flat

    def dims_of(self, leaf: Leaf) -> tuple[int, ...]:
        """Return the dimensions of a leaf; an array argument has the length of its remaining elements."""
        if leaf.outer != 1:
            return leaf.dims
        return (self.frame[leaf.root].left, *leaf.dims[1:])

    def subscript(self, index: Resolved, length: int, tag: str) -> int:
        """Return a subscript or bit number below `length`, or fault."""
        value = self.integer(index)
        if not 0 <= value < length:
            self.fault_log.subscript(self.site, tag, value, length)
        return value

    def get(self, place: Place) -> Value:
        """Return the value of a place."""
        value = self.store_of(place.leaf.root).read(place.leaf, self._index(place))
        if place.bit is None:
            return value
        bit = self.subscript(place.bit, place.leaf.type.bits, place.text)
        return bool(int(value) >> bit & 1)

    def put(self, place: Place, value: Value) -> None:
        """Set a place to a value of its type."""
        index = self._index(place)
        store = self.store_of(place.leaf.root)
        if place.bit is not None:
            bits = place.leaf.type.bits
            mask = 1 << self.subscript(place.bit, bits, place.text)
            word = int(store.read(place.leaf, index))
            value = arithmetic.wrap(word | mask if value else word & ~mask, place.leaf.type.wraps)
        store.write(place.leaf, index, value)

    def whole(self, value: Value) -> int:
        """Return a number truncated to an integer, or a truth value as 0 or 1."""
        return int(value)

    def truth(self, value: Value) -> bool:
        """Return whether a value is not 0."""
        return bool(value)

    def is_float(self, value: Value) -> bool:
        """Return whether a number is REAL or LREAL."""
        return isinstance(value, float)

    def is_infinite(self, value: Value) -> bool:
        """Return whether a number is infinite."""
        return math.isinf(value)

    def is_nan(self, value: Value) -> bool:
        """Return whether a number is NaN."""
        return math.isnan(value)

    def infinity(self, value: Value) -> float:
        """Return infinity with the sign of a number, including the sign of zero or NaN."""
        return math.copysign(math.inf, value)

    def truncated(self, value: float) -> int:
        """Return a float without its fraction; 0 for infinity and NaN."""
        return arithmetic.truncated(value)

    def least(self, value: int, most: int) -> int:
        """Return the smaller of a number and a limit."""
        return min(value, most)

    def chosen(self, truth: Value, if_true: Value, if_false: Value) -> Value:
        """Return `if_true` or `if_false`, according to a truth value."""
        return if_true if truth else if_false

    def converted(self, kind: Elementary, value: Value) -> Value:
        """Return a number converted to a type, without flags and faults."""
        return converted(kind, value)

    def copy(self, source: End, target: End, length: int) -> None:
        """Copy bytes for `length` elements of the target, up to the end of either array."""
        copy(source, target, length)

    def fill(self, target: End, length: int, value: Value) -> None:
        """Set each member of the elements to a value, up to the end of the array."""
        fill(target, length, value)

    def take_bytes(self, store: Store, region: ArrayRegion, first: int, count: int) -> bytes:
        """Return elements as bytes."""
        return take(store, region, first, count)

    def put_bytes(self, store: Store, region: ArrayRegion, first: int, count: int, data: bytes) -> None:
        """Set elements from bytes."""
        put(store, region, first, count, data)

    def bytes_of(self, value: int, size: int) -> bytes:
        """Return the low bytes of an integer, lowest first, padded with 0."""
        low = (value & (1 << 64) - 1).to_bytes(8, "little")
        return low.ljust(size, b"\0")[:size]

    def integer_in(self, data: bytes) -> int:
        """Return the unsigned integer in bytes, lowest first."""
        return int.from_bytes(data, "little")

    def start_clock(self, since: Place) -> None:
        """Set a hidden place to the current instant."""
        self.put(since, self.now_ns)

    def elapsed(self, since: Place, unit_ns: int) -> int:
        """Return the whole units of time since the instant in a hidden place; advance the instant by them."""
        last = int(self.get(since))
        units = (self.now_ns - last) // unit_ns
        self.put(since, last + units * unit_ns)
        return units

    def integer(self, operand: Resolved) -> int:
        """Return the value of an integer operand."""
        return self.whole(self.number(operand, DINT.bits))

    def number(self, operand: Resolved, width: int) -> Value:
        """Return the value of an expression, computed in integers of a width, or in SINGLE or DOUBLE."""
        if isinstance(operand, Calculation):
            if is_truth(operand):
                return self.rounded(self.whole(self.condition(operand)), width)
            if width <= 0 and operand.name in BITWISE:
                return self.rounded(self.number(operand, width_of(operand)), width)
            values = [self.number(inner, width) for inner in operand.operands]
            return self._calculate(operand.name, values, width)
        value = operand.value if isinstance(operand, Constant) else self.get(place_of(operand))
        return value if width > 0 else self.rounded(value, width)

    def rounded(self, value: Value, width: int) -> Value:
        """Return a number rounded to SINGLE or DOUBLE; an integer width does not change it."""
        if width > 0:
            return value
        return arithmetic.real(value) if width == SINGLE else float(value)

    def _calculate(self, name: str, values: Sequence[Any], width: int) -> Value:
        """Return the result of an operator in a width.

        A zero divisor is a minor fault, and the dividend is returned. An overflow is also a minor fault, and
        wraps.
        """
        if width <= 0:
            return self._calculate_real(name, values, width)
        if name in ("/", "MOD") and values[1] == 0:
            self.fault_log.zero_divisor(self.site)
            return values[0]  # type: ignore[no-any-return]
        exact = _WHOLE[name](*values)
        result = arithmetic.wrap(exact, width)
        if result != exact:
            self.fault_log.overflow(self.site)
        return result

    def _calculate_real(self, name: str, values: Sequence[Any], width: int) -> float:
        """Return the result of an operator in SINGLE or DOUBLE.

        A zero divisor is a minor fault, and so is an infinite or undefined result of finite operands.
        """
        if name in ("/", "MOD") and values[1] == 0:
            self.fault_log.zero_divisor(self.site)
        exact = _REAL[name](*values)
        result = arithmetic.real(exact) if width == SINGLE else float(exact)
        if not arithmetic.finite(result) and all(map(arithmetic.finite, values)):
            self.fault_log.overflow(self.site)
        return result

    def store(self, place: Place, value: Value) -> None:
        """Convert a value to the type of a place and store it there.

        Record a minor fault if it does not fit, and set the flags from the stored value. A BOOL causes no
        fault and sets no flags.
        """
        kind = place.type
        if kind.is_bool:
            self.put(place, bool(value))
            return
        if kind.is_real:
            stored: Value = arithmetic.real(value)
            if not arithmetic.finite(stored) and arithmetic.finite(value):
                self.fault_log.overflow(self.site)
        elif kind.is_double:
            stored = float(value)
        else:
            exact = arithmetic.whole(value) if isinstance(value, float) else int(value)
            stored = arithmetic.wrap(exact, kind.wraps)
            if stored != exact or (isinstance(value, float) and not arithmetic.finite(value)):
                self.fault_log.overflow(self.site)
        self.put(place, stored)
        self.set_flags(stored)

    def clear_flags(self) -> None:
        """Clear S:V and S:C if the program uses status flags."""
        if self.lowered.flags:
            self.set_status("S:V", False)
            self.set_status("S:C", False)

    def set_flags(self, stored: Value) -> None:
        """Set S:Z and S:N from a result if the program uses status flags."""
        if self.lowered.flags:
            self.set_status("S:Z", stored == 0)
            self.set_status("S:N", stored < 0)

    def compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        """Store the result of an operator, and its carry in S:C."""
        self.clear_flags()
        expression = Calculation(name, operands)
        width = width_of(expression, target)
        if self.lowered.flags and width > 0:
            self.set_status("S:C", self._carry(name, operands, width))
        self.store(target, self.number(expression, width))

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> bool:
        """Return whether S:C is set: by a carry of +, a borrow of -, or NEG of a nonzero number."""
        if name not in ("+", "-", "NEG"):
            return False
        mask = (1 << width) - 1
        values = [self.whole(self.number(operand, width)) & mask for operand in operands]
        if name == "+":
            return values[0] + values[1] > mask
        return values[0] < values[1] if name == "-" else values[0] != 0

    # --- comparing

    def compare(self, relation: str, a: Resolved, b: Resolved) -> bool:
        """Compare numbers, or the characters of strings."""
        if isinstance(a, (Group, StringConstant)):
            return COMPARISONS[relation](self.text(a), self.text(b))
        width = width_of(a, b)
        left, right = self.number(a, width), self.number(b, width)
        return COMPARISONS[relation](left, right)

    def text(self, operand: Resolved) -> bytes:
        """Return the characters of a string."""
        if isinstance(operand, StringConstant):
            return operand.value.encode("latin-1", errors="replace")
        assert isinstance(operand, Group)
        return text_in(*self.string(operand))

    def set_text(self, target: Group, value: bytes) -> None:
        """Set a string to characters, truncated to its size."""
        set_text_in(*self.string(target), value)

    def characters(self, name: str) -> Callable[..., Any]:
        """Return the function that computes a string instruction."""
        return CHARACTERS[name]

    def string(self, operand: Group) -> tuple[Store, Layout, str, int]:
        """Return the location of a string as its store, layout, path and index."""
        length = operand.length
        return self.store_of(length.leaf.root), operand.layout, operand.path, self._index(length)

    def end(self, operand: Resolved) -> End:
        """Return the store, region and current first element of an operand."""
        region = self._region(operand)
        if region.fixed_first is not None and not region.root:
            return self.memory, region, region.fixed_first
        store = self.store_of(region.root)
        dims = region.dims
        if dims and region.parts[0].leaf.outer == 1:
            dims = (store.left, *dims[1:])
        return store, region, region.first(lambda i, n: self.subscript(i, n, region.text), dims)

    def _region(self, operand: Resolved) -> ArrayRegion:
        """Return the region of an operand; it is cached by the operand's identity."""
        cached_operand, region = self._regions.get(id(operand), (None, None))
        if region is None or cached_operand is not operand:  # an id may be used again
            if len(self._regions) >= MOST_REGIONS:
                self._regions.clear()  # drops operands that are used once
            region = region_of(operand)
            self._regions[id(operand)] = operand, region
        return region

    def condition(self, condition: Resolved) -> bool:
        """Return the value of a condition, with no short-circuit evaluation."""
        if isinstance(condition, (Place, Constant)):
            return self.truth(self.get(condition) if isinstance(condition, Place) else condition.value)
        assert isinstance(condition, Calculation)
        if condition.name in RELATIONS and not any(map(is_truth, condition.operands)):
            return self.compare(condition.name, *condition.operands)
        values = [self.condition(operand) for operand in condition.operands]
        return _TRUTH[condition.name](*values)

    def filled(self, operand: Resolved) -> int:
        """Return an integer, zero-extended."""
        assert isinstance(operand, (Place, Constant))
        return self.integer(operand) & (1 << operand.type.bits) - 1

    def store_bits(self, target: Place, value: int) -> None:
        """Set an integer to the low bits of a pattern, without overflow."""
        self.clear_flags()
        stored = arithmetic.wrap(value, target.type.wraps)
        self.put(target, stored)
        self.set_flags(stored)


COMPARISONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
"""Functions that compare numbers, by operator symbol."""

_TRUTH: Mapping[str, Callable[..., bool]] = {
    **COMPARISONS,
    "AND": lambda a, b: a and b,
    "OR": lambda a, b: a or b,
    "XOR": lambda a, b: a != b,
    "NOT": lambda a: not a,
}

_WHOLE: Mapping[str, Callable[..., int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": arithmetic.quotient,
    "MOD": arithmetic.remainder,
    "**": lambda a, b: arithmetic.truncated(arithmetic.power(float(a), float(b))),
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
    "NOT": lambda a: ~a,
    "NEG": lambda a: -a,
    **{name: function.whole for name, function in FUNCTIONS.items() if function.whole is not None},
}

_REAL: Mapping[str, Callable[..., float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": arithmetic.real_quotient,
    "MOD": arithmetic.real_remainder,
    "**": arithmetic.power,
    "NEG": lambda a: -a,
    **{name: function.real for name, function in FUNCTIONS.items()},
}
