"""Reads rungs and structured text of a document; a refused rung becomes an empty rung.

The number of a rung in the tree is its index in the document, so a later refusal can find its text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from scanrack.io_images.site import NOWHERE, Site
from scanrack.ladder.instructions import BY_NAME
from scanrack.ladder.lowering.text import parse_rung
from scanrack.ladder.model.chart_checks import unreached
from scanrack.ladder.model.errors import LadderError, RungTextError
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.spec import Spec
from scanrack.ladder.model.statements import Empty, Region, statements_in
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import Block, Origin, Rung
from scanrack.ladder.st import parse_statements

from .charts import ChartBuilder, ChartRefusedError
from .diagrams.lowering import DiagramText, lower_diagram
from .diagrams.sheets import DiagramError
from .diagrams.wire_values import DocumentNames
from .edits import NORMAL, RUNG_TYPES, TEXT_TYPES, Edit
from .presets import Presets
from .report import Refusal, Report, StructuredRoutine
from .xml.limits import MOST_IN_RUNG, instructions_in
from .xml.records import EncodedRecord, L5xRungRecord, RoutineRecord, lines_of

UNKNOWN = "stub or remove the instruction"
"""Remedy for an unknown instruction."""

_CORRECT_CHART = "correct the chart, or stub the routine"
_CORRECT_DIAGRAM = 'correct the diagram, or let it do nothing: {} = "false" below [stubs]'
_PENDING = "accept or cancel the edits, then export again"


_CALLED = re.compile(r"\b([A-Za-z_]\w*+)\(")
_QUOTED = re.compile(r"'(?:[^'$\n]|\$[^\n])*+'?")
_ASIDE = re.compile(
    r"'(?:[^'$\n]|\$[^\n])*+'?|\(\*(?:.*?\*\)|.*)|/\*(?:.*?\*/|.*)|//[^\n]*|^[ \t]*#[^\n]*",
    re.DOTALL | re.MULTILINE,
)
"""Strings, comments and region lines of structured text."""

_INVOKED = re.compile(r"(?:\A|;|:(?!=)|\b(?:THEN|ELSE|DO|REPEAT)\b)\s*([A-Za-z_]\w*+)\s*\(", re.IGNORECASE)
"""A call at the beginning of a statement."""

_STATEMENTS = frozenset({"IF", "ELSIF", "WHILE", "UNTIL", "CASE"})
"""Keywords that an expression in parentheses may follow."""


def instruction_names(routines: Iterable[RoutineRecord]) -> list[str]:
    """Return the names of the called instructions, without duplicates."""
    names: dict[str, None] = {}
    for routine in routines:
        for rung in routine.rungs:
            names.update(dict.fromkeys(_CALLED.findall(_QUOTED.sub("", rung.text))))
        text = _ASIDE.sub(" ", "\n".join(line for line, _ in routine.lines))
        names.update((name, None) for name in _INVOKED.findall(text) if name.upper() not in _STATEMENTS)
    return list(names)


def _column(text: str, site: Site) -> int:
    """Return the column of a site in a rung, or of its instruction; 1 if neither is known."""
    if site.column or not site.instruction:
        return site.column or 1
    column = text.find(site.instruction)
    return (column if column >= 0 else text.find(site.instruction.partition("(")[0])) + 1 or 1


def _edits_of_text(owner: str, record: RoutineRecord) -> Iterator[Edit]:
    """Yield the versions of a routine's structured text, if it has online edits."""
    if len(record.texts) < 2:
        return
    for index, (kind, line) in enumerate(record.texts):
        description = TEXT_TYPES[kind].description if kind in TEXT_TYPES else "a text"
        runs = index == record.chosen
        yield Edit(line, owner, record.name, rung=None, type=kind, says=description, runs=runs)


def line_of(record: RoutineRecord, number: int) -> int:
    """Return the file's line for a line of structured text; the routine's line if the text is empty."""
    numbers = lines_of(record.lines)[1] or [record.line]
    return numbers[min(max(number - 1, 0), len(numbers) - 1)]


