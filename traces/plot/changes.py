"""Finds the scans in which an image or a signal's value changes, which are few even in a long trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import INPUT, ModuleWords

from ..signals import Block

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Changes:
    """Values in the first scan, and in each scan in which they change."""

    row: NDArray[np.int64]  # index of the scan among the scans read, from 0
    time_ns: NDArray[np.int64]
    values: Array  # of a signal, in its own type; of an image, the words, a row per scan


class ChangeFinder:
    """Finds the changes in a signal or an image, block by block.

    Args:
        read: returns the values in a block, either one per scan or a row of words per scan.
        word_count: number of words to compare, starting with the first; None = all values.
    """

    def __init__(self, read: Callable[[Block], Array], word_count: int | None = None) -> None:
        self._read, self._word_count = read, word_count
        self._rows = 0  # number of scans added
        self._last: Array | None = None  # compared values of the last scan added
        self._parts: list[Changes] = []

    def add(self, block: Block) -> None:
        """Add a block."""
        values = self._read(block)
        compared = values if self._word_count is None else np.ascontiguousarray(values[:, : self._word_count])
        is_different = compared[1:] != compared[:-1]
        is_new = np.ones(len(values), bool)
        is_new[0] = self._last is None or not np.array_equal(compared[0], self._last)
        is_new[1:] = is_different if is_different.ndim == 1 else is_different.any(axis=1)
        rows = np.flatnonzero(is_new)
        if len(rows):
            self._parts.append(Changes(rows + self._rows, block.time_ns[rows], values[rows]))
        self._rows += len(values)
        self._last = compared[-1].copy()

    def changes(self) -> Changes:
        """Return the changes; at least one block must have been added."""
        columns = zip(*((part.row, part.time_ns, part.values) for part in self._parts), strict=True)
        return Changes(*map(np.concatenate, columns))


def bit_changes(slot: int, direction: str, words: ModuleWords) -> ChangeFinder:
    """Return a finder of changes in an image, which compares the words up to the last with named bits."""
    last_word = 0
    for names in words.groups.values():
        for place in names.values():
            if (place.image in INPUT) == (direction in INPUT):
                last_word = max(last_word, place.word)
    return ChangeFinder(partial(Block.image, slot=slot, direction=direction), last_word + 1)
