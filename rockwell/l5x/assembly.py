"""Parts of a document put together: a `Controller` that can be built, made again after each refusal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ...ladder.build.addon import AddOn
from ...ladder.build.controller import Controller
from ...ladder.model.errors import LadderError
from ...ladder.model.schedule import Task, TaskKind
from ...ladder.model.stubs import Stub, Stubs
from ...ladder.model.tags import OPEN, Alias, Declaration, Tag
from ...ladder.model.tree import (
    Address,
    BitStep,
    Instruction,
    MemberStep,
    Routine,
    Rung,
    SubscriptStep,
    number,
)
from ...ladder.model.types import DINT, INT, DataType, Elementary, Structure, count_of
from .report import Report

CALLS = "scanrack_calls"
"""Name of the routine that calls the routines of an export that has no main routine."""

CLEARS = "scanrack_clears"
"""Name of the fault routine of programs without one, in a trial that goes on after a fault."""

FAULT_RECORD = 11
"""Words of a MajorFaultRecord [1756-PM014]."""

MADE = 256
"""Elements of an array that is made for an InOut of any length."""

MOST_MADE = 1_000_000
"""Values of all tags that are made for add-on instructions."""

_ZEROS, _INSTANCE, _ARGUMENT = "scanrack_zeros", "scanrack_instance", "scanrack_argument"


@dataclass(slots=True)
class ProgramPart:
    """A program, ready to be put into a controller.

    Attributes:
        main: its main routine, None for the first.
        fault: its fault routine.
        declarations: its tags.
        routines: its routines, by name in capitals.
        functions: replacements of routines that are missing in the file or refused, by name in capitals.
    """

    name: str
    main: str | None = None
    fault: str | None = None
    declarations: list[Declaration] = field(default_factory=list)
    routines: dict[str, Routine] = field(default_factory=dict)
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)

    def with_fault_routine(self) -> ProgramPart:
        """Return the same program with a routine that clears its major faults."""
        zeros = Address(_ZEROS, (SubscriptStep((number(0),)),))
        record = (Address("Program"), Address("THIS"), Address("MajorFaultRecord"), zeros)
        routine = Routine(CLEARS, (Rung((Instruction("SSV", record),)),))
        return replace(
            self,
            fault=CLEARS,
            declarations=[*self.declarations, Tag(_ZEROS, DINT, (FAULT_RECORD,))],
            routines={**self.routines, CLEARS.upper(): routine},
            main=self.main or next(iter(self.routines.values())).name if self.routines else self.main,
        )


@dataclass(slots=True)
class Parts:
    """A document's parts.

    Attributes:
        name: the controller's name.
        declarations: its tags.
        programs: by name in capitals.
        tasks: its tasks; none for one that runs all programs.
        add_ons: by name in capitals.
        stubs: replacements of instructions, by name in capitals.
        uncalled: add-ons that `harness_of` leaves out, in capitals.
        cards: what sits in the slots of the rack: catalog numbers.
    """

    name: str
    declarations: list[Declaration] = field(default_factory=list)
    programs: dict[str, ProgramPart] = field(default_factory=dict)
    tasks: list[Task] = field(default_factory=list)
    add_ons: dict[str, AddOn] = field(default_factory=dict)
    stubs: dict[str, Stub] = field(default_factory=dict)
    uncalled: set[str] = field(default_factory=set)
    cards: Mapping[int, str] = field(default_factory=dict)
    _indexes: dict[str, tuple[int, dict[str, Declaration]]] = field(default_factory=dict)

    def assemble(self, report: Report, tasks: Sequence[Task] | None = None) -> Controller:
        """Return a new controller of these parts; what it does not take is noted.

        Args:
            report: gets the notes.
            tasks: other tasks than the document's.
        """
        controller = Controller(self.name)
        controller.use(*self.add_ons.values())
        controller.take_stubs(Stubs(self.stubs, cards=self.cards))
        self.declarations = _added(controller, self.declarations, report)
        for part in self.programs.values():
            program = controller.program(part.name, main=part.main, fault=part.fault)
            part.declarations = _added(program, part.declarations, report)
            for routine in part.routines.values():
                program.add_routine(routine)
            for function in part.functions.values():
                program.function(function)
        for task in self.tasks if tasks is None else tasks:
            controller.add_task(task)
        return controller

    def operands_of(self, name: str) -> tuple[tuple[DataType, tuple[int, ...]], ...]:
        """Return type and dimensions of the operands of an add-on instruction; none for another one."""
        definition = self.add_ons.get(name.upper())
        return definition.operand_types if definition is not None else ()

    def with_fault_routines(self) -> Parts:
        """Return the same, with a fault routine that clears the fault in every program without one."""
        programs = {
            name: each if each.fault else each.with_fault_routine() for name, each in self.programs.items()
        }
        return replace(self, programs=programs, _indexes={})

    def known(self, program: str, address: Address) -> DataType | None:
        """Return the type of a declared address in a program, None if it is not declared."""
        address = self.without_aliases(program, address)
        tag = self.declaration(program, address.name)
        return _type_at(tag, address) if isinstance(tag, Tag) else None

    def declaration(self, program: str, name: str) -> Declaration | None:
        r"""Return what a name means in a program; `\Main.Run` means the tag of program Main."""
        scopes = [program, ""]
        if name.startswith("\\"):
            owner, _, name = name[1:].partition(".")
            scopes = [owner]
        for scope in scopes:
            part = self.programs.get(scope.upper())
            declared = self.declarations if not scope else part.declarations if part else []
            found = self._index(scope, declared).get(name.upper())
            if found is not None:
                return found
        return None

    def _index(self, scope: str, declared: list[Declaration]) -> dict[str, Declaration]:
        count, index = self._indexes.get(scope.upper(), (-1, {}))
        if count != len(declared):
            index = {each.name.upper(): each for each in declared}
            self._indexes[scope.upper()] = len(declared), index
        return index

    def without_aliases(self, program: str, address: Address) -> Address:
        """Return an address with its aliases followed, as far as they go."""
        for _ in range(20):
            declared = self.declaration(program, address.name)
            if not isinstance(declared, Alias):
                break
            address = Address(declared.target.name, declared.target.steps + address.steps)
        return address


def _added(to: Any, declarations: list[Declaration], report: Report) -> list[Declaration]:
    """Add declarations; return the accepted ones."""
    taken = []
    for each in declarations:
        try:
            to.add(each)
            taken.append(each)
        except LadderError as error:
            report.note(each.name, f"it is not declared: {error}")
    return taken


def _type_at(tag: Tag, address: Address) -> DataType | None:
    kind: DataType = tag.type
    for step in address.steps:
        if isinstance(step, MemberStep):
            member = kind.member(step.name) if isinstance(kind, Structure) else None
            if member is None:
                return None
            kind = member.type
        elif isinstance(step, BitStep):
            return None
        elif not isinstance(step, SubscriptStep):
            return INT
    return kind


def without(routine: Routine, *places: int) -> Routine:
    """Return a routine with empty rungs at places; one of statements without statements."""
    if routine.statements is not None:
        return replace(routine, statements=())
    rungs = list(routine.rungs)
    for place in places:
        rungs[place] = Rung((), rungs[place].comment, rungs[place].origin)
    return replace(routine, rungs=tuple(rungs))


def harness_of(parts: Parts) -> Parts:
    """Return a controller that calls every add-on instruction once: one program each, of its name.

    Those for whose InOuts there is no room are left out, and those that can't be called so.
    """
    programs: dict[str, ProgramPart] = {}
    counts: dict[int, int] = {}
    left = MOST_MADE
    for key, definition in parts.add_ons.items():
        lengths = {each.name: each.dims for each in definition.inouts}
        tags = [Tag(_INSTANCE, definition.structure)]
        for place, each in enumerate(definition.required):
            dims = tuple(MADE if length == OPEN else length for length in lengths.get(each.name, each.dims))
            tags.append(Tag(f"{_ARGUMENT}{place}", each.type, dims))
        taken = sum(_values(each.type, counts) * count_of(each.dims) for each in tags)
        if key in parts.uncalled or taken > left:
            continue
        left -= taken
        rung = Rung((Instruction(definition.name, tuple(Address(each.name) for each in tags)),))
        programs[key] = ProgramPart(
            definition.name, declarations=list(tags), routines={"MAIN": Routine("Main", (rung,))}
        )
    tasks = trial_tasks(parts, [each.name for each in programs.values()])
    return Parts(parts.name, [], programs, tasks, parts.add_ons, parts.stubs, cards=parts.cards)


def _values(kind: DataType, counts: dict[int, int]) -> int:
    """Count the values in an element of a type; `counts` caches by identity."""
    if isinstance(kind, Elementary):
        return 1
    if id(kind) not in counts:
        counts[id(kind)] = sum(_values(each.type, counts) * count_of(each.dims) for each in kind.own)
    return counts[id(kind)]


def call_of(routine: Routine) -> Rung:
    """Return a rung that calls a routine, with zeros for what its SBR takes."""
    inputs = 0
    first = routine.rungs[0].series[:1] if routine.rungs else ()
    for each in first:
        if isinstance(each, Instruction) and each.name == "SBR":
            inputs = len(each.operands)
    zeros = (number(0),) * inputs
    return Rung((Instruction("JSR", (Address(routine.name), number(inputs), *zeros)),))


def does_nothing(name: str) -> Callable[..., Any]:
    """Return a routine in Python that takes any inputs and does nothing."""

    def routine(_tags: object, *_inputs: object) -> None:
        """Do nothing."""

    routine.__name__ = name
    return routine


def trial_tasks(parts: Parts, programs: Iterable[str]) -> list[Task]:
    """Return a task that runs programs, and the tasks that EVENT may trigger, which run nothing then."""
    events = (each for each in parts.tasks if each.kind is TaskKind.EVENT)
    return [*implicit_task(programs), *(replace(each, programs=()) for each in events)]


def implicit_task(programs: Iterable[str]) -> list[Task]:
    """Return a continuous task that runs programs."""
    return [Task("Trial", TaskKind.CONTINUOUS, tuple(programs))]
