"""Repair: what is whole stays byte for byte, the end is made anew, the original is safe until then."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import forked
import numpy as np
import pytest
from made_traces import record
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from scanrack.commands import build
from scanrack.traces import SlotInfo, TraceError, open_trace, read_columns
from scanrack.traces.format.schema import CDR_PREFIX, SCAN_HEAD, scan_schema
from scanrack.traces.read.finding import find_records
from scanrack.traces.repair import repair
from scanrack.traces.write.line import LineRecorder, UnitColumns
from typer.testing import CliRunner

SLOTS = [SlotInfo(1, "amci3601", "4.1")]
SCANS = 100
WORDS = np.arange(SCANS * 16).reshape(SCANS, 16) % 30_000
STIMULUS = ("/stimuli", {"name": "HOME"})


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    events = {3: STIMULUS, 4: STIMULUS, 77: STIMULUS}
    path = tmp_path_factory.mktemp("repair") / "run.mcap"
    return record(path, WORDS, SLOTS, events=events, chunk_scans=20).read_bytes()


def spans(path: Path, *opcodes: Opcode) -> list[tuple[int, int]]:
    with path.open("rb") as file:
        found, _ = find_records(file, path.stat().st_size)
    return [(span.offset, span.end) for span in found if span.opcode in opcodes]


def scans(path: Path) -> list[int]:
    """Return the scans of a trace that has to be whole, for our reader and for the stock reader."""
    with open_trace(path) as trace:
        columns = read_columns(trace)
        events = list(trace.events())
        assert trace.notes == []
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        messages = [(channel.topic, message) for _, channel, message in reader.iter_messages()]
        summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(messages) == len(columns.scan) + len(events)
    assert [message.sequence for topic, message in messages if topic == "/scan"] == columns.scan.tolist()
    return columns.scan.tolist()


@pytest.fixture
def path(tmp_path: Path, content: bytes) -> Path:
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    return path


def test_a_trace_that_has_lost_its_end_becomes_what_it_was(path: Path, content: bytes) -> None:
    last_index = spans(path, Opcode.MESSAGE_INDEX)[-1]
    for size in (len(content) - 1, last_index[1], last_index[0], spans(path, Opcode.CHUNK)[-1][1]):
        path.write_bytes(content[:size])
        result = repair(path)
        assert (result.needed, result.damaged, result.scans) == (True, 0, SCANS)
        assert path.read_bytes() == content
    assert os.listdir(path.parent) == ["run.mcap"]


@pytest.mark.slow
def test_a_trace_cut_anywhere_keeps_its_whole_chunks(path: Path, content: bytes) -> None:
    ends = [end for _, end in spans(path, Opcode.CHUNK)]
    edges = [edge for span in spans(path, *Opcode) for edge in span if edge >= ends[0] - 100]
    counts = []
    for size in sorted({edge + step for edge in edges for step in (-1, 0, 9)}):
        path.write_bytes(content[:size])
        with open_trace(path) as trace:
            whole = read_columns(trace).scan.tolist()
            told = trace.notes
        result = repair(path)
        assert scans(path) == whole == list(range(len(whole)))
        assert result.scans == len(whole)
        assert result.notes == told
        counts.append(len(whole))
    assert counts[0] == 0
    assert set(counts) >= {0, SCANS}
    assert len(set(counts)) == len(ends) + 1


def test_a_whole_trace_is_left_alone(path: Path, content: bytes) -> None:
    before = path.stat()
    result = repair(path, path.with_name("other.mcap"))
    assert (result.needed, result.notes, result.scans) == (False, [], SCANS)
    assert path.stat().st_ino == before.st_ino
    assert os.listdir(path.parent) == ["run.mcap"]


def test_a_damaged_chunk_is_left_out_and_the_original_stays(path: Path, content: bytes) -> None:
    _, end = spans(path, Opcode.CHUNK)[1]
    bad = content[: end - 4] + bytes([content[end - 4] ^ 8]) + content[end - 3 :]
    path.write_bytes(bad)
    result = repair(path)
    assert (result.damaged, result.original) == (1, path.with_name("run.mcap.orig"))
    assert path.with_name("run.mcap.orig").read_bytes() == bad
    left = scans(path)
    assert result.scans is not None
    assert len(left) == result.scans < SCANS
    lost = sorted(set(range(SCANS)) - set(left))
    assert lost == list(range(lost[0], lost[-1] + 1))
    assert 0 < lost[0] < len(lost) + lost[0] < SCANS


BAD_SUMMARY = "its summary is damaged: its CRC does not fit; its contents are not used"


@pytest.mark.parametrize(
    "opcode", [Opcode.MESSAGE_INDEX, Opcode.CHUNK_INDEX, Opcode.STATISTICS, Opcode.FOOTER]
)
def test_damaged_indexes_are_made_anew(path: Path, content: bytes, opcode: Opcode) -> None:
    start, end = spans(path, opcode)[0]
    for place in (start + 12, end - 2):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        result = repair(path)
        in_summary = opcode is not Opcode.MESSAGE_INDEX
        assert result.notes == [
            BAD_SUMMARY if in_summary else "its indexes or its end do not fit its contents"
        ]
        assert path.read_bytes() == content
        assert result.damaged == 0
        assert result.original is None or result.original.read_bytes() != content


@pytest.mark.parametrize("opcode", [Opcode.SCHEMA, Opcode.CHANNEL])
def test_a_damaged_head_is_made_anew_from_the_summary(path: Path, content: bytes, opcode: Opcode) -> None:
    start, _ = spans(path, opcode)[0]
    for place in (start + 9, start + 17):  # the id, the name
        path.write_bytes(content[:place] + b"?" + content[place + 1 :])
        with open_trace(path) as trace:
            assert len(read_columns(trace).scan) == SCANS
        repair(path)
        assert path.read_bytes() == content


def test_a_damaged_attachment_is_left_out(path: Path, content: bytes) -> None:
    _, end = spans(path, Opcode.ATTACHMENT)[0]
    path.write_bytes(content[: end - 30] + b"?" + content[end - 29 :])
    with open_trace(path) as trace:
        assert trace.attachments() == []
        assert trace.notes[0].startswith("damaged attachment 'words.json' at byte ")
    assert repair(path).damaged == 1
    assert scans(path) == list(range(SCANS))


def test_a_damaged_time_in_the_head_of_a_chunk_is_made_anew(path: Path, content: bytes) -> None:
    start, _ = spans(path, Opcode.CHUNK)[1]
    path.write_bytes(content[: start + 9] + b"\xff" + content[start + 10 :])
    repair(path)
    assert path.read_bytes() == content


@pytest.mark.parametrize("compression", list(CompressionType))
def test_what_another_tool_wrote_is_repaired(tmp_path: Path, compression: CompressionType) -> None:
    path = tmp_path / "other.mcap"
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file, compression=compression, chunk_size=400)
        writer.start("ros2", "somebody else")
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        slot = {"slot.1.module": "amci3601", "slot.1.firmware": "4.1"}
        writer.add_metadata("scanrack", {"format": "1", "slots": "1", **slot})
        for scan in range(SCANS):
            payload = SCAN_HEAD.pack(CDR_PREFIX, scan, 1) + bytes(32)
            writer.add_message(channel, scan, payload, scan, scan)
        writer.finish()
    assert not repair(path).needed
    path.write_bytes(path.read_bytes()[:-30])
    assert repair(path).needed
    assert scans(path) == list(range(SCANS))


def test_the_index_has_the_times_of_an_attachment_as_another_tool_wrote_them(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "somebody else")
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        slot = {"slot.1.module": "amci3601", "slot.1.firmware": "4.1"}
        writer.add_metadata("scanrack", {"format": "1", "slots": "1", **slot})
        writer.add_attachment(create_time=3, log_time=7, name="notes", media_type="text/plain", data=b"")
        writer.add_message(channel, 0, SCAN_HEAD.pack(CDR_PREFIX, 0, 1) + bytes(32), 0, 0)
        writer.finish()
    path.write_bytes(path.read_bytes()[:-30])
    assert repair(path).needed
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    (index,) = summary.attachment_indexes
    assert (index.create_time, index.log_time) == (3, 7)


def test_output_leaves_the_original(path: Path, content: bytes) -> None:
    path.write_bytes(content[:-50])
    path.chmod(0o640)
    target = path.with_name("whole.mcap")
    assert repair(path, target).original is None
    assert target.read_bytes() == content
    assert target.stat().st_mode & 0o777 == 0o640
    assert path.read_bytes() == content[:-50]


def test_a_repair_that_fails_changes_nothing(
    path: Path, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    path.write_bytes(content[:-50])

    def no_space(number: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(OSError, match="No space left"):
        repair(path)
    assert path.read_bytes() == content[:-50]
    assert os.listdir(path.parent) == ["run.mcap"]


def test_progress_reaches_the_size_of_the_trace(path: Path, content: bytes) -> None:
    path.write_bytes(content[:-50])
    told: list[int] = []
    repair(path, progress=told.append)
    assert sum(told) == len(content) - 50
    assert min(told) >= 0


def test_what_is_no_trace_is_not_repaired(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a trace", encoding="utf-8")
    with pytest.raises(TraceError, match="it is not an MCAP file"):
        repair(path)
    assert os.listdir(tmp_path) == ["notes.txt"]


KILLED = """
import os, signal, sys
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.write.line import LineRecorder, UnitColumns
from scanrack.traces.write.recorder import ScanRecorder
memory = bytearray(32)
slots = [SlotInfo(1, "amci3601", "4.1")]
recorder = ScanRecorder(sys.argv[1], memory, slots, scan_period_ns=1, chunk_scans=64)
scan = 0
while True:
    memory[20] = scan % 251
    recorder.scan(scan, scan, 0)
    scan += 1
    if scan % 64 == 0:
        sys.stdout.write(f"{scan}\\n")
        sys.stdout.flush()