class RoutineReader:
    """Reads routines and counts rungs."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._records: dict[tuple[str, str], RoutineRecord] = {}
        self._refused: set[tuple[str, str, int]] = set()
        self._presets: dict[str, Presets] = {}
        self._texts: dict[tuple[str, str], StructuredRoutine] = {}
        self._diagrams: dict[tuple[str, str], DiagramText] = {}
        self.names_of: Callable[[str], DocumentNames] | None = None  # for diagrams, by owner
        self.specs: Mapping[str, Spec] = BY_NAME  # all instruction specs, by name in capitals
        self.stubbed: frozenset[str] = frozenset()  # stubbed instructions and routines, in capitals

    def routine(self, owner: str, record: RoutineRecord, inouts: Collection[str] = ()) -> Routine | None:
        """Return a routine of a program or add-on; None if it is refused.

        Args:
            inouts: the InOuts of the add-on, in capitals.
        """
        self._presets.setdefault(owner.upper(), Presets(inouts))
        self._records[owner.upper(), record.name.upper()] = record
        self._report.rungs += len(record.rungs)
        if record.kind == "FBD":
            return self._diagram(owner, record)
        if record.kind == "ST":
            self._report.edits += _edits_of_text(owner, record)
            return self._statements(owner, record)
        if record.kind == "SFC":
            return self._chart(owner, record)
        rungs = tuple(self._rung(owner, record, index, rung) for index, rung in enumerate(record.rungs))
        return Routine(record.name, rungs, record.comment)

    def skipped(self, owner: str, record: RoutineRecord, reason: str, remedy: str) -> None:
        """Refuse all rungs of a routine that is not read, such as one with a repeated name."""
        self._report.rungs += len(record.rungs)
        for rung in record.rungs:
            self._refuse_rung(owner, record.name, rung, reason, remedy)
        if record.lines:
            self._count_text(owner, record)
            self.refuse_object(owner, record.name, reason, record.line, remedy)

    def encoded(self, owner: str, record: EncodedRecord) -> None:
        """Refuse a routine whose source is encoded (protected)."""
        text = "its source is encoded, so it is not in the file"
        self.refuse_object(owner, record.name, text, record.line, "export it without source protection")

    def _rung(self, owner: str, record: RoutineRecord, index: int, rung: L5xRungRecord) -> Rung:
        """Return a rung, or an empty rung if it does not run or is refused."""
        origin = Origin(self._report.file, rung.line)
        if rung.texts > 1:
            name = f"{owner}.{record.name} rung {rung.number}"
            self._report.note(name, f"it has {rung.texts} texts; the first one is read", rung.line)
        kind = RUNG_TYPES.get(rung.kind if rung.kind != "n" else NORMAL)
        if kind is None:
            types = ", ".join(RUNG_TYPES)
            reason = f"it is of type {rung.kind}; types of rungs are {types}"
            self.refuse(owner, record.name, index, reason, _PENDING)
            return Rung((), rung.comment, origin)
        runs = kind.tested if record.tests_edits else kind.runs
        if kind is not RUNG_TYPES[NORMAL]:
            place = (rung.line, owner, record.name, rung.number)
            edit = Edit(*place, type=rung.kind, says=kind.description, runs=runs)
            self._report.edits.append(edit)
        if not runs:
            return Rung((), rung.comment, origin)
        count = instructions_in(rung.text)
        if count > MOST_IN_RUNG:
            reason = f"it has {count:,} instructions; {MOST_IN_RUNG:,} are allowed"
            self.refuse(owner, record.name, index, reason, "divide it")
            return Rung((), rung.comment, origin)
        try:
            parsed = parse_rung(
                rung.text,
                file=self._report.file,
                line=rung.line,
                rung=rung.number,
                comment=rung.comment,
                specs=self.specs,
            )
        except RungTextError as error:
            self.refuse(owner, record.name, index, error.reason, UNKNOWN, error.site)
            return Rung((), rung.comment, origin)
        return self._presets[owner.upper()].with_settled_presets(parsed, self.specs)

    def _statements(self, owner: str, record: RoutineRecord) -> Routine | None:
        """Return a routine of structured text; None if it is refused."""
        lines, numbers = lines_of(record.lines)
        try:
            block = parse_statements(
                "\n".join(lines), file=self._report.file, lines=numbers, specs=self.specs
            )
        except RungTextError as error:
            reason = f"column {error.site.column}: {error.reason}"
            self._refuse_text(owner, record, reason, error.site.line, "correct the line")
            return None
        self._count_text(owner, record, block)
        return Routine(record.name, (), record.comment, block)

    def _chart(self, owner: str, record: RoutineRecord) -> Routine | None:
        """Return a routine with a chart, whose unreached steps are noted; None if it is refused."""
        try:
            if record.chart is None:
                raise ChartRefusedError("the chart is not in the file", Site(line=record.line))
            chart = ChartBuilder(record.chart, self._report.file, self.specs).chart()
        except LadderError as error:
            reason = error.reason if isinstance(error, RungTextError) else str(error)
            self._refuse_text(owner, record, reason, next(iter(error.sites), NOWHERE).line, _CORRECT_CHART)
            return None
        for step in unreached(chart):
            self._report.note(f"{owner}.{record.name}", f"{step.text}; only SFR can reach it", record.line)
        routine = Routine(record.name, (), record.comment, chart=chart)
        self._count_text(owner, record, routine.block)
        return routine

    def _diagram(self, owner: str, record: RoutineRecord) -> Routine | None:
        """Return a diagram as structured text with a drawing; None if it is refused."""
        try:
            if record.chart is None or self.names_of is None:
                raise DiagramError("the diagram is not in the file", Site(line=record.line))
            diagram = lower_diagram(record.chart, record.name, self.names_of(owner))
        except LadderError as error:
            line = next(iter(error.sites), NOWHERE).line
            self._refuse_text(owner, record, str(error), line, _CORRECT_DIAGRAM)
            return None
        self._diagrams[owner.upper(), record.name.upper()] = diagram
        text = "\n".join(row.text for row in diagram.lines)
        numbers = [row.number for row in diagram.lines]
        try:
            block = parse_statements(text, file=self._report.file, lines=numbers, specs=self.specs)
        except RungTextError as error:
            place = next((row.place for row in diagram.lines if row.number == error.site.line), "")
            reason = f"{place}: {error.reason}"
            self._refuse_text(owner, record, reason, error.site.line, _CORRECT_DIAGRAM)
            return None
        self._count_text(owner, record, block)
        return Routine(record.name, (), record.comment, block, drawing=diagram.drawing)

    def _refuse_text(
        self, owner: str, record: RoutineRecord, reason: str, line: int | None, remedy: str
    ) -> None:
        """Refuse a routine that can't be read; `line` is None or 0 for the routine's own line."""
        self._count_text(owner, record)
        self.refuse_object(owner, record.name, reason, line or record.line, remedy)

    def generated(self, owner: str) -> list[Tag]:
        """Return the tags that the diagrams of a program or an add-on need."""
        tags: list[Tag] = []
        for (diagram_owner, _), diagram in self._diagrams.items():
            if diagram_owner == owner.upper():
                tags += diagram.tags
        return tags

    def place_of(self, owner: str, routine: str, number: int) -> tuple[str, int]:
        """Return the place (for a message) and the file line for a line of structured text or a diagram."""
        diagram = self._diagrams.get((owner.upper(), routine.upper()))
        if diagram is not None:
            line = diagram.lines[min(max(number - 1, 0), len(diagram.lines) - 1)]
            return line.place, line.number
        record = self.record(owner, routine)
        return f"line {number}", 0 if record is None else line_of(record, number)

    def _count_text(self, owner: str, record: RoutineRecord, block: Block | None = None) -> None:
        """Count the statements of a routine; all of them count as refused if it can't be read."""
        lines, _ = lines_of(record.lines)
        if block is None:
            refused = count = _ASIDE.sub(" ", "\n".join(lines)).count(";")
        else:
            refused = 0
            count = sum(not isinstance(statement, Empty | Region) for statement in statements_in(block))
        if record.kind == "FBD":
            lines, count = [], 1
        if record.kind in ("SFC", "FBD"):  # an empty one counts, too
            count = max(count, 1)
            refused = max(refused, 1) if block is None else 0
        structured = StructuredRoutine(owner, record.name, len(lines), count, refused, kind=record.kind)
        self._texts.setdefault((owner.upper(), record.name.upper()), structured)
        self._report.texts.append(structured)

    # --- refusing

    def refuse(
        self, owner: str, routine: str, index: int, reason: str, remedy: str, site: Site = NOWHERE
    ) -> None:
        """Refuse a rung by its index; ignore repeated refusals."""
        key = (owner.upper(), routine.upper())
        if (*key, index) in self._refused:
            return
        self._refused.add((*key, index))
        self._refuse_rung(owner, routine, self._records[key].rungs[index], reason, remedy, site)

    def _refuse_rung(
        self, owner: str, routine: str, rung: L5xRungRecord, reason: str, remedy: str, site: Site = NOWHERE
    ) -> None:
        """Report a rung as refused, at the column of the error's site."""
        column = _column(rung.text, site)
        place = (self._report.file, rung.line, owner, routine, rung.number, column)
        self._report.refused.append(Refusal(*place, rung.text, reason, remedy, site.tag))

    def refuse_object(self, owner: str, routine: str, reason: str, line: int, remedy: str) -> None:
        """Refuse a routine or another object, unless it is stubbed."""
        structured = self._texts.get((owner.upper(), routine.upper()))
        if structured is not None:
            structured.refused = structured.statements
        is_add_on = owner.upper() in self.specs and owner.upper() not in BY_NAME
        name = owner if is_add_on else routine
        if not {name.upper(), routine.upper()}.isdisjoint(self.stubbed):
            if not is_add_on:
                self._report.stubs[routine] = "the routine does nothing"
            return
        self._report.objects.append(
            Refusal(
                self._report.file,
                line,
                owner,
                routine,
                rung=None,
                column=1,
                text="",
                reason=reason,
                remedy=remedy.replace("{}", name),
            )
        )

    def refuse_statement(self, owner: str, routine: str, number: int, reason: str, remedy: str) -> None:
        """Refuse a statement by its line; the other statements of its routine remain."""
        structured = self._texts.get((owner.upper(), routine.upper()))
        if structured is None:
            return
        refused = structured.refused
        place, line = self.place_of(owner, routine, number)
        self.refuse_object(owner, routine, f"{place}: {reason}", line, remedy)
        structured.refused = min(refused + 1, structured.statements)  # `refuse_object` counts all of them

    def refuse_routine(self, owner: str, routine: str, reason: str, remedy: str) -> bool:
        """Refuse a whole routine; return whether the file has it."""
        record = self.record(owner, routine)
        if record is None:
            return False
        for index in range(len(record.rungs)):
            self.refuse(owner, routine, index, reason, remedy)
        if record.kind in ("ST", "SFC", "FBD"):
            self.refuse_object(owner, routine, reason, record.line, remedy)
        return True

    def mark_run(self, owner: str, routine: str) -> None:
        """Mark a routine of structured text as completed in the trial; ignore other routines."""
        structured = self._texts.get((owner.upper(), routine.upper()))
        if structured is not None:
            structured.ran = True

    def record(self, owner: str, routine: str) -> RoutineRecord | None:
        """Return the record of a routine; None if it was not read."""
        return self._records.get((owner.upper(), routine.upper()))

    def imported_rungs(self, owner: str, routine: str) -> int:
        """Return the number of imported rungs of a routine."""
        key = (owner.upper(), routine.upper())
        record = self._records.get(key)
        return sum((*key, index) not in self._refused for index in range(len(record.rungs) if record else 0))
