"""From tree to what the back ends run: addresses resolved, operands checked, instructions numbered."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from .addon import LOGIC, OTHERWISE, PRESCAN, AddOn, expand
from .errors import LadderError, Problem, Site
from .instructions import BY_NAME as SPEC_BY_NAME
from .instructions import RELATIONS, Kind, Spec, Use
from .places import (
    AddressError,
    Calculation,
    Constant,
    Group,
    Place,
    Quoted,
    Resolved,
    Resolver,
    is_integer,
    is_number,
)
from .tags import Layout
from .tree import Address, Branch, Instruction, Number, Operand, Origin, Routine, Rung, Series, Unknown
from .types import CONTROL, COUNTER, STRING, TIMER, Elementary, Structure


@dataclass(frozen=True, slots=True)
class Call:
    """Operands of JSR: whom, with what, and where the answers go.

    Attributes:
        routine: name in capitals.
        inputs: values in.
        returns: places for the values out.
    """

    routine: str
    inputs: tuple[Resolved, ...]
    returns: tuple[Place, ...]


ADD_ON = "add-on"
"""Name of the step that calls an add-on instruction; its operand is one `AddOnCall`."""


@dataclass(frozen=True, slots=True)
class AddOnCall:
    """A call of an add-on instruction.

    Attributes:
        name: the add-on.
        instance: the instance's tag.
        enable_in: told whether the rung is true in front of the call.
        enable_out: tells whether it is behind it.
        inputs: what copies the arguments in, each run as a rung of its own.
        outputs: what copies the results out.
        logic: the routine for a true rung, in capitals.
        otherwise: the one for a false rung, None if there is none.
        prescan: the one that runs in prescan, None if there is none.
    """

    name: str
    instance: Group
    enable_in: Place
    enable_out: Place
    inputs: tuple[tuple[Node, ...], ...]
    outputs: tuple[tuple[Node, ...], ...]
    logic: str
    otherwise: str | None
    prescan: str | None

    @property
    def routines(self) -> tuple[str, ...]:
        """The routines that it may run."""
        return tuple(each for each in (self.logic, self.otherwise, self.prescan) if each)


@dataclass(frozen=True, slots=True)
class Step:
    """An instruction, ready to run.

    Attributes:
        name: the instruction.
        kind: input or output.
        operands: resolved; a label or a mode is a str, JSR has one `Call`, an add-on instruction one
            `AddOnCall`, presets are left out.
        site: its number in `Linked.sites`.
    """

    name: str
    kind: Kind
    operands: tuple[Any, ...]
    site: int


@dataclass(frozen=True, slots=True)
class Parallel:
    """A branch, ready to run."""

    legs: tuple[tuple[Node, ...], ...]


Node = Step | Parallel


@dataclass(frozen=True, slots=True)
class Line:
    """A rung, ready to run."""

    number: int
    nodes: tuple[Node, ...]
    origin: Origin
    text: str
    comment: str


@dataclass(frozen=True, slots=True)
class LinkedRoutine:
    """A routine, ready to run.

    Attributes:
        name: its name.
        lines: its rungs.
        labels: number of the rung that a label stands in front of, by label in capitals.
        parameters: what SBR takes, None without SBR.
    """

    name: str
    lines: tuple[Line, ...]
    labels: Mapping[str, int]
    parameters: tuple[Place, ...] | None


@dataclass(slots=True)
class Linked:
    """A program, ready to run.

    Attributes:
        name: its name.
        layout: its memory.
        main: the routine that a scan calls, in capitals.
        routines: routines of rungs, by name in capitals.
        functions: routines in Python, by name in capitals.
        sites: every instruction, for messages.
        presets: initial values of PRE and ACC from the rungs, by path.
        flags: whether a rung uses S:V, S:Z, S:N or S:C; otherwise nobody keeps them.
        override: whether there is an MCR.
    """

    name: str
    layout: Layout
    main: str
    routines: dict[str, LinkedRoutine] = field(default_factory=dict)
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)
    sites: list[Site] = field(default_factory=list)
    presets: dict[str, int] = field(default_factory=dict)
    flags: bool = False
    override: bool = False


class OperandError(ValueError):
    """An operand that an instruction does not take."""

    def __init__(self, text: str, remedy: str) -> None:
        self.remedy = remedy
        super().__init__(text)


class Linker:
    """Links routine by routine and collects what is wrong.

    Attributes:
        linked: the result.
        problems: what is wrong.
    """

    def __init__(
        self, name: str, layout: Layout, main: str, add_ons: Mapping[str, AddOn] = MappingProxyType({})
    ) -> None:
        self.linked = Linked(name, layout, main.upper())
        self.problems: list[Problem] = []
        self._add_ons = add_ons
        self._instances: dict[str, str] = {}
        self._expanded: list[Routine] = []
        self.resolver = Resolver(layout)
        self._where = ""
        self._rung_text = ""
        self._routine = ""
        self._number = 0

    def routine(self, routine: Routine) -> None:
        """Link a routine of rungs, and the routines of the add-on instructions that it calls."""
        self._one(routine)
        while self._expanded:
            self._one(self._expanded.pop(0))

    def _one(self, routine: Routine) -> None:
        self._routine = routine.name
        lines = []
        labels: dict[str, int] = {}
        parameters: tuple[Place, ...] | None = None
        for number, rung in enumerate(routine.rungs):
            line = self._line(number, rung)
            lines.append(line)
            for step in steps_of(line.nodes):
                if step.name == "LBL":
                    self._label(labels, step.operands[0], number, first=line.nodes[0] is step)
                elif step.name == "SBR":
                    parameters = step.operands
                    if number != 0 or line.nodes[0] is not step:
                        self.report(
                            "SBR does not stand first", "make it the first of the routine's first rung"
                        )
        self.linked.routines[routine.name.upper()] = LinkedRoutine(
            routine.name, tuple(lines), labels, parameters
        )

    def report(self, text: str, remedy: str) -> None:
        """Note a problem of the present rung."""
        self.problems.append(Problem(self._where, self._rung_text, text, remedy))

    def _label(self, labels: dict[str, int], label: str, number: int, *, first: bool) -> None:
        if label in labels:
            self.report(f"label {label} stands twice in the routine", "rename one")
        if not first:
            self.report(f"LBL({label}) does not stand first in its rung", "put it first")
        labels[label] = number

    def _line(self, number: int, rung: Rung) -> Line:
        self._number, self._rung_text = number, str(rung)
        self._where = f"routine {self._routine}, rung {number}"
        if rung.origin.file:
            self._where = f"{rung.origin.file}:{rung.origin.line}: {self._where}"
        nodes = self._series(rung.series)
        steps = list(steps_of(nodes))
        if all(step.kind is Kind.INPUT and step.name not in _ALONE for step in steps):
            self.report("the rung has no output", "end it with a coil or another output instruction")
        for step in steps:
            if step.name == "MCR" and nodes[-1] is not step:
                self.report("MCR does not stand last in its rung", "move what follows to a rung of its own")
        return Line(number, nodes, rung.origin, self._rung_text, rung.comment)

    def _series(self, series: Series) -> tuple[Node, ...]:
        return tuple(
            Parallel(tuple(map(self._series, element.legs)))
            if isinstance(element, Branch)
            else self._step(element)
            for element in series
        )

    def _step(self, instruction: Instruction) -> Step:
        definition = self._add_ons.get(instruction.name.upper())
        spec = definition.spec if definition else SPEC_BY_NAME[instruction.name]
        site = len(self.linked.sites)
        self.linked.sites.append(Site(self.linked.name, self._routine, self._number, str(instruction)))
        if definition:
            return Step(ADD_ON, Kind.BOTH, self._add_on(definition, instruction), site)
        try:
            operands = self._operands(spec, instruction)
        except (AddressError, OperandError) as error:
            self.report(f"{instruction}: {error}", error.remedy)
            operands = ()
        if spec.name == "MCR":
            self.linked.override = True
        return Step(spec.name, spec.kind, operands, site)

    def _add_on(self, definition: AddOn, call: Instruction) -> tuple[AddOnCall, ...]:
        """Link a call of an add-on instruction; its routines are linked later on."""
        try:
            instance = self._instance(definition, call)
            expansion = expand(definition, call)
        except (AddressError, OperandError) as error:
            self.report(f"{call}: {error}", error.remedy)
            return ()
        except LadderError as error:
            self.report(f"{call}: {error}", f"operands of {definition.name} are {_signature(definition)}")
            return ()
        self._expanded += expansion.routines.values()
        names = {role: routine.name.upper() for role, routine in expansion.routines.items()}
        return (
            AddOnCall(
                definition.name,
                instance,
                instance.member("EnableIn"),
                instance.member("EnableOut"),
                tuple(map(self._series, expansion.inputs)),
                tuple(map(self._series, expansion.outputs)),
                names[LOGIC],
                names.get(OTHERWISE),
                names.get(PRESCAN),
            ),
        )

    def _instance(self, definition: AddOn, call: Instruction) -> Group:
        instance = self.resolver.operand(call.operands[0])
        if not isinstance(instance, Group) or instance.dims or instance.type != definition.structure:
            raise OperandError(
                f"{call.operands[0]} is {described(instance)}, an instance of {definition.name} is needed",
                f"declare a tag of type {definition.name} for this call",
            )
        if instance.indices:
            raise OperandError(
                f"{instance.text} is an element of an array", "give every call a tag of its own as instance"
            )
        if instance.path in self._instances:
            known = self._instances[instance.path]
            raise OperandError(
                f"{instance.path} is called in {known} already", "give each call an instance of its own"
            )
        self._instances[instance.path] = self._where
        return instance

    def _operands(self, spec: Spec, instruction: Instruction) -> tuple[Any, ...]:
        given = instruction.operands
        if spec.name == "JSR":
            return (self._call(given),)
        if spec.variadic:
            take = self._value if spec.name == "RET" else self._answer
            return tuple(take(each) for each in given)
        operands = [
            self._operand(use, operand)
            for use, operand in zip(spec.operands, given, strict=False)
            if use is not Use.PRESET
        ]
        if Use.PRESET in spec.operands:
            self._presets(operands[0], given[1:])
        checks = _EXTRA.get(spec.name)
        if checks:
            checks(*operands)
        return tuple(operands)

    def _operand(self, use: Use, operand: Operand) -> Any:
        if use in (Use.LABEL, Use.MODE):
            if not isinstance(operand, Address) or operand.steps:
                raise OperandError(f"{operand} is no name", "write a name")
            return operand.name.upper()
        resolved = self.resolver.operand(operand)
        self._note_flags(operand)
        demand = _DEMANDS[use]
        if not demand.met(resolved):
            raise OperandError(f"{operand} is {described(resolved)}, {demand.text} is needed", demand.remedy)
        if use in _WRITTEN and isinstance(resolved, (Place, Group)):
            self._refuse_input(operand, resolved)
        return resolved

    def _refuse_input(self, operand: Operand, resolved: Place | Group) -> None:
        leaf = (
            resolved.leaf
            if isinstance(resolved, Place)
            else resolved.layout.leaves.get(resolved.path.upper())
        )
        if leaf is not None and leaf.slot is not None and not leaf.output:
            raise OperandError(f"{operand} is an input and written by the module", "write a tag of your own")

    def _note_flags(self, operand: Operand) -> None:
        if isinstance(operand, Address) and operand.name.upper() in _KEPT_FLAGS:
            self.linked.flags = True

    def _presets(self, structure: Group, given: tuple[Operand, ...]) -> None:
        for name, operand in zip(("PRE", "ACC"), given, strict=False):
            if isinstance(operand, Unknown):
                continue
            if not isinstance(operand, Number) or not isinstance(operand.value, int):
                raise OperandError(
                    f"{name} {operand} is no whole number", f"write a number, or MOV to .{name}"
                )
            place = structure.member(name)
            if place.fixed_index is None or place.leaf.dims:
                raise OperandError(
                    f"{name} of an array element can't stand in the rung", "write ? and MOV to it"
                )
            known = self.linked.presets.setdefault(place.leaf.path, operand.value)
            if known != operand.value:
                raise OperandError(
                    f"{place.leaf.path} is {known} in another rung", "write the same number, or ?"
                )

    def _call(self, given: tuple[Operand, ...]) -> Call:
        name = given[0]
        if not isinstance(name, Address) or name.steps:
            raise OperandError(f"{name} is no routine", "write the routine's name")
        count = 0
        if len(given) > 1:
            number = given[1]
            if not isinstance(number, Number) or number.value not in range(len(given) - 1):
                raise OperandError(f"{number} is no number of inputs", f"allowed are 0 to {len(given) - 2}")
            count = int(number.value)
        inputs = tuple(map(self._value, given[2 : 2 + count]))
        return Call(name.name.upper(), inputs, tuple(map(self._answer, given[2 + count :])))

    def _value(self, operand: Operand) -> Resolved:
        resolved = self.resolver.operand(operand)
        if not isinstance(resolved, (Place, Constant)):
            raise OperandError(f"{operand} is {described(resolved)}, one value is needed", "pass its members")
        return resolved

    def _answer(self, operand: Operand) -> Place:
        resolved = self.resolver.operand(operand)
        if not isinstance(resolved, Place):
            raise OperandError(
                f"{operand} is {described(resolved)}, a tag is needed", "name the tag to write"
            )
        self._refuse_input(operand, resolved)
        return resolved


def steps_of(nodes: tuple[Node, ...]) -> list[Step]:
    """Return the instructions in the order in which they execute."""
    return list(_steps(nodes))


def _steps(nodes: tuple[Node, ...]) -> Iterator[Step]:
    for node in nodes:
        if isinstance(node, Parallel):
            for leg in node.legs:
                yield from _steps(leg)
            continue
        calls = [each for each in node.operands if isinstance(each, AddOnCall)]
        for call in calls:
            for series in call.inputs:
                yield from _steps(series)
        yield node
        for call in calls:
            for series in call.outputs:
                yield from _steps(series)


def _signature(definition: AddOn) -> str:
    named = [f"{each.name} : {each.type.name} ({each.way.value})" for each in definition.required]
    return ", ".join(["the instance", *named])


def described(resolved: Resolved) -> str:
    """Say what an operand is."""
    if isinstance(resolved, Constant):
        return f"the number {resolved.value}"
    if isinstance(resolved, Place):
        return f"{'an' if resolved.type.name == 'INT' else 'a'} {resolved.type.name}"
    if isinstance(resolved, Group):
        return f"an array of {resolved.type.name}" if resolved.dims else f"a {resolved.type.name}"
    return "a string" if isinstance(resolved, Quoted) else "an expression"


# --- what operands have to be


@dataclass(frozen=True, slots=True)
class _Demand:
    """What an operand has to be, in code and in words, and what to do if it is not."""

    met: Callable[[Resolved], bool]
    text: str
    remedy: str


def _is_bit(resolved: Resolved) -> bool:
    return isinstance(resolved, Place) and resolved.type.is_bool


def _is_plain_number(resolved: Resolved) -> bool:
    return isinstance(resolved, (Place, Constant)) and not resolved.type.is_bool


def _is_plain_integer(resolved: Resolved) -> bool:
    return isinstance(resolved, (Place, Constant)) and resolved.type.is_integer


def _is_string(resolved: Resolved) -> bool:
    return isinstance(resolved, Quoted) or _is_structure(resolved, STRING)


def _is_structure(resolved: Resolved, *types: Structure) -> bool:
    return isinstance(resolved, Group) and not resolved.dims and resolved.type in types


def _is_arithmetic(resolved: Resolved) -> bool:
    if not isinstance(resolved, Calculation):
        return is_number(resolved)
    if resolved.name in RELATIONS:
        return False
    if resolved.name in BITWISE:
        return all(is_integer(each) and _is_arithmetic(each) for each in resolved.operands)
    return all(map(_is_arithmetic, resolved.operands))


def _is_condition(resolved: Resolved) -> bool:
    if not isinstance(resolved, Calculation):
        return False
    if resolved.name in RELATIONS:
        return all(map(_is_arithmetic, resolved.operands))
    return resolved.name in BITWISE and all(map(_is_condition, resolved.operands))


def _is_region(resolved: Resolved) -> bool:
    """Something in memory with bytes: no BOOL, no bit, no array of BOOL."""
    if isinstance(resolved, Place):
        return not resolved.type.is_bool
    return isinstance(resolved, Group) and not (
        isinstance(resolved.type, Elementary) and resolved.type.is_bool
    )


BITWISE = ("AND", "OR", "XOR", "NOT")
"""Operators on bits: computed in integers, even where the rest of the expression is REAL."""

_KEPT_FLAGS = frozenset({"S:V", "S:Z", "S:N", "S:C"})
_ALONE = frozenset({"NOP", "AFI", "LBL", "SBR"})
_WRITTEN = frozenset({Use.COIL, Use.LATCH, Use.STORAGE, Use.TARGET, Use.INTEGER_TARGET, Use.DESTINATION})

_A_BIT = _Demand(_is_bit, "a bit", "use a BOOL or a bit of an integer (tag.3), or compare the number")
_A_NUMBER = _Demand(_is_plain_number, "a number", "use a numeric tag; CPT takes expressions")
_AN_INTEGER = _Demand(_is_plain_integer, "an integer", "use a SINT, INT, DINT or LINT")

_DEMANDS = {
    Use.BIT: _A_BIT,
    Use.COIL: _A_BIT,
    Use.LATCH: _A_BIT,
    Use.STORAGE: _A_BIT,
    Use.NUMBER: _A_NUMBER,
    Use.TEXT_OR_NUMBER: _Demand(
        lambda each: _is_plain_number(each) or _is_string(each), "a number or a STRING", "compare bits by XIC"
    ),
    Use.INTEGER: _AN_INTEGER,
    Use.TARGET: _Demand(
        lambda each: isinstance(each, Place) and not each.type.is_bool,
        "a numeric tag to write",
        "use a numeric tag; bits are written by OTE, OTL, OTU",
    ),
    Use.INTEGER_TARGET: _Demand(
        lambda each: isinstance(each, Place) and each.type.is_integer,
        "an integer tag to write",
        "use a SINT, INT, DINT or LINT",
    ),
    Use.EXPRESSION: _Demand(
        _is_arithmetic, "an arithmetic expression", "compare with CMP; AND, OR, XOR, NOT take integers"
    ),
    Use.CONDITION: _Demand(_is_condition, "a comparison", "write a relation such as a>b, or a>b AND c<=d"),
    Use.TIMER: _Demand(lambda each: _is_structure(each, TIMER), "a TIMER", "declare the tag as TIMER"),
    Use.COUNTER: _Demand(
        lambda each: _is_structure(each, COUNTER), "a COUNTER", "declare the tag as COUNTER"
    ),
    Use.RESETTABLE: _Demand(
        lambda each: _is_structure(each, TIMER, COUNTER, CONTROL),
        "a TIMER, COUNTER or CONTROL",
        "clear other tags with CLR or OTU",
    ),
    Use.SOURCE: _Demand(_is_region, "a tag with bytes", "copy numbers, structures or arrays of them"),
    Use.DESTINATION: _Demand(_is_region, "a tag with bytes", "copy to numbers, structures or arrays of them"),
    Use.CONSTANT: _Demand(
        lambda each: isinstance(each, Constant) and each.type.is_integer, "a constant", "write a whole number"
    ),
}


def _check_btd(
    source: Resolved, source_bit: Constant, target: Place, target_bit: Constant, length: Constant
) -> None:
    limits = (
        (source_bit, 0, source.type.bits - 1 if isinstance(source, (Place, Constant)) else 31, "source bit"),
        (target_bit, 0, target.type.bits - 1, "destination bit"),
        (length, 1, target.type.bits, "length"),
    )
    for given, low, high, what in limits:
        if not low <= given.value <= high:
            raise OperandError(f"{what} {given.value} is out of range", f"allowed are {low} to {high}")


def _check_swpb(source: Resolved, _mode: str, target: Place) -> None:
    allowed = {("INT", "INT"), ("INT", "DINT"), ("DINT", "DINT")}
    if not isinstance(source, Place) or (source.type.name, target.type.name) not in allowed:
        raise OperandError(
            f"SWPB does not go from {described(source)} to {described(target)}",
            "allowed are INT to INT or DINT, and DINT to DINT",
        )


def _check_same_kind(a: Resolved, b: Resolved) -> None:
    if _is_string(a) != _is_string(b):
        raise OperandError(f"{described(a)} and {described(b)} can't be compared", "compare like with like")


def _check_fll(_source: Resolved, target: Resolved, _length: Resolved) -> None:
    if isinstance(target, Group) and isinstance(target.type, Structure):
        raise OperandError(f"FLL does not fill a {target.type.name}", "COP a structure over it")


_EXTRA: Mapping[str, Callable[..., None]] = {
    "BTD": _check_btd,
    "SWPB": _check_swpb,
    "FLL": _check_fll,
    **dict.fromkeys(("EQU", "NEQ", "GRT", "GEQ", "LES", "LEQ"), _check_same_kind),
}
