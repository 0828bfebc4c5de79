"""The available cards: one row each, by catalog number.

    1762-...    a MicroLogix 1100, 1200 or 1400:  I:2.0/3, O:2.0/3
    1769-...    a CompactLogix:                   Local:2:I.Data.3, Local:2:O.Data.3

Terminal n of a digital card is bit n of its data, with 16 bits per word. Channel n of an analog card is word
n. In a CompactLogix, the data of a card with 32 terminals is one DINT: `Local:2:I.Data.31`.

To add a card, add its row and run `python -m tests.tools.generate`, which updates the tables and the schema.
The members of tags are derived from the row and have the same names as in Studio 5000 [1769-UM002B, table
3.1; 1769-IN087A, page 15]. `Fault` belongs to the connection and is not a word of an image:

    digital inputs      I.Data
    digital outputs     O.Data, I.ReadBack
    analog inputs       I.Ch0Data, I.Ch0Status, I.Ch0Overrange, I.Ch0Underrange
    analog outputs      O.Ch0Data, I.Ch0DataEcho, I.Ch0Status, I.Ch0Overrange, I.Ch0Underrange
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from itertools import chain
from typing import NamedTuple

from .dataclass import dataclass
from .signal_ranges import FORMATS, FORMATS_12, RANGES, Convert

WORD_BITS = 16


class RangeBits(NamedTuple):
    """The places of the range bits in a card's input image."""

    status_word: int  # word of the status bits; bit n belongs to channel n
    word: int  # word of the over- and under-range bits
    over: int  # the over-range bit of channel 0
    step: int  # from the over-range bit of a channel to the bit of the next channel

    def over_bit(self, channel: int) -> int:
        """Return the over-range bit of a channel; the next bit is its under-range bit."""
        return self.over + self.step * channel


class MemberPlace(NamedTuple):
    """The place of a member in an image."""

    image: str  # "I" or "O"
    word: int  # 0 to 7
    bit: int | None = None  # 0 to 15; None for a word, or for a DINT of two words


@dataclass(frozen=True, slots=True)
class CardKind:
    """A type of card, which has either terminals (digital) or channels (analog)."""

    name: str  # catalog number
    inputs: tuple[int, ...] = ()  # mask of the digital inputs in each word
    outputs: tuple[int, ...] = ()  # mask of the digital outputs in each word
    channels_in: int = 0  # number of analog inputs
    channels_out: int = 0  # number of analog outputs
    echo: bool = False  # whether the input image repeats the outputs (output data echo)
    echo_at: int = 0  # the input word that repeats output word or channel 0; it is after all inputs
    # of an analog card:
    bits: Mapping[str, RangeBits] = field(default_factory=dict)  # range bits by image
    ranges: tuple[str, ...] = ()  # names of the signal ranges
    formats: Mapping[str, Convert] = field(default_factory=dict)  # data formats
    ignored: int = 0  # number of ignored low bits in an output word

    def __post_init__(self) -> None:
        """Raise a ValueError if the echo overlaps inputs."""
        input_words = max(len(self.inputs), self.channels_in)
        if self.echo and self.echo_at < input_words:
            raise ValueError(
                f"{self.name}: echo_at = {self.echo_at}: words 0 to {input_words - 1} are inputs"
            )

    @property
    def shown(self) -> tuple[int, ...]:
        """Mask of the bits in each word of a digital card's input image: inputs and echo."""
        unused_words = (0,) * (self.echo_at - len(self.inputs))
        return (*self.inputs, *unused_words, *self.outputs) if self.echo else self.inputs

    @property
    def analog(self) -> bool:
        """Whether the card is analog."""
        return bool(self.channels_in or self.channels_out)

    @property
    def channels(self) -> Mapping[str, int]:
        """Number of channels in each image."""
        return {"I": self.channels_in, "O": self.channels_out}

    @property
    def data_bits(self) -> int:
        """Number of bits in `Data` and `ReadBack`; 0 for an analog card, which has neither."""
        if self.analog:
            return 0
        return 32 if max(len(self.inputs), len(self.outputs)) > 1 else WORD_BITS

    @property
    def has_members(self) -> bool:
        """Whether the card's tags have members; MicroLogix cards have only words."""
        return not self.name.startswith("1762")

    def members(self) -> Iterator[tuple[str, MemberPlace]]:
        """Yield the members of its tags, except `Data`."""
        if self.echo and not self.analog:
            yield "ReadBack", MemberPlace("I", self.echo_at)
        for image, count in self.channels.items():
            for channel in range(count):
                bits = self.bits[image]
                over = bits.over_bit(channel)
                yield f"Ch{channel}Data", MemberPlace(image, channel)
                if self.echo and image == "O":
                    yield f"Ch{channel}DataEcho", MemberPlace("I", self.echo_at + channel)
                yield f"Ch{channel}Status", MemberPlace("I", bits.status_word, channel)
                yield f"Ch{channel}Overrange", MemberPlace("I", bits.word, over)
                yield f"Ch{channel}Underrange", MemberPlace("I", bits.word, over + 1)


