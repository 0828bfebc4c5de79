"""Completes a trace that has no end, or a damaged one: whole records stay, indexes and end are made anew.

    head | chunk | index | chunk | index | chu                      the process was killed here
    head | chunk | index | chunk | index | summary | footer         after repair

Whole records are copied as they are, so a trace that has only lost its end is
afterwards what it would have been. The repaired trace is written beside the
original, put on the disk, and only then takes its place.
"""

from __future__ import annotations

import filecmp
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema

from .output import is_being_recorded
from .reader import Trace, open_trace
from .records import DAMAGED, MAGIC, Message, Span, TraceError, read_attachment, read_record, sound_summary
from .schema import LIBRARY
from .sections import Part, Section
from .summary import Entries, Summary, encoded

ORIGINAL_SUFFIX = ".orig"
"""What is added to the name of the original, where it is kept."""


@dataclass(slots=True)
class Repair:
    """What came of a repair.

    Attributes:
        notes: what was wrong with the trace; nothing at all and it has been left as it is.
        scans: how many scans it has, those that were left out not counted.
        original: where the original is kept; None if it is not, or still in its place.
    """

    notes: list[str] = field(default_factory=list)
    scans: int = 0
    original: Path | None = None

    @property
    def needed(self) -> bool:
        """Whether there was anything to repair."""
        return bool(self.notes)

    @property
    def damaged(self) -> int:
        """How many chunks or other records were left out because they can't be read."""
        return sum(note.startswith(DAMAGED) for note in self.notes)


def repair(
    path: Path, output: Path | None = None, *, progress: Callable[[int], None] = lambda size: None
) -> Repair:
    """Complete a trace.

    Where something whole in length but unreadable had to be left out, the original is kept, with
    `.orig` at the end of its name; otherwise nothing that could be read is lost, and it is replaced.

    Args:
        path: the trace.
        output: where the repaired trace is written; None to replace the trace.
        progress: told how many bytes of the trace have been gone through with each record.

    Raises:
        TraceError: it is no trace, or none that this version knows; see `open_trace`. Or it is
            being recorded.
        OSError: the repaired trace can't be written. The original is as it was.
    """
    path = path.resolve()
    target = path if output is None else output
    if is_being_recorded(target):
        raise TraceError(f"{target}: it is being recorded; repair it when that has ended")
    result = Repair()
    made = _new_file_beside(target)
    try:
        with open_trace(path) as trace:
            with made.open("wb") as file:
                Rewriter(trace, file, result, progress).run()
                file.flush()
                os.fsync(file.fileno())
            if not result.notes and trace.head.library.startswith(LIBRARY) and not _equal(made, path):
                result.notes.append("its indexes or its end do not fit what it holds")
        if result.needed:
            _put_in_place(made, path, target, result)
    finally:
        made.unlink(missing_ok=True)
    return result


def _new_file_beside(target: Path) -> Path:
    number, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".repair", dir=target.parent)
    os.close(number)
    return Path(name)


def _equal(one: Path, other: Path) -> bool:
    return filecmp.cmp(one, other, shallow=False)


