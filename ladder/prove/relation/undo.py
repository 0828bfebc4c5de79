"""Undo log of transactions, so that a refused row leaves no change."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_NOTHING = object()


class UndoLog:
    """The changes of open transactions, latest last; without an open transaction, nothing is logged."""

    def __init__(self) -> None:
        self._changes: list[tuple[Any, Any, Any]] = []  # the container, the key, and the old value
        self._open = 0

    def put(self, into: dict[Any, Any], key: Any, value: Any) -> None:
        """Set an item of a dict."""
        if self._open:
            self._changes.append((into, key, into.get(key, _NOTHING)))
        into[key] = value

    def add(self, to: list[Any], value: Any) -> None:
        """Append a value."""
        if self._open:
            self._changes.append((to, None, None))
        to.append(value)

    def append_at(self, into: dict[Any, list[Any]], key: Any, value: Any) -> None:
        """Append a value to the list of a key."""
        if key in into:
            self.add(into[key], value)
        else:
            self.put(into, key, [value])

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
            changed, key, before = self._changes.pop()
            if isinstance(changed, list):
                changed.pop()
            elif before is _NOTHING:
                del changed[key]
            else:
                changed[key] = before
            yield changed, key
