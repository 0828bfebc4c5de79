"""Mistakes in whole routines, add-on instructions and tags."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice, pairwise

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
from ..groups import reached
from .add_ons import hosts_in
from .loops import bodies_of, lines_in

LIBRARY = "axis3601"
"""The library of motion blocks, which are not the user's code."""

LEAVES = ("TND", "RET", "JMP")
"""Instructions after which a rung without a label is never reached."""


def own_add_ons(program: LadderLogic) -> list[AddOn]:
    """Return the add-on instructions of the program itself, not those of the library."""
    return [each for each in program.add_ons.values() if not is_of_library(each, LIBRARY)]


def own_routines(program: LadderLogic, lowered: LoweredProgram) -> list[LoweredRoutine]:
    """Return the routines that the user has written."""
    frames = {"", *(each.name.upper() for each in own_add_ons(program))}
    return [each for each in lowered.routines.values() if each.frame in frames]


class Structure:
    """Notes the mistakes in a program as a whole.

    Args:
        place_of: returns the file and line number of a line.
        declared: returns the place where a name is declared.
    """

    def __init__(
        self,
        program: LadderLogic,
        lowered: LoweredProgram,
        facts: Facts,
        place_of: Callable[[LoweredLine], FileLine],
        declared: Callable[[str], FileLine],
    ) -> None:
        self._program, self._lowered, self._facts = program, lowered, facts
        self._place, self._declared = place_of, declared

    def note(self, routines: Iterable[LoweredRoutine]) -> None:
        """Note the mistakes in the given routines, and in parameters and names."""
        for each in routines:
            self._leaving(each)
            self._labels(each)
        self._unreached()
        self._recursion()
        self._parameters()
        self._shadows()

    # --- reachability

    def _leaving(self, routine: LoweredRoutine) -> None:
        """Note code after an instruction that leaves the routine."""
        if routine.body is not None:
            self._after(routine.body)
            return
        labels = set(routine.labels.values())
        for at, (line, following) in enumerate(pairwise(routine.lines), 1):
            first = line.nodes[0] if line.nodes else None
            if isinstance(first, LoweredStep) and first.name in LEAVES and at not in labels:
                text = f"{first.name} in rung {line.number} always leaves: this rung is never reached"
                self._facts.remark("unreachable", self._place(following), text)

    def _after(self, body: Body) -> None:
        """Note the statement after a RETURN or EXIT."""
        for each, following in pairwise(body):
            steps = steps_of(each.line.nodes) if isinstance(each, Act) else ()
            if steps and steps[-1].name in ("RETURN", "EXIT", *LEAVES):
                text = f"{steps[-1].name} leaves before it: this statement is never reached"
                self._facts.remark("unreachable", self._place(_first_line(following)), text)
                return
        for each in body:
            for inner in bodies_of(each):
                self._after(inner)

    def _labels(self, routine: LoweredRoutine) -> None:
        jumps = (step for line in routine.lines for step in line.all_steps if step.name == "JMP")
        used = {step.operands[0] for step in jumps}
        for label, rung in routine.labels.items():
            if label not in used:
                text = f"no JMP names the label {label}"
                self._facts.remark("unreachable", self._place(routine.lines[rung]), text)

    def _unreached(self) -> None:
        """Note routines that nothing calls."""
        routines = self._lowered.routines
        if self._lowered.functions:
            return
        roots = set(self._lowered.roots)
        called = roots.union(
            reached(roots, lambda name: calls_of(routines[name]) if name in routines else ())
        )
        for name, routine in routines.items():
            if name not in called and self._is_left_out(name, routine):
                text = f"nothing calls routine {routine.name}"
                self._facts.remark("unreachable", self._place(routine.lines[0]), text)

    def _is_left_out(self, name: str, routine: LoweredRoutine) -> bool:
        """Whether something should call a routine that nothing calls."""
        is_monitor = name.rpartition(".")[2] == NEVER
        return bool(routine.lines) and not routine.frame and not is_monitor and self._runs(routine.name)

    def _runs(self, routine: str) -> bool:
        """Whether a task runs the routine's program; true if the program has no tasks."""
        program, schedule = program_of(routine).upper(), self._lowered.schedule
        if not program or schedule is None:
            return True
        return program in (each.name.upper() for each in schedule.programs)

    def _recursion(self) -> None:
        recursive = self._lowered.recursive
        for routine in (self._lowered.routines[name] for name in sorted(recursive)):
            calling = (line for line in routine.lines if any(each in recursive for each in _called_by(line)))
            for line in islice(calling, 1):
                text = f"routine {routine.name} calls itself, directly or through others"
                self._facts.remark("recursion", self._place(line), text)

    # --- parameters and names

    def _parameters(self) -> None:
        for add_on in own_add_ons(self._program):
            used = {each.name.upper() for routine in add_on.routines for each in _addresses(routine)}
            used |= hosts_in(add_on)
            for each in add_on.parameters:
                if each.name.upper() not in used and not each.at:
                    kind = "local tag" if each.way is ParameterMode.LOCAL else "parameter"
                    text = f"{add_on.name} does not use its {kind} {each.name}"
                    self._facts.remark("unused-parameter", self._declared(each.name), text)

    def _shadows(self) -> None:
        declared = self._lowered.layout.declarations
        for name, each in declared.items():
            program = program_of(each.name)
            short = name.rpartition(".")[2]
            if program and short in declared:
                text = f"tag {short} of program {program} hides the controller's tag {declared[short].name}"
                self._facts.remark("shadowed-name", self._declared(each.name), text)


def _first_line(statement: Act | Arms | Selection | Loop) -> LoweredLine:
    if isinstance(statement, Loop):
        return statement.start or statement.condition
    return next(lines_in((statement,)))


def _called_by(line: LoweredLine) -> Iterator[str]:
    """Yield the routines that a line calls, in capitals."""
    for step in line.all_steps:
        yield from (each.routine for each in step.operands if isinstance(each, Call))


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
