"""Mistakes in whole routines, add-on instructions and tags."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, islice, pairwise

from scanrack.ladder.lowering.addon import ParameterMode
from scanrack.ladder.lowering.checks import calls_of
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.statements import operands_in, statements_in
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.model.tree import Operand, addresses_in, instructions_of
from scanrack.ladder.prove.claims import NEVER
from scanrack.ladder.state.lowered import (
    Act,
    Body,
    Call,
    LoweredLine,
    LoweredRoutine,
    LoweredStep,
    steps_of,
)

from ..facts import Facts
from ..groups import reached
from .add_ons import hosts_in
from .loops import bodies_of, lines_in
from .operands import steps_in
from .view import LadderView

LEAVES = ("TND", "RET", "JMP")
"""Instructions that make a following rung without a label unreachable."""


class Structure:
    """Notes the mistakes in a program as a whole."""

    def __init__(self, view: LadderView, facts: Facts) -> None:
        self._view, self._lowered, self._facts = view, view.lowered, facts

    def note(self) -> None:
        """Note the mistakes in routines, parameters and names."""
        for routine in self._view.routines:
            self._note_after_leaving(routine)
            self._labels(routine)
        self._unreached()
        self._recursion()
        self._parameters()
        self._shadows()

    # --- reachability

    def _note_after_leaving(self, routine: LoweredRoutine) -> None:
        """Note code after an instruction that leaves the routine."""
        if routine.body is not None:
            self._note_statement_after(routine.body)
            return
        labels = set(routine.labels.values())
        for index, (line, following) in enumerate(pairwise(routine.lines), 1):
            first = line.nodes[0] if line.nodes else None
            if isinstance(first, LoweredStep) and first.name in LEAVES and index not in labels:
                text = f"{first.name} in rung {line.number} always leaves: this rung is never reached"
                self._facts.remark("unreachable", self._view.place(following), text)

    def _note_statement_after(self, body: Body) -> None:
        """Note the statement after a RETURN or EXIT."""
        for statement, following in pairwise(body):
            steps = steps_of(statement.line.nodes) if isinstance(statement, Act) else ()
            if steps and steps[-1].name in ("RETURN", "EXIT", *LEAVES):
                text = f"{steps[-1].name} leaves before it: this statement is never reached"
                self._facts.remark("unreachable", self._view.place(next(lines_in((following,)))), text)
                return
        for statement in body:
            for inner in bodies_of(statement):
                self._note_statement_after(inner)

    def _labels(self, routine: LoweredRoutine) -> None:
        """Note labels that no instruction jumps to."""
        labels_used = {step.operands[0] for step in steps_in(routine) if step.name == "JMP"}
        for label, rung in routine.labels.items():
            if label not in labels_used:
                text = f"no JMP jumps to label {label}"
                self._facts.remark("unreachable", self._view.place(routine.lines[rung]), text)

    def _unreached(self) -> None:
        """Note routines that are never called."""
        routines = self._lowered.routines
        if self._lowered.functions:
            return
        roots = set(self._lowered.roots)
        called = reached(roots, lambda name: calls_of(routines[name]) if name in routines else ())
        reachable = roots.union(called)
        for name, routine in routines.items():
            if name not in reachable and self._needs_call(name, routine):
                text = f"nothing calls routine {routine.name}"
                self._facts.remark("unreachable", self._view.place(routine.lines[0]), text)

    def _needs_call(self, name: str, routine: LoweredRoutine) -> bool:
        """Whether something should call a routine: it has lines, is not a monitor, and its program runs."""
        is_monitor = name.rpartition(".")[2] == NEVER
        return bool(routine.lines) and not routine.frame and not is_monitor and self._runs(routine.name)

    def _runs(self, routine: str) -> bool:
        """Whether a task runs the routine's program; true if the program has no tasks."""
        name, schedule = program_of(routine).upper(), self._lowered.schedule
        if not name or schedule is None:
            return True
        return name in (program.name.upper() for program in schedule.programs)

    def _recursion(self) -> None:
        """Note the first recursive call of each recursive routine."""
        recursive = self._lowered.recursive
        for routine in (self._lowered.routines[name] for name in sorted(recursive)):
            calling = (line for line in routine.lines if not recursive.isdisjoint(_called_by(line)))
            for line in islice(calling, 1):
                text = f"routine {routine.name} calls itself, directly or through others"
                self._facts.remark("recursion", self._view.place(line), text)

    # --- parameters and names

    def _parameters(self) -> None:
        """Note parameters and local tags of add-on instructions that their routines do not use."""
        for add_on in self._view.add_ons:
            names_used = hosts_in(add_on)
            for operand in chain.from_iterable(map(_operands, add_on.routines)):
                names_used.update(address.name.upper() for address in addresses_in(operand))
            for parameter in add_on.parameters:
                if parameter.name.upper() not in names_used and not parameter.at:
                    kind = "local tag" if parameter.mode is ParameterMode.LOCAL else "parameter"
                    text = f"{add_on.name} does not use its {kind} {parameter.name}"
                    self._facts.remark("unused-parameter", self._view.declaration(parameter.name), text)

    def _shadows(self) -> None:
        """Note tags of programs that hide a tag of the controller."""
        declared = self._lowered.layout.declarations
        for name, declaration in declared.items():
            program = program_of(declaration.name)
            short = name.rpartition(".")[2]
            if program and short in declared:
                text = f"tag {short} of program {program} hides the controller's tag {declared[short].name}"
                self._facts.remark("shadowed-name", self._view.declaration(declaration.name), text)


def _called_by(line: LoweredLine) -> Iterator[str]:
    """Yield the routines that a line calls, in capitals."""
    for step in line.all_steps:
        yield from (operand.routine for operand in step.operands if isinstance(operand, Call))


def _operands(routine: Routine) -> Iterator[Operand]:
    """Yield all operands in the rungs and statements of a routine."""
    for rung in routine.rungs:
        for instruction in instructions_of(rung.series):
            yield from instruction.operands
    for statement in statements_in(routine.statements or ()):
        yield from operands_in(statement)
