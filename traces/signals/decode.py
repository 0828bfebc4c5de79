"""Decodes words of a module with two modes into bits and speeds, a whole column at a time."""

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
    """Return True for scans in which an image is in command mode: bit 15 of its word `status` is clear."""
    is_in_command_mode: NDArray[np.bool_] = words[:, status] >= 0
    return is_in_command_mode


def bit(column: NDArray[Any], mask: int) -> NDArray[np.bool_]:
    """Return True for scans in which a bit of a word is set; `mask` is 1 to 8000h."""
    is_on: NDArray[np.bool_] = (column.view(np.uint16) & np.uint16(mask)) != 0
    return is_on


def module_bit(words: Words, module: ModuleWords, image: str, word: int, mask: int) -> NDArray[np.bool_]:
    """Return True for scans in which a named bit is set.

    In configuration mode, most bits mirror the configuration, so they are treated as clear.

    Args:
        image: "I" or "in", "O" or "out".
        mask: mask of the bit in the word.
    """
    is_set = bit(np.ascontiguousarray(words[:, word]), mask)
    if module.modes is None or mask & module.live(image, word):
        return is_set
    return is_set & in_command_mode(words, module.modes.word(image))


def input_bit(words: Words, module: ModuleWords, name: str) -> NDArray[np.bool_]:
    """Return True for scans in which a named bit of the input image is set; False for an unknown name."""
    place = module.place(name)
    if place is None:
        return np.zeros(len(words), bool)
    return module_bit(words, module, "I", place.word, 1 << place.bit)


def travel(words: Words, module: ModuleWords, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the motion of the position since the previous scan, steps.

    A preset, the end of homing or a configuration changes the position without motion. A change is therefore
    counted only while the MOVING bit of its direction is set.

    Args:
        words: an input image's words, a row per scan.
        positions: the axis's position, NaN in configuration mode.
    """
    motion = np.zeros(len(words))
    change = np.diff(positions)
    cw_change = np.where(input_bit(words, module, CW)[1:], change, 0)
    ccw_change = np.where(input_bit(words, module, CCW)[1:], change, 0)
    motion[1:] = np.fmax(cw_change, 0) + np.fmin(ccw_change, 0)
    return motion


def speed(steps: NDArray[np.float64], time_ns: NDArray[np.int64], margin: int) -> NDArray[np.float64]:
    """Return the signed mean speed from `margin` scans before to `margin` after each scan, steps/s.

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
