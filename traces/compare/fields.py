"""The compared fields of a scan: bits, decoded values and words, and their tolerances.

An image of a stepper has another meaning in configuration mode, where its words mirror the
configuration. A bit or value of command mode is therefore 0 or missing there, and a
configuration's word is 0 in command mode: every word counts once in either mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.number_formats import NumberFormat

from ..format.flags import FLAGS as CPU_FLAGS
from ..format.flags import OVERRUN
from ..format.layout import SlotInfo
from ..read.number_formats import NumberFormats
from ..signals import decode

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How much two traces that count as the same may differ.

    Raises:
        ValueError: one of them is negative.
    """

    time_ns: int = 0  # time by which an edge, a word or a position may be early or late, ns
    counts: int = 0  # allowed difference of position, encoder count and captured value of a 3601

    def __post_init__(self) -> None:
        for name, value in (("time_ns", self.time_ns), ("counts", self.counts)):
            if value < 0:
                raise ValueError(f"a tolerance of {name} = {value} is not allowed: 0 or more")

    @property
    def exact(self) -> bool:
        """Whether no difference is allowed."""
        return not (self.time_ns or self.counts)


EXACT = Tolerance()
"""No difference is allowed."""


class FieldKind(Enum):
    """Kind of a field."""

    BITS = "bits"
    """A word of sixteen bits, each compared separately."""

    COUNT = "count"
    """A number that the module counts: it has intermediate values, and a tolerance in counts applies."""

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
    kind: FieldKind  # its kind
    word: int  # index of its first word in the image
    words: int  # how many words it has
    key: Callable[[Array], Array]  # returns from images the number in each scan that must be equal
    value: Callable[[Array], Array] | None = None  # of kinds COUNT and VALUE: decodes images; NaN = no value
    bits: tuple[str, ...] = ()  # names of the sixteen bits, lowest first; of kind BITS only
    text: Callable[[Array], str] = str  # of kind TAG: returns the value in a row of tags as text

    @property
    def path(self) -> str:
        """Its name in the trace, such as "slot1.in.position"."""
        return f"{self.stem}.{self.name}"

    @property
    def stem(self) -> str:
        """The prefix of the name of a field or bit, such as "slot1.in"."""
        return self.direction if self.slot is None else f"slot{self.slot}.{self.direction}"

    def values(self, images: Array) -> Array:
        """Return its values in some scans as float64, NaN where it has none; a word is its own value."""
        if self.value is not None:
            return self.value(images)
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
    bits=FLAG_BITS,
)
"""The CPU's flags, without late scans, which depend on the computer."""

TIME = Field(None, "cpu", "time_ns", FieldKind.WORD, 0, 1, lambda times: times)
"""The time of a scan; compared where scans are paired by number."""


LAST = 1 << 63
"""A scan number after all others."""


def all_fields(slots: Sequence[SlotInfo], formats: NumberFormats | None = None) -> list[Field]:
    """Return the fields of a trace in the order of a report: inputs before outputs, as the logic uses them.

    Args:
        formats: number formats of modules whose configuration selects them; the last format decodes.
    """
    known_formats = NumberFormats() if formats is None else formats
    return [TIME, FLAGS, *(field for slot in slots for field in _fields_of(slot, known_formats))]


def _fields_of(slot: SlotInfo, formats: NumberFormats) -> Iterator[Field]:
    if slot.words.modes is not None:
        for direction in ("in", "out"):
            yield from _moded_fields(slot, direction, formats)
        return
    for direction, image, words in (("in", "I", slot.words.inputs), ("out", "O", slot.words.outputs)):
        for word, name in enumerate(words):
            if any(slot.words.bits(image, word)):
                bits = _bit_names(slot, direction, word, name)
                yield Field(
                    slot.number, direction, name, FieldKind.BITS, word, 1, partial(_bits, word), bits=bits
                )
            else:
                yield Field(slot.number, direction, name, FieldKind.WORD, word, 1, partial(_word, word))


def _moded_fields(slot: SlotInfo, direction: str, formats: NumberFormats) -> Iterator[Field]:
    """Yield the fields of an image of a module with two modes; fields of configuration mode come last."""
    number, words, names = slot.number, slot.words, slot.words.named(direction)
    pairs = {quantity.word: quantity for quantity in words.quantities_in(direction) if quantity.words > 1}
    seconds = {word + 1 for word in pairs}
    mode = words.modes.word(direction) if words.modes else 0
    for word, name in enumerate(names):
        if word in pairs:
            kind = FieldKind.COUNT if direction == "in" else FieldKind.VALUE
            value = partial(_value, mode, word, formats.at(number, pairs[word], LAST))
            yield Field(number, direction, pairs[word].name, kind, word, 2, partial(_pair, mode, word), value)
        elif any(words.bits("I" if direction == "in" else "O", word)):
            bits, live_bits = _bit_names(slot, direction, word, name), words.live(direction, word)
            key = partial(_masked, mode, word, live_bits)
            yield Field(number, direction, name, FieldKind.BITS, word, 1, key, bits=bits)
        elif word not in seconds:
            yield Field(
                number, direction, name, FieldKind.WORD, word, 1, partial(_where_commanded, mode, word)
            )
    for word in range(len(names)):
        key = partial(_where_configured, mode, word)
        yield Field(number, direction, f"configuration.word{word}", FieldKind.WORD, word, 1, key)


def _bit_names(slot: SlotInfo, direction: str, word: int, name: str) -> tuple[str, ...]:
    names_by_bit = {
        bit: bit_name for bit_name, bit in slot.words.bits("I" if direction == "in" else "O", word)
    }
    return tuple(names_by_bit.get(bit, f"{name}.{bit}") for bit in range(16))


def _word(word: int, images: Array) -> Array:
    return images[:, word]


def _bits(word: int, images: Array) -> Array:
    return np.ascontiguousarray(images[:, word]).view(np.uint16)


def _masked(mode: int, word: int, live: int, images: Array) -> Array:
    bits = _bits(word, images)
    return np.where(decode.in_command_mode(images, mode), bits, bits & np.uint16(live))


def _pair(mode: int, word: int, images: Array) -> Array:
    """Return two words as one undecoded number, because two pairs may decode to the same value."""
    undecoded = images[:, word].astype(np.int32) << 16 | images[:, word + 1].view(np.uint16).astype(np.int32)
    return np.where(decode.in_command_mode(images, mode), undecoded, 0)


def _value(mode: int, word: int, format: NumberFormat, images: Array) -> Array:
    """Return two words decoded; NaN in configuration mode."""
    values = format.reported_all(images[:, word], images[:, word + 1])
    values[~decode.in_command_mode(images, mode)] = np.nan
    return values


def _where_commanded(mode: int, word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images, mode), images[:, word], 0)


def _where_configured(mode: int, word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images, mode), 0, images[:, word])
