"""Types of tags that a partial export leaves out, from their use in its rungs.

    XIC(Missing.Ready) MOV(Missing.Count[3],Total)     Missing: Ready BOOL, Count DINT[4]

All uses of a tag are collected in a tree of its members. An instruction that takes one type only (a timer, a
string, an add-on's instance) decides; a real number beside it makes a number REAL; a bit of it makes it an
integer. What is left open is a DINT, or a BOOL where a bit is needed. The report lists each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from ..addon import AddOn
from ..inferred import BY_USE
from ..instructions import BY_NAME
from ..motion_types import MOTION_INSTRUCTION
from ..motion_words import KEYWORDS
from ..spec import Spec, Use
from ..statements import (
    Assignment,
    Case,
    For,
    If,
    Invocation,
    Repeat,
    While,
    operands_in,
    statements_in,
)
from ..tree import (
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
    Step,
    SubscriptStep,
    addresses_in,
    instructions_of,
)
from ..types import (
    BOOL,
    CONTROL,
    COUNTER,
    DINT,
    FBD_COUNTER,
    FBD_ONESHOT,
    FBD_TIMER,
    LINT,
    MESSAGE,
    REAL,
    STRING,
    TIMER,
    DataType,
    Member,
    Structure,
)

COMPUTED_LENGTH = 256
"""Length of an array with computed subscripts only."""

MOST_LENGTH = 4096
"""Length that a subscript in a rung can give an array."""

_BITS = frozenset({Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE, Use.TRUTH, Use.SWITCH})

_STRUCTURES: Mapping[Use, DataType] = {
    use: kind for use, kind in BY_USE.items() if isinstance(kind, Structure)
}
"""What an operand of a use is, if it is a structure."""

_BLOCKS: Mapping[str, DataType] = {
    **dict.fromkeys(("TONR", "TOFR", "RTOR"), FBD_TIMER),
    "CTUD": FBD_COUNTER,
    **dict.fromkeys(("OSRI", "OSFI"), FBD_ONESHOT),
}

_NAMES = frozenset({Use.LABEL, Use.MODE, Use.ROUTINE, Use.PASSES})
_BY_MEMBERS = (TIMER, COUNTER, CONTROL, STRING, MOTION_INSTRUCTION, MESSAGE)

Known = Callable[[str, Address], DataType | None]
"""Returns the type of a declared address in a program, None if it is not declared."""

Missing = Callable[[str, Address], tuple[str, tuple[Step, ...]] | None]
"""Returns what is to be guessed for an address in a program and the steps from there, None if it is known."""


@dataclass(slots=True)
class Guess:
    """What is known of a tag or a member.

    Attributes:
        name: its name.
        members: its members, by name in capitals.
        lengths: of its dimensions, as far as subscripts show them.
        votes: types that its uses need.
        weak: types that its uses make likely.
        bit: the highest bit that is named, -1 without one.
    """

    name: str
    members: dict[str, Guess] = field(default_factory=dict)
    lengths: list[int] = field(default_factory=list)
    votes: list[DataType] = field(default_factory=list)
    weak: list[DataType] = field(default_factory=list)
    bit: int = -1

    def member(self, name: str) -> Guess:
        """Return a member, new or known."""
        return self.members.setdefault(name.upper(), Guess(name))

    def subscripts(self, step: SubscriptStep) -> None:
        """Note subscripts."""
        while len(self.lengths) < len(step.indices):
            self.lengths.append(0)
        for place, index in enumerate(step.indices):
            length = COMPUTED_LENGTH if len(step.indices) == 1 else 16
            if isinstance(index, Number) and isinstance(index.value, int):
                length = min(max(index.value, 0), MOST_LENGTH - 1) + 1
            self.lengths[place] = max(self.lengths[place], length)

    @property
    def dims(self) -> tuple[int, ...]:
        """Its dimensions."""
        return tuple(max(1, each) for each in self.lengths[:3])

    def type(self, path: str) -> DataType:
        """Return its type."""
        structures = [each for each in self.votes if isinstance(each, Structure)]
        if structures:
            return structures[0]
        if self.members:
            return self._structure(path)
        if self.bit >= 0:
            return LINT if self.bit > 31 else DINT
        for votes in (self.votes, self.weak):
            for kind in (BOOL, REAL, LINT, DINT):
                if kind in votes:
                    return kind
            if votes:
                return votes[0]
        return DINT

    def fits(self, member: Member | None) -> bool:
        """Whether its uses are those of a member of a type."""
        if member is None or bool(member.dims) != bool(self.lengths):
            return False
        return BOOL not in self.votes or member.type is BOOL

    def _structure(self, path: str) -> Structure:
        for each in _BY_MEMBERS if ":" not in self.name else ():
            if all(guess.fits(each.member(guess.name)) for guess in self.members.values()):
                return each
        members = [
            Member(each.name, each.type(f"{path}_{each.name}"), each.dims) for each in self.members.values()
        ]
        return Structure(path, tuple(members))


class Guesses:
    """Collects uses of what is not declared.

    Args:
        missing: returns what is to be guessed.
        known: returns the type of a declared address.
        add_ons: by name in capitals.
        specs: the shapes of all instructions.
    """

    def __init__(
        self,
        missing: Missing,
        known: Known,
        add_ons: Mapping[str, AddOn],
        specs: Mapping[str, Spec],
    ) -> None:
        self._missing, self._known = missing, known
        self._add_ons, self._specs = add_ons, specs
        self.found: dict[str, Guess] = {}

    def read(self, program: str, routine: Routine) -> None:
        """Collect the uses in a routine."""
        for rung in routine.rungs:
            for instruction in instructions_of(rung.series):
                self._instruction(program, instruction)
        for statement in statements_in(routine.statements or ()):
            self._statement(program, statement)

    # --- instructions and statements

    def _instruction(self, program: str, instruction: Instruction) -> None:
        spec = self._specs.get(instruction.name.upper()) or BY_NAME.get(instruction.name)
        uses = spec.operands if spec else ()
        if instruction.name == "JSR":
            uses = (Use.ROUTINE, Use.CONSTANT)
        definition = self._add_ons.get(instruction.name.upper())
        partner = self._partner(program, instruction.operands)
        for place, operand in enumerate(instruction.operands):
            use = uses[place] if place < len(uses) else Use.PARAMETERS
            self._inside(program, operand)
            if isinstance(operand, Address):
                if use in _NAMES or (use is Use.KEYWORD and not operand.steps and _is_word(operand)):
                    continue
                self._address(program, operand, *self._wanted(use, instruction, place, definition, partner))
            elif isinstance(operand, Operation):
                self._operation(program, operand, partner, bits=use in _BITS)

    def _wanted(
        self,
        use: Use,
        instruction: Instruction,
        place: int,
        definition: AddOn | None,
        partner: DataType | None,
    ) -> tuple[DataType | None, DataType | None]:
        """Return the type that a use needs, or else the type that it makes likely."""
        if definition is not None:
            if place == 0:
                return definition.structure, None
            if place <= len(definition.required):
                return definition.required[place - 1].type, None
        if use in _BITS:
            return BOOL, None
        if use is Use.BLOCK:
            return _BLOCKS.get(instruction.name), None
        if use in _STRUCTURES:
            return _STRUCTURES[use], None
        if use is Use.RESETTABLE:
            return None, TIMER
        if use in (Use.TEXT_OR_NUMBER, Use.SOURCE, Use.DESTINATION, Use.ITEM, Use.ITEM_TARGET):
            return (partner, None) if isinstance(partner, Structure) else (None, partner or DINT)
        if use in (Use.INTEGER, Use.INTEGER_TARGET, Use.CONSTANT):
            return None, DINT
        return None, REAL if partner is REAL else DINT

    def _partner(self, program: str, operands: Iterable[Operand]) -> DataType | None:
        """Return REAL if an operand is one, a string or a structure if one is, else None."""
        kinds = [self._kind(program, each) for each in operands]
        structure = next((each for each in kinds if isinstance(each, Structure)), None)
        return structure or (REAL if REAL in kinds else None)

    def _kind(self, program: str, operand: Operand) -> DataType | None:
        if isinstance(operand, Number):
            return REAL if isinstance(operand.value, float) else None
        if isinstance(operand, Characters):
            return STRING
        if isinstance(operand, Operation):
            kinds = [self._kind(program, each) for each in operand.operands]
            return REAL if REAL in kinds else None
        if not isinstance(operand, Address):
            return None
        is_bit = bool(operand.steps) and isinstance(operand.steps[-1], BitStep)
        return BOOL if is_bit else self._known(program, operand)

    def _statement(self, program: str, statement: Statement) -> None:
        if isinstance(statement, Invocation):
            self._instruction(program, statement.instruction)
            return
        for operand in operands_in(statement):
            self._inside(program, operand)
        if isinstance(statement, Assignment):
            self._assignment(program, statement)
        elif isinstance(statement, If):
            for arm in statement.arms:
                self._operation(program, arm.condition, None, bits=True)
        elif isinstance(statement, While | Repeat):
            for operand in operands_in(statement):
                self._operation(program, operand, None, bits=True)
        elif isinstance(statement, Case | For):
            for operand in operands_in(statement):
                self._operation(program, operand, None, bits=False)

    def _assignment(self, program: str, statement: Assignment) -> None:
        value, target = statement.value, statement.target
        kind = self._kind(program, target) or self._kind(program, value)
        logical = isinstance(value, Operation) and (value.name in (*_RELATIONS, "NOT") or kind is BOOL)
        if isinstance(kind, Structure):
            self._address(program, target, kind, None)
        else:
            self._address(program, target, None, BOOL if logical else kind or DINT)
        if isinstance(value, Address):
            self._address(program, value, kind if isinstance(kind, Structure) else None, kind or DINT)
        else:
            self._operation(program, value, REAL if kind is REAL else None, bits=logical)

    def _operation(self, program: str, operand: Operand, partner: DataType | None, *, bits: bool) -> None:
        """Note the uses in an expression."""
        todo: list[tuple[Operand, bool, DataType | None]] = [(operand, bits, partner)]
        while todo:
            node, is_bit, beside = todo.pop()
            if isinstance(node, Address):
                self._address(program, node, None, BOOL if is_bit else beside or DINT)
            elif isinstance(node, Operation):
                inner = is_bit and node.name in _LOGICAL
                inner = inner or (node.name in _RELATIONS and any(map(_is_logical, node.operands)))
                near = self._partner(program, node.operands) or beside
                todo += [(each, inner, near) for each in node.operands]

    def _inside(self, program: str, operand: Operand) -> None:
        """Note the tags in subscripts and computed bits."""
        for address in addresses_in(operand):
            for step in address.steps:
                inner = step.indices if isinstance(step, SubscriptStep) else ()
                if isinstance(step, BitStep):
                    inner = (step.index,)
                for each in inner:
                    self._operation(program, each, None, bits=False)

    # --- addresses

    def _address(
        self, program: str, address: Address, needed: DataType | None, likely: DataType | None
    ) -> None:
        missing = self._missing(program, address)
        if missing is None:
            return
        name, steps = missing
        here = self.found.setdefault(name.upper(), Guess(name))
        for step in steps:
            if isinstance(step, MemberStep):
                here = here.member(step.name)
            elif isinstance(step, SubscriptStep):
                here.subscripts(step)
            else:
                index = step.index if isinstance(step, SlashStep) else _bit_of(step)
                here.bit = max(here.bit, index)
                return
        if needed is not None:
            here.votes.append(needed)
        elif likely is not None:
            here.weak.append(likely)


_LOGICAL = ("AND", "OR", "XOR", "NOT")
_RELATIONS = ("=", "<>", "<", "<=", ">", ">=")


def _is_logical(operand: Operand) -> bool:
    """Whether an operand of a relation is true or false, not a number."""
    if not isinstance(operand, Operation):
        return False
    numbers = any(isinstance(each, Number) for each in operand.operands)
    return operand.name in _RELATIONS or (operand.name in _LOGICAL and not numbers)


def _is_word(operand: Address) -> bool:
    """Whether a motion instruction means a word by this, not a tag."""
    return operand.name.upper().replace(" ", "") in KEYWORDS


def _bit_of(step: object) -> int:
    index = getattr(step, "index", 0)
    if isinstance(index, Number):
        return int(index.value)
    return index if isinstance(index, int) else 0


def called_routines(routines: Iterable[Routine]) -> Iterator[str]:
    """Yield the names of the routines that are called, as they are written."""
    return _named_first(routines, "JSR", "FOR")


def triggered_tasks(routines: Iterable[Routine]) -> Iterator[str]:
    """Yield the names of the tasks that EVENT triggers, as they are written."""
    return _named_first(routines, "EVENT")


def _named_first(routines: Iterable[Routine], *instructions: str) -> Iterator[str]:
    """Yield the first operands of instructions, if they are names."""
    for each in all_instructions(routines):
        if each.name in instructions and each.operands:
            target = each.operands[0]
            if isinstance(target, Address) and not target.steps:
                yield target.name


def all_instructions(routines: Iterable[Routine]) -> Iterator[Instruction]:
    """Yield the instructions of rungs and of structured text."""
    for routine in routines:
        yield from (instruction for _, instruction in numbered_instructions(routine))


def numbered_instructions(routine: Routine) -> Iterator[tuple[int, Instruction]]:
    """Yield the instructions of a routine, each with its rung or line."""
    for number, rung in enumerate(routine.rungs):
        yield from ((number, each) for each in instructions_of(rung.series))
    for statement in statements_in(routine.statements or ()):
        if isinstance(statement, Invocation):
            yield statement.line, statement.instruction
