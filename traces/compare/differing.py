"""Where fields differ, and what is told of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...io_images.image import WORDS
from ..changes import Row
from ..columns import Columns
from .fields import TIME, Field, Kind
from .pairing import Pairs, Rows, Windows, by_time, occurs, over_windows
from .tolerance import Tolerance

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Extent:
    """How much of two traces differs in one bit, value or word.

    Attributes:
        name: its name, such as "slot1.in.COMMAND_ERROR".
        scans: in how many scans.
        first: number of the first of them, in the first trace.
        last: number of the last.
        most: the greatest difference of a number; None for a bit.
    """

    name: str
    scans: int
    first: int
    last: int
    most: int | None = None


@dataclass(frozen=True, slots=True)
class Detail:
    """A field that differs in the first scan that does.

    Attributes:
        slot: number of the slot; None for the CPU.
        direction: "in", "out" or "cpu".
        name: name of the word or value in its image.
        word: index of the (first) word in the image.
        words_a: the word or words in the first trace.
        words_b: the same in the second.
        a: the value that the words stand for; None for bits, and where they stand for none.
        b: the same in the second trace.
        bits: of a word of bits, each that differs: name, level in the first trace, in the second.
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


@dataclass(frozen=True, slots=True)
class First:
    """The first scan that differs.

    Attributes:
        scan: its number in the first trace.
        time_ns: its virtual time there.
        scan_b: number of the scan that it is set against in the second trace.
        time_b_ns: the time of that.
        details: what differs in it, inputs before outputs.
        before_a: what changed in the first trace in the scans before it, and in it.
        before_b: the same of the second trace.
        rules_a: the rules that fired in it in the first trace, in words.
        rules_b: those that fired in the second.
    """

    scan: int
    time_ns: int
    scan_b: int
    time_b_ns: int
    details: tuple[Detail, ...]
    before_a: tuple[Row, ...] = ()
    before_b: tuple[Row, ...] = ()
    rules_a: tuple[str, ...] = ()
    rules_b: tuple[str, ...] = ()


class Side(NamedTuple):
    """One trace: its columns, and the first column of each slot."""

    columns: Columns
    places: Mapping[int, int]

    def images(self, field: Field, rows: Rows | None = None) -> Array:
        """Return what a field is read from, in all rows or some."""
        if field.slot is None:
            images: Array = self.columns.time_ns if field is TIME else self.columns.flags
        else:
            first = self.places[field.slot] + (WORDS if field.direction == "in" else 0)
            images = self.columns.words[:, first : first + WORDS]
        return images if rows is None else images[rows]


class Differing(NamedTuple):
    """The rows in which a field differs, paired; `bits` tells which ones in each, of a word of bits."""

    field: Field
    a: Rows
    b: Rows
    bits: Array | None = None

    def extents(self, one: Side, other: Side) -> Iterator[Extent]:
        """Yield how much differs: of each bit, or of the field."""
        numbers = one.columns.scan
        if self.bits is None:
            most = self._most(one, other)
            yield _extent(self.field.path, numbers, self.a, most)
            return
        for number, name in enumerate(self.field.bits):
            rows = self.a[(self.bits >> number & 1).astype(bool)]
            if len(rows):
                yield _extent(f"{self.field.stem}.{name}", numbers, rows, None)

    def _most(self, one: Side, other: Side) -> int | None:
        values = [
            _numbers(self.field, side.images(self.field, rows))
            for side, rows in ((one, self.a), (other, self.b))
        ]
        apart = np.abs(values[0] - values[1])
        return None if np.isnan(apart).all() else int(np.nanmax(apart))

    def detail(self, one: Side, other: Side, row_a: int) -> Detail | None:
        """Return what differs in one row of the first trace, None if nothing does."""
        places = np.flatnonzero(self.a == row_a)
        if not len(places):
            return None
        field, place = self.field, places[0]
        images = [
            side.images(field, rows[place : place + 1]) for side, rows in ((one, self.a), (other, self.b))
        ]
        place_in_image = field.slot, field.direction, field.name, field.word
        words = _words(field, images[0]), _words(field, images[1])
        if self.bits is not None:
            keys = [int(field.key(image)[0]) for image in images]
            return Detail(*place_in_image, *words, bits=tuple(field.differing_bits(*keys)))
        values = [_whole(_numbers(field, image)[0]) for image in images]
        return Detail(*place_in_image, *words, values[0], values[1])


def exactly(fields: Sequence[Field], one: Side, other: Side, pairs: Pairs) -> Iterator[Differing]:
    """Yield the fields that differ in pairs of scans in which every bit counts."""
    rows = _unequal(one.columns, other.columns, pairs)
    a, b = pairs.a[rows], pairs.b[rows]
    for image, parts in _by_image(fields):
        images = one.images(image, a), other.images(image, b)
        for field in parts:
            keys = field.key(images[0]), field.key(images[1])
            found = np.flatnonzero(keys[0] != keys[1])
            if len(found):
                bits = (keys[0] ^ keys[1])[found] if field.kind is Kind.BITS else None
                yield Differing(field, a[found], b[found], bits)


def _by_image(fields: Sequence[Field]) -> Iterator[tuple[Field, list[Field]]]:
    """Yield the fields of each image together, after the first of them."""
    for _, group in groupby(fields, lambda field: (field.stem, field is TIME)):
        parts = list(group)
        yield parts[0], parts


def _unequal(a: Columns, b: Columns, pairs: Pairs) -> Rows:
    """Return which pairs differ anywhere."""
    aligned = len(pairs.a) == len(a.scan) == len(b.scan)
    if not aligned:
        a, b = a.at(pairs.a), b.at(pairs.b)
    unequal = (a.time_ns != b.time_ns) | (a.flags != b.flags)
    if not np.array_equal(a.words, b.words):
        unequal |= (a.words != b.words).any(axis=1)
    return np.flatnonzero(unequal)


