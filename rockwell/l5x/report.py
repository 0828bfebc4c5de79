"""The report of an import: every rung is imported, or refused with place, reason and remedy.

`imported + len(refused) == rungs` holds always. What is not a rung (a routine of function blocks, an encoded
add-on, a line of structured text) is refused as an object.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

_COUNTED = ("total", "imported", "refused", "ran")

LOST_SHOWN = 8
"""Names that the warning of a run lists."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """A rung, or an object, that is not imported.

    Attributes:
        line: its line there.
        program: the program, or the add-on instruction.
        routine: the routine, "" for an object outside of routines.
        rung: the number of the rung, None for an object.
        column: where in the rung's text, from 1.
        text: the rung.
        reason: what is wrong.
        remedy: what helps.
        tag: the tag that is missing, "" if that is not the reason.
    """

    file: str
    line: int
    program: str
    routine: str
    rung: int | None
    column: int
    text: str
    reason: str
    remedy: str
    tag: str = ""

    @property
    def place(self) -> str:
        """Where it is in the program, as `Main.Feed rung 3`."""
        rung = "" if self.rung is None else f" rung {self.rung}"
        return ".".join(filter(None, (self.program, self.routine))) + rung

    def as_json(self) -> dict[str, Any]:
        """Return it for `--json`."""
        return {name: value for name, value in asdict(self).items() if name != "tag"}

    def __str__(self) -> str:
        where = [self.program, self.routine, "" if self.rung is None else f"rung {self.rung}"]
        place = ", ".join(filter(None, where))
        column = "" if self.rung is None else f", column {self.column}"
        return f"{self.file}:{self.line}: {place}{column}: {self.reason}; {self.remedy}"


@dataclass(slots=True)
class Note:
    """Something that a reader should know, and that prevents nothing from running.

    Attributes:
        line: its line in the file, 0 without one.
        name: what it is about.
        text: what there is to say.
        times: how often it applies to that name.
    """

    line: int
    name: str
    text: str
    times: int = 1

    def __str__(self) -> str:
        more = f", {self.times} times" if self.times > 1 else ""
        return f"{self.name}: {self.text}" + (f" (line {self.line}{more})" if self.line else more)


@dataclass(slots=True)
class StructuredRoutine:
    """Structured text of one routine.

    Attributes:
        owner: the program, or the add-on instruction.
        name: the routine.
        statements: statements in it, those in blocks included.
        refused: those that are not imported.
        ran: whether those that are imported ran in the trial.
    """

    owner: str
    name: str
    lines: int
    statements: int
    refused: int = 0
    ran: bool = False

    @property
    def is_refused(self) -> bool:
        """Whether nothing of it is imported."""
        return self.refused >= self.statements and bool(self.refused)

    def counts(self) -> Iterator[tuple[str, int, int]]:
        """Yield routines, lines and statements: how many there are, and how many are refused."""
        whole = self.is_refused
        yield "routines", 1, int(whole)
        yield "lines", self.lines, self.lines if whole else min(self.refused, self.lines)
        yield "statements", self.statements, self.refused


@dataclass(slots=True)
class Report:
    """The result of an import.

    Attributes:
        revision: software revision of the export.
        target: what was exported.
        controller: its name.
        rungs: rungs in the file.
        ran: imported rungs in programs that did the trial's scans on both back ends without a difference.
        refused: rungs that are not imported.
        objects: other things that are not imported.
        declared: tags that the file leaves out and that are declared from their use, with their types.
        notes: what else a reader should know.
        lost: what starts with another value than in the file, or is not declared; each has a note.
        stubs: instructions that a stub replaces, with the stub.
        faults: major faults and differences in the trial, by program.
        texts: routines of structured text.
    """

    file: str
    revision: str = ""
    target: str = ""
    controller: str = ""
    rungs: int = 0
    ran: int = 0
    refused: list[Refusal] = field(default_factory=list)
    objects: list[Refusal] = field(default_factory=list)
    declared: dict[str, str] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    stubs: dict[str, str] = field(default_factory=dict)
    faults: dict[str, str] = field(default_factory=dict)
    texts: list[StructuredRoutine] = field(default_factory=list)
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
        """Count routines, lines and statements of structured text: in all, imported, refused, ran."""
        counted = {name: dict.fromkeys(_COUNTED, 0) for name in ("routines", "lines", "statements")}
        for each in self.texts:
            for name, total, refused in each.counts():
                imported = total - refused
                for key, count in zip(_COUNTED, (total, imported, refused, imported * each.ran), strict=True):
                    counted[name][key] += count
        return counted

    def note(self, name: str, text: str, line: int = 0) -> None:
        """Add a note; one that is there already is counted."""
        note = self._noted.get((name, text))
        if note is not None:
            note.times += 1
            return
        self._noted[name, text] = note = Note(line, name, text)
        self.notes.append(note)

    def lose(self, name: str, text: str, line: int = 0) -> None:
        """Add a note on something that does not start with the value that it has in the file."""
        self.note(name, text, line)
        if name not in self.lost:
            self.lost.append(name)

    @property
    def warning(self) -> str:
        """What a run says of values that are lost, in one line; "" if none is."""
        if not self.lost:
            return ""
        shown = ", ".join(self.lost[:LOST_SHOWN])
        more = f" and {len(self.lost) - LOST_SHOWN:,} more" * (len(self.lost) > LOST_SHOWN)
        return f"{self.file}: values of the export are lost: {shown}{more}; scanrack l5x {self.file} says why"

    def as_json(self) -> dict[str, Any]:
        """Return it for `--json`."""
        return {
            "file": self.file,
            "revision": self.revision,
            "target": self.target,
            "controller": self.controller,
            "rungs": self.rungs,
            "imported": self.imported,
            "ran": self.ran,
            "structured_text": self.structured(),
            "refused": [each.as_json() for each in self.refused],
            "objects": [each.as_json() for each in self.objects],
            "declared": self.declared,
            "stubs": self.stubs,
            "faults": self.faults,
            "notes": [asdict(each) for each in self.notes],
            "lost": self.lost,
        }

    def _structured_line(self) -> str:
        counted = self.structured()
        routines, lines = (counted[name]["total"] for name in ("routines", "lines"))
        total, imported, refused, ran = counted["statements"].values()
        head = f"structured text, {routines} routines of {lines} lines"
        return f"{head}: {total} statements, {imported} imported, {refused} refused, {ran} ran"

    def lines(self) -> Iterator[str]:
        """Yield it as text."""
        revision = f", software revision {self.revision}" if self.revision else ""
        yield f"{self.file}: {self.target or 'L5X'} of {self.controller}{revision}"
        if self.rungs or not self.texts:
            yield f"{self.rungs} rungs: {self.imported} imported, {len(self.refused)} refused, {self.ran} ran"
        if self.texts:
            yield self._structured_line()
        for title, listed in (
            ("refused rungs", self.refused),
            ("refused objects", self.objects),
            ("notes", self.notes),
        ):
            if listed:
                yield f"{title}:"
                yield from (f"    {each}" for each in listed)
        for title, pairs in (
            ("declared from their use", self.declared),
            ("stubs", self.stubs),
            ("in the trial", self.faults),
        ):
            if pairs:
                yield f"{title}:"
                yield from (f"    {name}: {text}" for name, text in pairs.items())
