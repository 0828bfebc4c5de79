"""Traces as arrays: the same as scan by scan, and no more of the file read than it takes."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_traces import PERIOD_NS, record
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer
from scanrack.traces import ScanRecorder, SlotInfo, Trace, open_trace, read_columns
from scanrack.traces.format.schema import CDR_PREFIX, SCAN_HEAD, scan_schema
from scanrack.traces.read import reader
from scanrack.traces.read.arrays import by_name, column_chunks, extent, scan_at, scan_count
from scanrack.traces.read.columns import Columns, Selection

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(5, "a toy")]
SCANS = 500
CHUNK_SCANS = 50
NUMBERS = np.arange(SCANS * 32).reshape(SCANS, 32) * 7 % 65_536 - 32_768
"""Words that tell scan and word apart."""

STIMULUS = ("/stimuli", {"name": "HOME"})
FOREIGN = {
    "format": "1",
    "slots": "1 5",
    "slot.1.module": "amci3601",
    "slot.1.firmware": "4.1",
    "slot.5.module": "a toy",
    "slot.5.firmware": "",
}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arrays")
    events = {7: STIMULUS, 8: STIMULUS, 240: STIMULUS}
    return record(folder / "run.mcap", NUMBERS, SLOTS, events=events, chunk_scans=CHUNK_SCANS)


@contextmanager
def counted(path: Path, patch: pytest.MonkeyPatch) -> Iterator[tuple[Trace, list[int]]]:
    """Open a trace; the list tells where the sections are that have been read."""
    read: list[int] = []
    whole = reader.take_apart

    def noted(file, section, shape):
        read.append(section.span.offset)
        return whole(file, section, shape)

    patch.setattr(reader, "take_apart", noted)
    with open_trace(path) as trace:
        yield trace, read


def check(columns: Columns, first: int, last: int) -> None:
    scans = np.arange(first, last + 1)
    assert columns.scan.tolist() == scans.tolist()
    assert columns.time_ns.tolist() == (scans * PERIOD_NS).tolist()
    assert columns.flags.tolist() == [1] * len(scans)
    assert columns.words.tolist() == NUMBERS[first : last + 1].tolist()
    kinds = [column.dtype for column in columns.images()]
    assert kinds == [np.int64, np.int64, np.uint32, np.int16]


def test_all_scans(path: Path) -> None:
    with open_trace(path) as trace:
        check(read_columns(trace), 0, SCANS - 1)
        assert scan_count(trace) == SCANS


def test_words_have_names(path: Path) -> None:
    with open_trace(path) as trace:
        columns = read_columns(trace)
        named = by_name(columns.words, trace.head.slots)
    assert named["slot1"]["out"]["command_msw"].tolist() == NUMBERS[:, 0].tolist()
    assert named["slot1"]["in"]["captured_lsw"].tolist() == NUMBERS[:, 15].tolist()
    assert named["slot5"]["in"]["word1"].tolist() == NUMBERS[:, 25].tolist()
    assert np.shares_memory(named, columns.words)


@pytest.mark.parametrize(
    ("selection", "first", "last"),
    [
        (Selection(first=120, last=130), 120, 130),
        (Selection(last=0), 0, 0),
        (Selection(first=499), 499, 499),
        (Selection(start_ns=120 * PERIOD_NS, end_ns=130 * PERIOD_NS), 120, 130),
        (Selection(first=49, end_ns=51 * PERIOD_NS), 49, 51),
    ],
)
def test_a_slice_reads_only_the_chunks_it_needs(
    path: Path, selection: Selection, first: int, last: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    with counted(path, monkeypatch) as (trace, read):
        scan_count(trace, selection)  # finds the chunks
        read.clear()
        check(read_columns(trace, selection), first, last)
        assert len(read) <= 1 + (last - first + CHUNK_SCANS) // CHUNK_SCANS


def test_a_slice_that_ends_where_a_chunk_begins(path: Path) -> None:
    with open_trace(path) as trace:
        for section in trace.sections[1:]:
            scans = read_columns(trace, Selection(end_ns=section.start_ns)).scan
            assert scans[-1] * PERIOD_NS == section.start_ns
            scans = read_columns(trace, Selection(start_ns=section.start_ns)).scan
            assert scans[0] * PERIOD_NS == section.start_ns


@pytest.mark.parametrize("selection", [Selection(first=500), Selection(start_ns=10**12), Selection(9, 3)])
def test_a_slice_beyond_the_trace_is_empty(path: Path, selection: Selection) -> None:
    with open_trace(path) as trace:
        assert read_columns(trace, selection).words.shape == (0, 32)


@pytest.mark.parametrize("margin", [1, 49, 120])
def test_a_margin_is_there_on_both_sides(path: Path, margin: int) -> None:
    with open_trace(path) as trace:
        parts = list(column_chunks(trace, Selection(200, 260), margin=margin))
        assert parts[0].scan[0] <= 200 - margin
        assert parts[-1].scan[-1] >= 260 + margin
        assert sum(len(part.scan) for part in parts) < SCANS
        assert sum(len(part.scan) for part in parts) == scan_count(trace, Selection(200, 260), margin=margin)


def test_every_scan_is_found_at_random(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with counted(path, monkeypatch) as (trace, read):
        for number in np.random.default_rng(1).permutation(SCANS).tolist():
            scan = scan_at(trace, number)
            assert (scan.scan, scan.now_ns) == (number, number * PERIOD_NS)
            assert list(scan.inputs(5)) == NUMBERS[number, 24:].tolist()
        for place in range(len(trace.sections)):
            read.clear()
            scan_at(trace, trace.first_scan(place))
            assert len(read) == 1
        for number in (SCANS, -1):
            with pytest.raises(ValueError, match=f"the trace has no scan {number}; it has 0 to 499"):
                scan_at(trace, number)


def test_the_first_scan_and_the_last(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with counted(path, monkeypatch) as (trace, read):
        ends = extent(trace)
        assert ends.scan.tolist() == [0, 499]
        assert ends.time_ns.tolist() == [0, 499 * PERIOD_NS]
        assert len(read) == 2


def test_events_are_read_without_the_chunks_that_have_none(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with counted(path, monkeypatch) as (trace, read):
        assert [event.scan for event in trace.events()] == [7, 8, 240]
        assert len(read) == 2
        assert len(trace.sections) > 8


def test_an_index_that_does_not_tell_all_is_not_believed(path: Path, tmp_path: Path) -> None:
    with open_trace(path) as trace:
        index = next(span for span in trace.spans if span.opcode == Opcode.MESSAGE_INDEX)
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(path.read_bytes()[: index.end])  # that of the events is missing
    with open_trace(torn) as trace:
        assert [event.scan for event in trace.events()] == [7, 8]


def test_only_chunks_with_a_topic_are_read_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    events = {7: STIMULUS, 120: ("/cpu", {"mode": "run"}), 240: STIMULUS}
    path = record(tmp_path / "run.mcap", NUMBERS, SLOTS, events=events, chunk_scans=CHUNK_SCANS)
    with counted(path, monkeypatch) as (trace, read):
        assert [event.scan for event in trace.events(topics={"/cpu"})] == [120]
        assert len(read) == 1


def test_a_topic_is_looked_for_where_the_last_index_is_cut_off(path: Path, tmp_path: Path) -> None:
    with open_trace(path) as trace:
        index = next(span for span in trace.spans if span.opcode == Opcode.MESSAGE_INDEX)
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(path.read_bytes()[: index.end])
    with open_trace(torn) as trace:
        assert [event.scan for event in trace.events(topics={"/stimuli"})] == [7, 8]


@pytest.mark.parametrize("scans", [500, 20_000])
def test_a_scan_is_found_by_as_few_chunks_in_a_trace_of_any_length(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scans: int
) -> None:
    words = np.zeros((scans, 16), np.int16)
    path = record(tmp_path / "long.mcap", words, events={scans // 2: STIMULUS}, chunk_scans=CHUNK_SCANS)
    with counted(path, monkeypatch) as (trace, read):
        assert scan_at(trace, scans - 1 - scans // 3).scan == scans - 1 - scans // 3
        assert len(set(read)) <= 5


def test_a_scan_is_found_though_numbers_and_times_are_irregular(tmp_path: Path) -> None:
    numbers = np.cumsum(np.arange(300) ** 2 % 7 + 1).tolist()
    memory = bytearray(32)
    recorder = ScanRecorder(tmp_path / "run.mcap", memory, SLOTS[:1], scan_period_ns=1, chunk_scans=3)
    for place, number in enumerate(numbers):
        recorder.scan(number, place**3, 1)
    recorder.close()
    with open_trace(tmp_path / "run.mcap") as trace:
        firsts = numbers[::3]
        for number in range(numbers[-1] + 3):
            assert trace.place_of(number) == bisect_right(firsts, number) - 1


def test_a_trace_without_scans(tmp_path: Path) -> None:
    path = record(tmp_path / "none.mcap", NUMBERS[:0], SLOTS)
    with open_trace(path) as trace:
        assert read_columns(trace).words.shape == (0, 32)
        assert len(extent(trace).scan) == 0
        with pytest.raises(ValueError, match="it has no scans"):
            scan_at(trace, 0)


def foreign(path: Path, **options: Any) -> Path:
    """Write the same scans with the stock writer, another channel between them."""
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start("ros2", "somebody else")
        other = writer.register_channel("/imu", "json", writer.register_schema("Imu", "jsonschema", b"{}"))
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        writer.add_metadata("scanrack", FOREIGN)
        for scan, words in enumerate(NUMBERS.astype("<i2")):
            payload = SCAN_HEAD.pack(CDR_PREFIX, scan, 1) + words.tobytes()
            now_ns = scan * PERIOD_NS
            writer.add_message(channel, now_ns, payload, now_ns, scan)
            if scan % 9 == 0:
                writer.add_message(other, now_ns, b"{}" * (scan % 70), now_ns, scan)
        writer.finish()
    return path


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.LZ4, "chunk_size": 20_000},
        {"compression": CompressionType.NONE, "chunk_size": 20_000},
        {"compression": CompressionType.ZSTD, "chunk_size": 1},
        {"compression": CompressionType.ZSTD, "use_chunking": False},
        {"chunk_size": 20_000, "enable_crcs": False, "repeat_channels": False, "repeat_schemas": False},
        {"chunk_size": 20_000, "index_types": 0},
    ],
    ids=["lz4", "none", "tiny chunks", "no chunks", "no CRCs", "no indexes"],
)
def test_what_others_wrote_is_read(tmp_path: Path, options: dict[str, object]) -> None:
    if "index_types" in options:
        options = options | {"index_types": pytest.importorskip("mcap.writer").IndexType.NONE}
    path = foreign(tmp_path / "other.mcap", **options)
    with open_trace(path) as trace:
        check(read_columns(trace), 0, SCANS - 1)
        check(read_columns(trace, Selection(120, 130)), 120, 130)
        assert scan_at(trace, 444).memory == NUMBERS[444].astype("<i2").tobytes()
        assert [scan.scan for scan in trace.scans()] == list(range(SCANS))
        assert list(trace.events()) == []
        assert trace.notes == []


def test_the_scans_of_a_damaged_chunk_are_missing_and_noted(path: Path, tmp_path: Path) -> None:
    with open_trace(path) as trace:
        section = trace.sections[4]
    content = bytearray(path.read_bytes())
    content[section.span.offset + 9 + section.span.length - 3] ^= 1
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(content)
    with open_trace(damaged) as trace:
        columns = read_columns(trace)
        assert len(trace.notes) == 1
        lost = sorted(set(range(SCANS)) - set(columns.scan.tolist()))
        assert lost == list(range(lost[0], lost[-1] + 1))
        assert len(lost) == trace.shape.expected(section)
        assert scan_at(trace, lost[0] - 1).scan == lost[0] - 1
        assert scan_at(trace, lost[-1] + 1).scan == lost[-1] + 1
        with pytest.raises(ValueError, match=f"the trace has no scan {lost[3]}"):
            scan_at(trace, lost[3])


def test_a_scan_laid_out_in_another_way_is_noted_and_the_others_are_given(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "somebody else")
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        writer.add_metadata("scanrack", FOREIGN)
        for scan in range(40):
            prefix = CDR_PREFIX if scan != 30 else CDR_PREFIX + 1
            payload = SCAN_HEAD.pack(prefix, scan, 1) + bytes(64 if scan != 5 else 65)
            writer.add_message(channel, log_time=scan, data=payload, publish_time=scan)
        writer.finish()
    with open_trace(path) as trace:
        assert read_columns(trace).scan.tolist() == [scan for scan in range(40) if scan not in (5, 30)]
        assert ["77 bytes" in note for note in trace.notes] == [True, False]
        assert "has a scan of 76 bytes that is not laid out as its 76 bytes should be" in trace.notes[1]
