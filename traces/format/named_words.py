"""Reads the names of a recorded module's words and bits from the trace, without a list of modules.

    schema of /scan            message type and word names of every slot
    metadata slot.N.names      bits with their own names: group -> name -> [image, word, bit]
    metadata slot.N.family     of another module of the 3601's family: error bits and limits
    metadata slot.N.numbers    of any other module with numbers: error bits, modes, and its numbers

The names of a 3601's bits are in its manual, and are not repeated in a trace.
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
"""The group of the family's bits of input words 0 and 1."""


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
    """Return the metadata of a slot's words; none for a 3601, whose words are known."""
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
    """Return the words of the slots of a trace; slots without words in the schema are left out.

    Raises:
        ValueError: names of bits are illegal.
    """
    head, messages = split_schema(schema)
    fields = {name: tuple(line.partition(" ")[2] for line in lines) for name, lines in messages.items()}
    words: dict[int, ModuleWords] = {}
    for line in head[2:]:
        stem, _, slot = line.partition(" slot")
        outputs, inputs = fields.get(f"{stem}Out", ()), fields.get(f"{stem}In", ())
        if not (slot.isdecimal() and _are_words(outputs) and _are_words(inputs)):
            continue
        sizes = {"O": len(outputs), "I": len(inputs)}
        groups = _groups(metadata.get(names_key(int(slot)), "{}"), sizes)
        if (stem, outputs, inputs) == (WORDS_3601.message, WORDS_3601.outputs, WORDS_3601.inputs):
            words[int(slot)] = WORDS_3601
        elif family_key(int(slot)) in metadata and STATUS in groups:
            words[int(slot)] = recorded_profile(stem, groups, json_value(metadata[family_key(int(slot))]))
        else:
            numbers = _numbers(metadata.get(numbers_key(int(slot)), "{}"))
            words[int(slot)] = ModuleWords(stem, outputs, inputs, groups, **numbers)
    return words


def _numbers_text(words: ModuleWords) -> str:
    quantities = [
        {**asdict(quantity), "format": quantity.format and quantity.format.value}
        for quantity in words.quantities
    ]
    modes = None if words.modes is None else asdict(words.modes)
    return json.dumps(
        {"errors": words.errors, "modes": modes, "quantities": quantities}, separators=(",", ":")
    )


def _numbers(text: str) -> dict[str, Any]:
    """Return the errors, modes and quantities of a module that are recorded."""
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
    format = table["format"]
    places = str(table["image"]), int(table["word"]), int(table["words"]), str(table["unit"])
    return Quantity(
        str(table["name"]), *places, format and NumberFormat(format), counts=bool(table["counts"])
    )


def _are_words(names: Sequence[str]) -> bool:
    return 1 <= len(set(names)) == len(names) <= WORDS_MAX and all(name.isidentifier() for name in names)


def _groups(text: str, sizes: Mapping[str, int]) -> Groups:
    try:
        data = json_value(text)
        return {
            group: {name: _place(name, place, sizes) for name, place in names.items()}
            for group, names in data.items()
        }
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"names of bits: {error}") from None


def _place(name: str, at: Sequence[object], sizes: Mapping[str, int]) -> BitPlace:
    image, word, bit = at if len(at) == 3 else (None, None, None)
    sound = image in ("I", "O") and type(word) is int and type(bit) is int and name.isidentifier()
    if not (sound and 0 <= word < sizes[str(image)] and 0 <= bit < BITS):  # type: ignore[operator]
        raise ValueError(f"bit {name!r} at {at} is none of an image")
    return BitPlace(str(image), int(str(word)), int(str(bit)))
