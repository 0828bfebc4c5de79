"""Finds the marks of a whole recording: errors, faults, rules, mode changes, restarts.

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
"""Number of scans that are searched at once; this takes about 10 ms."""

SAME_SCANS = 2
"""An error bit comes on at most this many scans after its rule is reported."""

KINDS = ("fault", "error", "rule", "mode", "restart")
"""Kinds of marks, most severe first."""

FAILURES = ("fault", "error")

SHOWN_MOST = 2_000
"""Largest number of marks on a page's axis; if there are more, some are shown per stretch of scans."""


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
    """The marks of a recording, as far as it has been searched.

    Args:
        words: words of the modules, by slot, in the order of the rows.
    """

    def __init__(
        self, timeline: Timeline, recorded: RecordedEvents, words: Mapping[int, ModuleWords]
    ) -> None:
        self._timeline, self._recorded, self._words = timeline, recorded, words
        self._errors = ErrorWatch(words)
        self._of_rows: list[Mark] = []
        self._before: Rows | None = None
        self._next: int | None = None
        self._known: tuple[tuple[int, ...], list[Mark], list[int]] = ((), [], [])
        self.unexplained: list[Mark] = []  # error bits that came on without a rule, at the last question

    def tick(self) -> bool:
        """Search one more piece; return whether more remain."""
        extent = self._timeline.extent
        if extent is None:
            return False
        first = extent[0] if self._next is None else self._next
        if first <= extent[1]:
            self._take(self._timeline.apart(first, min(first + PIECE - 1, extent[1])))
            self._next = min(first + PIECE, extent[1] + 1)
        return self._next is None or self._next <= extent[1]

    @property
    def whole(self) -> bool:
        """Whether all scans and events have been searched."""
        extent = self._timeline.extent
        return extent is None or (
            self._next is not None and self._next > extent[1] and self._recorded.missing() == 0
        )

    @property
    def all(self) -> Sequence[Mark]:
        """The marks, in order."""
        return self._sorted()[0]

    def next(self, scan: int, way: int, kinds: Sequence[str] = KINDS) -> Mark | None:
        """Return the next mark after a scan, or the previous one if `way` is -1; None if there is none."""
        marks, scans = self._sorted()
        beyond = marks[bisect_right(scans, scan) :] if way > 0 else marks[: bisect_left(scans, scan)][::-1]
        nearest = next((mark for mark in beyond if mark.kind in kinds), None)
        if nearest is None:
            return None
        same_scan = marks[bisect_left(scans, nearest.scan) : bisect_right(scans, nearest.scan)]
        return min(same_scan, key=lambda each: KINDS.index(each.kind))  # the most severe in its scan

    def failure(self, scan: int) -> Mark | None:
        """Return the last fault or error up to a scan; if there is none, the first of all."""
        return self.next(scan + 1, -1, FAILURES) or self.next(scan, 1, FAILURES)

    def shown(self) -> list[list[Any]]:
        """Return `[scan, kind, count]` of the marks on the axis; of many, the most severe per stretch."""
        marks = self.all
        if len(marks) <= SHOWN_MOST:
            return [[mark.scan, mark.kind, 1] for mark in marks]
        first, last = marks[0].scan, marks[-1].scan
        groups: dict[int, list[Any]] = {}
        for mark in marks:
            place = (mark.scan - first) * SHOWN_MOST // (last - first + 1)
            group = groups.setdefault(place, [mark.scan, mark.kind, 0])
            group[2] += 1
            if KINDS.index(mark.kind) < KINDS.index(group[1]):
                group[:2] = mark.scan, mark.kind
        return list(groups.values())

    # --- where they come from

    def _sorted(self) -> tuple[list[Mark], list[int]]:
        version = len(self._of_rows), *self._recorded.version
        if self._known[0] != version:
            rule_scans: dict[tuple[int, str], list[int]] = {}
            marks = list(self._of_events(rule_scans))
            row_marks = [mark for mark in self._of_rows if not _has_rule_mark(mark, rule_scans)]
            self.unexplained = [mark for mark in row_marks if mark.kind == "error"]
            marks += row_marks
            marks.sort(key=attrgetter("scan"))
            self._known = version, marks, [mark.scan for mark in marks]
        return self._known[1:]

    def _of_events(self, rule_scans: dict[tuple[int, str], list[int]]) -> Iterator[Mark]:
        """Yield the marks for events, faults and rules; record the scans in which rules set bits."""
        for event in self._recorded.known():
            scan, kind, bits = event["scan"], event["kind"], event.get("bits", ())
            if kind == "faults":
                yield Mark(scan, event["t"], "fault", event["text"])
            elif kind == "rule":
                for bit in bits:
                    rule_scans.setdefault((event["slot"], bit), []).append(scan)
                yield self._of_rule(event, bits)

    def _of_rule(self, event: Json, bits: Sequence[str]) -> Mark:
        slot, name = event["slot"], event["name"]
        errors = self._words[slot].errors if slot in self._words and event["scan"] else ()  # power-up is none
        error = next((rule_bit for rule_bit in bits if rule_bit in errors), "")
        bit = self._errors.bit(slot, error)
        kind, text = "error" if error else "rule", f"{event['text']} [{name}]"
        return Mark(event["scan"], event["t"], kind, text, slot, error or name, bit.address if bit else "")

    def _take(self, rows: Rows) -> None:
        if not len(rows):
            return
        self._of_rows += [self._error(rows[place], bit) for place, bit in self._errors.all(rows)]
        joined = rows if self._before is None else np.concatenate([self._before, rows])
        skipped = len(joined) - len(rows)
        modes = joined["flags"] & MODE_MASK
        firsts = (joined["flags"] & ScanFlag.FIRST_SCAN) != 0
        change_rows = np.flatnonzero((modes[1:] != modes[:-1]) | (firsts[1:] & ~firsts[:-1])) + 1
        for place in change_rows.tolist():
            row, old, new = joined[place], CpuMode(int(modes[place - 1])), CpuMode(int(modes[place]))
            scan, now_ns = int(row["scan"]), int(row["now_ns"])
            if old is not new:
                self._of_rows.append(
                    Mark(scan, now_ns, "mode", f"Mode {mode_name(new)}, before that {mode_name(old)}")
                )
            else:
                self._of_rows.append(Mark(scan, now_ns, "restart", "The program starts again: a first scan"))
        self._before = joined[skipped:][-1:].copy()

    @staticmethod
    def _error(row: Any, bit: ErrorBit) -> Mark:
        text = f"{bit.name} came on"
        return Mark(int(row["scan"]), int(row["now_ns"]), "error", text, bit.slot, bit.name, bit.address)


def _has_rule_mark(mark: Mark, rule_scans: Mapping[tuple[int, str], Sequence[int]]) -> bool:
    """Return whether the rule that set an error bit has a mark of its own."""
    scans = rule_scans.get((mark.slot, mark.name), ()) if mark.kind == "error" else ()
    place = bisect_right(scans, mark.scan) - 1
    return place >= 0 and mark.scan - scans[place] <= SAME_SCANS
