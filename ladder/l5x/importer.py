"""An L5X to a controller that can run, and the report of what became of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ..addon import AddOn
from ..collector import collector_paused
from ..controller import Controller
from ..errors import BuildError, LadderError, Problem
from ..expressions import TAG_NAME
from ..inferred import Guess, Guesses
from ..instructions.stubbed import specs_of_stubs
from ..schedule import Task, TaskKind
from ..spec import Spec
from ..stubs import ALL_MESSAGES, NO_STUBS, Power, Stubs, parse_stub
from ..tags import STATUS_FLAGS, Alias, Declaration, Tag, program_of
from ..tree import Address, Instruction, Routine, Rung, Step
from ..types import Structure
from .addons import AddOns
from .assembly import CALLS, Parts, ProgramPart, call_of, harness_of, without
from .datatypes import NAME, Types
from .document import read_document
from .mnemonics import MNEMONICS
from .modules import is_bound, module_tags
from .records import Document, ProgramRecord
from .report import Refusal, Report
from .routines import UNKNOWN, RoutineReader, instruction_names
from .schedule import tasks_of
from .scopes import scope_of
from .unknown import UnknownTypes
from .uses import all_instructions, called_routines, jumps, labels, numbered_instructions, triggered_tasks

ROUNDS = 30
"""Attempts to build what is left after refusals; each refuses at least one rung."""

TRIAL_STUB = "done after 20 ms"
"""How messages end in a trial."""


@dataclass(slots=True)
class Imported:
    """What became of a document.

    Attributes:
        document: the document.
        report: what was imported and refused.
        controller: what runs; None if nothing can be built, or there are no programs.
        parts: what it is made of; refused rungs are empty.
        reader: knows the document's rungs.
    """

    document: Document
    report: Report
    controller: Controller | None
    parts: Parts
    reader: RoutineReader


def import_l5x(
    path: Path | str,
    stubs: Stubs = NO_STUBS,
    slots: Collection[int] | None = None,
    *,
    trial: bool = False,
) -> Imported:
    """Import an L5X.

    Args:
        path: the file.
        stubs: what stands for instructions, and for routines that are refused, by name.
        slots: slots of the rack, to whose images the tags of their modules are bound; None without a rack.
        trial: also check add-on instructions that nothing calls, and let messages end.

    Raises:
        L5xError: the file can't be used at all.
    """
    with collector_paused():
        return Importer(read_document(Path(path)), stubs, slots).run(trial=trial)


class Importer:
    """Imports one document.

    Args:
        document: the document.
        stubs: see `import_l5x`.
        slots: see `import_l5x`.
    """

    def __init__(
        self, document: Document, stubs: Stubs = NO_STUBS, slots: Collection[int] | None = None
    ) -> None:
        self._document, self._stubs, self._slots = document, stubs, slots
        self.report = Report(document.file, document.revision, document.target, document.name)
        self._reader = RoutineReader(self.report)
        self._types = Types(document.data_types)
        self._add_ons = AddOns(document.add_ons, self._types, self.report)
        self._parts = Parts(document.name, stubs=dict(stubs.by_name))
        self._completes = stubs.missing_tags

    def run(self, *, trial: bool) -> Imported:
        """Import it."""
        self._completes = self._stubs.missing_tags or (trial and not self._document.whole)
        self._note_others()
        self._read_logic()
        self._declare()
        if trial:
            self._parts.stubs.setdefault(ALL_MESSAGES, parse_stub(TRIAL_STUB))
            self._note_stubs()
            if self._parts.add_ons:
                self._build(harness_of)
        controller = self._build(lambda parts: parts) if self._parts.programs else None
        return Imported(self._document, self.report, controller, self._parts, self._reader)

    # --- reading

    def _read_logic(self) -> None:
        document, reader = self._document, self._reader
        self._parts.declarations += module_tags(document, self._types, self.report, self._slots)
        reader.stubbed = frozenset(self._stubs.by_name)
        shapes = self._add_ons.specs()
        if self._completes:
            self._stub_absent_add_ons(shapes)
        reader.specs = {**shapes, **specs_of_stubs(self._parts.stubs)}
        self._add_ons.read(reader)
        for program in document.programs:
            self._program(program)
        self._define_types()
        withheld = self._add_ons.make(reader)
        self._parts.add_ons = self._add_ons.made
        stubbed = self._stubs.by_name
        self._refuse_callers({name: text for name, text in withheld.items() if name not in stubbed})

    def _note_others(self) -> None:
        """Note the parts of the document that nothing here reads."""
        for name, line in self._document.others:
            self.report.note(name, "this part of the controller is not read", line)

    def _define_types(self) -> None:
        """Define types that the document leaves out, from their use."""
        unknown = UnknownTypes(self._document, self._types)
        if not unknown.names:
            return
        programs = [
            (part.name, each) for part in self._parts.programs.values() for each in part.routines.values()
        ]
        defined = unknown.define([*programs, *self._add_ons.routines()], self._reader.specs)
        for name, kind in defined.items():
            members = [each.name for each in kind.members] if isinstance(kind, Structure) else [kind.name]
            self.report.declared[f"type {name}"] = ", ".join(members)

    def _refuse_callers(self, withheld: Mapping[str, str]) -> None:
        """Refuse the rungs that call add-ons that can't be used."""
        if not withheld:
            return
        owned = [
            (part.name, each) for part in self._parts.programs.values() for each in part.routines.values()
        ]
        owned += [(each.name, routine) for each in self._parts.add_ons.values() for routine in each.routines]
        for owner, routine in owned:
            for number, instruction in numbered_instructions(routine):
                reason = withheld.get(instruction.name.upper())
                if reason is not None:
                    self._refuse(owner, routine.name, number, f"{instruction.name}: {reason}", UNKNOWN)

    def _stub_absent_add_ons(self, shapes: Mapping[str, Spec]) -> None:
        """Let add-on instructions whose definition was not exported do nothing."""
        for name in instruction_names(self._document):
            if name.upper() not in shapes and name.upper() not in (MNEMONICS | self._parts.stubs.keys()):
                self._parts.stubs[name.upper()] = Power(True)
                self.report.declared[f"add-on {name}"] = "instruction that does nothing"

    def _program(self, record: ProgramRecord) -> None:
        key = record.name.upper()
        part = self._parts.programs.get(key)
        if part is None:
            if not NAME.fullmatch(record.name):
                self._skip_program(record, f"{record.name!r} is no name of a program")
                return
            part = self._parts.programs[key] = ProgramPart(record.name)
        for each in record.routines:
            if each.name.upper() in {*part.routines, *part.functions} or not NAME.fullmatch(each.name):
                reason = f"there are two routines {each.name}, or it is no name"
                self._reader.skipped(record.name, each, reason, "rename it")
                continue
            routine = self._reader.routine(record.name, each)
            if routine is None:
                part.functions[each.name.upper()] = _nothing(each.name)
            else:
                part.routines[each.name.upper()] = routine
        for encoded in record.encoded:
            self._reader.encoded(record.name, encoded)
            if encoded.name.upper() not in part.routines and NAME.fullmatch(encoded.name):
                part.functions[encoded.name.upper()] = _nothing(encoded.name)
        known = {*part.routines, *part.functions}
        part.main = record.main if record.main.upper() in known else None
        part.fault = record.fault if record.fault.upper() in known else None

    def _skip_program(self, record: ProgramRecord, reason: str) -> None:
        for each in record.routines:
            self._reader.skipped(record.name, each, reason, "rename it")

    # --- declaring

    def _declare(self) -> None:
        document, parts = self._document, self._parts
        parts.declarations += scope_of(document.tags, self._types, self.report)
        for program in document.programs:
            part = parts.programs.get(program.name.upper())
            if part is not None:
                part.declarations += scope_of(program.tags, self._types, self.report, program.name)
        self._guess()
        if self._completes:
            self._complete_routines()
        document.release()
        parts.tasks = tasks_of(document, [each.name for each in parts.programs.values()], self.report)
        if self._completes:
            self._complete_tasks()

    def _guess(self) -> None:
        """Declare what the file leaves out, from its use."""
        guesses = Guesses(self._missing, self._parts.known, self._parts.operands_of, self._reader.specs)
        for part in self._parts.programs.values():
            for routine in part.routines.values():
                guesses.read(part.name, self._to_guess(part, routine))
        for guess in guesses.found.values():
            self._declare_guess(guess)

    def _to_guess(self, part: ProgramPart, routine: Routine) -> Routine:
        """Return the part of a routine that may name something missing: of a whole controller, a module."""
        if self._completes or self._aliases_of_modules or routine.statements is not None:
            return routine
        record = self._reader.record(part.name, routine.name)
        texts = [each.text for each in record.rungs] if record else []
        pairs = zip(routine.rungs, texts, strict=False)
        return replace(routine, rungs=tuple(rung for rung, text in pairs if ":" in text))

    @cached_property
    def _aliases_of_modules(self) -> bool:
        """Whether an alias names a module's tag that is not declared."""
        scopes = [("", self._parts.declarations)]
        scopes += [(each.name, each.declarations) for each in self._parts.programs.values()]
        return any(
            ":" in target.name and self._parts.declaration(program, target.name) is None
            for program, declared in scopes
            for each in declared
            if isinstance(each, Alias)
            for target in [self._parts.without_aliases(program, Address(each.name))]
        )

    def _missing(self, program: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
        address = self._parts.without_aliases(program, address)
        if self._parts.declaration(program, address.name) is not None:
            return None
        name = address.name.upper()
        if name in STATUS_FLAGS or not (self._completes or ":" in name) or is_bound(name, self._slots):
            return None
        plain = re.fullmatch(TAG_NAME, address.name.rpartition(".")[2], re.ASCII)
        return (address.name, address.steps) if plain else None

    def _declare_guess(self, guess: Guess) -> None:
        name = guess.name.rpartition(".")[2] if guess.name.startswith("\\") else guess.name
        kind, dims = guess.type(f"{re.sub(r'[^A-Za-z0-9]', '_', name)}_type"), guess.dims
        self._scope(program_of(guess.name)).append(Tag(name, kind, dims))
        self.report.declared[guess.name] = kind.name + "".join(f"[{each}]" for each in dims)

    def _scope(self, program: str) -> list[Declaration]:
        if not program:
            return self._parts.declarations
        part = self._parts.programs.setdefault(program.upper(), ProgramPart(program))
        return part.declarations

    def _complete_routines(self) -> None:
        """Give programs of a partial export a main routine, and the routines that they call."""
        for part in self._parts.programs.values():
            for routine in part.routines.values():
                part.routines[routine.name.upper()] = self._with_labels(part, routine)
            called = {name.upper(): name for name in called_routines(part.routines.values())}
            for key, name in called.items():
                if key not in {*part.routines, *part.functions} and NAME.fullmatch(name):
                    part.functions[key] = _nothing(name)
                    self.report.declared[rf"\{part.name}.{name}"] = "routine that does nothing"
            if part.main is None:
                self._main_of(part, called)

    def _with_labels(self, part: ProgramPart, routine: Routine) -> Routine:
        """Return a routine with the labels at its end to which it jumps and which were not exported."""
        there = [name.upper() for name in labels([routine])]
        missing = {name.upper(): name for name in jumps([routine]) if name.upper() not in there}
        for name in missing.values():
            self.report.declared[rf"\{part.name}.{routine.name}, label {name}"] = "behind the last rung"
        rungs = tuple(Rung((Instruction("LBL", (Address(name),)),)) for name in missing.values())
        return replace(routine, rungs=routine.rungs + rungs) if rungs else routine

    def _complete_tasks(self) -> None:
        """Declare the event tasks that a partial export triggers; without tasks all programs run in one."""
        routines = [each for part in self._parts.programs.values() for each in part.routines.values()]
        events = {name.upper(): name for name in triggered_tasks(routines)}
        known = {each.name.upper() for each in self._parts.tasks}
        missing = [name for key, name in events.items() if key not in known]
        if missing and not self._parts.tasks:
            self._parts.tasks = implicit_task([each.name for each in self._parts.programs.values()])
        for name in missing:
            self._parts.tasks.append(Task(name, TaskKind.EVENT, ()))
            self.report.declared[f"task {name}"] = "event task that runs nothing"

    def _main_of(self, part: ProgramPart, called: Iterable[str]) -> None:
        uncalled = [each for name, each in part.routines.items() if name not in called]
        if len(part.routines) == 1 and uncalled and len(call_of(uncalled[0]).series) == 1:
            only = uncalled[0]
            if not _takes_inputs(only):
                part.main = only.name
                return
        if part.routines:
            calls = tuple(map(call_of, uncalled or part.routines.values()))
            part.routines[CALLS.upper()] = Routine(CALLS, calls)
            part.main = CALLS

    def _note_stubs(self) -> None:
        routines = [each for part in self._parts.programs.values() for each in part.routines.values()]
        routines += [each for definition in self._parts.add_ons.values() for each in definition.routines]
        if any(each.name == ALL_MESSAGES for each in all_instructions(routines)):
            self.report.stubs[ALL_MESSAGES] = str(self._parts.stubs[ALL_MESSAGES])

    # --- building

    def _build(self, of: Callable[[Parts], Parts]) -> Controller | None:
        """Build, refusing what can't be built, until the rest can."""
        for _ in range(ROUNDS):
            parts = of(self._parts)
            controller = parts.assemble(self.report)
            try:
                controller.build()
            except BuildError as error:
                if not self._refuse_all(error.problems, parts):
                    self._refuse_rest(error, parts)
                    return None
            else:
                return controller
        self._refuse_rest(LadderError(f"it can't be built in {ROUNDS} attempts"), parts)
        return None

    def _refuse_all(self, problems: Iterable[Problem], parts: Parts) -> bool:
        """Refuse what problems are about; whether anything was."""
        something = False
        for each in problems:
            if each.number is not None and each.routine:
                owner, routine = _owner_of(each.routine)
                something |= self._refuse(owner, routine, each.number, each.text, each.remedy, parts)
            elif each.where == "initial values":
                something |= self._drop_initial(each.text, parts)
            elif each.routine:
                owner, routine = _owner_of(each.routine)
                something |= self._refuse_routine(owner, routine, each)
        return something

    def _refuse(
        self,
        owner: str,
        routine: str,
        number: int,
        text: str,
        remedy: str,
        parts: Parts | None = None,
    ) -> bool:
        """Refuse a rung, or a routine of structured text; whether there was something to refuse."""
        found = self._routine(owner, routine)
        record = self._reader.record(owner, routine)
        if found is None or record is None:
            return False
        if found.statements is not None:
            if not found.statements:
                return False
            line = record.lines[min(max(number - 1, 0), len(record.lines) - 1)][1] if record.lines else 0
            self._reader.refuse_object(owner, routine, f"line {number}: {text}", line, remedy)
        elif number >= len(record.rungs) or not found.rungs[number].series:
            return False
        else:
            self._reader.refuse(owner, routine, number, text, remedy)
        part = self._parts.programs.get(owner.upper())
        if part is not None and found.statements is not None:
            del part.routines[routine.upper()]
            part.functions[routine.upper()] = _nothing(found.name)
        else:
            self._replace(owner, routine, without(found, number))
        return True

    def _refuse_routine(self, owner: str, routine: str, problem: Problem) -> bool:
        found = self._routine(owner, routine)
        if found is None:
            return False
        refused = [
            self._refuse(owner, routine, number, problem.text, problem.remedy)
            for number in range(len(found.rungs) or 1)
        ]
        return any(refused)

    def _refuse_rest(self, error: LadderError, parts: Parts) -> None:
        """Refuse all that is left, because it can't be built."""
        reason = str(error).replace("\n", " ")
        for part in parts.programs.values():
            for routine in list(part.routines.values()):
                for number in range(len(routine.rungs) or 1):
                    self._refuse(part.name, routine.name, number, reason, "correct the program")
        for definition in list(parts.add_ons.values()):
            for routine in definition.routines:
                for number in range(len(routine.rungs) or 1):
                    self._refuse(definition.name, routine.name, number, reason, "correct the add-on")

    def _routine(self, owner: str, routine: str) -> Routine | None:
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            return part.routines[routine.upper()]
        definition = self._parts.add_ons.get(owner.upper())
        return definition.routine(routine) if definition is not None else None

    def _replace(self, owner: str, routine: str, new: Routine) -> None:
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            part.routines[routine.upper()] = new
            return
        definition = self._parts.add_ons[owner.upper()]
        self._parts.add_ons[owner.upper()] = _with_routine(definition, new)

    def _drop_initial(self, text: str, parts: Parts) -> bool:
        """Let a tag start with zeros whose initial value does not fit; whether there was one."""
        name = text.partition(":")[0].split("[")[0].split(".")
        for scope in (parts.declarations, *(each.declarations for each in parts.programs.values())):
            for place, each in enumerate(scope):
                if isinstance(each, Tag) and each.initial is not None and each.name in name:
                    self.report.note(each.name, f"it starts with zeros: {text}")
                    scope[place] = replace(each, initial=None)
                    return True
        return False


def _owner_of(routine: str) -> tuple[str, str]:
    r"""Split `\Program.Routine` or `AddOn.Role`."""
    owner, _, name = routine.removeprefix("\\").partition(".")
    return owner, name


def _with_routine(definition: AddOn, new: Routine) -> AddOn:
    routines = [new if each.name.upper() == new.name.upper() else each for each in definition.routines]
    return definition.with_routines(tuple(routines))


def _takes_inputs(routine: Routine) -> bool:
    return len(call_of(routine).series[0].operands) > 2  # type: ignore[union-attr]


def _nothing(name: str) -> Callable[..., Any]:
    def routine(_tags: object, *_inputs: object) -> None:
        """Do nothing."""

    routine.__name__ = name
    return routine


def implicit_task(programs: Iterable[str]) -> list[Task]:
    """Return a continuous task that runs programs."""
    return [Task("Trial", TaskKind.CONTINUOUS, tuple(programs))]


__all__ = ["Imported", "Importer", "Refusal", "import_l5x"]
