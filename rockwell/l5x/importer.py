"""Imports an L5X as a runnable controller, with a report."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from scanrack.io_images.site import Site
from scanrack.io_images.text_limits import EXPORT_MIB
from scanrack.ladder.instructions.stubbed import specs_of_stubs
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.model.collector import collector_paused
from scanrack.ladder.model.spec import Spec
from scanrack.ladder.model.stubs import ALL_MESSAGES, NO_STUBS, Power, Stubs, parse_stub
from scanrack.ladder.model.tree import Address
from scanrack.ladder.model.types import Structure

from .addons import AddOns
from .assembly import Parts, ProgramPart, harness_of, idle_routine
from .building import DECLARE, STAND_IN, Builder
from .completing import Completion
from .diagrams.wire_values import DocumentNames
from .mnemonics import MNEMONICS
from .modules import module_objects, module_tags
from .names import Names
from .report import Report
from .routines import UNKNOWN, RoutineReader, instruction_names
from .schedule import chart_options_of, tasks_of
from .scopes import motion_of, remotes_of, scope_of
from .unknown import UnknownTypes
from .uses import all_instructions
from .values.datatypes import NAME, Types
from .xml.document import read_document
from .xml.limits import check_limits
from .xml.records import L5xDocument, ProgramRecord, RoutineRecord

_PHASE = "it is an equipment phase, which stays idle: its prestate routine runs, its state routines do not"
IDLE = "scanrack_idle"
"""Name of a generated main routine of an equipment phase without a prestate routine."""

TRIAL_STUB = "done after 20 ms"
"""Result of messages in a trial."""


@dataclass(slots=True)
class L5xImport:
    """The result of an import."""

    document: L5xDocument
    report: Report
    controller: Controller | None  # None if nothing can be built, or the file has no programs
    parts: Parts  # the controller's parts, with refused rungs emptied
    reader: RoutineReader  # counts the file's rungs, and refuses them


def import_l5x(
    path: Path | str,
    stubs: Stubs = NO_STUBS,
    slots: Collection[int] | None = None,
    *,
    trial: bool = False,
    memory_mib: int = EXPORT_MIB,
) -> L5xImport:
    """Import an L5X; raise an L5xError if it can't be read.

    Args:
        stubs: replacements for instructions and for refused routines, by name.
        slots: slots of the rack, to which module tags are bound; None without a rack.
        trial: whether to also check uncalled add-on instructions, and to let messages complete.
        memory_mib: limit for the memory of all tags, MiB.
    """
    with collector_paused():
        document = read_document(Path(path))
        check_limits(document)
        return Importer(document, stubs, slots, memory_mib).run(trial=trial)


class Importer:
    """Imports one document, see `import_l5x`."""

    def __init__(
        self,
        document: L5xDocument,
        stubs: Stubs = NO_STUBS,
        slots: Collection[int] | None = None,
        memory_mib: int = EXPORT_MIB,
    ) -> None:
        self._document, self._stubs, self._slots = document, stubs, slots
        self.report = Report(document.file, document.revision, document.target, document.name)
        self._reader = RoutineReader(self.report)
        self._types = Types(document.data_types, document.revision, memory_mib)
        self._add_ons = AddOns(document.add_ons, self._types, self.report)
        self._parts = Parts(document.name, stubs=dict(stubs.by_name), modules=stubs.modules)
        self._parts.chart_options = chart_options_of(document, self.report)
        self._builder = Builder(self._parts, self._reader, self.report)
        self._completes = stubs.missing_tags  # whether missing tags, routines and tasks are declared
        self._absent: dict[str, str] = {}  # called add-ons without a definition, by name in capitals
        self._names = Names(document)

    def run(self, *, trial: bool) -> L5xImport:
        """Import the document; see `import_l5x`."""
        self._completes = self._stubs.missing_tags or (trial and not self._document.whole)
        stand_in_option = STAND_IN if trial else DECLARE
        self._builder.stand_in_option = "" if self._completes else stand_in_option
        self._note_unread()
        self._read_logic()
        self._declare()
        if trial:
            self._stub_messages()
            if self._parts.add_ons:
                self._builder.build(harness_of)
        controller = self._builder.build() if self._parts.programs else None
        return L5xImport(self._document, self.report, controller, self._parts, self._reader)

    def _stub_messages(self) -> None:
        """Let messages without a stub complete; report this if the program has messages."""
        self._parts.stubs.setdefault(ALL_MESSAGES, parse_stub(TRIAL_STUB))
        instructions = all_instructions(routine for _, routine in self._parts.all_routines())
        if any(instruction.name == ALL_MESSAGES for instruction in instructions):
            self.report.stubs[ALL_MESSAGES] = str(self._parts.stubs[ALL_MESSAGES])

    # --- reading

    def _read_logic(self) -> None:
        """Read modules, add-ons (whose names parsing needs) and programs; then build the add-ons."""
        document, reader = self._document, self._reader
        memory = module_tags(document, self._types, self.report, self._slots)
        self._parts.declarations += memory.declarations
        self._parts.outputs = memory.outputs
        reader.stubbed = frozenset(self._stubs.by_name)
        shapes = self._add_ons.specs()
        if self._completes:
            self._stub_absent_add_ons(shapes)
        reader.specs = {**shapes, **specs_of_stubs(self._parts.stubs)}
        reader.names_of = self._names_of
        self._add_ons.read(reader)
        for program in document.programs:
            self._read_program(program)
        self._define_types()
        withheld = self._add_ons.build(reader)
        self._parts.add_ons = self._add_ons.built
        stubbed = self._stubs.by_name
        self._refuse_callers({name: text for name, text in withheld.items() if name not in stubbed})

    def _names_of(self, owner: str) -> DocumentNames:
        """Return the types and aliases of names in the diagrams of a program or add-on."""
        names, add_ons = self._names, self._add_ons
        modules = {declaration.name.upper(): declaration for declaration in self._parts.declarations}
        return DocumentNames(
            lambda address: names.type_of(owner, address, self._types, modules),
            lambda name: names.without_aliases(owner, Address(name)).name.upper(),
            add_ons.arguments,
            add_ons.acts_when_off,
            add_ons.outputs,
        )

    def _note_unread(self) -> None:
        """Report content that is not read, and repeated data types."""
        for name, text, line in self._document.others:
            self.report.note(name, text, line)
        names: set[str] = set()
        for data_type in self._document.data_types:
            if data_type.name.upper() in names:
                text = "the file has two data types of that name; the first one is used"
                self.report.note(f"data type {data_type.name}", text, data_type.line)
            names.add(data_type.name.upper())

    def _define_types(self) -> None:
        """Define missing types by inferring them from their use."""
        unknown = UnknownTypes(self._document, self._types)
        if not unknown:
            return
        routines = [*self._parts.program_routines(), *self._add_ons.routines()]
        defined = unknown.define(routines, self._reader.specs)
        for name, kind in defined.items():
            members = [member.name for member in kind.members] if isinstance(kind, Structure) else [kind.name]
            self.report.declared[f"type {name}"] = ", ".join(members)

    def _refuse_callers(self, withheld: Mapping[str, str]) -> None:
        """Refuse the rungs that call withheld add-ons."""
        if not withheld:
            return
        for owner, routine in self._parts.all_routines():
            for number, instruction in routine.instructions():
                reason = withheld.get(instruction.name.upper())
                if reason is not None:
                    site, text = Site(instruction=instruction.name), f"{instruction.name}: {reason}"
                    self._builder.refuse(owner, routine.name, number, text, UNKNOWN, site)
        self._builder.empty()

    def _stub_absent_add_ons(self, shapes: Mapping[str, Spec]) -> None:
        """Replace add-on instructions without a definition with stubs; see `_refuse_absent`."""
        for name in instruction_names(routine for _, routine in self._document.routines()):
            if name.upper() not in shapes and name.upper() not in (MNEMONICS | self._parts.stubs.keys()):
                self._parts.stubs[name.upper()] = Power(True)
                self._absent[name.upper()] = name
                self.report.declared[f"add-on {name}"] = "instruction that does nothing"

    def _refuse_absent(self) -> None:
        """Refuse rungs that call add-on instructions without a definition.

        Statements are reported as refused, but the rest of their routine runs, since the stub does nothing.
        """
        for owner, routine in self._parts.all_routines() if self._absent else ():
            for number, instruction in routine.instructions():
                name = self._absent.get(instruction.name.upper())
                if name is None:
                    continue
                text = f"{name}: no instruction {name}, and no add-on in the export"
                if routine.statements is None:
                    site = Site(instruction=name)
                    self._builder.refuse(owner, routine.name, number, text, UNKNOWN, site)
                else:
                    self._reader.refuse_statement(owner, routine.name, number, text, UNKNOWN)
        self._builder.empty()

    def _read_program(self, record: ProgramRecord) -> None:
        """Read the routines of a program; programs with the same name become one."""
        key = record.name.upper()
        part = self._parts.programs.get(key)
        if part is None:
            if not NAME.fullmatch(record.name):
                for routine in record.routines:
                    reason = f"{record.name!r} is not a name of a program"
                    self._reader.skipped(record.name, routine, reason, "rename it")
                return
            part = self._parts.programs[key] = ProgramPart(record.name)
        for routine in record.routines:
            self._add_routine(part, record.name, routine)
        for encoded in record.encoded:
            self._reader.encoded(record.name, encoded)
            if encoded.name.upper() not in part.routines and NAME.fullmatch(encoded.name):
                part.functions[encoded.name.upper()] = idle_routine(encoded.name)
        self._choose_routines(record, part)

    def _add_routine(self, part: ProgramPart, owner: str, record: RoutineRecord) -> None:
        """Read a routine into a program; a refused routine does nothing, and a repeated name is skipped."""
        key = record.name.upper()
        if key in {*part.routines, *part.functions} or not NAME.fullmatch(record.name):
            reason = f"{record.name!r} is the name of another routine, or not a name"
            self._reader.skipped(owner, record, reason, "rename it")
            return
        routine = self._reader.routine(owner, record)
        if routine is None:
            part.functions[key] = idle_routine(record.name)
        else:
            part.routines[key] = routine

    def _choose_routines(self, record: ProgramRecord, part: ProgramPart) -> None:
        """Set the main and fault routines of a program; a phase without a main routine idles."""
        routine_names = {*part.routines, *part.functions}
        part.main = record.main if record.main.upper() in routine_names else None
        part.fault = record.fault if record.fault.upper() in routine_names else None
        if record.is_phase:
            self.report.note(record.name, _PHASE, record.line)
            if part.main is None:
                part.functions[IDLE.upper()] = idle_routine(IDLE)
                part.main = IDLE

    # --- declaring

    def _declare(self) -> None:
        """Declare tags, missing objects and tasks; refuse callers of absent add-ons; free the document."""
        document, parts = self._document, self._parts
        parts.declarations += scope_of(document.tags, self._types, self.report)
        parts.motion = motion_of(document.tags)
        parts.remotes = remotes_of(document.tags)
        declared = list(parts.declarations)
        for program in document.programs:
            part = parts.programs.get(program.name.upper())
            if part is not None:
                part.declarations += scope_of(program.tags, self._types, self.report, program.name)
                part.declarations += self._reader.generated(program.name)
                parts.remotes |= remotes_of(program.tags, program.name)
                declared += part.declarations
        parts.declarations += list(module_objects(document, self._types, declared))
        completion = Completion(parts, self._reader, self.report, self._slots, all_missing=self._completes)
        completion.declare_missing_tags()
        if self._completes:
            completion.add_missing_routines()
        self._refuse_absent()
        document.release()
        parts.tasks = tasks_of(document, [scope.name for scope in parts.programs.values()], self.report)
        if self._completes:
            completion.declare_missing_tasks()
