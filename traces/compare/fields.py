"""The compared fields of a scan: bits, decoded values and words, and their tolerances.

A 3601's image has another meaning in configuration mode, where its words mirror the
configuration. A bit or value of command mode is therefore 0 or missing there, and a
configuration's word is 0 in command mode: every word counts once in either mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...io_images.amci3601 import LIVE_BITS, CommandMsw
from ..format.flags import FLAGS as CPU_FLAGS
from ..format.flags import OVERRUN
from ..format.layout import SlotInfo
from ..signals import decode

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far two traces that count as the same may be apart.

    Raises:
        ValueError: one of them is negative.
    """

    time_ns: int = 0  # by how much an edge, a word or a position may come earlier or later, ns
    counts: int = 0  # by how much position, encoder count and captured value of a 3601 may differ

    def __post_init__(self) -> None:
        for name, value in (("time_ns", self.time_ns), ("counts", self.counts)):
            if value < 0:
                raise ValueError(f"a tolerance of {name} = {value} is not allowed: 0 or more")

    @property
    def exact(self) -> bool:
        """Whether nothing may differ."""
        return not (self.time_ns or self.counts)


EXACT = Tolerance()
"""Nothing may differ."""


class FieldKind(Enum):
    """Kind of a field."""

    BITS = "bits"
    """A word of sixteen bits, each compared by itself."""

    COUNT = "count"
    """A number that the module counts: a tolerance in counts applies, and it passes intermediate values."""

    VALUE = "value"
    """A number made of two words."""

    WORD = "word"

    TAG = "tag"


@dataclass(frozen=True, slots=True)
class Field:
    """A part of an image that is compared."""

    slot: int | None  # number of the slot; None for the CPU's flags and for tags
    direction: str  # "in", "out", "cpu" or "tags"
    name: str  # its name in the image
    kind: FieldKind  # what it is
    word: int  # index of its first word in the image
    words: int  # how many words it has
    key: Callable[[Array], Array]  # of images, what has to be equal, a number per scan
    bits: tuple[str, ...] = ()  # names of the sixteen bits, lowest first; of kind BITS only
    text: Callable[[Array], str] = str  # of kind TAG: the value in a row of tags, in words

    @property
    def path(self) -> str:
        """Its name in the trace, such as "slot1.in.position"."""
        return f"{self.stem}.{self.name}"

    @property
    def stem(self) -> str:
        """The prefix of the name of a field or bit, such as "slot1.in"."""
        return self.direction if self.slot is None else f"slot{self.slot}.{self.direction}"

    def values(self, images: Array) -> Array:
        """Return its value in some scans as float64, NaN where it has none; of a word the word."""
        if self.kind in (FieldKind.COUNT, FieldKind.VALUE):
            return decode.value(images, self.word)
        return self.key(images).astype(np.int64)

    def words_in(self, image: Array) -> tuple[int, ...]:
        """Return its words in the first of some scans."""
        if self.slot is None:
            return (int(image[0]),)
        return tuple(int(word) for word in image[0, self.word : self.word + self.words])


FLAG_BITS = ("mode.0", "mode.1", *(CPU_FLAGS.get(number, f"flags.{number}") for number in range(2, 16)))
"""The CPU's flags by name, see docs/traces.md."""

_COMPARED_FLAGS = np.uint32(~OVERRUN & 0xFFFF)

FLAGS = Field(
    None,
    "cpu",
    "flags",
    FieldKind.BITS,
    0,
    1,
    lambda flags: (flags & _COMPARED_FLAGS).astype(np.uint16),
    FLAG_BITS,
)
"""The CPU's flags, without late scans, which depend on the computer."""

TIME = Field(None, "cpu", "time_ns", FieldKind.WORD, 0, 1, lambda times: times)
"""The time of a scan; compared where scans are paired by number."""


def all_fields(slots: Sequence[SlotInfo]) -> list[Field]:
    """Return the fields of a trace in the order of a report: the logic reads inputs before it writes."""
    return [TIME, FLAGS, *(field for slot in slots for field in _fields_of(slot))]


def _fields_of(slot: SlotInfo) -> Iterator[Field]:
    if slot.is_stepper:
        for direction, fields in IMAGES_3601.items():
            yield from (_field_3601(slot, direction, *each) for each in fields)
            for word in range(len(slot.words.named(direction))):
                key = partial(_where_configured, word)
                name = f"configuration.word{word}"
                yield Field(slot.number, direction, name, FieldKind.WORD, word, 1, key)
        return
    for direction, image, words in (("in", "I", slot.words.inputs), ("out", "O", slot.words.outputs)):
        for word, name in enumerate(words):
            if any(slot.words.bits(image, word)):
                bits = _bit_names(slot, direction, word, name)
                yield Field(slot.number, direction, name, FieldKind.BITS, word, 1, partial(_bits, word), bits)
            else:
                yield Field(slot.number, direction, name, FieldKind.WORD, word, 1, partial(_word, word))


IMAGES_3601: dict[str, tuple[tuple[str, int, FieldKind, int], ...]] = {
    "in": (
        ("status_msw", 0, FieldKind.BITS, LIVE_BITS),
        ("status_lsw", 1, FieldKind.BITS, 0),
        ("position", 2, FieldKind.COUNT, 0),
        ("encoder", 4, FieldKind.COUNT, 0),
        ("captured", 6, FieldKind.COUNT, 0),
    ),
    "out": (
        ("command_msw", 0, FieldKind.BITS, CommandMsw.MODE_CONFIG.value),
        ("command_lsw", 1, FieldKind.BITS, 0),
        ("target", 2, FieldKind.VALUE, 0),
        ("programmed_speed", 4, FieldKind.VALUE, 0),
        ("acceleration", 6, FieldKind.WORD, 0),
        ("deceleration", 7, FieldKind.WORD, 0),
    ),
}
"""A stepper's fields: name, first word, kind, and the bits that mean the same in configuration mode."""


def _field_3601(slot: SlotInfo, direction: str, name: str, word: int, kind: FieldKind, live: int) -> Field:
    number = slot.number
    if kind is FieldKind.BITS:
        names = _bit_names(slot, direction, word, name)
        return Field(number, direction, name, kind, word, 1, partial(_masked, word, live), names)
    if kind is FieldKind.WORD:
        return Field(number, direction, name, kind, word, 1, partial(_where_commanded, word))
    return Field(number, direction, name, kind, word, 2, partial(_pair, word))


def _bit_names(slot: SlotInfo, direction: str, word: int, name: str) -> tuple[str, ...]:
    named = {bit: of for of, bit in slot.words.bits("I" if direction == "in" else "O", word)}
    return tuple(named.get(bit, f"{name}.{bit}") for bit in range(16))


def _word(word: int, images: Array) -> Array:
    return images[:, word]


def _bits(word: int, images: Array) -> Array:
    return np.ascontiguousarray(images[:, word]).view(np.uint16)


def _masked(word: int, live: int, images: Array) -> Array:
    bits = _bits(word, images)
    return np.where(decode.in_command_mode(images), bits, bits & np.uint16(live))


def _pair(word: int, images: Array) -> Array:
    """Return two words as one number, not decoded: two pairs may decode to one value."""
    pair = images[:, word].astype(np.int32) << 16 | images[:, word + 1].view(np.uint16).astype(np.int32)
    return np.where(decode.in_command_mode(images), pair, 0)


def _where_commanded(word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images), images[:, word], 0)


def _where_configured(word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images), 0, images[:, word])
