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
    """An answer to a question about a trace."""

    scan: int  # number of the scan that the answer is about
    now_ns: int  # virtual time of the scan
    text: str
    notes: tuple[str, ...] = ()  # reasons to doubt the answer
    lines: tuple[Line, ...] = ()  # lines of the program that the answer names
    chain: CauseLink | None = None  # chain of causes; None for a question without a tag
    remedies: Remedies | None = None  # inputs that would set the required value; None without a value


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
        trace: a trace; without its program, only its images explain a value.
        folder: folder into which to unpack the files of the trace.
        trust: whether to run any Python in the trace; if not, only files that are identical to files in the
            current folder run.
        more: scans of a growing trace that have not been written yet.

    Raises:
        ValueError: a file or an option is unusable, or a name is unknown.
        UntrustedError: untrusted Python of the trace would run.
        NotReachedError: the bit of the question does not become true.
    """
    recording = PackedTrace.of(trace, more)
    if not {"rack_file", "program_file"} <= set(trace.head.metadata):
        return _answer_from_images(recording, question)
    job = job_of(trace, folder, trust=trust)
    if isinstance(job.logic, LadderLogic):
        return _answer_from_ladder(recording, job, question, snapshots_of(trace))
    load = _load_of(trace, job, folder, trust=trust)
    return _answer_from_images(recording, question, job.spec, load)


def lines_of_trace(
    trace: Trace,
    folder: Path,
    scans: tuple[int, int],
    more: Columns | None = None,
    latest: Sequence[tuple[int, str]] = (),
) -> ExecutedLines:
    """Return the lines of a trace's Python program that were executed in a range of scans.

    The program runs, so the user must trust it. For `folder`, `more` and errors, see `why_of_trace`.

    Args:
        scans: first and last scan.
        latest: operator actions that may not have been written yet, each with its text and the scan before
            which it takes effect.
    """
    from ..why.program_rerun import executed_lines

    (first, last), recording = scans, PackedTrace.of(trace, more)
    recorded_actions = {(event.scan, event.fields.get("order")) for event in recording.events}
    new_events = [
        TraceEvent(scan, 0, ORDERS.name, {"order": text})
        for scan, text in latest
        if (scan, text) not in recorded_actions
    ]
    recording = replace(recording, events=(*recording.events, *new_events))
    job = job_of(trace, folder, trust=True)
    rows = range(bisect_left(recording.numbers, first), bisect_right(recording.numbers, last))
    if not rows:
        raise ValueError(f"the trace has no scan from {first} to {last}")
    return executed_lines(recording, job.spec, _load_of(trace, job, folder, trust=True), rows)


def _load_of(trace: Trace, job: LoadedRack, folder: Path, *, trust: bool) -> Load:
    """Return a loader for a trace's Python program and its edits."""
    from ..record.order_repeater import orders_of  # slow to import, and ladder programs do not need it
    from ..record.program_versions import versions_of
    from ..why.traced_run import Load

    versions = versions_of(trace, orders_of(trace.events()), job, folder / "edits", trust=trust)
    return Load(
        job.program,
        lambda: job_of(trace, folder, trust=trust).logic,
        lambda number: versions.again(number).logic,
    )


def _answer_from_images(
    recording: PackedTrace, question: Question, spec: RackSpec | None = None, load: Load | None = None
) -> TraceAnswer:
    """Answer from the images, and from a Python program that `load` runs again on them."""
    choice = question.moment
    if choice.until is None:
        row = choice.row(recording)
    else:
        row = _row_of(choice.until, Why(recording, 0, spec, load).first_on(choice.until))
    return _answer(Why(recording, row, spec, load), question)


def _answer_from_ladder(
    recording: PackedTrace, job: LoadedRack, question: Question, snapshots: Mapping[int, str]
) -> TraceAnswer:
    """Answer by running a ladder program on the recorded inputs, up to the scan of the question."""
    assert isinstance(job.logic, LadderLogic)
    debugger = Debugger(job.logic)
    choice = _without_images(question, Why(recording, 0, job.spec, None), debugger)
    last_row = choice.row(recording) if choice.until is None else len(recording.scans) - 1
    rungs_run = run_rungs(recording, job.spec, debugger, last_row, choice.until, snapshots)
    row = rungs_run.row
    if choice.until is not None:
        row = _row_of(choice.until, row if rungs_run.met else None)
    why = Why(recording, row, job.spec, None, debugger)
    notes = [*rungs_run.notes]
    if rungs_run.departs is not None:
        begin = why.past.when(rungs_run.departs)
        notes.append(f"run again on the recorded inputs, the program writes other words from {begin} on")
    return _answer(why, question, notes)


def _without_images(question: Question, images: Why, debugger: Debugger) -> ScanChoice:
    """Return the choice of a scan; replace an image bit with the number of the scan where it turns on.

    Raises:
        ValueError: a tag is unknown; raised before the run.
        NotReachedError: the bit of the question does not become true.
    """
    choice = question.moment
    for tag in (question.what, choice.until):
        if tag is not None and not images.is_address(tag):
            _ = debugger.tags[tag]
    if choice.until is None or not images.is_address(choice.until):
        return choice
    row = _row_of(choice.until, images.first_on(choice.until))
    return ScanChoice(at=str(images.recording.numbers[row]))


def _row_of(bit: str, row: int | None) -> int:
    """Return the row in which a bit turns on; raise NotReachedError for None."""
    if row is None:
        raise NotReachedError(f"{bit} does not come on in the trace", [bit] if bit else [])
    return row


def _answer(why: Why, question: Question, notes: Sequence[str] = ()) -> TraceAnswer:
    """Return the answer for a row of a recording, with the inputs that would produce a requested value."""
    scans, row, tag, value = why.recording, why.row, question.what, question.want
    text, chain = (why.rack(), None) if tag is None else why.explain(tag, deep=question.deep)
    lines = tuple(dict.fromkeys([*why.lines, *(_lines(chain, why.load) if chain else ())]))
    remedies = None if tag is None or value is None else why.suggest_inputs(tag, value)
    return TraceAnswer(
        scan=scans.numbers[row],
        now_ns=scans.times[row],
        text=text,
        notes=tuple(notes),
        lines=lines,
        chain=chain,
        remedies=remedies,
    )


def _lines(chain: CauseLink, load: Load | None) -> Iterator[Line]:
    """Yield the lines of a Python program that a chain names."""
    from ..why.source.lines import Line

    if load is None:
        return
    for step in chain.path:
        if step.site is not None and step.site.file and step.site.line:
            yield Line(str(load.folder / step.site.file), step.site.line, step.site.routine)
