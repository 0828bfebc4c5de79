"""Assembles a document's parts into a `Controller`; the builder repeats this after each refusal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.instructions.motion.axes import MotionData
from scanrack.ladder.lowering.addon import AddOn
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.lowering.guess import type_at
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.chart import DEFAULT_OPTIONS, ChartOptions
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.schedule import Task, TaskKind
from scanrack.ladder.model.stubs import Remote, Stub, Stubs
from scanrack.ladder.model.tags import OPEN, Alias, Declaration, Tag
from scanrack.ladder.model.tree import Address, Instruction, Operand, Rung, SubscriptStep, number
from scanrack.ladder.model.types import DINT, DataType, Elementary, count_of

from .report import Report

CALLS = "scanrack_calls"
"""Name of a generated main routine for an export without one; it calls the export's routines."""

CLEARS = "scanrack_clears"
"""Name of a generated fault routine, which lets a trial continue after faults."""

FAULT_RECORD = 11
"""Number of words in a MajorFaultRecord [1756-PM014]."""

ARRAY_LENGTH = 256
"""Length of a generated array for an InOut that accepts any length."""

MOST_VALUES = 1_000_000
"""Maximum number of values in all tags generated for add-on instructions."""

_ZEROS, _INSTANCE, _ARGUMENT = "scanrack_zeros", "scanrack_instance", "scanrack_argument"


@dataclass(slots=True)
class ProgramPart:
    """A program, ready for a controller."""

    name: str
    main: str | None = None  # its main routine; None for the first routine
    fault: str | None = None
    declarations: list[Declaration] = field(default_factory=list)
    routines: dict[str, Routine] = field(default_factory=dict)  # by name in capitals
    functions: dict[str, Callable[..., Any]] = field(
        default_factory=dict
    )  # in place of missing or refused ones

    def with_fault_routine(self) -> ProgramPart:
        """Return this program with an added fault routine that clears major faults.

        `routines` must not be empty. Otherwise the added routine would be the main routine.
        """
        zeros = Address(_ZEROS, (SubscriptStep((number(0),)),))
        ssv_operands = (Address("Program"), Address("THIS"), Address("MajorFaultRecord"), zeros)
        routine = Routine(CLEARS, (Rung((Instruction("SSV", ssv_operands),)),))
        return replace(
            self,
            fault=CLEARS,
            declarations=[*self.declarations, Tag(_ZEROS, DINT, (FAULT_RECORD,))],
            routines={**self.routines, CLEARS.upper(): routine},
        )


