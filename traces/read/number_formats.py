"""The number formats in each scan, for modules whose configuration selects the format.

A module reports each change in an event of kind "format"; before the first event, its numbers are in
thousands.

    scan       n - 1          n
    outputs    new format     ...            the module reads the outputs of n - 1 at the beginning of n
    inputs     old format     new format
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import INPUT, ModuleWords, Quantity
from scanrack.io_images.number_formats import NumberFormat

if TYPE_CHECKING:  # a run does not read recordings
    from .reader import Trace

KIND = "format"
"""Kind of event that reports formats, in the fields `reads` and `writes`."""

_FORMATS = {number_format.value: number_format for number_format in NumberFormat}


class NumberFormats:
    """The formats of the numbers of each slot."""

    def __init__(self) -> None:
        # by slot, and whether the image is an input image: first scans in order, and the format from each on
        self._changes: dict[tuple[int, bool], tuple[list[int], list[NumberFormat]]] = {}

    @classmethod
    def of(cls, trace: Trace) -> NumberFormats:
        """Return the formats in a trace; read events only if a module's configuration selects a format."""
        formats = cls()
        if any(formats_vary(slot.words) for slot in trace.head.slots):
            for event in trace.events(topics={"/events"}):
                formats.note(event.scan, event.fields)
        return formats

    def note(self, scan: int, fields: Mapping[str, Any]) -> None:
        """Record the formats in an event; events of other kinds are ignored."""
        slot = fields.get("slot")
        if fields.get("kind") != KIND or not isinstance(slot, int):
            return
        for is_input, name, first_scan in ((True, "reads", scan), (False, "writes", scan - 1)):
            format = _FORMATS.get(str(fields.get(name)))
            if format is not None:
                scans, formats = self._changes.setdefault((slot, is_input), ([], []))
                index = bisect_left(scans, first_scan)
                end = index + (scans[index : index + 1] == [first_scan])  # replaces a change at the same scan
                scans[index:end] = [first_scan]
                formats[index:end] = [format]

    def changes(self) -> list[tuple[int, str, int, str]]:
        """Return all changes, each with its slot, "I" or "O", first scan, and format."""
        return [
            (slot, "I" if is_input else "O", scan, format.value)
            for (slot, is_input), changes in self._changes.items()
            for scan, format in zip(*changes, strict=True)
        ]

    def at(self, slot: int, quantity: Quantity, scan: int) -> NumberFormat:
        """Return the format of a quantity in a scan."""
        if quantity.format is not None:
            return quantity.format
        scans, formats = self._changes.get((slot, quantity.image in INPUT), ([], []))
        index = bisect_right(scans, scan)
        return formats[index - 1] if index else NumberFormat.THOUSANDS

    def value(self, slot: int, scan: int, quantity: Quantity, words: Sequence[int]) -> int:
        """Return a quantity from the signed words of its image in a scan."""
        first_word, *units = words[quantity.word : quantity.word + quantity.words]
        return self.at(slot, quantity, scan).reported(first_word, units[0]) if units else first_word

    def reader(self, slot: int, scan: int) -> Callable[[Quantity, Sequence[int]], int]:
        """Return a function like `value` for a slot in a scan."""
        return partial(self.value, slot, scan)

    def values(
        self, slot: int, quantity: Quantity, scans: NDArray[np.int64], words: NDArray[np.int16]
    ) -> NDArray[np.float64]:
        """Return the values of a two-word quantity in successive scans.

        Args:
            scans: numbers of the scans, ascending.
            words: the words of its image, one row per scan.
        """
        values = np.empty(len(words))
        first_words, second_words = words[:, quantity.word], words[:, quantity.word + 1]
        change_scans: list[int] = []
        if not quantity.format:
            change_scans, _ = self._changes.get((slot, quantity.image in INPUT), ([], []))
        edges = [0, *np.searchsorted(scans, change_scans).tolist(), len(scans)]
        for start, stop in pairwise(edges):
            if start < stop:
                format = self.at(slot, quantity, int(scans[start]))
                values[start:stop] = format.reported_all(first_words[start:stop], second_words[start:stop])
        return values


def formats_vary(words: ModuleWords) -> bool:
    """Return whether a module's configuration selects the format of its numbers."""
    return any(quantity.format is None for quantity in words.quantities)
