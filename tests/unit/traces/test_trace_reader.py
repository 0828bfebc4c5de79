"""Reading traces back: whole ones, killed ones, damaged ones, and files that are none."""

from __future__ import annotations

import re
import signal
import sys
from itertools import chain
from pathlib import Path

import forked
import pytest
from mcap.opcode import Opcode
from mcap.writer import Writer
from scanrack.io_images.times import seconds_column
from scanrack.traces import ScanRecorder, SlotInfo, TraceError, open_trace
from scanrack.traces.format.schema import scan_schema
from scanrack.traces.read import finding
from scanrack.traces.read.finding import find_records

SLOTS = [SlotInfo(1, "amci3601", "3.1"), SlotInfo(2, "a toy")]
PERIOD = 2_000_000
CHUNK_SCANS = 50
SCANS = 4 * CHUNK_SCANS


def write_trace(path: Path) -> Path:
    memory = bytearray(64)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=PERIOD, chunk_scans=CHUNK_SCANS)
    for scan in range(SCANS):
        memory[20] = scan % 256
        if scan % 20 == 0:
            recorder.event(scan, scan * PERIOD, "/stimuli", {"slot": 1, "name": "HOME"})
        recorder.scan(scan, scan * PERIOD, 5)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_trace(tmp_path_factory.mktemp("whole") / "run.mcap").read_bytes()


@pytest.fixture
def path(tmp_path: Path, whole: bytes) -> Path:
    """A trace that a test may damage."""
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    return path


def spans(path: Path, opcode: Opcode) -> list[tuple[int, int]]:
    """Return first byte and end of each record of a kind."""
    with path.open("rb") as file:
        found, _ = find_records(file, path.stat().st_size)
    return [(span.offset, span.offset + 9 + span.length) for span in found if span.opcode == opcode]


def damage(path: Path, offset: int, *values: int) -> None:
    content = bytearray(path.read_bytes())
    content[offset : offset + len(values)] = bytes(values)
    path.write_bytes(content)


def joined(chunks: list[list[int]]) -> list[int]:
    return list(chain.from_iterable(chunks))


def numbers(path: Path) -> tuple[list[int], list[str]]:
    with open_trace(path) as trace:
        return [scan.scan for scan in trace.scans()], trace.notes


def test_a_whole_trace(path: Path) -> None:
    with open_trace(path) as trace:
        assert trace.notes == []
        assert trace.size == path.stat().st_size
        assert trace.head.profile == "ros2"
        assert trace.head.slots == tuple(SLOTS)
        assert trace.head.metadata["scan_period_ns"] == "2000000"
        topics = ["/scan", "/events", "/stimuli", "/indicators", "/forces", "/cpu", "/faults"]
        assert list(trace.head.channels) == topics
        assert [attachment.name for attachment in trace.attachments()] == ["words.json"]
        scans = list(trace.scans())
        events = list(trace.events())
    assert [(scan.scan, scan.now_ns, scan.flags) for scan in scans] == [
        (n, n * PERIOD, 5) for n in range(SCANS)
    ]
    assert [scan.inputs(1)[2] for scan in scans] == [n % 256 for n in range(SCANS)]
    assert [scan.outputs(2)[0] for scan in scans] == [0] * SCANS
    assert [(event.scan, event.now_ns, event.topic) for event in events] == [
        (n, n * PERIOD, "/stimuli") for n in range(0, SCANS, 20)
    ]
    assert events[0].fields == {"slot": 1, "name": "HOME"}


def test_events_come_before_the_scan_in_which_they_became_known(path: Path) -> None:
    with open_trace(path) as trace:
        assert [type(entry).__name__ for entry in trace][:3] == ["TraceEvent", "Scan", "Scan"]


