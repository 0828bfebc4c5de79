"""Types of tags that a program uses and does not declare, from how it uses them.

A partial export has rungs without the tags of their controller. A tag that is missing gets the type that its
uses ask for, and arrays the length of their highest constant subscript; a computed one asks for `COMPUTED`
elements.

| the program says | the tag is |
|---|---|
| `XIC(Run)` | BOOL |
| `TON(Fill,?,?)`, `Fill.DN` | TIMER |
| `Word.3`, `MOV(5,Word)` | DINT |
| `MOV(2.5,Level)` | REAL |
| `CONCAT(Text,'a',Text)` | STRING |
| `Recipe[2].Step` | an array of a structure with a member Step |
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from .motion_types import (
    AXIS_TYPES,
    COORDINATE_SYSTEM,
    MOTION_GROUP,
    MOTION_INSTRUCTION,
)
from .spec import Spec, Use
from .statements import Assignment, If, Invocation, Repeat, While, operands_in, statements_in
from .tags import STATUS_FLAGS, Tag
from .tree import (
    Address,
    BitStep,
    Characters,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Operation,
    Routine,
    SlashStep,
    Statement,
    SubscriptStep,
    WordStep,
    addresses_in,
    instructions_of,
)
from .types import (
    ALARM_ANALOG,
    ALARM_DIGITAL,
    BOOL,
    CONTROL,
    COUNTER,
    DINT,
    MESSAGE,
    PID,
    REAL,
    STRING,
    TIMER,
    DataType,
    Member,
    Structure,
)

COMPUTED = 100
"""Elements of an array with a computed subscript."""

MOST = 100_000
"""Elements that a constant subscript may ask for."""

BY_USE: Mapping[Use, DataType] = {
    **dict.fromkeys((Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE, Use.SWITCH, Use.TRUTH), BOOL),
    **dict.fromkeys((Use.TEXT, Use.TEXT_TARGET), STRING),
    Use.TIMER: TIMER,
    Use.COUNTER: COUNTER,
    Use.CONTROL: CONTROL,
    Use.MESSAGE: MESSAGE,
    Use.PID: PID,
    Use.ALARM_DIGITAL: ALARM_DIGITAL,
    Use.ALARM_ANALOG: ALARM_ANALOG,
    Use.MOTION: MOTION_INSTRUCTION,
    Use.MOTION_GROUP: MOTION_GROUP,
    Use.COORDINATE_SYSTEM: COORDINATE_SYSTEM,
    Use.AXIS: AXIS_TYPES["AXIS_CIP_DRIVE"],
}
"""What an operand of a use is."""

_NUMBERS = frozenset(
    {
        *(Use.NUMBER, Use.TEXT_OR_NUMBER, Use.TARGET, Use.EXPRESSION, Use.CONDITION, Use.KEYWORD),
        *(Use.OPTIONAL_TARGET, Use.PARAMETERS),
    }
)
"""Uses of a DINT, or of a REAL beside a number with a point."""

_ARRAYS = frozenset({Use.ARRAY, Use.TABLE})
_NAMES = frozenset({Use.LABEL, Use.MODE, Use.ROUTINE, Use.PASSES})

_BY_MEMBERS = (TIMER, COUNTER, CONTROL, STRING, MOTION_INSTRUCTION, MESSAGE, *AXIS_TYPES.values(), PID)
"""What a structure is whose members are all among theirs; the first that fits."""


@dataclass
class _Guess:
    """What the uses of a tag, or of a part of one, say of its type."""

    asked: dict[DataType, None] = field(default_factory=dict)
    members: dict[str, tuple[str, _Guess]] = field(default_factory=dict)
    lengths: list[int] = field(default_factory=list)

    def member(self, name: str) -> _Guess:
        return self.members.setdefault(name.upper(), (name, _Guess()))[1]

    def subscript(self, indices: tuple[Operand, ...]) -> None:
        self.lengths += [1] * (len(indices) - len(self.lengths))
        for place, each in enumerate(indices):
            wanted = COMPUTED
            if isinstance(each, Number) and isinstance(each.value, int):
                wanted = each.value + 1 if 0 <= each.value < MOST else 1
            self.lengths[place] = max(self.lengths[place], wanted)

    def type(self, name: str, known: Iterable[Structure]) -> DataType:
        structures = [each for each in self.asked if isinstance(each, Structure)]
        if structures:
            return structures[0]
        if self.members:
            return self._structure(name, known)
        first = next(iter(self.asked), DINT)
        return next((each for each in (BOOL, REAL) if each in self.asked), first)

    def _structure(self, name: str, known: Iterable[Structure]) -> Structure:
        for each in (*_BY_MEMBERS, *known):
            if all(each.member(member) is not None for member in self.members):
                return each
        made = [
            Member(said, guess.type(f"{name}_{said}", known), tuple(guess.lengths))
            for said, guess in self.members.values()
        ]
        return Structure(f"{name}_type", tuple(made))


class Inference:
    """Collects what routines ask of tags that nothing declares.

    Args:
        specs: the known instructions, by name in capitals.
        of_call: returns the types of the operands of an add-on call; none for any other instruction.
        known: structures that a tag may be of whose members are among theirs.
    """

    def __init__(
        self,
        specs: Mapping[str, Spec],
        of_call: Callable[[str], tuple[tuple[DataType, tuple[int, ...]], ...]] = lambda _name: (),
        known: Iterable[Structure] = (),
    ) -> None:
        self._specs, self._of_call = specs, of_call
        self._is_declared: Callable[[str], bool] = lambda _name: False
        self._known = tuple(known)
        self._guesses: dict[str, tuple[str, _Guess]] = {}

    def routine(self, routine: Routine, is_declared: Callable[[str], bool]) -> None:
        """Take notice of a routine.

        Args:
            routine: it.
            is_declared: whether a name means something in its program.
        """
        self._is_declared = is_declared
        for rung in routine.rungs:
            for instruction in instructions_of(rung.series):
                self._instruction(instruction)
        for statement in statements_in(routine.statements or ()):
            if isinstance(statement, Invocation):
                self._instruction(statement.instruction)
                continue
            for operand in operands_in(statement):
                self._value(operand, _is_real(operand))
            self._statement(statement)

    def _statement(self, statement: Statement) -> None:
        if isinstance(statement, If):
            for arm in statement.arms:
                self._condition(arm.condition)
        elif isinstance(statement, While):
            self._condition(statement.condition)
        elif isinstance(statement, Repeat):
            self._condition(statement.until)
        elif isinstance(statement, Assignment):
            if _is_logical(statement.value):
                self._address(statement.target, BOOL)
                self._condition(statement.value)
            elif _is_real(statement.value):
                self._address(statement.target, REAL)

    def tags(self) -> list[Tag]:
        """Return the tags that are missing, in the order of their first use."""
        return [
            Tag(name, guess.type(name.replace(":", "_"), self._known), tuple(guess.lengths[:3]))
            for name, guess in self._guesses.values()
        ]

    def _instruction(self, instruction: Instruction) -> None:
        handed = self._of_call(instruction.name)
        if handed:
            for (kind, dims), operand in zip(handed, instruction.operands, strict=False):
                self._argument(operand, kind, dims)
            return
        spec = self._specs.get(instruction.name.upper())
        real = any(map(_is_real, instruction.operands))
        uses = spec.operands if spec is not None else ()
        for place, operand in enumerate(instruction.operands):
            use = uses[min(place, len(uses) - 1)] if uses else Use.ANYTHING
            self._operand(use, operand, real, instruction)

    def _argument(self, operand: Operand, kind: DataType, dims: tuple[int, ...]) -> None:
        if isinstance(operand, Address):
            guess = self._address(operand, kind)
            if guess is not None and dims and not guess.lengths:
                guess.lengths = list(dims)
        else:
            self._value(operand, kind == REAL)

    def _operand(self, use: Use, operand: Operand, real: bool, instruction: Instruction) -> None:
        if use in _NAMES or (use is Use.KEYWORD and isinstance(operand, Address) and not operand.steps):
            return
        kind = BY_USE.get(use)
        if kind is not None and isinstance(operand, Address):
            self._address(operand, kind)
        elif use in _ARRAYS or use in (Use.SOURCE, Use.DESTINATION):
            self._region(operand, instruction)
        elif use is Use.TRUTH:
            self._condition(operand)
        else:
            self._value(operand, real)

    def _region(self, operand: Operand, instruction: Instruction) -> None:
        """An array, or as many elements as a COP or FLL beside it copies."""
        if not isinstance(operand, Address):
            self._value(operand, False)
            return
        guess = self._address(operand, None)
        last = instruction.operands[-1]
        if guess is None or guess.lengths or guess.members or _ends_in_element(operand):
            return
        if isinstance(last, Number) and isinstance(last.value, int) and 1 < last.value < MOST:
            guess.lengths = [last.value]

    def _value(self, operand: Operand, real: bool) -> None:
        """A number, or an expression of numbers."""
        if isinstance(operand, Address):
            self._address(operand, REAL if real else None)
        elif isinstance(operand, Operation):
            for each in addresses_in(operand):
                self._address(each, REAL if real else None)

    def _condition(self, operand: Operand) -> None:
        """Something true or false, in structured text."""
        if isinstance(operand, Address):
            self._address(operand, BOOL)
        elif isinstance(operand, Operation) and operand.name in ("AND", "OR", "XOR", "NOT"):
            for each in operand.operands:
                self._condition(each)

    def _address(self, address: Address, kind: DataType | None) -> _Guess | None:
        """Note a use of an address; return what is known of its end, None if it is declared."""
        for step in address.steps:
            for inner in step.indices if isinstance(step, SubscriptStep) else ():
                self._value(inner, False)
            if isinstance(step, BitStep):
                self._value(step.index, False)
        name = address.name
        if not name or name.upper() in STATUS_FLAGS or self._is_declared(name):
            return None
        here = self._guesses.setdefault(name.upper(), (name, _Guess()))[1]
        for step in address.steps:
            if isinstance(step, MemberStep):
                here = here.member(step.name)
            elif isinstance(step, SubscriptStep):
                here.subscript(step.indices)
            elif isinstance(step, WordStep):
                here.subscript((Number(step.index, str(step.index)),))
            elif isinstance(step, (BitStep, SlashStep)):
                here.asked[DINT] = None
                return None
        if kind is not None:
            here.asked[kind] = None
        return here


def _ends_in_element(address: Address) -> bool:
    return bool(address.steps) and isinstance(address.steps[-1], SubscriptStep)


def _is_real(operand: Operand) -> bool:
    if isinstance(operand, Number):
        return isinstance(operand.value, float)
    return isinstance(operand, Operation) and any(map(_is_real, operand.operands))


def _is_logical(operand: Operand) -> bool:
    if not isinstance(operand, Operation):
        return False
    if operand.name in ("=", "<>", "<", "<=", ">", ">="):
        return True
    numbers = any(isinstance(each, (Number, Characters)) for each in operand.operands)
    return operand.name == "NOT" or (operand.name in ("AND", "OR", "XOR") and not numbers)
