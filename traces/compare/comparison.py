"""Two traces compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..columns import SLOT_WORDS, Columns
from ..layout import SlotInfo
from ..reader import Trace
from .alignment import SAME_CLOCK, Clock
from .before import changes_before, rules_in
from .bytime import tolerantly
from .differing import Differing, Extent, First, Side, exactly
from .fields import all_fields
from .pairing import by_number
from .reading import Progress, read_all, read_from_where_they_part, slot_places
from .tolerance import EXACT, Tolerance


@dataclass(frozen=True, slots=True)
class Comparison:
    """What came of comparing two traces.

    Attributes:
        first: the first scan that differs; None if none does.
        extents: how much differs in each bit, value and word, by the first scan in which it does.
        scans_a: how many scans the first trace has.
        scans_b: how many the second has.
        only_a: how many scans of the first have nothing in the second to be compared with.
        only_b: the same the other way round.
        differing: in how many scans anything differs.
        slots_only_a: numbers of slots that only the first trace has.
        slots_only_b: those that only the second has.
        heads: entries of the metadata that differ: name, in the first trace, in the second.
        tolerance: what was allowed to differ.
        aligned: whether their clocks were brought together.
    """

    first: First | None
    extents: tuple[Extent, ...]
    scans_a: int
    scans_b: int
    only_a: int
    only_b: int
    differing: int
    slots_only_a: tuple[int, ...]
    slots_only_b: tuple[int, ...]
    heads: tuple[tuple[str, str, str], ...]
    tolerance: Tolerance
    aligned: bool = False

    @property
    def same(self) -> bool:
        """Whether both show the same: every scan, in the slots of both, and no more of them in one.

        Metadata may differ: the same images from another program are the same images. Traces whose
        clocks were brought together need not begin and end together.
        """
        if self.first is not None or self.slots_only_a or self.slots_only_b:
            return False
        if self.aligned:
            return self.only_a < self.scans_a
        return not (self.only_a or self.only_b)


def compare(
    one: Trace,
    other: Trace,
    tolerance: Tolerance = EXACT,
    *,
    clock: Clock = SAME_CLOCK,
    progress: Progress = lambda scans: None,
) -> Comparison:
    """Compare two traces.

    Without a tolerance scans are paired by number and every bit and their times count; with one
    they are paired by time, see `bytime.tolerantly`. What is held in memory of both takes 20 bytes
    per scan and 32 per scan and slot: all of it with a tolerance, otherwise what follows the first
    chunk that differs.

    Args:
        one: the first trace.
        other: the second.
        tolerance: what may differ.
        clock: turns times of the second trace into times of the first, see `align`; another than
            that of both makes it a comparison by time.
        progress: told how many scans of the first trace have been read with each chunk.

    Raises:
        TraceError: one of the files is damaged beyond what can be left out.
    """
    left_out = 0
    numbers = [[slot.number for slot in trace.head.slots] for trace in (one, other)]
    if tolerance.exact and clock == SAME_CLOCK and numbers[0] == numbers[1]:
        a, b, left_out = read_from_where_they_part(one, other, progress)
    else:
        a, b = read_all(one, progress), read_all(other, lambda scans: None)
    found = compare_columns(
        (one.head.slots, a),
        (other.head.slots, b),
        tolerance,
        clock=clock,
        heads=_heads(one, other),
        before=left_out,
    )
    if found.first is None:
        return found
    slots = {detail.slot for detail in found.first.details}
    first = found.first
    rules = (
        rules_in(one, first.scan, first.time_ns, slots),
        rules_in(other, first.scan_b, first.time_b_ns, slots),
    )
    return replace(found, first=replace(first, rules_a=rules[0], rules_b=rules[1]))


def compare_columns(
    one: tuple[Sequence[SlotInfo], Columns],
    other: tuple[Sequence[SlotInfo], Columns],
    tolerance: Tolerance = EXACT,
    *,
    clock: Clock = SAME_CLOCK,
    heads: tuple[tuple[str, str, str], ...] = (),
    only: frozenset[tuple[int | None, str]] | None = None,
    before: int = 0,
) -> Comparison:
    """Compare scans that are in memory, see `compare`.

    Args:
        one: slots and scans of the first trace.
        other: those of the second.
        tolerance: what may differ.
        clock: turns times of the second into times of the first.
        heads: metadata that differ, for the result.
        only: which images are compared: slot and direction; all if left out. (None, "cpu") stands
            for flags and times.
        before: how many scans there were before these, which are the same.
    """
    numbers = [{slot.number for slot in slots} for slots, _ in (one, other)]
    common = [slot for slot in one[0] if slot.number in numbers[1]]
    a, b = (_side(slots, columns, numbers[0] & numbers[1]) for slots, columns in (one, other))
    fields = [field for field in all_fields(common) if only is None or (field.slot, field.direction) in only]
    if tolerance.exact and clock == SAME_CLOCK:
        pairs = by_number(a.columns.scan, b.columns.scan)
        only_a, only_b = pairs.only_a, pairs.only_b
        found = list(exactly(fields, a, b, pairs))
    else:
        found, only_a, only_b = tolerantly(fields, a, b, tolerance, clock)
    return Comparison(
        first=_first(found, a, b, common),
        extents=_extents(found, a, b),
        scans_a=before + len(a.columns.scan),
        scans_b=before + len(b.columns.scan),
        only_a=only_a,
        only_b=only_b,
        differing=_rows_in(found, len(a.columns.scan)),
        slots_only_a=tuple(sorted(numbers[0] - numbers[1])),
        slots_only_b=tuple(sorted(numbers[1] - numbers[0])),
        heads=heads,
        tolerance=tolerance,
        aligned=clock != SAME_CLOCK,
    )


def _rows_in(found: Sequence[Differing], rows: int) -> int:
    """Return in how many rows anything differs."""
    anything = np.zeros(rows, bool)
    for each in found:
        anything[each.a] = True
    return int(np.count_nonzero(anything))


def _side(slots: Sequence[SlotInfo], columns: Columns, common: set[int]) -> Side:
    """Return a trace with the slots that both have."""
    places = slot_places(slots)
    if len(common) == len(places):
        return Side(columns, places)
    wanted = [slot for slot in slots if slot.number in common]
    words = [columns.words[:, places[slot.number] : places[slot.number] + SLOT_WORDS] for slot in wanted]
    none = np.zeros((len(columns.scan), 0), np.int16)
    return Side(columns._replace(words=np.hstack([none, *words])), slot_places(wanted))


def _first(found: Sequence[Differing], a: Side, b: Side, slots: Sequence[SlotInfo]) -> First | None:
    if not found:
        return None
    row, row_b = min((int(each.a[0]), int(each.b[0])) for each in found)
    details = [each.detail(a, b, row) for each in found]
    return First(
        int(a.columns.scan[row]),
        int(a.columns.time_ns[row]),
        int(b.columns.scan[row_b]),
        int(b.columns.time_ns[row_b]),
        tuple(detail for detail in details if detail is not None),
        changes_before(a, slots, row),
        changes_before(b, slots, row_b),
    )


def _extents(found: Sequence[Differing], a: Side, b: Side) -> tuple[Extent, ...]:
    extents = [extent for each in found for extent in each.extents(a, b)]
    return tuple(sorted(extents, key=lambda extent: extent.first))


def _heads(one: Trace, other: Trace) -> tuple[tuple[str, str, str], ...]:
    a, b = one.head.metadata, other.head.metadata
    names = dict.fromkeys([*a, *b])
    return tuple((name, a.get(name, ""), b.get(name, "")) for name in names if a.get(name) != b.get(name))
