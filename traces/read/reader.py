"""Reads a trace: its head, its scans and its events.

    with open_trace(path) as trace:
        for scan in trace.scans():
            scan.inputs(1)[2]              # slot 1, input word 2

A killed process leaves a trace without an end, which is read up to its last complete chunk, with a note in
`notes`. A damaged chunk is skipped and noted.
"""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple, Self, TypeVar

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Schema
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.io_images.image import Image
from scanrack.io_images.memory_layout import ImagePlaces
from scanrack.io_images.times import seconds_column
from typing_extensions import override

from ..files.locking import is_being_recorded
from ..format import hooks
from ..format.records import (
    DRAFT,
    MAGIC,
    Damage,
    Message,
    Span,
    TraceError,
    TraceLimitError,
    attachment_name,
    note_of,
    read_attachment,
)
from ..format.schema import LIBRARY, SCAN_HEAD
from ..format.tagplan import FIELD
from ..format.topics import ALL_TOPICS, SCAN_TOPIC, TEXTS
from .finding import DATA_DAMAGE, UNDER_WAY, data_damage, ends_whole, find_records, summary_damage
from .head import read_head
from .sections import Part, ScanRows, ScanShape, Section, find_sections, lost_scans, take_apart, torn_chunk

if TYPE_CHECKING:
    import numpy as np
    import pandas
    import polars
    from numpy.typing import NDArray

CHECKED_BYTES = 256 * 1024 * 1024
"""Maximum size of a trace that is checked when it is opened, bytes.

A larger trace is checked only by commands that run the programs named in its metadata.
"""

ENDED = "its recording was ended from outside, or by os._exit; scanrack repair completes it"


class Scan(NamedTuple):
    """One scan."""

    scan: int  # its number (modulo 2**32)
    now_ns: int
    flags: int
    memory: bytes  # the rack's memory block: per slot the output image, then the input image
    places: Mapping[int, ImagePlaces]  # images in the memory block by slot number
    tags: bytes = b""  # the row of tags; empty without any

    def outputs(self, slot: int) -> Image:
        """Return a copy of a slot's output image (logic to module); KeyError if there is none."""
        return self._image(self.places[slot].outputs)

    def inputs(self, slot: int) -> Image:
        """Return a copy of a slot's input image (module to logic); KeyError if there is none."""
        return self._image(self.places[slot].inputs)

    def _image(self, span: slice) -> Image:
        return Image(buffer=bytearray(self.memory[span]))


@dataclass(frozen=True, slots=True)
class TraceEvent:
    """A message other than a scan."""

    scan: int  # number of the scan that reported it
    now_ns: int
    topic: str  # such as "/events", "/stimuli", "/indicators", "/forces", "/cpu", "/faults"
    fields: Mapping[str, object]  # its values by name, without the scan