_ALL_RANGES = tuple(RANGES)
_INPUT_BITS = {"I": RangeBits(status_word=4, word=5, over=14, step=-2)}  # U0 O0 U1 O1 U2 O2 U3 O3 from bit 15
_RAW = {"raw": FORMATS["raw"]}
_8, _16, _32 = (0x00FF,), (0xFFFF,), (0xFFFF, 0xFFFF)

KINDS: Mapping[str, CardKind] = {
    kind.name: kind
    for kind in (
        CardKind("discrete16", inputs=_16, outputs=_16),  # a 1769-IQ16 and a 1769-OB16 in one slot
        CardKind("1762-IQ8", inputs=_8),
        CardKind("1762-IQ16", inputs=_16),
        CardKind("1762-OB8", outputs=_8),
        CardKind("1762-OB16", outputs=_16),
        CardKind("1762-OW8", outputs=_8),
        CardKind("1762-IF4", channels_in=4, bits=_INPUT_BITS, ranges=_ALL_RANGES, formats=_RAW),
        CardKind(
            "1762-OF4",
            channels_out=4,
            bits={"O": RangeBits(status_word=0, word=1, over=6, step=-2)},  # U0 O0 ... from bit 7 on
            ranges=("0..10 V", "4..20 mA", "0..20 mA"),
            formats=FORMATS_12,
            ignored=7,
        ),
        CardKind("1769-IQ16", inputs=_16),
        CardKind("1769-IQ32", inputs=_32),
        CardKind("1769-OB16", outputs=_16, echo=True),
        CardKind("1769-OB32", outputs=_32, echo=True),
        CardKind("1769-OW8", outputs=_8, echo=True),
        CardKind("1769-IF4", channels_in=4, bits=_INPUT_BITS, ranges=_ALL_RANGES, formats=FORMATS),
        CardKind(
            "1769-OF4",
            channels_out=4,
            echo=True,
            echo_at=1,
            bits={"O": RangeBits(status_word=0, word=0, over=8, step=2)},  # U3 O3 ... U0 O0 from bit 15 on
            ranges=_ALL_RANGES,
            formats=FORMATS,
        ),
    )
}
"""The cards by catalog number."""

DISCRETE16 = KINDS["discrete16"]

MEMBERS: Mapping[str, tuple[tuple[str, MemberPlace], ...]] = {
    name: tuple(kind.members()) for name, kind in KINDS.items() if kind.has_members
}
"""Members of tags except `Data`, by catalog number."""


def member_of(card: str | None, image: str, name: str) -> MemberPlace | None:
    """Return the place of a member; None if the card lacks it, or if the place depends on the unknown card.

    >>> member_of("1769-IF4", "I", "ch1overrange"), member_of(None, "I", "Ch1Status")
    (MemberPlace(image='I', word=5, bit=12), None)
    >>> member_of(None, "I", "ReadBack")
    MemberPlace(image='I', word=0, bit=None)

    Args:
        card: catalog number of the card; None if it is unknown.
        image: "I" or "O".
        name: name of the member, in upper or lower case.
    """
    tables = MEMBERS.values() if card is None else [MEMBERS.get(card, ())]
    key = name.upper(), image
    members = chain.from_iterable(tables)
    places = {place for member, place in members if (member.upper(), place.image) == key}
    return places.pop() if len(places) == 1 else None


def members_of(card: str, image: str) -> list[str]:
    """Return the names of the members of an image."""
    return [name for name, place in MEMBERS.get(card, ()) if place.image == image]
