"""What every instruction works with: the values of places, and arithmetic as the manual has it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .. import arithmetic as math
from ..fault_log import FaultLog
from ..instructions import BITWISE
from ..lowered import Lowered
from ..memory import Memory, Value
from ..operands import Calculation, Constant, Place, Resolved, types_in
from ..types import DINT, LINT, REAL


class Values:
    """Reads and writes the places of a program, and computes.

    Args:
        lowered: the program.
        memory: its memory.
        fault_log: collects its faults.
    """

    def __init__(self, lowered: Lowered, memory: Memory, fault_log: FaultLog) -> None:
        self._lowered, self._memory, self._fault_log = lowered, memory, fault_log
        self._site = 0
        self._now = 0

    def _leaf(self, path: str) -> Value:
        return self._memory.read(self._memory.layout.leaf(path))

    def _set_leaf(self, path: str, value: Value) -> None:
        self._memory.write(self._memory.layout.leaf(path), 0, value)

    def _index(self, place: Place) -> int:
        flat = 0
        for index, length in zip(place.indices, place.leaf.dims, strict=True):
            flat = flat * length + self._subscript(index, length, place.text)
        return flat

    def _subscript(self, index: Resolved, length: int, tag: str) -> int:
        value = self._integer(index)
        if not 0 <= value < length:
            self._fault_log.subscript(self._site, tag, value, length)
        return value

    def get(self, place: Place) -> Value:
        """Return the value of a place."""
        value = self._memory.read(place.leaf, self._index(place))
        if place.bit is None:
            return value
        bit = self._subscript(place.bit, place.leaf.type.bits, place.text)
        return bool(int(value) >> bit & 1)

    def put(self, place: Place, value: Value) -> None:
        """Set a place to a value of its type."""
        index = self._index(place)
        if place.bit is not None:
            bits = place.leaf.type.bits
            mask = 1 << self._subscript(place.bit, bits, place.text)
            word = int(self._memory.read(place.leaf, index))
            value = math.wrap(word | mask if value else word & ~mask, bits)
        self._memory.write(place.leaf, index, value)

    def _integer(self, operand: Resolved) -> int:
        return int(self._number(operand, DINT.bits))

    def _number(self, operand: Resolved, width: int) -> Value:
        """Value of an expression, computed in integers of that width or, width 0, in REAL."""
        if isinstance(operand, Calculation):
            if not width and operand.name in BITWISE:
                return math.real(self._number(operand, width_of(operand)))
            values = [self._number(each, width) for each in operand.operands]
            return self._calculate(operand.name, values, width)
        value = operand.value if isinstance(operand, Constant) else self.get(place_of(operand))
        return value if width else math.real(value)

    def _calculate(self, name: str, values: Sequence[Any], width: int) -> Value:
        if width == 0:
            return self._calculate_real(name, values)
        if name in ("/", "MOD") and values[1] == 0:
            self._fault_log.zero_divisor(self._site)
            return values[0]  # type: ignore[no-any-return]
        exact = _WHOLE[name](*values)
        result = math.wrap(exact, width)
        if result != exact:
            self._fault_log.overflow(self._site)
        return result

    def _calculate_real(self, name: str, values: Sequence[Any]) -> float:
        if name in ("/", "MOD") and values[1] == 0:
            self._fault_log.zero_divisor(self._site)
        result: float = _REAL[name](*values)
        if not math.finite(result) and all(map(math.finite, values)):
            self._fault_log.overflow(self._site)
        return result

    def _store(self, place: Place, value: Value) -> None:
        """Convert to the type of a place and set it."""
        kind = place.type
        if kind.is_bool:
            self.put(place, bool(value))
            return
        if kind.is_real:
            stored: Value = math.real(value)
        else:
            exact = math.whole(value) if isinstance(value, float) else int(value)
            stored = math.wrap(exact, kind.bits)
            if stored != exact or (isinstance(value, float) and not math.finite(value)):
                self._fault_log.overflow(self._site)
        self.put(place, stored)
        self._after(stored)

    def _before(self) -> None:
        if self._lowered.flags:
            self._set_leaf("S:V", False)
            self._set_leaf("S:C", False)

    def _after(self, stored: Value) -> None:
        if self._lowered.flags:
            self._set_leaf("S:Z", stored == 0)
            self._set_leaf("S:N", stored < 0)

    def _compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        self._before()
        expression = Calculation(name, operands)
        width = width_of(expression, target)
        if self._lowered.flags and width:
            self._set_leaf("S:C", self._carry(name, operands, width))
        self._store(target, self._number(expression, width))

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> bool:
        if name not in ("+", "-", "NEG"):
            return False
        mask = (1 << width) - 1
        values = [int(self._number(each, width)) & mask for each in operands]
        if name == "+":
            return values[0] + values[1] > mask
        return values[0] < values[1] if name == "-" else values[0] != 0


def width_of(*operands: Resolved) -> int:
    """Return the width in which operands are computed together: 0 for REAL, 64 with a LINT, else 32."""
    types = set().union(*map(types_in, operands))
    if REAL in types:
        return 0
    return LINT.bits if LINT in types else DINT.bits


def place_of(operand: Resolved) -> Place:
    """Return an operand that is known to be a place."""
    assert isinstance(operand, Place)
    return operand


_WHOLE: Mapping[str, Callable[..., int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": math.quotient,
    "MOD": math.remainder,
    "**": lambda a, b: math.truncated(math.power(float(a), float(b))),
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
    "NOT": lambda a: ~a,
    "NEG": lambda a: -a,
    "ABS": abs,
    "SQR": math.integer_root,
    "TRN": lambda a: a,
}

_REAL: Mapping[str, Callable[..., float]] = {
    "+": lambda a, b: math.real(a + b),
    "-": lambda a, b: math.real(a - b),
    "*": math.real_product,
    "/": math.real_quotient,
    "MOD": math.real_remainder,
    "**": math.power,
    "NEG": lambda a: -a,
    "ABS": abs,
    "SQR": math.square_root,
    "TRN": lambda a: math.real(math.truncated(a)),
}
