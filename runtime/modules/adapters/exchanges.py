"""Reads and writes of a controller over a link, one exchange after the other.

The driver sets the controller's counter to B = 1,000,000: after a power loss the
controller counts from 0, which the driver notices.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from enum import Enum
from typing import Generic

from ...line.master import LineRequest, LineTiming, Master, Reply, Step
from .findings import Findings
from .task import Drive, Task

BIAS = 1_000_000
FAILURES_MAX = 3
SILENCE_NS = 500_000_000
NEAR_ZERO = 1_000
NS_PER_S = 1_000_000_000


class ControllerState(Enum):
    """State of the controller from the adapter's view."""

    ABSENT = "no good exchange"
    PRESENT = "it answers, and is not configured"
    READY = "configured"


class LinkLostError(Exception):  # named after the state that follows
    """Three exchanges in a row, or all exchanges of half a second, have failed."""


class PowerLostError(Exception):
    """The controller's position shows that it was switched off meanwhile."""


Talk = Generator[Step, Reply | None, None]
"""Exchanges with a controller, as a generator."""


class Exchanges(Generic[Drive]):
    """A controller at the end of a link."""

    def __init__(self, line_timing: LineTiming) -> None:
        self.master = Master(line_timing)
        self.state = ControllerState.ABSENT
        self.position = 0  # the controller's counter, as last read
        self.busy = False
        self.task: Task[Drive] | None = None
        self.tasks: list[Task[Drive]] = []
        self.cut = False  # a hard stop is requested or in progress
        self.setup = False  # a configuration is requested or in progress
        self.rebased = 0  # steps by which the counter was set without motion
        self.findings = Findings()  # findings that the adapter has not processed yet
        self.unfit = False  # the controller reports its own failure: MODULE_OK is clear meanwhile
        self.captures: bool | None = None  # level of the capture input at which it captures, or None
        self._was_ready = False
        self._failed = 0
        self._good_ns = 0
        self._read_ns = 0
        self._top_sps = 0
        self._zeroing = False  # a search for home runs, in which the controller sets its counter to 0
        self._rebasing_to: int | None = None
        self._is_final = False

    # -- implemented for each controller -------------------------------------------------------

    def stop(self) -> Talk:
        """Stop motion at once; repeat until it is answered."""
        raise NotImplementedError

    def read_status(self) -> Talk:
        """Read whether the controller is busy."""
        raise NotImplementedError

    def ask_position(self) -> Generator[Step, Reply | None, int]:
        """Return the counter."""
        raise NotImplementedError

    def read_inputs(self) -> Talk:
        """Read the inputs."""
        raise NotImplementedError

    def write_position(self, position: int) -> Talk:
        """Set the counter."""
        raise NotImplementedError

    # -- exchanges ----------------------------------------------------------------------------

    def _good(self) -> None:
        self._failed = 0
        self._good_ns = self.master.now_ns

    def ask(self, request: LineRequest) -> Generator[Step, Reply | None, Reply | None]:
        """Make one exchange; return its reply, None if it failed.

        Raises:
            LinkLostError: the third exchange in a row has failed, or the silence lasts too long.
        """
        reply = yield request
        if reply is not None:
            self._good()
            return reply
        self._failed += 1
        if self._failed >= FAILURES_MAX or self.master.now_ns - self._good_ns >= SILENCE_NS:
            raise LinkLostError
        return None

    def insist(self, request: LineRequest) -> Generator[Step, Reply | None, Reply]:
        """Repeat an exchange until it is answered."""
        while True:
            reply = yield from self.ask(request)
            if reply is not None:
                return reply

    # -- parts --------------------------------------------------------------------------------

    def read_position(self) -> Talk:
        """Read and store the counter; near 0, read it again for each answer that may be late."""
        self._is_final = not self.busy
        for _ in range(self.master.overdue + 1):
            position = yield from self.ask_position()
            if abs(position) > NEAR_ZERO:
                break
        self.note_position(position)

    def rest(self, enough: Callable[[], bool] = lambda: False) -> Generator[Step, Reply | None, bool]:
        """Poll until more successive polls agree than answers may be late; return whether the axis rests.

        A poll reads a status and then the position, which is final if the status is idle. Only a position on
        which all polls agree is stored. The first poll that shows a motion ends the sequence, and so does a
        request for a hard stop, or `enough`.
        """
        looks, cut_before = self.master.overdue + 1, self.cut
        agreed, position = 0, self.position
        while agreed < looks:
            yield from self.read_status()
            if self.busy or self.cut is not cut_before or enough():
                return False
            previous, position = position, (yield from self.ask_position())
            agreed = agreed + 1 if position == previous else 1
        self.note_position(position)
        return True

    def read_all(self) -> Talk:
        """Read status, then the position, which is final if the status was idle, then inputs."""
        if not (yield from self.rest()):
            yield from self.read_position()
        yield from self.read_inputs()

    def note_position(self, position: int) -> None:
        """Store a position read; ignore the zero that a controller sets at home.

        Raises:
            PowerLostError: it is near 0, and too far from the last one for the speed.
        """
        if self._zeroing and abs(position) <= NEAR_ZERO:
            return
        self._settle_rebase(position)
        elapsed_ns, self._read_ns = self.master.now_ns - self._read_ns, self.master.now_ns
        reach = self._top_sps * elapsed_ns // NS_PER_S + NEAR_ZERO
        previous, self.position = self.position, position
        if self._was_ready and abs(position) <= NEAR_ZERO and abs(position - previous) > reach:
            raise PowerLostError

    def rebase(self, position: int) -> Talk:
        """Set the counter without moving the axis."""
        self._rebasing_to = position
        yield from self.write_position(position)
        self._settle_rebase(position)

    def _settle_rebase(self, seen: int) -> None:
        """Find out whether the counter was set: the answer may have been lost."""
        rebased_to, self._rebasing_to = self._rebasing_to, None
        if rebased_to is not None and abs(seen - rebased_to) < abs(seen - self.position):
            self.rebased += rebased_to - self.position
            self.position = rebased_to

    def halt(self) -> Talk:
        """Stop at once, and read the position at rest; this ends every motion."""
        yield from self.stop_and_read_status()
        self.task = None
        self.tasks.clear()
        self.cut = False

    def stop_and_read_status(self) -> Talk:
        """Stop at once, wait for standstill, and read the status and the final position."""
        yield from self.stop()
        while not (yield from self.rest()):
            if self.master.overdue:  # the answer to the stop may be outdated
                yield from self.stop()
