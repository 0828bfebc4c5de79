"""Takes snapshots of all values in a program's memory, to restore them or to record them as text.

Text from a recording is not trusted, so its values must have the shape of the program's memory.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import chain
from operator import attrgetter
from typing import Any

from scanrack.io_images.doors import json_value

from .memory import Memory
from .tag_bytes import TagBytes

_ENCODE = json.JSONEncoder(separators=(",", ":"), check_circular=False).encode
_CONTENTS = attrgetter("cell_contents")
_NUMBERS = frozenset({bool, int, float})
_LARGEST = 1 << 64


def snapshot(memory: Memory) -> dict[str, Any]:
    """Return all values of a memory by variable identifier."""
    images = {leaf.ident for leaf in memory.layout.images}
    values: dict[str, Any] = {}
    for ident, cell in memory.cells.items():
        value = cell.cell_contents
        if ident in images:
            value = value.tolist()
        if isinstance(value, TagBytes):
            value = value.saved()
        values[ident] = list(value) if isinstance(value, list) else value
    return values


def restore(memory: Memory, values: Mapping[str, Any]) -> None:
    """Restore all values of a memory from a snapshot."""
    for ident, cell in memory.cells.items():
        value = values[ident]
        if isinstance(cell.cell_contents, TagBytes):
            cell.cell_contents.restore(value)
            continue
        if not isinstance(value, list):
            cell.cell_contents = value
            continue
        if isinstance(cell.cell_contents, list):
            cell.cell_contents[:] = value
            continue
        for index, word in enumerate(value):
            cell.cell_contents[index] = word


class SavedValues:
    """The values of a memory as text."""

    def __init__(self, memory: Memory) -> None:
        self._cells = list(memory.cells.values())
        self._samples = snapshot(memory)
        images = {leaf.ident for leaf in memory.layout.images}
        # positions in `_cells` of images, and of tags in bytes
        self._images = [place for place, ident in enumerate(self._samples) if ident in images]
        self._bytes = [
            place
            for place, contents in enumerate(map(_CONTENTS, self._cells))
            if isinstance(contents, TagBytes)
        ]

    def text(self) -> str:
        """Return the current values as text; raise a TypeError for a value without a text form."""
        values = list(map(_CONTENTS, self._cells))
        for place in self._images:
            values[place] = values[place].tolist()
        for place in self._bytes:
            data, hidden = values[place].saved()
            values[place] = [data.hex(), *hidden.values()]
        return _ENCODE(values)

    def values_in(self, texts: Sequence[str]) -> list[dict[str, Any]]:
        """Return the values in each text by identifier, for `restore`.

        Raises:
            ValueError: a text does not contain values of this memory.
        """
        rows = json_value(f"[{','.join(texts)}]")
        width = len(self._samples)
        if len(rows) != len(texts) or not all(isinstance(row, list) and len(row) == width for row in rows):
            raise ValueError("a snapshot of another program")
        columns = [list(column) for column in zip(*rows, strict=True)]
        samples = self._samples.values()
        checked = [_checked_column(column, sample) for column, sample in zip(columns, samples, strict=True)]
        for place in self._images:
            if not _are_words(list(chain.from_iterable(checked[place]))):
                raise ValueError("a snapshot with an image word outside the range of an INT")
        return [dict(zip(self._samples, values, strict=True)) for values in zip(*checked, strict=True)]


def _checked_column(column: list[Any], sample: Any) -> list[Any]:
    """Return the values of a variable in all texts; raise a ValueError if one has the wrong shape.

    The numbers of all texts are checked together, which is faster.
    """
    if isinstance(sample, list) and {*map(type, sample)} <= _NUMBERS:
        if {*map(type, column)} == {list} and {*map(len, column)} == {len(sample)}:
            _check_numbers(list(chain.from_iterable(column)))
            return column
    elif type(sample) in _NUMBERS:
        _check_numbers(column)
        return column
    return [_checked(value, sample) for value in column]


def _check_numbers(values: list[Any]) -> None:
    if not _are_numbers(values):
        raise ValueError("a snapshot of another program")


def _are_numbers(values: list[Any]) -> bool:
    if not {*map(type, values)} <= _NUMBERS:
        return False
    return not values or (max(values) <= _LARGEST and min(values) >= -_LARGEST)


def _are_words(values: list[Any]) -> bool:
    return {*map(type, values)} <= {int} and (not values or -0x8000 <= min(values) <= max(values) <= 0x7FFF)


def _checked(value: Any, sample: Any) -> Any:
    """Return a value of a snapshot; raise a ValueError if it does not have the shape of `sample`."""
    if isinstance(sample, tuple):
        data, hidden = sample
        if isinstance(value, list) and len(value) == 1 + len(hidden) and isinstance(value[0], str):
            contents = bytes.fromhex(value[0])
            if len(contents) == len(data) and _have_same_shape(value[1:], [*hidden.values()]):
                return contents, dict(zip(hidden, value[1:], strict=True))
    elif isinstance(sample, list):
        if isinstance(value, list) and _have_same_shape(value, sample):
            return value
    elif _have_same_shape([value], [sample]):
        return value
    raise ValueError("a snapshot of another program")


def _have_same_shape(values: list[Any], sample: list[Any]) -> bool:
    """Return whether two lists have the same length, and numbers in the same places."""
    if len(values) != len(sample):
        return False
    if set(map(type, sample)) <= _NUMBERS:
        return _are_numbers(values)
    return [type(value) for value in values] == [type(value) for value in sample]
