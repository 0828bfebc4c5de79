"""The data of a shared page: a stretch of a trace."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.ladder.debug.causes import Causes
from scanrack.runtime.live.ring import Rows
from scanrack.runtime.machine.spec import INPUT_NAMES

from ..history.catalog import Catalog, Json, PageRoutine
from ..history.stretch import Stretch
from ..monitors.monitor import SPEED_SCANS
from ..monitors.page import Page
from ..monitors.picture import mode_of
from ..monitors.questions import EVENTS_MOST
from ..monitors.trace_monitor import IMPURE, TraceMonitor
from ..monitors.why_questions import why
from .changes import ChangeLists, take_recorded, take_words
from .ladder_walk import LadderWalk, take_ladder

WIDTHS = (56, 88, 120)
"""Widths of drawn rungs, columns."""

MOST_ANSWERS = 20
"""Maximum number of tags whose values the page explains."""

LATEST_ANSWERS = 2
"""Number of these tags that are selected because they changed last."""

MOST_EVENTS = 20_000
"""Maximum number of events in a page; the latest are kept."""


class SharedStretch(NamedTuple):
    """The scans of a shared page."""

    first: int
    last: int
    scan: int  # the scan that the page shows first


def collect(
    monitor: TraceMonitor,
    stretch: SharedStretch,
    tags: Sequence[str] = (),
    latest: int = LATEST_ANSWERS,
    failed: Callable[[ChangeLists], Json] | None = None,
) -> Json:
    """Return the data of a page.

    Args:
        monitor: monitor of the trace, which runs until it has read everything.
        tags: the first tags to explain.
        latest: number of other tags to explain: the ones that changed last before the scan.
        failed: returns the page's data about a failed test; None without one.
    """
    subject, (first, last, scan) = monitor.subject, stretch
    lists, lead, rows, events, programs = gathered(monitor, stretch)
    earlier_events = [event for event in events if event["scan"] < first][-EVENTS_MOST:]
    hello = subject.described(monitor.about, subject.programs.at(scan))
    if failed is not None:
        hello |= {"failure": failed(lists)}
    name = Path(str(monitor.about.path)).name  # without the folders of this machine
    return {
        "range": [first, last],
        "lead": lead,
        "scan": scan,
        "holes": _holes(rows["scan"]),
        "hello": hello | {"branches": False, "incidents": [], "path": name, "record": name, "shared": True},
        "programs": programs,
        "modes": {
            slot: {"in": words.modes.word("in"), "out": words.modes.word("out")}
            for slot, words in subject.words.items()
            if words.modes is not None
        },
        "formats": monitor.states.formats.changes(),
        "steppers": [slot for slot, words in subject.words.items() if is_stepper(words)],
        "machines": list(subject.row_layout.machines),
        "inputs": {name: bit.value for name, bit in INPUT_NAMES.items()},
        "lists": lists.packed(lead),
        "events": earlier_events + [event for event in events if event["scan"] >= first],
        "marks": [mark._asdict() for mark in monitor.marks.all if first <= mark.scan <= last],
        "whys": _answers(monitor, lists, scan, tags, latest),
        "notes": [IMPURE] if any(_is_impure(program) for program in subject.programs.all) else [],
    }


class StretchValues(NamedTuple):
    """The values and programs of a stretch."""

    lists: ChangeLists
    lead: int  # first scan of its words, which begin earlier for the speeds
    rows: Rows  # the rows of the stretch itself
    events: Sequence[Json]  # all events up to its end
    programs: Sequence[Json]


def gathered(monitor: TraceMonitor, stretch: SharedStretch) -> StretchValues:
    """Return the values and programs of a stretch, after the monitor has read everything."""
    subject, lists = monitor.subject, ChangeLists()
    start = subject.timeline.extent[0] if subject.timeline.extent else 0
    if stretch.first == 0:
        monitor.run_once()
    while monitor.tick():
        pass
    lead = max(start, stretch.first - SPEED_SCANS)
    rows = subject.timeline.between(lead, stretch.last)
    take_words(lists, rows, subject.spec.layout)
    _take_times(lists, rows, subject.spec.scan_ns)
    own_rows = rows[np.searchsorted(rows["scan"], stretch.first) :]
    events = monitor.states.up_to(stretch.last, MOST_EVENTS)
    _take_events(lists, monitor, own_rows, events)
    scans = own_rows["scan"].tolist()
    programs = [_program(monitor, lists, program, scans) for program in _shown(monitor, stretch)]
    return StretchValues(lists, lead, own_rows, events, programs)


def _is_impure(program: Stretch) -> bool:
    return program.past is not None and program.past.is_impure


def _shown(monitor: TraceMonitor, stretch: SharedStretch) -> Iterable[Stretch]:
    """Return the programs that ran in the stretch."""
    programs = monitor.subject.programs
    return [
        program
        for program in programs.all
        if program.first <= stretch.last and programs.end_of(program) >= stretch.first
    ]


def _take_times(lists: ChangeLists, rows: Rows, period_ns: int) -> None:
    """Collect the differences between the times of scans and multiples of the period."""
    offsets = rows["now_ns"] - rows["scan"].astype(np.int64) * period_ns
    for scan, offset in zip(rows["scan"].tolist(), offsets.tolist(), strict=True):
        lists.note("offset", scan, offset)


def _take_events(lists: ChangeLists, monitor: TraceMonitor, rows: Rows, events: Sequence[Json]) -> None:
    """Collect the modes, and the states that events change."""
    states, scans = monitor.states, rows["scan"]
    for index in np.flatnonzero(np.diff(rows["flags"], prepend=~rows["flags"][:1])).tolist():
        lists.note("mode", int(scans[index]), mode_of(int(rows["flags"][index])))
    first, last = int(scans[0]), int(scans[-1])
    event_scans = {event["scan"] for event in events}
    changing_scans = {first} | event_scans | {scan + 1 for scan in event_scans}
    changing_scans |= {fault.scan for fault in states.faults_at(last)}
    readers = {
        "forced": states.forces_at,
        "lines": states.lines_at,
        "rules": states.rules_at,
        "pressed": states.pressed_at,
        "faults": monitor.faults,
    }
    for scan in sorted(scan for scan in changing_scans if first <= scan <= last):
        for key, reader in readers.items():
            lists.note(key, scan, reader(scan))


def _drawings(catalog: Catalog, routines: Iterable[Json]) -> tuple[dict[str, Any], list[PageRoutine]]:
    """Return the drawings of routines, by name and width, and the contents of the routines."""
    drawings, contents = {}, []
    for routine in routines:
        widths = WIDTHS if routine["kind"] == "ladder" else WIDTHS[:1]
        shown = {width: catalog.show(routine["name"], width) for width in widths}
        drawings[routine["name"]] = {width: drawing for width, (_, drawing) in shown.items()}
        contents.append(shown[widths[0]][0])
    return drawings, contents


def _program(monitor: TraceMonitor, lists: ChangeLists, program: Stretch, scans: Sequence[int]) -> Json:
    """Return a program with its drawings; collect its power and values."""
    subject, number = monitor.subject, program.number
    described = program.described(subject.values)
    end = subject.programs.end_of(program)
    own_scans = [scan for scan in scans if program.first <= scan <= end]
    panel = monitor.panel.described(subject.bindings(program), "this is a recording")
    drawings, unknown_from = {}, own_scans[-1] + 1  # the first scan whose values are unknown
    if program.catalog is None:
        if program.source is not None:
            _, answer = program.source.show(tuple(subject.values))
            drawings[answer["routine"]] = {WIDTHS[0]: answer}
        take_recorded(lists, number, subject.timeline, subject.values, own_scans)
    else:
        drawings, routines = _drawings(program.catalog, described["routines"])
        names = [tag["name"] for tag in described["tags"]] + [item["read"] for item in panel["bound"]]
        names += [name for routine in routines for name in routine.names]
        replica = program.past
        assert replica is not None
        walk = LadderWalk(lists, number, replica.engine, routines, dict.fromkeys(names))
        unknown_from = take_ladder(replica, walk, range(own_scans[0], own_scans[-1] + 1))
    return {
        "first": program.first,
        "known": unknown_from,
        "described": described,
        "shows": drawings,
        "panel": panel,
    }


def _holes(scans: np.ndarray[Any, Any]) -> list[list[int]]:
    """Return the first and last scan of each gap."""
    gaps = np.flatnonzero(np.diff(scans) != 1).tolist()
    return [[int(scans[gap]) + 1, int(scans[gap + 1]) - 1] for gap in gaps]


def _answers(monitor: TraceMonitor, lists: ChangeLists, scan: int, tags: Sequence[str], latest: int) -> Json:
    """Return why tags have their values in a scan; the key "" contains the cause of the controller fault."""
    program = monitor.subject.programs.at(scan)
    if program.past is None:
        return {}
    change_scans = lists.last_changes(f"tags\n{program.number}", scan)
    changed = sorted(
        (name for name in change_scans if change_scans[name] >= 0), key=lambda name: -change_scans[name]
    )
    page, answers, causes = Page(), {}, Causes(program.past)
    page.program, page.past = program, scan
    for tag in ["", *dict.fromkeys((*tags, *changed[:latest]))][: MOST_ANSWERS + 1]:
        with suppress(ValueError):  # no fault, or the value is not of a tag
            answers[tag] = why(monitor, page, {"tag": tag} if tag else {"fault": True}, causes)
    return {tag: answer for tag, answer in answers.items() if answer}
