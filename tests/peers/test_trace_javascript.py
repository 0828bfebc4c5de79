"""Traces read in JavaScript: by the reader that viewers use, which follows every index, and their decoders.

Node.js finds the packages through NODE_PATH, or in a `node_modules` above this folder:

    npm install @mcap/core fzstd @foxglove/rosmsg @foxglove/rosmsg2-serialization \\
        @lichtblick/rosmsg @lichtblick/rosmsg2-serialization @lichtblick/cdr
"""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_traces import PERIOD_NS, record
from scanrack.traces import SlotInfo, open_trace
from scanrack.traces.repair import repair

SCRIPT = Path(__file__).with_name("read_trace.cjs")
PACKAGES = (
    "@mcap/core",
    "fzstd",
    "@foxglove/rosmsg",
    "@foxglove/rosmsg2-serialization",
    "@lichtblick/rosmsg",
    "@lichtblick/rosmsg2-serialization",
    "@lichtblick/cdr",
)

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(3, "a toy"), SlotInfo(12, "amci3601", "2.0")]
SCANS = 300
FIRST, LAST = 130, 190
"""A slice of the scans, which begins and ends within chunks."""

WORDS = np.arange(SCANS * 48).reshape(SCANS, 48) * 7 % 65_536 - 32_768
EVENTS = {scan: ("/stimuli", {"name": "HOME"}) for scan in (0, 131, 299)}


@pytest.fixture(scope="module")
def node() -> str:
    found = shutil.which("node")
    if found is None:
        pytest.skip("node is not installed")
    for package in PACKAGES:
        script = f"require.resolve({package!r}, {{paths: [{str(SCRIPT.parent)!r}]}})"
        if subprocess.run([found, "-e", script], capture_output=True, check=False).returncode:
            pytest.skip(f"the npm package {package} is not installed where node finds it (NODE_PATH)")
    return found


def read(node: str, path: Path) -> dict[str, Any]:
    arguments = [node, str(SCRIPT), str(path), str(FIRST * PERIOD_NS), str(LAST * PERIOD_NS)]
    done = subprocess.run(
        arguments, capture_output=True, text=True, timeout=120, check=False, encoding="utf-8"
    )
    assert (done.returncode, done.stderr) == (0, "")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("javascript")
    return record(folder / "run.mcap", WORDS, SLOTS, events=EVENTS, chunk_scans=40)


def by_name(words: np.ndarray) -> dict[str, Any]:
    """Return the words of a scan as the decoders should give them."""
    slots: dict[str, Any] = {}
    for place, slot in enumerate(SLOTS):
        names = slot.words
        values = words[16 * place : 16 * place + 16].tolist()
        images = {"outputs": (names.outputs, values[:8]), "inputs": (names.inputs, values[8:])}
        slots[f"slot{slot.number}"] = {image: dict(zip(*pair, strict=True)) for image, pair in images.items()}
    return slots


def check(found: dict[str, Any], scans: int) -> None:
    events = sum(scan < scans for scan in EVENTS)
    assert found["counts"] == {"/scan": scans, "/stimuli": events}
    assert found["statistics"] == scans + events
    assert found["slice"] == list(range(LAST, FIRST - 1, -1))
    assert found["all"]["Message"] == scans + events
    assert found["all"]["ChunkIndex"] == found["chunks"]
    assert found["all"]["Footer"] == found["all"]["DataEnd"] == found["all"]["Statistics"] == 1
    assert found["attachments"] == ["words.json"]
    assert found["metadata"]["scanrack"]["slots"] == "1 3 12"
    assert found["chunks"] > 5
    for number, scan in enumerate(found["scans"]):
        assert (scan["sequence"], scan["logTime"]) == (number, number * PERIOD_NS)
        wanted = {"scan": number, "flags": 1} | by_name(WORDS[number])
        assert scan["decoded"] == [wanted, wanted]


@pytest.mark.slow
def test_every_message_is_found_through_the_indexes_and_decoded_by_name(node: str, path: Path) -> None:
    check(read(node, path), SCANS)


@pytest.mark.slow
def test_a_repaired_trace_is_read_as_well(node: str, path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    with open_trace(path) as trace:
        last_chunk = trace.sections[-1].span.offset
    cut.write_bytes(path.read_bytes()[: last_chunk + 100])
    scans = repair(cut).scans
    assert scans is not None
    assert LAST < scans < SCANS
    check(read(node, cut), scans)


def test_damage_is_seen(node: str, path: Path, tmp_path: Path) -> None:
    """The reader does check: what is wrong with a file makes it fail."""
    content = bytearray(path.read_bytes())
    content[content.index(b"\x04\0\0\0zstd") - 2] ^= 1  # the CRC of the first chunk
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(content)
    arguments = [node, str(SCRIPT), str(damaged), "0", "1"]
    done = subprocess.run(
        arguments, capture_output=True, text=True, timeout=120, check=False, encoding="utf-8"
    )
    assert done.returncode != 0
    assert "CRC" in done.stderr
