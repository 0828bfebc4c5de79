"""Groups items by a key, and finds the states that can be reached from a start."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Return items grouped by a key; groups and items keep their order."""
    items_by_key: dict[Key, list[Item]] = {}
    for item in items:
        items_by_key.setdefault(key(item), []).append(item)
    return items_by_key


def reached(starts: Iterable[Key], onward: Callable[[Key], Iterable[Key]]) -> Iterator[Key]:
    """Yield each reachable state once, nearest first; yield a start only if a path leads back to it.

    >>> list(reached([1], lambda number: [2 * number % 7]))
    [2, 4, 1]
    """
    seen: set[Key] = set()
    todo = list(starts)
    while todo:
        for neighbor in onward(todo.pop(0)):
            if neighbor not in seen:
                seen.add(neighbor)
                todo.append(neighbor)
                yield neighbor
