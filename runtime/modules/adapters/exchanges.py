"""Reads from and writes to a device over a link, one exchange at a time.

The driver sets the device's counter to `BIAS`. After a power loss the device counts from 0, so a position
near 0 reveals the loss.
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
"""Largest distance from 0, in steps, of a counter that may have been reset by a power loss."""
NS_PER_S = 1_000_000_000


class ControllerState(Enum):
    """State of the device from the adapter's view."""

    ABSENT = "no good exchange"
    PRESENT = "it answers, but is not configured"
    READY = "configured"


class LinkLostError(Exception):
    """Three exchanges in a row, or all exchanges in half a second, have failed."""


class PowerLostError(Exception):
    """The device's position shows that the device was switched off."""


Talk = Generator[Step, Reply | None, None]
"""Exchanges with a device, as a generator."""


class Exchanges(Generic[Drive]):
    """Exchanges with a device at the end of a link.

    Attributes:
        position: the device's counter, as last read.
        busy: whether the device was moving when its status was last read.
        task: the present motion.
        tasks: motions that are waiting to start.
        cut: a hard stop is requested or in progress.
        setup: a configuration is requested or in progress.
        rebased: change of the counter, in steps, that was made without motion.
        findings: findings that the adapter has not processed yet.
        unfit: the device reports its own failure; the adapter clears MODULE_OK.
        capture_level: level of the capture input that triggers a capture; None without a capture input.
    """

    def __init__(self, line_timing: LineTiming) -> None:
        self.master = Master(line_timing)
        self.state = ControllerState.ABSENT
        self.position = 0
        self.busy = False
        self.task: Task[Drive] | None = None
        self.tasks: list[Task[Drive]] = []
        self.cut = False
        self.setup = False
        self.rebased = 0
        self.findings = Findings()
        self.unfit = False
        self.capture_level: bool | None = None
        self._was_ready = False  # the device was configured, and has not lost its power since
        self._failures = 0  # failed exchanges in a row
        self._last_good_ns = 0
        self._position_read_ns = 0
        self._top_sps = 0  # highest speed of the latest motion
        self._zeroing = False  # a search for home runs, in which the device sets its counter to 0
        self._rebasing_to: int | None = None  # value of a write to the counter that is not confirmed yet
        self._is_final = False  # the last position was read after an idle status

    # -- implemented for each device -----------------------------------------------------------

    def stop(self) -> Talk:
        """Stop motion at once; repeat the request until the device answers."""
        raise NotImplementedError

    def read_status(self) -> Talk:
        """Read whether the device is busy."""
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

    def _note_answer(self) -> None:
        self._failures = 0
        self._last_good_ns = self.master.now_ns

    def try_once(self, request: LineRequest) -> Generator[Step, Reply | None, Reply | None]:
        """Make one exchange; return its reply, or None if it failed.

        Raises:
            LinkLostError: the third exchange in a row has failed, or the silence has lasted too long.
        """
        reply = yield request
        if reply is not None:
            self._note_answer()
            return reply
        self._failures += 1
        if self._failures >= FAILURES_MAX or self.master.now_ns - self._last_good_ns >= SILENCE_NS:
            raise LinkLostError
        return None

    def insist(self, request: LineRequest) -> Generator[Step, Reply | None, Reply]:
        """Repeat an exchange until the device answers; return the reply."""
        while True:
            reply = yield from self.try_once(request)
            if reply is not None:
                return reply

    # -- sequences of exchanges -----------------------------------------------------------------

    def read_position(self) -> Talk:
        """Read and store the counter; near 0, read it again for each reply that may be late."""
        self._is_final = not self.busy
        for _ in range(self.master.overdue + 1):
            position = yield from self.ask_position()
            if abs(position) > NEAR_ZERO:
                break
        self.note_position(position)

    def confirm_standstill(
        self, gives_up: Callable[[], bool] = lambda: False
    ) -> Generator[Step, Reply | None, bool]:
        """Poll until enough polls in a row agree despite late replies; return whether the axis is at rest.

        A poll reads the status and then the position. The position is stored when more polls agree than
        replies can be late. A poll that shows a motion, a request for a hard stop, or `gives_up` ends the
        polling.
        """
        polls_needed, cut_before = self.master.overdue + 1, self.cut
        polls_agreeing, position = 0, self.position
        while polls_agreeing < polls_needed:
            yield from self.read_status()
            if self.busy or self.cut is not cut_before or gives_up():
                return False
            previous, position = position, (yield from self.ask_position())
            polls_agreeing = polls_agreeing + 1 if position == previous else 1
        self.note_position(position)
        return True

    def read_all(self) -> Talk:
        """Read status, position and inputs; the position is final if the status is idle."""
        if not (yield from self.confirm_standstill()):
            yield from self.read_position()
        yield from self.read_inputs()

    def note_position(self, position: int) -> None:
        """Store a position that was read; ignore the zero that a device sets at home.

        Raises:
            PowerLostError: the position is near 0, and the axis can't have moved there.
        """
        if self._zeroing and abs(position) <= NEAR_ZERO:
            return
        self._settle_rebase(position)
        now_ns = self.master.now_ns
        steps_possible = self._top_sps * (now_ns - self._position_read_ns) // NS_PER_S + NEAR_ZERO
        self._position_read_ns = now_ns
        steps_made, self.position = abs(position - self.position), position
        if self._was_ready and abs(position) <= NEAR_ZERO and steps_made > steps_possible:
            raise PowerLostError

    def rebase(self, position: int) -> Talk:
        """Set the counter without moving the axis."""
        self._rebasing_to = position
        yield from self.write_position(position)
        self._settle_rebase(position)

    def _settle_rebase(self, counter: int) -> None:
        """Determine from the counter whether the write took effect, since its reply may have been lost."""
        rebased_to, self._rebasing_to = self._rebasing_to, None
        if rebased_to is not None and abs(counter - rebased_to) < abs(counter - self.position):
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
        while not (yield from self.confirm_standstill()):
            if self.master.overdue:  # the reply may belong to an earlier request, not to the stop
                yield from self.stop()
