"""Groups items by a key, and finds what can be reached from a start."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Return items grouped by a key; groups and items keep their order."""
    found: dict[Key, list[Item]] = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return found


def reached(starts: Iterable[Key], onward: Callable[[Key], Iterable[Key]]) -> Iterator[Key]:
    """Yield each state that can be reached, once, nearest first; a start only if a path leads back to it.

    >>> list(reached([1], lambda number: [2 * number % 7]))
    [2, 4, 1]
    """
    seen: set[Key] = set()
    todo = list(starts)
    while todo:
        for each in onward(todo.pop(0)):
            if each not in seen:
                seen.add(each)
                todo.append(each)
                yield each
