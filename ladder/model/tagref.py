"""Python operators on tags and expressions."""

from __future__ import annotations

from typing import NoReturn

from .errors import LadderError
from .expressions import parse_expression
from .operators import COMPARISONS
from .tree import Address, BitStep, Instruction, MemberStep, Operand, Operation, SubscriptStep, number

_COMPARE = {operator: name for name, operator in COMPARISONS.items()}


class Expression:
    """An operand with Python's operators."""

    __slots__ = ("operand",)

    def __init__(self, operand: Operand) -> None:
        self.operand = operand

    def __bool__(self) -> NoReturn:
        raise LadderError(
            f"{self.operand} has no value while the program is written; "
            "write [a, b] for parallel, a, b for series and ~a for XIO instead of or, and, not"
        )

    __hash__ = None  # type: ignore[assignment]

    def __add__(self, other: object) -> Expression:
        return _operation("+", self, other)

    def __radd__(self, other: object) -> Expression:
        return _operation("+", other, self)

    def __sub__(self, other: object) -> Expression:
        return _operation("-", self, other)

    def __rsub__(self, other: object) -> Expression:
        return _operation("-", other, self)

    def __mul__(self, other: object) -> Expression:
        return _operation("*", self, other)

    def __rmul__(self, other: object) -> Expression:
        return _operation("*", other, self)

    def __truediv__(self, other: object) -> Expression:
        return _operation("/", self, other)

    def __rtruediv__(self, other: object) -> Expression:
        return _operation("/", other, self)

    def __mod__(self, other: object) -> Expression:
        return _operation("MOD", self, other)

    def __pow__(self, other: object) -> Expression:
        return _operation("**", self, other)

    def __and__(self, other: object) -> Expression:
        return _operation("AND", self, other)

    def __or__(self, other: object) -> Expression:
        return _operation("OR", self, other)

    def __xor__(self, other: object) -> Expression:
        return _operation("XOR", self, other)

    def __neg__(self) -> Expression:
        return Expression(Operation("NEG", (self.operand,)))

    def __abs__(self) -> Expression:
        return Expression(Operation("ABS", (self.operand,)))

    def __eq__(self, other: object) -> Instruction:  # type: ignore[override]
        return _comparison("=", self, other)

    def __ne__(self, other: object) -> Instruction:  # type: ignore[override]
        return _comparison("<>", self, other)

    def __lt__(self, other: object) -> Instruction:
        return _comparison("<", self, other)

    def __le__(self, other: object) -> Instruction:
        return _comparison("<=", self, other)

    def __gt__(self, other: object) -> Instruction:
        return _comparison(">", self, other)

    def __ge__(self, other: object) -> Instruction:
        return _comparison(">=", self, other)

    def __repr__(self) -> str:
        return str(self.operand)


class TagRef(Expression):
    """A tag or a part of one: `fill.ACC`, `data[3]`, `data[index + 1]`, `word.bit(5)`; `~tag` is XIO."""

    __slots__ = ()

    def __init__(self, address: Address) -> None:
        super().__init__(address)

    @property
    def _address(self) -> Address:
        assert isinstance(self.operand, Address)
        return self.operand

    def __getattr__(self, name: str) -> TagRef:
        if name.startswith("__"):
            raise AttributeError(name)
        return self._with(MemberStep(name))

    def __getitem__(self, index: object) -> TagRef:
        indices = index if isinstance(index, tuple) else (index,)
        return self._with(SubscriptStep(tuple(map(operand_of, indices))))

    def bit(self, index: object) -> TagRef:
        """Return a bit of an integer; the number may be a tag."""
        return self._with(BitStep(operand_of(index)))

    def __invert__(self) -> Instruction:
        return Instruction("XIO", (self.operand,))

    def _with(self, step: MemberStep | SubscriptStep | BitStep) -> TagRef:
        return TagRef(Address(self._address.name, (*self._address.steps, step)))


def operand_of(given: object) -> Operand:
    """Return the operand of a Python value: a tag, a number, or an address as text."""
    if isinstance(given, Expression):
        return given.operand
    if isinstance(given, bool) or not isinstance(given, (int, float, str)):
        raise LadderError(f"{given!r} is not an operand; write a tag, a number or an address as text")
    return parse_expression(given) if isinstance(given, str) else number(given)


def _operation(name: str, a: object, b: object) -> Expression:
    return Expression(Operation(name, (operand_of(a), operand_of(b))))


def _comparison(relation: str, a: object, b: object) -> Instruction:
    operands = (operand_of(a), operand_of(b))
    if any(isinstance(each, Operation) for each in operands):
        return Instruction("CMP", (Operation(relation, operands),))
    return Instruction(_COMPARE[relation], operands)
