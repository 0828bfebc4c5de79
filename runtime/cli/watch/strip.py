"""The timing strip of rows: bits by their edges, positions as an envelope.

    rows      0 0 0 1 0 0 0 0 1 1 1        edges  (t3, 1) (t4, 0) (t8, 1)

So a pulse of one scan is seen, however many scans there are in a frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....io_images.image import IMAGE_BYTES
from ....io_images.module_words import ModuleWords
from ...live.ring import Rows

MOST_EDGES = 400
"""Edges of one signal in one frame; of more, the last ones are shown."""

WORDS_PER_IMAGE = IMAGE_BYTES // 2

STATUS_TO_POSITION = 2
"""Words from a 3601's status to its position [chapter 6, Input Data]."""

CONFIGURES = np.uint16(0x8000)
"""In the first word of an image: all its words are of a configuration [chapter 3, Configuration Mode]."""

Edge = list[int]
"""Virtual time, ns, and the value from then on."""


@dataclass(frozen=True, slots=True)
class Signals:
    """The bits of a rack that have names, by word of its memory.

    Attributes:
        bits: word of the memory -> bit of the word -> name, such as `1.MOVE_COMPLETE`.
        positions: name -> words of the memory with thousands and the rest.
        modes: words of an image of a stepper -> the first of them, whose sign says that they configure.
    """

    bits: Mapping[int, Mapping[int, str]]
    positions: Mapping[str, tuple[int, int]]
    modes: Mapping[int, int]


def signals_of(slots: Mapping[int, ModuleWords], steppers: Sequence[int]) -> Signals:
    """Return the signals of a rack.

    Args:
        slots: the words of its modules, in the order of its memory.
        steppers: the slots that answer as a 3601.
    """
    bits: dict[int, dict[int, str]] = {}
    for place, (slot, words) in enumerate(slots.items()):
        named = [(name, at) for names in words.groups.values() for name, at in names.items()]
        inputs = {name for name, at in named if at.image == "I"}
        for name, at in named:
            if at.image == "I" or name not in inputs:  # MODE_CONFIG is in both: the status is shown
                word = (2 * place + (at.image == "I")) * WORDS_PER_IMAGE + at.word
                bits.setdefault(word, {})[at.bit] = f"{slot}.{name}"
    order = list(slots)
    positions = {}
    modes: dict[int, int] = {}
    for slot in steppers:
        outputs = 2 * order.index(slot) * WORDS_PER_IMAGE
        first = outputs + WORDS_PER_IMAGE
        positions[f"{slot}.position"] = first + 2, first + 3
        for image in (outputs, first):
            modes |= dict.fromkeys(range(image, image + WORDS_PER_IMAGE), image)
    return Signals(bits, positions, modes)


def edges(rows: Rows, before: Rows, signals: Signals) -> dict[str, list[Edge]]:
    """Return the edges of all bits.

    Args:
        rows: the rows of a frame, in order.
        before: the row before them, or none: the first row then begins every signal.
        signals: the bits.
    """
    if not len(rows):
        return {}
    times = rows["now_ns"]
    found: dict[str, list[Edge]] = {}
    for word, names in signals.bits.items():
        column = _column(rows, word, signals)
        if len(before):
            previous = np.concatenate([_column(before[-1:], word, signals), column[:-1]])
        else:
            previous = np.concatenate([~column[:1], column[:-1]])
        changed = column ^ previous
        places = np.flatnonzero(changed)
        if not len(places):
            continue
        for bit, name in names.items():
            own = places[(changed[places] >> bit & 1).astype(bool)][-MOST_EDGES:]
            if len(own):
                levels = (column[own] >> bit & 1).tolist()
                found[name] = [[t, level] for t, level in zip(times[own].tolist(), levels, strict=True)]
    return found


def _column(rows: Rows, word: int, signals: Signals) -> np.ndarray[Any, np.dtype[np.uint16]]:
    """Return a word of each row, without the bits that have another meaning in configuration mode."""
    words = rows["words"].view(np.uint16)
    column = words[:, word]
    mode = signals.modes.get(word)
    if mode is None:
        return column
    kept = CONFIGURES if word == mode else np.uint16(0)
    return np.where(words[:, mode] & CONFIGURES, column & kept, column)


def envelopes(rows: Rows, signals: Signals, most: int = 1) -> dict[str, list[list[int]]]:
    """Return the positions, steps, in up to `most` stretches of rows.

    Returns:
        Per stretch the time of its first row, ns, and the least, the greatest and the last value.
    """
    found = {}
    for name, (thousands, rest) in signals.positions.items():
        status = rows["words"][:, thousands - STATUS_TO_POSITION]
        told = rows[status >= 0]  # in configuration mode, bit 15, these words are a mirror
        if len(told):
            found[name] = _envelope(told, thousands, rest, most)
    return found


def _envelope(rows: Rows, thousands: int, rest: int, most: int) -> list[list[int]]:
    words = rows["words"].astype(np.int64)
    values = words[:, thousands] * 1000 + words[:, rest]
    starts = np.unique(np.linspace(0, len(rows), min(most, len(rows)), endpoint=False).astype(np.int64))
    ends = [*starts[1:].tolist(), len(rows)]
    times = rows["now_ns"][starts].tolist()
    least = np.minimum.reduceat(values, starts).tolist()
    greatest = np.maximum.reduceat(values, starts).tolist()
    last = [int(values[end - 1]) for end in ends]
    return [list(point) for point in zip(times, least, greatest, last, strict=True)]
