"""One open page: its view, the last message sent to it, and the rate limit of its questions."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Sequence
from typing import Protocol

from scanrack.runtime.live.ring import Row
from scanrack.runtime.loop.pace import wall_ns

from ..history.catalog import NOTHING_SHOWN, Json, PageRoutine
from ..history.stretch import Stretch

ORDERS_PER_SECOND = 100
"""Largest number of messages from a page per second."""

SECOND_NS = 1_000_000_000


class PageComparison(Protocol):
    """Another recording with which a page compares, see `comparison`."""

    def close(self) -> None:
        """Close the other recording's files."""

    def tick(self) -> bool:
        """Continue work on the other recording; return whether more must be done at once."""

    def differences(self, page: Page, picture: Json) -> Json:
        """Return the other recording's values in the scan of a picture, where they differ."""


class Page:
    """An open page."""

    def __init__(self) -> None:
        self.program: Stretch | None = None  # the last program sent to it; None before its first message
        self.shown: PageRoutine = NOTHING_SHOWN
        self.watched: tuple[str, ...] = ()  # tags that it shows in addition to those of the routine
        self.lanes: tuple[str, ...] = ()  # tags in its timing strip
        self.lanes_at: int | None = None  # the last scan in its lanes; None before the first frame
        self.past: int | None = None  # the past scan that it shows; None = the latest
        self.row: Row | None = None
        self.place: int | None = None  # the last row in its strip; None before the first frame
        self.events: int | None = None  # number of its next event; None before the first frame
        self.stops = False  # whether it stops at the scan of the next error bit, instead of only naming it
        self.compared: PageComparison | None = None
        self.number = 0  # number among the pages of a monitor, from 1
        self.holds: Sequence[Json] = []  # orders that release what it presses, given when it is lost
        self.holds_until_ns = 0
        self.last: Json = {}
        self.outbox: deque[Json] = deque()
        self.due = asyncio.Event()  # set when there is a message to send
        self._times: deque[int] = deque(maxlen=ORDERS_PER_SECOND)

    def start_over(self) -> None:
        """Make the next frame contain everything."""
        self.last = {}
        self.place = self.lanes_at = None

    def show(self, shown: PageRoutine) -> None:
        """Show another routine; the next frame contains all of it."""
        self.shown = shown
        self.last.pop("power", None)
        self.last.pop("tags", None)

    def watch(self, tags: tuple[str, ...]) -> None:
        """Watch other tags."""
        self.watched = tags
        self.last.pop("tags", None)

    def compare(self, other: PageComparison | None) -> None:
        """Begin to compare with another recording, or stop comparing."""
        if self.compared is not None:
            self.compared.close()
        self.compared = other
        self.last.pop("other", None)
        self.due.set()

    def send(self, message: Json) -> None:
        """Send a message before the next frame."""
        self.outbox.append(message)
        self.due.set()

    def may_ask(self) -> bool:
        """Count a message; return whether it is allowed now."""
        now = wall_ns()
        if len(self._times) == ORDERS_PER_SECOND and now - self._times[0] < SECOND_NS:
            return False
        self._times.append(now)
        return True
