"""The questions of a page and their answers; a ValueError has the mistake in a question."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...ladder.debug import told
from ...ladder.debug.inquiry import Inquiry
from ...traces.format.records import TraceError
from ..history.catalog import COLUMNS, MOST_HITS, tag_hits
from ..history.lanes import MOST_LANES
from ..history.stretch import Stretch
from ..history.strip import piece_of
from ..history.timeline import columns_of
from . import drafts
from .chain_answer import chain_of, chain_of_fault, links_of
from .comparison import Comparison, recordings_beside
from .hello import addresses_of
from .monitor import Monitor
from .page import Page
from .panel_questions import PANEL_QUESTIONS
from .since import last_change

Json = dict[str, Any]
Said = Mapping[str, Any]

MOST_WATCHED = 500
"""Most tags that a page may watch."""

UNWRITTEN_MOST = 16_384
"""Number of latest scans sent with a question, since the recording may lack them."""

ENVELOPE_STEPS = 500
"""Points of a position in a past window."""

EVENTS_MOST = 100

WINDOW_MOST = 50_000


def show(monitor: Monitor, page: Page, said: Said) -> Json:
    """Draw a routine; from now on frames have its power and tags."""
    program = _program(monitor, page)
    if program.catalog is not None:
        columns = said.get("columns", 88)
        if type(columns) is not int or columns not in COLUMNS:
            raise ValueError(f"columns {columns!r}: must be {COLUMNS[0]} to {COLUMNS[-1]}")
        operands = said.get("operands") is True
        shown, answer = program.catalog.show(_text(said, "routine"), columns, operands=operands)
        if monitor.about.kind == "rack":
            answer["base"] = program.digest
    elif program.source is not None:
        shown, answer = program.source.show(tuple(monitor.subject.values))
    else:
        raise ValueError("the recording does not bring the program of this scan")
    page.show(shown)
    return answer


def watch(monitor: Monitor, page: Page, said: Said) -> Json:
    """Add further tags to frames from now on."""
    tags = said.get("tags")
    if not isinstance(tags, list) or len(tags) > MOST_WATCHED or not all(map(_is_name, tags)):
        raise ValueError(f"tags must be a list of up to {MOST_WATCHED} names")
    unknown = [name for name in tags if not _is_known(monitor, page, name)]
    page.watch(tuple(name for name in tags if name not in unknown))
    addresses = _addresses(monitor, page, tags)
    return {"unknown": [name for name in unknown if name not in addresses], "addresses": addresses}


def _addresses(monitor: Monitor, page: Page, tags: Sequence[str]) -> dict[str, str]:
    """Return the addresses of those tags that mean a word or bit of an image."""
    program = _program(monitor, page)
    places = {tag: program.address(tag) for tag in tags}
    faults = {} if program.catalog is None else program.catalog.addresses(tags)
    return faults | {tag: str(place) for tag, place in places.items() if place is not None}


def lanes(monitor: Monitor, page: Page, said: Said) -> Json:
    """Add the points of tags for the timing strip from now on."""
    names, unknown = _lanes_in(monitor, page, said)
    page.lanes, page.lanes_at = names, None
    return {"unknown": unknown}


def steps(monitor: Monitor, page: Page, said: Said) -> Json:
    """Return the points of tags in past scans; `next` is the scan of the next piece."""
    first, last = _scans_in(said)
    names, _unknown = _lanes_in(monitor, page, said)
    extent = monitor.subject.timeline.extent
    if extent is None or not names:
        return {"lanes": {}, "next": None}
    first, last = max(first, extent[0]), min(last, extent[1])
    piece, following = monitor.subject.lanes(names, first, last) if first <= last else ({}, None)
    return {"lanes": piece, "next": following}


def _lanes_in(monitor: Monitor, page: Page, said: Said) -> tuple[tuple[str, ...], list[str]]:
    """Return the tags in a question, and the unknown ones."""
    tags = said.get("tags")
    if not isinstance(tags, list) or len(tags) > MOST_LANES or not all(map(_is_name, tags)):
        raise ValueError(f"tags must be a list of up to {MOST_LANES} names")
    unknown = [name for name in tags if not _is_known(monitor, page, name)]
    unknown = [name for name in unknown if _program(monitor, page).address(name) is None]
    return tuple(dict.fromkeys(name for name in tags if name not in unknown)), unknown


def _is_known(monitor: Monitor, page: Page, name: str) -> bool:
    catalog = _program(monitor, page).catalog
    return name in monitor.subject.values if catalog is None else catalog.has(name)


def look(monitor: Monitor, page: Page, said: Said) -> Json:
    """Show a past scan to this page, or the latest again."""
    scan = said.get("scan")
    if scan == "live":
        if monitor.about.kind == "trace":
            raise ValueError("this is a trace; nothing is running")
        page.past = None
        page.last = {}  # its strip continues
        monitor.exchange_program(page)
        return {"scan": "live"}
    if type(scan) is not int:
        raise ValueError('scan is the number of a scan, or "live"')
    if monitor.subject.timeline.row(scan) is None:
        extent = monitor.subject.timeline.extent
        there = "none" if extent is None else f"{extent[0]} to {extent[1]}"
        raise ValueError(f"scan {scan} is not there: there are {there}")
    page.past = scan
    monitor.exchange_program(page)
    return {"scan": scan}


def stop(_monitor: Monitor, page: Page, said: Said) -> Json:
    """Stay at the scan of each error bit of a module from now on, or only name it."""
    wanted = said.get("at_errors")
    if wanted not in ("stop", "off"):
        raise ValueError("at_errors is stop or off")
    page.stops = wanted == "stop"
    return {}


def window(monitor: Monitor, _page: Page, said: Said) -> Json:
    """Return the strip of past scans, as far as available."""
    first, last = _scans_in(said)
    subject = monitor.subject
    rows = subject.timeline.between(first, last)
    piece = piece_of(rows, rows[:0], subject.signals, subject.spec.scan_ns, ENVELOPE_STEPS)
    wanted = said.get("signals")
    if piece and isinstance(wanted, list):
        piece["bits"] = {name: each for name, each in piece["bits"].items() if name in wanted}
    return {"strip": piece}


def _scans_in(said: Said) -> tuple[int, int]:
    first, last = said.get("from"), said.get("to")
    if type(first) is not int or type(last) is not int or not 0 <= first <= last < first + WINDOW_MOST:
        raise ValueError(f"from and to must be scan numbers, at most {WINDOW_MOST:,} scans apart")
    return first, last


def events(monitor: Monitor, _page: Page, said: Said) -> Json:
    """Return the latest events up to a scan."""
    scan = said.get("to")
    if type(scan) is not int:
        raise ValueError("to must be a scan number")
    return {"events": monitor.states.up_to(scan, EVENTS_MOST)}


def why(monitor: Monitor, page: Page, said: Said) -> Json | None:
    """Explain a tag's value in a scan, that of the page if none is given; with `fault` the CPU's fault."""
    if said.get("fault") is True:
        return _why_fault(monitor, page, said)
    tag, asked = _own_name(monitor, page, _text(said, "tag")), said.get("scan")
    if asked is not None and type(asked) is not int:
        raise ValueError("scan must be a scan number")
    past = page.past if asked is None else asked
    row = monitor.row_of(page) if asked is None or asked == page.past else monitor.subject.timeline.row(asked)
    if row is None:
        raise ValueError(f"{tag}: no scan has run yet" if past is None else f"scan {past} is not there")
    program = monitor.subject.programs.at(past)
    scan, replica = int(row["scan"]), program.past
    if replica is None or program.catalog is None:
        _ask_python(monitor, page, said, tag, scan)
        return None
    if not replica.show(scan):
        raise ValueError(f"scan {scan} can't be repeated yet: ask again in a moment")
    forced = monitor.states.forces_at(past)
    try:
        found = None if replica.is_impure else chain_of(monitor, replica, tag, scan)
        if found is None:
            text = Inquiry(replica.engine, replica, scan, forced, program.catalog.cross_reference).why(tag)
        else:
            text = told(found)
    finally:
        replica.show(scan)
    return {"text": text, "scan": scan, "chain": links_of(found) if found is not None else []}


def since(monitor: Monitor, page: Page, said: Said) -> Json:
    """Say since when a tag has its value in the scan of the page, and what it was before."""
    tag, row = _text(said, "tag"), monitor.row_of(page)
    found = None if row is None else last_change(monitor, tag, int(row["scan"]))
    if found is None:
        return {"since": None}
    changed = monitor.subject.timeline.row(found.scan)
    now_ns = None if changed is None else int(changed["now_ns"])
    return {"since": {"scan": found.scan, "t": now_ns, "before": found.before}}


def _why_fault(monitor: Monitor, page: Page, said: Said) -> Json | None:
    """Explain the CPU's fault by what its rung or line has read."""
    faults, program = monitor.states.faults_at(page.past), monitor.subject.programs.at(page.past)
    if not faults:
        raise ValueError("the CPU has not faulted up to this scan")
    fault, replica = faults[0], program.past
    tags = program.tags_of_fault(fault, monitor.subject.values)
    if not tags:
        raise ValueError("nothing that the program has read is known of this fault")
    if replica is None:
        _ask_python(monitor, page, said, tags[0], fault.scan)
        return None
    if not replica.show(fault.scan):
        raise ValueError(f"scan {fault.scan} can't be repeated yet: ask again in a moment")
    chain = [] if replica.is_impure else chain_of_fault(monitor, replica, fault, tags)
    replica.show(fault.scan)
    return {"text": str(fault), "scan": fault.scan, "chain": chain}


