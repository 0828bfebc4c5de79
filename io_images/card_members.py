"""Members of a card's tags as Studio 5000 names them: `Local:3:I.Ch1Overrange`, `Local:2:I.ReadBack.3`.

    1769-IQ16, -IQ32            I.Data
    1769-OB16, -OB32, -OW8      O.Data, I.ReadBack
    1769-IF4                    I.Ch0Data, I.Ch0Status, I.Ch0Overrange, I.Ch0Underrange
    1769-OF4                    O.Ch0Data, I.Ch0DataEcho, I.Ch0Status, I.Ch0Overrange, I.Ch0Underrange

Words and bits are those of 1769-UM002B, table 3.1, and 1769-IN087A, page 15. `Fault` is that of the
connection and no word of an image.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

_CHANNELS = range(4)


class MemberPlace(NamedTuple):
    """Where a member is.

    Attributes:
        image: "I" or "O".
        word: 0 to 7.
        bit: 0 to 15; None for a whole word, or for a DINT of two words.
    """

    image: str
    word: int
    bit: int | None = None


def _inputs() -> Iterator[tuple[str, MemberPlace]]:
    for channel in _CHANNELS:
        yield f"Ch{channel}Data", MemberPlace("I", channel)
        yield f"Ch{channel}Status", MemberPlace("I", 4, channel)
        yield f"Ch{channel}Overrange", MemberPlace("I", 5, 14 - 2 * channel)
        yield f"Ch{channel}Underrange", MemberPlace("I", 5, 15 - 2 * channel)


def _outputs() -> Iterator[tuple[str, MemberPlace]]:
    for channel in _CHANNELS:
        yield f"Ch{channel}Data", MemberPlace("O", channel)
        yield f"Ch{channel}DataEcho", MemberPlace("I", 1 + channel)
        yield f"Ch{channel}Status", MemberPlace("I", 0, channel)
        yield f"Ch{channel}Overrange", MemberPlace("I", 0, 8 + 2 * channel)
        yield f"Ch{channel}Underrange", MemberPlace("I", 0, 9 + 2 * channel)


_READ_BACK = {"ReadBack": MemberPlace("I", 0)}

MEMBERS: Mapping[str, Mapping[str, MemberPlace]] = {
    "1769-OB16": _READ_BACK,
    "1769-OB32": _READ_BACK,
    "1769-OW8": _READ_BACK,
    "1769-IF4": dict(_inputs()),
    "1769-OF4": dict(_outputs()),
}
"""Members beside `Data`, by catalog number."""

DATA_BITS: Mapping[str, int] = {
    "1769-IQ16": 16,
    "1769-OB16": 16,
    "1769-OW8": 16,
    "1769-IQ32": 32,
    "1769-OB32": 32,
    "discrete16": 16,
}
"""Bits of `Data` and `ReadBack`, by catalog number."""


def member_of(card: str | None, image: str, name: str) -> MemberPlace | None:
    """Return where a member is; None if there is none, or if cards differ and the card is not known.

    >>> member_of("1769-IF4", "I", "ch1overrange"), member_of(None, "I", "Ch1Status")
    (MemberPlace(image='I', word=5, bit=12), None)
    >>> member_of(None, "I", "ReadBack")
    MemberPlace(image='I', word=0, bit=None)

    Args:
        card: its catalog number; None if it is not known.
        image: "I" or "O".
        name: in any case.
    """
    tables = MEMBERS.values() if card is None else [MEMBERS.get(card, {})]
    wanted = name.upper()
    places = {place for table in tables for each, place in table.items() if each.upper() == wanted}
    found = [place for place in places if place.image == image]
    return found[0] if len(found) == 1 else None


def members_of(card: str, image: str) -> list[str]:
    """Return the names of the members of an image."""
    return [name for name, place in MEMBERS.get(card, {}).items() if place.image == image]
