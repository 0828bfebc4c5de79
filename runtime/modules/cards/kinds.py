"""The cards that can be put into a slot: one row each, named as Rockwell sells them.

    1762-...    a MicroLogix 1100, 1200 or 1400:  I:2.0/3, O:2.0/3
    1769-...    a CompactLogix:                   Local:2:I.Data.3, Local:2:O.Data.3

Terminal n of a digital card is bit n of its data, 16 to a word. Channel n of an analog card is word n.
The data of a card with 32 terminals are one DINT to a CompactLogix: `Local:2:I.Data.31`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .analog import FORMATS, FORMATS_12, RANGES, Convert, RangeBits


@dataclass(frozen=True, slots=True)
class CardKind:
    """A row of the table.

    Attributes:
        inputs: number of its digital inputs.
        outputs: number of its digital outputs.
        channels_in: number of its analog inputs.
        channels_out: number of its analog outputs.
        echo: the input image repeats the present outputs (output data echo).
        echo_at: of an analog card: the input word that repeats channel 0.
        bits: of an analog card: places of its range bits.
        ranges: of an analog card: names of its channels' ranges.
        formats: of an analog card: its data formats.
        ignored: of an analog card: low bits of an output word that have no effect.
    """

    name: str
    inputs: int = 0
    outputs: int = 0
    channels_in: int = 0
    channels_out: int = 0
    echo: bool = False
    echo_at: int = 0
    bits: RangeBits | None = None
    ranges: tuple[str, ...] = ()
    formats: Mapping[str, Convert] = field(default_factory=dict)
    ignored: int = 0

    @property
    def analog(self) -> bool:
        """Whether it has channels; such a card has no terminals."""
        return bool(self.channels_in or self.channels_out)


_ALL_RANGES = tuple(RANGES)
_INPUT_BITS = RangeBits(status_word=4, word=5, over=14, step=-2)  # U0 O0 U1 O1 U2 O2 U3 O3 from bit 15 on
_RAW = {"raw": FORMATS["raw"]}

KINDS: Mapping[str, CardKind] = {
    kind.name: kind
    for kind in (
        CardKind("discrete16", inputs=16, outputs=16),  # a 1769-IQ16 and a 1769-OB16 in one slot
        CardKind("1762-IQ8", inputs=8),
        CardKind("1762-IQ16", inputs=16),
        CardKind("1762-OB8", outputs=8),
        CardKind("1762-OB16", outputs=16),
        CardKind("1762-OW8", outputs=8),
        CardKind("1762-IF4", channels_in=4, bits=_INPUT_BITS, ranges=_ALL_RANGES, formats=_RAW),
        CardKind(
            "1762-OF4",
            channels_out=4,
            bits=RangeBits(status_word=0, word=1, over=6, step=-2),  # U0 O0 ... from bit 7 on
            ranges=("0..10 V", "4..20 mA", "0..20 mA"),
            formats=FORMATS_12,
            ignored=7,
        ),
        CardKind("1769-IQ16", inputs=16),
        CardKind("1769-IQ32", inputs=32),
        CardKind("1769-OB16", outputs=16, echo=True),
        CardKind("1769-OB32", outputs=32, echo=True),
        CardKind("1769-OW8", outputs=8, echo=True),
        CardKind("1769-IF4", channels_in=4, bits=_INPUT_BITS, ranges=_ALL_RANGES, formats=FORMATS),
        CardKind(
            "1769-OF4",
            channels_out=4,
            echo=True,
            echo_at=1,
            bits=RangeBits(status_word=0, word=0, over=8, step=2),  # U3 O3 ... U0 O0 from bit 15 on
            ranges=_ALL_RANGES,
            formats=FORMATS,
        ),
    )
}
"""The cards by catalog name."""

DISCRETE16 = KINDS["discrete16"]