def tolerantly(
    fields: Sequence[Field], one: Side, other: Side, tolerance: Tolerance, shift_ns: int
) -> tuple[list[Differing], int, int]:
    """Compare two traces by time: what one shows, the other shows within the tolerance.

    A word, or the level of a bit, has to be there at some time within the tolerance; a count may
    lie between those that are. So an edge may be early or late by the tolerance, and a position
    that moves may be off by as much as it moves meanwhile and the tolerance in counts.

    Args:
        fields: what is compared.
        one: the first trace.
        other: the second.
        tolerance: what may differ.
        shift_ns: what is added to the times of the second trace.

    Returns:
        What differs, and how many scans of either trace are outside the time of the other.
    """
    times = one.columns.time_ns, other.columns.time_ns + shift_ns
    there = by_time(times[0], times[1], tolerance.time_ns, since_ns=_since(other, shift_ns))
    back = by_time(times[1], times[0], tolerance.time_ns, since_ns=_since(one, 0))
    found = []
    for image, parts in _by_image([field for field in fields if field is not TIME]):
        images = one.images(image), other.images(image)
        rows = _otherwise(images[0], images[1], there), _otherwise(images[1], images[0], back)
        for field in parts:
            a = _missing(field, images[0], images[1], there, rows[0], tolerance)
            b = _missing(field, images[1], images[0], back, rows[1], tolerance)
            if len(a.a) or len(b.a):
                found.append(_merged(field, a, b))
    return found, len(times[0]) - len(there.rows), len(times[1]) - len(back.rows)


def _since(side: Side, shift_ns: int) -> int | None:
    """Return when a trace begins that does not begin with the first scan, None for one that does."""
    columns = side.columns
    return int(columns.time_ns[0]) + shift_ns if len(columns.scan) and columns.scan[0] else None


def _otherwise(own: Array, other: Array, windows: Windows) -> Rows:
    """Return which windows begin with another image than the one held, as far as they can be judged."""
    unequal = own[windows.rows] != other[windows.held]
    return np.flatnonzero((unequal if unequal.ndim == 1 else unequal.any(axis=1)) & windows.whole)


def _missing(
    field: Field, own: Array, other: Array, windows: Windows, rows: Rows, tolerance: Tolerance
) -> Differing:
    """Return the rows of one trace whose value the other does not have within the tolerance.

    Args:
        field: the field.
        own: the images of the one trace.
        other: those of the other.
        windows: what of the other each row is set against.
        rows: the windows that come into question: no others can lack a value.
        tolerance: what may differ.
    """
    wanted, held = field.key(own[windows.rows[rows]]), field.key(other[windows.held[rows]])
    rows, wanted = rows[wanted != held], wanted[wanted != held]
    bits = None
    if len(rows):
        first, end = windows.first[rows], windows.end[rows]
        if field.kind is Kind.BITS:
            bits = _missing_bits(wanted, field.key(other), first, end)
            missing = bits != 0
            bits = bits[missing]
        elif field.kind is Kind.COUNT:
            values = field.values(own[windows.rows[rows]]), field.values(other)
            missing = _beyond(*values, first, end, tolerance.counts)
        else:
            missing = ~occurs(wanted, field.key(other), first, end)
        rows = rows[missing]
    elif field.kind is Kind.BITS:
        bits = np.zeros(0, np.uint16)
    return Differing(field, windows.rows[rows], windows.held[rows], bits)


def _missing_bits(wanted: Array, values: Array, first: Rows, end: Rows) -> Array:
    """Return which bits stand otherwise throughout the window."""
    never_set = ~over_windows(values, first, end, np.bitwise_or)
    always_set = over_windows(values, first, end, np.bitwise_and)
    missing: Array = (wanted & never_set) | (~wanted & always_set)
    return missing


def _beyond(wanted: Array, values: Array, first: Rows, end: Rows, counts: int) -> Array:
    """Return which counts lie outside what the window spans; nothing does where there are none."""
    least = over_windows(values, first, end, np.fmin)
    most = over_windows(values, first, end, np.fmax)
    beyond: Array = (wanted < least - counts) | (wanted > most + counts)
    return beyond


def _merged(field: Field, there: Differing, back: Differing) -> Differing:
    """Join what was found either way, by rows of the first trace; a row once."""
    a, b = np.concatenate((there.a, back.b)), np.concatenate((there.b, back.a))
    rows, place = np.unique(a, return_index=True)
    if there.bits is None or back.bits is None:
        return Differing(field, rows, b[place])
    bits = np.zeros(len(rows), np.uint16)
    np.bitwise_or.at(bits, np.searchsorted(rows, a), np.concatenate((there.bits, back.bits)))
    return Differing(field, rows, b[place], bits)


def _extent(name: str, numbers: NDArray[np.int64], rows: Rows, most: int | None) -> Extent:
    return Extent(name, len(rows), int(numbers[rows[0]]), int(numbers[rows[-1]]), most)


def _numbers(field: Field, images: Array) -> Array:
    """Return the values of a field as numbers, NaN where it has none."""
    if field.kind in (Kind.COUNT, Kind.VALUE):
        return field.values(images)
    return field.key(images).astype(np.float64)


def _words(field: Field, image: Array) -> tuple[int, ...]:
    if field.slot is None:
        return (int(image[0]),)
    return tuple(int(word) for word in image[0, field.word : field.word + field.words])


def _whole(value: float) -> int | None:
    return None if np.isnan(value) else int(value)
