"""Reads the names of a recorded module's words and bits from the trace, without a list of modules.

    schema of /scan            message type and word names of every slot
    metadata slot.N.names      bits with their own names: group -> name -> [image, word, bit]
    metadata slot.N.family     only for a relative of the 3601: error bits and limits
    metadata slot.N.numbers    only for another module with numbers: error bits, modes, quantities

A trace does not repeat the names of a 3601's bits, which are in its manual.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from scanrack.io_images.amci3601.words import WORDS_3601, family_facts, is_stepper, recorded_profile
from scanrack.io_images.doors import json_value
from scanrack.io_images.image import WORDS_MAX
from scanrack.io_images.module_words import BitPlace, Groups, Modes, ModuleWords, Quantity
from scanrack.io_images.number_formats import NumberFormat

SEPARATOR = 80 * "="
BITS = 16
STATUS = "status"
"""The group of the bits in input words 0 and 1 of the 3601 family."""


def names_key(slot: int) -> str:
    """Return the key of a slot's names in the metadata."""
    return f"slot.{slot}.names"


def family_key(slot: int) -> str:
    """Return the key of a slot's family in the metadata."""
    return f"slot.{slot}.family"


def numbers_key(slot: int) -> str:
    """Return the key of a slot's numbers in the metadata."""
    return f"slot.{slot}.numbers"


def names_text(words: ModuleWords) -> str:
    """Return the named bits of a module as text for the metadata.

    >>> names_text(ModuleWords("Card", ("data",), ("data",), {"input": {"start": BitPlace("I", 0, 3)}}))
    '{"input":{"start":["I",0,3]}}'
    """
    return json.dumps(words.groups, separators=(",", ":"))


def facts_of(slot: int, words: ModuleWords) -> dict[str, str]:
    """Return the metadata of a slot's words; empty for a 3601, whose words every reader has."""
    if words is WORDS_3601 or not words.groups:
        return {}
    facts = {names_key(slot): names_text(words)}
    if is_stepper(words):
        facts[family_key(slot)] = json.dumps(family_facts(words), separators=(",", ":"))
    elif words.quantities:
        facts[numbers_key(slot)] = _numbers_text(words)
    return facts


def split_schema(text: str) -> tuple[list[str], dict[str, list[str]]]:
    """Return the fields of a schema, and the lines of its messages by name."""
    head, *messages = text.split(f"{SEPARATOR}\n")
    message_lines = (message.splitlines() or [""] for message in messages)
    return head.splitlines(), {
        first_line.removeprefix("MSG: scanrack/"): lines for first_line, *lines in message_lines
    }


def recorded_words(schema: str, metadata: Mapping[str, str]) -> dict[int, ModuleWords]:
    """Return the words of the slots of a trace; slots without words in the schema are omitted.

    Raises:
        ValueError: bit names are illegal.
    """
    head, messages = split_schema(schema)
    fields = {name: tuple(line.partition(" ")[2] for line in lines) for name, lines in messages.items()}
    words: dict[int, ModuleWords] = {}
    for line in head[2:]:
        stem, _, slot_text = line.partition(" slot")
        outputs, inputs = fields.get(f"{stem}Out", ()), fields.get(f"{stem}In", ())
        if slot_text.isdecimal() and _are_words(outputs) and _are_words(inputs):
            slot = int(slot_text)
            words[slot] = _slot_words(stem, outputs, inputs, slot, metadata)
    return words


def _slot_words(
    stem: str, outputs: tuple[str, ...], inputs: tuple[str, ...], slot: int, metadata: Mapping[str, str]
) -> ModuleWords:
    """Return the words of a slot with a 3601, a related module, or any other module."""
    sizes = {"O": len(outputs), "I": len(inputs)}
    groups = _groups(metadata.get(names_key(slot), "{}"), sizes)
    if (stem, outputs, inputs) == (WORDS_3601.message, WORDS_3601.outputs, WORDS_3601.inputs):
        return WORDS_3601
    if family_key(slot) in metadata and STATUS in groups:
        return recorded_profile(stem, groups, json_value(metadata[family_key(slot)]))
    return ModuleWords(stem, outputs, inputs, groups, **_numbers(metadata.get(numbers_key(slot), "{}")))


def _numbers_text(words: ModuleWords) -> str:
    """Return the errors, modes and quantities of a module as text for the metadata, see `_numbers`."""
    quantities = [
        {**asdict(quantity), "format": quantity.format and quantity.format.value}
        for quantity in words.quantities
    ]
    modes = None if words.modes is None else asdict(words.modes)
    return json.dumps(
        {"errors": words.errors, "modes": modes, "quantities": quantities}, separators=(",", ":")
    )


def _numbers(text: str) -> dict[str, Any]:
    """Return a module's recorded errors, modes and quantities, as arguments of `ModuleWords`."""
    try:
        data = json_value(text)
        modes = data.get("modes")
        return {
            "errors": tuple(map(str, data.get("errors", ()))),
            "modes": None if modes is None else Modes(int(modes["live"]), int(modes["input"])),
            "quantities": tuple(map(_quantity, data.get("quantities", ()))),
        }
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"numbers of a module: {error!r}") from None


def _quantity(table: Mapping[str, Any]) -> Quantity:
    """Return a quantity from the metadata; `_numbers` handles its errors."""
    format = table["format"]
    return Quantity(
        name=str(table["name"]),
        image=str(table["image"]),
        word=int(table["word"]),
        words=int(table["words"]),
        unit=str(table["unit"]),
        format=format and NumberFormat(format),
        counts=bool(table["counts"]),
    )


def _are_words(names: Sequence[str]) -> bool:
    """Return whether names are legal for an image's words: unique identifiers, and not too many."""
    return 1 <= len(set(names)) == len(names) <= WORDS_MAX and all(name.isidentifier() for name in names)


def _groups(text: str, sizes: Mapping[str, int]) -> Groups:
    """Return the named bits from the metadata, by group; raise ValueError for a bit outside the images."""
    try:
        data = json_value(text)
        return {
            group: {name: _bit_place(name, place, sizes) for name, place in names.items()}
            for group, names in data.items()
        }
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"names of bits: {error}") from None


def _bit_place(name: str, place: Sequence[Any], sizes: Mapping[str, int]) -> BitPlace:
    """Check the location of a bit, and return its image, word and bit number.

    Args:
        sizes: number of words by image.
    """
    image, word, bit = place if len(place) == 3 else ("", -1, -1)
    has_types = image in ("I", "O") and type(word) is int and type(bit) is int
    if not (has_types and name.isidentifier() and 0 <= word < sizes[image] and 0 <= bit < BITS):
        raise ValueError(f"bit {name!r} at {place} is not in an image")
    return BitPlace(image, word, bit)
