"""The compared fields of a scan: bits, decoded values and words, and their tolerances.

In configuration mode, the words of a stepper's image mirror the configuration. A bit or value of command mode
is therefore treated as 0 or missing in configuration mode. A configuration word is treated as 0 in command
mode. Every word is therefore compared exactly once in each mode.
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
    """The allowed differences between two traces.

    Raises:
        ValueError: a tolerance is negative.
    """

    time_ns: int = 0  # time by which an edge, word or position may be early or late, ns
    counts: int = 0  # allowed difference of position, encoder count and captured value of a 3601

    def __post_init__(self) -> None:
        for name, value in (("time_ns", self.time_ns), ("counts", self.counts)):
            if value < 0:
                raise ValueError(f"tolerance {name}: {value} is negative; a tolerance is 0 or more")

    @property
    def exact(self) -> bool:
        """Whether both tolerances are 0."""
        return not (self.time_ns or self.counts)


EXACT = Tolerance()
"""No difference is allowed."""


class FieldKind(Enum):
    """Kind of a field."""

    BITS = "bits"
    """A sixteen-bit word whose bits are compared separately."""

    COUNT = "count"
    """A number in counts, such as a position, to which a tolerance in counts applies."""

    VALUE = "value"
    """A number made up of two words."""

    WORD = "word"

    TAG = "tag"


@dataclass(frozen=True, slots=True)
class Field:
    """A part of an image that is compared."""

    slot: int | None  # number of the slot; None for the CPU's flags and for tags
    direction: str  # "in", "out", "cpu" or "tags"
    name: str  # its name in the image
    kind: FieldKind
    word: int  # index of its first word in the image
    words: int  # number of its words
    key: Callable[[Array], Array]  # returns a number for each image; equal numbers = equal fields
    value: Callable[[Array], Array] | None = None  # of kinds COUNT and VALUE: decodes images; NaN = no value
    bits: tuple[str, ...] = ()  # names of the sixteen bits, lowest first; of kind BITS only
    text: Callable[[Array], str] = str  # of kind TAG: returns the value in a row of tags as text

    @property
    def path(self) -> str:
        """The field's name in the trace, such as "slot1.in.position"."""
        return f"{self.stem}.{self.name}"

    @property
    def stem(self) -> str:
        """The prefix of the name of a field or bit, such as "slot1.in"."""
        return self.direction if self.slot is None else f"slot{self.slot}.{self.direction}"

    def values(self, images: Array) -> Array:
        """Return the decoded value in each image as float64 (NaN = no value), or else the key as int64."""
        if self.value is not None:
            return self.value(images)
        return self.key(images).astype(np.int64)

    def words_in(self, image: Array) -> tuple[int, ...]:
        """Return the field's words in the first of the given images."""
        if self.slot is None:
            return (int(image[0]),)
        return tuple(int(word) for word in image[0, self.word : self.word + self.words])


FLAG_BITS = ("mode.0", "mode.1", *(CPU_FLAGS.get(number, f"flags.{number}") for number in range(2, 16)))
"""The controller's flags by name, see docs/traces.md."""

_COMPARED_FLAGS = np.uint32(~OVERRUN & 0xFFFF)

FLAGS = Field(
    None,
    "cpu",
    "flags",
    FieldKind.BITS,
    word=0,
    words=1,
    key=lambda flags: (flags & _COMPARED_FLAGS).astype(np.uint16),
    bits=FLAG_BITS,
)
"""The controller's flags without the late-scan flag, which depends on the computer."""

TIME = Field(None, "cpu", "time_ns", FieldKind.WORD, word=0, words=1, key=lambda times: times)
"""The time of a scan; compared where scans are paired by number."""


LAST = 1 << 63
"""A number greater than every scan number."""


def all_fields(slots: Sequence[SlotInfo], formats: NumberFormats | None = None) -> list[Field]:
    """Return the fields of a trace in report order, with inputs before outputs, as the logic uses them.

    Args:
        formats: number formats of modules whose configuration selects them; the last format of the trace
            decodes all scans.
    """
    slot_formats = NumberFormats() if formats is None else formats
    return [TIME, FLAGS, *(field for slot in slots for field in _fields_of(slot, slot_formats))]


