"""Writes answers as one HTML page: a table of claims, and each scenario's scans and rungs with power flow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path

from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.draw import captions_of, routines_svg
from scanrack.ladder.model.errors import LadderFault
from scanrack.ladder.prove.answers import ScenarioStep
from scanrack.ladder.prove.monitors import WatchedClaim
from scanrack.ladder.prove.replaying import ScanOf
from scanrack.traces.files.guard import PAGE, Used
from scanrack.traces.files.newfile import new_file

from .differing import EditedSubject
from .differing import lines_of as lines_of_edit
from .proving import Questions, Result
from .report import assumptions, detail_of, question_lines
from .scenario import step_text
from .subject import ProofSubject

RungPlace = tuple[str, int]
"""The routine and number of a rung."""

WIDTH = 96
"""Columns between the rails of a drawn rung."""

MOST_RUNGS = 12
"""Maximum number of rungs that are drawn for a scenario; those closest to the claim are chosen."""

STYLE = """\
body { font: 15px system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em; color: #1b1f24 }
table { border-collapse: collapse } td, th { text-align: left; padding: .2em 1em .2em 0; vertical-align: top }
code, pre { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: 13px }
.proved, .reached { color: #1a7f37 } .refuted { color: #cf222e } .unknown { color: #9a6700 }
svg { max-width: 100%; height: auto }
@media (prefers-color-scheme: dark) {
  body { background: #0d1117; color: #e6edf3 } .proved, .reached { color: #3fb950 }
  .refuted { color: #f85149 } .unknown { color: #d29922 }
}"""


def save_page(path: Path, title: str, parts: Iterable[str], used: Used) -> None:
    """Write a page to a file.

    Raises:
        OwnedError: the page would replace a different kind of file, or a file in use.
        OSError: the file can't be written.
    """
    head = f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
    with new_file(path, PAGE, used=used) as file:
        file.write(f"{head}\n<style>\n{STYLE}\n</style></head><body>\n<h1>{escape(title)}</h1>\n")
        file.writelines(f"{part}\n" for part in parts)
        file.write("</body></html>\n")


def parts_of(subject: ProofSubject, results: Sequence[Result], answers: Questions) -> Iterator[str]:
    """Yield the parts of a page of answers."""
    if results:
        yield _table(("property", "claim", "", ""), [_row(result) for result in results])
    watched = {claim.claim: claim for claim in subject.program.properties}
    for result in results:
        if result.answer.steps:
            yield f'<h2 id="{escape(result.name)}">{escape(result.name)}</h2>'
            yield _scans(subject, result.answer.steps)
            if result.rack is not None:
                yield f"<p>{escape(str(result.rack))}</p>"
            yield drawn(subject.program.program, result.answer.scans, watched[result.answer.claim])
    yield "<h2>built-in questions</h2>"
    yield f"<pre>{escape(chr(10).join(question_lines(answers)))}</pre>"
    yield "<h2>assumed</h2>"
    yield f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in assumptions(subject, results))}</ul>"


def parts_of_edit(edit: EditedSubject) -> Iterator[str]:
    """Yield the parts of a page that compares two programs."""
    yield f"<pre>{escape(chr(10).join(lines_of_edit(edit)))}</pre>"


def _row(result: Result) -> Sequence[str]:
    word = result.answer.word
    claim = f"<code>{escape(result.answer.claim.sentence)}</code>"
    return escape(result.name), claim, f'<b class="{word}">{word}</b>', escape(detail_of(result))


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{heading}</th>" for heading in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _scans(subject: ProofSubject, steps: Sequence[ScenarioStep]) -> str:
    """Return a table of the scans of a scenario, each with the changes before it."""
    return _table(
        ("scan", "what changes before it"),
        [
            (str(number), f"<code>{escape(step_text(step, subject.job.spec))}</code>")
            for number, step in enumerate(steps, start=1)
        ],
    )


def drawn(program: LadderLogic, scans: Sequence[ScanOf], watched: WatchedClaim) -> str:
    """Return the rungs that decide a claim as SVG, with the power flow in the last scan of a scenario."""
    debugger = Debugger(program)
    for scan in scans:
        scan.write_inputs(debugger.engine)
        try:
            debugger.scan(1, scan.ms)
        except LadderFault:
            break
    rung_numbers: dict[str, list[int]] = {}
    for name, number in _deciding_rungs(debugger, watched):
        rung_numbers.setdefault(name, []).append(number)
    routines = [(debugger.routine_now(name), sorted(numbers)) for name, numbers in rung_numbers.items()]
    own_names = {routine.name for routine in program.routines}
    truths = {name: debugger.truth(name) for name in rung_numbers if name in own_names}
    return routines_svg(routines, WIDTH, truths, captions_of(program))


def _deciding_rungs(debugger: Debugger, watched: WatchedClaim) -> Iterator[RungPlace]:
    """Yield the rungs that write tags of a claim, then the rungs that write tags of these rungs, ..."""
    drawable = {
        routine.name: set(routine.numbers) for routine in debugger.program.routines if routine.chart is None
    }
    reads, writers = _cross_reference(debugger)
    queue = list(writers.get(watched.bit[0], ()))
    visited: set[RungPlace] = set()
    count = 0
    while queue and count < MOST_RUNGS:
        rung = queue.pop(0)
        if rung in visited:
            continue
        visited.add(rung)
        routine, number = rung
        if number in drawable.get(routine, ()):
            count += 1
            yield rung
        for path in sorted(reads.get(rung, ())):
            for written_path in _overlapping(path, writers):
                queue += writers[written_path]


def _cross_reference(debugger: Debugger) -> tuple[dict[RungPlace, set[str]], dict[str, list[RungPlace]]]:
    """Return the paths that each rung reads, and the rungs that write each path."""
    reads: dict[RungPlace, set[str]] = {}
    writers: dict[str, list[RungPlace]] = {}
    for mention in debugger.cross_reference.mentions:
        rung = mention.site.routine, mention.site.rung or 0
        path = mention.where.path.upper()
        if mention.reads:
            reads.setdefault(rung, set()).add(path)
        if mention.writes:
            writers.setdefault(path, []).append(rung)
    return reads, writers


def _overlapping(path: str, writers: Iterable[str]) -> list[str]:
    """Return the written paths that share memory with a path: itself, its members, and its structures."""
    return sorted(
        writer
        for writer in writers
        if writer == path or writer.startswith(f"{path}.") or path.startswith(f"{writer}.")
    )
