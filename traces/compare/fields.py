"""What is compared of a scan: bits, decoded values and words, each with the words of the image it is made of.

A 3601's image means something else in configuration mode, where its words echo the
configuration. So a bit or value of command mode is 0 or missing there, and a
configuration's word is 0 in command mode: every word counts once in either mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, IntFlag
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...io_images.amci3601 import LIVE_BITS, CommandLsw, CommandMsw, StatusLsw, StatusMsw
from ...io_images.image import WORDS
from ..format.flags import FLAGS as CPU_FLAGS
from ..format.flags import OVERRUN
from ..format.layout import SlotInfo
from ..signals import decode

Array = NDArray[Any]
Words = NDArray[np.int16]
"""An image in some scans: a row per scan, a column per word."""

_MODE_CONFIG = CommandMsw.MODE_CONFIG.value


class Kind(Enum):
    """What a field is."""

    BITS = "bits"
    """A word of sixteen bits, each of which is compared by itself."""

    COUNT = "count"
    """A number that the module counts: a tolerance in counts applies, and it passes what lies between."""

    VALUE = "value"
    """A number made of two words."""

    WORD = "word"
    """A word."""

    TAG = "tag"
    """A recorded tag."""


@dataclass(frozen=True, slots=True)
class Field:
    """A part of an image that is compared.

    Attributes:
        slot: number of the slot; None for the CPU's flags and for tags.
        direction: "in", "out", "cpu" or "tags".
        name: its name in the image.
        kind: what it is.
        word: index of its first word in the image.
        words: how many words it has.
        key: of images, what has to be equal, a number per scan.
        bits: names of the sixteen bits, lowest first; of kind BITS only.
        text: of kind TAG: the value in a row of tags, in words.
    """

    slot: int | None
    direction: str
    name: str
    kind: Kind
    word: int
    words: int
    key: Callable[[Array], Array]
    bits: tuple[str, ...] = ()
    text: Callable[[Array], str] = str

    @property
    def path(self) -> str:
        """Its name in the trace, such as "slot1.in.position"."""
        return f"{self.stem}.{self.name}"

    @property
    def stem(self) -> str:
        """The prefix of the name of a field or bit, such as "slot1.in"."""
        return self.direction if self.slot is None else f"slot{self.slot}.{self.direction}"

    def values(self, images: Array) -> Array:
        """Return its value in some scans, float64; NaN where it has none. Of COUNT and VALUE only."""
        return decode.value(images, self.word)

    def differing_bits(self, one: int, other: int) -> Iterator[tuple[str, bool, bool]]:
        """Yield name and both levels of each bit that differs."""
        for number, name in enumerate(self.bits):
            if (one ^ other) >> number & 1:
                yield name, bool(one >> number & 1), bool(other >> number & 1)


FLAG_BITS = ("mode.0", "mode.1", *(CPU_FLAGS.get(number, f"flags.{number}") for number in range(2, 16)))
"""The CPU's flags by name, see docs/traces.md."""

_COMPARED_FLAGS = np.uint32(~OVERRUN & 0xFFFF)


def _flags(flags: Array) -> Array:
    return (flags & _COMPARED_FLAGS).astype(np.uint16)


FLAGS = Field(None, "cpu", "flags", Kind.BITS, 0, 1, _flags, FLAG_BITS)
"""What the CPU was doing; that a scan began late is a matter of the computer it ran on, and may differ."""

TIME = Field(None, "cpu", "time_ns", Kind.WORD, 0, 1, lambda times: times)
"""When the scan was; compared where scans are paired by number."""


def fields_of(slot: SlotInfo) -> Iterator[Field]:
    """Yield the fields of a slot's images, inputs first: the logic reads before it writes."""
    if slot.is_stepper:
        yield from _inputs_3601(slot.number)
        yield from _outputs_3601(slot.number)
        return
    for direction, image, words in (("in", "I", slot.words.inputs), ("out", "O", slot.words.outputs)):
        for word, name in enumerate(words):
            named = {bit: of for of, bit in slot.words.bits(image, word)}
            if named:
                bits = tuple(named.get(bit, f"{name}.{bit}") for bit in range(16))
                yield Field(slot.number, direction, name, Kind.BITS, word, 1, partial(_bits_of, word), bits)
            else:
                yield Field(slot.number, direction, name, Kind.WORD, word, 1, partial(_plain, word))


def _inputs_3601(slot: int) -> Iterator[Field]:
    bits = partial(_bits, slot, "in")
    yield bits("status_msw", 0, StatusMsw, LIVE_BITS)
    yield bits("status_lsw", 1, StatusLsw, 0)
    for name, word in (("position", 2), ("encoder", 4), ("captured", 6)):
        yield Field(slot, "in", name, Kind.COUNT, word, 2, partial(_pair, word))
    yield from _configuration(slot, "in")


def _outputs_3601(slot: int) -> Iterator[Field]:
    bits = partial(_bits, slot, "out")
    yield bits("command_msw", 0, CommandMsw, _MODE_CONFIG)
    yield bits("command_lsw", 1, CommandLsw, 0)
    for name, word in (("target", 2), ("programmed_speed", 4)):
        yield Field(slot, "out", name, Kind.VALUE, word, 2, partial(_pair, word))
    for name, word in (("acceleration", 6), ("deceleration", 7)):
        yield Field(slot, "out", name, Kind.WORD, word, 1, partial(_command_word, word))
    yield from _configuration(slot, "out")


def _bits(slot: int, direction: str, name: str, word: int, bits: type[IntFlag], live: int) -> Field:
    """Return the field of a word of bits; `live` are those that mean the same in configuration mode."""
    names = tuple(
        str(bits(1 << number).name) if 1 << number in bits.__members__.values() else f"{name}.{number}"
        for number in range(16)
    )
    return Field(slot, direction, name, Kind.BITS, word, 1, partial(_masked, word, live), names)


def _configuration(slot: int, direction: str) -> Iterator[Field]:
    for word in range(WORDS):
        name = f"configuration.word{word}"
        yield Field(slot, direction, name, Kind.WORD, word, 1, partial(_configuration_word, word))


def _plain(word: int, images: Words) -> Array:
    return images[:, word]


def _bits_of(word: int, images: Words) -> Array:
    return np.ascontiguousarray(images[:, word]).view(np.uint16)


def _masked(word: int, live: int, images: Words) -> Array:
    bits = np.ascontiguousarray(images[:, word]).view(np.uint16)
    return np.where(decode.in_command_mode(images), bits, bits & np.uint16(live))


def _pair(word: int, images: Words) -> Array:
    """Return two words as one number, not decoded: two pairs may decode to one value."""
    pair = images[:, word].astype(np.int32) << 16 | images[:, word + 1].view(np.uint16).astype(np.int32)
    return np.where(decode.in_command_mode(images), pair, 0)


def _command_word(word: int, images: Words) -> Array:
    return np.where(decode.in_command_mode(images), images[:, word], 0)


def _configuration_word(word: int, images: Words) -> Array:
    return np.where(decode.in_command_mode(images), 0, images[:, word])


def all_fields(slots: Sequence[SlotInfo]) -> list[Field]:
    """Return the fields of a trace in the order of a report."""
    return [TIME, FLAGS, *(field for slot in slots for field in fields_of(slot))]
