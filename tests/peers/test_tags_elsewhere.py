"""Recorded tags read by other people's decoders: in Python, and in JavaScript as viewers do."""

from __future__ import annotations

from pathlib import Path
from struct import pack
from typing import Any

import pytest
from foxglove_peer import decoded_scans
from made_tags import MadeTags
from mcap.reader import make_reader
from scanrack.traces import ScanRecorder, SlotInfo, Tag

SCANS = 300
SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "a toy")]
TAGS = [
    Tag("bool", "BOOL"),
    Tag("Count", "LINT"),
    Tag("Big", "ULINT"),
    Tag("Level", "REAL"),
    Tag("time", "LREAL"),
    Tag(r"\Main.Step", "ENUM", 0, ("IDLE", "wait for it")),
    Tag("Recipe[1].Times", "DINT", 3),
    Tag("Flags", "BOOL", 3),
    Tag("Medium", "TEXT"),
    Tag("Small", "SINT"),
]


def row(n: int) -> bytes:
    wide = pack("<qQdf3i", 2**53 + n, 2**64 - 1 - n, n / 4, n / 2, n, -n, 7)
    return wide + pack("<HH?3?b", n % 2, 0, n % 3 == 0, True, False, True, -5)


def wanted(n: int) -> dict[str, Any]:
    """Return the tags of a scan; 64-bit integers as text, as JSON has no others."""
    return {
        "count": str(2**53 + n),
        "big": str(2**64 - 1 - n),
        "time": n / 4,
        "level": n / 2,
        "recipe_1_times": [n, -n, 7],
        "main_step": {"value": n % 2},
        "medium": 0,
        "bool": n % 3 == 0,
        "flags": [True, False, True],
        "small": -5,
    }


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace with tags of every type."""
    path = tmp_path_factory.mktemp("tags") / "run.mcap"
    memory = bytearray(64)
    tags = MadeTags(memory, TAGS, row)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags, chunk_scans=70)
    for scan in range(SCANS):
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    return path


def plain(value: Any) -> Any:
    """Return a decoded value as `wanted` has it."""
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return list(map(plain, value)) if isinstance(value, list | tuple) else value


def test_mcap_ros2_support_reads_every_type(path: Path) -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
    found = []
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=["/scan"]):
            tags = plain(message.tags)
            found.append({**tags, "count": str(tags["count"]), "big": str(tags["big"])})
    assert found == [wanted(n) for n in range(SCANS)]


@pytest.mark.slow
def test_foxglove_reads_every_type(path: Path) -> None:
    assert decoded_scans(path) == [wanted(n) for n in range(SCANS)]
