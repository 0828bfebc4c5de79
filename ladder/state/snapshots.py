"""All values of a program's memory at once: to go back to, and as text for a recording.

Text from a recording is data: it must have the shape of the program's own memory.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
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
    """Return all values of a memory, by identifier of the variable."""
    images = {leaf.ident for leaf in memory.layout.images}
    found: dict[str, Any] = {}
    for ident, cell in memory.cells.items():
        value = cell.cell_contents
        if ident in images:
            value = value.tolist()
        if isinstance(value, TagBytes):
            value = value.saved()
        found[ident] = list(value) if isinstance(value, list) else value
    return found


def restore(memory: Memory, values: Mapping[str, Any]) -> None:
    """Set all values of a memory to those of a snapshot."""
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
        self._like = snapshot(memory)
        images = {leaf.ident for leaf in memory.layout.images}
        self._images = [at for at, ident in enumerate(self._like) if ident in images]
        self._bytes = [
            at for at, each in enumerate(map(_CONTENTS, self._cells)) if isinstance(each, TagBytes)
        ]

    def text(self) -> str:
        """Return the present values; TypeError if text can't have one of them."""
        values = list(map(_CONTENTS, self._cells))
        for at in self._images:
            values[at] = values[at].tolist()
        for at in self._bytes:
            data, hidden = values[at].saved()
            values[at] = [data.hex(), *hidden.values()]
        return _ENCODE(values)

    def of(self, text: str) -> dict[str, Any]:
        """Return the values in a text by identifier, for `restore`.

        Raises:
            ValueError: they are not values of this memory.
        """
        values = json_value(text)
        if not isinstance(values, list) or len(values) != len(self._like):
            raise ValueError("a snapshot of another program")
        found = {
            ident: _checked(value, like)
            for (ident, like), value in zip(self._like.items(), values, strict=True)
        }
        for at in self._images:
            if not all(type(each) is int and -0x8000 <= each <= 0x7FFF for each in values[at]):
                raise ValueError("a snapshot with a word that is no word")
        return found


def _checked(value: Any, like: Any) -> Any:
    """Return a value of a snapshot if it is like the memory's own."""
    if isinstance(like, tuple):
        data, hidden = like
        if isinstance(value, list) and len(value) == 1 + len(hidden) and isinstance(value[0], str):
            found = bytes.fromhex(value[0])
            if len(found) == len(data) and _are_like(value[1:], [*hidden.values()]):
                return found, dict(zip(hidden, value[1:], strict=True))
    elif isinstance(like, list):
        if isinstance(value, list) and _are_like(value, like):
            return value
    elif _are_like([value], [like]):
        return value
    raise ValueError("a snapshot of another program")


def _are_like(values: list[Any], like: list[Any]) -> bool:
    """Return whether values are as many, and numbers where the others are."""
    if len(values) != len(like):
        return False
    if set(map(type, like)) <= _NUMBERS:
        numbers = set(map(type, values)) <= _NUMBERS
        return numbers and (not values or (max(values) <= _LARGEST and min(values) >= -_LARGEST))
    return [type(each) for each in values] == [type(each) for each in like]
