"""Two traces compared block by block give what they give scan by scan, wherever a block ends.

Broken on purpose: a block's scans without those within the tolerance before or behind it, scans of one
time read in part, scans at the border's very time counted to the block before, the last scans before a
block forgotten, the last block without what is late: each turns it red.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_compare import plainly
from scanrack.traces import SlotInfo
from scanrack.traces.compare import SAME_CLOCK, TimeMap, Tolerance, blocks, compare_parts, findings
from scanrack.traces.read.columns import Columns

SLOTS = (SlotInfo(1, "amci3601", "4.1"), SlotInfo(4, "a toy"))
TICKS = 120
GAPS = np.array([0, 1, 1, 2, 2, 3, 9, 40])
COLUMNS = np.array([0, 1, 6, 8, 9, 10, 11, 12, 20, 25])  # words in which something happens, either mode


@pytest.fixture(scope="module", autouse=True)
def _short_reports() -> Iterator[None]:
    """A report looks back one scan, so that what is farther back is forgotten, but for the tolerance."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(findings, "LOOKED_AT", 1)
        patch.setattr(blocks, "LOOKED_AT", 1)
        yield


def signal(rng: np.random.Generator) -> np.ndarray:
    """Return words by time: each changes now and then."""
    words = np.zeros((TICKS, 32), np.int16)
    for column in COLUMNS:
        kept = np.maximum.accumulate(np.where(rng.random(TICKS) < 0.1, np.arange(TICKS), 0))
        words[:, column] = rng.integers(-3, 4, TICKS)[kept] if column > 8 else rng.integers(0, 4, TICKS)[kept]
    if rng.random() < 0.3:
        words[30:50, 8] = -0x8000  # configuration mode
    return words


def sampled(rng: np.random.Generator, words: np.ndarray, scans: int, since: int, late: int) -> Columns:
    """Return scans of a signal from a time on, at times of their own, a few of them with another word."""
    times = since + np.cumsum(rng.choice(GAPS, scans))
    images = words[np.clip(times - late, 0, TICKS - 1)]
    flipped = rng.random(scans) < 0.05
    images[flipped, rng.choice(COLUMNS)] ^= 1
    first = int(rng.choice([0, 0, 5]))
    numbers = np.arange(first, first + scans, dtype=np.int64)
    return Columns(numbers, times.astype(np.int64), np.ones(scans, np.uint32), images)


def in_parts(columns: Columns, size: int) -> Iterator[Columns]:
    yield columns.rows(0, 0)
    for start in range(0, len(columns.scan), size):
        yield columns.rows(start, start + size)


SIZES = st.integers(0, 40)


@pytest.mark.slow
@settings(max_examples=amount(80))
@given(
    seed=st.integers(0, 2**32 - 1),
    scans=st.tuples(SIZES, SIZES),
    since=st.tuples(st.integers(0, 60), st.integers(0, 60)),
    late=st.integers(-2, 2),
    tolerance=st.builds(Tolerance, st.integers(0, 12), st.integers(0, 2)),
    shift=st.sampled_from([0, 0, -7, 30]),
    block=st.integers(1, 12),
    part=st.integers(1, 9),
)
def test_a_comparison_by_time_does_not_depend_on_its_blocks(
    seed: int,
    scans: tuple[int, int],
    since: tuple[int, int],
    late: int,
    tolerance: Tolerance,
    shift: int,
    block: int,
    part: int,
) -> None:
    rng = np.random.default_rng(seed)
    words = signal(rng)
    one = sampled(rng, words, scans[0], since[0], 0)
    other = sampled(rng, words, scans[1], since[1], late)
    clock = TimeMap((shift,), (0,)) if shift else SAME_CLOCK
    if tolerance.exact and clock == SAME_CLOCK:
        tolerance = Tolerance(1)
    found = compare_parts(
        (SLOTS, in_parts(one, part)),
        (SLOTS, in_parts(other, part)),
        tolerance,
        clock=clock,
        block_scans=block,
    )
    assert found == plainly(SLOTS, one, other, tolerance, clock)


@pytest.mark.slow
@settings(max_examples=amount(40))
@given(
    seed=st.integers(0, 2**32 - 1),
    scans=SIZES,
    missing=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    block=st.integers(1, 12),
    part=st.integers(1, 9),
)
def test_a_comparison_by_number_does_not_depend_on_its_blocks(
    seed: int, scans: int, missing: tuple[float, float], block: int, part: int
) -> None:
    rng = np.random.default_rng(seed)
    one = sampled(rng, signal(rng), scans, 0, 0)
    words = one.words.copy()
    words[rng.random(scans) < 0.05, rng.choice(COLUMNS)] ^= 1
    other = one._replace(words=words)
    a, b = (
        side.at(np.flatnonzero(rng.random(scans) >= share * (rng.random() < 0.5)))
        for side, share in zip((one, other), missing, strict=True)
    )
    found = compare_parts((SLOTS, in_parts(a, part)), (SLOTS, in_parts(b, part)), block_scans=block)
    assert found == plainly(SLOTS, a, b, Tolerance(), SAME_CLOCK)


@pytest.mark.parametrize("block", [1, 2, 3, 100])
def test_numbers_that_begin_anew_are_set_against_those_of_the_same_run(block: int) -> None:
    """Scans 5, 6, 7, then 0 to 3; scan 2 of the second run differs."""
    numbers = np.array([5, 6, 7, 0, 1, 2, 3])
    one = Columns(numbers, np.arange(7), np.ones(7, np.uint32), np.zeros((7, 32), np.int16))
    words = one.words.copy()
    words[5, 25] = 1
    other = one._replace(words=words).at(np.array([0, 2, 3, 4, 5, 6]))
    found = compare_parts((SLOTS, in_parts(one, 2)), (SLOTS, in_parts(other, 3)), block_scans=block)
    assert found.first is not None
    assert (found.first.scan, found.first.scan_b) == (2, 2)
    assert (found.differing, found.only_a, found.only_b) == (1, 1, 0)


def test_scans_of_one_time_are_all_met_though_they_come_in_two_parts() -> None:
    """What the first trace shows at 0 ns the second shows at 2 ns, but not in its first scan at 2 ns."""
    numbers, flags, words = np.arange(4), np.ones(4, np.uint32), np.zeros((4, 32), np.int16)
    early, late = words.copy(), words.copy()
    early[[0, 2, 3], 25] = late[2:, 25] = 1
    one = Columns(numbers, np.array([0, 1, 20, 30]), flags, early)
    other = Columns(numbers, np.array([0, 2, 2, 20]), flags, late)
    found = compare_parts((SLOTS, in_parts(one, 1)), (SLOTS, in_parts(other, 1)), Tolerance(2), block_scans=1)
    assert found.first is None


@pytest.mark.parametrize("part", [1, 3, 4, 9])
def test_time_that_goes_back_between_two_parts_is_refused(part: int) -> None:
    times = np.array([0, 2, 4, 5, 4, 6])
    one = Columns(np.arange(6), times, np.ones(6, np.uint32), np.zeros((6, 32), np.int16))
    with pytest.raises(ValueError, match="time goes back in scan 4"):
        compare_parts((SLOTS, []), (SLOTS, in_parts(one, part)), Tolerance(1), block_scans=2)
