"""Collects findings of all blocks: the first scan that differs, the changes before it, and all extents."""

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
"""Number of earlier scans that are searched for changes."""


@dataclass(frozen=True, slots=True)
class Extent:
    """How much of two traces differs in one bit, value or word."""

    name: str  # its name, such as "slot1.in.COMMAND_ERROR"
    scans: int  # number of scans in which it differs
    first: int  # scan number of the first of them, in the first trace
    last: int  # scan number of the last
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
        words_b: the same in the second.
        a: value of the words in the first trace; None for bits, and where the words have no value.
        b: the same in the second trace.
        bits: differing bits: name, level in the first trace, level in the second.
        text_a: value of a tag in the first trace, as text.
        text_b: the same in the second.
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

    scan: int  # its number in the first trace
    time_ns: int  # its virtual time there
    scan_b: int  # number of the scan in the second trace with which it is compared
    time_b_ns: int  # its virtual time
    details: tuple[Detail, ...]  # its differences, inputs before outputs
    before_a: tuple[Row, ...] = ()  # changes in the first trace in this and earlier scans
    before_b: tuple[Row, ...] = ()  # the same in the second trace
    rules_a: tuple[str, ...] = ()  # rules that fired in this scan of the first trace, as text
    rules_b: tuple[str, ...] = ()  # rules that fired in the second trace


class FieldDifference(NamedTuple):
    """The pairs of rows in which a field differs; for a word of bits, `bits` has the differing ones."""

    field: Field
    a: Rows
    b: Rows
    bits: Array | None = None

    def extents(self, one: Side, other: Side) -> Iterator[Extent]:
        """Yield the extent of each bit that differs, or of the field."""
        scan_numbers = one.columns.scan
        if self.bits is None:
            yield _extent(self.field.path, scan_numbers[self.a], self._most(one, other))
            return
        for number, name in enumerate(self.field.bits):
            rows = self.a[(self.bits >> number & 1).astype(bool)]
            if len(rows):
                yield _extent(f"{self.field.stem}.{name}", scan_numbers[rows], None)

    def _most(self, one: Side, other: Side) -> int | None:
        if self.field.kind is FieldKind.TAG:
            return None
        values = (self.field.values(side.images(self.field, rows)) for side, rows in self._rows(one, other))
        differences = np.abs(np.subtract(*values))
        return None if np.isnan(differences).all() else int(np.nanmax(differences))

    def _rows(self, one: Side, other: Side) -> tuple[tuple[Side, Rows], tuple[Side, Rows]]:
        return (one, self.a), (other, self.b)

    def detail(self, one: Side, other: Side, row_a: int) -> Detail | None:
        """Return the difference in one row of the first trace; None if there is none."""
        places = np.flatnonzero(self.a == row_a)[:1]
        if not len(places):
            return None
        field = self.field
        images_a, images_b = (side.images(field, rows[places]) for side, rows in self._rows(one, other))
        place_in_image = field.slot, field.direction, field.name, field.word
        if field.kind is FieldKind.TAG:
            return Detail(
                *place_in_image, (), (), text_a=field.text(images_a[0]), text_b=field.text(images_b[0])
            )
        words = field.words_in(images_a), field.words_in(images_b)
        if self.bits is not None:
            levels = zip(
                field.bits,
                *(_levels(int(field.key(image)[0])) for image in (images_a, images_b)),
                strict=True,
            )
            return Detail(*place_in_image, *words, bits=tuple(bit for bit in levels if bit[1] != bit[2]))
        return Detail(
            *place_in_image, *words, _whole(field.values(images_a)[0]), _whole(field.values(images_b)[0])
        )


def _whole(value: float) -> int | None:
    return None if np.isnan(value) else int(value)


def _levels(word: int) -> list[bool]:
    return [bool(word >> number & 1) for number in range(16)]


