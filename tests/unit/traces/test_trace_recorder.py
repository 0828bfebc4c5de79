"""What a recorder puts into its file, byte by byte, and that equal runs give equal files."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import Attachment as AttachmentRecord
from mcap.records import Channel, Chunk, Header, Metadata, Schema
from mcap.stream_reader import StreamReader
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.traces import Attachment, Scan, ScanRecorder, SlotInfo, open_trace
from scanrack.traces.format.schema import scan_schema

ONE_SLOT = [SlotInfo(1, "amci3601", "4.1")]
PERIOD = 2_000_000


def top_level(path: Path) -> list[object]:
    with path.open("rb") as file:
        return list(StreamReader(file, emit_chunks=True).records)


def test_the_payload_of_one_scan_byte_by_byte(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    memory = bytearray(32)
    recorder = ScanRecorder(path, memory, ONE_SLOT, scan_period_ns=PERIOD)
    # outputs: relative move (0002h), 12,345 steps, 5000 steps/s, 20 and 10 steps/ms/s
    memory[:16] = bytes.fromhex("0200 0000 0C00 5901 0500 0000 1400 0A00")
    # inputs: MODULE_OK, MOVING_CW, ACCELERATING (4021h); position -12,345 (FFF4h FEA7h)
    memory[16:] = bytes.fromhex("2140 0000 F4FF A7FE 0000 0000 0000 0000")
    recorder.scan(0x0102_0304, 7 * PERIOD, 0x0A)
    recorder.close()
    with path.open("rb") as file:
        ((_, _, message),) = make_reader(file, validate_crcs=True).iter_messages("/scan")
    assert message.data.hex(" ", 4) == (
        "00010000"  # CDR, little-endian
        " 04030201"  # scan
        " 0a000000"  # flags
        " 02000000 0c005901 05000000 14000a00"
        " 21400000 f4ffa7fe 00000000 00000000"
    )
    assert (message.sequence, message.log_time, message.publish_time) == (0x0102_0304, 7 * PERIOD, 7 * PERIOD)


def test_every_scan_is_a_copy_of_the_memory_block_at_that_time(tmp_path: Path) -> None:
    memory = bytearray(64)
    slots = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(4, "amci3601", "2.0")]
    recorder = ScanRecorder(tmp_path / "two.mcap", memory, slots, scan_period_ns=PERIOD, chunk_scans=7)
    for scan in range(50):
        memory[:] = bytes((scan + place) % 256 for place in range(64))
        recorder.scan(scan, scan * PERIOD, 1)
    recorder.close()
    with open_trace(tmp_path / "two.mcap") as trace:
        scans = list(trace.scans())
    assert [scan.scan for scan in scans] == list(range(50))
    for each in scans:
        expected = bytes((each.scan + place) % 256 for place in range(64))
        images = (each.outputs(1), each.inputs(1), each.outputs(4), each.inputs(4))
        assert b"".join(bytes(image) for image in images) == expected


def test_a_scan_number_beyond_32_bits_wraps(tmp_path: Path) -> None:
    recorder = ScanRecorder(tmp_path / "long.mcap", bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    recorder.scan(2**32 + 5, 1, 0)
    recorder.close()
    with open_trace(tmp_path / "long.mcap") as trace:
        assert [scan.scan for scan in trace.scans()] == [5]


def test_head_comes_before_the_first_chunk(tmp_path: Path) -> None:
    path = tmp_path / "head.mcap"
    program = Attachment("logic.py", b"def logic(scan): pass\n", "text/x-python")
    rack = Attachment("rack.toml", "period = '2 ms'  # µs\n".encode())
    recorder = ScanRecorder(
        path,
        bytearray(64),
        [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "something else")],
        scan_period_ns=PERIOD,
        seed=42,
        program=program,
        rack_file=rack,
        metadata={"exchange": "every 2 ms"},
    )
    recorder.scan(0, 0, 0)
    recorder.close()
    records = top_level(path)
    head = records[: next(index for index, record in enumerate(records) if isinstance(record, Chunk))]
    assert isinstance(head[0], Header)
    assert head[0].profile == "ros2"
    assert head[0].library.startswith("scanrack ")
    topics = [record.topic for record in head if isinstance(record, Channel)]
    assert topics == ["/scan", "/events", "/stimuli", "/indicators", "/forces", "/cpu", "/faults"]
    assert len([record for record in head if isinstance(record, Schema)]) == 7
    (metadata,) = [record for record in head if isinstance(record, Metadata)]
    assert metadata.name == "scanrack"
    facts = dict(metadata.metadata)
    assert facts.pop("scanrack")
    assert facts.pop("mcap")
    assert len(facts.pop("layout")) == 12
    assert facts == {
        "format": "1",
        "scan_period_ns": "2000000",
        "seed": "42",
        "slots": "1 2",
        "slot.1.module": "amci3601",
        "slot.1.firmware": "4.1",
        "slot.2.module": "something else",
        "slot.2.firmware": "",
        "program_sha256": hashlib.sha256(program.data).hexdigest(),
        "rack_sha256": hashlib.sha256(rack.data).hexdigest(),
        "exchange": "every 2 ms",
    }
    attached = {record.name: record for record in head if isinstance(record, AttachmentRecord)}
    assert list(attached) == ["logic.py", "rack.toml", "words.json"]
    assert attached["rack.toml"].data == rack.data
    assert {(record.create_time, record.log_time) for record in attached.values()} == {(0, 0)}


def test_the_word_map_names_words_and_bits(tmp_path: Path) -> None:
    recorder = ScanRecorder(tmp_path / "map.mcap", bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    recorder.close()
    with open_trace(tmp_path / "map.mcap") as trace:
        (attachment,) = trace.attachments()
    table = json.loads(attachment.data)["amci3601"]
    # chapter 5: word 0 bit 1 relative move; chapter 3: word 1 bits 0 to 5 active levels; chapter 6
    assert table["out"][6:] == ["acceleration", "deceleration"]
    assert table["in"][4:6] == ["encoder_msw", "encoder_lsw"]
    assert table["bits"]["out, command mode"]["0"]["1"] == "RELATIVE_MOVE"
    assert table["bits"]["out, configuration mode"]["1"]["3"] == "ESTOP"
    assert table["bits"]["in, command mode"]["1"]["9"] == "BLEND_ACK"
    assert len(table["bits"]["in, command mode"]["0"]) == 16


def test_events_are_json_with_the_scan(tmp_path: Path) -> None:
    path = tmp_path / "events.mcap"
    recorder = ScanRecorder(path, bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    recorder.event(
        3, 6_100_000, "/events", {"slot": 1, "kind": "rule", "name": "CMD-03", "text": "µ", "n": None}
    )
    recorder.scan(3, 8_000_000, 0)
    recorder.close()
    with path.open("rb") as file:
        ((schema, channel, message),) = make_reader(file, validate_crcs=True).iter_messages("/events")
    assert message.data.decode() == '{"scan":3,"slot":1,"kind":"rule","name":"CMD-03","text":"µ","n":null}'
    assert (message.sequence, message.log_time, message.publish_time) == (3, 6_100_000, 6_100_000)
    assert channel.message_encoding == "json"
    assert schema is not None
    assert (schema.name, schema.encoding) == ("scanrack.Event", "jsonschema")
    described = json.loads(schema.data)
    assert described["type"] == "object"
    assert described["required"] == ["scan"]
    assert set(described["properties"]) == {"scan", "slot", "kind", "name", "text"}


def test_a_state_is_written_on_change_only_and_an_occurrence_each_time(tmp_path: Path) -> None:
    recorder = ScanRecorder(tmp_path / "states.mcap", bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    for scan, mode in enumerate(["run", "run", "test", "run"]):
        recorder.event(scan, scan, "/cpu", {"mode": mode})
        recorder.event(scan, scan, "/stimuli", {"name": "HOME"})
    recorder.close()
    with open_trace(tmp_path / "states.mcap") as trace:
        events = list(trace.events())
    assert [(event.scan, event.fields["mode"]) for event in events if event.topic == "/cpu"] == [
        (0, "run"),
        (2, "test"),
        (3, "run"),
    ]
    assert [event.scan for event in events if event.topic == "/stimuli"] == [0, 1, 2, 3]


def test_an_unknown_topic_is_refused(tmp_path: Path) -> None:
    recorder = ScanRecorder(tmp_path / "topic.mcap", bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    with pytest.raises(ValueError, match="topic '/weather' is not recorded; choose from /events, /stimuli"):
        recorder.event(0, 0, "/weather", {})
    recorder.close()


@pytest.mark.parametrize(
    ("slots", "size", "why"),
    [
        ([], 0, "at least one slot"),
        ([SlotInfo(1, "amci3601"), SlotInfo(1, "amci3601")], 64, "slot 1 is given twice"),
        ([SlotInfo(-1, "amci3601")], 32, "slot -1: slot numbers are 0 or more"),
        ([SlotInfo(1, "amci3601")], 64, "1 slots need a memory block of 32 bytes, got 64"),
    ],
)
def test_slots_that_do_not_fit_are_refused(
    tmp_path: Path, slots: list[SlotInfo], size: int, why: str
) -> None:
    path = tmp_path / "refused.mcap"
    with pytest.raises(ValueError, match=why):
        ScanRecorder(path, bytearray(size), slots, scan_period_ns=PERIOD)
    assert not path.exists()


def test_close_may_be_called_again(tmp_path: Path) -> None:
    recorder = ScanRecorder(tmp_path / "closed.mcap", bytearray(32), ONE_SLOT, scan_period_ns=PERIOD)
    recorder.close()
    recorder.close()
    with open_trace(tmp_path / "closed.mcap") as trace:
        assert list(trace) == []
        assert trace.notes == []


def test_the_schema_of_three_slots_word_by_word() -> None:
    rule = 80 * "="
    slots = [SlotInfo(1, "amci3601"), SlotInfo(2, "toy"), SlotInfo(7, "amci3601")]
    assert (
        scan_schema(slots).text
        == f"""\
