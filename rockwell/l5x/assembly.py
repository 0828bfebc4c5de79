"""Assembles a document's parts into a `Controller`, again after each refusal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.instructions.motion.axes import MotionData
from scanrack.ladder.lowering.addon import AddOn
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.lowering.guess import type_at
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
"""Name of a generated main routine that calls the routines of an export without one."""

CLEARS = "scanrack_clears"
"""Name of a generated fault routine, for a trial that continues after faults."""

FAULT_RECORD = 11
"""Words of a MajorFaultRecord [1756-PM014]."""

MADE = 256
"""Length of a generated array for an InOut of any length."""

MOST_MADE = 1_000_000
"""Maximum values of all tags generated for add-on instructions."""

_ZEROS, _INSTANCE, _ARGUMENT = "scanrack_zeros", "scanrack_instance", "scanrack_argument"


@dataclass(slots=True)
class ProgramPart:
    """A program, ready for a controller."""

    name: str
    main: str | None = None  # its main routine; None for the first routine
    fault: str | None = None
    declarations: list[Declaration] = field(default_factory=list)
    routines: dict[str, Routine] = field(default_factory=dict)  # by name in capitals
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)  # for missing or refused routines

    def with_fault_routine(self) -> ProgramPart:
        """Return the same program with another routine, which clears its major faults.

        `routines` must not be empty: the added routine would be the main routine.
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
    _indexes: dict[str, tuple[int, dict[str, Declaration]]] = field(default_factory=dict)

    def assemble(self, report: Report, tasks: Sequence[Task] | None = None) -> Controller:
        """Return a new controller of these parts, with other tasks if given; note rejected declarations."""
        controller = Controller(self.name)
        controller.chart_options = self.chart_options
        controller.use(*self.add_ons.values())
        controller.motion, controller.remotes = self.motion, self.remotes
        controller.outputs = self.outputs
        controller.take_stubs(Stubs(self.stubs, modules=self.modules))
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

    def owned(self) -> list[tuple[str, Routine]]:
        """Return the routines of programs, each with its program."""
        return [(part.name, routine) for part in self.programs.values() for routine in part.routines.values()]

    def operands_of(self, name: str) -> tuple[tuple[DataType, tuple[int, ...]], ...]:
        """Return types and dimensions of an add-on instruction's operands; none for other instructions."""
        return self.add_ons[name.upper()].operand_types if name.upper() in self.add_ons else ()

    def with_fault_routines(self) -> Parts:
        """Return the same parts; each program without a fault routine gets one that clears faults.

        A program without `routines` gets none: its `functions` do nothing, so they can't fault.
        """
        programs = {
            name: program.with_fault_routine() if program.routines and not program.fault else program
            for name, program in self.programs.items()
        }
        return replace(self, programs=programs, _indexes={})

    def known(self, program: str, address: Address) -> DataType | None:
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
    r"""Split `\Program.Name` or `AddOn.Role`."""
    owner, _, own_name = name.removeprefix("\\").partition(".")
    return owner, own_name


def _added(to: Any, declarations: list[Declaration], report: Report) -> list[Declaration]:
    """Add declarations; return the accepted ones."""
    added = []
    for declaration in declarations:
        try:
            to.add(declaration)
            added.append(declaration)
        except LadderError as error:
            owner = "" if isinstance(to, Controller) else rf"\{to.name}."
            report.leave_out(f"{owner}{declaration.name}", str(error))
    return added


def without(routine: Routine, *places: int) -> Routine:
    """Return a routine with empty rungs at `places`, or without statements."""
    if routine.statements is not None:
        return replace(routine, statements=())
    rungs = list(routine.rungs)
    for place in places:
        rungs[place] = Rung((), rungs[place].comment, rungs[place].origin)
    return replace(routine, rungs=tuple(rungs))


def harness_of(parts: Parts) -> Parts:
    """Return a controller with a program for each add-on that calls it once, as far as memory allows."""
    programs: dict[str, ProgramPart] = {}
    counts: dict[int, int] = {}
    budget = MOST_MADE
    for key, definition in parts.add_ons.items():
        tags = _arguments(definition)
        value_count = sum(_values(tag.type, counts) * count_of(tag.dims) for tag in tags)
        if key in parts.uncalled or value_count > budget:
            continue
        budget -= value_count
        rung = Rung((Instruction(definition.name, tuple(Address(tag.name) for tag in tags)),))
        programs[key] = ProgramPart(
            definition.name, declarations=[*tags], routines={"MAIN": Routine("Main", (rung,))}
        )
    tasks = trial_tasks(parts, [program.name for program in programs.values()])
    return Parts(parts.name, [], programs, tasks, parts.add_ons, parts.stubs, modules=parts.modules)


def _arguments(definition: AddOn) -> list[Tag]:
    """Return the tags of a call: the instance, then the required parameters."""
    lengths = {inout.name: inout.dims for inout in definition.inouts}
    tags = [Tag(_INSTANCE, definition.structure)]
    for place, parameter in enumerate(definition.required):
        dims = tuple(
            MADE if length == OPEN else length for length in lengths.get(parameter.name, parameter.dims)
        )
        tags.append(Tag(f"{_ARGUMENT}{place}", parameter.type, dims))
    return tags


def _values(kind: DataType, counts: dict[int, int]) -> int:
    """Count the values in an element of a type; `counts` is a cache by the type's identity."""
    if isinstance(kind, Elementary):
        return 1
    if id(kind) not in counts:
        counts[id(kind)] = sum(_values(member.type, counts) * count_of(member.dims) for member in kind.own)
    return counts[id(kind)]


def call_of(routine: Routine) -> Rung:
    """Return a rung that calls a routine; the tags of its SBR keep their values."""
    inputs: tuple[Operand, ...] = ()
    first = routine.rungs[0].series[:1] if routine.rungs else ()
    for instruction in first:
        if isinstance(instruction, Instruction) and instruction.name == "SBR":
            inputs = instruction.operands
    return Rung((Instruction("JSR", (Address(routine.name), number(len(inputs)), *inputs)),))


def does_nothing(name: str) -> Callable[..., Any]:
    """Return a routine in Python that ignores its inputs."""

    def routine(_tags: object, *_inputs: object) -> None:
        """Do nothing."""

    routine.__name__ = name
    return routine


def trial_tasks(parts: Parts, programs: Iterable[str]) -> list[Task]:
    """Return a task with these programs, and empty tasks that EVENT instructions may trigger."""
    events = (task for task in parts.tasks if task.kind is TaskKind.EVENT)
    return [*implicit_task(programs), *(replace(event, programs=()) for event in events)]


def implicit_task(programs: Iterable[str]) -> list[Task]:
    """Return a continuous task with these programs."""
    return [Task("Trial", TaskKind.CONTINUOUS, tuple(programs))]
