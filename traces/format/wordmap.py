"""The word-and-bit map attached to a trace, with the names of each word and bit."""

from __future__ import annotations

import json
from collections.abc import Iterable

from scanrack.io_images.amci3601.bits import ConfigMsw, InputBit
from scanrack.io_images.module_words import ModuleWords

from .layout import SlotInfo

_CONFIGURATION = (ConfigMsw, InputBit)
"""Bits of output words 0 and 1 in configuration mode [chapter 3]; word 1: active level."""


def word_map(slots: Iterable[SlotInfo]) -> str:
    """Return the map of all modules in these slots, as JSON text.

    >>> import json
    >>> table = json.loads(word_map([SlotInfo(1, "amci3601")]))
    >>> table["amci3601"]["in"][2], table["amci3601"]["bits"]["in, command mode"]["0"]["7"]
    ('position_msw', 'MOVE_COMPLETE')
    """
    modules = {slot.module: _slot_map(slot) for slot in slots}
    return json.dumps(modules, separators=(",", ":")) + "\n"


def _slot_map(slot: SlotInfo) -> dict[str, object]:
    """Return the names of a slot's words, and of its bits in each mode; bits are omitted without modes."""
    words = slot.words
    tables = {
        "out, command mode": _bits(words, "O"),
        "out, configuration mode": [
            {bit.value.bit_length() - 1: str(bit.name) for bit in bits} for bits in _CONFIGURATION
        ],
        "in, command mode": _bits(words, "I"),
    }
    if not slot.is_stepper:
        del tables["out, configuration mode"]
    bits = {name: dict(enumerate(table)) for name, table in tables.items()} if words.modes else {}
    return {"out": words.outputs, "in": words.inputs, "bits": bits}


def _bits(words: ModuleWords, image: str) -> list[dict[int, str]]:
    """Return the names of the bits in words 0 and 1."""
    return [{bit: name for name, bit in words.bits(image, word)} for word in (0, 1)]
