"""The scans in which the words that hold bits changed: few, however long the trace."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..signals import Block

BIT_WORDS = 2
"""Words with bits stand first in an image of a 3601, in either direction."""


@dataclass(frozen=True, slots=True)
class Changes:
    """An image in the first scan, and in every scan in which a word with bits changed.

    Attributes:
        row: the scan's place in what was read, from 0.
        time_ns: its virtual time.
        words: the image's eight words.
    """

    row: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    words: NDArray[np.int16]


class ChangeFinder:
    """Finds the changes in one image of a slot, block by block.

    Args:
        slot: number of the slot.
        direction: "in" or "out".
        words: how many words to watch, from the first one.
    """

    def __init__(self, slot: int, direction: str, words: int = BIT_WORDS) -> None:
        self._slot, self._direction, self._watched = slot, direction, words
        self._rows = 0
        self._last: NDArray[np.int16] | None = None
        self._found: list[Changes] = []

    def add(self, block: Block) -> None:
        """Take a block."""
        words = block.image(self._slot, self._direction)
        watched = np.ascontiguousarray(words[:, : self._watched])
        differs = np.empty(len(watched), bool)
        differs[0] = self._last is None or not np.array_equal(watched[0], self._last)
        differs[1:] = (watched[1:] != watched[:-1]).any(axis=1)
        rows = np.flatnonzero(differs)
        if len(rows):
            self._found.append(Changes(rows + self._rows, block.time_ns[rows], words[rows]))
        self._rows += len(watched)
        self._last = watched[-1].copy()

    def changes(self) -> Changes:
        """Return what has been found; at least one block must have been taken."""
        return Changes(
            np.concatenate([found.row for found in self._found]),
            np.concatenate([found.time_ns for found in self._found]),
            np.concatenate([found.words for found in self._found]),
        )
