"""A listener that keeps what events tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class Witness:
    """Keeps the data of all events.

    Attributes:
        events: in their order.
    """

    def __init__(self) -> None:
        self.events: list[Mapping[str, Any]] = []

    def scan(self, _scan: int, _now_ns: int, _flags: int) -> None:
        """Nothing to keep."""

    def event(self, *event: Any) -> None:
        """Keep the data, which come last."""
        self.events.append(event[-1])

    def close(self) -> None:
        """Do nothing: nothing is open."""

    @property
    def texts(self) -> list[str]:
        """What they tell people."""
        return [event.get("text", "") for event in self.events]