@dataclass(slots=True)
class Parts:
    """A document's parts."""

    name: str
    declarations: list[Declaration] = field(default_factory=list)
    programs: dict[str, ProgramPart] = field(default_factory=dict)  # by name in capitals
    tasks: list[Task] = field(default_factory=list)  # empty: one task runs all programs
    add_ons: dict[str, AddOn] = field(default_factory=dict)  # by name in capitals
    stubs: dict[str, Stub] = field(default_factory=dict)  # replacements of instructions, by name in capitals
    uncalled: set[str] = field(default_factory=set)  # add-ons that `harness_of` omits, in capitals
    modules: Mapping[int, ModuleWords] = field(default_factory=dict)  # words of the rack's modules, by slot
    motion: MotionData = field(default_factory=MotionData)
    chart_options: ChartOptions = DEFAULT_OPTIONS
    remotes: dict[str, Remote] = field(default_factory=dict)  # of consumed tags and messages
    outputs: dict[int, bytes] = field(default_factory=dict)  # first values of output images, by slot
    _indexes: dict[str, tuple[int, dict[str, Declaration]]] = field(default_factory=dict)  # see `_index`

    def assemble(self, report: Report, tasks: Sequence[Task] | None = None) -> Controller:
        """Return a new controller of these parts; report declarations that it rejects.

        Args:
            tasks: the tasks of the controller; None for the tasks of these parts.
        """
        controller = Controller(self.name)
        controller.chart_options = self.chart_options
        controller.use(*self.add_ons.values())
        controller.motion, controller.remotes = self.motion, self.remotes
        controller.outputs = self.outputs
        controller.take_stubs(Stubs(self.stubs, modules=self.modules))
        self.declarations = _add_declarations(controller, self.declarations, report)
        for part in self.programs.values():
            program = controller.program(part.name, main=part.main, fault=part.fault)
            part.declarations = _add_declarations(program, part.declarations, report)
            for routine in part.routines.values():
                program.add_routine(routine)
            for function in part.functions.values():
                program.function(function)
        for task in self.tasks if tasks is None else tasks:
            controller.add_task(task)
        return controller

    def program_routines(self) -> list[tuple[str, Routine]]:
        """Return the routines of all programs, each with the name of its program."""
        return [(part.name, routine) for part in self.programs.values() for routine in part.routines.values()]

    def all_routines(self) -> list[tuple[str, Routine]]:
        """Return the routines of programs and add-ons, each with the name of its owner."""
        definitions = self.add_ons.values()
        return [
            *self.program_routines(),
            *((definition.name, routine) for definition in definitions for routine in definition.routines),
        ]

    def operands_of(self, name: str) -> tuple[tuple[DataType, tuple[int, ...]], ...]:
        """Return the types and dimensions of an add-on instruction's operands; () for other instructions."""
        return self.add_ons[name.upper()].operand_types if name.upper() in self.add_ons else ()

    def with_fault_routines(self) -> Parts:
        """Return these parts, with a fault routine that clears faults in each program that lacks one.

        A program without `routines` needs no fault routine: its `functions` do nothing.
        """
        programs = {
            name: program.with_fault_routine() if program.routines and not program.fault else program
            for name, program in self.programs.items()
        }
        return replace(self, programs=programs, _indexes={})

    def type_of(self, program: str, address: Address) -> DataType | None:
        """Return the type of an address in a program; None if it is undeclared."""
        address = self.without_aliases(program, address)
        return type_at(self.declaration(program, address.name), address)

    def declaration(self, program: str, name: str) -> Declaration | None:
        r"""Return a declaration by its name in a program; `\Main.Run` names the tag of program Main."""
        scopes = [program, ""]
        if name.startswith("\\"):
            owner, name = owner_of(name)
            scopes = [owner]
        for scope in scopes:
            if not scope:
                declared = self.declarations
            else:
                part = self.programs.get(scope.upper())
                declared = part.declarations if part else []
            declaration = self._index(scope, declared).get(name.upper())
            if declaration is not None:
                return declaration
        return None

    def _index(self, scope: str, declared: list[Declaration]) -> dict[str, Declaration]:
        """Return the declarations of a scope by name in capitals, cached until their number changes."""
        count, index = self._indexes.get(scope.upper(), (-1, {}))
        if count != len(declared):
            index = {declaration.name.upper(): declaration for declaration in declared}
            self._indexes[scope.upper()] = len(declared), index
        return index

    def without_aliases(self, program: str, address: Address) -> Address:
        """Resolve the aliases in an address as far as possible."""
        for _ in range(20):
            declared = self.declaration(program, address.name)
            if not isinstance(declared, Alias):
                break
            address = Address(declared.target.name, declared.target.steps + address.steps)
        return address


def owner_of(name: str) -> tuple[str, str]:
    r"""Split `\Program.Name` or `AddOn.Role` into the owner and the name without it."""
    owner, _, own_name = name.removeprefix("\\").partition(".")
    return owner, own_name


def _add_declarations(
    scope: Controller | Program, declarations: list[Declaration], report: Report
) -> list[Declaration]:
    """Add declarations to a controller or program; return the accepted ones."""
    added = []
    for declaration in declarations:
        try:
            scope.add(declaration)
            added.append(declaration)
        except LadderError as error:
            owner = "" if isinstance(scope, Controller) else rf"\{scope.name}."
            report.leave_out(f"{owner}{declaration.name}", str(error))
    return added


