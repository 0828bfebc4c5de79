"""An open page: its view, its latest frame, and the rate limit of its messages."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Sequence
from typing import Protocol

from scanrack.runtime.live.ring import Row
from scanrack.runtime.loop.pace import wall_ns

from ..history.catalog import NOTHING_SHOWN, Json, PageRoutine
from ..history.stretch import Stretch

MESSAGES_PER_SECOND = 100
"""Maximum number of messages from a page per second."""

SECOND_NS = 1_000_000_000


class PageComparison(Protocol):
    """A comparison of a page with another trace, see `comparison`."""

    def close(self) -> None:
        """Close the files of the other trace."""

    def tick(self) -> bool:
        """Do some work on the other trace; return whether more work is due now."""

    def differences(self, page: Page, picture: Json) -> Json:
        """Return the other trace's values that differ in the scan of a picture."""


class Page:
    """An open page."""

    def __init__(self) -> None:
        self.program: Stretch | None = None  # the program that it has; None before its first message
        self.shown: PageRoutine = NOTHING_SHOWN
        self.watched: tuple[str, ...] = ()  # tags that it shows in addition to the routine's tags
        self.lanes: tuple[str, ...] = ()  # tags in its timing strip
        self.lanes_scan: int | None = None  # the last scan in its lanes; None before the first frame
        self.past: int | None = None  # the past scan that it shows; None = the latest
        self.row: Row | None = None
        self.strip_position: int | None = (
            None  # end of its strip in the recent rows; None before the first frame
        )
        self.events: int | None = None  # number of its next event; None before the first frame
        self.stops = False  # whether it stops at the scan of the next error bit, or only shows its name
        self.compared: PageComparison | None = None
        self.number = 0  # number among the pages of a monitor, from 1
        self.releases: Sequence[Json] = []  # actions that release its presses if it is lost
        self.releases_due_ns = 0  # when they are carried out unless the page confirms its presses
        self.last: Json = {}  # contents of the frames so far
        self.outbox: deque[Json] = deque()
        self.due = asyncio.Event()  # set when there is a message to send
        self._times: deque[int] = deque(maxlen=MESSAGES_PER_SECOND)

    def start_over(self) -> None:
        """Make the next frame contain everything."""
        self.last = {}
        self.strip_position = self.lanes_scan = None

    def show(self, shown: PageRoutine) -> None:
        """Show another routine, and include all of it in the next frame."""
        self.shown = shown
        self.last.pop("power", None)
        self.last.pop("tags", None)

    def watch(self, tags: tuple[str, ...]) -> None:
        """Watch other tags."""
        self.watched = tags
        self.last.pop("tags", None)

    def compare(self, comparison: PageComparison | None) -> None:
        """Begin a comparison; None ends the current one."""
        if self.compared is not None:
            self.compared.close()
        self.compared = comparison
        self.last.pop("other", None)
        self.due.set()

    def send(self, message: Json) -> None:
        """Send a message before the next frame."""
        self.outbox.append(message)
        self.due.set()

    def may_send(self) -> bool:
        """Count a message from the page; return whether the rate limit allows it."""
        now_ns = wall_ns()
        if len(self._times) == MESSAGES_PER_SECOND and now_ns - self._times[0] < SECOND_NS:
            return False
        self._times.append(now_ns)
        return True
