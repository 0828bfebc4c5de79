"""Traces read by software that others wrote: the mcap reader and the ROS 2 decoder."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import ChunkIndex
from scanrack.io_images.image import Image
from scanrack.traces import ScanRecorder, SlotInfo

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(3, "amci3601", "2.0"), SlotInfo(12, "a toy")]
# fmt: off
NAMED = (
    ["command_msw", "command_lsw", "target_msw", "target_lsw",
     "speed_msw", "speed_lsw", "acceleration", "deceleration"],
    ["status_msw", "status_lsw", "position_msw", "position_lsw",
     "encoder_msw", "encoder_lsw", "captured_msw", "captured_lsw"],
)
# fmt: on
PLAIN = [f"word{index}" for index in range(8)]
SCANS = 500
GOLDEN = Path(__file__).parents[1] / "golden" / "recordings"
CHUNK_SCANS = 60


def words(scan: int, image: int) -> list[int]:
    """Return eight words that tell scan, image and word apart, negative ones among them."""
    return [(scan * 48 + image * 8 + word) * 7 % 65_536 - 32_768 for word in range(8)]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("peers") / "run.mcap"
    memory = bytearray(32 * len(SLOTS))
    images = [Image(buffer=memoryview(memory)[16 * place : 16 * place + 16]) for place in range(6)]
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, chunk_scans=CHUNK_SCANS)
    for scan in range(SCANS):
        for place, image in enumerate(images):
            image.load(Image(words(scan, place)))
        if scan % 100 == 0:
            recorder.event(scan, scan * 2_000_000, "/cpu", {"mode": f"mode {scan}"})
        recorder.scan(scan, scan * 2_000_000, scan % 4)
    recorder.close()
    return path


def test_the_stock_reader_reads_all_of_it_with_crcs(path: Path) -> None:
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        scans = list(reader.iter_messages("/scan"))
        modes = list(reader.iter_messages("/cpu"))
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == SCANS + 5
    counts = {
        summary.channels[channel].topic: count
        for channel, count in summary.statistics.channel_message_counts.items()
    }
    assert counts == {"/scan": SCANS, "/cpu": 5}
    assert summary.statistics.attachment_count == 1
    assert summary.statistics.metadata_count == 1
    assert len(summary.chunk_indexes) >= SCANS // CHUNK_SCANS
    assert [message.sequence for _, _, message in scans] == list(range(SCANS))
    assert [message.log_time for _, _, message in scans] == [2_000_000 * scan for scan in range(SCANS)]
    assert [message.sequence for _, _, message in modes] == [0, 100, 200, 300, 400]


def test_the_stock_reader_reads_it_as_a_stream(path: Path) -> None:
    with path.open("rb") as file:
        messages = list(NonSeekingReader(file, validate_crcs=True).iter_messages("/scan"))
    assert [message.sequence for _, _, message in messages] == list(range(SCANS))


def in_file_order(path: Path) -> list[int]:
    """Return the times of all messages, as they lie in the file."""
    with path.open("rb") as file:
        messages = make_reader(file).iter_messages(log_time_order=False)
        return [message.log_time for _, _, message in messages]


def test_messages_lie_in_order_of_time(path: Path) -> None:
    """small-mcap 0.16.0 does not sort the messages of a chunk: findings/small-mcap-unsorted-chunk."""
    times = in_file_order(path)
    assert len(times) == SCANS + 5
    assert times == sorted(times)


@pytest.mark.slow
def test_messages_of_golden_recordings_lie_in_order_of_time() -> None:
    recordings = sorted(GOLDEN.glob("*.mcap"))
    assert len(recordings) > 80
    unsorted = [each.name for each in recordings if in_file_order(each) != sorted(in_file_order(each))]
    assert unsorted == []


def test_message_indexes_lead_to_their_messages(path: Path) -> None:
    """The stock reader does not follow the indexes; viewers do."""
    content = path.read_bytes()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    found = 0
    for chunk in summary.chunk_indexes:
        for channel, offset in chunk.message_index_offsets.items():
            opcode, _, named, size = struct.unpack_from("<BQHI", content, offset)
            assert (opcode, named) == (Opcode.MESSAGE_INDEX, channel)
            found += _follow(content, chunk, channel, offset + 15, size)
    assert found == SCANS + 5


def _follow(content: bytes, chunk: ChunkIndex, channel: int, offset: int, size: int) -> int:
    """Check that each entry of a message index leads to a message of its channel and time."""
    start = chunk.chunk_start_offset + chunk.chunk_length - chunk.compressed_size
    data = zstandard.decompress(content[start : start + chunk.compressed_size])
    assert len(data) == chunk.uncompressed_size
    for entry in range(offset, offset + size, 16):
        time, place = struct.unpack_from("<QQ", content, entry)
        opcode, _, named, _, log_time = struct.unpack_from("<BQHIQ", data, place)
        assert (opcode, named, log_time) == (Opcode.MESSAGE, channel, time)
    return size // 16


def test_the_ros2_decoder_reads_words_by_name(path: Path) -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
    names = {"slot1": NAMED, "slot3": NAMED, "slot12": (PLAIN, PLAIN)}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        decoded: list[Any] = [found.decoded_message for found in reader.iter_decoded_messages("/scan")]
    assert len(decoded) == SCANS
    for scan, message in enumerate(decoded):
        assert (message.scan, message.flags) == (scan, scan % 4)
        for place, slot in enumerate(["slot1", "slot3", "slot12"]):
            for direction, fields in enumerate(names[slot]):
                image = getattr(getattr(message, slot), ("outputs", "inputs")[direction])
                assert [getattr(image, field) for field in fields] == words(scan, 2 * place + direction)
