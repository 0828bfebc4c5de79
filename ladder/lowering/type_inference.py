"""Types of undeclared tags, inferred from their use.

A partial export has rungs without the tags of their controller. All uses of a tag are collected in a tree of
its members. A use that accepts only one type determines the type. An operand of an instruction with a REAL
operand becomes REAL. A tag with a bit access is an integer. The highest constant subscript determines the
length of an array; if all subscripts are computed, it has `COMPUTED` elements.

| in the program | the tag is |
|---|---|
| `XIC(Run)` | BOOL |
| `TON(Fill,?,?)`, `Fill.DN` | TIMER |
| `Word.3`, `MOV(5,Word)` | DINT |
| `MOV(2.5,Level)` | REAL |
| `CONCAT(Text,'a',Text)` | STRING |
| `Recipe[2].Step` | an array of a structure with a member Step |

With `files`, as in an SLC 500, a number is an INT, and timers, counters and controls have the types of data
files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain, repeat

from ..model.operators import RELATIONS
from ..model.predefined.block_types import BLOCK_STRUCTURES
from ..model.predefined.motion_types import (
    AXIS_TYPES,
    BY_CLASS,
    COORDINATE_SYSTEM,
    MOTION_GROUP,
    MOTION_INSTRUCTION,
)
from ..model.predefined.safety_types import SAFETY
from ..model.predefined.slc_types import SLC_CONTROL, SLC_COUNTER, SLC_TIMER, SLC_TYPES
from ..model.predefined.structures import HMIBC, PREDEFINED_TYPES, SERIAL_PORT_CONTROL
from ..model.predefined.words import KEYWORDS, plain
from ..model.routine import Routine
from ..model.spec import Spec, Use
from ..model.statements import (
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
from ..model.tree import (
    Address,
    BitStep,
    Characters,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Operation,
    SlashStep,
    Statement,
    Step,
    SubscriptStep,
    Unknown,
    WordStep,
    addresses_in,
)
from ..model.types import (
    ALARM_ANALOG,
    ALARM_DIGITAL,
    BOOL,
    CONTROL,
    COUNTER,
    DINT,
    INT,
    MESSAGE,
    PID,
    REAL,
    STRING,
    TIMER,
    DataType,
    Elementary,
    Structure,
)
from .guess import COMPUTED, MOST, Guess, add_kind
from .parameter_pairs import ParameterPairs

CODE = 4
"""Maximum number of characters in a string used as a number, as in `MOV('A',Code)`."""

_BITS = (Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE, Use.TRUTH, Use.SWITCH)

BY_USE: Mapping[Use, DataType] = {
    **dict.fromkeys(_BITS, BOOL),
    **dict.fromkeys((Use.TEXT, Use.TEXT_TARGET), STRING),
    Use.TIMER: TIMER,
    Use.COUNTER: COUNTER,
    Use.CONTROL: CONTROL,
    Use.SLC_TIMER: SLC_TIMER,
    Use.SLC_COUNTER: SLC_COUNTER,
    Use.SLC_CONTROL: SLC_CONTROL,
    Use.MESSAGE: MESSAGE,
    Use.SERIAL: SERIAL_PORT_CONTROL,
    Use.HMI_BUTTON: HMIBC,
    Use.PID: PID,
    Use.ALARM_DIGITAL: ALARM_DIGITAL,
    Use.ALARM_ANALOG: ALARM_ANALOG,
    Use.MOTION: MOTION_INSTRUCTION,
    Use.MOTION_GROUP: MOTION_GROUP,
    Use.COORDINATE_SYSTEM: COORDINATE_SYSTEM,
    Use.AXIS: AXIS_TYPES["AXIS_CIP_DRIVE"],
}
"""Type that a use of an operand requires."""

_LIKELY: Mapping[Use, DataType | None] = {
    Use.RESETTABLE: TIMER,
    Use.SLC_RESETTABLE: SLC_TIMER,
    Use.PARAMETERS: None,
    **dict.fromkeys((Use.INTEGER, Use.INTEGER_TARGET, Use.CONSTANT), DINT),
}
"""Type that a use suggests, for uses that do not depend on the other operands."""

_BLOCKS: Mapping[str, DataType] = {**BLOCK_STRUCTURES, **SAFETY}

_REGIONS = frozenset({Use.SOURCE, Use.DESTINATION, Use.ARRAY, Use.TABLE})
_MAY_BE_TEXT = frozenset({Use.TEXT_OR_NUMBER, Use.TEXT_OR_NUMBER_TARGET})
_MAY_BE_STRUCTURES = _MAY_BE_TEXT | {Use.SOURCE, Use.DESTINATION, Use.ITEM, Use.ITEM_TARGET, Use.ARRAY}
_NAMES = frozenset({Use.LABEL, Use.MODE, Use.ROUTINE, Use.PASSES})
_BY_MEMBERS = (
    *(TIMER, COUNTER, CONTROL, STRING, MOTION_INSTRUCTION, MESSAGE),
    *(*AXIS_TYPES.values(), PID),
)
"""Candidate structures; the first one with all members in use is chosen."""

Known = Callable[[str, Address], DataType | None]
"""Returns the type of an address in a program; None if it is undeclared."""

OfCall = Callable[[str], tuple[tuple[DataType, tuple[int, ...]], ...]]
"""Returns the types and dimensions of an add-on call's operands."""

