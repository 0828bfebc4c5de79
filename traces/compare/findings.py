"""Collects the differences of all blocks: the first scan that differs, and the extent of each difference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scanrack.io_images.dataclass import dataclass

from ..format.flags import flag_names
from ..format.layout import SlotInfo
from ..read.changes import ChangeRows, Row
from ..read.event_text import describe
from ..read.reader import Scan, Trace
from .fields import Array, Field, FieldKind
from .stream import Rows, Side

SCANS_BEFORE = 5
"""Number of scans with changes that a report shows before the first difference."""

LOOKED_AT = 4096
"""Number of earlier scans to search for changes."""


@dataclass(frozen=True, slots=True)
class Extent:
    """The scans of the first trace in which one bit, value or word differs from the second trace."""

    name: str  # name of the bit, value or word, such as "slot1.in.COMMAND_ERROR"
    scans: int  # number of scans in which it differs
    first: int  # number of the first scan in which it differs
    last: int  # number of the last scan in which it differs
    most: int | None = None  # greatest difference of a number; None for a bit


@dataclass(frozen=True, slots=True)
class Detail:
    """A field that differs in the first scan with a difference.

    Attributes:
        slot: number of the slot; None for the CPU.
        direction: "in", "out", "cpu" or "tags".
        name: name of the word or value in its image.
        word: index of the (first) word in the image.
        words_a: the word or words in the first trace.
        words_b: the word or words in the second trace.
        a: value of the words in the first trace; None for bits, and for words without a value.
        b: value of the words in the second trace.
        bits: differing bits, each with its name, its level in the first trace and its level in the second.
        text_a: value of a tag in the first trace, as text.
        text_b: value of a tag in the second trace, as text.
    """

    slot: int | None
    direction: str
    name: str
    word: int
    words_a: tuple[int, ...]
    words_b: tuple[int, ...]
    a: int | None = None
    b: int | None = None
    bits: tuple[tuple[str, bool, bool], ...] = ()
    text_a: str = ""
    text_b: str = ""


@dataclass(frozen=True, slots=True)
class First:
    """The first scan that differs."""

    scan: int  # number of the scan in the first trace
    time_ns: int  # virtual time of the scan in the first trace
    scan_b: int  # number of the scan in the second trace that it is compared with
    time_b_ns: int  # virtual time of the scan in the second trace
    details: tuple[Detail, ...]  # the fields that differ, inputs before outputs
    before_a: tuple[Row, ...] = ()  # changes in the first trace in this and earlier scans
    before_b: tuple[Row, ...] = ()  # changes in the second trace in this and earlier scans
    rules_a: tuple[str, ...] = ()  # rules that fired in this scan of the first trace, as text
    rules_b: tuple[str, ...] = ()  # rules that fired in this scan of the second trace, as text


class FieldDifference(NamedTuple):
    """The pairs of rows in which a field differs."""

    field: Field
    rows_a: Rows
    rows_b: Rows
    bits: Array | None = None  # of kind BITS: the differing bits of each pair, as a mask

    def extents(self, side_a: Side, side_b: Side) -> Iterator[Extent]:
        """Yield the extent of each bit that differs, or of the field."""
        scan_numbers = side_a.columns.scan
        if self.bits is None:
            yield _extent(self.field.path, scan_numbers[self.rows_a], self._most(side_a, side_b))
            return
        for number, name in enumerate(self.field.bits):
            rows = self.rows_a[(self.bits >> number & 1).astype(bool)]
            if len(rows):
                yield _extent(f"{self.field.stem}.{name}", scan_numbers[rows], None)

    def _most(self, side_a: Side, side_b: Side) -> int | None:
        """Return the greatest difference of the field's numbers; None for a tag, or if none has a value."""
        field = self.field
        if field.kind is FieldKind.TAG:
            return None
        values_a = field.values(side_a.images(field, self.rows_a))
        values_b = field.values(side_b.images(field, self.rows_b))
        differences = np.abs(values_a - values_b)
        return None if np.isnan(differences).all() else int(np.nanmax(differences))

    def detail(self, side_a: Side, side_b: Side, row_a: int) -> Detail | None:
        """Return the difference in one row of the first trace; None if the field does not differ in it."""
        first_pair = np.flatnonzero(self.rows_a == row_a)[:1]
        if not len(first_pair):
            return None
        field = self.field
        images_a = side_a.images(field, self.rows_a[first_pair])
        images_b = side_b.images(field, self.rows_b[first_pair])
        names = field.slot, field.direction, field.name, field.word
        if field.kind is FieldKind.TAG:
            text_a, text_b = field.text(images_a[0]), field.text(images_b[0])
            return Detail(*names, words_a=(), words_b=(), text_a=text_a, text_b=text_b)
        words = field.words_in(images_a), field.words_in(images_b)
        if self.bits is None:
            values_a, values_b = field.values(images_a), field.values(images_b)
            return Detail(*names, *words, a=_whole_number(values_a[0]), b=_whole_number(values_b[0]))
        levels_a, levels_b = (_levels(int(field.key(images)[0])) for images in (images_a, images_b))
        levels = zip(field.bits, levels_a, levels_b, strict=True)
        bits = tuple((name, bit_a, bit_b) for name, bit_a, bit_b in levels if bit_a != bit_b)
        return Detail(*names, *words, bits=bits)


