"""A controller as read and written over a link: one exchange after the other, and what they tell.

B, 1,000,000, is where the counter of a controller is put: one that has lost its
power counts from 0 and is noticed by that.
"""

from __future__ import annotations

from collections.abc import Generator
from enum import Enum
from typing import Generic

from ...line.master import LineTiming, Master, Reply, Request, Step
from .findings import Findings
from .task import Drive, Task

BIAS = 1_000_000
FAILURES_MAX = 3
SILENCE_NS = 500_000_000
NEAR_ZERO = 1_000
NS_PER_S = 1_000_000_000


class State(Enum):
    """How far the adapter has got with the controller."""

    ABSENT = "no good exchange"
    PRESENT = "it answers, and is not configured"
    READY = "configured"


class LinkLost(Exception):  # noqa: N818  # the state that follows, not a mistake
    """Three exchanges in a row have failed, or none was good for half a second."""


class PowerLost(Exception):  # noqa: N818
    """The controller's position says that it has been switched off meanwhile."""


Talk = Generator[Step, Reply | None, None]
"""Exchanges with a controller, as a generator."""


class Exchanges(Generic[Drive]):
    """A controller as the link knows it.

    Attributes:
        state: how far it has got.
        position: of the controller's counter, as read last.
        busy: whether it moves.
        task: the motion that runs.
        tasks: those that are to follow.
        cut: a hard stop is wanted, or under way.
        setup: a configuration is wanted, or under way.
        rebased: what the counter has been moved by so far without motion, steps.
        findings: what was found out about it, for the adapter to take.
        unfit: the controller says that it can't be relied on: MODULE_OK is clear while it does.

    Args:
        line_timing: how the line is used.
    """

    def __init__(self, line_timing: LineTiming) -> None:
        self.master = Master(line_timing)
        self.state = State.ABSENT
        self.position = 0
        self.busy = False
        self.task: Task[Drive] | None = None
        self.tasks: list[Task[Drive]] = []
        self.cut = False
        self.setup = False
        self.rebased = 0
        self.findings = Findings()
        self.unfit = False
        self._was_ready = False
        self._failed = 0
        self._good_ns = 0
        self._read_ns = 0
        self._top_sps = 0
        self._rebasing_to: int | None = None

    # -- what a controller brings -------------------------------------------------------------

    def stop(self) -> Talk:
        """Stop its motion at once, and repeat that until it is answered."""
        raise NotImplementedError

    def read_status(self) -> Talk:
        """Read whether it is busy."""
        raise NotImplementedError

    def read_position(self) -> Talk:
        """Read its counter, and `note_position`."""
        raise NotImplementedError

    def read_inputs(self) -> Talk:
        """Read its inputs."""
        raise NotImplementedError

    def write_position(self, position: int) -> Talk:
        """Put its counter somewhere."""
        raise NotImplementedError

    # -- exchanges ----------------------------------------------------------------------------

    def _good(self) -> None:
        self._failed = 0
        self._good_ns = self.master.now_ns

    def ask(self, request: Request) -> Generator[Step, Reply | None, Reply | None]:
        """Make one exchange; return its reply, None if it failed.

        Raises:
            LinkLost: it was the third in a row that failed, or the silence has lasted too long.
        """
        reply = yield request
        if reply is not None:
            self._good()
            return reply
        self._failed += 1
        if self._failed >= FAILURES_MAX or self.master.now_ns - self._good_ns >= SILENCE_NS:
            raise LinkLost
        return None

    def insist(self, request: Request) -> Generator[Step, Reply | None, Reply]:
        """Repeat an exchange that may be repeated until it is answered."""
        while True:
            reply = yield from self.ask(request)
            if reply is not None:
                return reply

    # -- parts --------------------------------------------------------------------------------

    def read_all(self) -> Talk:
        """Read status, then the position, which is final if the status was idle, then inputs."""
        yield from self.read_status()
        yield from self.read_position()
        yield from self.read_inputs()

    def note_position(self, position: int) -> None:
        """Take over a position read.

        Raises:
            PowerLost: it is near 0, and too far from the one before to have been reached.
        """
        self._settle_rebase(position)
        elapsed_ns, self._read_ns = self.master.now_ns - self._read_ns, self.master.now_ns
        way = self._top_sps * elapsed_ns // NS_PER_S + NEAR_ZERO
        before, self.position = self.position, position
        if self._was_ready and abs(position) <= NEAR_ZERO and abs(position - before) > way:
            raise PowerLost

    def rebase(self, position: int) -> Talk:
        """Put the counter elsewhere; the axis stays where it is."""
        self._rebasing_to = position
        yield from self.write_position(position)
        self._settle_rebase(position)

    def _settle_rebase(self, seen: int) -> None:
        """Find out from the counter whether it was put elsewhere: the answer may have been lost."""
        goal, self._rebasing_to = self._rebasing_to, None
        if goal is not None and abs(seen - goal) < abs(seen - self.position):
            self.rebased += goal - self.position
            self.position = goal

    def halt(self) -> Talk:
        """Stop at once, and read where."""
        yield from self.stop_and_look()
        self.task = None
        self.cut = False

    def stop_and_look(self) -> Talk:
        """Stop at once, wait until it stands still, and read where."""
        yield from self.stop()
        self.busy = True
        while self.busy:
            yield from self.read_status()
        yield from self.read_position()
