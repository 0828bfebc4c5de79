"""Finds the scans in which error bits of modules come on, for pages that stop there.

scan       4,008   4,009   4,010   4,011
bit        0       0       1       1        a page that follows the scans stops at 4,010
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.memory_layout import memory_layout
from scanrack.io_images.module_words import BitPlace, ModuleWords
from scanrack.runtime.live.ring import Row, Rows


class ErrorBit(NamedTuple):
    """A bit of an input image that reports an error."""

    slot: int
    name: str
    place: BitPlace

    @property
    def address(self) -> str:
        """Its address, such as `Local:1:I.Data[0].12`."""
        return f"Local:{self.slot}:I.Data[{self.place.word}].{self.place.bit}"


class ErrorWatch:
    """Finds error bits that come on; it must be called with all rows in order.

    Args:
        words: words of the modules, by slot, in the order of the rows.
    """

    def __init__(self, words: Mapping[int, ModuleWords]) -> None:
        self._bits = list(error_bits(words))
        self._last: Rows | None = None

    def clear(self) -> None:
        """Restart for another session."""
        self._last = None

    def is_on(self, row: Row, bit: ErrorBit) -> bool:
        """Return whether an error bit is on in a row."""
        (start, _module), _bit = next(entry for entry in self._bits if entry[1] == bit)
        return bool(int(row["words"][start + bit.place.word]) >> bit.place.bit & 1)

    def first(self, rows: Rows) -> tuple[int, ErrorBit] | None:
        """Return the index of the first row in which an error bit comes on, and the bit; None if none."""
        return min(self.all(rows), key=itemgetter(0), default=None)

    def all(self, rows: Rows) -> list[tuple[int, ErrorBit]]:
        """Return the index of each row in which an error bit comes on, and the bit."""
        if not len(rows):
            return []
        joined = rows if self._last is None else np.concatenate([self._last, rows])
        skipped = len(joined) - len(rows)
        self._last = rows[-1:].copy()
        return [
            (place - skipped, bit) for address, bit in self._bits for place in _rises(joined, address, bit)
        ]

    def bit(self, slot: int, name: str) -> ErrorBit | None:
        """Return the error bit with a name; None if there is none."""
        return next((bit for _, bit in self._bits if (bit.slot, bit.name) == (slot, name)), None)


def error_bits(words: Mapping[int, ModuleWords]) -> Iterator[tuple[tuple[int, ModuleWords], ErrorBit]]:
    """Yield the error bits, each with the place of its image in a row, and the words of its module."""
    places = memory_layout(words.items()).places
    for slot, names in words.items():
        for group in names.groups.values():
            for name in names.errors:
                if name in group:
                    start = int(places[slot].columns("I").start)
                    yield (start, names), ErrorBit(slot, name, group[name])


def _rises(rows: Rows, at: tuple[int, ModuleWords], bit: ErrorBit) -> list[int]:
    """Return the indices of the rows in which a bit comes on."""
    start, module = at
    images: Any = rows["words"]
    is_on = (images[:, start + bit.place.word] >> bit.place.bit & 1).astype(bool)
    if module.modes is not None and not module.live("I", bit.place.word) >> bit.place.bit & 1:
        is_on &= images[:, start + module.modes.input] >= 0  # the mirror of a configuration has no status
    rises: list[int] = (np.flatnonzero(is_on[1:] & ~is_on[:-1]) + 1).tolist()
    return rises