def _ask_python(monitor: Monitor, page: Page, said: Said, tag: str, scan: int) -> None:
    """Let a process answer: a program in Python must run again from its first scan on."""
    trace, program = monitor.subject.timeline.path, monitor.subject.programs.at(scan)
    if program.logic is None or trace is None:
        raise ValueError(f"{tag}: the program may not run here: see --trust")
    if program.number:
        raise ValueError(f"{tag}: the program was edited before scan {program.first}: why answers before it")
    rows = monitor.subject.timeline.between(max(0, scan - UNWRITTEN_MOST), scan)
    monitor.elsewhere.why(page, said.get("id"), str(trace), tag, columns_of(rows))


def want(monitor: Monitor, page: Page, said: Said) -> None:
    """Say what an owner could do after the scan of the page so that a tag has a value."""
    tag, wanted = _own_name(monitor, page, _text(said, "tag")), said.get("value")
    if not isinstance(wanted, bool | int | float):
        raise ValueError("value is true, false or a number")
    trace, row = monitor.subject.timeline.path, monitor.row_of(page)
    if trace is None or row is None:
        raise ValueError(f"{tag}: no scan has run yet")
    scan = int(row["scan"])
    if monitor.subject.programs.at(page.past).logic is None:
        raise ValueError(f"{tag}: the program may not run here: see --trust")
    monitor.elsewhere.want(page, said.get("id"), str(trace), (tag, wanted, scan), monitor.orders_to(scan))


