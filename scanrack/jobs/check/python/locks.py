"""Finds sequences that take locks in orders that can block each other forever."""

from __future__ import annotations

from collections.abc import Sequence

from ..facts import Facts, FileLine


class Locks:
    """The locks of a class.

    Args:
        names: names of all locks.
    """

    def __init__(self, names: Sequence[str], facts: Facts) -> None:
        self.names = names
        self._facts = facts
        self._after: dict[str, dict[str, FileLine]] = {}  # by held lock: the locks taken then, and where

    def take(self, owner: str, name: str, held: Sequence[str], at: FileLine) -> None:
        """Note that a sequence takes a lock; remark if its order can block."""
        if name in held:
            text = f"{owner} takes {name}, which it holds: it waits for itself"
            self._facts.remark("lock-order", at, text)
            return
        for each in held:
            back = self._way(name, each)
            if back is not None:
                text = f"{owner} takes {name} while it holds {each}: line {back.line} leads the other way"
                self._facts.remark("lock-order", at, text)
            self._after.setdefault(each, {}).setdefault(name, at)

    def _way(self, first: str, last: str) -> FileLine | None:
        """Return where a chain of lock orders from one lock to another begins; None if there is none."""
        seen, todo = {first}, [(each, at) for each, at in self._after.get(first, {}).items()]
        while todo:
            name, at = todo.pop(0)
            if name == last:
                return at
            if name not in seen:
                seen.add(name)
                todo += [(each, at) for each in self._after.get(name, {})]
        return None