def _fields_of(slot: SlotInfo, formats: NumberFormats) -> Iterator[Field]:
    """Yield the fields of a slot; without modes, each word is a field, compared by its bits if named."""
    if slot.words.modes is not None:
        for direction in ("in", "out"):
            yield from _moded_fields(slot, direction, formats)
        return
    for direction in ("in", "out"):
        for word, name in enumerate(slot.words.named(direction)):
            bits = _bit_names(slot, direction, word, name)
            kind, key = (FieldKind.BITS, _bits) if bits else (FieldKind.WORD, _word)
            yield Field(
                slot.number, direction, name, kind, word=word, words=1, key=partial(key, word), bits=bits
            )


def _moded_fields(slot: SlotInfo, direction: str, formats: NumberFormats) -> Iterator[Field]:
    """Yield the fields of an image of a module with two modes; fields of configuration mode come last."""
    number, words, names = slot.number, slot.words, slot.words.named(direction)
    pairs = {quantity.word: quantity for quantity in words.quantities_in(direction) if quantity.words > 1}
    second_words = {word + 1 for word in pairs}
    mode_word = words.modes.word(direction) if words.modes else 0
    for word, name in enumerate(names):
        bits = _bit_names(slot, direction, word, name)
        if word in pairs:
            kind = FieldKind.COUNT if direction == "in" else FieldKind.VALUE
            value = partial(_value, mode_word, word, formats.at(number, pairs[word], LAST))
            key = partial(_pair, mode_word, word)
            pair_name = pairs[word].name
            yield Field(number, direction, pair_name, kind, word=word, words=2, key=key, value=value)
        elif bits:
            key = partial(_live_bits, mode_word, word, words.live(direction, word))
            yield Field(number, direction, name, FieldKind.BITS, word=word, words=1, key=key, bits=bits)
        elif word not in second_words:
            key = partial(_command_word, mode_word, word)
            yield Field(number, direction, name, FieldKind.WORD, word=word, words=1, key=key)
    for word in range(len(names)):
        key = partial(_configuration_word, mode_word, word)
        name = f"configuration.word{word}"
        yield Field(number, direction, name, FieldKind.WORD, word=word, words=1, key=key)


def _bit_names(slot: SlotInfo, direction: str, word: int, name: str) -> tuple[str, ...]:
    """Return the names of a word's sixteen bits; empty if no bit has its own name."""
    image = "I" if direction == "in" else "O"
    names_by_bit = {bit: bit_name for bit_name, bit in slot.words.bits(image, word)}
    return tuple(names_by_bit.get(bit, f"{name}.{bit}") for bit in range(16)) if names_by_bit else ()


def _word(word: int, images: Array) -> Array:
    return images[:, word]


def _bits(word: int, images: Array) -> Array:
    return np.ascontiguousarray(images[:, word]).view(np.uint16)


def _live_bits(mode_word: int, word: int, live_mask: int, images: Array) -> Array:
    """Return a word; in configuration mode, keep only the bits that have the same meaning in both modes."""
    bits = _bits(word, images)
    return np.where(decode.in_command_mode(images, mode_word), bits, bits & np.uint16(live_mask))


def _pair(mode_word: int, word: int, images: Array) -> Array:
    """Return two words as one undecoded number, because two pairs may decode to the same value."""
    undecoded = images[:, word].astype(np.int32) << 16 | images[:, word + 1].view(np.uint16).astype(np.int32)
    return np.where(decode.in_command_mode(images, mode_word), undecoded, 0)


def _value(mode_word: int, word: int, number_format: NumberFormat, images: Array) -> Array:
    """Return the decoded value of two words; NaN in configuration mode."""
    values = number_format.reported_all(images[:, word], images[:, word + 1])
    values[~decode.in_command_mode(images, mode_word)] = np.nan
    return values


def _command_word(mode_word: int, word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images, mode_word), images[:, word], 0)


def _configuration_word(mode_word: int, word: int, images: Array) -> Array:
    return np.where(decode.in_command_mode(images, mode_word), 0, images[:, word])