class Records:
    """A file of records, with any topics, open for reading.

    Args:
        grows: whether the file is being recorded; if so, the draft at its end is ignored, since it may
            disappear at any time.

    Attributes:
        size: size of the file without an ignored draft, bytes.
        notes: the defects of the file; a damaged chunk is noted when it is read.
        spans: locations of the file's complete records, in order.
        sections: locations of the messages, in file order.
        shape: layout of the scans in the sections; here, a layout without scans.

    Raises:
        TraceError: the file is not an MCAP file.
        TraceLimitError: it has more records than the limits allow.
    """

    def __init__(self, file: BinaryIO, size: int, *, grows: bool = False) -> None:
        self.file = file
        if file.read(len(MAGIC)) != MAGIC:
            raise TraceError("it is not an MCAP file")
        self._grows = grows
        self._is_data_checked = False
        self.size, self.spans, self.notes = self._find_records(size)
        if any(span.opcode == DRAFT for span in self.spans):
            self.notes.insert(0, ENDED)
        # the last note is about a missing end; `follow` replaces it
        self._end_notes = [] if ends_whole(file, self.spans) else self.notes[-1:]
        self.sections = find_sections(file, self.spans)
        self.shape = ScanShape(None, 0)
        if damage := summary_damage(file, self.spans):
            self.notes.append(f"{damage}; its contents are not used")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    @property
    def may_grow(self) -> bool:
        """Whether the file can still grow, because it has no end yet."""
        return bool(self._end_notes)

    def follow(self) -> bool:
        """Read the new records of a file without an end; return whether there were any.

        Raises:
            TraceLimitError: it has more records than the limits allow.
        """
        size = os.fstat(self.file.fileno()).st_size
        if size <= self.size or not self._end_notes:
            return False
        end_before = self.spans[-1].end if self.spans else 0
        first_span = self._last_chunk()  # new records may belong to it
        self.size, self.spans, notes = self._find_records(size, self.spans[:first_span])
        self.notes = [note for note in self.notes if note not in self._end_notes]
        self.notes += [note for note in notes if note not in self.notes]
        self._end_notes = [] if ends_whole(self.file, self.spans) else notes[-1:]
        first_offset = self.spans[first_span].offset if first_span < len(self.spans) else self.size
        self.sections = [section for section in self.sections if section.span.offset < first_offset]
        self.sections += find_sections(self.file, self.spans[first_span:])
        return bool(self.spans) and self.spans[-1].end > end_before

    def _last_chunk(self) -> int:
        """Return the index of the last chunk among the records; 0 if there is none."""
        indexes = range(len(self.spans) - 1, -1, -1)
        return next((index for index in indexes if self.spans[index].opcode == Opcode.CHUNK), 0)

    def _find_records(self, size: int, first_spans: Sequence[Span] = ()) -> tuple[int, list[Span], list[str]]:
        """Return the size of the file without a draft, its records, and its defects.

        Args:
            first_spans: records at the beginning of the file that are already known.
        """
        if self._grows:
            self.file.seek(0, os.SEEK_END)  # drops buffered data, which a chunk may have replaced
        spans, notes = find_records(self.file, size, first_spans, drafts=not self._grows)
        is_under_way = bool(notes) and notes[-1] == UNDER_WAY
        return (spans[-1].end if is_under_way and spans else size), spans, notes

    def parts(self, section: Section) -> list[Part] | None:
        """Split a section into parts; note a damaged section and return None.

        Raises:
            TraceLimitError: the section unpacks to more bytes, or has more records, than the limits allow.
        """
        try:
            return take_apart(self.file, section, self.shape)
        except TraceLimitError:
            raise
        except TraceError as error:
            self.note(note_of(error, f"{lost_scans(self.shape, section)} are left out"))
            return None

    def check_data(self) -> None:
        """Note once if the CRC of all data is wrong, unless damage is already known.

        Only this CRC protects the metadata. The whole file is read: 1 GB takes about 1 s.
        """
        if self._is_data_checked or any(isinstance(note, Damage) for note in self.notes):
            return
        self._is_data_checked = True
        if damage := data_damage(self.file, self.spans):
            self.note(damage)

    def raw(self, span: Span) -> bytes:
        """Return the bytes of a record."""
        self.file.seek(span.offset)
        return self.file.read(span.end - span.offset)

    def note(self, note: str) -> None:
        """Add a note unless it already exists. A note about specific damage replaces a general note."""
        if note in self.notes:
            return
        if isinstance(note, Damage) and DATA_DAMAGE in self.notes:
            self.notes.remove(DATA_DAMAGE)
        self.notes.append(note)


