"""`scanrack show TRACE`: print the header, events and changes of a trace as text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Annotated, Generic, TypeVar

import typer
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from scanrack.io_images.times import seconds_column
from scanrack.jobs.trust.extracting import attached_files, extract
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.shared_options import RangeOption, TraceArgument, selection
from scanrack.terminal.status import DONE
from scanrack.terminal.tables import Cells
from scanrack.terminal.terminal import on_a_line, say
from scanrack.traces.format.flags import flag_names
from scanrack.traces.read.arrays import extent, scan_count
from scanrack.traces.read.changes import ROW_TITLES, ChangeRows, Row
from scanrack.traces.read.event_text import describe
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.traces.read.reader import Trace, TraceEvent, open_trace
from scanrack.traces.read.sections import Section
from scanrack.traces.read.tag_text import TagText
from scanrack.traces.signals import ALL, Selection

T = TypeVar("T")


def show(
    trace: Path,
    *,
    every: bool = False,
    limit: int | None = None,
    selected: Selection = ALL,
    as_json: bool = False,
) -> None:
    """Print a trace; raise TraceError if it can't be read.

    Args:
        every: whether to also print scans in which only the position or counts changed.
        limit: maximum number of rows, and of events; None means all.
    """
    with open_trace(trace) as opened:
        contents = Contents(opened, every=every, limit=limit, selected=selected)
        if not contents.rows.stopped:
            opened.check_data()
        if as_json:
            say_json(_as_json(trace, opened, contents))
            return
        for block in _blocks(trace, opened, contents):
            print_block(block)


class CappedList(Generic[T]):
    """A list that keeps the first items and counts the rest.

    Args:
        limit: maximum number of items to keep; None means all.
    """

    def __init__(self, limit: int | None) -> None:
        self.kept: list[T] = []
        self.more = 0  # number of items that were not kept
        self.stopped = False  # whether reading ended early, so that there may be more
        self._limit = limit

    @property
    def full(self) -> bool:
        """Whether the limit has been reached."""
        return self._limit is not None and len(self.kept) >= self._limit

    def add(self, items: Iterable[T]) -> None:
        """Keep items up to the limit; count the others."""
        rest = iter(items)
        count = None if self._limit is None else self._limit - len(self.kept)
        self.kept.extend(islice(rest, count))
        self.more += sum(1 for _ in rest)


ONLY_WITH_EVERY = frozenset({"/indicators", "/texts"})
"""Topics that are printed only with --every, because status bits and tags show the same information."""


class Contents:
    """The parts of a trace to print, collected in one pass that ends at the limit.

    Attributes:
        count: number of all scans, including those outside the range.
        first: number of the first scan.
        last: number of the last scan.
        rows: rows of the table that are in the range.
    """

    def __init__(self, trace: Trace, *, every: bool, limit: int | None, selected: Selection) -> None:
        self.rows: CappedList[Row] = CappedList(limit)
        self.events: CappedList[TraceEvent] = CappedList(limit)
        self._selected = selected
        self._every = every
        self._scans = 0
        tags = None if trace.head.tags is None else TagText(trace.head.tags, trace.texts(), every=every)
        formats = NumberFormats.of(trace)
        self._changes = ChangeRows(trace.head.slots, flag_names, every=every, tags=tags, formats=formats)
        for section in trace.sections:
            if self.events.full and self.rows.full:
                self.events.stopped = self.rows.stopped = True
                break
            # a full table needs no more scans, but sections with events are read for these
            if self.rows.full and trace.shape.only_scans(section):
                self.rows.stopped = True
            else:
                self._read(trace, section)
        if not self.rows.full:
            self.rows.add(self._changes.rest())
        self.count: int = scan_count(trace) if self.rows.stopped else self._scans
        self.first: int = 0
        self.last: int = 0
        self.end_ns: int = 0
        if self.count:
            ends = extent(trace)
            self.first, self.last = ends.scan.tolist()
            self.end_ns = int(ends.time_ns[-1])

    def _read(self, trace: Trace, section: Section) -> None:
        """Collect the selected events of a section, and the rows of its scans with changes."""
        for entry in trace.entries(section):
            if isinstance(entry, TraceEvent):
                is_printed = self._every or entry.topic not in ONLY_WITH_EVERY
                if is_printed and self._selected.has(entry.scan, entry.now_ns):
                    self.events.add([entry])
            else:
                self._scans += len(entry)
                is_selected = self._selected.has(entry["scan"], entry["log_time"])
                self.rows.add(self._changes.rows_of(entry, is_selected, trace.as_scans))


def _blocks(path: Path, trace: Trace, contents: Contents) -> Iterator[str | Table]:
    """Yield all parts to print, in order."""
    head = trace.head
    attachments = {attachment.name: f"{len(attachment.data):,} bytes" for attachment in trace.attachments()}
    yield f"{path}: {trace.size:,} bytes, written by {head.library}"
    for note in trace.notes:
        yield f"note: {note}"
    yield _scans_line(contents)
    yield from ("", _slot_table(trace), "", _pairs_table(head.metadata))
    yield from ("", _pairs_table({f"attached: {name}": size for name, size in attachments.items()}))
    yield ""
    yield from story(contents)


def _as_json(path: Path, trace: Trace, contents: Contents) -> dict[str, object]:
    """Return all parts for --json; counts of remaining rows are null if reading stopped at the limit."""
    head = trace.head
    return {
        "trace": str(path),
        "bytes": trace.size,
        "library": head.library,
        "notes": trace.notes,
        "metadata": head.metadata,
        "slots": [
            {"number": slot.number, "module": slot.module, "firmware": slot.firmware} for slot in head.slots
        ],
        "attached": {attachment.name: len(attachment.data) for attachment in trace.attachments()},
        "scans": contents.count,
        "first": contents.first,
        "last": contents.last,
        "end_ns": contents.end_ns,
        "events": [
            {**asdict(event), "text": describe(event.topic, event.scan, event.fields)}
            for event in contents.events.kept
        ],
        "more_events": None if contents.events.stopped else contents.events.more,
        "changes": [asdict(row) for row in contents.rows.kept],
        "more_changes": None if contents.rows.stopped else contents.rows.more,
    }


def story(contents: Contents) -> Iterator[str | Table]:
    """Yield the parts that show events and changes."""
    yield "What happened"
    yield _event_table(contents.events.kept) if contents.events.kept else "nothing beside the scans"
    yield from _more(contents.events, "events")
    yield from ("", "What changed")
    yield _row_table(contents.rows.kept) if contents.rows.kept else "nothing"
    yield from _more(contents.rows, "rows")


def _scans_line(contents: Contents) -> str:
    if not contents.count:
        return "no scans"
    return (
        f"{contents.count:,} scans, {contents.first} to {contents.last}, "
        f"up to {seconds_column(contents.end_ns)} s of machine time"
    )


def _more(capped: CappedList[T], kind: str) -> Iterator[str]:
    """Yield a line about the items that were not kept, if any exist or may exist."""
    if capped.stopped:
        yield f"... and maybe more {kind}: stopped at the limit"
    elif capped.more:
        yield f"... and {capped.more:,} more {kind}"


def _slot_table(trace: Trace) -> Table:
    table = new_table("slot>", "module", "firmware")
    for slot in trace.head.slots:
        table.add_row(str(slot.number), slot.module or "-", slot.firmware or "-")
    return table


def _pairs_table(pairs: Mapping[str, str]) -> Table:
    table = new_table("", "")
    table.show_header = False
    for name, value in pairs.items():
        if not name.startswith("slot"):  # signals of slots have their own table
            table.add_row(name, value)
    return table


def _event_table(events: Iterable[TraceEvent]) -> Table:
    table = new_table("scan>", "time s>", "slot>", "what")
    for event in events:
        slot = event.fields.get("slot", "")
        text = describe(event.topic, event.scan, event.fields)
        table.add_row(str(event.scan), seconds_column(event.now_ns), str(slot), text)
    return table


def _row_table(rows: Iterable[Row]) -> Table:
    table = new_table(*ROW_TITLES)
    for row in rows:
        table.add_row(*row.cells)
    return table


def new_table(*titles: str) -> Table:
    """Return an empty table; a title that ends in ">" marks a column of numbers."""
    table = Cells(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in titles:
        if title.endswith(">"):
            table.add_column(title[:-1], justify="right", no_wrap=True)
        else:
            table.add_column(title, overflow="fold")
    return table


def print_block(block: str | Table) -> None:
    """Print a block, wrapped to the width of a terminal; without a terminal, in lines of any length."""
    console = Console(highlight=False, markup=False, emoji=False)
    if isinstance(block, str):
        say(on_a_line(block))
    elif console.is_terminal:
        console.print(block)
    else:
        say("\n".join(plain_lines(block)))


def plain_lines(block: str | Table) -> list[str]:
    """Return a block as lines of any length, as Rich prints them on a wide console."""
    if isinstance(block, str):
        return [block]
    columns = []
    for column in block.columns:
        header = [str(column.header)] if block.show_header else []
        cells = [*header, *map(str, column.cells)]
        widths = [cell_len(cell) for cell in cells]
        width, right = max(widths, default=0), column.justify == "right"
        gaps = [" " * (width - cell_width) for cell_width in widths]
        columns.append([gap + cell if right else cell + gap for cell, gap in zip(cells, gaps, strict=True)])
    return ["  ".join(row).rstrip() for row in zip(*columns, strict=True)]


def _show_command(
    trace: TraceArgument,
    every: Annotated[
        bool, typer.Option("--every", help="Print every change, including position and counts.")
    ] = False,
    limit: Annotated[
        int | None,
        typer.Option("--limit", metavar="N", min=0, help="Maximum rows and events.", show_default="all"),
    ] = None,
    ranges: RangeOption = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--extract",
            metavar="FOLDER",
            help="Write the attached files to this folder: program, rack file, map of words.",
            show_default=False,
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List events and changes: the trace's header, slots and events, and the scans with changes.

    Bits that rose are shown as +NAME, bits that fell as -NAME. Scans in which only the position or encoder
    count changed are only counted, unless --every is given. The trace of a killed process is shown up to its
    last complete chunk. With --extract, the attached files are written, and only their names are printed.

    Examples:
        scanrack show run.mcap --range 1.5s:3s
        scanrack show run.mcap --extract attached

    Exit status: 0 done, 2 the file can't be read, 3 a file can't be written.
    """
    if folder is not None:
        with reported_mistakes(), open_trace(trace) as opened:
            for path in extract(attached_files(opened), folder):
                say(path)
        raise typer.Exit(DONE)
    with reported_mistakes():
        show(trace, every=every, limit=limit, selected=selection(ranges), as_json=as_json)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("show", no_args_is_help=True)(_show_command)