Missing = Callable[[str, Address], tuple[str, tuple[Step, ...]] | None]
"""Returns the key of an undeclared address in a program and the remaining steps, None if declared."""


class Guesses:
    """Collects the uses of undeclared tags.

    Args:
        missing: see `Missing`.
        known: see `Known`.
        of_call: see `OfCall`.
        specs: all instructions, by name in capitals.
        structures: candidates for structures, after the predefined ones.
        files: whether tags are data files, as in an SLC 500.
    """

    def __init__(
        self,
        missing: Missing,
        known: Known,
        of_call: OfCall,
        specs: Mapping[str, Spec],
        structures: Iterable[Structure] = (),
        *,
        files: bool = False,
    ) -> None:
        self._missing, self._known = missing, known
        self._of_call, self._specs = of_call, specs
        self._number = INT if files else DINT
        self._structures = (*(SLC_TYPES.values() if files else ()), *_BY_MEMBERS, *structures)
        self.found: dict[str, Guess] = {}
        self._copies: list[tuple[Guess, Guess]] = []
        self._parameters = ParameterPairs()
        self._is_second_pass = False

    def read_all(self, routines: Iterable[tuple[str, Routine]]) -> None:
        """Collect the uses in routines, in two passes because a later use can determine an earlier one."""
        owned = list(routines)
        for _ in range(2):
            for program, routine in owned:
                self.read(program, routine)
            self._is_second_pass = True
            if not any(guess.asks_for_structure for guess in self.found.values()):
                break
        for program, outer, inner in self._parameters:
            self._unify(program, outer, inner)
        for copied, into in self._copies:
            if copied.is_bare != into.is_bare and (copied.root.members or into.root.members):
                copied.same_as(into)

    def read(self, program: str, routine: Routine) -> None:
        """Collect the uses in a routine."""
        for name, kind in routine.chart.tags() if routine.chart else ():
            self.argument(program, Address(name), PREDEFINED_TYPES[kind], ())
        for statement in statements_in(routine.block):
            self._read_statement(program, statement)
        for _, instruction in routine.instructions():
            self._read_instruction(program, instruction)
            if not self._is_second_pass:
                self._parameters.note(program, routine.name, instruction)

    def _unify(self, program: str, a: Operand, b: Operand) -> None:
        """Note that two operands have the same type if one of them is a structure, or has members."""
        kinds = self._kind(program, a), self._kind(program, b)
        kind = next((candidate for candidate in kinds if isinstance(candidate, Structure)), None)
        if not isinstance(a, Address) or not isinstance(b, Address):
            return
        first, second = (self._note_address(program, operand, kind, None) for operand in (a, b))
        if first is None or second is None:
            return
        if first.root.members or second.root.members:
            first.same_as(second)

    # --- instructions and statements

    def _read_instruction(self, program: str, instruction: Instruction) -> None:
        """Note the uses of an instruction's operands; each type suggests the types of the others."""
        if instruction.name in ("GSV", "SSV"):
            self._read_attribute(program, instruction)
        uses, call_operands = self._uses(instruction.name), self._of_call(instruction.name)
        used = list(zip(instruction.operands, chain(uses, repeat(Use.PARAMETERS)), strict=False))
        valued = [operand for operand, use in used if use not in _NAMES and not _is_of_structure(use)]
        partner = self._partner(program, valued)
        guesses: dict[int, Guess] = {}
        for index, (operand, use) in enumerate(used):
            self._read_subscripts(program, operand)
            if isinstance(operand, Operation):
                self._read_operation(program, operand, partner, bits=use in _BITS)
            elif not isinstance(operand, Address) or _is_name(operand, use):
                continue
            elif index < len(call_operands):
                self.argument(program, operand, *call_operands[index])
            else:
                guess = self._note_address(program, operand, *self._types_by_use(use, instruction, partner))
                if guess is not None:
                    guesses[index] = guess
                    self._note_extent(guess, operand, use, instruction)
        if 0 in guesses and 1 in guesses:
            self._note_pair(instruction, guesses[0], guesses[1])

    def _uses(self, name: str) -> Sequence[Use]:
        """Return the uses of an instruction's first operands; the others are parameters."""
        if name == "JSR":
            return Use.ROUTINE, Use.CONSTANT
        spec = self._specs.get(name.upper())
        return spec.operands if spec else ()

    def _note_extent(self, guess: Guess, operand: Address, use: Use, instruction: Instruction) -> None:
        """Note whether an operand is one element or a region."""
        if use in _REGIONS:
            self._note_region(guess, operand, instruction)
        elif not _ends_in_element(operand):
            guess.single = True

    def _note_pair(self, instruction: Instruction, a: Guess, b: Guess) -> None:
        """Note that the operands of a queue instruction have the same type; collect operands of a copy."""
        queue = instruction.name in ("FFL", "FFU", "LFL", "LFU")
        if queue:
            a.same_as(b)
        elif instruction.name in ("COP", "CPS"):
            self._copies.append((a, b))

    def _read_attribute(self, program: str, instruction: Instruction) -> None:
        """Note a use in GSV or SSV; the attribute counts as a member of the instance."""
        if len(instruction.operands) != 4:
            return
        class_name, instance, name, tag = instruction.operands
        owner = BY_CLASS.get(str(class_name).upper())
        if owner is None or not isinstance(instance, Address) or not isinstance(name, Address):
            return
        tag_kind = self._kind(program, tag)
        likely = tag_kind if isinstance(tag_kind, Elementary) and tag_kind is not BOOL else DINT
        self._note_address(program, instance, owner, None)
        self._note_address(program, instance.member(name.name), None, likely)
        member = owner.member(name.name)
        if member is not None and isinstance(tag, Address):
            self._note_address(program, tag, None, member.type)

    def _types_by_use(
        self, use: Use, instruction: Instruction, partner: DataType | None
    ) -> tuple[DataType | None, DataType | None]:
        """Return the type that a use requires, and the type that it suggests."""
        if use is Use.BLOCK:
            return _BLOCKS.get(instruction.name), None
        if use in BY_USE:
            return BY_USE[use], None
        if use in _LIKELY:
            return None, _LIKELY[use]
        if use in _MAY_BE_STRUCTURES and isinstance(partner, Structure):
            return partner, None
        if use in _MAY_BE_TEXT:
            return None, STRING if _is_code(instruction) else partner  # None: a DINT without other uses
        return None, REAL if partner is REAL else DINT

    def argument(self, program: str, operand: Address, kind: DataType, dims: tuple[int, ...]) -> None:
        """Note an argument of an add-on instruction."""
        guess = self._note_address(program, operand, kind, None)
        if guess is not None and dims and not guess.lengths and not _ends_in_element(operand):
            guess.lengths = [min(length, MOST) for length in dims]

    def _note_region(self, guess: Guess, operand: Address, instruction: Instruction) -> None:
        """Note the length of a COP or FLL operand; for other instructions, note that it is an array."""
        length = self._length(instruction)
        if 1 < length <= MOST and (not guess.lengths or _ends_in_element(operand)):
            guess.copied = max(guess.copied, length)

    def _length(self, instruction: Instruction) -> int:
        """Return an instruction's constant length; COMPUTED if it is computed, 0 if it has no length."""
        spec = self._specs.get(instruction.name.upper())
        last = -1  # where COP and FLL have their length
        position = spec.operands.index(Use.PRESET) if spec and Use.PRESET in spec.operands else last
        counted = instruction.operands[position] if position < len(instruction.operands) else None
        if instruction.name == "SIZE" or isinstance(counted, Unknown):
            return COMPUTED
        return counted.value if isinstance(counted, Number) and isinstance(counted.value, int) else 0

    def _partner(self, program: str, operands: Iterable[Operand]) -> DataType | None:
        """Return the type that the other operands suggest: REAL, a string or a structure; otherwise None."""
        kinds = [self._kind(program, operand) for operand in operands]
        structure = next((kind for kind in kinds if isinstance(kind, Structure)), None)
        return structure or (REAL if REAL in kinds else None)

    def _kind(self, program: str, operand: Operand) -> DataType | None:
        """Return the type of an operand by its form, declaration or earlier uses; None if none decides."""
        if isinstance(operand, Number):
            return REAL if isinstance(operand.value, float) else None
        if isinstance(operand, Characters):
            return STRING if len(operand.value) > CODE else None
        if isinstance(operand, Operation):
            return self._kind_of_result(program, operand)
        if not isinstance(operand, Address):
            return None
        if operand.steps and isinstance(operand.steps[-1], BitStep):
            return BOOL
        return self._known(program, operand) or self._guessed(program, operand)

    def _kind_of_result(self, program: str, operation: Operation) -> DataType | None:
        kinds = [self._kind(program, operand) for operand in operation.operands]
        if REAL in kinds:
            return REAL
        return BOOL if BOOL in kinds and operation.name in _LOGICAL else None

    def _guessed(self, program: str, address: Address) -> DataType | None:
        """Return the type that an earlier use requires; None if none does."""
        missing = self._missing(program, address)
        if missing is None:
            return None
        name, steps = missing
        guess = self.found.get(name.upper())
        kind = _required_structure(guess)
        for step in steps:
            if isinstance(step, SubscriptStep):
                continue
            if not isinstance(step, MemberStep):
                return None
            member = kind.member(step.name) if isinstance(kind, Structure) else None
            guess = guess.members.get(step.name.upper()) if guess else None
            kind = _required_structure(guess) if member is None else member.type
        return kind if guess is None or kind is not None else self._likely(guess)

    def _likely(self, guess: Guess) -> DataType | None:
        """Return the type that earlier uses make likely, STRING or BOOL; otherwise None."""
        if self._is_second_pass and guess.root.weak == [STRING]:
            return STRING
        return BOOL if BOOL in guess.root.votes else None

    def _read_statement(self, program: str, statement: Statement) -> None:
        """Note the uses in a statement; `read` handles instructions."""
        if isinstance(statement, Invocation):
            return
        for operand in operands_in(statement):
            self._read_subscripts(program, operand)
        if isinstance(statement, Assignment):
            self._read_assignment(program, statement)
        elif isinstance(statement, If):
            for arm in statement.arms:
                self._read_operation(program, arm.condition, None, bits=True)
        elif isinstance(statement, While | Repeat):
            for operand in operands_in(statement):
                self._read_operation(program, operand, None, bits=True)
        elif isinstance(statement, Case | For):
            for operand in operands_in(statement):
                self._read_operation(program, operand, None, bits=False)

    def _read_assignment(self, program: str, statement: Assignment) -> None:
        """Note the uses in an assignment; the type of each side suggests the type of the other."""
        value, target = statement.value, statement.target
        kind = self._kind(program, target) or self._kind(program, value)
        structure = kind if isinstance(kind, Structure) else None
        logical = isinstance(value, Operation) and (_is_truth(value) or kind is BOOL)
        self._note_address(program, target, structure, BOOL if logical else kind or DINT)
        if isinstance(value, Address):
            self._note_address(program, value, structure, kind or DINT)
        else:
            self._read_operation(program, value, REAL if kind is REAL else None, bits=logical)

    def _read_operation(
        self, program: str, operand: Operand, partner: DataType | None, *, bits: bool
    ) -> None:
        """Note the uses in an expression. With `bits`, its result is a bit; `partner` suggests a type."""
        pending: list[tuple[Operand, bool, DataType | None]] = [(operand, bits, partner)]
        while pending:
            node, is_bit, partner_here = pending.pop()
            if isinstance(node, Address):
                structure = partner_here if isinstance(partner_here, Structure) else None
                self._note_address(program, node, structure, BOOL if is_bit else partner_here or DINT)
            elif isinstance(node, Operation):
                inner_partner = self._partner(program, node.operands) or partner_here
                pending += [
                    (inner, _takes_bits(node, is_bit), inner_partner) for inner in reversed(node.operands)
                ]

    def _read_subscripts(self, program: str, operand: Operand) -> None:
        """Note the uses of tags in an operand's subscripts and bit numbers, which must be integers."""
        for address in addresses_in(operand):
            for step in address.steps:
                inner = step.indices if isinstance(step, SubscriptStep) else ()
                if isinstance(step, BitStep):
                    inner = (step.index,)
                for node in inner:
                    self._read_operation(program, node, None, bits=False)
                    self._note_index(program, node)

    def _note_index(self, program: str, index: Operand) -> None:
        """Note that a subscript is an integer, even if other uses suggest another type."""
        for address in [index] if isinstance(index, Address) else addresses_in(index):
            if not (address.steps and isinstance(address.steps[-1], BitStep)):
                self._note_address(program, address, self._number, None)

    # --- addresses

    def _note_address(
        self, program: str, address: Address, needed: DataType | None, likely: DataType | None
    ) -> Guess | None:
        """Note a use of an address; return the guess of its last member, None for a declared tag or a bit.

        The use requires the type `needed`, or suggests the type `likely`.
        """
        missing = self._missing(program, address)
        if missing is None:
            return None
        name, steps = missing
        guess = self.found.setdefault(name.upper(), Guess(name, self._structures, number=self._number))
        element = False
        for step in steps:
            guess.single = guess.single or not (element or isinstance(step, SubscriptStep | WordStep))
            element = isinstance(step, SubscriptStep | WordStep)
            if isinstance(step, MemberStep):
                guess = guess.member(step.name)
            elif isinstance(step, SubscriptStep):
                guess.subscripts(step)
            elif isinstance(step, WordStep):
                guess.subscripts(SubscriptStep((Number(step.index, str(step.index)),)))
            else:
                index = step.index if isinstance(step, SlashStep) else _bit_of(step)
                guess.root.bit = max(guess.root.bit, index)
                return None
        if needed is not None:
            add_kind(guess.root.votes, needed)
        elif likely is not None:
            add_kind(guess.root.weak, likely)
        return guess


