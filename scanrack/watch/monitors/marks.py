"""The marks of a trace: errors, faults, rules, mode changes, restarts.

scans      0 ... 32,767   32,768 ...        columns of the images and flags, a piece per tick
events     one chunk per tick               see `recorded_events`
marks      4,001 INP-01   4,002 INPUT_ERROR   9,000 run to program
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.module_words import ModuleWords
from scanrack.runtime.live.ring import Rows
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, ScanFlag, mode_name

from ..history.recorded_events import Json, RecordedEvents
from ..history.timeline import Timeline
from .troubles import ErrorBit, ErrorWatch

PIECE = 32_768
"""Number of scans to search at once, which takes about 10 ms."""

SAME_SCANS = 2
"""Maximum number of scans between the report of a rule and its error bit."""

KINDS = ("fault", "error", "rule", "mode", "restart")
"""Kinds of marks, the most severe first."""

FAILURES = ("fault", "error")

SHOWN_MOST = 2_000
"""Maximum number of marks on a page's axis. If there are more, they are combined by stretches of scans."""


class Mark(NamedTuple):
    """A mark at a scan."""

    scan: int
    t: int
    kind: str
    text: str
    slot: int = 0
    name: str = ""  # name of the bit or rule
    tag: str = ""  # address of the bit


class Marks:
    """The marks of a trace, as far as it has been searched.

    Args:
        words: words of the modules, by slot, in the order of the rows.
    """

    def __init__(
        self, timeline: Timeline, recorded: RecordedEvents, words: Mapping[int, ModuleWords]
    ) -> None:
        self._timeline, self._recorded, self._words = timeline, recorded, words
        self._errors = ErrorWatch(words)
        self._row_marks: list[Mark] = []
        self._last_row: Rows | None = None
        self._next: int | None = None  # the next scan to search
        self._cache: tuple[tuple[int, ...], list[Mark], list[int]] = ((), [], [])  # version, marks, scans
        self.unexplained: list[Mark] = []  # error bits that came on without a rule, when `all` was last read

    def tick(self) -> bool:
        """Search one more piece; return whether more pieces remain."""
        extent = self._timeline.extent
        if extent is None:
            return False
        first = extent[0] if self._next is None else self._next
        if first <= extent[1]:
            self._take(self._timeline.apart(first, min(first + PIECE - 1, extent[1])))
            self._next = min(first + PIECE, extent[1] + 1)
        return self._next is None or self._next <= extent[1]

    @property
    def is_complete(self) -> bool:
        """Whether all scans and events have been searched."""
        extent = self._timeline.extent
        if extent is None:
            return True
        return self._next is not None and self._next > extent[1] and self._recorded.missing() == 0

    @property
    def all(self) -> Sequence[Mark]:
        """The marks, in order."""
        return self._sorted()[0]

    def find(self, scan: int, direction: int, kinds: Sequence[str] = KINDS) -> Mark | None:
        """Return the next mark after a scan, or before it if `direction` is -1; None if there is none."""
        marks, scans = self._sorted()
        if direction > 0:
            candidates = marks[bisect_right(scans, scan) :]
        else:
            candidates = marks[: bisect_left(scans, scan)][::-1]
        nearest = next((mark for mark in candidates if mark.kind in kinds), None)
        if nearest is None:
            return None
        same_scan = marks[bisect_left(scans, nearest.scan) : bisect_right(scans, nearest.scan)]
        return min(same_scan, key=_severity)

    def failure(self, scan: int) -> Mark | None:
        """Return the latest fault or error up to a scan, otherwise the first one after it."""
        return self.find(scan + 1, -1, FAILURES) or self.find(scan, 1, FAILURES)

    def on_axis(self) -> list[list[Any]]:
        """Return `[scan, kind, count]` for marks on the axis; if many, the most severe per stretch."""
        marks = self.all
        if len(marks) <= SHOWN_MOST:
            return [[mark.scan, mark.kind, 1] for mark in marks]
        first, last = marks[0].scan, marks[-1].scan
        groups: dict[int, list[Any]] = {}
        for mark in marks:
            stretch = (mark.scan - first) * SHOWN_MOST // (last - first + 1)
            group = groups.setdefault(stretch, [mark.scan, mark.kind, 0])
            group[2] += 1
            if KINDS.index(mark.kind) < KINDS.index(group[1]):
                group[:2] = mark.scan, mark.kind
        return list(groups.values())

    # --- marks of events and rows

    def _sorted(self) -> tuple[list[Mark], list[int]]:
        """Return the known marks in order, and their scans; sort them again if more are known."""
        version = len(self._row_marks), *self._recorded.version
        if self._cache[0] != version:
            rule_scans: dict[tuple[int, str], list[int]] = {}
            marks = list(self._event_marks(rule_scans))
            row_marks = [mark for mark in self._row_marks if not _has_rule_mark(mark, rule_scans)]
            self.unexplained = [mark for mark in row_marks if mark.kind == "error"]
            marks += row_marks
            marks.sort(key=attrgetter("scan"))
            self._cache = version, marks, [mark.scan for mark in marks]
        return self._cache[1:]

    def _event_marks(self, rule_scans: dict[tuple[int, str], list[int]]) -> Iterator[Mark]:
        """Yield the marks of faults and rules; add the scans in which rules set bits to `rule_scans`."""
        for event in self._recorded.known_events():
            scan, kind, bits = event["scan"], event["kind"], event.get("bits", ())
            if kind == "faults":
                yield Mark(scan, event["t"], "fault", event["text"])
            elif kind == "rule":
                for bit in bits:
                    rule_scans.setdefault((event["slot"], bit), []).append(scan)
                yield self._rule_mark(event, bits)

    def _rule_mark(self, event: Json, bits: Sequence[str]) -> Mark:
        """Return the mark of a rule, which is an error if the rule set an error bit."""
        slot, name = event["slot"], event["name"]
        is_after_power_up = event["scan"] > 0  # bits that are on at power-up are no errors
        errors = self._words[slot].errors if slot in self._words and is_after_power_up else ()
        error = next((rule_bit for rule_bit in bits if rule_bit in errors), "")
        bit = self._errors.bit(slot, error)
        kind, text = "error" if error else "rule", f"{event['text']} [{name}]"
        address = bit.address if bit else ""
        return Mark(event["scan"], event["t"], kind, text, slot=slot, name=error or name, tag=address)

    def _take(self, rows: Rows) -> None:
        """Add the marks of successive rows: error bits that came on, mode changes, restarts."""
        if not len(rows):
            return
        self._row_marks += [self._error(rows[index], bit) for index, bit in self._errors.all(rows)]
        joined = rows if self._last_row is None else np.concatenate([self._last_row, rows])
        modes = joined["flags"] & MODE_MASK
        firsts = (joined["flags"] & ScanFlag.FIRST_SCAN) != 0
        change_rows = np.flatnonzero((modes[1:] != modes[:-1]) | (firsts[1:] & ~firsts[:-1])) + 1
        for index in change_rows.tolist():
            row, old, new = joined[index], CpuMode(int(modes[index - 1])), CpuMode(int(modes[index]))
            kind, text = "restart", "The program starts again: a first scan"
            if old is not new:
                kind, text = "mode", f"Mode {mode_name(new)}, before that {mode_name(old)}"
            self._row_marks.append(Mark(int(row["scan"]), int(row["now_ns"]), kind, text))
        self._last_row = rows[-1:].copy()

    @staticmethod
    def _error(row: Any, bit: ErrorBit) -> Mark:
        scan, now_ns, text = int(row["scan"]), int(row["now_ns"]), f"{bit.name} came on"
        return Mark(scan, now_ns, "error", text, slot=bit.slot, name=bit.name, tag=bit.address)


def _has_rule_mark(mark: Mark, rule_scans: Mapping[tuple[int, str], Sequence[int]]) -> bool:
    """Return whether a mark of an error bit has the same cause as the mark of a rule."""
    scans = rule_scans.get((mark.slot, mark.name), ()) if mark.kind == "error" else ()
    index = bisect_right(scans, mark.scan) - 1
    return index >= 0 and mark.scan - scans[index] <= SAME_SCANS


def _severity(mark: Mark) -> int:
    """Return the severity of a mark; a lower number is more severe."""
    return KINDS.index(mark.kind)
