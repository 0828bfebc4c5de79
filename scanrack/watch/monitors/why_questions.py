"""Answers to questions about causes: why a tag has its value, and which actions lead to another value."""

from __future__ import annotations

from scanrack.ladder.debug import answer_text
from scanrack.ladder.debug.causes import Causes
from scanrack.ladder.debug.inquiry import Inquiry
from scanrack.runtime.live.ring import Row

from ..history.timeline import columns_of
from . import question_process
from .fields import Question, name_in_program, text_in
from .monitor import BACK, Json, Monitor
from .page import Page

LINES_AROUND = 500
"""Number of additional scans before and after a scan in an answer about executed lines."""


def why(monitor: Monitor, page: Page, question: Question, causes: Causes | None = None) -> Json | None:
    """Explain a tag's value in a scan, by default the page's scan; with `fault`, explain the major fault.

    Args:
        causes: the program's causes, with a cache of repeated scans; None = create them.
    """
    if question.get("fault") is True:
        return _why_fault(monitor, page, question, causes)
    tag = name_in_program(monitor, page, text_in(question, "tag"))
    past, row = _row_in(monitor, page, question.get("scan"), tag)
    program = monitor.subject.programs.at(past)
    scan, replica = int(row["scan"]), program.past
    if replica is None or program.catalog is None:
        _ask_python(monitor, page, question, tag, scan)
        return None
    if not replica.show(scan):
        raise ValueError(f"scan {scan} can't be repeated yet; try again in a moment")
    from .chain_answer import chain_of, links_of  # imported late, to show the first page earlier

    try:
        chain = None if replica.is_impure else chain_of(monitor, causes or Causes(replica), tag, scan)
        if chain is not None:
            return {"text": answer_text(chain), "scan": scan, "chain": links_of(chain)}
        forced, uses = monitor.states.forces_at(past), program.catalog.cross_reference
        text = Inquiry(replica.engine, replica, scan, forced, uses).why(tag)
        return {"text": text, "scan": scan, "chain": []}
    finally:
        replica.show(scan)


def _row_in(monitor: Monitor, page: Page, scan: object, tag: str) -> tuple[int | None, Row]:
    """Return a question's past scan, or None for the latest, and its row; the default is the page's scan."""
    if scan is not None and type(scan) is not int:
        raise ValueError("scan must be a scan number")
    past = page.past if scan is None else scan
    row = monitor.row_of(page) if past is None or past == page.past else monitor.subject.timeline.row(past)
    if row is None:
        raise ValueError(f"{tag}: no scan has run yet" if past is None else f"no scan {past}")
    return past, row


def _why_fault(monitor: Monitor, page: Page, question: Question, causes: Causes | None) -> Json | None:
    """Explain the controller fault by the values that the faulted rung or line read."""
    faults, program = monitor.states.faults_at(page.past), monitor.subject.programs.at(page.past)
    if not faults:
        raise ValueError("the CPU has not faulted up to this scan")
    fault, replica = faults[0], program.past
    tags = program.tags_of_fault(fault, monitor.subject.values)
    if not tags:
        raise ValueError("no tags are known that the faulted rung or line reads")
    if replica is None:
        _ask_python(monitor, page, question, tags[0], fault.scan)
        return None
    if not replica.show(fault.scan):
        raise ValueError(f"scan {fault.scan} can't be repeated yet; try again in a moment")
    from .chain_answer import chain_of_fault  # as above

    chain = [] if replica.is_impure else chain_of_fault(monitor, causes or Causes(replica), fault, tags)
    replica.show(fault.scan)
    return {"text": str(fault), "scan": fault.scan, "chain": chain}


def _ask_python(monitor: Monitor, page: Page, question: Question, tag: str, scan: int) -> None:
    """Start a process to find the answer, since a Python program must be rerun from its first scan."""
    trace, program = monitor.subject.timeline.path, monitor.subject.programs.at(scan)
    if program.logic is None or trace is None:
        raise ValueError(f"{tag}: running the program needs --trust")
    if program.number:
        raise ValueError(
            f"{tag}: the program was edited before scan {program.first}; ask about an earlier scan"
        )
    rows = monitor.subject.timeline.between(max(0, scan - BACK), scan)
    monitor.processes.start(page, question.get("id"), question_process.why(str(trace), tag, columns_of(rows)))


def ran(monitor: Monitor, page: Page, question: Question) -> None:
    """Start a process that finds the Python lines that were executed in scans around the page's scan."""
    trace, row = monitor.subject.timeline.path, monitor.row_of(page)
    program, extent = monitor.subject.programs.at(page.past), monitor.subject.timeline.extent
    if trace is None or row is None or extent is None:
        raise ValueError("no scan has run yet")
    if program.logic is None or program.source is None:
        raise ValueError("running the program needs --trust")
    if program.number:
        raise ValueError(f"the program was edited before scan {program.first:,}")
    scan = int(row["scan"])
    first = max(extent[0], scan - LINES_AROUND)
    last = min(scan + LINES_AROUND, extent[1], monitor.subject.programs.end_of(program))
    rows = monitor.subject.timeline.between(max(0, scan - BACK), last)
    actions = monitor.latest_actions(last)
    lines_question = question_process.lines(str(trace), (first, last), columns_of(rows), actions)
    monitor.processes.start(page, question.get("id"), lines_question)


def want(monitor: Monitor, page: Page, question: Question) -> None:
    """Start a process that finds actions after the page's scan that lead to a value of a tag."""
    tag, target_value = name_in_program(monitor, page, text_in(question, "tag")), question.get("value")
    if not isinstance(target_value, bool | int | float):
        raise ValueError("value must be true, false or a number")
    trace, row = monitor.subject.timeline.path, monitor.row_of(page)
    if trace is None or row is None:
        raise ValueError(f"{tag}: no scan has run yet")
    scan = int(row["scan"])
    if monitor.subject.programs.at(page.past).logic is None:
        raise ValueError(f"{tag}: running the program needs --trust")
    actions = monitor.latest_actions(scan)
    monitor.processes.start(
        page, question.get("id"), question_process.want(str(trace), tag, target_value, scan, actions)
    )
