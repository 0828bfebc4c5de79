"""Repairs a trace that is damaged or has no end, by copying complete records and rebuilding the rest.

    head | chunk | index | chunk | index | chu                      the process was killed here
    head | chunk | index | chunk | index | summary | footer         after repair

Complete records are copied unchanged. The indexes and the end are rebuilt. A trace that only lacks its end
therefore becomes identical to a complete recording. The repaired trace is written next to the original and
flushed to the disk before it replaces the original. The original is kept, unless the repaired trace begins
with the whole original except a torn end.
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

    notes: list[str] = field(default_factory=list)  # defects of the trace; without any, it is unchanged
    scans: int | None = 0  # number of copied scans; None for the trace of a serial line
    messages: int = 0  # number of copied messages, including scans
    original: Path | None = None  # path of the renamed original; None if it was not renamed

    @property
    def needed(self) -> bool:
        """Whether the trace had a defect."""
        return bool(self.notes)

    @property
    def damaged(self) -> int:
        """Number of chunks and other records that were omitted because they are unreadable."""
        return sum(isinstance(note, Damage) for note in self.notes)


def repair(
    path: Path | str, output: Path | str | None = None, *, progress: Callable[[int], None] = lambda size: None
) -> Repair:
    """Repair a trace; a trace without defects is left unchanged, and `output` is not written.

    A replaced original is kept with the suffix `.orig`, unless the repaired trace begins with the whole
    original except a chunk that was cut off.

    Args:
        path: the trace of scans or of a serial line.
        output: path of the repaired trace; None to replace the trace.
        progress: called for each record with the number of bytes read since the last call.

    Raises:
        TraceError: the file is not a trace, or has an unknown version; see `open_trace`.
        OwnedError: the file to replace is not a recording, or is being recorded.
        OSError: the repaired trace can't be written. The original is unchanged.
    """
    path = Path(realpath(path))
    target = path if output is None else Path(output)
    with _open(path) as trace, replacing(target, TRACE) as draft:
        result = Rewriter(trace, draft.file, progress).run()
        draft.file.flush()
        if not result.notes:
            result.notes += _index_defects(trace, draft.path, path)
        if not result.needed:
            return result
        last_record_end = trace.spans[-1].end
        if target == path and (result.damaged or not begin_alike(draft.path, path, last_record_end)):
            result.original = _free_name(path)
        trace.close()  # Windows can't replace an open file
        _replace_trace(draft, path, result.original)
    return result


def _open(path: Path) -> Records:
    """Open the trace of a rack or of a serial line; raise a TraceError for any other file."""
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


def _index_defects(trace: Records, rewritten: Path, path: Path) -> list[str]:
    """Return the defects of the indexes and the end of a trace whose messages are all readable.

    A trace from scanrack must equal the rewritten trace. The `mcap` reader checks traces from other writers.
    """
    if _header(trace).library.startswith(LIBRARY):
        is_same_size = rewritten.stat().st_size == path.stat().st_size
        is_equal = is_same_size and begin_alike(rewritten, path, trace.size)
        return [] if is_equal else ["its indexes or its end do not fit its contents"]
    try:
        trace.file.seek(0)
        for _ in make_reader(trace.file, validate_crcs=True).iter_messages(log_time_order=False):
            pass
    except BROKEN as error:
        return [f"the stock reader can't read it to its end: {error}"]
    return []


def _replace_trace(draft: Draft, path: Path, original: Path | None) -> None:
    """Replace the target with the repaired trace; first keep the old trace at `original`, unless None."""
    shutil.copymode(path, draft.path)
    if original is not None:
        _add_name(path, original)
    try:
        draft.replace_target()
    except OSError:
        if original is not None:
            original.unlink()
        raise


def _add_name(path: Path, new_name: Path) -> None:
    """Add a second name to a file; copy the file if the file system has no links."""
    try:
        os.link(path, new_name)
    except OSError:
        with path.open("rb") as source, new_file(new_name, TRACE, "wb") as file:
            shutil.copyfileobj(source, file)


def _free_name(path: Path) -> Path:
    """Return the first unused name for the original: `NAME.orig`, `NAME.orig1`, `NAME.orig2`."""
    names = (path.with_name(f"{path.name}{ORIGINAL_SUFFIX}{number or ''}") for number in count())
    return next(name for name in names if not name.exists())


class Rewriter:
    """Copies the complete records of a trace, and writes a new end."""

    def __init__(self, trace: Records, file: IO[bytes], progress: Callable[[int], None]) -> None:
        self._trace, self._file, self._progress = trace, file, progress
        self._result = Repair(scans=0 if isinstance(trace, Trace) else None)
        self._crc = 0  # of the data written so far
        # by offset of the first record
        self._sections = {section.span.offset: section for section in trace.sections}
        self._summary = Summary()
        summary_records = list(_checksummed_records(trace))
        self._has_checksummed = bool(summary_records)
        self._unwritten_checksummed = iter(summary_records)
        # messages after a draft's record belong to a chunk that was not finished
        drafts = [span.offset for span in trace.spans if span.opcode == DRAFT]
        self._draft_offset = min(drafts, default=trace.size)

    def run(self) -> Repair:
        """Write the repaired trace; return the counts and the defects."""
        self._write(MAGIC)
        reported_end = 0
        for span in self._data_records():
            self._copy_record(span)
            self._progress(span.end - reported_end)
            reported_end = span.end
        self._file.write(self._summary.end(self._file.tell(), self._checked_crc()))
        self._progress(self._trace.size - reported_end)
        self._result.notes += self._trace.notes
        return self._result

    def _data_records(self) -> Iterator[Span]:
        """Yield the records before the end of the data: the first DataEnd without messages after it."""
        last_section = max(self._sections, default=0)
        for span in self._trace.spans:
            if span.opcode == Opcode.DATA_END and span.offset > last_section:
                return
            yield span

    def _checked_crc(self) -> int:
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

    def _copy_record(self, span: Span) -> None:
        """Copy a record; skip and note a damaged one."""
        section = self._sections.get(span.offset)
        if section is not None:
            self._copy_section(section)
        elif span.opcode in (Opcode.SCHEMA, Opcode.CHANNEL) and self._has_checksummed:
            self._write_checksummed()
        elif span.opcode not in _NOT_COPIED:
            try:
                self._summarize(span)
            except TraceError as error:
                self._trace.note(note_of(error, "it is left out"))
            else:
                self._write(self._trace.raw(span))

    def _write_checksummed(self) -> None:
        """On the first call, write all schemas and channels of the checksummed summary."""
        for record in self._unwritten_checksummed:
            self._write(encoded(record))
            self._summary.register(record)

    def _summarize(self, span: Span) -> None:
        """Add a record outside of chunks to the summary; raise a TraceError if it is damaged."""
        file, offset, length = self._trace.file, self._file.tell(), span.end - span.offset
        if span.opcode == Opcode.SCHEMA:
            self._summary.register(read_record(file, span, Schema.read))
        elif span.opcode == Opcode.CHANNEL:
            self._summary.register(read_record(file, span, Channel.read))
        elif span.opcode == Opcode.METADATA:
            self._summary.metadata(offset, length, read_record(file, span, Metadata.read))
        elif span.opcode == Opcode.ATTACHMENT:
            self._summary.attachment(offset, length, read_attachment(file, span))

    def _copy_section(self, section: Section) -> None:
        """Copy a chunk or messages outside of chunks; compress the messages of a draft to a chunk."""
        section_parts = self._trace.parts(section)
        if section_parts is None:
            return
        entries = self._entries(section_parts)
        bounds = _time_bounds(entries)
        if section.is_chunk:
            chunk = read_record(self._trace.file, section.span, Chunk.read)
            chunk.message_start_time, chunk.message_end_time = bounds  # no checksum protects the old times
            self._write_chunk(chunk, entries)
        elif section.span.offset > self._draft_offset:
            self._write_chunk(chunk_of(self._trace.raw(section.span), *bounds), entries)
        else:
            self._write(self._trace.raw(section.span))
            self._summary.messages(*bounds, entries)
        self._result.messages += sum(map(len, entries.values())) // 2
        if self._result.scans is not None and self._trace.shape.channel is not None:
            self._result.scans += len(entries.get(self._trace.shape.channel, ())) // 2

    def _write_chunk(self, chunk: Chunk, entries: Mapping[int, Entries]) -> None:
        content, start = encoded(chunk), self._file.tell()
        self._write(content + self._summary.chunk(start, len(content), chunk, entries))

    def _entries(self, parts: Sequence[Part]) -> dict[int, Entries]:
        """Return the times and offsets of messages by channel; add schemas and channels to the summary."""
        entries: dict[int, Entries] = {}
        for part in parts:
            content = part.content
            if isinstance(content, Schema | Channel):
                self._summary.register(content)
            elif isinstance(content, Message):
                entries.setdefault(content.channel, array("Q")).extend((content.log_time, part.offset))
            else:  # successive scans
                offsets = part.offset + self._trace.shape.stride * np.arange(len(content), dtype=np.uint64)
                rows = np.column_stack((content["log_time"], offsets.astype(np.uint64)))
                entries.setdefault(int(content["channel"][0]), array("Q")).frombytes(rows.tobytes())
        return {channel: entries[channel] for channel in sorted(entries)}


def _time_bounds(entries: Mapping[int, Entries]) -> tuple[int, int]:
    """Return the earliest and the latest time of messages; both are 0 without messages."""
    times = [np.frombuffer(entry, np.uint64)[::2] for entry in entries.values()] or [np.zeros(1, np.uint64)]
    return min(int(stamps.min()) for stamps in times), max(int(stamps.max()) for stamps in times)


def _checksummed_records(trace: Records) -> Iterator[Schema | Channel]:
    """Yield the schemas and channels in a trace's summary, each schema before its channels.

    Their copies at the beginning of the file have no checksum.
    """
    summary_start = sound_summary(trace.file, trace.spans)
    if summary_start is None:
        return
    spans = [span for span in trace.spans if span.offset >= summary_start]
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
"""Types of records that are rebuilt or copied with their section."""
