"""The scans of a session or trace by number, the latest from the ring and the others from the trace.

    scan     0 ............................ 229,374 ............. 300,000
    from     the trace, a chunk at a time   the ring, in memory

A row from a trace has no figures and no wall time, since these are not recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scanrack.runtime.live.ring import Row, Rows
from scanrack.traces.format.records import TraceError
from scanrack.traces.format.tagplan import TagField
from scanrack.traces.read.arrays import extent, read_columns
from scanrack.traces.read.columns import Columns, Selection
from scanrack.traces.read.reader import Trace, open_trace

from .recent import RecentRows

WINDOWS = 4
"""Number of windows of a trace to keep in memory."""

WINDOW = 8192
"""Number of scans in a window."""


class Timeline:
    """The rows of all available scans."""

    def __init__(self, recent: RecentRows, path: Path | None) -> None:
        self.recent = recent
        self.path = path
        self._trace: Trace | None = None
        self._windows: dict[int, tuple[int, Rows]] = {}  # by number: size of the trace when read, rows
        self._extent: tuple[int, int] | None = None
        self._latest_tags: tuple[int, dict[str, Any]] | None = None  # of the scan of the latest request

    @property
    def extent(self) -> tuple[int, int] | None:
        """The first and the last scan; None without scans."""
        numbers = self.recent.rows["scan"]
        if not len(numbers):
            return self._recorded()
        first = int(numbers[0])
        if first and self.path is not None:
            recorded_extent = self._recorded()
            first = first if recorded_extent is None else min(first, recorded_extent[0])
        return first, int(numbers[-1])

    def row(self, scan: int) -> Row | None:
        """Return the row of a scan, or None."""
        rows = self.between(scan, scan)
        return rows[0] if len(rows) else None

    def between(self, first: int, last: int) -> Rows:
        """Return the available rows from scan `first` to scan `last`, inclusive."""
        rows = self.recent.between(first, last)
        begins = int(rows["scan"][0]) if len(rows) else last + 1
        if self.path is None or len(rows) == last - first + 1:
            return rows
        if begins <= first:  # recent rows may have gaps, if the session runs faster than the monitor
            stored_rows = self._read(first, last)
            if not len(stored_rows):
                return rows
            return np.concatenate([stored_rows, rows[rows["scan"] > stored_rows["scan"][-1]]])
        return np.concatenate([self._read(first, begins - 1), rows])

    def apart(self, first: int, last: int) -> Rows:
        """Return rows of the trace for one-time use, without loading windows."""
        return self._columns(Selection(first, last))

    def values(self, scan: int) -> dict[str, Any]:
        """Return the recorded tags in a scan, by name."""
        if self._latest_tags is None or self._latest_tags[0] != scan:
            trace = self.opened()
            self._latest_tags = scan, {} if trace is None else _recorded_tags(trace, scan)
        return self._latest_tags[1]

    def recorded(self, names: Sequence[str], first: int, last: int) -> tuple[list[int], dict[str, list[Any]]]:
        """Return the times of scans, ns, and the values of the recorded names.

        Both are empty if none of the names is recorded.
        """
        trace = self.opened()
        plan = None if trace is None else trace.head.tags
        if trace is None or plan is None:
            return [], {}
        if set(names).isdisjoint(address for field in plan.fields for address in field.tag.addresses):
            return [], {}
        self.follow()
        columns = read_columns(trace, Selection(first, last), tags=True)
        if columns.tags is None:
            return [], {}
        texts = trace.texts() if plan.has_texts else {}
        return columns.time_ns.tolist(), {
            address: [_shown(field, value, texts) for value in values.tolist()]
            for field in plan.fields
            for address, values in field.columns(columns.tags)
            if address in names
        }

    def follow(self) -> bool:
        """Read the new part of the trace; return whether there was a new part."""
        if self._trace is None:
            return self.opened() is not None
        grown = self._trace.follow()
        if grown:
            self._extent = None
        return grown

    def opened(self) -> Trace | None:
        """Return the opened trace; None without a trace, or before its first chunk."""
        if self._trace is None and self.path is not None:
            try:
                self._trace = open_trace(self.path)
            except TraceError:
                return None  # no chunk has been written yet
        return self._trace

    def use(self, trace: Trace) -> None:
        """Use a trace that is already open."""
        self._trace = trace

    def forget(self, path: Path | None) -> None:
        """Close the trace, and continue with another one."""
        self.close()
        self.path = path

    def close(self) -> None:
        """Close the trace."""
        if self._trace is not None:
            self._trace.close()
        self._trace, self._extent, self._latest_tags = None, None, None
        self._windows.clear()

    # --- the trace

    def _recorded(self) -> tuple[int, int] | None:
        """Return the first and the last scan of the trace, cached until it grows; None without scans."""
        if self._extent is None:
            trace = self.opened()
            ends = None if trace is None else extent(trace).scan.tolist()
            self._extent = (ends[0], ends[-1]) if ends else None
        return self._extent

    def _read(self, first: int, last: int) -> Rows:
        """Return the rows from `first` to `last`; the trace is read in whole windows."""
        numbers = range(first // WINDOW, last // WINDOW + 1)
        rows = np.concatenate([self._window(number, last) for number in numbers])
        low, high = np.searchsorted(rows["scan"], [first, last + 1])
        return rows[int(low) : int(high)]

    def _window(self, number: int, last: int) -> Rows:
        """Return a window; read it again if it lacks scans up to `last` and the trace has grown."""
        start, end = number * WINDOW, (number + 1) * WINDOW - 1
        size, rows = self._windows.pop(number, (-1, self.recent.rows[:0]))
        if not len(rows) or rows["scan"][-1] < min(end, last):
            self.follow()
            if self._size != size:
                size, rows = self._size, self._columns(Selection(start, end))
        self._windows[number] = size, rows
        while len(self._windows) > WINDOWS:
            del self._windows[next(iter(self._windows))]
        return rows

    @property
    def _size(self) -> int:
        return 0 if self._trace is None else self._trace.size

    def _columns(self, selection: Selection) -> Rows:
        trace = self.opened()
        return self._rows(None if trace is None else read_columns(trace, selection))

    def _rows(self, columns: Columns | None) -> Rows:
        """Return columns of the trace as rows of the ring; fields that are not recorded are 0."""
        rows = np.zeros(0 if columns is None else len(columns.scan), self.recent.dtype)
        if columns is not None:
            rows["scan"] = rows["again"] = columns.scan
            rows["flags"], rows["now_ns"], rows["words"] = columns.flags, columns.time_ns, columns.words
        return rows


def columns_of(rows: Rows) -> Columns:
    """Return rows as columns of a trace."""
    return Columns(
        rows["scan"].astype(np.int64), rows["now_ns"].copy(), rows["flags"].copy(), rows["words"].copy()
    )


def _recorded_tags(trace: Trace, scan: int) -> dict[str, Any]:
    """Return the tags in a scan for a page: enums by name, texts, arrays as lists and by element."""
    plan = trace.head.tags
    rows = None if plan is None else read_columns(trace, Selection(scan, scan), tags=True).tags
    if plan is None or rows is None or not len(rows):
        return {}
    texts = trace.texts() if plan.has_texts else {}
    whole_tags = {field.tag.name: _shown(field, rows[field.name][0].tolist(), texts) for field in plan.fields}
    elements = {
        address: _shown(field, values[0].item(), texts)
        for field in plan.fields
        if field.tag.length
        for address, values in field.columns(rows)
    }
    return whole_tags | elements


def _shown(field: TagField, value: Any, texts: Mapping[int, str]) -> Any:
    """Return a recorded value as a page shows it: texts and enums have numbers in a trace."""
    match field.tag.type:
        case "BOOL":
            return [bool(element) for element in value] if isinstance(value, list) else bool(value)
        case "TEXT":
            return texts.get(value, f"text {value}")
        case "ENUM" if value < len(field.constants):
            return field.constants[value]
    return value
