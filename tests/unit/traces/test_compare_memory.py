"""What a comparison holds in memory is some blocks, however long the traces are and however they differ.

A scan of one slot takes 52 bytes: two traces of 100,000 scans take 10.4 MB, and comparing them at once by
time takes five times as much. The bound is 4 MB: blocks of 4,096 scans of both, and what is computed of them.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator

import numpy as np
import pytest
from made_traces import A3601, idle
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs.replay.input_levels import recorded_levels
from scanrack.traces.compare import EXACT, Tolerance, compare_parts
from scanrack.traces.follower import Follower
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.replay import PackedTrace

SCANS = 100_000
BLOCK = 4096
MB = 1_000_000


def parts(
    rows: range = range(SCANS), *, off: int = 0, late_ns: int = 0, size: int = 1000
) -> Iterator[Columns]:
    """Yield scans of a position that counts back and forth, made as they are asked for."""
    for start in range(rows.start, rows.stop, size):
        numbers = np.arange(start, min(start + size, rows.stop), dtype=np.int64)
        words = np.zeros((len(numbers), 16), np.int16)
        words[:, 11] = np.abs(numbers % 1000 - 500) + off
        yield Columns(numbers, 2_000_000 * numbers + late_ns, np.ones(len(numbers), np.uint32), words)


@pytest.fixture(autouse=True, scope="module")
def _everything_loaded() -> None:
    """Import what a comparison imports when it is first needed: that is no memory of its own."""
    peak_of(parts(range(10)), parts(range(10), off=9), EXACT, 10)


def peak_of(one: Iterator[Columns], other: Iterator[Columns], tolerance: Tolerance, differing: int) -> int:
    """Compare, check how many scans differ, and return the most memory that was in use, bytes."""
    tracemalloc.start()
    found = compare_parts(([A3601], one), ([A3601], other), tolerance, block_scans=BLOCK)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.differing == differing
    return peak


@pytest.mark.parametrize(
    "tolerance", [Tolerance(4_000_000), Tolerance(counts=9)], ids=["within a time", "within counts"]
)
def test_two_that_are_the_same_within_a_tolerance(tolerance: Tolerance) -> None:
    off = tolerance.counts
    assert peak_of(parts(), parts(off=off, late_ns=tolerance.time_ns), tolerance, 0) < 4 * MB


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [EXACT, Tolerance(counts=2)], ids=["exactly", "within counts"])
def test_two_that_differ_in_every_scan(tolerance: Tolerance) -> None:
    assert peak_of(parts(), parts(off=9), tolerance, SCANS) < 4 * MB


@pytest.mark.slow
@pytest.mark.parametrize("short", [range(10), range(50_000, 50_010), range(99_990, SCANS)], ids=str)
@pytest.mark.parametrize("tolerance", [EXACT, Tolerance(4_000_000)], ids=["exactly", "within a time"])
def test_one_that_is_much_longer(short: range, tolerance: Tolerance) -> None:
    assert peak_of(parts(short), parts(), tolerance, 0) < 4 * MB
    assert peak_of(parts(), parts(short), tolerance, 0) < 4 * MB


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [EXACT, Tolerance(4_000_000)], ids=["exactly", "within a time"])
def test_a_replay_that_goes_on_after_a_difference(tolerance: Tolerance) -> None:
    """Blocks have the size that they have for everyone; the answer is another one in nearly all scans."""
    recording = PackedTrace((A3601,), PackedScans.of(16, parts()), ())
    follower = Follower(recording, bytearray(32), [(1, "in")], tolerance=tolerance)
    for number, now_ns in zip(recording.numbers, recording.times, strict=True):
        follower.scan(number, now_ns, 1)
    tracemalloc.start()
    found = follower.comparison()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.scans_a == found.scans_b == SCANS
    assert [extent.name for extent in found.extents] == ["slot1.in.position"]
    assert peak < 10 * MB


def test_the_levels_of_a_recording_are_read_chunk_by_chunk() -> None:
    """HOME comes and goes every 100 scans of 20,000, which take 1.04 MB as columns."""
    (columns,) = [part._replace(words=idle(20_000)) for part in parts(range(20_000), size=20_000)]
    columns.words[:, 9] = np.where(np.arange(20_000) // 100 % 2, InputBit.HOME.value, 0)
    recording = PackedTrace((A3601,), PackedScans.of(16, [columns]), ())
    tracemalloc.start()
    stimuli = list(recorded_levels(recording))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(stimuli) == 6 + 199
    assert peak < 1 * MB
