"""Reads a whole trace, a slice of scans or time, or a single scan as numpy arrays.

    with open_trace(path) as trace:
        columns = read_columns(trace)                       # all scans
        named = by_name(columns.words, trace.head.slots)
        named["slot1"]["in"]["position_msw"]                # a word in every scan, int16

All messages in a chunk from scanrack have the same size, so the chunk is read as one array. Chunks from other
writers are read message by message if necessary. A slice reads only the chunks it needs. The memory use of
`column_chunks` does not depend on the length of the trace.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..format.tagplan import FIELD
from .columns import ALL, Columns, Selection, by_name, join, no_columns
from .reader import Scan, Trace, TraceEvent
from .sections import ScanRows, Section

__all__ = [
    "ALL",
    "Columns",
    "Selection",
    "by_name",
    "column_chunks",
    "extent",
    "read_columns",
    "scan_at",
    "scan_count",
]


def read_columns(trace: Trace, selection: Selection = ALL, *, tags: bool = False) -> Columns:
    """Read the selected scans of a trace into memory, which takes 20 bytes per scan and two per word.

    Scans of a damaged chunk are missing; `trace.notes` lists these chunks.

    Args:
        selection: the scans to read; if it has no scans, the columns are empty.
        tags: also read recorded tags: `read_columns(trace, tags=True).tags["fill_acc"]`.
    """
    blocks = []
    for columns in column_chunks(trace, selection, tags=tags):
        start, stop = selection.rows(columns)
        blocks.append(columns.rows(start, max(start, stop)))
    if blocks:
        return join(blocks)
    plan = trace.head.tags if tags else None
    return no_columns(trace.head.layout.words, None if plan is None else plan.dtype)


def column_chunks(
    trace: Trace, selection: Selection = ALL, *, margin: int = 0, tags: bool = False
) -> Iterator[Columns]:
    """Iterate over the selected chunks of a trace, in the order of the file.

    Args:
        selection: the scans to read; the first and the last chunk may also have other scans.
        margin: number of additional scans before and after the selection, if the trace has them.
    """
    for section in _needed(trace, selection, margin):
        row_arrays = trace.scan_rows(section)
        if row_arrays:
            yield _columns(_joined(row_arrays), tags=tags)


def column_chunks_and_events(trace: Trace) -> Iterator[tuple[Columns, list[TraceEvent]]]:
    """Iterate over the scans and events of all chunks, even of chunks without scans; read each chunk once."""
    nothing = no_columns(trace.head.layout.words)
    for section in trace.sections:
        row_arrays, events = trace.scans_and_events(section)
        yield _columns(_joined(row_arrays)) if row_arrays else nothing, events


def _joined(row_arrays: Sequence[ScanRows]) -> ScanRows:
    return row_arrays[0] if len(row_arrays) == 1 else np.concatenate(row_arrays)


def scan_count(trace: Trace, selection: Selection = ALL, *, margin: int = 0) -> int:
    """Return the number of scans in the chunks that `column_chunks` yields, using only the indexes."""
    return sum(map(trace.shape.expected, _needed(trace, selection, margin)))


def scan_at(trace: Trace, number: int) -> Scan:
    """Return one scan, reading only the parts of the trace that are needed to find it.

    Raises:
        ValueError: the trace has no scan with this number; the message lists the scans that exist.
    """
    for section in _needed(trace, Selection(number, number), 0):
        for rows in trace.scan_rows(section):
            row = int(np.searchsorted(rows["scan"], number))
            if row < len(rows) and rows["scan"][row] == number:
                return next(trace.as_scans(rows[row : row + 1]))
    edge_scans = extent(trace)
    existing = f"{edge_scans.scan[0]} to {edge_scans.scan[1]}" if len(edge_scans.scan) else "no scans"
    raise ValueError(f"the trace has no scan {number}; it has {existing}")


def extent(trace: Trace) -> Columns:
    """Return the first and last scan of a trace as two rows; no rows for a trace without scans."""
    edge_rows = [trace.edge(last=at_end) for at_end in (False, True)]
    edge_columns = [_columns(rows) for rows in edge_rows if rows is not None]
    return join(edge_columns) if edge_columns else no_columns(trace.head.layout.words)


def _needed(trace: Trace, selection: Selection, margin: int) -> Sequence[Section]:
    """Return the sections with the requested scans and the margins."""
    sections, end_ns = trace.sections, selection.end_ns
    first_section, end_section = 0, len(sections)
    while first_section < end_section and sections[first_section].end_ns < selection.start_ns:
        first_section += 1
    while first_section < end_section and end_ns is not None and sections[end_section - 1].start_ns > end_ns:
        end_section -= 1
    if selection.first:
        first_section = max(first_section, trace.place_of(selection.first))
    if selection.last is not None:
        end_section = min(end_section, trace.place_of(selection.last) + 1)
    scans_before = scans_after = margin
    while first_section > 0 and scans_before > 0:
        first_section -= 1
        scans_before -= trace.shape.expected(sections[first_section])
    while end_section < len(sections) and scans_after > 0:
        scans_after -= trace.shape.expected(sections[end_section])
        end_section += 1
    return sections[first_section:end_section]


def _columns(rows: ScanRows, *, tags: bool = False) -> Columns:
    """Return rows as columns, without tags unless they are requested and recorded."""
    words = np.ascontiguousarray(rows["images"]).view("<i2").reshape(len(rows), -1)
    has_tags = tags and FIELD in (rows.dtype.names or ())
    return Columns(
        scan=rows["scan"].astype(np.int64),
        time_ns=rows["log_time"].astype(np.int64),
        flags=rows["flags"].copy(),
        words=words,
        tags=np.ascontiguousarray(rows[FIELD]) if has_tags else None,
    )
