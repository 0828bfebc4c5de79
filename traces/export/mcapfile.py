"""Copies a trace and adds decoded values for any viewer: position, speed and status bits of each stepper.

    scan, flags, slots, tags      as recorded, byte for byte
    decoded                       after them, see `traces.decoded`

Our own reader reads the copy like the recording, because it ignores fields after `tags`.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
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
_PREAMBLE_BYTES = 9
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
        selection: events of other scans are left out.
        progress: called at each block with the number of scans read so far.

    Raises:
        ValueError: no slot of the trace has a stepper's words.
        EmptySelectionError: no scan is in the selection.
        OSError: the copy can't be written.
    """
    head = trace.head
    tags = None if head.tags is None else head.tags.dtype
    memory_bytes = head.layout.size
    own_bytes = memory_bytes + (0 if tags is None else tags.itemsize)
    decoded = DecodedValues(head.slots, SCAN_HEAD.size - 4 + own_bytes, NumberFormats.of(trace))
    schema = scan_schema(head.slots, head.tags, (FIELD, decoded.messages))
    layout = message_layout(memory_bytes, tags, decoded.dtype)
    rows = Rows(decoded.rows(block) for block in blocks(trace, selection, progress=progress))
    rows.fill()  # an empty selection is refused before there is a file
    with new_file(path, TRACE, "wb") as file:
        copy = Copy(trace, CountingFile(file), schema, layout)
        for section in trace.sections:
            for entry in trace.entries(section):
                if isinstance(entry, TraceEvent):
                    copy.event(entry, selection)
                else:
                    is_inside = selection.has(entry["scan"], entry["log_time"])
                    copy.scans(entry if is_inside.all() else entry[is_inside], rows)
        copy.finish()
    return copy.count


class CountingFile:
    """An open file that counts the bytes written, because a pipe has no position.

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


class Rows:
    """Decoded rows, regrouped in portions of any size.

    Args:
        blocks: the rows, block by block.
    """

    def __init__(self, blocks: Iterator[NDArray[Any]]) -> None:
        self._blocks = blocks
        self._held: NDArray[Any] | None = None

    def fill(self) -> NDArray[Any]:
        """Return the remaining rows of a block, or the rows of the next block."""
        if self._held is None or not len(self._held):
            self._held = next(self._blocks)
        return self._held

    def take(self, count: int) -> Iterator[NDArray[Any]]:
        """Yield the next `count` rows."""
        while count:
            taken = self.fill()[:count]
            self._held = self.fill()[len(taken) :]
            count -= len(taken)
            yield taken


class Copy:
    """Writes the copy of a trace."""

    def __init__(
        self, trace: Trace, file: CountingFile, schema: ScanSchema, layout: np.dtype[np.void]
    ) -> None:
        self.count = 0
        self._layout = layout
        self._copied = [name for name in layout.names or () if name != "rest"]
        library = trace.head.library
        self._writer = ChunkWriter(file, profile=PROFILE, library=library, chunk_bytes=CHUNK_BYTES)
        topics = [topic for topic in ALL_TOPICS if topic.name in trace.head.channels]
        self._channels = self._writer.register(schema, topics)
        for record in _metadata(trace):
            tag_metadata = {"format": str(FORMAT_WITH_TAGS), "layout": schema.layout}
            own_fields = tag_metadata if record.name == METADATA else {}
            self._writer.add_metadata(record.name, {**record.metadata, **own_fields})
        for file_with in trace.attachments():
            self._writer.add_attachment(file_with.name, file_with.media_type, file_with.data)

    def scans(self, recorded: ScanRows, decoded: Rows) -> None:
        """Write scans, each followed by the next decoded row."""
        start = 0
        for decoded_rows in decoded.take(len(recorded)):
            rows = np.zeros(len(decoded_rows), self._layout)
            source = recorded[start : start + len(decoded_rows)]
            for name in self._copied:
                rows[name] = source[name]
            rows["length"] = self._layout.itemsize - _PREAMBLE_BYTES
            rows["channel"] = self._channels[SCAN_TOPIC]
            rows["rest"] = decoded_rows
            times = array("Q", rows["log_time"].tobytes())
            self._writer.add_block(self._channels[SCAN_TOPIC], times, bytearray(rows.tobytes()))
            start += len(decoded_rows)
        self.count += len(recorded)

    def event(self, event: TraceEvent, selection: Selection) -> None:
        """Write an event of a selected scan; texts and steps are always written, as later scans need them."""
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
    holds="a copy of the trace with [decoded values](traces.md#decoded-values) in every scan",
    reader="Foxglove, Lichtblick, any MCAP reader",
    binary=True,
    chooses=False,
)
