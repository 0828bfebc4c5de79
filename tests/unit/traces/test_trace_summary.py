"""The end of a trace, offset by offset as the MCAP specification has it, and chunks that hold no message."""

from __future__ import annotations

import zlib
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from made_traces import record
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Schema, Statistics, SummaryOffset
from scanrack.traces import open_trace, read_columns
from scanrack.traces.format.records import Span, read_record
from scanrack.traces.format.summary import encoded
from scanrack.traces.read.finding import find_records
from scanrack.traces.repair import repair

SCANS = 100
WORDS = np.arange(SCANS * 16).reshape(SCANS, 16) % 30_000
SUMMARY = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return record(tmp_path / "run.mcap", WORDS, chunk_scans=20)


def found(path: Path) -> list[Span]:
    with path.open("rb") as file:
        return find_records(file, path.stat().st_size)[0]


def footer_of(path: Path) -> Footer:
    with path.open("rb") as file:
        return read_record(file, found(path)[-1], Footer.read)


def test_the_footer_leads_to_the_summary_and_to_its_offsets(path: Path) -> None:
    spans, footer = found(path), footer_of(path)
    [data_end] = [span for span in spans if span.opcode == Opcode.DATA_END]
    offsets = [span for span in spans if span.opcode == Opcode.SUMMARY_OFFSET]
    assert footer.summary_start == data_end.end
    assert footer.summary_offset_start == offsets[0].offset
    content = path.read_bytes()
    # the CRC covers the summary and the footer up to the CRC itself
    assert footer.summary_crc == zlib.crc32(content[footer.summary_start : spans[-1].end - 4])


def test_each_offset_leads_to_a_group_of_the_summary(path: Path) -> None:
    spans, footer = found(path), footer_of(path)
    summary = [span for span in spans if span.offset >= footer.summary_start]
    with path.open("rb") as file:
        offsets = [
            read_record(file, span, SummaryOffset.read)
            for span in spans
            if span.opcode == Opcode.SUMMARY_OFFSET
        ]
    groups = {
        opcode: [span for span in summary if span.opcode == opcode]
        for opcode in SUMMARY
        if any(span.opcode == opcode for span in summary)
    }
    assert [each.group_opcode for each in offsets] == list(groups)
    for each in offsets:
        group = groups[Opcode(each.group_opcode)]
        assert each.group_start == group[0].offset
        assert each.group_length == group[-1].end - group[0].offset


def test_each_chunk_index_leads_to_its_chunk_and_to_its_message_indexes(path: Path) -> None:
    spans = found(path)
    chunks = [span for span in spans if span.opcode == Opcode.CHUNK]
    with path.open("rb") as file:
        indexes = [
            read_record(file, span, ChunkIndex.read) for span in spans if span.opcode == Opcode.CHUNK_INDEX
        ]
        heads = [read_record(file, span, Chunk.read) for span in chunks]
    assert len(indexes) == len(chunks) == 5
    for index, span, head in zip(indexes, chunks, heads, strict=True):
        assert (index.chunk_start_offset, index.chunk_length) == (span.offset, span.end - span.offset)
        assert (index.message_start_time, index.message_end_time) == (
            head.message_start_time,
            head.message_end_time,
        )
        following = [
            each for each in spans if each.offset == span.end and each.opcode == Opcode.MESSAGE_INDEX
        ]
        assert sorted(index.message_index_offsets.values())[0] == following[0].offset
        assert index.message_index_length == following[0].end - following[0].offset


def statistics_of(path: Path) -> Statistics:
    with path.open("rb") as file:
        [span] = [span for span in found(path) if span.opcode == Opcode.STATISTICS]
        return read_record(file, span, Statistics.read)


def test_the_statistics_count_what_is_there(tmp_path: Path) -> None:
    event = "/stimuli", {"name": "HOME"}
    path = record(tmp_path / "run.mcap", WORDS, events={3: event, 77: event}, chunk_scans=20)
    counts = statistics_of(path)
    with path.open("rb") as file:
        messages = [(channel.id, message) for _, channel, message in make_reader(file).iter_messages()]
    times = [message.log_time for _, message in messages]
    assert counts.message_count == len(messages) == SCANS + 2
    assert counts.channel_message_counts == Counter(channel for channel, _ in messages)
    assert (counts.message_start_time, counts.message_end_time) == (min(times), max(times))
    spans = Counter(span.opcode for span in found(path) if span.offset < footer_of(path).summary_start)
    assert (counts.chunk_count, counts.attachment_count, counts.metadata_count) == (
        spans[Opcode.CHUNK],
        spans[Opcode.ATTACHMENT],
        spans[Opcode.METADATA],
    )


def test_the_statistics_of_a_single_scan_at_0(tmp_path: Path) -> None:
    counts = statistics_of(record(tmp_path / "run.mcap", WORDS[:1]))
    assert (counts.message_count, counts.message_start_time, counts.message_end_time) == (1, 0, 0)


def with_chunk(path: Path, data: bytes) -> None:
    """Put a chunk of our own in front of the last one, and cut the end off, from the CRC of the data on."""
    at = next(span.offset for span in found(path)[::-1] if span.opcode == Opcode.CHUNK)
    [end] = [span.offset for span in found(path) if span.opcode == Opcode.DATA_END]
    content = path.read_bytes()
    chunk = Chunk(
        compression="",
        data=data,
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=zlib.crc32(data),
        uncompressed_size=len(data),
    )
    path.write_bytes(content[:at] + encoded(chunk) + content[at:end])


def first_of(path: Path, kind: type[Schema] | type[Channel], opcode: Opcode) -> bytes:
    with path.open("rb") as file:
        span = next(span for span in found(path) if span.opcode == opcode)
        return encoded(read_record(file, span, kind.read))


@pytest.mark.parametrize("registers", [False, True])
def test_a_chunk_without_messages_is_repaired(path: Path, registers: bool) -> None:
    """It is empty, or holds schemas and channels only; its times are 0, and it has no message index."""
    data = (
        first_of(path, Schema, Opcode.SCHEMA) + first_of(path, Channel, Opcode.CHANNEL) if registers else b""
    )
    with_chunk(path, data)
    result = repair(path)
    assert (result.needed, result.damaged, result.scans) == (True, 0, SCANS)
    with open_trace(path) as trace:
        assert read_columns(trace).scan.tolist() == list(range(SCANS))
        assert trace.notes == []
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert sum(1 for _ in reader.iter_messages(topics=["/scan"])) == SCANS
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) == 6
    [empty] = [index for index in summary.chunk_indexes if index.uncompressed_size == len(data)]
    assert (empty.message_start_time, empty.message_end_time) == (0, 0)
    assert (empty.message_index_length, empty.message_index_offsets) == (0, {})
    assert summary.statistics.message_start_time == 0
    assert not repair(path).needed
