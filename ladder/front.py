"""The Python front end: a rung is a call, and reads from left to right like the rung it is.

| Python | rung text |
|---|---|
| `rung(start, ~stop, OTE(run))` | `XIC(Start)XIO(Stop)OTE(Run);` |
| `rung([start, run], ~stop, OTE(run))` | `[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);` |
| `rung([(a, ~b), c], OTE(d), e, OTE(f))` | `[XIC(a)XIO(b),XIC(c)]OTE(d)XIC(e)OTE(f);` |
| `rung(run, TON(fill))` | `XIC(Run)TON(Fill,?,?);` |
| `rung(count.ACC >= 10, MOV(count.ACC, total))` | `GEQ(Count.ACC,10)MOV(Count.ACC,Total);` |
| `rung(a * 2 > b, CPT(c, (a + b) / 2))` | `CMP(a*2>b)CPT(c,(a+b)/2);` |

Brackets are parallel, parentheses a series inside them, a tag is XIC, `~` is XIO, and a
comparison is the compare instruction.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import NoReturn

from .errors import LadderError
from .instructions import BY_NAME, Spec, Use
from .text import parse_expression, parse_rung
from .tree import (
    Address,
    BitStep,
    Branch,
    Element,
    Instruction,
    MemberStep,
    Operand,
    Operation,
    Origin,
    Rung,
    Series,
    SubscriptStep,
    Unknown,
    number,
    too_deep,
)

_COMPARE = {"=": "EQU", "<>": "NEQ", "<": "LES", "<=": "LEQ", ">": "GRT", ">=": "GEQ"}


class Expression:
    """Something with a value: an operand with Python's operators."""

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
    """Return the operand that a Python value stands for: a tag, a number, an address as text."""
    if isinstance(given, Expression):
        return given.operand
    if isinstance(given, bool) or not isinstance(given, (int, float, str)):
        raise LadderError(f"{given!r} is no operand; write a tag, a number or an address as text")
    return parse_expression(given) if isinstance(given, str) else number(given)


def _operation(name: str, a: object, b: object) -> Expression:
    return Expression(Operation(name, (operand_of(a), operand_of(b))))


def _comparison(relation: str, a: object, b: object) -> Instruction:
    operands = (operand_of(a), operand_of(b))
    if any(isinstance(each, Operation) for each in operands):
        return Instruction("CMP", (Operation(relation, operands),))
    return Instruction(_COMPARE[relation], operands)


class RungMaker:
    """What a routine's function is called with: call it once per rung.

    Attributes:
        rungs: the rungs so far.

    Args:
        specs: the instructions that rung text may name.
    """

    def __init__(self, specs: Mapping[str, Spec] = BY_NAME) -> None:
        self.rungs: list[Rung] = []
        self._specs = specs

    def __call__(self, *elements: object, comment: str = "") -> None:
        """Add a rung.

        Args:
            elements: tags, instructions, lists as branches; or one str of rung text.
            comment: what is said of it.

        Raises:
            LadderError: something is no part of a rung; file and line, and a remedy.
        """
        caller = sys._getframe(1)
        origin = Origin(caller.f_code.co_filename, caller.f_lineno)
        try:
            if len(elements) == 1 and isinstance(elements[0], str):
                series = parse_rung(elements[0], rung=len(self.rungs), specs=self._specs).series
            else:
                series = _checked(series_of(elements))
        except (LadderError, RecursionError) as error:
            what = "lists stand too deep in one another" if isinstance(error, RecursionError) else error
            text = f"{origin.file}:{origin.line}: rung {len(self.rungs)}: {what}"
            raise LadderError(text) from None
        self.rungs.append(Rung(series, comment, origin))


def _checked(series: Series) -> Series:
    deep = too_deep(series)
    if deep:
        raise LadderError(f"{deep}; use fewer, or steps in between")
    return series


def series_of(elements: Sequence[object]) -> Series:
    """Return the series that Python values stand for."""
    found: list[Element] = []
    for each in elements:
        if isinstance(each, tuple):
            found.extend(series_of(each))
        else:
            found.append(_element(each))
    return tuple(found)


def _element(given: object) -> Element:
    if isinstance(given, (Instruction, Branch)):
        return given
    if isinstance(given, list):
        legs = tuple(series_of(leg if isinstance(leg, tuple) else (leg,)) for leg in given)
        return Branch(legs)
    if isinstance(given, TagRef):
        return Instruction("XIC", (given.operand,))
    if isinstance(given, str):
        return Instruction("XIC", (operand_of(given),))
    what = f"the expression {given}" if isinstance(given, Expression) else repr(given)
    raise LadderError(f"{what} is no part of a rung; write a tag, an instruction, or a list as a branch")


def make(name: str, *given: object) -> Instruction:
    """Return an instruction with operands of Python; missing presets are `?`.

    Raises:
        LadderError: there is no such instruction, or it takes another number of operands.
    """
    spec = BY_NAME.get(name.upper())
    if spec is None:
        raise LadderError(f"there is no instruction {name}")
    operands = [
        Address(str(each)) if _is_name(spec.operands, place) and isinstance(each, str) else operand_of(each)
        for place, each in enumerate(given)
    ]
    most = len(spec.operands)
    if len(operands) < most - spec.optional - spec.variadic or (len(operands) > most and not spec.variadic):
        raise LadderError(f"{spec.name} takes {most} operands, {len(operands)} are given")
    if Use.PRESET in spec.operands:
        operands += [Unknown()] * (most - len(operands))
    return Instruction(spec.name, tuple(operands))


def _is_name(uses: tuple[Use, ...], place: int) -> bool:
    return place < len(uses) and uses[place] in (Use.LABEL, Use.MODE, Use.ROUTINE)