def _is_code(instruction: Instruction) -> bool:
    return any(isinstance(operand, Characters) for operand in instruction.operands)


def _is_of_structure(use: Use) -> bool:
    return isinstance(BY_USE.get(use), Structure)


def _ends_in_element(address: Address) -> bool:
    return bool(address.steps) and isinstance(address.steps[-1], SubscriptStep)


_LOGICAL = ("AND", "OR", "XOR", "NOT")


def _is_logical(operand: Operand) -> bool:
    if not isinstance(operand, Operation):
        return False
    numbers = any(isinstance(inner, Number) for inner in operand.operands)
    return operand.name in RELATIONS or (operand.name in _LOGICAL and not numbers)


def _is_truth(value: Operation) -> bool:
    """Return whether the value of an assignment is a bit, judging by its operators."""
    return value.name in (*RELATIONS, "NOT") or (
        value.name in _LOGICAL and any(map(_is_logical, value.operands))
    )


def _takes_bits(operation: Operation, is_bit: bool) -> bool:
    """Return whether the operands of an operation are bits.

    Args:
        is_bit: whether its result is a bit.
    """
    if operation.name in _LOGICAL and is_bit:
        return True
    return operation.name in RELATIONS and any(map(_is_logical, operation.operands))


def _is_name(operand: Address, use: Use) -> bool:
    """Return whether an operand is a keyword, or the name of something other than a tag."""
    return use in _NAMES or (use is Use.KEYWORD and not operand.steps and plain(operand.name) in KEYWORDS)


def _required_structure(guess: Guess | None) -> DataType | None:
    return None if guess is None else guess.needed


def _bit_of(step: object) -> int:
    index = getattr(step, "index", 0)
    if isinstance(index, Number):
        return int(index.value)
    return index if isinstance(index, int) else 0