"""


@pytest.mark.slow
@pytest.mark.parametrize("lines", [2, 40, 700])
def test_a_killed_recording_loses_the_open_chunk_at_most(tmp_path: Path, lines: int) -> None:
    path = tmp_path / "killed.mcap"
    process = forked.start(
        [sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, text=True, encoding="utf-8"
    )
    assert process.stdout is not None
    told = [int(process.stdout.readline()) for _ in range(lines)]
    process.kill()
    rest, _ = process.communicate(timeout=120)
    assert process.returncode == -signal.SIGKILL
    told += [int(line) for line in rest.splitlines(keepends=True) if line.endswith("\n")]
    result = repair(path)
    assert result.scans is not None
    assert scans(path) == list(range(result.scans))
    assert result.scans >= told[-1] - 64
    assert repair(path).needed is False


def run(*arguments: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(build(), ["repair", *map(str, arguments)])
    return result.exit_code, result.stdout, result.stderr


def test_the_command(path: Path, content: bytes) -> None:
    path.write_bytes(content[:-50])
    status, out, err = run(path)
    assert (status, out) == (0, f"{path}: repaired, 100 scans, {len(content):,} bytes\n")
    assert [line.partition(":")[0] for line in err.splitlines()] == ["note", "note"]
    assert "note: the last scan is 99, at 0.198 s" in err
    assert run(path) == (0, f"{path}: 100 scans, nothing to repair\n", "")


def test_the_command_tells_what_is_left_out(path: Path, content: bytes) -> None:
    _, end = spans(path, Opcode.CHUNK)[1]
    path.write_bytes(content[: end - 4] + b"\0\0" + content[end - 2 :])
    status, _, err = run(path)
    assert status == 1
    assert "note: damaged chunk at byte" in err
    assert "note: the original is kept as run.mcap.orig" in err


def test_the_command_refuses_in_one_line(path: Path, tmp_path: Path) -> None:
    for arguments, status in (
        ((tmp_path / "none.mcap",), 2),
        ((tmp_path,), 2),
        ((path, "--out", path), 2),
        ((path, "--out", tmp_path / "nowhere" / "run.mcap"), 3),
    ):
        found, out, err = run(*arguments)
        assert (found, out) == (status, "")
        assert err.startswith("scanrack: ")
        assert err.count("\n") == 1


def flipped(content: bytes, place: int, bit: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 1 << bit]) + content[place + 1 :]


def test_the_top_bit_of_the_last_length_costs_nothing(path: Path, content: bytes) -> None:
    """Every scan was lost that the chunk had, with exit status 0, and the original was gone."""
    start, _ = spans(path, Opcode.CHUNK)[-1]
    bad = flipped(content, start + 8, 7)
    path.write_bytes(bad)
    result = repair(path)
    assert path.read_bytes() == content
    assert result.scans == SCANS
    assert result.original is not None
    assert result.original.read_bytes() == bad


@pytest.mark.slow
def test_any_flipped_bit_in_the_heads_of_records_costs_no_scan_or_keeps_the_original(
    path: Path, content: bytes
) -> None:
    """Opcodes and lengths; no checksum but that of all data guards them."""
    for opcode in (Opcode.ATTACHMENT, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.DATA_END, Opcode.STATISTICS):
        path.write_bytes(content)
        start, _ = spans(path, opcode)[-1]
        for bit in range(0, 72, 5):
            bad = flipped(content, start + bit // 8, bit % 8)
            path.write_bytes(bad)
            result = repair(path)
            assert result.needed
            kept = result.original
            assert kept is None or kept.read_bytes() == bad
            assert kept is not None or result.scans == SCANS
            assert result.scans == SCANS or result.damaged
            if kept is not None:
                kept.unlink()


@pytest.mark.parametrize("more", [b"x", b"twice"])
def test_what_is_behind_the_end_is_not_thrown_away(path: Path, content: bytes, more: bytes) -> None:
    bad = content + (content if more == b"twice" else more)
    path.write_bytes(bad)
    result = repair(path)
    size = len(bad) - len(content)
    assert result.notes == [f"damaged at byte {len(content):,}: {size:,} bytes follow its end"]
    assert path.read_bytes() == content
    assert result.original is not None
    assert result.original.read_bytes() == bad


def test_an_earlier_original_is_not_replaced(path: Path, content: bytes) -> None:
    for number, name in enumerate(["run.mcap.orig", "run.mcap.orig1", "run.mcap.orig2"]):
        path.write_bytes(content + bytes([number]))
        assert repair(path).original == path.with_name(name)
    assert path.with_name("run.mcap.orig").read_bytes() == content + b"\0"


@pytest.mark.slow
def test_damaged_metadata_are_noted_and_not_signed_anew_in_silence(path: Path, content: bytes) -> None:
    start, end = spans(path, Opcode.METADATA)[0]
    place = content.index(b"4.1", start, end)
    bad = content[:place] + b"2.1" + content[place + 3 :]
    path.write_bytes(bad)
    status, *_ = run(path, "--out", path.with_name("other.mcap"))
    assert status == 1
    shown = CliRunner().invoke(build(), ["show", str(path)]).stdout
    assert "note: damaged data: their CRC does not fit" in shown
    result = repair(path)
    assert (result.scans, result.damaged) == (SCANS, 1)
    assert result.original is not None
    assert result.original.read_bytes() == bad


def test_a_trace_without_a_crc_of_its_data_is_left_alone() -> None:
    """Those of the golden library were recorded before there was one."""
    for golden in sorted((Path(__file__).parents[3] / "tests" / "golden" / "recordings").glob("*.mcap"))[:10]:
        assert not repair(golden, golden.with_name("not written.mcap")).needed


def test_a_trace_that_the_stock_reader_cannot_read_is_not_called_whole(tmp_path: Path) -> None:
    """Another tool's trace whose chunk index leads nowhere: its summary has no checksum."""
    path = tmp_path / "other.mcap"
    schema = scan_schema(SLOTS)
    with path.open("wb") as file:
        writer = Writer(file, enable_crcs=False)
        writer.start("ros2", "another tool")
        channel = writer.register_channel(
            "/scan", "cdr", writer.register_schema(schema.name, "ros2msg", schema.text.encode())
        )
        slot = {"slot.1.module": "amci3601", "slot.1.firmware": "4.1"}
        writer.add_metadata("scanrack", {"format": "1", "slots": "1", **slot})
        for scan in range(SCANS):
            writer.add_message(channel, scan, SCAN_HEAD.pack(CDR_PREFIX, scan, 1) + bytes(32), scan, scan)
        writer.finish()
    assert not repair(path).needed
    start, _ = spans(path, Opcode.CHUNK_INDEX)[0]
    path.write_bytes(flipped(path.read_bytes(), start + 9 + 16, 3))  # where the chunk is, after two times
    result = repair(path)
    assert result.notes[0].startswith("the stock reader can't read it to its end: ")
    assert result.scans == SCANS
    assert not repair(path).needed


