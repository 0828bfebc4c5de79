"""Instructions on numbers: compare, compute, move, logical."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .. import arithmetic as math
from ..instructions import RELATIONS
from ..operands import Calculation, Constant, Group, Place, Quoted, Resolved
from ..regions import region_of
from .values import Values, width_of


class NumberInstructions(Values):
    """Compare, compute, move, logical."""

    def _compare(self, relation: str, a: Resolved, b: Resolved) -> bool:
        if isinstance(a, (Group, Quoted)):
            return _RELATIONS[relation](self._text(a), self._text(b))
        width = width_of(a, b)
        left, right = self._number(a, width), self._number(b, width)
        return _RELATIONS[relation](left, right)

    def _text(self, operand: Resolved) -> bytes:
        if isinstance(operand, Quoted):
            return operand.value.encode("latin-1", errors="replace")
        assert isinstance(operand, Group)
        first = region_of(operand, self._memory.layout).first(
            lambda index, length: self._subscript(index, length, operand.text)
        )
        return self._memory.text(operand.path, first)

    def _cmp(self, condition: Resolved) -> bool:
        assert isinstance(condition, Calculation)
        if condition.name in RELATIONS:
            return self._compare(condition.name, *condition.operands)
        values = [self._cmp(each) for each in condition.operands]
        return _TRUTH[condition.name](*values)

    def _lim(self, low: Resolved, test: Resolved, high: Resolved) -> bool:
        width = width_of(low, test, high)
        least, value, most = (self._number(each, width) for each in (low, test, high))
        if least <= most:
            return least <= value <= most
        return value >= least or value <= most

    def _meq(self, source: Resolved, mask: Resolved, compare: Resolved) -> bool:
        different = self._filled(source) ^ self._filled(compare)
        return different & self._filled(mask) == 0

    def _filled(self, operand: Resolved) -> int:
        """An integer as unsigned: a narrow one is filled up with zeros."""
        assert isinstance(operand, (Place, Constant))
        return self._integer(operand) & (1 << operand.type.bits) - 1

    def _cpt(self, target: Place, expression: Resolved) -> None:
        self._before()
        self._store(target, self._number(expression, width_of(expression, target)))

    def _sqr(self, source: Resolved, target: Place) -> None:
        self._compute("SQR", (source,), target)

    def _trn(self, source: Resolved, target: Place) -> None:
        self._before()
        value = self._number(source, width_of(source))
        if isinstance(value, float):
            if not math.finite(value):
                self._fault_log.overflow(self._site)
            value = math.truncated(value)
        self._store(target, value)

    def _mov(self, source: Resolved, target: Place) -> None:
        self._before()
        self._store(target, self._number(source, width_of(source)))

    def _combine(self, target: Place, value: int) -> None:
        """Set an integer to the low bits of a pattern; nothing overflows."""
        self._before()
        stored = math.wrap(value, target.type.bits)
        self.put(target, stored)
        self._after(stored)

    def _and(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) & self._filled(b))

    def _or(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) | self._filled(b))

    def _xor(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) ^ self._filled(b))

    def _not(self, source: Resolved, target: Place) -> None:
        self._combine(target, ~self._filled(source))

    def _mvm(self, source: Resolved, mask: Resolved, target: Place) -> None:
        before, bits = int(self.get(target)), self._filled(mask)
        self._combine(target, before & ~bits | self._filled(source) & bits)

    def _btd(
        self, source: Resolved, source_bit: Constant, target: Place, target_bit: Constant, length: Constant
    ) -> None:
        value = math.distributed(
            self._filled(source),
            int(source_bit.value),
            int(self.get(target)),
            int(target_bit.value),
            int(length.value),
            target.type.bits,
        )
        self.put(target, value)

    def _clr(self, target: Place) -> None:
        self._before()
        self.put(target, target.type.zero)
        self._after(0)

    def _swpb(self, source: Place, mode: str, target: Place) -> None:
        self.put(target, math.swapped(int(self.get(source)), source.type.bits, mode))


_RELATIONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}

_TRUTH: Mapping[str, Callable[..., bool]] = {
    "AND": lambda a, b: a and b,
    "OR": lambda a, b: a or b,
    "XOR": lambda a, b: a != b,
    "NOT": lambda a: not a,
}

COMPARISONS = {"EQU": "=", "NEQ": "<>", "LES": "<", "LEQ": "<=", "GRT": ">", "GEQ": ">="}
"""Relation by compare instruction."""

COMPUTATIONS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "NEG": "NEG", "ABS": "ABS"}
"""Operator by compute instruction."""
