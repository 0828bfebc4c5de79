"""Values as Python code with their ranges, and integer operations on them."""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.dataclass import dataclass

from ..model.operands import Calculation, Group, Place, Resolved, can_fault, is_truth
from ..model.operators import FUNCTIONS, RELATIONS


@dataclass(frozen=True, slots=True)
class Term:
    """A value as Python code."""

    text: str  # an expression: a name, a number or something in parentheses
    low: int = 0  # lowest possible value, for an integer
    high: int = 0  # highest possible value
    real: bool = False  # whether it is a floating-point number
    double: bool = False  # whether it needs rounding to be a REAL

    def fits(self, bits: int) -> bool:
        """Return whether it is an integer that never overflows that many bits."""
        half = 1 << bits - 1
        return not self.real and -half <= self.low and self.high < half


def integer_operation(name: str, terms: list[Term], site: int) -> Term:
    """Return an integer operation without wrapping, with the range of its result."""
    texts = [term.text for term in terms]
    a = terms[0]
    b = terms[-1]
    largest = max(abs(bound) for term in terms for bound in (term.low, term.high))
    if name in ("+", "-", "*"):
        low, high = _RANGES[name](a, b)
        return Term(f"({texts[0]} {name} {texts[1]})", low, high)
    if name in ("/", "MOD"):
        function = "divide" if name == "/" else "modulo"
        return Term(f"{function}({site}, {texts[0]}, {texts[1]})", -largest, largest)
    if name in ("AND", "OR", "XOR"):
        bits = largest.bit_length()
        sign = {"AND": "&", "OR": "|", "XOR": "^"}[name]
        return Term(f"({texts[0]} {sign} {texts[1]})", -(1 << bits), (1 << bits) - 1)
    if name == "**":  # the range is wider than that of a float
        return Term(f"truncated(power(float({texts[0]}), float({texts[1]})))", -(1 << 4000), 1 << 4000)
    if name == "NOT":
        return Term(f"(~{texts[0]})", ~a.high, ~a.low)
    if name == "NEG":
        return Term(f"(-{texts[0]})", -a.high, -a.low)
    row = FUNCTIONS[name]
    assert row.whole is not None
    return Term(f"{row.whole.__name__}({texts[0]})", 0 if row.positive else a.low, row.most or largest)


def times(text: str, stride: int) -> str:
    """Return text for the product of a text and a stride.

    >>> times("i", 3), times("i", 1)
    ('i * 3', 'i')
    """
    return f"{text} * {stride}" if stride != 1 else text


def calculates(operand: Resolved) -> bool:
    """Return whether an operand or a subscript contains a calculation, which can need extra lines."""
    if isinstance(operand, Calculation):
        return True
    if isinstance(operand, (Place, Group)):
        inner = [*operand.indices]
        if isinstance(operand, Place) and operand.bit is not None:
            inner.append(operand.bit)
        return any(map(calculates, inner))
    return False


def is_plain(condition: Resolved) -> bool:
    """Return whether a condition is one expression without effects or faults."""
    if can_fault(condition):
        return False
    if not isinstance(condition, Calculation):
        return True
    return (condition.name in RELATIONS or is_truth(condition)) and all(map(is_plain, condition.operands))


CARRIES: dict[str, Callable[[str, str, int], str]] = {
    "+": lambda a, b, mask: f"{a} + {b} > {mask}",
    "-": lambda a, b, _mask: f"{a} < {b}",
    "NEG": lambda a, _b, _mask: f"{a} != 0",
}
"""Text for the carry of an operator on unsigned operands."""


def _product(a: Term, b: Term) -> tuple[int, int]:
    """Return the lowest and highest value of a product."""
    corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
    return min(corners), max(corners)


_RANGES: dict[str, Callable[[Term, Term], tuple[int, int]]] = {
    "+": lambda a, b: (a.low + b.low, a.high + b.high),
    "-": lambda a, b: (a.low - b.high, a.high - b.low),
    "*": _product,
}
