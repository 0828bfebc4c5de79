"""Copies a trace with each stepper's decoded position, speed and status bits, for any viewer.

    scan, flags, slots, tags      as recorded, byte for byte
    decoded                       after them, see `export.decoded`

`open_trace` reads the copy like the original recording, because it ignores fields after `tags`.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from itertools import chain
from typing import IO, Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Metadata
from numpy.typing import NDArray

from ..files.guard import TRACE
from ..files.newfile import Target, new_file
from ..format.message_layout import message_layout
from ..format.records import read_record
from ..format.schema import FORMAT_WITH_TAGS, METADATA, PROFILE, SCAN_HEAD, ScanSchema, scan_schema
from ..format.topics import ALL_TOPICS, SCAN_TOPIC, SEQUENCES, TEXTS
from ..read.number_formats import NumberFormats
from ..read.reader import Trace, TraceEvent
from ..read.sections import ScanRows
from ..signals import ALL, Selection, blocks
from ..write.chunks import ChunkWriter
from .decoded import FIELD, DecodedValues
from .format import ExportFormat

CHUNK_BYTES = 1 << 20
CDR_PREFIX_BYTES = 4
"""Size of `CDR_PREFIX` in bytes; CDR aligns fields relative to the byte after it."""

_PREAMBLE_BYTES = 9  # opcode and length of a record, which its length does not include
_NEEDED_LATER = (TEXTS.name, SEQUENCES.name)


def write_mcap(
    trace: Trace,
    path: Target,
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> int:
    """Write a copy of a trace with decoded values in every scan; return the number of scans.

    Args:
        path: the file, or an open binary stream.
        selection: scans to copy, with their events.
        progress: called for each block with the number of scans read so far.

    Raises:
        ValueError: no slot of the trace has a stepper's words.
        EmptySelectionError: no scan is in the selection.
        OSError: the copy can't be written.
    """
    head = trace.head
    tags = None if head.tags is None else head.tags.dtype
    tag_bytes = 0 if tags is None else tags.itemsize
    decoded_offset = SCAN_HEAD.size - CDR_PREFIX_BYTES + head.layout.size + tag_bytes
    decoded = DecodedValues(head.slots, decoded_offset, NumberFormats.of(trace))
    schema = scan_schema(head.slots, head.tags, (FIELD, decoded.messages))
    layout = message_layout(head.layout.size, tags, decoded.dtype)
    decoded_rows = DecodedRows(decoded.rows(block) for block in blocks(trace, selection, progress=progress))
    decoded_rows.read_block()  # raises EmptySelectionError before the file is created
    with new_file(path, TRACE, "wb") as file:
        copy = CopyWriter(trace, CountingFile(file), schema, layout)
        for entry in chain.from_iterable(map(trace.entries, trace.sections)):
            if isinstance(entry, TraceEvent):
                copy.add_event(entry, selection)
            else:
                is_selected = selection.has(entry["scan"], entry["log_time"])
                copy.add_scans(entry if is_selected.all() else entry[is_selected], decoded_rows)
        copy.finish()
    return copy.scans


class CountingFile:
    """An open file that counts the written bytes, because a pipe has no position.

    Args:
        file: the file, open for writing bytes.
    """

    def __init__(self, file: IO[Any]) -> None:
        self._file, self._size = file, 0

    def write(self, data: bytes, /) -> int:
        """Write bytes."""
        self._file.write(data)
        self._size += len(data)
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._size


class DecodedRows:
    """Decoded rows, regrouped into portions of any size.

    Args:
        blocks: the rows, block by block.
    """

    def __init__(self, blocks: Iterator[NDArray[Any]]) -> None:
        self._blocks = blocks
        self._remaining: NDArray[Any] | None = None  # rows of the last block that `take` has not yielded

    def read_block(self) -> NDArray[Any]:
        """Return the remaining rows of a block, or the rows of the next block."""
        if self._remaining is None or not len(self._remaining):
            self._remaining = next(self._blocks)
        return self._remaining

    def take(self, count: int) -> Iterator[NDArray[Any]]:
        """Yield the next `count` rows."""
        while count:
            available_rows = self.read_block()
            rows, self._remaining = available_rows[:count], available_rows[count:]
            count -= len(rows)
            yield rows


class CopyWriter:
    """Writes a trace's metadata and attachments, and then its scans and events in order.

    Args:
        schema: schema of /scan with the decoded values.
        layout: layout of a scan's message record, with the decoded values as its field `rest`.

    Attributes:
        scans: number of scans written.
    """

    def __init__(
        self, trace: Trace, file: CountingFile, schema: ScanSchema, layout: np.dtype[np.void]
    ) -> None:
        self.scans = 0
        self._layout = layout
        self._recorded_fields = [name for name in layout.names or () if name != "rest"]
        library = trace.head.library
        self._writer = ChunkWriter(file, profile=PROFILE, library=library, chunk_bytes=CHUNK_BYTES)
        topics = [topic for topic in ALL_TOPICS if topic.name in trace.head.channels]
        self._channels = self._writer.register(schema, topics)
        new_format = {"format": str(FORMAT_WITH_TAGS), "layout": schema.layout}
        for record in _metadata(trace):
            replaced_fields = new_format if record.name == METADATA else {}
            self._writer.add_metadata(record.name, {**record.metadata, **replaced_fields})
        for attachment in trace.attachments():
            self._writer.add_attachment(attachment.name, attachment.media_type, attachment.data)

    def add_scans(self, recorded: ScanRows, decoded: DecodedRows) -> None:
        """Write scans, each followed by the next decoded row."""
        start = 0
        for decoded_rows in decoded.take(len(recorded)):
            rows = np.zeros(len(decoded_rows), self._layout)
            recorded_rows = recorded[start : start + len(decoded_rows)]
            for name in self._recorded_fields:
                rows[name] = recorded_rows[name]
            rows["length"] = self._layout.itemsize - _PREAMBLE_BYTES
            rows["channel"] = self._channels[SCAN_TOPIC]
            rows["rest"] = decoded_rows
            times = array("Q", rows["log_time"].tobytes())
            self._writer.add_block(self._channels[SCAN_TOPIC], times, bytearray(rows.tobytes()))
            start += len(decoded_rows)
        self.scans += len(recorded)

    def add_event(self, event: TraceEvent, selection: Selection) -> None:
        """Write an event if its scan is selected. Always write texts and steps; later scans need them."""
        if event.topic in _NEEDED_LATER or selection.has(event.scan, event.now_ns):
            self._writer.add_event(self._channels[event.topic], event.scan, event.now_ns, event.fields)

    def finish(self) -> None:
        """Write the summary and the footer."""
        self._writer.finish()


def _metadata(trace: Trace) -> Iterator[Metadata]:
    for span in trace.spans:
        if span.opcode == Opcode.METADATA:
            yield read_record(trace.file, span, Metadata.read)


FORMAT = ExportFormat(
    name="mcap",
    kind=TRACE,
    write=write_mcap,
    help="Write a copy with decoded position, speed and bits of each stepper, for any viewer.",
    contents="a copy of the trace with [decoded values](traces.md#decoded-values) in every scan",
    reader="Foxglove, Lichtblick, any MCAP reader",
    binary=True,
    selects_signals=False,
)
