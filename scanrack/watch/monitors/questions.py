"""Answers to a page's questions. A ValueError describes a mistake in a question."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..history.catalog import MOST_HITS, tag_hits
from ..history.event_table import piece_of
from ..history.lanes import MOST_LANES
from . import comparison, drafts, question_process
from .fields import (
    Question,
    addresses_in,
    columns_in,
    name_in_program,
    names_in,
    program_of,
    scans_in,
    step_in,
    strip_in,
    text_in,
)
from .hello import addresses_of
from .marks import Marks
from .monitor import Json, Monitor
from .page import Page
from .panel_questions import PANEL_QUESTIONS
from .since import last_change
from .why_questions import ran, want, why

MOST_WATCHED = 500
"""Maximum number of tags that a page can watch."""

EVENTS_MOST, KINDS_MOST = 200, 30
"""Maximum number of events in an answer, and of kinds in a question."""


def show(monitor: Monitor, page: Page, question: Question) -> Json:
    """Draw a routine; later frames include its power and tags."""
    program = program_of(monitor, page)
    if program.catalog is not None:
        columns, operands = columns_in(question), question.get("operands") is True
        page_routine, answer = program.catalog.show(text_in(question, "routine"), columns, operands=operands)
        if monitor.about.kind == "rack":
            answer["base"] = program.digest
    elif program.source is not None:
        page_routine, answer = program.source.show(tuple(monitor.subject.values))
    else:
        raise ValueError("the trace does not contain the program of this scan")
    page.show(page_routine)
    return answer


def watch(monitor: Monitor, page: Page, question: Question) -> Json:
    """Include tags in later frames, in addition to the tags of the routine."""
    tags = names_in(question, MOST_WATCHED)
    unknown = [name for name in tags if not _is_known(monitor, page, name)]
    page.watch(tuple(name for name in tags if name not in unknown))
    addresses = addresses_in(monitor, page, tags)
    return {"unknown": [name for name in unknown if name not in addresses], "addresses": addresses}


def lanes(monitor: Monitor, page: Page, question: Question) -> Json:
    """Include the points of tags for the timing strip in later frames."""
    names, unknown = _lanes_in(monitor, page, question)
    page.lanes, page.lanes_scan = names, None
    return {"unknown": unknown}


def steps(monitor: Monitor, page: Page, question: Question) -> Json:
    """Return the points of tags in past scans; `next` is the first scan of the next piece."""
    first, last = scans_in(question)
    names, _unknown = _lanes_in(monitor, page, question)
    extent = monitor.subject.timeline.extent
    if extent is None or not names:
        return {"lanes": {}, "next": None}
    first, last = max(first, extent[0]), min(last, extent[1])
    piece, following = monitor.subject.lanes(names, first, last) if first <= last else ({}, None)
    return {"lanes": piece, "next": following}


def _lanes_in(monitor: Monitor, page: Page, question: Question) -> tuple[tuple[str, ...], list[str]]:
    """Return the known and the unknown tags in a question."""
    tags, program = names_in(question, MOST_LANES), program_of(monitor, page)
    unknown = [name for name in tags if not _is_known(monitor, page, name) and program.address(name) is None]
    return tuple(dict.fromkeys(name for name in tags if name not in unknown)), unknown


def _is_known(monitor: Monitor, page: Page, name: str) -> bool:
    catalog = program_of(monitor, page).catalog
    return name in monitor.subject.values if catalog is None else catalog.has(name)


def look(monitor: Monitor, page: Page, question: Question) -> Json:
    """Make this page show a past scan, or the latest scan again."""
    scan = question.get("scan")
    if scan == "live":
        if monitor.about.kind == "trace":
            raise ValueError("this is a trace; nothing is running")
        page.past = None
        page.last = {}  # but not `start_over`, since the strip continues
        monitor.exchange_program(page)
        return {"scan": "live"}
    if type(scan) is not int:
        raise ValueError('scan must be a scan number, or "live"')
    if monitor.subject.timeline.row(scan) is None:
        extent = monitor.subject.timeline.extent
        available = "none" if extent is None else f"{extent[0]} to {extent[1]}"
        raise ValueError(f"no scan {scan}; available are {available}")
    page.past = scan
    monitor.exchange_program(page)
    return {"scan": scan}


def stop(_monitor: Monitor, page: Page, question: Question) -> Json:
    """Make the page stop at the scan in which a module's error bit comes on, or only report the bit."""
    choice = question.get("at_errors")
    if choice not in ("stop", "off"):
        raise ValueError("at_errors must be stop or off")
    page.stops = choice == "stop"
    return {}


def window(monitor: Monitor, _page: Page, question: Question) -> Json:
    """Return the strip of past scans, as far as available."""
    piece = strip_in(monitor, question)
    signals = question.get("signals")
    if piece and isinstance(signals, list):
        piece["bits"] = {name: points for name, points in piece["bits"].items() if name in signals}
    return {"strip": piece}


def events(monitor: Monitor, _page: Page, question: Question) -> Json:
    """Return a piece of the events up to a scan, the total number, and whether all events are known."""
    scan, hidden = question.get("to"), question.get("hide", [])
    skip, most = question.get("skip", 0), question.get("most", EVENTS_MOST)
    if type(scan) is not int:
        raise ValueError("to must be a scan number")
    if type(skip) is not int or skip < 0 or type(most) is not int or not 0 < most <= EVENTS_MOST:
        raise ValueError(f"skip must be 0 or more, and most 1 to {EVENTS_MOST}")
    is_short_list = isinstance(hidden, list) and len(hidden) <= KINDS_MOST
    if not is_short_list or not all(isinstance(kind, str) for kind in hidden):
        raise ValueError(f"hide must be a list of up to {KINDS_MOST} kinds of events")
    rows, total = piece_of(monitor.event_table(scan), scan, hidden, skip, most)
    return {"events": rows, "total": total, "whole": not monitor.states.missing()}


