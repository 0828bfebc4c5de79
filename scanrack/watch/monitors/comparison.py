"""Comparison of a page's trace with another one: the same scan in both, and how the two differ.

    page       scan 480   words  power  tags          of the session or trace of the page
    other      scan 480   words  power  tags          of a trace in the same folder
    frame      other: { there, known, words, power, tags }    values of the other trace that differ

Scans with equal numbers are compared. The other trace may be a branch of this one.
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
"""Maximum number of traces in a page's list, the newest first."""

PIECE, MOST_SEARCHED = 4096, 65_536
"""Number of scans to compare at once, and maximum number for a question."""


class OpenedBeside(NamedTuple):
    """Another trace: its monitor, and a function that closes its files."""

    monitor: Monitor
    close: Callable[[], None]


def recordings_beside(record: Path) -> list[str]:
    """Return the names of the other traces in the folder of a trace or rack file."""
    rows = []
    for file in record.parent.glob("*.mcap"):
        with suppress(OSError):  # the file no longer exists, or can't be accessed
            if file.is_file() and file.resolve() != record.resolve():
                rows.append((file.stat().st_mtime_ns, file.name))
    return [name for _, name in sorted(rows, reverse=True)[:MOST_LISTED]]


def described(path: Path, rack: RackSpec, page_trace: Path, parent: str | None) -> Json | None:
    """Return an entry for a page's list of traces; None if it is from another rack or unreadable.

    Args:
        rack: rack of the page.
        page_trace: trace of the page.
        parent: name of the trace from which the page's trace branches, or None.
    """
    try:
        with open_trace(path) as trace:
            metadata, slots = trace.head.metadata, [(slot.number, slot.module) for slot in trace.head.slots]
        changed_s = path.stat().st_mtime
    except (OSError, TraceError):
        return None
    if metadata.get("name") != rack.name or slots != sorted((slot.number, slot.module) for slot in rack.slot):
        return None
    is_branch = metadata.get("parent") == page_trace.name
    relation = "branch" if is_branch else ""
    return {
        "name": path.name,
        "date": datetime.fromtimestamp(changed_s).astimezone().isoformat(timespec="seconds"),
        "relation": "parent" if path.name == parent else relation,
        "scan": int(metadata.get("parent_scan", 0)) if is_branch else None,
    }


