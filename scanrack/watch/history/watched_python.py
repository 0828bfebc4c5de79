"""Sends the values of a Python program to a monitor about 30 times per second.

A Python program may do anything, so its scans are not repeated: its values are read while it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from types import CodeType
from typing import Any

from scanrack.jobs.record.tag_names import named_values, namespace_of
from scanrack.runtime.loop.pace import wall_ns
from scanrack.runtime.loop.scan import ScanLogic

EVERY_NS = 30_000_000
"""Time between two reads, ns."""

FIND_EVERY = 32
"""Number of reads between two searches for new values."""

MOST = 200
"""Largest number of values that are shown."""

ALL = ("*",)


class PythonNotes:
    """Sends the values of a Python program to a monitor, see `runtime.live.tap.Notes`.

    Args:
        logic: returns the program, which an edit may replace.
        patterns: the values that the rack file records; empty = all.
    """

    def __init__(
        self,
        logic: Callable[[], ScanLogic],
        patterns: Sequence[str],
        tell: Callable[[Mapping[str, object]], object],
    ) -> None:
        self._tell, self._patterns = tell, patterns or ALL
        self._codes: dict[str, CodeType] = {}
        self._known: dict[str, object] = {}
        self._due_ns = self._looks = 0
        self._logic = logic
        self._namespace: dict[str, Any] = {}

    def news(self) -> bool:
        """Return False: values are sent at intervals."""
        return False

    def note(self, scan: int) -> None:
        """Send changed values if the interval has passed."""
        now = wall_ns()
        if now >= self._due_ns:
            self._due_ns = now + EVERY_NS
            self._look(scan)

    def give(self, scan: int) -> None:
        """Send all values."""
        self._known = {}
        self._looks = 0
        self._look(scan - 1)

    def _find(self) -> None:
        """Find the current values: a running program may create new ones."""
        try:
            self._namespace = namespace_of(self._logic())
            values = named_values(self._namespace, self._patterns)[:MOST]
        except ValueError:
            return  # no values yet
        self._codes = {value.name: compile(value.name, "<watched>", "eval") for value in values}

    def _look(self, scan: int) -> None:
        if self._looks % FIND_EVERY == 0:
            self._find()
        self._looks += 1
        values = {name: self._value(code) for name, code in self._codes.items()}
        known_values = self._known
        new_values = {
            name: value
            for name, value in values.items()
            if name not in known_values or value != known_values[name]
        }
        self._known = values
        if new_values:
            self._tell({"values": {"scan": scan, "values": new_values}})

    def _value(self, code: CodeType) -> object:
        """Return a value for a page; None if it can't be read now."""
        try:
            value = eval(code, self._namespace)
        except Exception:  # a user's property raises: there is no value
            return None
        if isinstance(value, Enum):
            return value.name
        return value if isinstance(value, bool | int | str) else str(value)
