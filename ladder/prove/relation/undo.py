"""Undo log of transactions, so that a refused row leaves no change."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_NOTHING = object()


class UndoLog:
    """The changes made in open transactions, latest last; changes outside transactions are not logged."""

    def __init__(self) -> None:
        self._changes: list[tuple[Any, Any, Any]] = []  # the container, the key, and the old value
        self._open = 0

    def put(self, container: dict[Any, Any], key: Any, value: Any) -> None:
        """Set an item of a dict."""
        if self._open:
            self._changes.append((container, key, container.get(key, _NOTHING)))
        container[key] = value

    def add(self, values: list[Any], value: Any) -> None:
        """Append a value."""
        if self._open:
            self._changes.append((values, None, None))
        values.append(value)

    def append_at(self, lists: dict[Any, list[Any]], key: Any, value: Any) -> None:
        """Append a value to the list for a key."""
        if key in lists:
            self.add(lists[key], value)
        else:
            self.put(lists, key, [value])

    def begin(self) -> tuple[int, int]:
        """Open a transaction; return its mark."""
        self._open += 1
        return self._open, len(self._changes)

    def commit(self, mark: tuple[int, int]) -> None:
        """Close a transaction; an enclosing transaction may still undo its changes."""
        self._open = mark[0] - 1
        if not self._open:
            self._changes.clear()

    def undo(self, mark: tuple[int, int]) -> Iterator[tuple[Any, Any]]:
        """Undo and close a transaction and the nested ones; yield each restored container and key."""
        self._open, begin = mark[0] - 1, mark[1]
        while len(self._changes) > begin:
            container, key, old_value = self._changes.pop()
            if isinstance(container, list):
                container.pop()
            elif old_value is _NOTHING:
                del container[key]
            else:
                container[key] = old_value
            yield container, key
