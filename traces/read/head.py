"""The head of a trace, with everything needed to read its scans, checked before use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, Header, Metadata, Schema
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.io_images.module_words import PLAIN_WORDS

from ..format.layout import SlotInfo, block_layout
from ..format.named_words import recorded_words
from ..format.records import Span, TraceError, read_chunk, read_record
from ..format.schema import (
    FORMAT,
    FORMAT_WITH_TAGS,
    MESSAGE_ENCODING,
    METADATA,
    NAME_STEM,
    SCHEMA_ENCODING,
    layout_of,
    rest_bytes,
    scan_schema,
)
from ..format.tagplan import TagPlan, read_plan
from ..format.topics import SCAN_TOPIC
from .finding import sound_summary


@dataclass(frozen=True)
class TraceHead:
    """The head of a trace: rack, metadata and layout."""

    profile: str
    library: str
    metadata: Mapping[str, str]  # the metadata record "scanrack"
    slots: tuple[SlotInfo, ...]  # in the order of the memory block
    channels: Mapping[str, Channel]
    tags: TagPlan | None = None  # the recorded tags, or None
    rest_bytes: int = 0  # bytes of a scan after the tags, which are ignored

    @cached_property
    def layout(self) -> MemoryLayout:
        """The locations of the images in the memory block."""
        return block_layout(self.slots)


def read_head(file: BinaryIO, spans: Sequence[Span]) -> TraceHead:
    """Read the head of a trace from its records.

    Raises:
        TraceError: there is no /scan, or its layout is unknown to this version.
    """
    headers = [read_record(file, span, Header.read) for span in spans if span.opcode == Opcode.HEADER]
    if not headers:
        raise TraceError("it has no header")
    channels, schemas = _channels(file, spans)
    if SCAN_TOPIC not in channels:
        raise TraceError(f"it has no channel {SCAN_TOPIC}; its topics are: {', '.join(channels) or 'none'}")
    metadata = _metadata(file, spans)
    schema = schemas.get(channels[SCAN_TOPIC].schema_id)
    slots = _slots(metadata, schema)
    tags = _tags(metadata, schema)
    other_bytes = _rest_bytes(channels[SCAN_TOPIC], schema, slots, tags)
    if metadata["format"] == str(FORMAT_WITH_TAGS) and tags is None and not other_bytes:
        raise TraceError("its schema lists no tags")
    return TraceHead(
        profile=headers[0].profile,
        library=headers[0].library,
        metadata=metadata,
        slots=slots,
        channels=channels,
        tags=tags,
        rest_bytes=other_bytes,
    )


def _channels(file: BinaryIO, spans: Sequence[Span]) -> tuple[dict[str, Channel], dict[int, Schema]]:
    """Return channels by topic and schemas by ID.

    A sound summary lists them; without one, the first record of each in the file is used.
    """
    channels: dict[str, Channel] = {}
    schemas: dict[int, Schema] = {}
    summary_start = sound_summary(file, spans) or 0
    for record in _registered(file, [span for span in spans if span.offset >= summary_start]):
        if isinstance(record, Schema):
            schemas.setdefault(record.id, record)
        else:
            channels.setdefault(record.topic, record)
    return channels, schemas


def _registered(file: BinaryIO, spans: Sequence[Span]) -> Iterator[Schema | Channel]:
    """Yield the schemas and channels among the records; without channels, use the records of the first chunk.

    Other tools may write them only inside chunks.
    """
    for span in spans:
        if span.opcode == Opcode.SCHEMA:
            yield read_record(file, span, Schema.read)
        elif span.opcode == Opcode.CHANNEL:
            yield read_record(file, span, Channel.read)
    opcodes = [span.opcode for span in spans]
    if Opcode.CHANNEL not in opcodes and Opcode.CHUNK in opcodes:
        first_chunk = spans[opcodes.index(Opcode.CHUNK)]
        yield from (
            record for record in read_chunk(file, first_chunk) if isinstance(record, Schema | Channel)
        )


def _metadata(file: BinaryIO, spans: Sequence[Span]) -> Mapping[str, str]:
    """Return the contents of the metadata record "scanrack"; raise TraceError if there is none."""
    for span in spans:
        if span.opcode == Opcode.METADATA:
            record = read_record(file, span, Metadata.read)
            if record.name == METADATA:
                return dict(record.metadata)
    raise TraceError(f"it has no metadata record {METADATA!r}, so that its layout is unknown")


def _slots(metadata: Mapping[str, str], schema: Schema | None) -> tuple[SlotInfo, ...]:
    """Return the slots in the metadata, with the words in the schema.

    Raises:
        TraceError: the format is unknown, or the metadata does not list the slots.
    """
    version = metadata.get("format", "")
    if version not in _FORMATS:
        known_formats = " or ".join(_FORMATS)
        raise TraceError(f"its layout has format {version or 'none'}: must be {known_formats}")
    try:
        numbers = [int(number) for number in metadata["slots"].split()]
        words = {} if schema is None else recorded_words(schema.data.decode("utf-8", "replace"), metadata)
        return tuple(
            SlotInfo(
                number,
                module=metadata[f"slot.{number}.module"],
                firmware=metadata[f"slot.{number}.firmware"],
                words=words.get(number, PLAIN_WORDS),
            )
            for number in numbers
        )
    except (KeyError, ValueError) as error:
        raise TraceError(f"its metadata record {METADATA!r} does not list its slots: {error}") from error


_FORMATS = (str(FORMAT), str(FORMAT_WITH_TAGS))


def _tags(metadata: Mapping[str, str], schema: Schema | None) -> TagPlan | None:
    """Return the recorded tags in the schema; None if the trace's format does not include tags."""
    if schema is None or metadata["format"] != str(FORMAT_WITH_TAGS):
        return None
    try:
        return read_plan(schema.data.decode("utf-8", "replace"))
    except (IndexError, ValueError) as error:
        raise TraceError(f"its schema does not list its tags: {error}") from error


def _rest_bytes(
    channel: Channel, schema: Schema | None, slots: Sequence[SlotInfo], tags: TagPlan | None
) -> int:
    """Return the number of bytes after the tags in a scan.

    Raises:
        TraceError: the fields before these bytes are unknown.
    """
    text = "" if schema is None else schema.data.decode("utf-8", "replace")
    own_schema = scan_schema(slots, tags)
    encoding = (channel.message_encoding, schema.encoding, schema.name) if schema is not None else ()
    required = (MESSAGE_ENCODING, SCHEMA_ENCODING, own_schema.name)
    if encoding == required:
        return 0
    if encoding == (*required[:2], NAME_STEM + layout_of(text)):
        try:
            other_bytes = rest_bytes(text, own_schema)
        except ValueError as error:
            raise TraceError(f"its scans have fields after the tags: {error}") from error
        if other_bytes is not None:
            return other_bytes
    raise TraceError(
        f"this version can't read the layout of its scans: "
        f"{' '.join(encoding) or 'no schema'}, expected {' '.join(required)}"
    )
