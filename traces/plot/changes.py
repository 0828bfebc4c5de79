"""Finds the scans in which words with bits, or the values of a tag, changed: few, even in a long trace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import INPUT, BitPlace, ModuleWords

from ..signals import Block, Signal


@dataclass(frozen=True, slots=True)
class BitChanges:
    """Images of a slot in the first scan, and in each scan that changes a word with named bits."""

    row: NDArray[np.int64]  # the scan's place among the scans read, from 0
    time_ns: NDArray[np.int64]
    words: NDArray[np.int16]


@dataclass(frozen=True, slots=True)
class Steps:
    """The value of a signal in the first scan, and in each scan in which it changed."""

    row: NDArray[np.int64]  # the scan's place among the scans read, from 0
    time_ns: NDArray[np.int64]
    value: NDArray[Any]  # the values, of the signal's own type


class StepFinder:
    """Finds the changes of one signal, block by block."""

    def __init__(self, signal: Signal) -> None:
        self._signal = signal
        self._rows = 0
        self._found: list[Steps] = []

    def add(self, block: Block) -> None:
        """Add a block."""
        values = self._signal.read(block)
        new = np.ones(len(values), bool)
        new[1:] = values[1:] != values[:-1]
        if self._found:
            new[0] = values[0] != self._found[-1].value[-1]
        rows = np.flatnonzero(new)
        if len(rows):
            self._found.append(Steps(rows + self._rows, block.time_ns[rows], values[rows]))
        self._rows += len(values)

    def steps(self) -> Steps:
        """Return the changes; at least one block must have been added."""
        return Steps(
            np.concatenate([found.row for found in self._found]),
            np.concatenate([found.time_ns for found in self._found]),
            np.concatenate([found.value for found in self._found]),
        )


def _is_in(at: BitPlace, direction: str) -> bool:
    return (at.image in INPUT) == (direction in INPUT)


class ChangeFinder:
    """Finds the changes in one image of a slot, block by block.

    Args:
        words: names of the slot's words and bits; only words with named bits are watched.
    """

    def __init__(self, slot: int, direction: str, words: ModuleWords) -> None:
        self._slot, self._direction = slot, direction
        self._watched = 1 + max(
            (at.word for names in words.groups.values() for at in names.values() if _is_in(at, direction)),
            default=0,
        )
        self._rows = 0
        self._last: NDArray[np.int16] | None = None
        self._found: list[BitChanges] = []

    def add(self, block: Block) -> None:
        """Add a block."""
        words = block.image(self._slot, self._direction)
        watched = np.ascontiguousarray(words[:, : self._watched])
        differs = np.empty(len(watched), bool)
        differs[0] = self._last is None or not np.array_equal(watched[0], self._last)
        differs[1:] = (watched[1:] != watched[:-1]).any(axis=1)
        rows = np.flatnonzero(differs)
        if len(rows):
            self._found.append(BitChanges(rows + self._rows, block.time_ns[rows], words[rows]))
        self._rows += len(watched)
        self._last = watched[-1].copy()

    def changes(self) -> BitChanges:
        """Return the changes; at least one block must have been added."""
        return BitChanges(
            np.concatenate([found.row for found in self._found]),
            np.concatenate([found.time_ns for found in self._found]),
            np.concatenate([found.words for found in self._found]),
        )
