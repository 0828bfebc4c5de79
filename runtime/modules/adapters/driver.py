"""The driver of a device: finds, configures and moves it, and reconnects after a loss.

    ABSENT --answers--> PRESENT --configured--> READY
       ^                   ^                      |
       |                   +---- power lost ------+
       +---- link lost; READY again if the position fits

A start is never repeated blindly: if the reply is lost, the driver reads the device first. Any other
exchange may be repeated until the device answers.
"""

from __future__ import annotations

from collections.abc import Callable, Generator

from scanrack.io_images.amci3601 import StatusMsw

from ...line.master import PUBLISH, LinePause, LineRequest, LineTiming, Reply, Script, Step
from .exchanges import BIAS, ControllerState, Exchanges, LinkLostError, PowerLostError, Talk
from .findings import FindingKind
from .task import Drive, Task, TaskKind

REBIAS_BELOW = 500_000
"""Distance of the counter from 0, in steps, below which an axis at rest is set to `BIAS` again."""
PROBE_NS = 250_000_000
"""Time between two attempts to find the device."""


class Driver(Exchanges[Drive]):
    """The sequence of exchanges with a device."""

    def __init__(self, line_timing: LineTiming) -> None:
        super().__init__(line_timing)
        self.master.begin(self._script())

    # -- implemented for each device -----------------------------------------------------------

    def identify(self) -> LineRequest:
        """Return the request that finds the device."""
        raise NotImplementedError

    def configure(self) -> Talk:
        """Prepare the device for motions, with its counter at `BIAS`."""
        raise NotImplementedError

    def carry_out(self, task: Task[Drive]) -> Talk:
        """Carry out a motion, including the wait for standstill."""
        raise NotImplementedError

    @property
    def cycle(self) -> tuple[Callable[[], Talk], ...]:
        """Return the reads of a poll, in order; the status comes before the position."""
        return self.read_status, self.read_position, self.read_inputs

    def restore_protocol(self) -> Talk:
        """Recover a device that does not answer because it uses another protocol."""
        yield from ()

    def take_control(self) -> Generator[Step, Reply | None, bool]:
        """Take control of a device that was found; return whether it obeys."""
        yield from ()
        return True

    def pending_exchange(self) -> Talk | None:
        """Return the exchange that an adapter's request needs, or None."""
        return None

    def wake_for_requests(self) -> None:
        """End a pause if the adapter has a new request."""

    def forget(self) -> None:
        """Forget the device's parameters, and drop pending clear requests."""
        raise NotImplementedError

    # -- the script ---------------------------------------------------------------------------

    def _script(self) -> Script:
        """Connect to the device and do its work; after a loss of the link or of power, connect again."""
        while True:
            try:
                yield from self._connect()
                while True:
                    yield from self._do_most_urgent()
            except LinkLostError:
                self._reset_after_loss()
                self.state = ControllerState.ABSENT
                yield PUBLISH
            except PowerLostError:
                self._reset_after_loss()
                self._was_ready = False
                self.findings.add(FindingKind.POWER_LOST)
                self.master.expect_nothing_late()
                self.cut = True
                self.state = ControllerState.PRESENT
                yield PUBLISH

    def _reset_after_loss(self) -> None:
        """Drop all tasks, and forget the state of the device."""
        self.task = None
        self.tasks.clear()
        self.cut = False
        self.forget()

    def _connect(self) -> Talk:
        """Request the identity until it arrives; then check whether the device has kept its state."""
        while self.state is ControllerState.ABSENT:
            sent_ns = self.master.now_ns
            reply = yield self.identify()
            if reply is None:
                yield from self.restore_protocol()
                yield LinePause(max(0, sent_ns + PROBE_NS - self.master.now_ns))
                continue
            self._note_answer()
            if self._was_ready or (yield from self.take_control()):
                yield from self._read_after_connecting()
            else:
                yield PUBLISH
                yield LinePause(PROBE_NS)
        self._failures = 0

    def _read_after_connecting(self) -> Talk:
        """Read the state of a device that answers; stop a configured device, which may be moving."""
        if self._was_ready:
            yield from self.halt()
        yield from self.read_all()
        self.state = ControllerState.READY if self._was_ready else ControllerState.PRESENT
        if self._was_ready:
            self.findings.add(FindingKind.RETURNED)
        yield PUBLISH

    def _do_most_urgent(self) -> Talk:
        """Carry out the most urgent request, or poll if there is none."""
        if self.cut:
            yield from self.halt()
            yield PUBLISH
        elif self.setup:
            yield from self._set_up()
        elif (pending_exchange := self.pending_exchange()) is not None:
            yield from pending_exchange
        elif self.tasks:
            self.task = self.tasks.pop(0)
            self._top_sps = self.task.drive.max_sps
            yield from self.carry_out(self.task)
        else:
            yield from self._poll_at_rest()

    def _set_up(self) -> Talk:
        """Configure the device as if it were new; it is then ready for motions."""
        self.forget()
        self._was_ready = False
        yield from self.configure()
        yield from self.read_all()
        self.setup = False
        self._was_ready = True
        self.state = ControllerState.READY
        yield PUBLISH

    def _poll_at_rest(self) -> Talk:
        """Poll while idle, until there is work; report a motion without a command.

        A counter that has come near 0 is set to `BIAS` again, since 0 would look like a loss of power.
        """
        position_before = self.position
        reads = self.cycle if not self.master.overdue else (self._poll_with_late_replies, self.read_inputs)
        for read in reads:
            yield from read()
            if self.state is ControllerState.READY and (self.busy or self.position != position_before):
                self.findings.add(FindingKind.STRAYED)
                position_before = self.position
            if self.has_work():
                return
        yield PUBLISH
        if self.state is ControllerState.READY and not self.busy and abs(self.position) < REBIAS_BELOW:
            yield from self.rebase(BIAS)

    def _poll_with_late_replies(self) -> Talk:
        """Read the status; a reply that shows a motion may be late, so more replies must confirm it."""
        for _ in range(self.master.overdue + 1):
            if (yield from self.confirm_standstill(self.has_work)) or self.has_work():
                self.busy = False
                return

    def has_work(self) -> bool:
        """Return whether there is work other than polling."""
        return self.cut or self.setup or bool(self.tasks) or self.pending_exchange() is not None

    # -- motions ------------------------------------------------------------------------------

    def start(self, task: Task[Drive], request: LineRequest) -> Talk:
        """Start a motion; if the reply is lost, repeat the start only if the axis has not moved.

        A device refuses a start while a stop or a program is active, or another master moves the axis.
        """
        position_before = self.position
        for _ in range(2):
            reply = yield from self.try_once(request)
            self.model(task)
            if reply is not None:
                if reply.refused is not None:
                    text = "the device has refused to start the motion"
                    self.findings.complain(StatusMsw.COMMAND_ERROR.value, text)
                return
            if not (yield from self.confirm_standstill()) or self.position != position_before:
                return

    def model(self, task: Task[Drive]) -> None:
        """Store the plan of a motion that starts now."""
        raise NotImplementedError

    def accompany(self, task: Task[Drive]) -> Talk:
        """Poll until the motion has ended; slow it down or set its mark on request."""
        was_slowed = was_marked = False
        while not self.cut:
            if task.stopping and not was_slowed:
                was_slowed = True
                yield from self.slow_down(task)
                if task.kind is TaskKind.INDEX:
                    return
            elif task.marked and not was_marked:
                was_marked = True
                yield from self.set_mark(task)
            for read in self.cycle:
                yield from read()
                must_slow, must_mark = task.stopping and not was_slowed, task.marked and not was_marked
                if self._is_cut() or must_slow or must_mark:
                    break
            else:
                yield from self.watch(task)
                if (yield from self._has_ended()):
                    return
                yield PUBLISH

    def _has_ended(self) -> Generator[Step, Reply | None, bool]:
        """Return whether the last position read is final; read again while replies may be late."""
        if self.busy or not self._is_final:
            return False
        return not self.master.overdue or (yield from self.confirm_standstill())

    def slow_down(self, task: Task[Drive]) -> Talk:
        """Stop with a ramp; on return, an index move is at rest."""
        raise NotImplementedError

    def set_mark(self, task: Task[Drive]) -> Talk:
        """Set the mark of a registration move."""
        raise NotImplementedError

    def stop_and_index(self, task: Task[Drive]) -> Talk:
        """Use the present position as the mark, stop, and index the steps that remain."""
        yield from self.read_position()
        mark = self.position
        task.stopping = True
        yield from self.slow_down(task)
        while not self.cut and not (yield from self.confirm_standstill()):
            pass
        steps_left = task.steps - abs(self.position - mark)
        if steps_left > 0:
            drive = self.drive_over(task.drive, steps_left)
            task.following = Task(TaskKind.INDEX, task.direction, drive, task.ramps_up, steps_left)

    def drive_over(self, drive: Drive, steps: int) -> Drive:
        """Return the speeds and ramps for an index over a number of steps."""
        return drive

    def watch(self, task: Task[Drive]) -> Talk:
        """React to a read during a motion."""
        raise NotImplementedError

    def _is_cut(self) -> bool:
        """Return whether a hard stop is requested; mypy assumes that a `yield` leaves `cut` unchanged."""
        return self.cut

    def conclude(self, task: Task[Drive], start_position: int) -> Talk:
        """Publish the standstill, end the motion, and queue the motion that follows it."""
        target = start_position + task.direction * task.steps
        if task.kind is TaskKind.INDEX and not task.stopping and self.position != target:
            self.findings.add(FindingKind.STOPPED_SHORT)
        yield PUBLISH
        if not self._is_cut():
            self.task = None
            if task.following is not None:
                self.tasks.insert(0, task.following)
            yield PUBLISH