def line_trace(path: Path) -> int:
    """Record a serial line; return how many messages there are."""
    recorder = LineRecorder(path, [UnitColumns(1, ["position"])], {"controller": "pmc006"})
    for number in range(9000):
        recorder.received(number, bytes([number % 256]) * 20)
        recorder.unit(number, 1, {"position": number})
    recorder.close()
    return 18_000


@pytest.mark.slow
def test_the_trace_of_a_serial_line_is_completed(tmp_path: Path) -> None:
    path = tmp_path / "line.mcap"
    messages = line_trace(path)
    content = path.read_bytes()
    assert run(path) == (0, f"{path}: 18,000 messages of a line, nothing to repair\n", "")
    path.write_bytes(content[:-50])
    status, out, _ = run(path)
    assert (status, out) == (0, f"{path}: repaired, 18,000 messages of a line, {len(content):,} bytes\n")
    assert path.read_bytes() == content
    start, _ = spans(path, Opcode.CHUNK)[-1]
    path.write_bytes(content[: start + 100])
    assert 0 < repair(path).messages < messages
    with path.open("rb") as file:
        assert sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages()) == repair(path).messages


@pytest.mark.slow
def test_no_flipped_bit_in_a_channel_hides_a_topic_in_silence(path: Path, content: bytes) -> None:
    """One in the summary hid 8 of 23 events; of a killed trace there is only the record at its beginning."""
    with open_trace(path) as trace:
        expected = list(trace)
    channels = spans(path, Opcode.CHANNEL)
    cut = spans(path, Opcode.DATA_END)[0][0]
    for whole in (content, content[:cut]):
        for start, end in channels:
            for bit in range(8 * start, 8 * min(end, len(whole)), 7):
                path.write_bytes(flipped(whole, bit // 8, bit % 8))
                try:
                    with open_trace(path) as trace:
                        found = list(trace)
                        notes = [
                            note for note in trace.notes if not note.startswith(("it has no end", "the last"))
                        ]
                except TraceError:
                    continue
                assert found == expected or notes
