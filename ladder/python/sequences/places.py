"""Finds the place of an input or output, given an address or a bare name that is unique in the rack."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from scanrack.io_images.addresses import Address, allowed, parse_address
from scanrack.io_images.module_words import ModuleWords

Rack = Mapping[int, ModuleWords]
"""Word names of the module in each slot, by slot number."""

KINDS = {"I": "input", "O": "output"}
"""Name of an image in messages."""

_BARE_NAME = re.compile(r"[A-Za-z_]\w*")


def find_bit(text: str, image: str, rack: Rack) -> Address:
    """Find a bit.

    >>> from scanrack.io_images.amci3601.words import WORDS_3601
    >>> str(find_bit("IN_HOME", "I", {1: WORDS_3601}))
    'Local:1:I.Data[1].2'

    Args:
        text: an address, see `scanrack.io_images.addresses`, or the bare name of a bit.
        image: "I" or "O".

    Raises:
        ValueError: the bit is unknown, is in the other image, is a word, or is not a terminal of a card.
    """
    address = _find(text, image, rack, _bits(image, rack))
    if address.bit is None:
        kind = KINDS[image].capitalize()
        raise ValueError(f"{text!r} is a word; add a bit, or declare it as {kind}Word")
    terminals = rack[address.slot].terminals_instead(image, address.word, address.bit)
    if terminals:
        raise ValueError(f"{text!r}: the card in slot {address.slot} has {terminals}")
    return address


def find_word(text: str, image: str, rack: Rack) -> Address:
    """Find a word, see `find_bit`; raise a ValueError if it is unknown, in the other image, or a bit."""
    address = _find(text, image, rack, _words(image, rack))
    if address.bit is not None:
        raise ValueError(f"{text!r} is a bit; declare it as {KINDS[image].capitalize()}")
    return address


def _find(text: str, image: str, rack: Rack, candidates: Iterator[tuple[str, Address]]) -> Address:
    """Return the address for a text, which is a candidate's bare name or a place in the image."""
    if _BARE_NAME.fullmatch(text):
        return _by_name(text, image, list(candidates))
    address = parse_address(text, rack)
    if address.image != image:
        kind = KINDS[address.image]
        raise ValueError(f"{text!r} is an {kind}; declare it as {kind.capitalize()}")
    return address


def _bits(image: str, rack: Rack) -> Iterator[tuple[str, Address]]:
    """Yield the name and the address of each named bit of an image."""
    for slot, words in rack.items():
        for names in words.groups.values():
            yield from ((name, Address(slot, *bit)) for name, bit in names.items() if bit.image == image)


def _words(image: str, rack: Rack) -> Iterator[tuple[str, Address]]:
    """Yield the name and the address of each word of an image."""
    for slot, words in rack.items():
        names = words.inputs if image == "I" else words.outputs
        yield from ((name, Address(slot, image, word, None)) for word, name in enumerate(names))


def _by_name(text: str, image: str, candidates: list[tuple[str, Address]]) -> Address:
    """Return the one address with a name, in any case; raise a ValueError if there are none or several."""
    matches = [address for name, address in candidates if name.upper() == text.upper()]
    if len(matches) == 1:
        return matches[0]
    if matches:
        raise ValueError(f"{text!r} is in several slots; write one of {', '.join(map(str, matches))}")
    names = dict.fromkeys(name for name, _ in candidates)
    raise ValueError(f"no {KINDS[image]} {text!r}; {allowed(text, names)}")
