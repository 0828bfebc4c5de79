"""Compares a page's recording with another one: shows the same scan of both, and the differences.

    page       scan 480   words  power  tags          of the session or recording that is watched
    other      scan 480   words  power  tags          of a recording in the same folder
    frame      other: { there, known, words, power, tags }    the other's values where they differ

Scans with equal numbers are compared. A branch is also a recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.memory_layout import ImagePlaces
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.format.records import TraceError
from scanrack.traces.read.reader import open_trace

from ..history.catalog import NOTHING_SHOWN
from .fields import Question, step_in, strip_in
from .monitor import Json, Monitor
from .page import Page

MOST_LISTED = 100
"""Largest number of recordings that a page is offered; the newest are kept."""

PIECE, MOST_SEARCHED = 4096, 65_536
"""Number of scans compared at once, and the most for one question."""


class OpenedBeside(NamedTuple):
    """Another recording: its monitor, and a function that closes its files."""

    monitor: Monitor
    close: Callable[[], None]


def recordings_beside(record: Path) -> list[str]:
    """Return the names of the other recordings in the folder of a recording or rack file."""
    rows = []
    for file in record.parent.glob("*.mcap"):
        with suppress(OSError):  # the file is gone, or belongs to someone else
            if file.is_file() and file.resolve() != record.resolve():
                rows.append((file.stat().st_mtime_ns, file.name))
    return [name for _, name in sorted(rows, reverse=True)[:MOST_LISTED]]


def described(path: Path, rack: RackSpec, own: Path, parent: str | None) -> Json | None:
    """Return an entry for a page's list of recordings; None if it is of another rack or can't be read.

    Args:
        rack: rack of the page.
        own: recording of the page.
        parent: name of the recording from which it branches.
    """
    try:
        with open_trace(path) as trace:
            metadata, slots = trace.head.metadata, [(slot.number, slot.module) for slot in trace.head.slots]
        changed_s = path.stat().st_mtime
    except (OSError, TraceError):
        return None
    if metadata.get("name") != rack.name or slots != sorted((slot.number, slot.module) for slot in rack.slot):
        return None
    branches = metadata.get("parent") == own.name
    return {
        "name": path.name,
        "date": datetime.fromtimestamp(changed_s).astimezone().isoformat(timespec="seconds"),
        "relation": "parent" if path.name == parent else "branch" if branches else "",
        "scan": int(metadata.get("parent_scan", 0)) if branches else None,
    }


class Comparison:
    """A comparison that a page shows.

    Attributes:
        name: name of the other recording.
        other: monitor of the other recording.

    Args:
        own: the monitor of the page.
    """

    def __init__(self, own: Monitor, name: str, opened: OpenedBeside) -> None:
        self.name, self._own, (self.other, self._close) = name, own, opened
        self._page, self._routine = Page(), ""

    def close(self) -> None:
        """Close the other recording."""
        self._close()

    def tick(self) -> bool:
        """Run more scans of the other program; return whether more remain."""
        return self.other.tick()

    def differences(self, page: Page, picture: Json) -> Json:
        """Return the other recording's values in the scan of a picture, where they differ."""
        scan = int(picture["scan"])
        if self.other.subject.timeline.row(scan) is None:
            return {"there": False, "words": {}, "power": {}, "tags": {}}
        self._follow(page, scan)
        recorded_picture = self.other.whole(self._page)
        return {
            "there": True,
            "known": recorded_picture.get("known", True) and picture.get("known", True),
            **{
                part: _differing(picture.get(part, {}), recorded_picture.get(part, {}))
                for part in ("power", "tags")
            },
            "words": {
                slot: differing
                for slot, words in picture["words"].items()
                if (differing := _words(words, recorded_picture["words"].get(slot)))
            },
        }

    def _follow(self, page: Page, scan: int) -> None:
        """Make the other recording show the same scan, routine and tags."""
        own_page, program = self._page, self.other.subject.programs.at(scan)
        own_page.past = scan
        if own_page.program is not program or self._routine != page.shown.name:
            own_page.program, self._routine = program, page.shown.name
            routine = NOTHING_SHOWN
            if program.catalog is not None and self._routine:
                with suppress(ValueError):  # the other program has no such routine
                    routine, _ = program.catalog.show(self._routine, COLUMNS)
            own_page.show(routine)
        own_page.watch(page.watched)

    def next_difference(self, scan: int, way: int) -> tuple[int | None, int]:
        """Return the next scan in which the set of differing words changes, and the last searched scan.

        Args:
            scan: scan from which to search, not included.
            way: 1 forwards, -1 backwards.
        """
        searched, low = scan, self._common()[0]
        for first, last in self._pieces(scan, way):
            scans, differs = self._differing_words(first - 1, last)
            if len(scans) and scans[0] == low:  # before the first scan nothing differs
                scans, differs = np.insert(scans, 0, low - 1), np.insert(differs, 0, False, axis=0)
            is_new = (differs[1:] != differs[:-1]).any(axis=1) & differs[1:].any(axis=1)
            change_rows = np.flatnonzero(is_new & (np.diff(scans) == 1)) + 1
            matches = [int(scans[index]) for index in change_rows if first <= scans[index] <= last]
            if matches:
                return (matches[0] if way > 0 else matches[-1]), searched
            searched = last if way > 0 else first
        return None, searched

    def _pieces(self, scan: int, way: int) -> Iterator[tuple[int, int]]:
        """Yield the first and last scan of each piece that both recordings have, beginning next to a scan."""
        low, high = self._common()
        if way > 0:
            for first in range(max(scan + 1, low), min(high, scan + MOST_SEARCHED) + 1, PIECE):
                yield first, min(first + PIECE - 1, high)
        else:
            for last in range(min(scan - 1, high), max(low, scan - MOST_SEARCHED) - 1, -PIECE):
                yield max(last - PIECE + 1, low), last

    def _common(self) -> tuple[int, int]:
        """Return the first and last scan that both recordings may have; 0 and -1 if there are none."""
        extents = [monitor.subject.timeline.extent for monitor in (self._own, self.other)]
        known_extents = [extent for extent in extents if extent is not None]
        if len(known_extents) < len(extents):
            return 0, -1
        return max(extent[0] for extent in known_extents), min(extent[1] for extent in known_extents)

    def _differing_words(self, first: int, last: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return the scans of a stretch that both have, with a row of flags for each: which words differ."""
        first = max(first, 0)
        own_rows, other_rows = (
            monitor.subject.timeline.between(first, last) for monitor in (self._own, self.other)
        )
        scans, own_indices, other_indices = np.intersect1d(
            own_rows["scan"], other_rows["scan"], return_indices=True
        )
        pair = [
            rows["words"][indices][:, self._columns(monitor)]
            for rows, indices, monitor in (
                (own_rows, own_indices, self._own),
                (other_rows, other_indices, self.other),
            )
        ]
        return scans.astype(np.int64), pair[0] != pair[1]

    def _columns(self, monitor: Monitor) -> np.ndarray[Any, Any]:
        """Return the places of words in a monitor's rows, for slots of equal size in both recordings."""
        own_places, other_places = (side.subject.spec.layout.places for side in (self._own, self.other))
        slots = [
            slot
            for slot, own_place in own_places.items()
            if slot in other_places and _sizes(own_place) == _sizes(other_places[slot])
        ]
        all_columns = np.arange(monitor.subject.spec.layout.words)
        word_columns = [all_columns[monitor.subject.spec.layout.places[slot].words] for slot in slots]
        return np.concatenate([*word_columns, np.zeros(0, int)])


COLUMNS = 88
"""Width for which routines of the other program are laid out, columns; the layout is not shown."""


def _sizes(places: ImagePlaces) -> tuple[int, ...]:
    return tuple(place.stop - place.start for place in places)


def _differing(mine: Mapping[str, Any], others: Mapping[str, Any]) -> Json:
    return {name: others[name] for name, value in mine.items() if name in others and others[name] != value}


def _words(mine: list[int], others: list[int] | None) -> Json:
    """Return the other's words that differ, by place, inputs before outputs; none if the sizes differ."""
    same_size = others is not None and len(others) == len(mine)
    pairs = enumerate(zip(mine, others or (), strict=True)) if same_size else ()
    return {str(place): other_word for place, (own_word, other_word) in pairs if own_word != other_word}


# --- questions


def recordings(monitor: Monitor, _page: Page, _question: Question) -> Json:
    """List the recordings of this rack with which a page may compare, newest first."""
    record, trace = _record_of(monitor), monitor.subject.timeline.opened()
    parent = None if trace is None else trace.head.metadata.get("parent")
    rack = monitor.subject.spec
    rows = (described(record.parent / name, rack, record, parent) for name in recordings_beside(record))
    return {"recordings": [row for row in rows if row is not None]}


def compare(monitor: Monitor, page: Page, question: Question) -> Json:
    """Start comparing with another recording in the same folder, or stop comparing."""
    name, record = question.get("with"), _record_of(monitor)
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


def difference(_monitor: Monitor, page: Page, question: Question) -> Json:
    """Return the next or previous scan in which the set of differing words changes."""
    scan, searched = _comparison(page).next_difference(*step_in(question))
    return {"scan": scan, "searched": searched}


def beside(_monitor: Monitor, page: Page, question: Question) -> Json:
    """Return the strip of past scans of the other recording, as far as available."""
    return {"strip": strip_in(_comparison(page).other, question)}


def _comparison(page: Page) -> Comparison:
    if not isinstance(page.compared, Comparison):
        raise ValueError("this page compares with no recording")
    return page.compared


def _record_of(monitor: Monitor) -> Path:
    return Path(monitor.about.record or monitor.about.path)