class Trace(Records):
    """A trace of scans, open for reading. Each iteration starts at the beginning of the trace.

    Args:
        file: the file, open for reading; it is closed with the trace.
        grows: see `Records`.
        check: whether to check the data of a file of up to `CHECKED_BYTES`, see `check_data`.

    Attributes:
        shape: layout of the scans in its sections.

    Raises:
        TraceError: the file is not a trace, or has an unknown version.
    """

    def __init__(self, file: BinaryIO, size: int, *, grows: bool = False, check: bool = True) -> None:
        super().__init__(file, size, grows=grows)
        try:
            self.head = read_head(file, self.spans)
        except TraceLimitError:
            raise
        except TraceError as error:
            raise TraceError("; ".join([str(error), *self.notes])) from error
        self._topics = {channel.id: topic for topic, channel in self.head.channels.items()}
        self._first_scans: dict[int, int] = {}  # number of the first scan by section, see `first_scan`
        tags = None if self.head.tags is None else self.head.tags.dtype
        memory_bytes = self.head.layout.size
        rest_bytes = self.head.rest_bytes
        self._scan_bytes = SCAN_HEAD.size + memory_bytes + (0 if tags is None else tags.itemsize) + rest_bytes
        self.shape = ScanShape(self.head.channels[SCAN_TOPIC].id, memory_bytes, tags, rest_bytes)
        self._leave_out_repeated()
        self._note_where_it_ends()
        if check and size <= CHECKED_BYTES:
            self.check_data()

    @override
    def follow(self) -> bool:
        """Read the new records, see `Records.follow`; update the data that depends on the last sections."""
        size, grown = self.size, super().follow()
        self._leave_out_repeated()
        if self.size > size:
            section_count = len(self.sections)
            # a section that no scan followed may have one now
            self._first_scans = {
                index: scan
                for index, scan in self._first_scans.items()
                if scan < _NO_SCAN and index < section_count
            }
            self._note_where_it_ends()
        return grown

    def _leave_out_repeated(self) -> None:
        """Skip and note chunks that repeat an earlier chunk's times and size, which no recorder writes."""
        kept_sections: dict[tuple[int, ...], Section] = {}
        for section in self.sections:
            has_duration = section.is_chunk and section.start_ns < section.end_ns
            key = (section.start_ns, section.end_ns, section.size) if has_duration else (section.span.offset,)
            if kept_sections.setdefault(key, section) is not section:
                scans = lost_scans(self.shape, section)
                self.note(
                    f"the chunk at byte {section.span.offset:,} repeats an earlier one: {scans} are left out"
                )
        self.sections = list(kept_sections.values())

    def __iter__(self) -> Iterator[Scan | TraceEvent]:
        """Iterate over scans and events in file order; damaged parts are noted and skipped."""
        for section in self.sections:
            for entry in self.entries(section):
                if isinstance(entry, TraceEvent):
                    yield entry
                else:
                    yield from self.as_scans(entry)

    def entries(self, section: Section) -> Iterator[ScanRows | TraceEvent]:
        """Iterate over a section, yielding successive scans as an array, and events."""
        for message in self._messages(section):
            if isinstance(message, Message):
                yield from self._events(message, section)
            else:
                yield message

    def __repr__(self) -> str:
        return hooks.short_text(self)

    def _repr_html_(self) -> str:
        """Return the trace as HTML for a notebook, with name, length, position, rules and faults."""
        return hooks.as_html(self)

    def to_pandas(self, *signals: str) -> pandas.DataFrame:
        """Return the trace as a pandas DataFrame, see `traces.export.to_pandas`."""
        frame: pandas.DataFrame = hooks.to_pandas(self, signals)
        return frame

    def to_polars(self, *signals: str) -> polars.DataFrame:
        """Return the trace as a Polars DataFrame, see `traces.export.to_polars`."""
        frame: polars.DataFrame = hooks.to_polars(self, signals)
        return frame

    def by_name(self) -> NDArray[np.void]:
        """Return each word in every scan: `trace.by_name()["slot1"]["in"]["position_msw"]`, int16."""
        from .columns import by_name

        return by_name(hooks.read_columns(self).words, self.head.slots)

    def scans(self) -> Iterator[Scan]:
        """Iterate over the scans."""
        return (entry for entry in self if isinstance(entry, Scan))

    def events(
        self, start_ns: int = 0, end_ns: int | None = None, topics: Collection[str] | None = None
    ) -> Iterator[TraceEvent]:
        """Iterate over the events. Only chunks that can contain selected events are read.

        Args:
            start_ns: chunks that end before this time are skipped.
            end_ns: chunks that begin after this time are skipped; None = no limit.
            topics: topics of the selected events; None = all.
        """
        for section in self.sections:
            is_late = end_ns is not None and section.start_ns > end_ns
            if not (is_late or section.end_ns < start_ns) and self.may_contain(section, topics):
                yield from self.events_in(section, topics)

    def events_in(self, section: Section, topics: Collection[str] | None = None) -> Iterator[TraceEvent]:
        """Read a section and iterate over its events.

        Args:
            topics: topics of the selected events; None = all.
        """
        for event in self._events_among(self._messages(section), section):
            if topics is None or event.topic in topics:
                yield event

    def scans_and_events(self, section: Section) -> tuple[list[ScanRows], list[TraceEvent]]:
        """Return the scans and the events of a section; the section is read only once."""
        messages = self._messages(section)
        return _rows_of(messages), list(self._events_among(messages, section))

    def may_contain(self, section: Section, topics: Collection[str] | None = None) -> bool:
        """Return whether a section can contain events, without reading it.

        The answer comes from the section's indexes, unless the file is damaged or more indexes may follow at
        its end.

        Args:
            topics: topics of the selected events; None = all.
        """
        if self.shape.only_scans(section):
            return False
        is_index_whole = self.spans[-1].opcode != Opcode.MESSAGE_INDEX or section is not self.sections[-1]
        is_damaged = any(isinstance(note, Damage) for note in self.notes)
        if topics is None or is_damaged or not (is_index_whole and section.counts):
            return True
        return any(section.counts.get(number) for number, name in self._topics.items() if name in topics)

    def texts(self) -> dict[int, str]:
        """Return the meanings of the codes of recorded texts."""
        if TEXTS.name not in self.head.channels:
            return {}
        texts = {}
        for event in self.events(topics={TEXTS.name}):
            code = event.fields.get("code")
            if isinstance(code, int):
                texts[code] = str(event.fields.get("text", ""))
        return texts

    def scan_rows(self, section: Section) -> list[ScanRows]:
        """Return the scans of a section as arrays; a damaged section is noted and treated as empty."""
        return _rows_of(self._messages(section))

    def as_scans(self, rows: ScanRows) -> Iterator[Scan]:
        """Iterate over the scans of an array."""
        size = rows.dtype["images"].itemsize
        memory = rows["images"].tobytes()
        tags = [row.tobytes() for row in rows[FIELD]] if FIELD in (rows.dtype.names or ()) else None
        columns = (rows[name].tolist() for name in ("scan", "log_time", "flags"))
        places = self.head.layout.places
        for index, (scan, now_ns, flags) in enumerate(zip(*columns, strict=True)):
            block = memory[index * size : index * size + size]
            yield Scan(scan, now_ns, flags, block, places, tags[index] if tags else b"")

    def edge(self, *, last: bool) -> ScanRows | None:
        """Return the first or last scan as an array with one row; None for a trace without scans."""
        for section in reversed(self.sections) if last else self.sections:
            if row_arrays := self.scan_rows(section):
                return row_arrays[-1][-1:] if last else row_arrays[0][:1]
        return None

    def first_scan(self, index: int) -> int:
        """Return the number of the first scan in section `index` or a later one; 2**32 if no scan follows."""
        if index not in self._first_scans:
            first_rows = (rows for section in self.sections[index:] for rows in self.scan_rows(section)[:1])
            rows = next(first_rows, None)
            self._first_scans[index] = _NO_SCAN if rows is None else int(rows["scan"][0])
        return self._first_scans[index]

    def place_of(self, scan: int) -> int:
        """Return the index of the last section that begins at or before this scan; -1 if there is none.

        The search starts at an estimated index and doubles its steps, so that it reads few sections.
        """
        # section `low` begins with `scan` or an earlier scan, section `high` with a later one
        low, high = -1, len(self.sections)
        index, step = self._estimated_index(scan), 1
        while high - low > 1:
            if self.first_scan(index) <= scan:
                low, index = index, index + step
            else:
                high, index = index, index - step
            if not low < index < high:
                index = (low + high) // 2
            step *= 2
        return low

    def _estimated_index(self, scan: int) -> int:
        """Return the estimated index of a scan's section, assuming that all scans take the same time."""
        last_section = len(self.sections) - 1
        if last_section < 1:
            return 0
        first_scan, first_ns = self.first_scan(0), self.sections[0].start_ns
        duration_ns = self.sections[last_section].start_ns - first_ns
        ns_per_scan = duration_ns / max(1, self.first_scan(last_section) - first_scan)
        scan_ns = first_ns + (scan - first_scan) * ns_per_scan
        index = bisect_right(self.sections, scan_ns, key=lambda section: section.start_ns)
        return min(max(index - 1, 0), last_section)

    def attachments(self) -> list[Attachment]:
        """Return the attachments, such as the program, the rack file and the word map."""
        attachments = []
        for span in self.spans:
            if span.opcode == Opcode.ATTACHMENT:
                try:
                    attachments.append(read_attachment(self.file, span))
                except TraceError as error:
                    self.note(note_of(error, "the attachment is left out"))
        return attachments

    def attachment_names(self) -> list[tuple[Span, str]]:
        """Return the locations and names of the attachments without reading their data."""
        spans = [span for span in self.spans if span.opcode == Opcode.ATTACHMENT]
        return [(span, attachment_name(self.file, span)) for span in spans]

    def _messages(self, section: Section) -> list[ScanRows | Message]:
        """Return the scans and messages of a section; a damaged section is noted and treated as empty."""
        contents = [part.content for part in self.parts(section) or ()]
        messages = [content for content in contents if not isinstance(content, Channel | Schema)]
        return [message for message in messages if not self._note_malformed(message, section)]

    def _events_among(self, messages: Iterable[ScanRows | Message], section: Section) -> Iterator[TraceEvent]:
        """Yield the events among scans and messages."""
        for message in messages:
            if isinstance(message, Message):
                yield from self._events(message, section)

    def _note_malformed(self, message: ScanRows | Message, section: Section) -> bool:
        """Note a message that is a malformed scan; return whether it is malformed."""
        if not isinstance(message, Message) or message.channel != self.shape.channel:
            return False
        self.note(
            f"the chunk at byte {section.span.offset:,} has a scan of {len(message.data)} bytes "
            f"that is not laid out as its {self._scan_bytes} bytes should be; it is left out"
        )
        return True

    def _events(self, message: Message, section: Section) -> Iterator[TraceEvent]:
        """Yield the event in a message; note a message that is not an event."""
        topic = self._topics.get(message.channel)
        if topic not in _EVENT_TOPICS:
            self._note_unknown_channel(message.channel, topic)
        else:
            try:
                yield _event(message, topic)
            except ValueError as error:
                location = f"the chunk at byte {section.span.offset:,}"
                self.note(f"{location} has a bad message on {topic}: {error}; it is left out")

    def _note_unknown_channel(self, channel: int, topic: str | None) -> None:
        """Note a message without a readable channel or, in a trace of scanrack, of an unknown topic.

        Topics of other software are skipped without a note.
        """
        if topic is None:
            self.note(f"channel {channel} has no readable record; its messages are left out")
        elif self.head.library.startswith(LIBRARY):
            self.note(f"the topic {topic!r} is not known; its messages are left out")

    def _note_where_it_ends(self) -> None:
        """Note the last scan of a trace without an end; `follow` replaces these notes."""
        if self._end_notes:
            location_notes = list(self._where_it_ends())
            self.notes += location_notes
            self._end_notes = [*self._end_notes[:1], *location_notes]

    def _where_it_ends(self) -> Iterator[str]:
        """Yield notes about the last scan of a trace without an end, and an unfinished chunk after it."""
        row = self.edge(last=True)
        if row is None:
            yield "no whole chunk with scans"
        else:
            yield f"the last scan is {row['scan'][0]:,}, at {seconds_column(int(row['log_time'][0]))} s"
        torn = torn_chunk(self.file, self.spans, self.size)
        if torn is not None:
            scans = lost_scans(self.shape, torn)
            yield f"the chunk at byte {torn.span.offset:,} is not whole; {scans} are left out"