def marks(monitor: Monitor, page: Page, _question: Question) -> Json:
    """Return the marks on the axis of a trace, and the failure nearest to the page's scan."""
    trace_marks, row = _marks_of(monitor), monitor.row_of(page)
    is_complete, failure = trace_marks.is_complete, None
    if is_complete:
        failure = trace_marks.failure(0 if row is None else int(row["scan"]))
    totals = {"total": len(trace_marks.all), "whole": is_complete}
    return {"marks": trace_marks.on_axis(), **totals, "failure": failure and failure._asdict()}


def mark(monitor: Monitor, _page: Page, question: Question) -> Json:
    """Return the next mark after a scan, or the previous one."""
    trace_marks = _marks_of(monitor)
    nearest = trace_marks.find(*step_in(question))
    return {"mark": nearest and nearest._asdict(), "whole": trace_marks.is_complete}


def _marks_of(monitor: Monitor) -> Marks:
    if monitor.marks is None:
        raise ValueError("only a trace has marks; this rack is running")
    return monitor.marks


def since(monitor: Monitor, page: Page, question: Question) -> Json:
    """Return when a tag got the value that it has in the page's scan, and its previous value.

    Each question searches one stretch of scans. `from` is the scan from which the next question continues
    backwards; null if the first scan was reached.
    """
    tag, row, end = text_in(question, "tag"), monitor.row_of(page), question.get("from")
    if end is not None and type(end) is not int:
        raise ValueError("from must be a scan number")
    if row is None:
        return {"since": None, "from": None}
    change, unsearched = last_change(monitor, tag, int(row["scan"]) if end is None else end)
    if change is None:
        extent = monitor.subject.timeline.extent
        first = extent[0] if extent else 0
        return {"since": None, "from": unsearched if unsearched > first else None}
    change_row = monitor.subject.timeline.row(change.scan)
    now_ns = None if change_row is None else int(change_row["now_ns"])
    return {"since": {"scan": change.scan, "t": now_ns, "before": change.before}, "from": unsearched}


def share(monitor: Monitor, page: Page, question: Question) -> None:
    """Create a page of the trace that any browser can open and that shows this page's scan first."""
    trace, row = monitor.subject.timeline.path, monitor.row_of(page)
    if trace is None or row is None:
        raise ValueError("no trace yet; start with --record")
    is_trusted = monitor.subject.programs.at(page.past).logic is not None
    rack = "" if monitor.about.kind == "trace" else monitor.about.path
    share_question = question_process.share(str(trace), int(row["scan"]), trust=is_trusted, rack=rack)
    monitor.processes.start(page, question.get("id"), share_question)


def xref(monitor: Monitor, page: Page, question: Question) -> Json:
    """List the rungs that read or write a tag."""
    tag, catalog = name_in_program(monitor, page, text_in(question, "tag")), program_of(monitor, page).catalog
    if catalog is None:
        raise ValueError(f"{tag}: the program is in Python and has no rungs")
    return {"hits": catalog.mentions(tag)}


def find(monitor: Monitor, page: Page, question: Question) -> Json:
    """List the tags, image words and bits, and rungs or lines that contain a text."""
    text, program = text_in(question, "text"), program_of(monitor, page)
    hits = program.find(text, monitor.subject.values)
    hits += tag_hits(addresses_of(monitor.subject.spec), text)
    hits.sort(key=lambda hit: hit["tag"] is None or hit["tag"].casefold() != text.casefold())
    return {"hits": hits[:MOST_HITS]}  # a tag with exactly this name first


QUESTIONS: Mapping[str, Callable[[Monitor, Page, Question], Json | None]] = {
    "here": lambda _monitor, _page, _question: {},
    "show": show,
    "watch": watch,
    "lanes": lanes,
    "steps": steps,
    "look": look,
    "stop": stop,
    "window": window,
    "events": events,
    "marks": marks,
    "mark": mark,
    "why": why,
    "ran": ran,
    "since": since,
    "want": want,
    "xref": xref,
    "find": find,
    "share": share,
    "recordings": comparison.recordings,
    "compare": comparison.compare,
    "difference": comparison.difference,
    "beside": comparison.beside,
    **PANEL_QUESTIONS,
    "words": drafts.words,
    "rungs": drafts.rungs,
    "rebase": drafts.rebase,
    "would": drafts.would,
}
"""The questions by name. A question that returns None is answered later."""


def handle_message(monitor: Monitor, page: Page, message: object) -> None:
    """Carry out a page's action or answer its question; if there is a mistake, the answer describes it."""
    number = message.get("id") if isinstance(message, Mapping) else None
    if not isinstance(number, int | str) or isinstance(number, bool):
        number = None
    try:
        if not isinstance(message, Mapping):
            raise ValueError("a message must be an object with the keys id and do")
        name = message.get("do")
        if not isinstance(name, str):
            raise ValueError(f"do must be the name of an action or a question, not {str(name)[:60]}")
        answer_question = QUESTIONS.get(name)
        if answer_question is None:
            monitor.act(page, number, message)
        elif (answer := answer_question(monitor, page, message)) is not None:
            page.send({"answer": {"id": number, "ok": True, **answer}})
    except ValueError as error:
        page.send({"answer": {"id": number, "refused": str(error)}})
