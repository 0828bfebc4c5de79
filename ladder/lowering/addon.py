"""Add-on instructions: user-defined instructions with parameters [1756-PM010].

A definition has parameters, local tags and up to four routines of rungs. An instance is a tag of the
definition's type; its members are EnableIn, EnableOut, the parameters passed by value, and the local
tags. The operands of a call are the instance and the arguments of the required parameters:

    INSTRUCTION Average
    INPUT A : DINT REQUIRED
    INPUT B : DINT REQUIRED
    OUTPUT Mean : DINT
    ROUTINE Logic
    CPT(Mean,(A+B)/2);
    END
    END INSTRUCTION

    XIC(Run)Average(Level,Left,Right)GRT(Level.Mean,100)OTE(High);

A call depends on the scan mode [1756-PM010]:

| mode | inputs | then | outputs |
|---|---|---|---|
| the rung is true | copied in | Logic runs | copied out |
| it is false | copied in | EnableInFalse runs | copied out |
| it is false, no EnableInFalse | copied in | nothing | unchanged |
| prescan | copied in | Logic is prescanned, then Prescan runs | copied out |
| postscan, of an SFC action | copied in | Logic is postscanned, then Postscan runs | copied out |

Only required parameters are copied. The rung condition after the call is EnableOut. EnableOut follows the
rung unless a routine writes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from enum import Enum
from functools import cached_property
from types import MappingProxyType

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site

from ..instructions import BY_NAME
from ..instructions.addons import ADD_ON_CALL, with_off_calls
from ..instructions.stubbed import specs_of_stubs
from ..model.errors import LadderError
from ..model.routine import Routine
from ..model.spec import Spec, Use
from ..model.statements import Invocation, operands_in, statements_in
from ..model.stubs import Stub
from ..model.tagref import operand_of
from ..model.tags import OPEN, TRUTHS, Tag
from ..model.tree import (
    Address,
    Instruction,
    Operand,
    Operation,
    Series,
    Statement,
    SubscriptStep,
    addresses_in,
    instructions_of,
    number,
    too_deep,
)
from ..model.types import BOOL, DataType, Member, Structure, count_of

LOGIC, OTHERWISE, PRESCAN, POSTSCAN = "Logic", "EnableInFalse", "Prescan", "Postscan"
ROUTINES = (LOGIC, OTHERWISE, PRESCAN, POSTSCAN)
"""Roles of routines in a definition; only Logic is mandatory."""

ENABLES = ("EnableIn", "EnableOut")
"""Members of every instance that contain the rung condition before and after the call."""

REFUSED = ("JSR", "SBR", "RET", "FOR", "BRK")
"""Instructions not allowed in a definition, because it can't call routines [1756-PM010]."""


