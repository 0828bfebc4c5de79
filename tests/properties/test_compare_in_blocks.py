"""Two traces compared block by block give what they give scan by scan, wherever a block ends.

Broken on purpose: a block's scans without those within the tolerance before or behind it, scans of one
time read in part, scans at the border's very time counted to the block before, the last scans before a
block forgotten, the last block without what is late: each turns it red.

Two traces compared scan by scan, all of them in memory: slow, and plain enough to be believed.

`compare_parts` does the same block by block; whatever its blocks are, it has to give this.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.traces import SlotInfo
from scanrack.traces.compare import (
    SAME_CLOCK,
    Comparison,
    Extent,
    First,
    TimeMap,
    Tolerance,
    blocks,
    compare_parts,
    findings,
)
from scanrack.traces.compare.fields import TIME, Field, FieldKind, all_fields
from scanrack.traces.compare.findings import FieldDifference, changes_before
from scanrack.traces.compare.stream import Side
from scanrack.traces.format.layout import block_layout
from scanrack.traces.read.columns import Columns

Found = dict[int, tuple[int, int]]
"""Rows of the first trace in which a field differs: the row of the second, and which bits."""


def plainly(
    slots: Sequence[SlotInfo], one: Columns, other: Columns, tolerance: Tolerance, clock: TimeMap
) -> Comparison:
    """Compare two traces of the same slots."""
    places = block_layout(slots).places
    a, b = Side(one, places), Side(other, places)
    fields = all_fields(slots)
    if tolerance.exact and clock == TimeMap():
        found, only = by_number(fields, a, b)
    else:
        found, only = by_time(fields, a, b, tolerance, clock(other.time_ns).tolist())
    differing = [(field, rows) for field, rows in found if rows]
    extents = [extent for field, rows in differing for extent in extents_of(field, rows, a, b)]
    return Comparison(
        first=first_of(differing, a, b, slots),
        extents=tuple(sorted(extents, key=lambda extent: extent.first)),
        scans_a=len(one.scan),
        scans_b=len(other.scan),
        only_a=only[0],
        only_b=only[1],
        differing=len({row for _, rows in differing for row in rows}),
        slots_only_a=(),
        slots_only_b=(),
        heads=(),
        tolerance=tolerance,
        aligned=clock != TimeMap(),
    )


def by_number(fields: Sequence[Field], a: Side, b: Side) -> tuple[list[tuple[Field, Found]], tuple[int, int]]:
    """Compare scans of one number."""
    numbers = b.columns.scan.tolist()
    pairs = [
        (row, numbers.index(number))
        for row, number in enumerate(a.columns.scan.tolist())
        if number in numbers
    ]
    found = []
    for field in fields:
        keys = [field.key(side.images(field)).tolist() for side in (a, b)]
        unequal = ((row, row_b) for row, row_b in pairs if keys[0][row] != keys[1][row_b])
        found.append((field, {row: (row_b, keys[0][row] ^ keys[1][row_b]) for row, row_b in unequal}))
    return found, (len(a.columns.scan) - len(pairs), len(numbers) - len(pairs))


def by_time(
    fields: Sequence[Field], a: Side, b: Side, tolerance: Tolerance, times_b: list[int]
) -> tuple[list[tuple[Field, Found]], tuple[int, int]]:
    """Compare scans within the tolerance."""
    times_a = a.columns.time_ns.tolist()
    there = list(windows(times_a, times_b, tolerance.time_ns, begun=first_is_zero(b)))
    back = list(windows(times_b, times_a, tolerance.time_ns, begun=first_is_zero(a)))
    found = []
    for field in fields:
        if field is TIME:
            continue
        rows: Found = {}
        for row, held, window in there:
            bits = missing(field, a, row, b, (held, window), tolerance.counts)
            if bits:
                rows[row] = held, bits
        for row_b, held, window in back:
            bits = missing(field, b, row_b, a, (held, window), tolerance.counts)
            if bits:
                partner, before = rows.get(held, (row_b, 0))
                rows[held] = partner, before | bits
        found.append((field, dict(sorted(rows.items()))))
    return found, (len(times_a) - len(there), len(times_b) - len(back))


def first_is_zero(side: Side) -> bool:
    return not len(side.columns.scan) or not side.columns.scan[0]


def windows(
    own: list[int], other: list[int], tolerance_ns: int, *, begun: bool
) -> Iterator[tuple[int, int, range]]:
    """Yield each row that is within the other trace: the row in force there, and those that may be met.

    These are none where the other trace does not show all that is within the tolerance.
    """
    if not other:
        return
    period = (other[-1] - other[0]) // (len(other) - 1) if len(other) > 1 else 0
    for row, now in enumerate(own):
        if other[0] - tolerance_ns <= now <= other[-1] + max(period, tolerance_ns):
            early, held, late = (
                bisect_right(other, at) - 1 for at in (now - tolerance_ns, now, now + tolerance_ns)
            )
            whole = now + tolerance_ns < other[-1] + period and (begun or now - tolerance_ns >= other[0])
            yield row, max(held, 0), range(max(early, 0), late + 1) if whole else range(0)


def missing(field: Field, own: Side, row: int, other: Side, there: tuple[int, range], counts: int) -> int:
    """Return what of a field is not met in the window: its bits, or 1. What is in force there is met."""
    held, window = there
    if not window or field.key(own.images(field))[row] == field.key(other.images(field))[held]:
        return 0
    wanted, met = own.images(field, np.array([row])), other.images(field, np.array(window))
    key, keys = int(field.key(wanted)[0]), field.key(met).tolist()
    if field.kind is FieldKind.BITS:
        levels = [{other_key >> bit & 1 for other_key in keys} for bit in range(16)]
        return sum(1 << bit for bit in range(16) if (key >> bit & 1) not in levels[bit])
    if field.kind is FieldKind.COUNT:
        value = float(field.values(wanted)[0])
        values = [each for each in field.values(met).tolist() if not np.isnan(each)]
        return int(bool(values) and (value < min(values) - counts or value > max(values) + counts))
    return int(key not in keys)


def extents_of(field: Field, rows: Found, a: Side, b: Side) -> Iterator[Extent]:
    """Yield how much differs in a field: of each bit, or as a whole."""
    numbers = a.columns.scan.tolist()
    if field.kind is not FieldKind.BITS:
        most = None
        for row, (row_b, _) in rows.items():
            apart = abs(number_of(field, a, row) - number_of(field, b, row_b))
            if not np.isnan(apart):
                most = max(int(apart), most or 0)
        where = list(rows)
        yield Extent(field.path, len(where), numbers[where[0]], numbers[where[-1]], most)
        return
    for bit, name in enumerate(field.bits):
        where = [row for row, (_, bits) in rows.items() if bits >> bit & 1]
        if where:
            yield Extent(f"{field.stem}.{name}", len(where), numbers[where[0]], numbers[where[-1]])


def number_of(field: Field, side: Side, row: int) -> float:
    image = side.images(field, np.array([row]))
    return float(field.values(image)[0])


def first_of(
    differing: Sequence[tuple[Field, Found]], a: Side, b: Side, slots: Sequence[SlotInfo]
) -> First | None:
    """Return the first scan that differs, and how."""
    if not differing:
        return None
    row, row_b = min((next(iter(rows)), next(iter(rows.values()))[0]) for _, rows in differing)
    details = []
    for field, rows in differing:
        if row in rows:
            bits = np.array([rows[row][1]], np.uint16) if field.kind is FieldKind.BITS else None
            pair = FieldDifference(field, np.array([row]), np.array([rows[row][0]]), bits)
            detail = pair.detail(a, b, row)
            assert detail is not None
            details.append(detail)
    return First(
        int(a.columns.scan[row]),
        int(a.columns.time_ns[row]),
        int(b.columns.scan[row_b]),
        int(b.columns.time_ns[row_b]),
        tuple(details),
        changes_before(a, slots, row),
        changes_before(b, slots, row_b),
    )


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