def _whole_number(value: float) -> int | None:
    return None if np.isnan(value) else int(value)


def _levels(word: int) -> list[bool]:
    return [bool(word >> number & 1) for number in range(16)]


def _extent(name: str, scans: Array, most: int | None) -> Extent:
    return Extent(name, len(scans), int(scans[0]), int(scans[-1]), most)


class Findings:
    """The differences in all blocks of two traces."""

    def __init__(self, slots: Sequence[SlotInfo]) -> None:
        self._slots = slots
        self._extents: dict[str, Extent] = {}
        self.first: First | None = None  # the first scan that differs, or None
        self.differing = 0  # number of scans with a difference

    def add(self, side_a: Side, side_b: Side, differences: Sequence[FieldDifference]) -> None:
        """Add the fields that differ in the next block, with rows in ascending order."""
        if not differences:
            return
        if self.first is None:
            self.first = _first(differences, side_a, side_b, self._slots)
        for difference in differences:
            for extent in difference.extents(side_a, side_b):
                previous = self._extents.get(extent.name)
                self._extents[extent.name] = extent if previous is None else _joined(previous, extent)
        self.differing += len(np.unique(np.concatenate([difference.rows_a for difference in differences])))

    @property
    def extents(self) -> tuple[Extent, ...]:
        """The extent of each bit, value and word, in the order of the first scan in which it differs."""
        return tuple(sorted(self._extents.values(), key=lambda extent: extent.first))


def _first(
    differences: Sequence[FieldDifference], side_a: Side, side_b: Side, slots: Sequence[SlotInfo]
) -> First:
    """Return the earliest differing pair of rows, with all its differences and the changes before it."""
    row_a, row_b = min((int(difference.rows_a[0]), int(difference.rows_b[0])) for difference in differences)
    details = [difference.detail(side_a, side_b, row_a) for difference in differences]
    return First(
        scan=int(side_a.columns.scan[row_a]),
        time_ns=int(side_a.columns.time_ns[row_a]),
        scan_b=int(side_b.columns.scan[row_b]),
        time_b_ns=int(side_b.columns.time_ns[row_b]),
        details=tuple(detail for detail in details if detail is not None),
        before_a=changes_before(side_a, slots, row_a),
        before_b=changes_before(side_b, slots, row_b),
    )


def _joined(earlier: Extent, later: Extent) -> Extent:
    most = max((extent.most for extent in (earlier, later) if extent.most is not None), default=None)
    return replace(earlier, scans=earlier.scans + later.scans, last=later.last, most=most)


def changes_before(side: Side, slots: Sequence[SlotInfo], row: int) -> tuple[Row, ...]:
    """Return the changes in a row, and in the last `SCANS_BEFORE` scans before it that have changes."""
    begin = max(0, row - LOOKED_AT)
    words, flags = side.columns.words[begin : row + 1], side.columns.flags[begin : row + 1]
    is_changed = (words[1:] != words[:-1]).any(axis=1) | (flags[1:] != flags[:-1])
    rows = begin + 1 + np.flatnonzero(is_changed)
    earlier_rows = [changed_row for changed_row in rows.tolist() if changed_row < row][-SCANS_BEFORE:]
    return tuple(change for changed_row in [*earlier_rows, row] for change in _rows(side, slots, changed_row))


def _rows(side: Side, slots: Sequence[SlotInfo], row: int) -> Iterator[Row]:
    """Yield the row's changes from the previous row."""
    changes = ChangeRows(slots, flag_names, every=True)
    if row:
        changes.skip(_scan(side, row - 1))
    return changes.rows(_scan(side, row))


def _scan(side: Side, row: int) -> Scan:
    columns = side.columns
    scan, now_ns, flags = (int(column[row]) for column in (columns.scan, columns.time_ns, columns.flags))
    return Scan(scan, now_ns, flags, columns.words[row].tobytes(), side.places)


_LONGEST_EXCHANGE_NS = 2_000_000_000
"""Longest time from an event to its scan, which is two I/O exchanges of the slowest rack."""


def rules_in(trace: Trace, scan: int, time_ns: int, slots: Set[int | None]) -> tuple[str, ...]:
    """Return, as text, the rules that fired in a scan in any of these slots."""
    return tuple(
        describe(event.topic, event.scan, event.fields)
        for event in trace.events(time_ns - _LONGEST_EXCHANGE_NS, time_ns)
        if event.scan == scan and event.fields.get("kind") == "rule" and event.fields.get("slot") in slots
    )
