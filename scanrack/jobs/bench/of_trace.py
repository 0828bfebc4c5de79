"""Answers questions about a trace by running its program on the recorded inputs up to a scan."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import CauseLink, Debugger, Remedies
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.reader import Trace, TraceEvent
from scanrack.traces.read.snapshots import snapshots_of
from scanrack.traces.replay import PackedTrace

from ..load.loading import LoadedRack
from ..trust.attachments import job_of
from ..why.answer import Why
from ..why.followed import run_rungs
from .moment import NotReachedError, Question, ScanChoice

if TYPE_CHECKING:
    from ..why.program_rerun import ExecutedLines
    from ..why.source.lines import Line
    from ..why.traced_run import Load


@dataclass(frozen=True, slots=True)
class TraceAnswer:
    """An answer, the number of its scan, reasons to doubt it, and the program lines that it names."""

    scan: int
    now_ns: int
    text: str
    notes: tuple[str, ...] = ()
    lines: tuple[Line, ...] = ()
    chain: CauseLink | None = None  # chain of causes; None without a question
    remedies: Remedies | None = None  # what would give the required value; None without one


def why_of_trace(
    trace: Trace,
    folder: Path,
    question: Question,
    *,
    trust: bool,
    more: Columns | None = None,
) -> TraceAnswer:
    """Answer a question about a trace.

    Args:
        trace: if it lacks its program, the answer comes from its images alone.
        trust: run any Python that came with the trace; otherwise only files that equal those in the current
            folder.
        more: scans of a growing trace that are not yet written.

    Raises:
        ValueError: a file or an option is unusable, or a name is unknown.
        UntrustedError: untrusted Python of the trace would run.
        NotReachedError: the bit of the question does not become true.
    """
    recording = PackedTrace.of(trace, more)
    if not {"rack_file", "program_file"} <= set(trace.head.metadata):
        return _of_images(recording, question)
    job = job_of(trace, folder, trust=trust)
    if isinstance(job.logic, LadderLogic):
        return _of_ladder(recording, job, question, snapshots_of(trace))
    load = _load_of(trace, job, folder, trust=trust)
    return _of_images(recording, question, job.spec, load)


def lines_of_trace(
    trace: Trace,
    folder: Path,
    scans: tuple[int, int],
    more: Columns | None = None,
    latest: Sequence[tuple[int, str]] = (),
) -> ExecutedLines:
    """Return the lines of a trace's Python program that were executed in a range of scans.

    The program is run, so it must be trusted. For `more` and errors, see `why_of_trace`.

    Args:
        latest: orders that may not be written yet, each with the scan before which it acts and its text.
    """
    from ..why.program_rerun import executed_lines

    (first, last), recording = scans, PackedTrace.of(trace, more)
    orders_recorded = {(event.scan, event.fields.get("order")) for event in recording.events}
    orders = [
        TraceEvent(now_ns, 0, ORDERS.name, {"order": text})
        for now_ns, text in latest
        if (now_ns, text) not in orders_recorded
    ]
    recording = replace(recording, events=(*recording.events, *orders))
    job = job_of(trace, folder, trust=True)
    rows = range(bisect_left(recording.numbers, first), bisect_right(recording.numbers, last))
    if not rows:
        raise ValueError(f"the trace has no scan from {first} to {last}")
    return executed_lines(recording, job.spec, _load_of(trace, job, folder, trust=True), rows)


def _load_of(trace: Trace, job: LoadedRack, folder: Path, *, trust: bool) -> Load:
    """Return a loader for a trace's Python program and its edits."""
    from ..record.order_repeater import orders_of  # imports the modules of a session, which rungs do not need
    from ..record.program_versions import versions_of
    from ..why.traced_run import Load

    editions = versions_of(trace, orders_of(trace.events()), job, folder / "edits", trust=trust)
    return Load(
        job.program,
        lambda: job_of(trace, folder, trust=trust).logic,
        lambda number: editions.again(number).logic,
    )


def _of_images(
    recording: PackedTrace, question: Question, spec: RackSpec | None = None, load: Load | None = None
) -> TraceAnswer:
    moment, first = question.moment, Why(recording, 0, spec, load)
    row = moment.row(recording) if moment.until is None else _reached(moment, first.first_on(moment.until))
    return _answer(Why(recording, row, spec, load), question)


def _of_ladder(
    recording: PackedTrace, job: LoadedRack, question: Question, snapshots: Mapping[int, str]
) -> TraceAnswer:
    assert isinstance(job.logic, LadderLogic)
    debugger = Debugger(job.logic)
    moment = _without_images(question, Why(recording, 0, job.spec, None), debugger)
    until = moment.until
    last = len(recording.scans) - 1 if until is not None else moment.row(recording)
    rungs_run = run_rungs(recording, job.spec, debugger, last, until, snapshots)
    row = _reached(moment, rungs_run.row if rungs_run.met or until is None else None)
    why = Why(recording, row, job.spec, None, debugger)
    return _answer(why, question, [*rungs_run.notes, *_departed(why, rungs_run.departs)])


def _without_images(question: Question, images: Why, debugger: Debugger) -> ScanChoice:
    """Return the choice of a scan; replace a bit of an image by the number of the scan in which it comes on.

    Raises:
        ValueError: a tag is unknown; raised before the run.
        NotReachedError: the bit of the question does not become true.
    """
    moment = question.moment
    for tag in (question.what, moment.until):
        if tag is not None and not images.is_address(tag):
            _ = debugger.tags[tag]
    if moment.until is None or not images.is_address(moment.until):
        return moment
    row = _reached(moment, images.first_on(moment.until))
    return ScanChoice(at=str(images.recording.numbers[row]))


def _departed(why: Why, row: int | None) -> list[str]:
    """Return a note about the program's deviation from the recording in a row; [] if it did not deviate."""
    if row is None:
        return []
    when = why.past.when(row)
    return [f"run again on the recorded inputs, the program writes other words from {when} on"]


def _reached(moment: ScanChoice, row: int | None) -> int:
    if row is None:
        raise NotReachedError(f"{moment.until} does not come on in the trace", filter(None, [moment.until]))
    return row


def _answer(why: Why, question: Question, notes: Sequence[str] = ()) -> TraceAnswer:
    scans, row, subject, want = why.recording, why.row, question.what, question.want
    text, chain = (why.rack(), None) if subject is None else why.explain(subject, deep=question.deep)
    lines = tuple(dict.fromkeys([*why.lines, *(_lines(chain, why.load) if chain else ())]))
    remedies = None if subject is None or want is None else why.suggest_inputs(subject, want)
    return TraceAnswer(scans.numbers[row], scans.times[row], text, tuple(notes), lines, chain, remedies)


def _lines(chain: CauseLink, load: Load | None) -> Iterator[Line]:
    """Yield the lines of a Python program that a chain names."""
    from ..why.source.lines import Line

    for step in chain.path if load is not None else ():
        if load is not None and step.site is not None and step.site.file and step.site.line:
            yield Line(str(load.folder / step.site.file), step.site.line, step.site.routine)