def share(monitor: Monitor, page: Page, said: Said) -> None:
    """Make a page of the recording that any browser opens, with the scan of the page shown first."""
    trace, row = monitor.subject.timeline.path, monitor.row_of(page)
    if trace is None or row is None:
        raise ValueError("no trace yet; start with --record")
    trusted = monitor.subject.programs.at(page.past).logic is not None
    rack = "" if monitor.about.kind == "trace" else monitor.about.path
    monitor.elsewhere.share(page, said.get("id"), str(trace), int(row["scan"]), trust=trusted, rack=rack)


def recordings(monitor: Monitor, _page: Page, _said: Said) -> Json:
    """List the recordings that a page may compare with."""
    return {"recordings": recordings_beside(_record_of(monitor))}


def compare(monitor: Monitor, page: Page, said: Said) -> Json:
    """Compare with another recording of the same folder from now on, or with none."""
    name, record = said.get("with"), _record_of(monitor)
    if name is None:
        page.compare(None)
        return {"with": None}
    if monitor.opener is None or name not in recordings_beside(record):
        raise ValueError(f"no recording {str(name)[:60]!r} beside this one")
    try:
        page.compare(Comparison(monitor, str(name), monitor.opener(record.parent / str(name))))
    except (OSError, TraceError) as error:
        raise ValueError(f"{name} can't be read: {error}") from error
    return {"with": name}


