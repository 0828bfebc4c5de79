"""The cards that can be put into a slot: one row each, named as Rockwell sells them.

    1762-...    a MicroLogix 1100, 1200 or 1400:  I:2.0/3, O:2.0/3
    1769-...    a CompactLogix:                   Local:2:I.Data.3, Local:2:O.Data.3

Terminal n of a digital card is bit n of its data, 16 to a word. Channel n of an analog card is word n.
The data of a card with 32 terminals are one DINT to a CompactLogix: `Local:2:I.Data.31`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CardKind:
    """What a card has.

    Attributes:
        name: its catalog name.
        inputs: number of its digital inputs.
        outputs: number of its digital outputs.
        channels_in: number of its analog inputs.
        channels_out: number of its analog outputs.
        echo: the input image repeats the outputs that are in force (output data echo).
    """

    name: str
    inputs: int = 0
    outputs: int = 0
    channels_in: int = 0
    channels_out: int = 0
    echo: bool = False

    @property
    def analog(self) -> bool:
        """Whether it has channels; no card has terminals, too."""
        return bool(self.channels_in or self.channels_out)


KINDS: Mapping[str, CardKind] = {
    kind.name: kind
    for kind in (
        CardKind("discrete16", inputs=16, outputs=16),  # a 1769-IQ16 and a 1769-OB16 in one slot
        CardKind("1762-IQ8", inputs=8),
        CardKind("1762-IQ16", inputs=16),
        CardKind("1762-OB8", outputs=8),
        CardKind("1762-OB16", outputs=16),
        CardKind("1762-OW8", outputs=8),
        CardKind("1762-IF4", channels_in=4),
        CardKind("1762-OF4", channels_out=4),
        CardKind("1769-IQ16", inputs=16),
        CardKind("1769-IQ32", inputs=32),
        CardKind("1769-OB16", outputs=16, echo=True),
        CardKind("1769-OB32", outputs=32, echo=True),
        CardKind("1769-OW8", outputs=8, echo=True),
        CardKind("1769-IF4", channels_in=4),
        CardKind("1769-OF4", channels_out=4),
    )
}
"""The cards by catalog name."""

DISCRETE16 = KINDS["discrete16"]