def open_records(path: Path | str) -> Records:
    """Open any MCAP file for reading, such as the trace of a serial line.

    Raises:
        TraceError: the file can't be read, or is not an MCAP file. The message names the path.
        TraceLimitError: it has more records than the limits allow.
    """
    return _opened(Path(path), Records)


def open_trace(path: Path | str, *, check: bool = True) -> Trace:
    """Open a trace of scans for reading.

    Args:
        check: see `Trace`; a caller that reads all bytes may check the CRC itself.

    Raises:
        TraceError: the file can't be read, is not an MCAP file, has no scans of scanrack, or has scans with a
            layout that this version does not support. The message names the path.
        TraceLimitError: it has more records than the limits allow. Reading may also raise it.
    """
    return _opened(Path(path), partial(Trace, check=check))


R = TypeVar("R", bound=Records)


def _opened(path: Path, kind: Callable[..., R]) -> R:
    """Open a file with a kind of reader; on an error, close the file and add the path to the message."""
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            raise TraceError(f"{path}: it is not a file")
        file = path.open("rb")
    except OSError as error:
        raise TraceError(f"{path}: {error.strerror}") from error
    try:
        return kind(file, path.stat().st_size, grows=is_being_recorded(path))
    except TraceLimitError as error:
        file.close()
        raise TraceLimitError(f"{path}: {error}", error.limit) from error
    except TraceError as error:
        file.close()
        raise TraceError(f"{path}: {error}") from error


_NO_SCAN = 1 << 32
"""A number greater than any scan number."""

_EVENT_TOPICS = frozenset(topic.name for topic in ALL_TOPICS)


def _rows_of(messages: Iterable[ScanRows | Message]) -> list[ScanRows]:
    return [message for message in messages if not isinstance(message, Message)]


def _event(message: Message, topic: str) -> TraceEvent:
    """Read an event; raise a ValueError if the message is not an event."""
    fields = json_value(message.data)
    if not isinstance(fields, dict) or not isinstance(fields.get("scan"), int):
        raise ValueError("it has no scan number")
    return TraceEvent(fields.pop("scan"), message.log_time, topic, fields)
