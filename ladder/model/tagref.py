"""Python operators for tags and expressions."""

from __future__ import annotations

from collections.abc import Callable
from typing import NoReturn

from .errors import LadderError
from .expressions import parse_expression
from .operators import COMPARISONS
from .tree import Address, BitStep, Instruction, MemberStep, Operand, Operation, SubscriptStep, number

_COMPARE = {operator: name for name, operator in COMPARISONS.items()}


def _binary(name: str, *, reflected: bool = False) -> Callable[[Expression, object], Expression]:
    """Return the method for an operator; a reflected method reverses the operands."""

    def operate(left: Expression, right: object) -> Expression:
        operands = (operand_of(left), operand_of(right))
        return Expression(Operation(name, operands[::-1] if reflected else operands))

    return operate


def _relation(sign: str) -> Callable[[Expression, object], Instruction]:
    """Return the method for a comparison; it makes a CMP if an operand is an operation."""

    def compare(left: Expression, right: object) -> Instruction:
        operands = (operand_of(left), operand_of(right))
        if any(isinstance(operand, Operation) for operand in operands):
            return Instruction("CMP", (Operation(sign, operands),))
        return Instruction(_COMPARE[sign], operands)

    return compare


class Expression:
    """An operand that supports Python's operators."""

    __slots__ = ("operand",)

    def __init__(self, operand: Operand) -> None:
        self.operand = operand

    def __bool__(self) -> NoReturn:
        raise LadderError(
            f"{self.operand} has no value while the program is written; "
            "write [a, b] for parallel, a, b for series and ~a for XIO instead of or, and, not"
        )

    __hash__ = None  # type: ignore[assignment]

    __add__ = _binary("+")
    __radd__ = _binary("+", reflected=True)
    __sub__ = _binary("-")
    __rsub__ = _binary("-", reflected=True)
    __mul__ = _binary("*")
    __rmul__ = _binary("*", reflected=True)
    __truediv__ = _binary("/")
    __rtruediv__ = _binary("/", reflected=True)
    __mod__ = _binary("MOD")
    __pow__ = _binary("**")
    __and__ = _binary("AND")
    __or__ = _binary("OR")
    __xor__ = _binary("XOR")

    def __neg__(self) -> Expression:
        return Expression(Operation("NEG", (self.operand,)))

    def __abs__(self) -> Expression:
        return Expression(Operation("ABS", (self.operand,)))

    __eq__ = _relation("=")  # type: ignore[assignment]
    __ne__ = _relation("<>")  # type: ignore[assignment]
    __lt__ = _relation("<")
    __le__ = _relation("<=")
    __gt__ = _relation(">")
    __ge__ = _relation(">=")

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
        """Return a bit of an integer; the bit number can be a tag."""
        return self._with(BitStep(operand_of(index)))

    def __invert__(self) -> Instruction:
        return Instruction("XIO", (self.operand,))

    def _with(self, step: MemberStep | SubscriptStep | BitStep) -> TagRef:
        return TagRef(Address(self._address.name, (*self._address.steps, step)))


def operand_of(value: object) -> Operand:
    """Return the operand of a Python value: a tag, a number, or an address as text."""
    if isinstance(value, Expression):
        return value.operand
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise LadderError(f"{value!r} is not an operand; write a tag, a number or an address as text")
    return parse_expression(value) if isinstance(value, str) else number(value)