class ParameterMode(Enum):
    """Direction of a parameter in a call."""

    INPUT = "INPUT"  # by value, before the routine runs
    OUTPUT = "OUTPUT"  # by value, after the routine has run
    INOUT = "INOUT"  # by reference: the routine reads and writes the caller's tag
    LOCAL = "LOCAL"  # not passed: the instance's own tag


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter or a local tag of an add-on instruction."""

    name: str
    type: DataType  # for INOUT, the type of the argument
    mode: ParameterMode
    dims: tuple[int, ...] = ()  # length per dimension, none for a single value
    required: bool = False  # whether a call has an argument for it; always true for an INOUT
    comment: str = ""
    initial: object = None  # initial value in every instance, see `tags.Tag`; None = zero, or an INOUT
    at: str = ""  # the part of a local tag that it is an alias of; "" with its own memory


@dataclass(frozen=True)
class AddOn:
    """The checked definition of an add-on instruction; calling it in Python returns a call instruction."""

    name: str
    parameters: tuple[Parameter, ...]  # parameters and local tags
    routines: tuple[Routine, ...]  # Logic, EnableInFalse, Prescan, Postscan
    comment: str = ""

    def __post_init__(self) -> None:
        """Raise a LadderError if a name is taken, Logic is missing, or a routine has an error."""
        if self.name.upper() in BY_NAME:
            raise LadderError(f"{self.name} is a built-in instruction; rename the add-on")
        names = {name.upper() for name in ENABLES}
        for parameter in self.parameters:
            if parameter.name.upper() in names:
                raise LadderError(f"add-on {self.name}: {parameter.name} is declared twice")
            names.add(parameter.name.upper())
        if self.routine(LOGIC) is None:
            raise LadderError(f"add-on {self.name} has no routine {LOGIC}")
        for routine in self.routines:
            for site, text in self.problems_in(routine):
                raise LadderError(f"add-on {self.name}, routine {routine.name}, {site.place}: {text}", site)

    def with_routines(self, routines: tuple[Routine, ...]) -> AddOn:
        """Return the add-on with other routines; the type of its instances stays the same."""
        result = replace(self, routines=routines)
        result.__dict__["structure"] = self.structure
        return result

    def problems_in(self, routine: Routine) -> Iterator[tuple[Site, str]]:
        """Yield the site and text of each error in a routine of the add-on."""
        known = {name.upper() for name in (*ENABLES, *(parameter.name for parameter in self.parameters))}
        site = Site(routine=routine.name, unit=routine.unit)
        for rung_number, rung in enumerate(routine.rungs):
            deep = too_deep(rung.series)
            if deep:
                yield replace(site, rung=rung_number), deep
                continue
            for instruction in instructions_of(rung.series):
                for text in self._instruction_problems(instruction, known):
                    yield (
                        replace(site, rung=rung_number, instruction=str(instruction)),
                        f"{instruction}: {text}",
                    )
        for statement in statements_in(routine.statements or ()):
            for text in self._statement_problems(statement, known):
                yield replace(site, rung=statement.line), f"{statement.head}: {text}"

    def _statement_problems(self, statement: Statement, known: set[str]) -> Iterator[str]:
        if isinstance(statement, Invocation):
            return self._instruction_problems(statement.instruction, known)
        addresses = (address for operand in operands_in(statement) for address in addresses_in(operand))
        return self._name_problems(addresses, known)

    def _instruction_problems(self, instruction: Instruction, known: set[str]) -> Iterator[str]:
        if instruction.name in REFUSED:
            yield f"{instruction.name} is not allowed in an add-on instruction"
        else:
            yield from self._name_problems(_instruction_addresses(instruction), known)

    def _name_problems(self, addresses: Iterable[Address], known: set[str]) -> Iterator[str]:
        for address in addresses:
            if address.name.upper() not in known and not _is_always_known(address):
                names = ", ".join(parameter.name for parameter in self.parameters)
                yield f"no parameter or local tag {address.name}; choose from {names}"

    def __call__(self, instance: object, *arguments: object) -> Instruction:
        """Return a call, given the instance's tag and then the required parameters in order."""
        if len(arguments) != len(self.required):
            names = ", ".join(parameter.name for parameter in self.required)
            expected = f"an instance and {len(self.required)} operands ({names})"
            raise LadderError(f"{self.name} needs {expected}; the call has {len(arguments)} operands")
        return Instruction(self.name, tuple(map(operand_of, (instance, *arguments))))

    @cached_property
    def required(self) -> tuple[Parameter, ...]:
        """The parameters that need an argument, in call order."""
        return tuple(
            parameter
            for parameter in self.parameters
            if parameter.required or parameter.mode is ParameterMode.INOUT
        )

    @property
    def operand_types(self) -> tuple[tuple[DataType, tuple[int, ...]], ...]:
        """Type and dimensions of the operands of a call."""
        return ((self.structure, ()), *((parameter.type, parameter.dims) for parameter in self.required))

    @cached_property
    def spec(self) -> Spec:
        """The add-on's instruction spec, for the parser."""
        return replace(
            ADD_ON_CALL, name=self.name, operands=(Use.INSTANCE, *[Use.ARGUMENT] * len(self.required))
        )

    @cached_property
    def inouts(self) -> tuple[Tag, ...]:
        """The InOuts as tags; one that is subscripted but has no dimensions is an array of any length."""
        subscripted = {
            address.name.upper()
            for routine in self.routines
            for address in _routine_addresses(routine)
            if address.steps and isinstance(address.steps[0], SubscriptStep)
        }
        return tuple(
            Tag(
                parameter.name,
                parameter.type,
                parameter.dims or ((OPEN,) if parameter.name.upper() in subscripted else ()),
            )
            for parameter in self.parameters
            if parameter.mode is ParameterMode.INOUT
        )

    @cached_property
    def structure(self) -> Structure:
        """Type of an instance."""
        members = [Member(name, BOOL) for name in ENABLES]
        members += [
            Member(parameter.name, parameter.type, parameter.dims, initial=parameter.initial, at=parameter.at)
            for parameter in self.parameters
            if parameter.mode is not ParameterMode.INOUT
        ]
        return Structure(self.name, tuple(members))

    def routine(self, name: str) -> Routine | None:
        """Return a routine by its name in any case; None if it does not exist."""
        return next((routine for routine in self.routines if routine.name.upper() == name.upper()), None)


