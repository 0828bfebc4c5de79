"""Recorded tags as signals: `tags.fill_acc`, element `tags.counts.3`, code bit `tags.step.FILL`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from ..format.tagplan import FIELD, FORMATS, TagField, TagPlan
from .signal import Array, Signal, SignalKind
from .stream import Block

CODES = ("ENUM", "TEXT")
"""Types whose values are codes for names."""


def tag_signals(plan: TagPlan, texts: Mapping[int, str]) -> Iterator[Signal]:
    """Yield a signal for every tag, and for every element of an array.

    Args:
        texts: text by code, for tags of type TEXT.
    """
    for field in plan.fields:
        names = code_names(field, texts)
        for index, title in enumerate(field.tag.addresses):
            element = index if field.tag.length else None
            name = f"{FIELD}.{field.name}" if element is None else f"{FIELD}.{field.name}.{element}"
            read_values = partial(_values, field.name, element)
            signed = FORMATS[field.tag.type].letter.islower()
            yield Signal(name, _kind(field), read_values, names, _bits(field), title, signed)


def code_names(field: TagField, texts: Mapping[int, str]) -> Mapping[int, str]:
    """Return the name or text of each of a field's codes."""
    if field.tag.type == "TEXT":
        return texts
    return dict(enumerate(field.constants))


def constant(signal: Signal, name: str) -> Signal | None:
    """Return a signal that is true in scans with the code of a name; None if no code has this name."""
    codes = [code for code, code_name in signal.names.items() if code_name == name]
    if signal.kind is not SignalKind.CODE or not codes:
        return None
    return Signal(f"{signal.name}.{name}", SignalKind.BIT, partial(_is_code, signal, codes[0]))


def _kind(field: TagField) -> SignalKind:
    if field.tag.type == "BOOL":
        return SignalKind.BIT
    return SignalKind.CODE if field.tag.type in CODES else SignalKind.NUMBER


def _bits(field: TagField) -> int:
    tag_format = FORMATS[field.tag.type]
    return 0 if tag_format.letter in "df?" else 8 * tag_format.size


def _values(name: str, element: int | None, block: Block) -> Array:
    column: Array = block.tags[name]
    return np.ascontiguousarray(column if element is None else column[:, element])


def _is_code(signal: Signal, code: int, block: Block) -> Array:
    is_code: Array = signal.read(block) == code
    return is_code