uint32 scan
uint32 flags
Amci3601 slot1
Plain slot2
Amci3601 slot7
{rule}
MSG: scanrack/Amci3601
Amci3601Out outputs
Amci3601In inputs
{rule}
MSG: scanrack/Amci3601Out
int16 command_msw
int16 command_lsw
int16 target_msw
int16 target_lsw
int16 speed_msw
int16 speed_lsw
int16 acceleration
int16 deceleration
{rule}
MSG: scanrack/Amci3601In
int16 status_msw
int16 status_lsw
int16 position_msw
int16 position_lsw
int16 encoder_msw
int16 encoder_lsw
int16 captured_msw
int16 captured_lsw
{rule}
MSG: scanrack/Plain
PlainOut outputs
PlainIn inputs
{rule}
MSG: scanrack/PlainOut
int16 word0
int16 word1
int16 word2
int16 word3
int16 word4
int16 word5
int16 word6
int16 word7
{rule}
MSG: scanrack/PlainIn
int16 word0
int16 word1
int16 word2
int16 word3
int16 word4
int16 word5
int16 word6
int16 word7
"""
    )


def test_layouts_differ_in_name_and_firmware_does_not_matter() -> None:
    names = {
        scan_schema(slots).name
        for slots in (
            [SlotInfo(1, "amci3601", "4.1")],
            [SlotInfo(2, "amci3601", "4.1")],
            [SlotInfo(1, "toy")],
            [SlotInfo(1, "amci3601"), SlotInfo(2, "amci3601")],
        )
    }
    assert len(names) == 4
    assert scan_schema([SlotInfo(1, "amci3601", "2.0")]).name in names


def test_the_recorder_is_a_scan_listener() -> None:
    for name in ("event", "scan", "close"):
        asked = inspect.signature(getattr(ScanListener, name))
        given = inspect.signature(getattr(ScanRecorder, name))
        assert list(given.parameters) == list(asked.parameters)


RUN = """
import random, sys
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.write.recorder import Attachment, ScanRecorder
memory = bytearray(96)
slots = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "toy"), SlotInfo(5, "amci3601", "2.0")]
recorder = ScanRecorder(sys.argv[1], memory, slots, scan_period_ns=2_000_000, seed=7,
    program=Attachment("p.py", b"x = 1"), metadata={"exchange": "end of scan"})