def specs_of(
    add_ons: Mapping[str, AddOn],
    stubs: Mapping[str, Stub] = MappingProxyType({}),
    specs: Mapping[str, Spec] = BY_NAME,
) -> Mapping[str, Spec]:
    """Return all instruction specs by name in capitals: built-in ones, add-ons and stubs."""
    addon_specs = with_off_calls({name: add_on.spec for name, add_on in add_ons.items()})
    return {**specs, **addon_specs, **specs_of_stubs(stubs)}


def _is_always_known(address: Address) -> bool:
    """Return whether an address needs no declaration: a status flag, TRUE or FALSE."""
    name = address.name.upper()
    return name.startswith("S:") or (name in TRUTHS and not address.steps)


def _instruction_addresses(instruction: Instruction) -> Iterator[Address]:
    for use, operand in zip(_uses(instruction), instruction.operands, strict=False):
        if use not in (Use.LABEL, Use.MODE, Use.PASSES, Use.KEYWORD):
            yield from addresses_in(operand)


def _routine_addresses(routine: Routine) -> Iterator[Address]:
    for rung in routine.rungs:
        for instruction in instructions_of(rung.series):
            yield from _instruction_addresses(instruction)
    for statement in statements_in(routine.statements or ()):
        for operand in operands_in(statement):
            yield from addresses_in(operand)


def _uses(instruction: Instruction) -> tuple[Use, ...]:
    spec = BY_NAME.get(instruction.name)
    return spec.operands if spec else (Use.ARGUMENT,) * len(instruction.operands)


# --- a call as rungs


@dataclass(frozen=True, slots=True)
class Copies:
    """The rungs of the caller that copy a call's parameters, and the arguments of its InOuts."""

    inputs: tuple[Series, ...]  # rungs that copy the arguments in
    outputs: tuple[Series, ...]  # rungs that copy the results out
    handed: Mapping[str, Address]  # arguments of the InOuts, by name


def copies_of(definition: AddOn, instance: Address, call: Instruction) -> Copies:
    """Return the copies of a call, or raise a LadderError for a wrong operand."""
    inputs, outputs, handed = [], [], {}
    for parameter, argument in zip(definition.required, call.operands[1:], strict=True):
        instance_member = instance.member(parameter.name)
        if parameter.mode is ParameterMode.INPUT:
            inputs.append(_copy(parameter, argument, instance_member))
            continue
        if not isinstance(argument, Address):
            raise LadderError(f"{parameter.name} of {definition.name} needs a tag, not {argument}")
        if parameter.mode is ParameterMode.OUTPUT:
            outputs.append(_copy(parameter, instance_member, argument))
        else:
            handed[parameter.name] = argument
    return Copies(tuple(inputs), tuple(outputs), handed)


def _copy(parameter: Parameter, source: Operand, target: Operand) -> Series:
    """Return the rung that copies one parameter."""
    if parameter.dims or isinstance(parameter.type, Structure):
        return (Instruction("COP", (source, target, number(count_of(parameter.dims)))),)
    if parameter.type is not BOOL:
        if isinstance(source, Operation):
            return (Instruction("CPT", (target, source)),)
        return (Instruction("MOV", (source, target)),)
    return (_contact(parameter, source), Instruction("OTE", (target,)))


def _contact(parameter: Parameter, source: Operand) -> Instruction:
    """Return the instruction that passes power if the argument of a BOOL is on."""
    if isinstance(source, Address):
        return Instruction("XIC", (source,))
    if isinstance(source, Operation):
        return Instruction("IF", (source,))
    if str(source) not in ("0", "1"):
        raise LadderError(f"{parameter.name} needs a bit, 0 or 1, not {source}")
    return Instruction("NOP" if str(source) == "1" else "AFI")
