"""Values of a Python program, which a monitor gets about 30 times per second.

Scans of a Python program are not repeated, since it may have side effects. Its values are read while it runs.
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
"""Maximum number of values."""

ALL = ("*",)


class PythonNotes:
    """The values of a Python program, as `runtime.live.tap.Notes`.

    Args:
        logic: returns the running program, which an edit may replace.
        patterns: the values that the rack file records; empty = all.
    """

    def __init__(
        self,
        logic: Callable[[], ScanLogic],
        patterns: Sequence[str],
        send: Callable[[Mapping[str, object]], object],
    ) -> None:
        self._send, self._patterns = send, patterns or ALL
        self._codes: dict[str, CodeType] = {}
        self._sent: dict[str, object] = {}
        self._due_ns = self._reads = 0
        self._logic = logic
        self._namespace: dict[str, Any] = {}

    def must_note(self) -> bool:
        """Return False, since values are sent at intervals."""
        return False

    def note(self, scan: int) -> None:
        """Send changed values if the interval has passed."""
        now = wall_ns()
        if now >= self._due_ns:
            self._due_ns = now + EVERY_NS
            self._read(scan)

    def send_values(self, scan: int) -> None:
        """Send all values."""
        self._sent = {}
        self._reads = 0
        self._read(scan - 1)

    def _find(self) -> None:
        """Find the values of the program, which may create new ones while it runs."""
        try:
            self._namespace = namespace_of(self._logic())
            values = named_values(self._namespace, self._patterns)[:MOST]
        except ValueError:
            return  # no values yet
        self._codes = {value.name: compile(value.name, "<watched>", "eval") for value in values}

    def _read(self, scan: int) -> None:
        """Read the values after a scan and send the changed ones; search for new ones now and then."""
        if self._reads % FIND_EVERY == 0:
            self._find()
        self._reads += 1
        values = {name: self._value(code) for name, code in self._codes.items()}
        sent, self._sent = self._sent, values
        new_values = {
            name: value for name, value in values.items() if name not in sent or value != sent[name]
        }
        if new_values:
            self._send({"values": {"scan": scan, "values": new_values}})

    def _value(self, code: CodeType) -> object:
        """Return a value for a page; None if it can't be read now."""
        try:
            value = eval(code, self._namespace)
        except Exception:  # a user's property may raise anything
            return None
        if isinstance(value, Enum):
            return value.name
        return value if isinstance(value, bool | int | str) else str(value)