def _put_in_place(made: Path, path: Path, target: Path, result: Repair) -> None:
    shutil.copymode(path, made)
    if target == path and result.damaged:
        result.original = path.with_name(path.name + ORIGINAL_SUFFIX)
        path.replace(result.original)
    made.replace(target)
    with suppress(OSError):  # not every system puts folders on the disk when asked
        folder = os.open(target.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


class Rewriter:
    """Writes what is whole of a trace, and an end.

    Args:
        trace: the open trace.
        file: where to.
        result: its counts are kept.
        progress: told of the bytes gone through.
    """

    def __init__(self, trace: Trace, file: BinaryIO, result: Repair, progress: Callable[[int], None]) -> None:
        self._trace, self._file, self._result, self._progress = trace, file, result, progress
        self._sections = {section.span.offset: section for section in trace.sections}
        self._summary = Summary()
        self._guarded = list(_guarded(trace))
        self._registered = 0

    def run(self) -> None:
        """Write all of it."""
        self._file.write(MAGIC)
        done = 0
        for span in takewhile(lambda span: span.opcode != Opcode.DATA_END, self._trace.spans):
            self._record(span)
            self._progress(span.end - done)
            done = span.end
        self._file.write(self._summary.end(self._file.tell()))
        self._progress(self._trace.size - done)
        self._result.notes += self._trace.notes

    def _record(self, span: Span) -> None:
        section = self._sections.get(span.offset)
        if section is not None:
            self._section(section)
        elif span.opcode in (Opcode.SCHEMA, Opcode.CHANNEL) and self._guarded:
            self._register()
        elif span.opcode not in _NOT_COPIED:
            try:
                self._index(span)
            except TraceError as error:
                self._trace.note(f"{error}; it is left out")
            else:
                self._file.write(self._trace.raw(span))

    def _register(self) -> None:
        """Write schemas and channels as the summary has them, once: a checksum guards those."""
        for record in self._guarded[self._registered :]:
            self._file.write(encoded(record))
            self._take(record)
            self._registered += 1

    def _take(self, record: Schema | Channel) -> None:
        """Let the summary know of a schema or channel."""
        if isinstance(record, Schema):
            self._summary.schema(record)
        else:
            self._summary.channel(record)

    def _index(self, span: Span) -> None:
        """Let the summary know of a record outside of chunks.

        Raises:
            TraceError: it is damaged.
        """
        file, place = self._trace.file, (self._file.tell(), span.end - span.offset)
        if span.opcode == Opcode.SCHEMA:
            self._take(read_record(file, span, Schema.read))
        elif span.opcode == Opcode.CHANNEL:
            self._take(read_record(file, span, Channel.read))
        elif span.opcode == Opcode.METADATA:
            self._summary.metadata(*place, read_record(file, span, Metadata.read))
        elif span.opcode == Opcode.ATTACHMENT:
            self._summary.attachment(*place, read_attachment(file, span))

    def _section(self, section: Section) -> None:
        parts = self._trace.parts(section)
        if parts is None:
            return
        entries = self._entries(parts)
        if section.is_chunk:
            self._chunk(section, entries)
        else:
            self._file.write(self._trace.raw(section.span))
            self._summary.messages(entries)
        self._result.scans += len(entries.get(self._trace.shape.channel, ()))

    def _chunk(self, section: Section, entries: Mapping[int, Entries]) -> None:
        """Copy a chunk, its times made anew: no checksum guards them."""
        chunk = read_record(self._trace.file, section.span, Chunk.read)
        times = np.concatenate([rows[:, 0] for rows in entries.values()] or [np.zeros(1, np.uint64)])
        chunk.message_start_time, chunk.message_end_time = int(times.min()), int(times.max())
        content, start = encoded(chunk), self._file.tell()
        self._file.write(content + self._summary.chunk(start, len(content), chunk, entries))

    def _entries(self, parts: Sequence[Part]) -> dict[int, Entries]:
        """Return times and offsets of the messages, by channel; let the summary know of anything else."""
        entries: dict[int, list[Entries]] = {}
        for part in parts:
            what = part.what
            if isinstance(what, Schema | Channel):
                self._take(what)
            elif isinstance(what, Message):
                entry = np.array([[what.log_time, part.offset]], np.uint64)
                entries.setdefault(what.channel, []).append(entry)
            else:
                offsets = part.offset + self._trace.shape.stride * np.arange(len(what), dtype=np.uint64)
                rows = np.column_stack((what["log_time"], offsets.astype(np.uint64)))
                entries.setdefault(self._trace.shape.channel, []).append(rows)
        return {channel: np.concatenate(entries[channel]) for channel in sorted(entries)}


def _guarded(trace: Trace) -> Iterator[Schema | Channel]:
    """Yield the schemas and channels in a trace's summary, each schema before its channels.

    Those at the beginning of the file have no checksum.
    """
    summary = sound_summary(trace.file, trace.spans)
    if summary is None:
        return
    spans = [span for span in trace.spans if span.offset >= summary]
    schemas = [read_record(trace.file, span, Schema.read) for span in spans if span.opcode == Opcode.SCHEMA]
    channels = [
        read_record(trace.file, span, Channel.read) for span in spans if span.opcode == Opcode.CHANNEL
    ]
    for channel in channels:
        yield from (schema for schema in schemas if schema.id == channel.schema_id)
        yield channel


_NOT_COPIED = frozenset({Opcode.MESSAGE, Opcode.MESSAGE_INDEX, Opcode.FOOTER, Opcode.STATISTICS}) | {
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
}
"""Records that are made anew, or copied with their section."""
