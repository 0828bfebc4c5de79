"""Completes a trace without an end, or a damaged trace: whole records are kept, indexes and end are rebuilt.

    head | chunk | index | chunk | index | chu                      the process was killed here
    head | chunk | index | chunk | index | summary | footer         after repair

Whole records are copied unchanged, so that a trace that only lacks its end becomes
identical to a complete recording. The repaired trace is written beside the
original and flushed to the disk, and only then replaces it. The original is kept
unless the repaired trace begins with all of it except a torn end.
"""

from __future__ import annotations

import os
import shutil
import zlib
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from os.path import realpath
from pathlib import Path
from typing import IO

import numpy as np
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Header, Metadata, Schema

from .files.guard import TRACE
from .files.keeping import begin_alike
from .files.newfile import Draft, new_file, replacing
from .format.records import (
    BROKEN,
    DRAFT,
    MAGIC,
    Damage,
    Message,
    Span,
    TraceError,
    TraceLimitError,
    note_of,
    read_attachment,
    read_record,
)
from .format.schema import LIBRARY
from .format.summary import Entries, Summary, encoded
from .read.finding import DATA_DAMAGE, data_crc, ends_whole, sound_summary
from .read.reader import Records, Trace, open_records, open_trace
from .read.sections import Part, Section
from .write.chunks import chunk_of
from .write.line import PROFILE as LINE_PROFILE

ORIGINAL_SUFFIX = ".orig"
"""Suffix of a kept original; a number follows if that name exists."""


@dataclass(slots=True)
class Repair:
    """The result of a repair."""

    notes: list[str] = field(default_factory=list)  # defects of the trace; if there are none, it is unchanged
    scans: int | None = 0  # number of scans, without those left out; None for the trace of a serial line
    messages: int = 0  # number of messages, including scans
    original: Path | None = None  # path of the kept original; None if it is not kept, or still in its place

    @property
    def needed(self) -> bool:
        """Whether the trace had a defect."""
        return bool(self.notes)

    @property
    def damaged(self) -> int:
        """Number of chunks and other records that were left out because they can't be read."""
        return sum(isinstance(note, Damage) for note in self.notes)


def repair(
    path: Path | str, output: Path | str | None = None, *, progress: Callable[[int], None] = lambda size: None
) -> Repair:
    """Complete a trace.

    The original is kept, with the suffix `.orig`, unless the repaired trace begins with
    all of it, except a chunk in which it was cut off.

    Args:
        path: the trace, of scans or of a serial line.
        output: path of the repaired trace; None to replace the trace.
        progress: called at each record with the number of bytes read so far.

    Raises:
        TraceError: the file is not a trace, or of an unknown version; see `open_trace`.
        OwnedError: the file to replace is not a recording, or is being recorded.
        OSError: the repaired trace can't be written. The original is unchanged.
    """
    path = Path(realpath(path))
    target = path if output is None else Path(output)
    result = Repair()
    with _open(path) as trace, replacing(target, TRACE) as draft:
        rewriter = Rewriter(trace, draft.file, result, progress)
        rewriter.run()
        draft.file.flush()
        if not result.notes:
            result.notes += _misfits(trace, rewriter.library, draft.place, path)
        if result.needed:
            whole_end = trace.spans[-1].end
            is_kept = target == path and (result.damaged > 0 or not begin_alike(draft.place, path, whole_end))
            result.original = _free_name(path) if is_kept else None
            trace.close()  # Windows can't replace an open file
            _put_in_place(draft, path, result.original)
    return result


def _open(path: Path) -> Records:
    try:
        return open_trace(path, check=False)  # the rewriter reads each byte anyway
    except TraceLimitError:
        raise
    except TraceError:
        records = open_records(path)
        if _header(records).profile == LINE_PROFILE:
            return records
        records.close()
        raise


def _header(records: Records) -> Header:
    headers = [span for span in records.spans if span.opcode == Opcode.HEADER]
    return read_record(records.file, headers[0], Header.read) if headers else Header("", "")


def _misfits(trace: Records, library: str, made: Path, path: Path) -> Iterator[str]:
    """Yield the defects of a trace in which everything could be read.

    Our own traces are compared with a rewritten version; others are read by the stock reader.
    """
    if library.startswith(LIBRARY):
        if made.stat().st_size != path.stat().st_size or not begin_alike(made, path, trace.size):
            yield "its indexes or its end do not fit its contents"
        return
    try:
        trace.file.seek(0)
        for _ in make_reader(trace.file, validate_crcs=True).iter_messages(log_time_order=False):
            pass
    except BROKEN as error:
        yield f"the stock reader can't read it to its end: {error}"


def _put_in_place(draft: Draft, path: Path, original: Path | None) -> None:
    """Replace the trace by the repaired one; keep the original as `original`, if that is given."""
    shutil.copymode(path, draft.place)
    if original is not None:
        _give_name(path, original)
    try:
        draft.put()
    except OSError:
        if original is not None:
            original.unlink()
        raise


def _give_name(path: Path, other: Path) -> None:
    """Give a file a second name; copy it if the file system has no links."""
    try:
        os.link(path, other)
    except OSError:
        with path.open("rb") as source, new_file(other, TRACE, "wb") as file:
            shutil.copyfileobj(source, file)


def _free_name(path: Path) -> Path:
    names = (path.with_name(f"{path.name}{ORIGINAL_SUFFIX}{number or ''}") for number in count())
    return next(name for name in names if not name.exists())


