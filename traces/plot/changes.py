"""Finds the scans in which an image or the value of a signal changed: few, even in a long trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import INPUT, BitPlace, ModuleWords

from ..signals import Block

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Changes:
    """Values in the first scan, and in each scan in which they changed."""

    row: NDArray[np.int64]  # the scan's place among the scans read, from 0
    time_ns: NDArray[np.int64]
    values: Array  # of a signal, in its own type; of an image, the words, a row per scan


class ChangeFinder:
    """Finds the changes of a signal or an image, block by block.

    Args:
        read: returns the values in a block: one per scan, or a row of words per scan.
        watched: number of words that are compared, from the first one; None = all values.
    """

    def __init__(self, read: Callable[[Block], Array], watched: int | None = None) -> None:
        self._read, self._watched = read, watched
        self._rows = 0
        self._last: Array | None = None
        self._parts: list[Changes] = []

    def add(self, block: Block) -> None:
        """Add a block."""
        values = self._read(block)
        watched = values if self._watched is None else np.ascontiguousarray(values[:, : self._watched])
        is_different = watched[1:] != watched[:-1]
        is_new = np.ones(len(values), bool)
        is_new[0] = self._last is None or not np.array_equal(watched[0], self._last)
        is_new[1:] = is_different if is_different.ndim == 1 else is_different.any(axis=1)
        rows = np.flatnonzero(is_new)
        if len(rows):
            self._parts.append(Changes(rows + self._rows, block.time_ns[rows], values[rows]))
        self._rows += len(values)
        self._last = watched[-1].copy()

    def changes(self) -> Changes:
        """Return the changes; at least one block must have been added."""
        columns = zip(*((part.row, part.time_ns, part.values) for part in self._parts), strict=True)
        return Changes(*map(np.concatenate, columns))


def bit_changes(slot: int, direction: str, words: ModuleWords) -> ChangeFinder:
    """Return the finder of changes in an image, of words up to the last one with named bits."""
    named_places = [
        place for names in words.groups.values() for place in names.values() if _is_in(place, direction)
    ]
    watched = 1 + max((place.word for place in named_places), default=0)
    return ChangeFinder(partial(Block.image, slot=slot, direction=direction), watched)


def _is_in(at: BitPlace, direction: str) -> bool:
    return (at.image in INPUT) == (direction in INPUT)