def difference(_monitor: Monitor, page: Page, said: Said) -> Json:
    """Return the next scan, or the one before, in which other words differ than in the scan before it."""
    scan, way = said.get("from"), said.get("way")
    if type(scan) is not int or way not in (1, -1):
        raise ValueError("from is the number of a scan, and way 1 or -1")
    found, searched = _comparison(page).next_difference(scan, way)
    return {"scan": found, "searched": searched}


def beside(_monitor: Monitor, page: Page, said: Said) -> Json:
    """Return the strip of past scans of the recording that is compared with, as far as available."""
    first, last = _scans_in(said)
    compared = _comparison(page)
    rows, subject = compared.window(first, last), compared.other.subject
    return {"strip": piece_of(rows, rows[:0], subject.signals, subject.spec.scan_ns, ENVELOPE_STEPS)}


def _comparison(page: Page) -> Comparison:
    if not isinstance(page.compared, Comparison):
        raise ValueError("this page compares with no recording")
    return page.compared


def _record_of(monitor: Monitor) -> Path:
    return Path(monitor.about.record or monitor.about.path)


def xref(monitor: Monitor, page: Page, said: Said) -> Json:
    """List where a tag is read and written."""
    tag, catalog = _own_name(monitor, page, _text(said, "tag")), _program(monitor, page).catalog
    if catalog is None:
        raise ValueError(f"{tag}: the program is in Python: it has no rungs")
    return {"hits": catalog.mentions(tag)}


def find(monitor: Monitor, page: Page, said: Said) -> Json:
    """List the tags, the words and bits of images, and the rungs that contain a text."""
    text, program = _text(said, "text"), _program(monitor, page)
    hits = tag_hits(program.alias_tags(), text) if program.catalog is None else program.catalog.find(text)
    hits += tag_hits(addresses_of(monitor.subject.spec), text)
    ranked = sorted(hits, key=lambda hit: _is_called(hit, text), reverse=True)
    return {"hits": ranked[:MOST_HITS]}


def _is_called(hit: Json, text: str) -> bool:
    return hit["tag"] is not None and hit["tag"].casefold() == text.casefold()


def _own_name(monitor: Monitor, page: Page, tag: str) -> str:
    """Return a tag as a ladder program can name it: in place of `slot1.status.IN_HOME` the address."""
    catalog = _program(monitor, page).catalog
    if catalog is None or catalog.has(tag):
        return tag
    return _addresses(monitor, page, [tag]).get(tag, tag)


def _program(monitor: Monitor, page: Page) -> Stretch:
    """Return the program that a page has received."""
    return page.program or monitor.subject.programs.latest


def _text(said: Said, key: str) -> str:
    value = said.get(key)
    if not _is_name(value):
        raise ValueError(f"{key} is text of 1 to 400 characters")
    return str(value)


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 400


QUESTIONS: Mapping[str, Callable[[Monitor, Page, Said], Json | None]] = {
    "here": lambda _monitor, _page, _said: {},
    "show": show,
    "watch": watch,
    "lanes": lanes,
    "steps": steps,
    "look": look,
    "stop": stop,
    "window": window,
    "events": events,
    "why": why,
    "since": since,
    "want": want,
    "xref": xref,
    "find": find,
    "share": share,
    "recordings": recordings,
    "compare": compare,
    "difference": difference,
    "beside": beside,
    **PANEL_QUESTIONS,
    "words": drafts.words,
    "rungs": drafts.rungs,
    "rebase": drafts.rebase,
    "would": drafts.would,
}
"""The questions by name; one that returns None is answered later."""


def ask(monitor: Monitor, page: Page, said: object) -> None:
    """Process an order or a question of a page; the answer goes to the page.

    No message raises: the answer has its mistake.
    """
    number = said.get("id") if isinstance(said, Mapping) else None
    if not isinstance(number, int | str) or isinstance(number, bool):
        number = None
    try:
        if not isinstance(said, Mapping):
            raise ValueError("a message is an object with the keys id and do")
        name = said.get("do")
        if not isinstance(name, str):
            raise ValueError(f"do is the name of an order or a question, not {str(name)[:60]}")
        question = QUESTIONS.get(name)
        if question is None:
            monitor.order(page, number, said)
        elif (answer := question(monitor, page, said)) is not None:
            page.send({"answer": {"id": number, "ok": True, **answer}})
    except ValueError as error:
        page.send({"answer": {"id": number, "refused": str(error)}})
