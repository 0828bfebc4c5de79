"""A copy with decoded values, read by other people's decoders: in Python, and in JavaScript as viewers do."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from struct import pack
from typing import Any

import numpy as np
import pytest
from foxglove_peer import decoded_scans
from made_tags import MadeTags
from mcap.reader import make_reader
from scanrack.traces import ScanRecorder, SlotInfo, Tag, open_trace
from scanrack.traces.export import write_mcap

SCANS = 200
SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "a toy"), SlotInfo(4, "amci3601", "4.1")]
TAGS = [Tag("Level", "REAL"), Tag("Step", "ENUM", 0, ("IDLE", "FILL")), Tag("Lamp", "BOOL")]
CONFIGURED = range(50, 60)


def row(n: int) -> bytes:
    """Return tags of seven bytes: what follows them needs a gap of one byte."""
    return pack("<fH?", n / 2, n % 2, n % 3 == 0)


def position(n: int, slot: int) -> float | None:
    """Return where a slot is, steps; None while it is configured. It moves at 500 or 1,000 steps/s."""
    return None if slot == 1 and n in CONFIGURED else float(-n if slot == 1 else 2 * n)


@pytest.fixture(scope="module", params=["tags", "no tags"])
def copy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of a trace of two 3601s and a toy between them."""
    path, memory = tmp_path_factory.mktemp("decoded") / "run.mcap", bytearray(96)
    words = np.frombuffer(memory, np.int16)
    tags = MadeTags(memory, TAGS, row) if request.param == "tags" else None
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags, chunk_scans=70)
    for n in range(SCANS):
        words[8], words[10:12] = 0x4002, (0, -n)  # MODULE_OK, MOVING_CCW
        if n in CONFIGURED:
            words[8] = -0x4000  # MODE_CONFIG, MODULE_OK
        words[40], words[42:44] = 0x4001, (0, 2 * n)  # MODULE_OK, MOVING_CW
        words[32], words[34:36] = 1, (12, 345)  # ABSOLUTE_MOVE to 12,345
        recorder.scan(n, n * 2_000_000, 0)
    recorder.close()
    with open_trace(path) as trace:
        assert write_mcap(trace, path.with_name("copy.mcap")) == SCANS
    return path.with_name("copy.mcap")


def check(messages: list[Any]) -> None:
    """Check what a decoder made of the scans: positions, speeds, bits, and the tags before them."""
    assert len(messages) == SCANS
    for n, message in enumerate(messages):
        for slot in (1, 4):
            decoded = message["decoded"][f"slot{slot}"]
            wanted = position(n, slot)
            found = decoded["inputs"]["position"]
            assert (found is None or isnan(found)) if wanted is None else found == wanted
        assert message["decoded"]["slot1"]["inputs"]["mode_config"] is (n in CONFIGURED)
        assert message["decoded"]["slot1"]["inputs"]["moving_ccw"] is (n not in CONFIGURED)
        assert message["decoded"]["slot4"]["inputs"]["moving_cw"] is True
        assert message["decoded"]["slot4"]["inputs"]["moving_ccw"] is False
        assert message["decoded"]["slot4"]["outputs"]["absolute_move"] is True
        assert message["decoded"]["slot4"]["outputs"]["target"] == 12_345
        assert message["slot4"]["inputs"]["position_lsw"] == 2 * n
        if "tags" in message:
            tags = {"level": n / 2, "step": {"value": n % 2}, "lamp": n % 3 == 0}
            assert message["tags"] == tags
    # 10 ms either way: five scans of two steps, 2 ms each
    assert {message["decoded"]["slot4"]["speed"] for message in messages[6:-6]} == {1000}
    assert messages[100]["decoded"]["slot1"]["speed"] == -500


def plain(value: Any) -> Any:
    """Return a decoded value as `check` wants it."""
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return value


def test_mcap_ros2_support_reads_decoded_values(copy: Path) -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
    with copy.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        check([plain(message) for *_, message in reader.iter_decoded_messages(topics=["/scan"])])


@pytest.mark.slow
def test_foxglove_reads_decoded_values(copy: Path) -> None:
    check(decoded_scans(copy, whole=True))
