"""Where fields differ, and what a report says of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...io_images.image import WORDS
from ..read.changes import Row
from ..read.columns import Columns
from .fields import TIME, Field, Kind
from .pairing import Rows

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
        direction: "in", "out", "cpu" or "tags".
        name: name of the word or value in its image.
        word: index of the (first) word in the image.
        words_a: the word or words in the first trace.
        words_b: the same in the second.
        a: the value that the words stand for; None for bits, and where they stand for none.
        b: the same in the second trace.
        bits: of a word of bits, each that differs: name, level in the first trace, in the second.
        text_a: of a tag, its value in the first trace in words.
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
        if field.kind is Kind.TAG:
            assert self.columns.tags is not None, "tags are compared"
            images: Array = self.columns.tags
        elif field.slot is None:
            images = self.columns.time_ns if field is TIME else self.columns.flags
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
        if self.field.kind is Kind.TAG:
            return None
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
        if field.kind is Kind.TAG:
            texts = [field.text(image[0]) for image in images]
            return Detail(*place_in_image, (), (), text_a=texts[0], text_b=texts[1])
        words = _words(field, images[0]), _words(field, images[1])
        if self.bits is not None:
            keys = [int(field.key(image)[0]) for image in images]
            return Detail(*place_in_image, *words, bits=tuple(field.differing_bits(*keys)))
        values = [_whole(_numbers(field, image)[0]) for image in images]
        return Detail(*place_in_image, *words, values[0], values[1])


def by_image(fields: Sequence[Field]) -> Iterator[tuple[Field, list[Field]]]:
    """Yield the fields of each image together, after the first of them."""
    for _, group in groupby(fields, lambda field: (field.stem, field is TIME)):
        parts = list(group)
        yield parts[0], parts


def _extent(name: str, numbers: NDArray[np.int64], rows: Rows, most: int | None) -> Extent:
    return Extent(name, len(rows), int(numbers[rows[0]]), int(numbers[rows[-1]]), most)


def _numbers(field: Field, images: Array) -> Array:
    """Return the values of a field as numbers: whole ones, or floats with NaN where it has none."""
    if field.kind in (Kind.COUNT, Kind.VALUE):
        return field.values(images)
    return field.key(images).astype(np.int64)


def _words(field: Field, image: Array) -> tuple[int, ...]:
    if field.slot is None:
        return (int(image[0]),)
    return tuple(int(word) for word in image[0, field.word : field.word + field.words])


def _whole(value: float) -> int | None:
    return None if np.isnan(value) else int(value)