chance = random.Random(7)
recorder.event(0, 0, "/cpu", {"mode": "run"})
for scan in range(3000):
    memory[chance.randrange(96)] = chance.randrange(256)
    if chance.random() < 0.01:
        recorder.event(scan, scan * 2_000_000, "/events", {"slot": 1, "kind": "rule", "name": "CMD-03"})
    recorder.scan(scan, scan * 2_000_000, 1)
recorder.close()
"""


@pytest.mark.slow
def test_equal_runs_in_two_processes_give_equal_bytes(tmp_path: Path) -> None:
    files = []
    for seed in ("1", "4711"):
        path = tmp_path / seed / "run.mcap"
        path.parent.mkdir()
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", RUN, str(path)], env=environment, check=True, timeout=120)
        files.append(path.read_bytes())
    assert files[0] == files[1]
    assert len(files[0]) > 20_000
    with open_trace(tmp_path / "1" / "run.mcap") as trace:
        assert sum(isinstance(entry, Scan) for entry in trace) == 3000


def test_a_recorder_writes_without_numpy(tmp_path: Path) -> None:
    code = (
        "import sys\n"
        "from scanrack.traces.format.layout import SlotInfo\n"
        "from scanrack.traces.write.recorder import ScanRecorder\n"
        "slots = [SlotInfo(1, 'amci3601', '4.1')]\n"
        "recorder = ScanRecorder('one.mcap', bytearray(32), slots, scan_period_ns=2_000_000)\n"
        "recorder.scan(0, 0, 1)\n"
        "recorder.close()\n"
        "print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, check=True)
    assert done.stdout.split() == [b"False"]
    with open_trace(tmp_path / "one.mcap") as trace:
        assert [scan.scan for scan in trace.scans()] == [0]
