"""Finds the last change of a value in a long past by running stretches from many snapshots in parallel.

    lane 0    snapshot 0     scan   0   1   2  ...  63
    lane 1    snapshot 64    scan  64  65  66  ... 127        one scan of all lanes at a time, on arrays
    lane 2    snapshot 128   scan 128 129 130  ... 191

A lane's result counts only if it ends with exactly the values of the next snapshot. Other stretches run one
by one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...model.collector import collector_paused
from ...model.tags import Leaf
from ...state.lowered import LoweredProgram
from ...state.memory import Memory
from ..cells import Cell, place_in_snapshot
from ..stretch import PlainInputs, ReplayStretch
from .translation import code_of
from .vectors import Vectors

_EXACT = 2**53
"""Whole numbers from this size up are not always exact in an array of floats."""


class LastChange(NamedTuple):
    """The result of a search in one stretch."""

    known: bool  # if False, its scans must run one at a time
    scan: int | None = None  # the last scan that changed a value


UNKNOWN = LastChange(known=False)


class Lanes:
    """Runs stretches of a program in parallel.

    Args:
        memory: the program's memory.
        images: the input images, in the order of `ScanInputs.images`.
    """

    def __init__(self, lowered: LoweredProgram, memory: Memory, images: Sequence[Leaf]) -> None:
        self._lowered, self._memory = lowered, memory
        self._images = [leaf.ident for leaf in images]

    def last_changes(self, cells: Sequence[Cell], stretches: Sequence[ReplayStretch]) -> list[LastChange]:
        """Return the last scan in each stretch that changed any of the cells."""
        changes = [UNKNOWN] * len(stretches)
        plain = [place for place, stretch in enumerate(stretches) if stretch.inputs is not None]
        places = [place_in_snapshot(self._memory, cell) for cell in cells]
        watched = [
            (*place, cell.mask)
            for place, cell in zip(places, cells, strict=True)
            if place is not None and place[0] in self._loaded
        ]
        if not plain or len(watched) < len(cells) or self._code is None:
            return changes
        chosen = [stretches[place] for place in plain]
        for number, change in zip(plain, self._run(watched, chosen), strict=True):
            changes[number] = change
        return changes

    @cached_property
    def _loaded(self) -> frozenset[str]:
        """Identifiers of the variables that arrays can hold: numbers, lists of them, and views."""
        cells = self._memory.cells.items()
        return frozenset(ident for ident, cell in cells if _is_numeric(cell.cell_contents))

    @cached_property
    def _code(self) -> Any:
        """The program as code on arrays; None if it can't run on them."""
        return code_of(self._lowered, self._loaded)

    def _run(self, watched: Sequence[_Watched], stretches: Sequence[ReplayStretch]) -> list[LastChange]:
        """Run stretches in parallel; return their last changes, UNKNOWN where a lane was lost."""
        try:
            with collector_paused():
                begin, end = self._columns(stretches)
                vectors = Vectors(self._code, begin, len(stretches))
                last = self._ran(vectors, watched, stretches)
                lost = vectors.lost | ~_are_as(vectors, end)
        except (ArithmeticError, LookupError, TypeError, ValueError):
            return [UNKNOWN] * len(stretches)  # a line's values are not what its translation expects
        return [
            UNKNOWN if is_lost else LastChange(True, None if offset < 0 else stretch.first + offset)
            for stretch, offset, is_lost in zip(stretches, last.tolist(), lost.tolist(), strict=True)
        ]

    def _columns(self, stretches: Sequence[ReplayStretch]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the values before and after stretches, with an array per variable or list element.

        The snapshot after a stretch is usually the snapshot before the next one.
        """
        pairs = [(stretch.values, stretch.after) for stretch in stretches]
        snapshots = {id(item): item for pair in pairs for item in pair}
        numbers = {key: number for number, key in enumerate(snapshots)}
        chosen = np.array([[numbers[id(item)] for item in pair] for pair in pairs]).T
        begin: dict[str, Any] = {}
        end: dict[str, Any] = {}
        for ident in self._loaded:
            column = _column([values[ident] for values in snapshots.values()])
            begin[ident], end[ident] = (_at(column, places) for places in chosen)
        return begin, {ident: value for ident, value in end.items() if ident not in self._images}

    def _ran(self, vectors: Vectors, watched: Sequence[_Watched], stretches: Sequence[ReplayStretch]) -> Any:
        """Run all scans; return the number of each lane's last scan with a change, or -1."""
        lanes = len(stretches)
        lengths = np.array([stretch.last + 1 - stretch.first for stretch in stretches])
        times, images = _padded(
            [stretch.inputs for stretch in stretches if stretch.inputs is not None], int(lengths.max())
        )
        last = np.full(lanes, -1)
        before: list[Any] = [None] * len(watched)
        for number in range(-1, int(lengths.max())):
            if number >= 0:
                for ident, words in zip(self._images, images, strict=True):
                    vectors.values[ident] = _words(words[number])
                vectors.scan(None if number < lengths.min() else number < lengths, times[number])
            for place, cell in enumerate(watched):
                value = _value(vectors, *cell)
                if number >= 0 and value is not before[place]:
                    last[np.broadcast_to(value != before[place], (lanes,))] = number
                before[place] = value
        return last


_Watched = tuple[str, int | None, int | None]
"""A value: its variable, its index in a list, and a mask of its bits."""


def _is_numeric(value: Any) -> bool:
    """Return whether a value is a number, a list of numbers, or a view."""
    if isinstance(value, list):
        return all(isinstance(item, (bool, int, float)) for item in value)
    return isinstance(value, (bool, int, float, memoryview))


def _padded(inputs: Sequence[PlainInputs], most: int) -> tuple[Any, list[Any]]:
    """Return times and input images by scan and lane; a shorter stretch repeats its last scan."""

    def together(rows: Sequence[Any]) -> Any:
        return np.stack([row if len(row) == most else row[_repeating(len(row), most)] for row in rows])

    times = together([recorded.times for recorded in inputs]).T
    images = [together(words) for words in zip(*(recorded.images for recorded in inputs), strict=True)]
    return times, [np.ascontiguousarray(image.transpose(1, 2, 0)) for image in images]


def _words(rows: Any) -> list[Any]:
    """Return the words of an image, each an array over the lanes, or a number that all lanes share."""
    shared = (rows == rows[:, :1]).all(axis=1).tolist()
    return [
        int(word[0]) if is_shared else word.astype(np.int64)
        for word, is_shared in zip(rows, shared, strict=True)
    ]


def _repeating(count: int, most: int) -> Any:
    """Return the indexes of `count` scans; repeat the last index to fill `most` places."""
    return np.minimum(np.arange(most), count - 1)


def _at(column: Any, places: Any) -> Any:
    """Return the values of a column at some indices."""
    if isinstance(column, list):
        return [_at(value, places) for value in column]
    return column[places] if isinstance(column, np.ndarray) else column


def _are_as(vectors: Vectors, expected: Mapping[str, Any]) -> Any:
    """Return a mask of the lanes that have the expected values."""
    good = np.full(len(vectors.lost), True)
    for ident, values in expected.items():
        got = vectors.values[ident]
        for actual, required in (
            zip(got, values, strict=True) if isinstance(values, list) else [(got, values)]
        ):
            good &= actual == required
    return good


def _column(values: list[Any]) -> Any:
    """Return a variable's values in all snapshots; for a list, the values of each element."""
    first = values[0]
    if not isinstance(first, list):
        return _row(np.array(values, _TYPES[type(first)]), type(first))
    kind = float if float in map(type, first) else int
    rows: Any = np.array(values, _TYPES[kind])
    return [_row(row, type(value)) for row, value in zip(rows.T, first, strict=True)]


_TYPES = {bool: np.bool_, int: np.int64, float: np.float64}


def _row(row: Any, kind: type) -> Any:
    """Return an array of the values' type, or a number if all values are equal."""
    if row.dtype == float and kind is int and np.abs(row).max() >= _EXACT:
        raise ValueError("a number too large for an array of mixed types")
    if (row == row[0]).all():
        return kind(row[0])
    return np.ascontiguousarray(row, _TYPES[kind])


def _value(vectors: Vectors, ident: str, index: int | None, mask: int | None) -> Any:
    """Return a variable, an element of it, or some of its bits, in all lanes."""
    value = vectors.values[ident]
    if index is not None:
        value = value[index]
    return value if mask is None else value & mask
