"""Scans packed in memory are the scans that were added; a replay compares them chunk by chunk."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from made_traces import A3601, idle, record
from scanrack.traces import open_trace
from scanrack.traces.compare import compare_parts
from scanrack.traces.follower import Follower
from scanrack.traces.read import packed
from scanrack.traces.read.columns import Columns, join
from scanrack.traces.read.packed import PackedScans, memory_blocks
from scanrack.traces.replay import PackedTrace


def columns_of(count: int, first: int = 0, slots: int = 1) -> Columns:
    numbers = np.arange(first, first + count, dtype=np.int64)
    words = np.multiply.outer(numbers, np.arange(16 * slots)).astype(np.int16)
    return Columns(numbers, 3 * numbers, (numbers % 7).astype(np.uint32), words)


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of eight scans."""
    monkeypatch.setattr(packed, "CHUNK_SCANS", 8)


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("parts", [[], [1], [8], [3, 5], [7, 2], [30], [1] * 20, [8, 8, 1]])
def test_what_was_added_is_there(parts: list[int]) -> None:
    added, first = [], 0
    for count in parts:
        added.append(columns_of(count, first, slots=2))
        first += count
    scans = PackedScans.of(32, added)
    whole = join([columns_of(0, slots=2), *added])
    assert len(scans) == len(whole.scan)
    for column, expected in zip(scans.columns().images(), whole.images(), strict=True):
        np.testing.assert_array_equal(column, expected)
        assert column.dtype == expected.dtype
    numbers, memory = scans.view(lambda columns: columns.scan.tolist()), scans.view(memory_blocks)
    assert list(numbers) == whole.scan.tolist()
    assert list(memory) == memory_blocks(whole)
    assert numbers[2:11:3] == whole.scan[2:11:3].tolist()
    if whole.scan.size:
        assert (numbers[-1], numbers[0]) == (whole.scan[-1], 0)
    with pytest.raises(IndexError):
        numbers[len(scans)]


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("differing", [None, 0, 7, 8, 20, 39])
@pytest.mark.parametrize("stopping", [True, False])
def test_a_replay_is_compared_as_two_traces_are(
    tmp_path: Path, differing: int | None, stopping: bool
) -> None:
    words = idle(40)
    words[:, 10] = np.arange(40)
    with open_trace(record(tmp_path / "run.mcap", words)) as trace:
        recording = PackedTrace.of(trace)
    memory = bytearray(32)
    follower = Follower(recording, memory, [(1, "in")])
    if stopping:
        follower.stop = lambda: None
    answers = words.copy()
    answers[:, 0] = 99  # of the output image, which is not compared
    if differing is not None:
        answers[differing, 8] ^= 1
    recorded = recording.columns
    for row, answer in enumerate(answers):
        memory[:] = answer.tobytes()
        follower.scan(row, int(recorded.time_ns[row]), 1)
        if follower.stopped:
            break
    found = follower.comparison()
    count = follower.scans
    expected = compare_parts(
        ([A3601], [recorded.rows(0, count)]),
        ([A3601], [recorded.rows(0, count)._replace(words=answers[:count])]),
        only=frozenset({(1, "in")}),
    )
    assert found.same is (differing is None)
    assert count == (40 if differing is None or not stopping else differing + 1)
    assert (found.scans_a, found.scans_b, found.differing) == (count, count, expected.differing)
    assert found.extents == expected.extents
    if expected.first is not None:
        assert found.first is not None
        assert (found.first.scan, found.first.details) == (expected.first.scan, expected.first.details)


def test_a_recording_in_memory_takes_a_few_bytes_a_scan(tmp_path: Path) -> None:
    """As columns a scan takes 52 bytes, as lists 400 more."""
    path = record(tmp_path / "run.mcap", idle(100_000), chunk_scans=4096)
    tracemalloc.start()
    with open_trace(path) as trace:
        recording = PackedTrace.of(trace)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(recording.scans) == 100_000
    assert held < 20 * 100_000
