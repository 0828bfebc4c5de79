"""The word-and-bit map that travels with a trace: the names of each word and bit."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from enum import IntFlag

from ...io_images.amci3601.bits import CommandLsw, CommandMsw, ConfigMsw, InputBit, StatusLsw, StatusMsw
from .layout import SlotInfo

Bits = Mapping[int, type[IntFlag]]

# of a 3601: words with bits, per table of the manual
_BITS_3601: Mapping[str, Bits] = {
    "out, command mode": {0: CommandMsw, 1: CommandLsw},  # chapter 5
    "out, configuration mode": {0: ConfigMsw, 1: InputBit},  # chapter 3; word 1: active level
    "in, command mode": {0: StatusMsw, 1: StatusLsw},  # chapter 6
}


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
    words, tables = slot.words, _BITS_3601 if slot.is_stepper else {}
    bits = {name: {word: _bit_names(bits) for word, bits in table.items()} for name, table in tables.items()}
    return {"out": words.outputs, "in": words.inputs, "bits": bits}


def _bit_names(bits: type[IntFlag]) -> dict[int, str]:
    return {bit.value.bit_length() - 1: str(bit.name) for bit in bits}