def emptied(routine: Routine, *numbers: int) -> Routine:
    """Return a routine with the rungs with these numbers emptied; structured text loses all statements."""
    if routine.statements is not None:
        return replace(routine, statements=())
    rungs = list(routine.rungs)
    for rung_number in numbers:
        rungs[rung_number] = replace(rungs[rung_number], series=())
    return replace(routine, rungs=tuple(rungs))


def harness_of(parts: Parts) -> Parts:
    """Return a controller with a program for each add-on that calls it once.

    Add-ons in `uncalled`, and add-ons whose arguments exceed `MOST_VALUES`, are omitted.
    """
    programs: dict[str, ProgramPart] = {}
    counts: dict[int, int] = {}
    budget = MOST_VALUES
    for key, definition in parts.add_ons.items():
        tags = _argument_tags(definition)
        value_count = sum(_count_values(tag.type, counts) * count_of(tag.dims) for tag in tags)
        if key in parts.uncalled or value_count > budget:
            continue
        budget -= value_count
        rung = Rung((Instruction(definition.name, tuple(Address(tag.name) for tag in tags)),))
        programs[key] = ProgramPart(
            definition.name, declarations=[*tags], routines={"MAIN": Routine("Main", (rung,))}
        )
    tasks = trial_tasks(parts, [program.name for program in programs.values()])
    return Parts(
        parts.name,
        programs=programs,
        tasks=tasks,
        add_ons=parts.add_ons,
        stubs=parts.stubs,
        modules=parts.modules,
    )


def _argument_tags(definition: AddOn) -> list[Tag]:
    """Return tags for the operands of a call: the instance, then the required parameters."""
    inout_dims = {inout.name: inout.dims for inout in definition.inouts}
    tags = [Tag(_INSTANCE, definition.structure)]
    for index, parameter in enumerate(definition.required):
        dims = inout_dims.get(parameter.name, parameter.dims)
        lengths = tuple(ARRAY_LENGTH if length == OPEN else length for length in dims)
        tags.append(Tag(f"{_ARGUMENT}{index}", parameter.type, lengths))
    return tags


def _count_values(kind: DataType, counts: dict[int, int]) -> int:
    """Count the values in an element of a type; `counts` is a cache by the type's identity."""
    if isinstance(kind, Elementary):
        return 1
    if id(kind) not in counts:
        counts[id(kind)] = sum(
            _count_values(member.type, counts) * count_of(member.dims) for member in kind.own
        )
    return counts[id(kind)]


def call_of(routine: Routine) -> Rung:
    """Return a rung that calls a routine and passes the tags of its SBR, so that they keep their values."""
    inputs = inputs_of(routine)
    return Rung((Instruction("JSR", (Address(routine.name), number(len(inputs)), *inputs)),))


def inputs_of(routine: Routine) -> tuple[Operand, ...]:
    """Return the operands of the SBR at the beginning of a routine's rungs; () if it has no SBR."""
    first_element = next(iter(routine.rungs[0].series), None) if routine.rungs else None
    if isinstance(first_element, Instruction) and first_element.name == "SBR":
        return first_element.operands
    return ()


def idle_routine(name: str) -> Callable[..., Any]:
    """Return a routine in Python that ignores its inputs and does nothing."""

    def routine(_tags: object, *_inputs: object) -> None:
        """Do nothing."""

    routine.__name__ = name
    return routine


def trial_tasks(parts: Parts, programs: Iterable[str]) -> list[Task]:
    """Return a task with these programs, and the event tasks without programs, for EVENT instructions."""
    events = (task for task in parts.tasks if task.kind is TaskKind.EVENT)
    return [*implicit_task(programs), *(replace(event, programs=()) for event in events)]


def implicit_task(programs: Iterable[str]) -> list[Task]:
    """Return a continuous task with these programs."""
    return [Task("Trial", TaskKind.CONTINUOUS, tuple(programs))]
