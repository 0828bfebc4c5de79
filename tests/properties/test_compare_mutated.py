"""Compare finds exactly what was changed, and tolerances let exactly so much pass.

Broken on purpose: comparing words as values (two pairs of one value), windows of `first:end - 1`,
`>` for `>=` in the tolerance, one direction only of a comparison by time: each turns a test red.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.thousands import split_reported
from scanrack.traces import SlotInfo
from scanrack.traces.compare import EXACT, Tolerance, compare_parts
from scanrack.traces.read.columns import Columns

pytestmark = pytest.mark.slow  # together they take seconds

SLOTS = (SlotInfo(1, "amci3601", "4.1"), SlotInfo(4, "a toy"))
PERIOD_NS = 2_000_000
SCANS = 60
STATUS_MSW, POSITION = 8, 10  # columns: eight output words, then the inputs
MOVING_CW, MODE_CONFIG = 0x0001, -0x8000


def columns(words: np.ndarray, times: np.ndarray | None = None) -> Columns:
    scans = np.arange(len(words), dtype=np.int64)
    return Columns(
        scans, scans * PERIOD_NS if times is None else times, np.ones(len(words), np.uint32), words
    )


def idle() -> np.ndarray:
    words = np.zeros((SCANS, 32), np.int16)
    words[:, STATUS_MSW] = 0x4000
    return words


def differ(a: Columns, b: Columns, tolerance: Tolerance = EXACT, slots=SLOTS):
    return compare_parts((slots, [a]), (slots, [b]), tolerance)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, SCANS - 1),
    st.integers(0, 31),
    st.integers(1, 0xFFFF),
)
def test_one_changed_word_is_found_where_it_is(seed: int, scan: int, word: int, flip: int) -> None:
    """Of any words at all, legal or not, in either mode."""
    words = np.random.default_rng(seed).integers(-(2**15), 2**15, (SCANS, 32), np.int16)
    changed = words.copy()
    changed[scan, word] ^= np.uint16(flip).view(np.int16)
    found = differ(columns(words), columns(changed))
    assert found.first is not None
    assert (found.first.scan, found.first.scan_b, found.differing) == (scan, scan, 1)
    slot, direction = (1, 4)[word // 16], ("out", "in")[word // 8 % 2]
    assert {(one.slot, one.direction) for one in found.first.details} == {(slot, direction)}
    own = word % 8
    both = {int(words[scan, word]), int(changed[scan, word])}
    assert any(
        {one.words_a[own - one.word], one.words_b[own - one.word]} == both
        for one in found.first.details
        if one.word <= own < one.word + len(one.words_a)
    )
    assert {(extent.first, extent.last, extent.scans) for extent in found.extents} == {(scan, scan, 1)}


@given(st.integers(0, SCANS - 1), st.integers(0, 15), st.sampled_from([STATUS_MSW, STATUS_MSW + 1, 0, 1]))
def test_a_changed_bit_is_told_alone(scan: int, bit: int, column: int) -> None:
    changed = idle()
    changed[scan, column] ^= np.uint16(1 << bit).view(np.int16)
    if (column, bit) in ((0, 15), (STATUS_MSW, 15)):
        return  # another mode: all words mean something else
    found = differ(columns(idle()), columns(changed))
    assert found.first is not None
    ((detail),) = found.first.details
    ((name, a, b),) = detail.bits
    assert (detail.word, a, b) == (column % 8, not b, not a)
    assert [extent.name.rpartition(".")[2] for extent in found.extents] == [name.rpartition(".")[2]]


@given(st.integers(10, 20), st.integers(30, 40), st.integers(-5, 5), st.integers(0, 5))
def test_edges_may_be_off_by_the_tolerance_and_not_more(
    rise: int, fall: int, late: int, allowed: int
) -> None:
    a, b = idle(), idle()
    a[rise:fall, STATUS_MSW] |= MOVING_CW
    b[rise + late : fall + late, STATUS_MSW] |= MOVING_CW
    found = differ(columns(a), columns(b), Tolerance(time_ns=allowed * PERIOD_NS))
    assert found.same is (abs(late) <= allowed)
    if not found.same:
        assert found.first is not None
        assert [extent.name for extent in found.extents] == ["slot1.in.MOVING_CW"]
        # The level is missing until the other trace comes within the tolerance: by late - allowed
        # scans at either edge, told of the trace that is ahead and of the one that is behind.
        assert min(rise, rise + late) <= found.first.scan <= max(rise, rise + late)


@given(st.integers(10, 40), st.integers(1, 9), st.integers(0, 4))
def test_a_pulse_that_one_trace_lacks_is_found_whichever_it_is(rise: int, scans: int, allowed: int) -> None:
    """However short: a pulse within the tolerance is missing, not early or late."""
    a = idle()
    a[rise : rise + scans, STATUS_MSW] |= MOVING_CW
    for one, other in ((a, idle()), (idle(), a)):
        found = differ(columns(one), columns(other), Tolerance(time_ns=allowed * PERIOD_NS))
        assert found.first is not None
        assert found.first.scan == rise
        assert found.differing == scans


@given(st.integers(-9, 9), st.integers(0, 9), st.integers(10, 50))
def test_positions_may_be_off_by_the_counts_and_not_more(off: int, counts: int, at: int) -> None:
    a, b = idle(), idle()
    a[:, POSITION : POSITION + 2] = b[:, POSITION : POSITION + 2] = split_reported(5_000)
    b[at:, POSITION : POSITION + 2] = split_reported(5_000 + off)
    found = differ(columns(a), columns(b), Tolerance(counts=counts))
    assert found.same is (abs(off) <= counts)
    if not found.same:
        assert found.first is not None
        assert (found.first.scan, found.extents[0].most) == (at, abs(off))


@given(st.integers(1, 40), st.integers(0, 8), st.integers(0, 3), st.integers(0, 3))
def test_a_moving_position_may_be_off_by_what_it_moves_in_the_tolerance(
    steps: int, late: int, allowed: int, counts: int
) -> None:
    """A ramp of so many steps per scan, late by some scans, is off by steps x late."""
    a, b = idle(), idle()
    for scan in range(SCANS):
        a[scan, POSITION : POSITION + 2] = split_reported(steps * scan)
        b[scan, POSITION : POSITION + 2] = split_reported(steps * max(0, scan - late))
    found = differ(columns(a), columns(b), Tolerance(allowed * PERIOD_NS, counts))
    assert found.same is (steps * max(0, late - allowed) <= counts)


@given(st.lists(st.integers(-400_000, 400_000), min_size=SCANS, max_size=SCANS), st.integers(0, 2**32 - 1))
def test_jitter_within_the_tolerance_is_the_same(jitter: list[int], seed: int) -> None:
    """Scans at other times, and a bit that is recorded in the first scan after it changed.

    Two recorders that look within 2.8 ms of each other at latest see an edge within 2.8 ms.
    """
    rng = np.random.default_rng(seed)
    edges = np.sort(rng.choice(np.arange(2, 36), 6, replace=False)) * 3_000_000  # a pulse is in some scan
    times = np.arange(SCANS) * PERIOD_NS, np.maximum.accumulate(np.arange(SCANS) * PERIOD_NS + jitter)
    made = []
    for time in times:
        words = idle()
        words[:, STATUS_MSW] |= (np.searchsorted(edges, time, "right") % 2).astype(np.int16)
        made.append(columns(words, time.astype(np.int64)))
    first, second = made
    assert differ(first, second, Tolerance(time_ns=PERIOD_NS + 800_000)).same


@given(st.integers(1, 59), st.integers(1, 5))
def test_scans_that_are_missing_are_counted(first: int, scans: int) -> None:
    whole = columns(idle())
    keep = np.delete(np.arange(SCANS), slice(first, first + scans))
    found = differ(whole, whole.at(keep))
    assert not found.same
    assert (found.first, found.only_a, found.only_b) == (None, SCANS - len(keep), 0)


def test_slots_that_only_one_has_are_told_and_the_others_compared() -> None:
    words = idle()
    words[7, 20] = 5
    one = (SLOTS, [columns(words)])
    other = ((SLOTS[1],), [columns(idle()[:, 16:])])
    found = compare_parts(one, other)
    assert (found.slots_only_a, found.slots_only_b, found.same) == ((1,), (), False)
    assert [extent.name for extent in found.extents] == ["slot4.out.word4"]


@given(st.integers(10, 20), st.integers(30, 40), st.integers(-5, 5), st.integers(0, 5))
def test_words_may_change_as_late_as_edges(start: int, end: int, late: int, allowed: int) -> None:
    """An acceleration of 50 for a while; 20 lies between 0 and 50, but never was there."""
    a, b = idle(), idle()
    a[start:end, 6] = 50
    b[start + late : end + late, 6] = 50
    assert differ(columns(a), columns(b), Tolerance(time_ns=allowed * PERIOD_NS)).same is (
        abs(late) <= allowed
    )
    b[end + late, 6] = 20
    assert not differ(columns(a), columns(b), Tolerance(time_ns=5 * PERIOD_NS)).same


@given(st.integers(10, 40), st.integers(1, 9), st.integers(1, 4))
def test_a_gap_that_one_trace_lacks_is_found_whichever_it_is(fall: int, scans: int, allowed: int) -> None:
    whole, gap = idle(), idle()
    whole[:, STATUS_MSW] |= MOVING_CW
    gap[:, STATUS_MSW] |= MOVING_CW
    gap[fall : fall + scans, STATUS_MSW] &= ~MOVING_CW
    for one, other in ((gap, whole), (whole, gap)):
        found = differ(columns(one), columns(other), Tolerance(time_ns=allowed * PERIOD_NS))
        assert found.first is not None
        assert (found.first.scan, found.differing) == (fall, scans)


@given(st.integers(10, 50), st.integers(-9, 9), st.integers(0, 9), st.integers(1, 4))
def test_a_count_that_jumps_for_a_scan_is_found_whichever_it_is(
    at: int, off: int, counts: int, allowed: int
) -> None:
    still, jump = idle(), idle()
    jump[at, POSITION : POSITION + 2] = split_reported(off)
    for one, other in ((jump, still), (still, jump)):
        found = differ(columns(one), columns(other), Tolerance(allowed * PERIOD_NS, counts))
        assert found.same is (abs(off) <= counts)


def test_two_pairs_of_one_value_differ() -> None:
    """1 000 and 0 1000 both make 1000; no module sends the second."""
    a, b = idle(), idle()
    a[5, POSITION], b[5, POSITION + 1] = 1, 1000
    found = differ(columns(a), columns(b))
    assert found.first is not None
    assert [(one.name, one.a, one.b) for one in found.first.details] == [("position", 1000, 1000)]


def test_what_was_before_a_trace_that_begins_in_mid_life_is_not_judged() -> None:
    """An edge 3 scans late, of which the other trace shows nothing: it begins behind it."""
    a, b = idle(), idle()
    a[10:, STATUS_MSW] |= MOVING_CW
    b[7:, STATUS_MSW] |= MOVING_CW
    late = columns(b).at(np.arange(8, SCANS))
    found = differ(columns(a), late, Tolerance(time_ns=3 * PERIOD_NS))
    assert (found.first, found.only_a) == (None, 5), "scans 0 to 4 are more than the tolerance before it"


def test_time_that_goes_back_is_refused() -> None:
    times = np.arange(SCANS) * PERIOD_NS
    times[30] = 0
    with pytest.raises(ValueError, match="time goes back in scan 30"):
        differ(columns(idle()), columns(idle(), times), Tolerance(time_ns=1))
