"""Declares tags, routines, labels and tasks that rungs name but the file lacks, and reports them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import cached_property

from scanrack.ladder.lowering.guess import Guess
from scanrack.ladder.lowering.type_inference import Guesses
from scanrack.ladder.model.expressions import TAG_NAME
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.schedule import Task, TaskKind
from scanrack.ladder.model.tags import STATUS_FLAGS, TRUTHS, Alias, Declaration, Tag, program_of
from scanrack.ladder.model.tree import Address, Instruction, Rung, Step

from .assembly import CALLS, Parts, ProgramPart, call_of, idle_routine, implicit_task, inputs_of
from .modules import is_bound
from .report import Report
from .routines import RoutineReader
from .uses import named_first
from .values.datatypes import NAME
from .widening import widen


class Completion:
    """Completes the parts of a document.

    Args:
        slots: slots of the rack, whose module tags are images; None without a rack.
        all_missing: whether to declare all missing tags; otherwise only missing tags of modules.
    """

    def __init__(
        self,
        parts: Parts,
        reader: RoutineReader,
        report: Report,
        slots: Collection[int] | None,
        *,
        all_missing: bool,
    ) -> None:
        self._parts, self._reader, self._report, self._slots = parts, reader, report, slots
        self._all_missing = all_missing

    def declare_missing_tags(self) -> None:
        """Declare missing tags, with types inferred from their use."""
        guesses = Guesses(self._missing, self._parts.type_of, self._parts.operands_of, self._reader.specs)
        guesses.read_all(
            (owner, self._rungs_with_missing_tags(owner, routine))
            for owner, routine in self._parts.program_routines()
        )
        for guess in guesses.found.values():
            self._declare_guess(guess)
        if self._all_missing:
            widen(self._parts, self._reader.specs, self._report)

    def _rungs_with_missing_tags(self, owner: str, routine: Routine) -> Routine:
        """To save time, return a routine with only the rungs that may name missing tags.

        If only module tags can be missing, these are the rungs with a colon in their text. With an alias of
        a module tag, or in structured text, it is the whole routine.
        """
        if self._all_missing or self._has_aliases_of_missing_modules or routine.block:
            return routine
        record = self._reader.record(owner, routine.name)
        texts = [rung.text for rung in record.rungs] if record else []
        rungs = [rung for rung, text in zip(routine.rungs, texts, strict=False) if ":" in text]
        return replace(routine, rungs=tuple(rungs))

    @cached_property
    def _has_aliases_of_missing_modules(self) -> bool:
        """Return whether an alias names an undeclared module tag."""
        scopes = [("", self._parts.declarations)]
        scopes += [(program.name, program.declarations) for program in self._parts.programs.values()]
        for program, declarations in scopes:
            for declaration in declarations:
                if isinstance(declaration, Alias):
                    target = self._parts.without_aliases(program, Address(declaration.name))
                    if ":" in target.name and self._parts.declaration(program, target.name) is None:
                        return True
        return False

    def _missing(self, program: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
        """Return the name and steps of a missing tag that must be declared; None for other addresses."""
        address = self._parts.without_aliases(program, address)
        if self._parts.declaration(program, address.name) is not None:
            return None
        name = address.name.upper()
        if name in STATUS_FLAGS or (name in TRUTHS and not address.steps):
            return None
        if not (self._all_missing or ":" in name) or is_bound(name, self._slots):
            return None
        match = re.fullmatch(TAG_NAME, address.name.rpartition(".")[2], re.ASCII)
        return (address.name, address.steps) if match else None

    def _declare_guess(self, guess: Guess) -> None:
        name = guess.name.rpartition(".")[2] if guess.name.startswith("\\") else guess.name
        kind, dims = guess.type(f"{re.sub(r'[^A-Za-z0-9]', '_', name)}_type"), guess.dims
        self._scope(program_of(guess.name)).append(Tag(name, kind, dims))
        self._report.declare(guess.name, kind, dims)

    def _scope(self, program: str) -> list[Declaration]:
        if not program:
            return self._parts.declarations
        part = self._parts.programs.setdefault(program.upper(), ProgramPart(program))
        return part.declarations

    def add_missing_routines(self) -> None:
        """Add missing labels, called routines and main routines to programs of a partial export."""
        for part in self._parts.programs.values():
            for routine in part.routines.values():
                part.routines[routine.name.upper()] = self._with_labels(part, routine)
            called = {name.upper(): name for name in named_first(part.routines.values(), "JSR", "FOR")}
            for key, name in called.items():
                if key not in {*part.routines, *part.functions} and NAME.fullmatch(name):
                    part.functions[key] = idle_routine(name)
                    self._report.declared[rf"\{part.name}.{name}"] = "routine that does nothing"
            if part.main is None:
                self._set_main(part, called)

    def _with_labels(self, part: ProgramPart, routine: Routine) -> Routine:
        """Return a routine with the missing labels of its jumps appended."""
        labels = [name.upper() for name in named_first([routine], "LBL")]
        missing = {name.upper(): name for name in named_first([routine], "JMP") if name.upper() not in labels}
        for name in missing.values():
            self._report.declared[rf"\{part.name}.{routine.name}, label {name}"] = "after the last rung"
        rungs = tuple(Rung((Instruction("LBL", (Address(name),)),)) for name in missing.values())
        return replace(routine, rungs=routine.rungs + rungs) if rungs else routine

    def declare_missing_tasks(self) -> None:
        """Declare missing event tasks; in a file without tasks, also declare a task for all programs."""
        routines = [routine for _, routine in self._parts.program_routines()]
        events = {name.upper(): name for name in named_first(routines, "EVENT")}
        declared = {task.name.upper() for task in self._parts.tasks}
        missing = [name for key, name in events.items() if key not in declared]
        if missing and not self._parts.tasks:
            self._parts.tasks = implicit_task([program.name for program in self._parts.programs.values()])
        for name in missing:
            self._parts.tasks.append(Task(name, TaskKind.EVENT, ()))
            self._report.declared[f"task {name}"] = "event task that runs nothing"

    def _set_main(self, part: ProgramPart, called: Iterable[str]) -> None:
        """Set the main routine of a program: its only routine, or a generated one that calls the others.

        A routine with inputs can't be the main routine, so the generated routine also calls it.

        Args:
            called: names of called routines, in capitals.
        """
        uncalled = [routine for name, routine in part.routines.items() if name not in called]
        if len(part.routines) == 1 and uncalled and not inputs_of(uncalled[0]):
            part.main = uncalled[0].name
        elif part.routines:
            calls = tuple(map(call_of, uncalled or part.routines.values()))
            part.routines[CALLS.upper()] = Routine(CALLS, calls)
            part.main = CALLS
