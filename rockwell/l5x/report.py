"""The report of an import: every rung is either imported, or refused with a place, reason and remedy.

`imported + len(refused) == rungs` is always true. Other content is refused as an object: a function block
diagram, an encoded add-on, or a line of structured text.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

from scanrack.ladder.model.types import DataType

from .edits import Edit

_COUNTED = ("total", "imported", "refused", "ran")

LOST_SHOWN = 8
"""Maximum number of names listed in the warning of a run."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """A rung or object that is not imported."""

    file: str
    line: int
    program: str  # the program or add-on instruction
    routine: str  # "" for an object outside of routines
    rung: int | None  # the number of the rung; None for an object
    column: int  # in the rung's text, from 1
    text: str  # the rung
    reason: str  # the error
    remedy: str
    tag: str = ""

    @property
    def place(self) -> str:
        """Its place in the program, for example `Main.Feed rung 3`."""
        rung = "" if self.rung is None else f" rung {self.rung}"
        return ".".join(filter(None, (self.program, self.routine))) + rung

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {name: value for name, value in asdict(self).items() if name != "tag"}

    def __str__(self) -> str:
        places = [self.program, self.routine, "" if self.rung is None else f"rung {self.rung}"]
        place = ", ".join(filter(None, places))
        column = "" if self.rung is None else f", column {self.column}"
        return f"{self.file}:{self.line}: {place}{column}: {self.reason}; {self.remedy}"


@dataclass(slots=True)
class Note:
    """A remark on content that does not prevent the program from running."""

    line: int  # in the file, 0 if unknown
    name: str  # the tag, type or other content that it is about
    text: str
    times: int = 1  # number of occurrences with that name and text

    def __str__(self) -> str:
        suffix = f", {self.times} times" if self.times > 1 else ""
        return f"{self.name}: {self.text}" + (f" (line {self.line}{suffix})" if self.line else suffix)


@dataclass(slots=True)
class StructuredRoutine:
    """Structured text of one routine."""

    owner: str  # the program or add-on instruction
    name: str
    lines: int
    statements: int  # number of statements, including nested ones
    refused: int = 0  # number of refused statements
    ran: bool = False  # whether the imported statements ran in the trial
    kind: str = "ST"  # `ST`; `SFC` for a chart; `FBD` for a diagram, which counts as one statement

    @property
    def is_refused(self) -> bool:
        """Whether all of its statements are refused."""
        return self.refused >= self.statements and bool(self.refused)

    def totals_and_refused(self) -> dict[str, tuple[int, int]]:
        """Return the total number and the refused number of `routines`, `lines` and `statements`.

        Each refused statement counts as one line, since its lines are not recorded.
        """
        refused_lines = self.lines if self.is_refused else min(self.refused, self.lines)
        return {
            "routines": (1, int(self.is_refused)),
            "lines": (self.lines, refused_lines),
            "statements": (self.statements, self.refused),
        }


@dataclass(slots=True)
class Report:
    """The report of an import."""

    file: str
    revision: str = ""  # software revision of the export
    target: str = ""  # the exported object
    controller: str = ""  # its name
    rungs: int = 0  # number of rungs in the file
    ran: int = 0  # imported rungs that completed all trial scans without a difference between the back ends
    refused: list[Refusal] = field(default_factory=list)
    objects: list[Refusal] = field(default_factory=list)  # refused objects other than rungs
    declared: dict[str, str] = field(default_factory=dict)  # undeclared tags with their inferred types
    notes: list[Note] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)  # tags whose initial value in the file is lost
    stubs: dict[str, str] = field(default_factory=dict)  # stubbed instructions, with their stubs
    faults: dict[str, str] = field(default_factory=dict)  # faults and differences in the trial, by program
    texts: list[StructuredRoutine] = field(default_factory=list)  # routines of structured text
    edits: list[Edit] = field(default_factory=list)  # rungs and texts of online edits
    forces: dict[str, bool | int | float] = field(default_factory=dict)  # forces in the file, by address
    undeclared: dict[str, str] = field(default_factory=dict)  # reasons, by tag in capitals
    _noted: dict[tuple[str, str], Note] = field(default_factory=dict, repr=False)

    @property
    def imported(self) -> int:
        """Number of rungs that are imported."""
        return self.rungs - len(self.refused)

    @property
    def complete(self) -> bool:
        """Whether nothing is refused."""
        return not (self.refused or self.objects)

    def structured(self) -> dict[str, dict[str, int]]:
        """Count routines, lines and statements of structured text: total, imported, refused, ran."""
        counts = {name: dict.fromkeys(_COUNTED, 0) for name in ("routines", "lines", "statements")}
        for text in self._routines_of_kind("ST", "SFC"):
            for name, (total, refused) in text.totals_and_refused().items():
                imported = total - refused
                ran = imported if text.ran else 0
                for key, count in zip(_COUNTED, (total, imported, refused, ran), strict=True):
                    counts[name][key] += count
        return counts

    def _routines_of_kind(self, *kinds: str) -> list[StructuredRoutine]:
        return [text for text in self.texts if text.kind in kinds]

    def drawn(self, kind: str) -> dict[str, int]:
        """Count charts (`SFC`) or function block diagrams (`FBD`): total, imported, refused, ran."""
        routines = self._routines_of_kind(kind)
        refused = sum(routine.is_refused for routine in routines)
        ran = sum(routine.ran and not routine.is_refused for routine in routines)
        return dict(zip(_COUNTED, (len(routines), len(routines) - refused, refused, ran), strict=True))

    def declare(self, name: str, kind: DataType, dims: tuple[int, ...]) -> None:
        """Add a tag or member that the file lacks, with its inferred type."""
        self.declared[name] = kind.name + "".join(f"[{dim}]" for dim in dims)

    def note(self, name: str, text: str, line: int = 0) -> None:
        """Add a note, or count a repeated one."""
        note = self._noted.get((name, text))
        if note is not None:
            note.times += 1
            return
        self._noted[name, text] = note = Note(line, name, text)
        self.notes.append(note)

    def lose(self, name: str, text: str, line: int = 0) -> None:
        """Add a note on a lost initial value."""
        self.note(name, text, line)
        if name not in self.lost:
            self.lost.append(name)

    def leave_out(self, name: str, reason: str, line: int = 0) -> None:
        """Add a note on a tag that can't be declared; refusals of rungs that use it repeat the reason."""
        self.undeclared[name.upper()] = reason
        self.lose(name, f"it is not declared: {reason}", line)

    def reason_undeclared(self, program: str, tag: str) -> str:
        """Return why a tag in a program's scope is not declared; "" if the file does not have the tag."""
        scoped_name = rf"\{program}.{tag}".upper()
        return self.undeclared.get(scoped_name) or self.undeclared.get(tag.upper(), "")

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for a run, about lost values, forces and online edits."""
        texts = []
        if self.lost:
            losses = ", ".join(self.lost[:LOST_SHOWN])
            more = len(self.lost) - LOST_SHOWN
            suffix = f" and {more:,} more" if more > 0 else ""
            lost = f"values of the export are lost: {losses}{suffix}"
            texts.append(f"{self.file}: {lost}; scanrack l5x {self.file} says why")
        if self.forces:
            texts.append(f"{self.file}: the export has {len(self.forces)} forces; --forces holds them")
        if self.edits:
            runs = sum(edit.runs for edit in self.edits)
            edits = f"the export has online edits, {runs} run and {len(self.edits) - runs} do not"
            texts.append(f"{self.file}: {edits}; scanrack l5x {self.file} lists them")
        return tuple(texts)

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {
            "file": self.file,
            "revision": self.revision,
            "target": self.target,
            "controller": self.controller,
            "rungs": self.rungs,
            "imported": self.imported,
            "ran": self.ran,
            "structured_text": self.structured(),
            "charts": self.drawn("SFC"),
            "diagrams": self.drawn("FBD"),
            "refused": [refusal.as_json() for refusal in self.refused],
            "objects": [entry.as_json() for entry in self.objects],
            "declared": self.declared,
            "stubs": self.stubs,
            "faults": self.faults,
            "edits": [asdict(edit) for edit in self.edits],
            "forces": self.forces,
            "notes": [asdict(note) for note in self.notes],
            "lost": self.lost,
        }

    def _structured_line(self) -> str:
        """Return a line with the counts of structured text."""
        counts = self.structured()
        routines, lines = (counts[name]["total"] for name in ("routines", "lines"))
        total, imported, refused, ran = counts["statements"].values()
        head = f"structured text, {routines} routines of {lines} lines"
        return f"{head}: {total} statements, {imported} imported, {refused} refused, {ran} ran"

    def _drawn_lines(self) -> Iterator[str]:
        """Yield one line each with the counts of charts and of diagrams, if there are any."""
        for name, kind in (("sequential function charts", "SFC"), ("function block diagrams", "FBD")):
            total, imported, refused, ran = self.drawn(kind).values()
            if total:
                yield f"{name}: {total}, {imported} imported, {refused} refused, {ran} ran"

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report as text."""
        revision = f", software revision {self.revision}" if self.revision else ""
        yield f"{self.file}: {self.target or 'L5X'} of {self.controller}{revision}"
        if self.rungs or not self.texts:
            yield f"{self.rungs} rungs: {self.imported} imported, {len(self.refused)} refused, {self.ran} ran"
        if self._routines_of_kind("ST", "SFC"):
            yield self._structured_line()
        yield from self._drawn_lines()
        sections: dict[str, Iterable[object]] = {
            "refused rungs": self.refused,
            "refused objects": self.objects,
            "online edits": self.edits,
            "forces, held with --forces only": (f"{name} = {value:g}" for name, value in self.forces.items()),
            "notes": self.notes,
            "declared from their use": map(": ".join, self.declared.items()),
            "stubs": map(": ".join, self.stubs.items()),
            "in the trial": map(": ".join, self.faults.items()),
        }
        for title, rows in sections.items():
            shown = [f"    {line}" for line in rows]
            yield from (f"{title}:", *shown) if shown else ()
