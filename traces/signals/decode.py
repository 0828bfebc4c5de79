"""Decodes words of a module with two modes to bits and speeds, for whole columns at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import ModuleWords

Words = NDArray[np.int16]
"""One image of one slot, with a column per word and a row per scan."""

CW, CCW = "MOVING_CW", "MOVING_CCW"
"""Status bits of an axis."""


def in_command_mode(words: Words, status: int = 0) -> NDArray[np.bool_]:
    """Return the scans in which an image is in command mode: bit 15 of its word `status` is clear."""
    in_command: NDArray[np.bool_] = words[:, status] >= 0
    return in_command


def bit(column: NDArray[Any], mask: int) -> NDArray[np.bool_]:
    """Return the scans in which a bit of a word is set; `mask` is 1 to 8000h."""
    is_on: NDArray[np.bool_] = (column.view(np.uint16) & np.uint16(mask)) != 0
    return is_on


def module_bit(words: Words, module: ModuleWords, image: str, word: int, mask: int) -> NDArray[np.bool_]:
    """Return the scans in which a named bit is set.

    In configuration mode most bits mirror the configuration; none of these counts as set.

    Args:
        image: "I" or "in", "O" or "out".
        mask: mask of the bit in the word.
    """
    is_set = bit(np.ascontiguousarray(words[:, word]), mask)
    if module.modes is None or mask & module.live(image, word):
        return is_set
    return is_set & in_command_mode(words, module.modes.word(image))


def input_bit(words: Words, module: ModuleWords, name: str) -> NDArray[np.bool_]:
    """Return the scans in which a named bit of the input image is set; none for an unknown name."""
    place = module.place(name)
    if place is None:
        return np.zeros(len(words), bool)
    return module_bit(words, module, "I", place.word, 1 << place.bit)


def travel(words: Words, module: ModuleWords, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the motion of the position since the previous scan, steps.

    A preset, the end of homing or a configuration sets the position without a step; therefore changes
    while neither MOVING bit is set, or against its direction, count as 0.

    Args:
        words: an input image's words, a row per scan.
        positions: its position, NaN where it has none.
    """
    steps = np.zeros(len(words))
    steps_moved = np.diff(positions)
    onward = np.where(input_bit(words, module, CW)[1:], steps_moved, 0)
    moved_back = np.where(input_bit(words, module, CCW)[1:], steps_moved, 0)
    steps[1:] = np.fmax(onward, 0) + np.fmin(moved_back, 0)
    return steps


def speed(steps: NDArray[np.float64], time_ns: NDArray[np.int64], margin: int) -> NDArray[np.float64]:
    """Return the mean speed from `margin` scans before to `margin` scans after each one, steps/s, signed.

    Args:
        steps: the motion since the previous scan, see `travel`.
        margin: number of scans on either side, 1 or more; fewer are used at the ends.
    """
    distance = np.cumsum(steps)
    rows = np.arange(len(steps))
    late_rows, early_rows = np.minimum(rows + margin, len(rows) - 1), np.maximum(rows - margin, 0)
    elapsed = (time_ns[late_rows] - time_ns[early_rows]) / 1e9
    return np.divide(
        distance[late_rows] - distance[early_rows], elapsed, out=np.zeros(len(rows)), where=elapsed > 0
    )
