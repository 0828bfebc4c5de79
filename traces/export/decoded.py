"""Decoded values of steppers as another field of /scan: `/scan.decoded.slot1.speed`, `.inputs.position`.

A recording does not contain them, because they can be calculated from the words. Exported copies add them,
see `export.write_mcap`. Values are float64, NaN in configuration mode; bits are bool. A field's name is its
signal's name in lower case:

    Decoded0123456789ab decoded
    ====...
    MSG: scanrack/Decoded0123456789ab
    Decoded3601 slot1 ====...
    MSG: scanrack/Decoded3601
    float64 speed Decoded3601In inputs Decoded3601Out outputs ====...
    MSG: scanrack/Decoded3601In
    float64 position
    ...
    bool module_ok

Slots with the same module share a message, such as `Decoded3601` or `DecodedSmd23e2`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.amci3601.words import WORDS_3601

from ..format.cdr import leaves
from ..format.layout import SlotInfo, listed
from ..format.schema import IMAGE_FIELDS
from ..read.number_formats import NumberFormats
from ..signals import Block, Catalog, Signal, SignalKind

FIELD = "decoded"
"""Name of the field of /scan."""

_3601 = WORDS_3601.message
_HASH_DIGITS = 12
_IMAGE_FIELD_OF = dict(zip(("out", "in"), IMAGE_FIELDS, strict=True))
_ROS_TYPES = {SignalKind.BIT: "bool", SignalKind.VALUE: "float64", SignalKind.MEASURED: "float64"}

Message = tuple[str, list[str]]
"""Name and lines of a message."""


class DecodedColumn(NamedTuple):
    """A decoded signal, and its field in `DecodedValues.dtype`."""

    signal: Signal
    field: str


class DecodedValues:
    """The decoded values of a trace's steppers, and their layout.

    Args:
        offset: number of payload bytes between the CDR prefix and the decoded values.
        formats: number formats of modules whose configuration selects them.

    Attributes:
        messages: the messages of the schema; the first one is the type of the field `decoded`.
        dtype: layout of a row, including the alignment bytes before the first value.

    Raises:
        ValueError: no slot has a stepper's words.
    """

    def __init__(self, slots: Sequence[SlotInfo], offset: int, formats: NumberFormats | None = None) -> None:
        steppers = [slot for slot in slots if slot.words.is_axis]
        if not steppers:
            raise ValueError(f"no 3601 or drive in the trace to decode ({listed(slots)})")
        catalog = Catalog(steppers, formats=formats)
        signals = [signal for signal in catalog.values() if signal.kind in _ROS_TYPES]
        self.messages = _messages(steppers, signals)
        _, lines = self.messages[0]
        placed_leaves = list(leaves(lines, dict(self.messages), offset))
        by_path = {_path(signal): signal for signal in signals}
        self._columns = [DecodedColumn(by_path[leaf.path], ".".join(leaf.path)) for leaf in placed_leaves]
        self.dtype: np.dtype[np.void] = np.dtype(
            {
                "names": [column.field for column in self._columns],
                "formats": [f"<{leaf.letter}" for leaf in placed_leaves],
                "offsets": [leaf.offset - offset for leaf in placed_leaves],
                "itemsize": placed_leaves[-1].end - offset,
            }
        )

    def rows(self, block: Block) -> NDArray[Any]:
        """Return the decoded values of a block, one row per scan."""
        rows = np.zeros(len(block), self.dtype)
        for column in self._columns:
            rows[column.field] = column.signal.read(block)
        return rows


def _path(signal: Signal) -> tuple[str, ...]:
    return tuple(_IMAGE_FIELD_OF.get(step, step.lower()) for step in signal.path)


def _messages(slots: Sequence[SlotInfo], signals: Sequence[Signal]) -> list[Message]:
    """Return the messages; slots with the same fields share a message."""
    messages_by_stem: dict[str, list[Message]] = {}
    slot_lines = []
    for slot in slots:
        stem = "Decoded3601" if slot.words.message == _3601 else f"Decoded{slot.words.message}"
        slot_messages = _slot_messages(stem, slot.number, signals)
        # True for the same module whose bits have other names
        if messages_by_stem.setdefault(stem, slot_messages) != slot_messages:
            stem = f"{stem}Slot{slot.number}"
            messages_by_stem[stem] = _slot_messages(stem, slot.number, signals)
        slot_lines.append(f"{stem} slot{slot.number}")
    messages = [message for messages_of_stem in messages_by_stem.values() for message in messages_of_stem]
    text = "\n".join([*slot_lines, *(line for _, lines in messages for line in lines)])
    name = f"Decoded{hashlib.sha256(text.encode()).hexdigest()[:_HASH_DIGITS]}"
    return [(name, slot_lines), *messages]


def _slot_messages(stem: str, number: int, signals: Sequence[Signal]) -> list[Message]:
    """Return the messages of a slot, from its signals."""
    outputs, inputs = IMAGE_FIELDS
    fields: dict[str, list[str]] = {"": [], outputs: [], inputs: []}
    # float64 before bool, so that no alignment bytes are between them
    for signal in sorted(signals, key=lambda signal: signal.kind is SignalKind.BIT):
        slot, *images, name = _path(signal)
        if slot == f"slot{number}":
            fields[images[0] if images else ""].append(f"{_ROS_TYPES[signal.kind]} {name}")
    return [
        (stem, [*fields[""], f"{stem}In {inputs}", f"{stem}Out {outputs}"]),
        (f"{stem}In", fields[inputs]),
        (f"{stem}Out", fields[outputs]),
    ]
