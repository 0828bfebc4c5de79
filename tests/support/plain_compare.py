"""Two traces compared scan by scan, all of them in memory: slow, and plain enough to be believed.

`compare_parts` does the same block by block; whatever its blocks are, it has to give this.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np
from scanrack.traces import SlotInfo
from scanrack.traces.compare import Comparison, Extent, First, TimeMap, Tolerance
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