class Comparison:
    """A comparison on a page.

    Attributes:
        name: name of the other trace.
        other: monitor of the other trace.

    Args:
        monitor: the monitor of the page.
    """

    def __init__(self, monitor: Monitor, name: str, opened: OpenedBeside) -> None:
        self.name, self._own = name, monitor
        self.other, self._close = opened
        self._page, self._routine = Page(), ""

    def close(self) -> None:
        """Close the other trace."""
        self._close()

    def tick(self) -> bool:
        """Run more scans of the other program; return whether more scans remain."""
        return self.other.tick()

    def differences(self, page: Page, picture: Json) -> Json:
        """Return the other trace's values that differ in the scan of a picture."""
        scan = int(picture["scan"])
        if self.other.subject.timeline.row(scan) is None:
            return {"there": False, "words": {}, "power": {}, "tags": {}}
        self._follow(page, scan)
        other = self.other.picture(self._page)
        words = {
            slot: _differing_words(words, other["words"].get(slot))
            for slot, words in picture["words"].items()
        }
        return {
            "there": True,
            "known": other.get("known", True) and picture.get("known", True),
            "power": _differing(picture.get("power", {}), other.get("power", {})),
            "tags": _differing(picture.get("tags", {}), other.get("tags", {})),
            "words": {slot: differing for slot, differing in words.items() if differing},
        }

    def _follow(self, page: Page, scan: int) -> None:
        """Show the same scan, routine and tags of the other trace."""
        own_page, program = self._page, self.other.subject.programs.at(scan)
        own_page.past = scan
        if own_page.program is not program or self._routine != page.shown.name:
            own_page.program, self._routine = program, page.shown.name
            routine = NOTHING_SHOWN
            if program.catalog is not None and self._routine:
                with suppress(ValueError):  # the other program may lack the routine
                    routine, _ = program.catalog.show(self._routine, COLUMNS)
            own_page.show(routine)
        own_page.watch(page.watched)

    def next_difference(self, scan: int, direction: int) -> tuple[int | None, int]:
        """Return the next scan in which the set of differing words changes, and the last searched scan.

        Args:
            scan: scan from which to search, not included.
            direction: 1 forwards, -1 backwards.
        """
        searched, low = scan, self._common()[0]
        for first, last in self._pieces(scan, direction):
            scans, differs = self._word_differences(first - 1, last)
            if len(scans) and scans[0] == low:  # before the first scan nothing differs
                scans, differs = np.insert(scans, 0, low - 1), np.insert(differs, 0, False, axis=0)
            is_new = (differs[1:] != differs[:-1]).any(axis=1) & differs[1:].any(axis=1)
            change_rows = np.flatnonzero(is_new & (np.diff(scans) == 1)) + 1
            matches = [int(scans[index]) for index in change_rows if first <= scans[index] <= last]
            if matches:
                return (matches[0] if direction > 0 else matches[-1]), searched
            searched = last if direction > 0 else first
        return None, searched

    def _pieces(self, scan: int, direction: int) -> Iterator[tuple[int, int]]:
        """Yield the first and last scan of each piece that both traces may have, starting from a scan."""
        low, high = self._common()
        if direction > 0:
            for first in range(max(scan + 1, low), min(high, scan + MOST_SEARCHED) + 1, PIECE):
                yield first, min(first + PIECE - 1, high)
        else:
            for last in range(min(scan - 1, high), max(low, scan - MOST_SEARCHED) - 1, -PIECE):
                yield max(last - PIECE + 1, low), last

    def _common(self) -> tuple[int, int]:
        """Return the first and last scan that both traces may have; 0 and -1 if they share no scans."""
        own, other = self._own.subject.timeline.extent, self.other.subject.timeline.extent
        if own is None or other is None:
            return 0, -1
        return max(own[0], other[0]), min(own[1], other[1])

    def _word_differences(self, first: int, last: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return the common scans of a stretch, and a row of flags per scan that mark differing words."""
        first = max(first, 0)
        own_rows = self._own.subject.timeline.between(first, last)
        other_rows = self.other.subject.timeline.between(first, last)
        scans, own_indexes, other_indexes = np.intersect1d(
            own_rows["scan"], other_rows["scan"], return_indices=True
        )
        own_words = own_rows["words"][own_indexes][:, self._columns(self._own)]
        other_words = other_rows["words"][other_indexes][:, self._columns(self.other)]
        return scans.astype(np.int64), own_words != other_words

    def _columns(self, monitor: Monitor) -> np.ndarray[Any, Any]:
        """Return the columns of words in a monitor's rows, for slots of equal size in both traces."""
        own_images, other_images = self._own.subject.spec.layout.places, self.other.subject.spec.layout.places
        slots = [
            slot
            for slot, images in own_images.items()
            if slot in other_images and _sizes(images) == _sizes(other_images[slot])
        ]
        all_columns = np.arange(monitor.subject.spec.layout.words)
        word_columns = [all_columns[monitor.subject.spec.layout.places[slot].words] for slot in slots]
        return np.concatenate([*word_columns, np.zeros(0, int)])


COLUMNS = 88
"""Width of routines of the other program, columns. Their drawing is not used."""


def _sizes(images: ImagePlaces) -> tuple[int, ...]:
    return tuple(image.stop - image.start for image in images)


def _differing(own: Mapping[str, Any], other: Mapping[str, Any]) -> Json:
    return {name: other[name] for name, value in own.items() if name in other and other[name] != value}


def _differing_words(own: list[int], other: list[int] | None) -> Json:
    """Return the other slot's differing words by index, inputs before outputs; none if the sizes differ."""
    if other is None or len(other) != len(own):
        return {}
    pairs = enumerate(zip(own, other, strict=True))
    return {str(index): other_word for index, (own_word, other_word) in pairs if own_word != other_word}


# --- questions


def recordings(monitor: Monitor, _page: Page, _question: Question) -> Json:
    """List the traces of this rack that a page can compare with its own, newest first."""
    record, trace = _record_of(monitor), monitor.subject.timeline.opened()
    parent = None if trace is None else trace.head.metadata.get("parent")
    rack = monitor.subject.spec
    rows = (described(record.parent / name, rack, record, parent) for name in recordings_beside(record))
    return {"recordings": [row for row in rows if row is not None]}


def compare(monitor: Monitor, page: Page, question: Question) -> Json:
    """Begin or end a comparison with another trace in the same folder."""
    name, record = question.get("with"), _record_of(monitor)
    if name is None:
        page.compare(None)
        return {"with": None}
    if monitor.opener is None or name not in recordings_beside(record):
        raise ValueError(f"no recording {str(name)[:60]!r} in the same folder")
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
    """Return the strip of past scans of the other trace, as far as available."""
    return {"strip": strip_in(_comparison(page).other, question)}


def _comparison(page: Page) -> Comparison:
    if not isinstance(page.compared, Comparison):
        raise ValueError("this page does not compare with a recording")
    return page.compared


def _record_of(monitor: Monitor) -> Path:
    return Path(monitor.about.record or monitor.about.path)
