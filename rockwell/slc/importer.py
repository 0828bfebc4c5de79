"""Imports an RSLogix 500 export as a runnable program, with a report."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from scanrack.ladder.instructions.slc import SLC_SPECS
from scanrack.ladder.lowering.addon import specs_of
from scanrack.ladder.lowering.dialects import SLC
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.errors import BuildError, LadderError, Problem
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.stubs import ALL_MESSAGES, NO_STUBS, Stubs, parse_stub
from scanrack.ladder.model.tree import Origin, Rung, Series

from ..l5x.assembly import emptied
from ..l5x.building import ROUNDS
from ..l5x.importer import TRIAL_STUB
from ..l5x.report import Refusal, Report
from .datafiles import DataFiles
from .document import parse_document, read_document
from .records import LadderRecord, SlcDocument, SlcRungRecord
from .rungs import RungError, RungReader, routine_name

LONGEST = 1000
"""Maximum number of characters of a rung in a refusal."""

MAIN = 2
"""Number of the main ladder file."""


@dataclass(slots=True)
class SlcImport:
    """The result of an import; `program` is None if nothing can be built."""

    document: SlcDocument
    report: Report
    program: Program | None


def import_slc(
    path: Path | str,
    stubs: Stubs = NO_STUBS,
    slots: Collection[int] | None = None,
    *,
    trial: bool = False,
) -> SlcImport:
    """Import an export from a file; raise an SlcError if it can't be read.

    Args:
        stubs: replacements of instructions.
        slots: slots of the rack; images of other slots are memory. None means no rack; then slots with a 3601
            are bound, or all slots from 1 on if the export lists no slots.
        trial: whether to let messages without a stub complete.
    """
    if trial and ALL_MESSAGES not in stubs.by_name:
        stubs = replace(stubs, by_name={**stubs.by_name, ALL_MESSAGES: parse_stub(TRIAL_STUB)})
    return _Importer(read_document(path), stubs, slots).run()


def import_text(
    text: str, name: str, stubs: Stubs = NO_STUBS, slots: Collection[int] | None = None, *, file: str = ""
) -> SlcImport:
    """Import the text of an export, see `import_slc`."""
    return _Importer(parse_document(text, file, name), stubs, slots).run()


class _Importer:
    """Imports one document."""

    def __init__(self, document: SlcDocument, stubs: Stubs, slots: Collection[int] | None) -> None:
        self._document, self._stubs, self._slots = document, stubs, slots
        self._specs = specs_of({}, stubs.by_name, SLC_SPECS)
        self._report = Report(document.file, "", "RSLogix 500", document.name)
        self._rungs: dict[tuple[int, int], SlcRungRecord] = {}  # by numbers of ladder file and rung

    def run(self) -> SlcImport:
        """Import the document; see `import_slc`.

        Rungs that can't be built are refused, and the rest is built again, up to `ROUNDS` times.
        """
        document, report = self._document, self._report
        for line, text, data_file in document.others:
            report.note(text.split()[0], f"the line is not understood: {text}"[:200], line)
            if data_file and data_file not in report.lost:
                report.lost.append(data_file)
        for line, text in document.forces:
            report.note(text, "the force is not applied: set it in the rack file", line)
        routines = [self._routine(ladder) for ladder in document.ladders.values()]
        program = None
        reason = f"it can't be built in {ROUNDS} attempts"
        for _ in range(ROUNDS):
            try:
                program = self._program(routines)
                program.build()
                break
            except BuildError as error:
                program = None
                if not self._refuse_all(error.problems, routines):
                    reason = error.problems[0].text
                    break
        if program is None:
            self._refuse_rest(reason)
        else:
            report.stubs.update(program.used_stubs)
        return SlcImport(document, report, program)

    # --- rungs

    def _routine(self, record: LadderRecord) -> Routine:
        """Return the routine of a ladder file; refuse unreadable rungs, which become empty."""
        reader = RungReader(self._specs)
        rungs = []
        for number, rung in enumerate(record.rungs):
            self._report.rungs += 1
            self._rungs[record.number, number] = rung
            series: Series = ()
            try:
                if not rung.whole:
                    raise RungError("the rung has no EOR", len(rung.text), "end it with EOR")
                series = reader.read(rung.words)
            except RungError as error:
                self._refuse(record.number, number, str(error), error.remedy, error.column)
            rungs.append(Rung(series, rung.comment, Origin(self._document.file, rung.line)))
        return Routine(routine_name(record.number), tuple(rungs), record.name)

    def _refuse(self, file: int, number: int, reason: str, remedy: str, column: int = 1) -> None:
        """Add a rung to the refused ones; its column is counted from 1."""
        rung = self._rungs[file, number]
        place = (self._document.file, rung.line, self._document.name, routine_name(file), number, column)
        self._report.refused.append(Refusal(*place, rung.text[:LONGEST], reason, remedy))

    def _refuse_all(self, problems: Iterable[Problem], routines: list[Routine]) -> bool:
        """Refuse the rungs with problems, and empty them in the routines; return whether any was refused."""
        indexes = {routine.name: index for index, routine in enumerate(routines)}
        files = {routine_name(file): file for file, _ in self._rungs}
        refused: set[tuple[int, int]] = set()
        for problem in problems:
            file, number = files.get(problem.site.routine), problem.site.rung
            if file is None or number is None:
                continue
            if (file, number) not in self._rungs or (file, number) in refused:
                continue
            refused.add((file, number))
            self._refuse(file, number, problem.text, problem.remedy)
            index = indexes[problem.site.routine]
            routines[index] = emptied(routines[index], number)
        return bool(refused)

    def _refuse_rest(self, reason: str) -> None:
        """Refuse the rungs that are not refused yet, since they can't be built together."""
        refused_rungs = {(refusal.routine, refusal.rung) for refusal in self._report.refused}
        for file, rung in self._rungs:
            if (routine_name(file), rung) not in refused_rungs:
                self._refuse(file, rung, reason, "correct the program")

    # --- the program

    def _program(self, routines: list[Routine]) -> Program:
        """Return a program with these routines and the data files that they need."""
        name = re.sub(r"\W", "_", self._document.name) or "program"
        main = routine_name(MAIN)
        has_main = any(routine.name == main for routine in routines)
        program = Program(name, main=main if has_main else None, dialect=SLC)
        program.take_stubs(self._stubs)
        files = DataFiles(self._specs)
        for routine in routines:
            files.add_uses(routine)
            program.add_routine(routine)
        self._read_data(files)
        for tag in files.tags(self._bound_images(files)):
            try:
                program.add(tag)
            except LadderError as error:
                self._report.lose(tag.name, f"it is not declared: {error}")
        return program

    def _read_data(self, files: DataFiles) -> None:
        """Add the values of the export; a value that can't be read is lost if a rung uses its file."""
        for record in self._document.data:
            for address, text, line in files.add_values(record):
                note = self._report.lose if files.has(record.file) else self._report.note
                note(address, text, line)

    def _bound_images(self, files: DataFiles) -> list[str]:
        """Return the images of the rack's slots; all other images become memory."""
        bound = []
        for image in files.images:
            if self._is_bound(_slot_of(image)):
                bound.append(image)
            else:
                self._make_memory(image, files)
        return bound

    def _make_memory(self, image: str, files: DataFiles) -> None:
        """Make an image without a module in the rack plain memory, with the size from the export."""
        text = "memory: the rack has no module there; a test or a timeline may set it"
        self._report.note("data", f"{image} is {text}")
        slot = self._document.slots.get(_slot_of(image))
        if slot is not None:
            files.add_image(image, (slot.inputs if image.startswith("I") else slot.outputs) or 0)

    def _is_bound(self, slot: int) -> bool:
        """Return whether a slot's images are the rack's images."""
        if self._slots is not None:
            return slot in self._slots
        if not self._document.slots:
            return slot > 0
        return slot in self._document.slots and self._document.slots[slot].is_3601


def _slot_of(image: str) -> int:
    """Return the slot of an image such as `I:1`."""
    return int(image.split(":")[1])
