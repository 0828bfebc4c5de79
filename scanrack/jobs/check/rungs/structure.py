"""Mistakes of routines, add-on instructions and tags as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from scanrack.ladder import LadderLogic
from scanrack.ladder.files.rungreader import is_of_library
from scanrack.ladder.lowering.addon import AddOn, ParameterMode
from scanrack.ladder.lowering.checks import calls_of
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.statements import operands_in, statements_in
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.model.tree import Address, Operand, addresses_in, instructions_of
from scanrack.ladder.prove.claims import NEVER
from scanrack.ladder.state.lowered import (
    Act,
    Arms,
    Body,
    Call,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Selection,
    steps_of,
)

from ..facts import Facts, FileLine
from .loops import bodies_of

LIBRARY = "axis3601"
"""The library of motion blocks, whose inside is not the user's."""

LEAVES = ("TND", "RET", "JMP")
"""Instructions behind which a rung without a label is not reached."""


def own_add_ons(program: LadderLogic) -> list[AddOn]:
    """Return the add-on instructions of the program itself, without those of the library."""
    return [each for each in program.add_ons.values() if not is_of_library(each, LIBRARY)]


def own_routines(program: LadderLogic, lowered: LoweredProgram) -> list[LoweredRoutine]:
    """Return the routines that the user has written."""
    frames = {"", *(each.name.upper() for each in own_add_ons(program))}
    return [each for each in lowered.routines.values() if each.frame in frames]


class Structure:
    """Notes the mistakes of a program as a whole.

    Args:
        declared: returns the line that declares a name.
    """

    def __init__(
        self,
        program: LadderLogic,
        lowered: LoweredProgram,
        facts: Facts,
        file: str,
        declared: Callable[[str], int],
    ) -> None:
        self._program, self._lowered, self._facts = program, lowered, facts
        self._file, self._line = file, declared

    def note(self, routines: Iterable[LoweredRoutine]) -> None:
        """Note the mistakes of these routines, of parameters and of names."""
        for each in routines:
            self._leaving(each)
            self._labels(each)
        self._unreached()
        self._recursion()
        self._parameters()
        self._shadows()

    # --- reachability

    def _leaving(self, routine: LoweredRoutine) -> None:
        """Note what follows an instruction that leaves the routine."""
        if routine.body is not None:
            self._behind(routine.body)
            return
        labels = set(routine.labels.values())
        for at, line in enumerate(routine.lines[:-1]):
            first = line.nodes[0] if line.nodes else None
            if isinstance(first, LoweredStep) and first.name in LEAVES and at + 1 not in labels:
                text = f"{first.name} in rung {line.number} always leaves: this rung is never reached"
                self._facts.remark("unreachable", self._place(routine.lines[at + 1]), text)

    def _behind(self, body: Body) -> None:
        """Note the statement behind RETURN or EXIT."""
        for at, each in enumerate(body):
            if isinstance(each, Act) and at + 1 < len(body):
                names = [step.name for step in steps_of(each.line.nodes)]
                if names and names[-1] in ("RETURN", "EXIT", *LEAVES):
                    following = next(_lines_in((body[at + 1],)), None)
                    if following is not None:
                        text = f"{names[-1]} leaves before it: this statement is never reached"
                        self._facts.remark("unreachable", self._place(following), text)
                    return
        for each in body:
            for inner in bodies_of(each):
                self._behind(inner)

    def _labels(self, routine: LoweredRoutine) -> None:
        used = {
            step.operands[0] for line in routine.lines for step in steps_of(line.nodes) if step.name == "JMP"
        }
        for label, rung in routine.labels.items():
            if label not in used:
                text = f"no JMP names the label {label}"
                self._facts.remark("unreachable", self._place(routine.lines[rung]), text)

    def _unreached(self) -> None:
        """Note the routines that nothing calls."""
        if self._lowered.functions:
            return
        reached = set(self._lowered.roots)
        todo = [each for each in reached if each in self._lowered.routines]
        while todo:
            for name in calls_of(self._lowered.routines[todo.pop()]):
                if name not in reached:
                    reached.add(name)
                    todo += [name] * (name in self._lowered.routines)
        for name, routine in self._lowered.routines.items():
            is_run = (
                not program_of(routine.name) or self._lowered.schedule is None or self._runs(routine.name)
            )
            is_monitor = name.rpartition(".")[2] == NEVER
            if not (routine.frame or is_monitor or name in reached) and routine.lines and is_run:
                text = f"nothing calls routine {routine.name}"
                self._facts.remark("unreachable", self._place(routine.lines[0]), text)

    def _runs(self, routine: str) -> bool:
        """Whether a task runs the routine's program."""
        schedule = self._lowered.schedule
        names = [each.name.upper() for each in schedule.programs] if schedule is not None else []
        return program_of(routine).upper() in names

    def _recursion(self) -> None:
        for name in sorted(self._lowered.recursive):
            routine = self._lowered.routines[name]
            for line in routine.lines:
                calls = [
                    each for step in steps_of(line.nodes) for each in step.operands if isinstance(each, Call)
                ]
                if any(each.routine in self._lowered.recursive for each in calls):
                    text = f"routine {routine.name} calls itself, directly or through others"
                    self._facts.remark("recursion", self._place(line), text)
                    break

    # --- parameters and names

    def _parameters(self) -> None:
        for add_on in own_add_ons(self._program):
            used = {each.name.upper() for routine in add_on.routines for each in _addresses(routine)}
            for each in add_on.parameters:
                if each.name.upper() not in used and not each.at and not self._is_host(add_on, each.name):
                    kind = "local tag" if each.way is ParameterMode.LOCAL else "parameter"
                    text = f"{add_on.name} does not use its {kind} {each.name}"
                    self._facts.remark("unused-parameter", FileLine(self._file, self._line(each.name)), text)

    @staticmethod
    def _is_host(add_on: AddOn, name: str) -> bool:
        """Whether another parameter names a part of this one."""
        return any(
            each.at.upper().partition(".")[0].partition("[")[0] == name.upper() for each in add_on.parameters
        )

    def _shadows(self) -> None:
        declared = self._lowered.layout.declarations
        for name, each in declared.items():
            program = program_of(each.name)
            short = name.rpartition(".")[2]
            if program and short in declared:
                text = f"tag {short} of program {program} hides the controller's tag {declared[short].name}"
                lines = self._line(each.name)
                self._facts.remark("shadowed-name", FileLine(self._file, lines), text)

    def _place(self, line: LoweredLine) -> FileLine:
        return FileLine(line.origin.file or self._file, line.origin.line or 1)


def _lines_in(body: Body) -> Iterator[LoweredLine]:
    for each in body:
        match each:
            case Act(line):
                yield line
            case Arms(arms, _):
                yield arms[0][0]
            case Selection():
                yield each.line
            case Loop():
                yield each.start or each.condition


def _addresses(routine: Routine) -> Iterator[Address]:
    """Yield the addresses in a routine."""
    for operand in _operands(routine):
        yield from addresses_in(operand)


def _operands(routine: Routine) -> Iterator[Operand]:
    for rung in routine.rungs:
        for instruction in instructions_of(rung.series):
            yield from instruction.operands
    for statement in statements_in(routine.statements or ()):
        yield from operands_in(statement)