class Rewriter:
    """Copies the whole records of a trace, and writes a new end.

    Args:
        result: receives counts and notes.
    """

    def __init__(
        self, trace: Records, file: IO[bytes], result: Repair, progress: Callable[[int], None]
    ) -> None:
        self._trace, self._file, self._result, self._progress = trace, file, result, progress
        self.library = _header(trace).library
        self._crc = 0
        self._sections = {section.span.offset: section for section in trace.sections}
        self._summary = Summary()
        self._guarded = list(_guarded(trace))
        self._registered = 0
        drafts = [span.offset for span in trace.spans if span.opcode == DRAFT]
        self._draft = min(drafts, default=trace.size)

    def run(self) -> None:
        """Write the repaired trace."""
        if not isinstance(self._trace, Trace):
            self._result.scans = None
        self._write(MAGIC)
        done = 0
        for span in self._data():
            self._record(span)
            self._progress(span.end - done)
            done = span.end
        self._file.write(self._summary.end(self._file.tell(), self._data_crc()))
        self._progress(self._trace.size - done)
        self._result.notes += self._trace.notes

    def _data(self) -> Iterator[Span]:
        """Yield the records before the end of the data: the first DataEnd that no message follows."""
        last_offset = max(self._sections, default=0)
        for span in self._trace.spans:
            if span.opcode == Opcode.DATA_END and span.offset > last_offset:
                return
            yield span

    def _data_crc(self) -> int:
        """Return the CRC to write; note a different CRC in the trace, if no other damage is known."""
        stored_crc = data_crc(self._trace.file, self._trace.spans)
        if stored_crc == 0 and ends_whole(self._trace.file, self._trace.spans):
            return 0  # its writer states no CRC
        if stored_crc not in (None, self._crc) and not any(
            isinstance(note, Damage) for note in self._trace.notes
        ):
            self._trace.note(DATA_DAMAGE)
        return self._crc

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._crc = zlib.crc32(data, self._crc)

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
                self._trace.note(note_of(error, "it is left out"))
            else:
                self._write(self._trace.raw(span))

    def _register(self) -> None:
        """Write the schemas and channels of the checksummed summary, unless that is done."""
        for record in self._guarded[self._registered :]:
            self._write(encoded(record))
            self._take(record)
            self._registered += 1

    def _take(self, record: Schema | Channel) -> None:
        """Add a schema or channel to the summary."""
        if isinstance(record, Schema):
            self._summary.schema(record)
        else:
            self._summary.channel(record)

    def _index(self, span: Span) -> None:
        """Add a record outside of chunks to the summary; raise a TraceError if it is damaged."""
        file, record_place = self._trace.file, (self._file.tell(), span.end - span.offset)
        if span.opcode == Opcode.SCHEMA:
            self._take(read_record(file, span, Schema.read))
        elif span.opcode == Opcode.CHANNEL:
            self._take(read_record(file, span, Channel.read))
        elif span.opcode == Opcode.METADATA:
            self._summary.metadata(*record_place, read_record(file, span, Metadata.read))
        elif span.opcode == Opcode.ATTACHMENT:
            self._summary.attachment(*record_place, read_attachment(file, span))

    def _section(self, section: Section) -> None:
        section_parts = self._trace.parts(section)
        if section_parts is None:
            return
        entries = self._entries(section_parts)
        if section.is_chunk:
            self._chunk(section, entries)
        elif section.span.offset > self._draft:
            self._write_chunk(chunk_of(self._trace.raw(section.span), *_bounds(entries)), entries)
        else:
            self._write(self._trace.raw(section.span))
            self._summary.messages(*_bounds(entries), entries)
        self._result.messages += sum(map(len, entries.values())) // 2
        if self._result.scans is not None and self._trace.shape.channel is not None:
            self._result.scans += len(entries.get(self._trace.shape.channel, ())) // 2

    def _chunk(self, section: Section, entries: Mapping[int, Entries]) -> None:
        """Copy a chunk and rebuild its times, which no checksum protects."""
        chunk = read_record(self._trace.file, section.span, Chunk.read)
        chunk.message_start_time, chunk.message_end_time = _bounds(entries)
        self._write_chunk(chunk, entries)

    def _write_chunk(self, chunk: Chunk, entries: Mapping[int, Entries]) -> None:
        content, start = encoded(chunk), self._file.tell()
        self._write(content + self._summary.chunk(start, len(content), chunk, entries))

    def _entries(self, parts: Sequence[Part]) -> dict[int, Entries]:
        """Return times and offsets of messages by channel; add schemas and channels to the summary."""
        entries: dict[int, Entries] = {}
        for part in parts:
            record = part.what
            if isinstance(record, Schema | Channel):
                self._take(record)
            elif isinstance(record, Message):
                entries.setdefault(record.channel, array("Q")).extend((record.log_time, part.offset))
            else:
                offsets = part.offset + self._trace.shape.stride * np.arange(len(record), dtype=np.uint64)
                rows = np.column_stack((record["log_time"], offsets.astype(np.uint64)))
                entries.setdefault(int(record["channel"][0]), array("Q")).frombytes(rows.tobytes())
        return {channel: entries[channel] for channel in sorted(entries)}


def _bounds(entries: Mapping[int, Entries]) -> tuple[int, int]:
    """Return the least and the greatest time of messages; both 0 if there are none."""
    times = [np.frombuffer(entry, np.uint64)[::2] for entry in entries.values()] or [np.zeros(1, np.uint64)]
    return min(int(stamps.min()) for stamps in times), max(int(stamps.max()) for stamps in times)


def _guarded(trace: Records) -> Iterator[Schema | Channel]:
    """Yield the schemas and channels in a trace's summary, each schema before its channels.

    Schemas and channels at the beginning of the file have no checksum.
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
    Opcode.DATA_END,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
    DRAFT,
}
"""Records that are rebuilt, or copied with their section."""
