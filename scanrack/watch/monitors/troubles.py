"""The scans in which error bits of modules come on.

scan       4,008   4,009   4,010   4,011
bit        0       0       1       1        the bit comes on in scan 4,010; a page may stop there
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
        """The address of the bit, such as `Local:1:I.Data[0].12`."""
        return f"Local:{self.slot}:I.Data[{self.place.word}].{self.place.bit}"


class ErrorWatch:
    """A search for error bits that come on. It must receive all rows in order.

    Args:
        words: words of the modules, by slot, in the order of the rows.
    """

    def __init__(self, words: Mapping[int, ModuleWords]) -> None:
        self._bits = list(error_bits(words))
        self._last: Rows | None = None

    def clear(self) -> None:
        """Start over, since another session begins."""
        self._last = None

    def is_on(self, row: Row, bit: ErrorBit) -> bool:
        """Return whether an error bit is on in a row."""
        (start, _module), _bit = next(entry for entry in self._bits if entry[1] == bit)
        return bool(int(row["words"][start + bit.place.word]) >> bit.place.bit & 1)

    def first(self, rows: Rows) -> tuple[int, ErrorBit] | None:
        """Return the index of the first row in which an error bit comes on, and the bit, or None."""
        return min(self.all(rows), key=itemgetter(0), default=None)

    def all(self, rows: Rows) -> list[tuple[int, ErrorBit]]:
        """Return the index of each row in which an error bit comes on, and the bit."""
        if not len(rows):
            return []
        joined = rows if self._last is None else np.concatenate([self._last, rows])
        skipped = len(joined) - len(rows)
        self._last = rows[-1:].copy()
        return [(index - skipped, bit) for image, bit in self._bits for index in _rises(joined, image, bit)]

    def bit(self, slot: int, name: str) -> ErrorBit | None:
        """Return a slot's error bit with a given name, or None."""
        return next((bit for _, bit in self._bits if (bit.slot, bit.name) == (slot, name)), None)


def error_bits(words: Mapping[int, ModuleWords]) -> Iterator[tuple[tuple[int, ModuleWords], ErrorBit]]:
    """Yield the error bits, each with the first column of its image in a row, and the words of its module."""
    images = memory_layout(words.items()).places
    for slot, module in words.items():
        start = int(images[slot].columns("I").start)
        for group in module.groups.values():
            for name in module.errors:
                if name in group:
                    yield (start, module), ErrorBit(slot, name, group[name])


def _rises(rows: Rows, image: tuple[int, ModuleWords], bit: ErrorBit) -> list[int]:
    """Return the indexes of the rows in which a bit comes on; for `image` see `error_bits`."""
    start, module = image
    images: Any = rows["words"]
    is_on = (images[:, start + bit.place.word] >> bit.place.bit & 1).astype(bool)
    if module.modes is not None and not module.live("I", bit.place.word) >> bit.place.bit & 1:
        is_on &= images[:, start + module.modes.input] >= 0  # no status bits in configuration mode
    rises: list[int] = (np.flatnonzero(is_on[1:] & ~is_on[:-1]) + 1).tolist()
    return rises