def _extent(name: str, numbers: Array, most: int | None) -> Extent:
    return Extent(name, len(numbers), int(numbers[0]), int(numbers[-1]), most)


class Findings:
    """The differences in the blocks of two traces."""

    def __init__(self, slots: Sequence[SlotInfo]) -> None:
        self._slots = slots
        self._extents: dict[str, Extent] = {}
        self.first: First | None = None  # the first scan that differs, or None
        self.differing = 0  # number of scans with a difference

    def add(self, one: Side, other: Side, differences: Sequence[FieldDifference]) -> None:
        """Add the fields that differ in the next block, with rows in ascending order."""
        if not differences:
            return
        if self.first is None:
            self.first = _first(differences, one, other, self._slots)
        for extent in (extent for difference in differences for extent in difference.extents(one, other)):
            previous = self._extents.get(extent.name)
            self._extents[extent.name] = extent if previous is None else _joined(previous, extent)
        self.differing += len(np.unique(np.concatenate([difference.a for difference in differences])))

    @property
    def extents(self) -> tuple[Extent, ...]:
        """The extents of each bit, value and word, in the order of the first scan in which it differs."""
        return tuple(sorted(self._extents.values(), key=lambda extent: extent.first))


def _first(differences: Sequence[FieldDifference], a: Side, b: Side, slots: Sequence[SlotInfo]) -> First:
    row, row_b = min((int(difference.a[0]), int(difference.b[0])) for difference in differences)
    details = [difference.detail(a, b, row) for difference in differences]
    return First(
        int(a.columns.scan[row]),
        int(a.columns.time_ns[row]),
        int(b.columns.scan[row_b]),
        int(b.columns.time_ns[row_b]),
        tuple(detail for detail in details if detail is not None),
        changes_before(a, slots, row),
        changes_before(b, slots, row_b),
    )


def _joined(before: Extent, after: Extent) -> Extent:
    most_counts = max(
        (difference.most for difference in (before, after) if difference.most is not None), default=None
    )
    return replace(before, scans=before.scans + after.scans, last=after.last, most=most_counts)


def changes_before(side: Side, slots: Sequence[SlotInfo], row: int) -> tuple[Row, ...]:
    """Return the changes in a row, and in the last scans before it that have any."""
    begin = max(0, row - LOOKED_AT)
    words, flags = side.columns.words[begin : row + 1], side.columns.flags[begin : row + 1]
    is_changed = (words[1:] != words[:-1]).any(axis=1) | (flags[1:] != flags[:-1])
    rows = begin + 1 + np.flatnonzero(is_changed)
    listed_rows = [changed_row for changed_row in rows.tolist() if changed_row < row][-SCANS_BEFORE:]
    return tuple(line for shown_row in [*listed_rows, row] for line in _rows(side, slots, shown_row))


def _rows(side: Side, slots: Sequence[SlotInfo], row: int) -> Iterator[Row]:
    changes = ChangeRows(slots, flag_names, every=True)
    if row:
        changes.skip(_scan(side, row - 1))
    return changes.rows(_scan(side, row))


def _scan(side: Side, row: int) -> Scan:
    columns = side.columns
    scan, now_ns, flags = (int(column[row]) for column in (columns.scan, columns.time_ns, columns.flags))
    return Scan(scan, now_ns, flags, columns.words[row].tobytes(), side.places)


_LONGEST_EXCHANGE_NS = 2_000_000_000
"""Longest time from an event to its scan: two exchanges of the slowest rack."""


def rules_in(trace: Trace, scan: int, time_ns: int, slots: Set[int | None]) -> tuple[str, ...]:
    """Return, as text, the rules that fired in a scan in any of these slots."""
    return tuple(
        describe(event.topic, event.scan, event.fields)
        for event in trace.events(time_ns - _LONGEST_EXCHANGE_NS, time_ns)
        if event.scan == scan and event.fields.get("kind") == "rule" and event.fields.get("slot") in slots
    )
