"""Totals over a folder of exports: runs and reasons for refusals, without tag names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scanrack.jobs.load.program import EXPORT_SUFFIXES
from scanrack.jobs.load.trial import Trial, tried
from scanrack.ladder.model.errors import LadderError
from scanrack.rockwell.l5x.mnemonics import MNEMONICS
from scanrack.rockwell.l5x.report import Report
from scanrack.terminal.as_json import say_json
from scanrack.terminal.status import BAD_INPUT, DONE, NO, complain
from scanrack.terminal.terminal import say

LACKS = "names that the file does not have: tags, members, routines, add-ons"
WHOLE = "Controller"

_REASONS = (
    (
        re.compile(r"scanrack has no ([\w, ]+) in function block diagrams"),
        "blocks without an implementation: {}",
    ),
    (re.compile(r"is a loop without|they are a loop without"), "a loop of blocks without a feedback wire"),
    (re.compile(r"source is encoded|source of this add-on is encoded"), "encoded"),
    (re.compile(r"\btag \S+ is not declared: "), "tags that are not declared"),
    (re.compile(r"no (?:tag|routine|parameter or local tag|add-on|instruction) |has no member "), LACKS),
    (re.compile(r"\b(\w+) is unknown"), "an instruction without an implementation: {}"),
    (re.compile(r"is of type \w+; types of rungs"), "edits in progress"),
    (re.compile(r"^(?:step|stop|transition|branch|leg|link|action) .+ (?:has|have|is|and) "), "a chart"),
    (re.compile(r"^(\w+)\("), "an operand of {}"),
    (re.compile(r"expected "), "text that is no logic"),
)
"""Kinds of refusals, selected by the first pattern that matches; {} is the name of an instruction."""


def kind_of(reason: str) -> str:
    """Return the kind of a refusal, without the user's names.

    >>> kind_of("MOV(Level,N): no tag Level (did you mean Lever?)")
    'names that the file does not have: tags, members, routines, add-ons'
    >>> kind_of("ADD(Lamp,1,N): Lamp is a BOOL, a number is needed")
    'an operand of ADD'
    """
    for pattern, kind in _REASONS:
        match = pattern.search(reason)
        if match is not None:
            name = match[1] if pattern.groups else ""
            return kind.format(name) if not name or name.upper() in MNEMONICS or "blocks" in kind else LACKS
    return "other"


@dataclass(slots=True)
class FolderReport:
    """The totals over a folder."""

    files: int = 0
    controllers: int = 0  # exports of a whole controller
    complete: int = 0  # whole controllers without a refusal
    rungs: int = 0
    imported: int = 0
    ran: int = 0
    unusable: int = 0  # files that are not exports, or exceed a limit
    refusals: dict[str, int] = field(default_factory=dict)  # by kind
    refused_files: dict[str, int] = field(default_factory=dict)  # by kind: files with such a refusal
    any_refused: bool = False

    def add(self, report: Report) -> None:
        """Add the counts of a file's report, and its refusals by kind."""
        is_whole = report.target == WHOLE
        self.controllers += is_whole
        self.complete += is_whole and report.complete
        self.any_refused |= not report.complete
        self.rungs += report.rungs
        self.imported += report.imported
        self.ran += report.ran
        kinds = [kind_of(refusal.reason) for refusal in (*report.refused, *report.objects)]
        for kind in kinds:
            self.refusals[kind] = self.refusals.get(kind, 0) + 1
        for kind in set(kinds):
            self.refused_files[kind] = self.refused_files.get(kind, 0) + 1

    def reasons(self) -> list[dict[str, Any]]:
        """Return the kinds of refusals, most frequent first."""
        rows: list[dict[str, Any]] = [
            {"reason": kind, "files": self.refused_files[kind], "refusals": self.refusals[kind]}
            for kind in self.refusals
        ]
        return sorted(rows, key=lambda row: (-row["files"], -row["refusals"], row["reason"]))

    def as_json(self) -> dict[str, Any]:
        """Return the totals for `--json`."""
        counts = ("files", "controllers", "complete", "rungs", "imported", "ran", "unusable")
        return {name: getattr(self, name) for name in counts} | {"reasons": self.reasons()}

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report."""
        share = f"{self.ran / self.rungs:.2%}" if self.rungs else "none"
        yield f"{self.files} exports, {self.unusable} of them can't be used"
        yield f"{self.rungs:,} rungs: {self.imported:,} imported, {self.ran:,} ran ({share})"
        yield f"{self.controllers} whole controllers, {self.complete} without a refusal"
        rows = self.reasons()
        if rows:
            yield "files  refusals  reason"
            yield from (f"{row['files']:5}  {row['refusals']:8}  {row['reason']}" for row in rows)


def exports_in(folder: Path) -> list[Path]:
    """Return the exports below a folder, by name."""
    suffixes = {suffix.upper() for suffix in EXPORT_SUFFIXES}
    return sorted(path for path in folder.rglob("*") if path.suffix.upper() in suffixes and path.is_file())


def report_of(paths: Iterable[Path], trial: Trial) -> FolderReport:
    """Import exports and run their trials; return the totals."""
    report = FolderReport()
    for path in paths:
        report.files += 1
        try:
            report.add(tried(path, trial).report)
        except LadderError:
            report.unusable += 1
    return report


def l5x_folder(folder: Path, trial: Trial, *, as_json: bool) -> int:
    """Print the totals over a folder; return the exit status."""
    paths = exports_in(folder)
    if not paths:
        return complain(f"{folder}: no .L5X or .SLC file", BAD_INPUT)
    report = report_of(paths, trial)
    if as_json:
        say_json(report.as_json())
    else:
        for line in report.lines():
            say(line)
    return NO if report.any_refused or report.unusable else DONE