def test_a_killed_process_leaves_all_up_to_the_last_whole_chunk(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    program = """
import os, signal, sys
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.write.recorder import ScanRecorder
slots = [SlotInfo(1, "amci3601", "4.1")]
recorder = ScanRecorder(sys.argv[1], bytearray(32), slots, scan_period_ns=2_000_000, chunk_scans=100)
for scan in range(1050):
    recorder.scan(scan, scan, 0)
os.kill(os.getpid(), signal.SIGKILL)
"""
    killed = forked.run([sys.executable, "-c", program, str(path)], timeout=120, check=False)
    assert killed.returncode == -signal.SIGKILL
    scans, notes = numbers(path)
    assert scans == list(range(len(scans)))
    assert 900 <= len(scans) < 1050
    size = path.stat().st_size
    assert notes == [
        f"it has no end: the last whole record ends at byte {size:,} of {size:,}",
        f"the last scan is {scans[-1]}, at {seconds_column(scans[-1])} s",
    ]


@pytest.mark.slow
def test_a_file_cut_anywhere_gives_its_whole_chunks(path: Path) -> None:
    content = path.read_bytes()
    chunk_ends = [end for _, end in spans(path, Opcode.CHUNK)]
    head_end = spans(path, Opcode.CHUNK)[0][0]
    _, notes = numbers(path)
    assert notes == []
    every_chunk = per_chunk(path)
    sizes = {*range(head_end, len(content), 211), *range(len(content) - 40, len(content))}
    sizes |= {end - short for end in chunk_ends for short in range(10)}
    for size in sorted(sizes):
        path.write_bytes(content[:size])
        whole = sum(end <= size for end in chunk_ends)
        scans, notes = numbers(path)
        assert scans == joined(every_chunk[:whole])
        assert f"of {size:,}" in notes[0]
        if scans:
            assert f"the last scan is {scans[-1]}, at {seconds_column(scans[-1] * PERIOD)} s" in notes


@pytest.mark.parametrize("step", [211, 1009, 100_000])
def test_a_file_that_grows_is_followed_as_if_opened_anew(path: Path, step: int) -> None:
    content = path.read_bytes()
    head_end = spans(path, Opcode.CHUNK)[0][0]
    path.write_bytes(content[:head_end])
    with open_trace(path) as followed:
        for size in [*range(head_end + step, len(content), step), len(content), len(content)]:
            path.write_bytes(content[:size])
            grown = size > followed.size
            whole = [span.end for span in followed.spans][-1]
            followed.place_of(SCANS // 2)  # what it remembers of places must not stay wrong
            assert followed.follow() == (grown and followed.spans[-1].end > whole)
            with open_trace(path) as fresh:
                assert (followed.spans, followed.sections) == (fresh.spans, fresh.sections)
                assert sorted(followed.notes) == sorted(fresh.notes)
                assert [followed.place_of(scan) for scan in range(0, SCANS + 20, 20)] == [
                    fresh.place_of(scan) for scan in range(0, SCANS + 20, 20)
                ]
        assert [scan.scan for scan in followed.scans()] == list(range(SCANS))


CHUNKS: dict[bytes, list[list[int]]] = {}
"""What `per_chunk` has found, by the content of the file."""


def per_chunk(path: Path) -> list[list[int]]:
    """Return the scan numbers by chunk, found by cutting the file after each."""
    content = path.read_bytes()
    if content in CHUNKS:
        return CHUNKS[content]
    cut = path.with_name("cut.mcap")
    chunks: list[list[int]] = []
    for _, end in spans(path, Opcode.CHUNK):
        cut.write_bytes(content[:end])
        scans, _ = numbers(cut)
        chunks.append(scans[sum(map(len, chunks)) :])
    assert all(chunks)
    CHUNKS[content] = chunks
    return chunks


def test_a_damaged_chunk_is_named_and_the_others_are_given(path: Path) -> None:
    chunks = per_chunk(path)
    start, end = spans(path, Opcode.CHUNK)[1]
    damage(path, end - 5, 0xFF, 0xFF)
    scans, notes = numbers(path)
    assert scans == chunks[0] + joined(chunks[2:])
    assert len(notes) == 1
    assert notes[0].startswith(f"damaged chunk at byte {start:,}: ")
    lost = chunks[1]
    span = f"{seconds_column(lost[0] * PERIOD)} s to {seconds_column(lost[-1] * PERIOD)} s"
    assert notes[0].endswith(f"; its {len(lost)} scans from {span} are left out")


def test_a_wrong_crc_is_a_damaged_chunk(path: Path) -> None:
    start, _ = spans(path, Opcode.CHUNK)[0]
    damage(path, start + 9 + 24, 1, 2, 3, 4)  # after two times and the uncompressed size
    scans, notes = numbers(path)
    assert scans == joined(per_chunk(write_trace(path.with_name("whole.mcap")))[1:])
    assert f"damaged chunk at byte {start:,}: its CRC does not fit" in notes[0]


def test_what_is_cut_off_of_the_last_chunk_is_told(path: Path) -> None:
    lost = per_chunk(path)[1]
    start, end = spans(path, Opcode.CHUNK)[1]
    path.write_bytes(path.read_bytes()[: end - 1])
    _, notes = numbers(path)
    span = f"from {seconds_column(lost[0] * PERIOD)} s to {seconds_column(lost[-1] * PERIOD)} s"
    says = rf"the chunk at byte {start:,} is not whole; about (\d+) scans {span} are left out"
    said = re.fullmatch(says, notes[2])
    assert said is not None
    assert 0 <= int(said[1]) - len(lost) <= 3  # events have taken room


def ruin(path: Path, start: int) -> None:
    """Damage the opcode of a chunk and the name of its compression: nothing tells that it is one."""
    damage(path, start, 0x77)
    damage(path, start + 41, *b"no")


def test_reading_goes_on_with_the_next_chunk_after_a_damaged_record(path: Path) -> None:
    chunks = per_chunk(path)
    (start, _), (following, _) = spans(path, Opcode.CHUNK)[2:4]
    ruin(path, start)
    scans, notes = numbers(path)
    assert scans == chunks[0] + chunks[1] + joined(chunks[3:])
    assert notes == [f"damaged at byte {start:,}; the next chunk is at byte {following:,}"]


@pytest.mark.parametrize("length", [0, 5, 300, 1 << 40, "into the next"])
@pytest.mark.parametrize("place", [0, 1, -1])
def test_a_wrong_length_costs_no_chunk(path: Path, length: int | str, place: int) -> None:
    chunks = per_chunk(path)
    starts = [start for start, _ in spans(path, Opcode.CHUNK)]
    number = length if isinstance(length, int) else starts[1] - starts[0] + 100
    damage(path, starts[place] + 1, *number.to_bytes(8, "little"))
    scans, notes = numbers(path)
    assert scans == joined(chunks)
    assert f"the head of the chunk at byte {starts[place]:,} is damaged; the chunk is whole" in notes


@pytest.mark.parametrize("opcode", [0x77, Opcode.MESSAGE_INDEX, Opcode.DATA_END, 0x86, Opcode.FOOTER])
@pytest.mark.parametrize("place", [0, 1, -1])
def test_a_wrong_opcode_costs_no_chunk(path: Path, opcode: int, place: int) -> None:
    chunks = per_chunk(path)
    start, _ = spans(path, Opcode.CHUNK)[place]
    damage(path, start, opcode)
    scans, notes = numbers(path)
    assert scans == joined(chunks)
    assert notes == [
        f"the head of the chunk at byte {start:,} is damaged; the chunk is whole",
        finding.DATA_DAMAGE,
    ]


@pytest.mark.parametrize("size", [1, 7, 64])
def test_the_next_chunk_is_found_however_much_is_read_at_once(
    path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    (start, _), (following, _) = spans(path, Opcode.CHUNK)[2:4]
    ruin(path, start)
    monkeypatch.setattr(finding, "_SEARCH_BYTES", size)
    _, notes = numbers(path)
    assert notes == [f"damaged at byte {start:,}; the next chunk is at byte {following:,}"]


def test_a_chunk_that_holds_less_than_it_says_is_damaged(path: Path) -> None:
    start, _ = spans(path, Opcode.CHUNK)[0]
    damage(path, start + 9 + 16, 1)  # the uncompressed size, after two times
    _, notes = numbers(path)
    assert re.search(r"damaged chunk at byte [\d,]+: it has [\d,]+ bytes instead of [\d,]+;", notes[0])


def test_what_is_behind_a_damaged_last_chunk(path: Path) -> None:
    chunks = per_chunk(path)
    start, _ = spans(path, Opcode.CHUNK)[-1]
    end, _ = spans(path, Opcode.DATA_END)[0]
    ruin(path, start)
    assert numbers(path) == (
        joined(chunks[:-1]),
        [f"damaged at byte {start:,}; the end of its data is at byte {end:,}"],
    )
    path.write_bytes(path.read_bytes()[:-10])
    _, notes = numbers(path)
    assert notes[0] == f"damaged at byte {start:,}: 0x77 is not the opcode of a record"


def refusal(path: Path) -> str:
    with pytest.raises(TraceError) as error:
        open_trace(path)
    assert isinstance(error.value, ValueError)
    assert str(error.value).startswith(f"{path}: ")
    return str(error.value).removeprefix(f"{path}: ")


def test_files_that_are_no_traces_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "file"
    assert refusal(path) == "No such file or directory"
    assert refusal(tmp_path) == "Is a directory"
    path.write_bytes(b"")
    assert refusal(path) == "it is not an MCAP file"
    path.write_bytes(b"scan,position\n0,0\n" * 100)
    assert refusal(path) == "it is not an MCAP file"
    path.write_bytes(b"\x89MCAP0\r\n")
    assert refusal(path).startswith("it has no header; it has no end")


def test_a_trace_cut_in_its_head_says_so(path: Path) -> None:
    first, _ = spans(path, Opcode.CHANNEL)[0]
    path.write_bytes(path.read_bytes()[: first + 3])
    why = refusal(path)
    assert why.startswith(
        "it has no channel /scan; its topics are: none; it has no end: the last whole record"
    )
    assert why.endswith(f"ends at byte {first:,} of {first + 3:,}")


def foreign(
    path: Path,
    *,
    topic: str = "/scan",
    metadata: dict[str, str] | None = None,
    name: str = "",
) -> None:
    """Write an MCAP file that is not quite a trace, with the stock writer."""
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "somebody else")
        schema_id = writer.register_schema(name or schema.name, "ros2msg", schema.text.encode())
        channel = writer.register_channel(topic, "cdr", schema_id)
        if metadata is not None:
            writer.add_metadata("scanrack", metadata)
        payload = bytes.fromhex("00010000") + (3).to_bytes(4, "little") + bytes(4 + 64)
        writer.add_message(channel, log_time=6, data=payload, publish_time=6, sequence=3)
        writer.finish()


GOOD = {
    "format": "1",
    "slots": "1 2",
    "slot.1.module": "amci3601",
    "slot.1.firmware": "3.1",
    "slot.2.module": "a toy",
    "slot.2.firmware": "",
}


def test_a_trace_that_another_tool_wrote_is_read(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    foreign(path, metadata=GOOD)
    with open_trace(path) as trace:
        (scan,) = trace.scans()
        assert (scan.scan, scan.now_ns, scan.memory) == (3, 6, bytes(64))
        assert trace.head.library == "somebody else"


def test_layouts_that_are_not_known_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    foreign(path, topic="/imu", metadata=GOOD)
    assert refusal(path) == "it has no channel /scan; its topics are: /imu"
    foreign(path)
    assert refusal(path) == "it has no metadata record 'scanrack', so that its layout is unknown"
    foreign(path, metadata={**GOOD, "format": "3"})
    assert refusal(path) == "its layout has format 3: must be 1 or 2"
    foreign(path, metadata={**GOOD, "format": "2"})
    assert refusal(path) == "its schema lists no tags"
    foreign(path, metadata={**GOOD, "slots": "1 2 3"})
    assert refusal(path) == "its metadata record 'scanrack' does not list its slots: 'slot.3.module'"
    foreign(path, metadata={**GOOD, "slots": "2 1"})
    assert refusal(path).startswith("this version can't read the layout of its scans: cdr ros2msg")
    foreign(path, metadata=GOOD, name="scanrack/msg/Scan0123456789ab")
    assert "scanrack/msg/Scan0123456789ab, expected cdr ros2msg scanrack/msg/Scan" in refusal(path)


@pytest.mark.parametrize("payload", ["00000000" * 11, "00010000" * 5, "00010000" * 12])
def test_a_scan_that_is_not_laid_out_as_it_should_be_is_named(tmp_path: Path, payload: str) -> None:
    path = tmp_path / "short.mcap"
    one = SLOTS[:1]
    schema = scan_schema(one)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "somebody else")
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        writer.add_metadata("scanrack", {**GOOD, "slots": "1"})
        writer.add_message(channel, log_time=0, data=bytes.fromhex(payload), publish_time=0)
        writer.finish()
    with open_trace(path) as trace:
        assert list(trace) == []
        assert re.search(
            r"^the chunk at byte \d+ has a scan of \d\d bytes .* it is left out$", trace.notes[0]
        )


@pytest.mark.parametrize("data", [b"{", b"[1]", b'{"name": "x"}', b'{"scan": "x"}', b"[" * 9])
def test_an_event_that_is_none_is_noted_and_the_others_are_given(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "other.mcap"
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "somebody else")
        number = writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        writer.register_channel("/scan", "cdr", number)
        channel = writer.register_channel("/events", "json", number)
        writer.add_metadata("scanrack", GOOD)
        for message in (data, b'{"scan": 7, "name": "x"}'):
            writer.add_message(channel, log_time=0, data=message, publish_time=0)
        writer.finish()
    with open_trace(path) as trace:
        assert [event.scan for event in trace.events()] == [7]
        (note,) = trace.notes
    assert re.fullmatch(r"the chunk at byte [\d,]+ has a bad message on /events: .*; it is left out", note)
