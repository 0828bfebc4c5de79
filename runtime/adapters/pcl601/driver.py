"""What is said to a PCL601, one exchange after the other.

    connect     identity every 250 ms until it answers; then it is stopped, and its position compared
    configure   errors cleared, stopped, functions off, current on, position := B
    idle        status, position, inputs; over again
    motion      parameters where they have changed, the start, then as idle until it is over

A start is never repeated blindly: where its echo is lost, busy and position
tell whether it was carried out. Stops are repeated until they are answered.

B, 1,000,000, is where the controller's counter is put: one that has lost its
power counts from 0 and is noticed by that.
"""

from __future__ import annotations

from collections.abc import Generator
from enum import Enum

from ....io_images.pcl601 import Code, Error, Register
from ...kinematics import Shape, creep, move, register, run, stop
from ...wire import LineFormat
from ..master import PUBLISH, Manners, Master, Pause, Reply, Request, Script, Step
from . import frames
from .task import Kind, Task

LINE_FORMAT = LineFormat(38_400, "E")
MANNERS = Manners(LINE_FORMAT, gap_ns=1_010_000, patience_ns=50_000_000)
"""3.5 characters and a little; replies are waited for 50 ms [adapters, timeouts]."""

BIAS = 1_000_000
REBIAS_BELOW = 500_000
COUNTER_END = 8_000_000
PROBE_NS = 250_000_000
FAILURES_MAX = 3
SILENCE_NS = 500_000_000
NEAR_ZERO = 1_000
NS_PER_S = 1_000_000_000

MARK_OUTPUT = 7
"""Wired to input 2: it sets the mark of a registration move."""

FUNCTIONS_OFF = (0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0)
"""4x21 to 4x31: everything off, encoder ratio 1."""

HARD_LIMIT = 1 << 6
BOTH_SIDES = 2
"""Value of `Driver.limit_side`: a limit is on, and which one is not known."""


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


class Driver:
    """The controller as the link knows it, and the script that talks to it.

    Attributes:
        state: how far it has got.
        position: of the controller's counter, as read last.
        encoder: its encoder count.
        inputs: its input register.
        busy: whether it moves.
        errors: its error bits.
        limit_side: which hard limit is on: +1, -1, 0 for none, `BOTH_SIDES`.
        direction: of the last motion, 0 before the first.
        task: the motion that runs.
        tasks: those that are to follow.
        cut: a hard stop is wanted, or under way.
        setup: a configuration is wanted, or under way.
        clear_errors: the error bits are to be cleared.
        clear_encoder: the encoder is to be set to 0.
        estop_on_limits: an active input 4 shows on both hard limits, too.
        rebased: what the counter has been moved by so far without motion, steps.
        lost_power: it was found to have been switched off.
        returned: it answers again after a loss, and was not switched off.
        strayed: it has moved without being told.
        stopped_short: a motion ended before its target.
        out_of_range: a slew has come to the end of the counter's range.

    Args:
        unit: its address.
    """

    def __init__(self, unit: int = 1) -> None:
        self.unit = unit
        self.master = Master(MANNERS)
        self.state = State.ABSENT
        self.position = self.encoder = self.inputs = 0
        self.busy = False
        self.errors = Error(0)
        self.limit_side = 0
        self.direction = 0
        self.task: Task | None = None
        self.tasks: list[Task] = []
        self.cut = False
        self.setup = False
        self.clear_errors = False
        self.clear_encoder = False
        self.estop_on_limits = False
        self.rebased = 0
        self.lost_power = self.returned = self.strayed = False
        self.stopped_short = self.out_of_range = False
        self._was_ready = False
        self._failed = 0
        self._good_ns = 0
        self._read_ns = 0
        self._top_sps = 0
        self._written: dict[Register, tuple[int, ...]] = {}
        self.master.begin(self._script())

    # -- the script ---------------------------------------------------------------------------

    def _script(self) -> Script:
        while True:
            try:
                yield from self._connect()
                while True:
                    yield from self._turn()
            except LinkLost:
                self._forget_wishes()
                self.state = State.ABSENT
                yield PUBLISH
            except PowerLost:
                self._forget_wishes()
                self._was_ready = False
                self.lost_power = self.cut = True
                self.state = State.PRESENT
                yield PUBLISH

    def _forget_wishes(self) -> None:
        self.task = None
        self.tasks.clear()
        self._written.clear()
        self.cut = self.clear_errors = self.clear_encoder = False

    def _connect(self) -> Talk:
        """Ask for the identity until it comes; then see whether it is the controller that it was."""
        while self.state is State.ABSENT:
            asked_ns = self.master.now_ns
            reply = yield frames.report_id(self.unit)
            if reply is None:
                yield Pause(max(0, asked_ns + PROBE_NS - self.master.now_ns))
                continue
            self._good(reply)
            yield from self._see_again()
        self._failed = 0

    def _see_again(self) -> Talk:
        if self._was_ready:
            yield from self._halt()
        yield from self._read_all()
        self.state = State.READY if self._was_ready else State.PRESENT
        self.returned = self._was_ready
        yield PUBLISH

    def _turn(self) -> Talk:
        """Do the most urgent thing."""
        if self.cut:
            yield from self._halt()
            yield PUBLISH
        elif self.setup:
            yield from self._configure()
        elif self.clear_errors:
            yield from self._command(Code.CLEAR_ERRORS)
            self.clear_errors = False
        elif self.clear_encoder:
            yield from self._command(Code.ENCODER_RESET)
            self.encoder = 0
            self.clear_encoder = False
        elif self.tasks:
            self.task = self.tasks.pop(0)
            yield from self._carry_out(self.task)
        else:
            yield from self._look_around()

    @property
    def _urgent(self) -> bool:
        """Whether there is something to do that idle reading must not hold up."""
        return self.cut or self.setup or bool(self.tasks) or self.clear_errors or self.clear_encoder

    # -- exchanges ----------------------------------------------------------------------------

    def _good(self, reply: Reply) -> None:
        self._failed = 0
        self._good_ns = self.master.now_ns

    def _ask(self, request: Request) -> Generator[Step, Reply | None, Reply | None]:
        """Make one exchange; return its reply, None if it failed.

        Raises:
            LinkLost: it was the third in a row that failed, or the silence has lasted too long.
        """
        reply = yield request
        if reply is not None:
            self._good(reply)
            return reply
        self._failed += 1
        if self._failed >= FAILURES_MAX or self.master.now_ns - self._good_ns >= SILENCE_NS:
            raise LinkLost
        return None

    def _insist(self, request: Request) -> Generator[Step, Reply | None, Reply]:
        """Repeat an exchange that may be repeated until it is answered."""
        while True:
            reply = yield from self._ask(request)
            if reply is not None:
                return reply

    def _write(self, first: Register, *words: int) -> Talk:
        """Write registers, unless they hold these words already."""
        if self._written.get(first) == words:
            return
        reply = yield from self._insist(frames.write_registers(self.unit, first, words))
        if reply.refused is not None:  # a program runs, or somebody moves the axis: stop both
            yield from self._command(Code.STOP_MOTION)
            reply = yield from self._insist(frames.write_registers(self.unit, first, words))
            if reply.refused is not None:
                raise LinkLost
        self._written[first] = words

    def _command(self, code: Code) -> Talk:
        yield from self._insist(frames.write_command(self.unit, code))

    def _mark(self, on: bool) -> Talk:
        yield from self._insist(frames.write_output(self.unit, MARK_OUTPUT, on))

    # -- reading ------------------------------------------------------------------------------

    def _read_status(self) -> Talk:
        reply = yield from self._insist(frames.read_registers(self.unit, Register.ENCODER_POSITION, 5))
        low, high, _, busy, errors = frames.words_of(reply)
        self.encoder, self.busy, self.errors = frames.signed_pair(low, high), bool(busy), Error(errors)

    def _read_position(self) -> Talk:
        reply = yield from self._insist(frames.read_registers(self.unit, Register.POSITION, 2))
        position = frames.signed_pair(*frames.words_of(reply))
        elapsed_ns, self._read_ns = self.master.now_ns - self._read_ns, self.master.now_ns
        way = self._top_sps * elapsed_ns // NS_PER_S + NEAR_ZERO
        before, self.position = self.position, position
        if self._was_ready and abs(position) <= NEAR_ZERO and abs(position - before) > way:
            raise PowerLost

    def _read_inputs(self) -> Talk:
        reply = yield from self._insist(frames.read_inputs(self.unit))
        (self.inputs,) = frames.words_of(reply)
        on = self.inputs & HARD_LIMIT and not self._diodes_conduct
        if not on:
            self.limit_side = 0
        elif self.limit_side in (0, BOTH_SIDES):
            yield from self._attribute()

    @property
    def _diodes_conduct(self) -> bool:
        return self.estop_on_limits and bool(self.inputs & 1 << 3)

    def _attribute(self) -> Talk:
        """Find out which limit is on: it stops a slew towards it, and not one away from it."""
        if self.task is not None and self.task.kind is Kind.SLEW and self.task.model is not None:
            yield from self._read_status()
            self.limit_side = -self.direction if self.busy else self.direction
        elif self.limit_side == 0:
            self.limit_side = self.direction or BOTH_SIDES

    def _read_all(self) -> Talk:
        yield from self._read_status()
        yield from self._read_position()
        yield from self._read_inputs()

    def _look_around(self) -> Talk:
        """Read everything while nothing is to be done; what moves then was not told to."""
        before = self.position
        for read in (self._read_status, self._read_position, self._read_inputs):
            yield from read()
            if self.state is State.READY and (self.busy or self.position != before):
                self.strayed = True
                before = self.position
            if self._urgent:
                return
        yield PUBLISH
        if self.state is State.READY and not self.busy and abs(self.position) < REBIAS_BELOW:
            yield from self._rebase(BIAS)

    def _rebase(self, position: int) -> Talk:
        """Put the counter elsewhere; the axis stays where it is."""
        self._written.pop(Register.POSITION, None)
        before = self.position
        yield from self._write(Register.POSITION, *frames.low_high(position))
        self.position = position
        self.rebased += position - before

    # -- configuration ------------------------------------------------------------------------

    def _configure(self) -> Talk:
        self._written.clear()
        yield from self._insist(frames.report_id(self.unit))
        yield from self._read_status()
        if self.errors:
            yield from self._command(Code.CLEAR_ERRORS)
        yield from self._halt()
        yield from self._mark(False)
        yield from self._write(Register.ANALOG_ENABLE, 0, 1)
        yield from self._write(Register.INDEX_ON_FLY, *FUNCTIONS_OFF)
        self._was_ready = False
        yield from self._rebase(BIAS)
        yield from self._read_all()
        self.setup = False
        self._was_ready = True
        self.state = State.READY
        yield PUBLISH

    # -- motions ------------------------------------------------------------------------------

    def _halt(self) -> Talk:
        """Stop at once, and read where."""
        yield from self._command(Code.STOP_MOTION)
        self.busy = True
        while self.busy:
            yield from self._read_status()
        yield from self._read_position()
        self.task = None
        self.cut = False

    def _carry_out(self, task: Task) -> Talk:
        """Make a motion, from its parameters to the standstill after it."""
        self._top_sps = task.drive.speed_sps
        yield from self._make_room(task)
        yield from self._write_parameters(task)
        began_at = self.position
        if not (self.cut or task.stopping):
            self.direction = task.direction
            yield from self._start(task)
            yield from self._accompany(task)
        if self.cut:
            return
        yield from self._conclude(task, began_at)

    def _make_room(self, task: Task) -> Talk:
        """Keep the counter within its range."""
        steps = task.steps if task.kind is Kind.INDEX else COUNTER_END // 2
        if abs(self.position + task.direction * steps) > COUNTER_END:
            yield from self._rebase(-task.direction * BIAS)

    def _write_parameters(self, task: Task) -> Talk:
        drive = task.drive
        yield from self._write(Register.INDEX_ON_FLY, int(task.registers))
        direction = int(task.direction > 0)
        speeds = (*frames.low_high(drive.accel_sps2), drive.base_sps, drive.speed_sps, drive.speed_sps)
        if task.kind is Kind.INDEX or task.registers:
            self._written.pop(Register.ACCEL, None)
            yield from self._write(Register.STEPS, *frames.low_high(task.steps), *speeds, direction)
        else:
            self._written.pop(Register.STEPS, None)
            yield from self._write(Register.ACCEL, *speeds, direction)

    def _start(self, task: Task) -> Talk:
        """Start the motion; where the echo is lost, look before doing it again."""
        request = frames.write_command(self.unit, task.kind.value)
        before = self.position
        for _ in range(2):
            reply = yield from self._ask(request)
            self._model(task)
            if reply is not None or self.cut:
                return
            for _ in range(2):
                yield from self._read_status()
                yield from self._read_position()
                if self.busy or self.position != before:
                    return

    def _model(self, task: Task) -> None:
        """Note what the controller is now thought to do."""
        now_ns, profile = self.master.now_ns, task.drive.profile
        if task.kind is Kind.INDEX:
            task.model = move(now_ns, 0, task.direction * task.steps, profile)
        else:
            task.model = run(now_ns, 0, task.direction, profile)

    def _accompany(self, task: Task) -> Talk:
        """Watch the motion until the controller is idle, and pass on what is wanted of it."""
        slowed = marked = False
        while not self.cut:
            if task.stopping and not slowed:
                slowed = True
                yield from self._slow_down(task)
                if task.kind is Kind.INDEX:
                    return
            elif task.marked and not marked:
                marked = True
                yield from self._set_mark(task)
            for read in (self._read_status, self._read_position, self._read_inputs):
                yield from read()
                if self._cut_meanwhile() or (task.stopping > slowed) or (task.marked > marked):
                    break
            else:
                self._watch_range(task)
                if not self.busy:
                    return
                yield PUBLISH

    def _watch_range(self, task: Task) -> None:
        if task.kind is Kind.SLEW and not task.stopping and abs(self.position) > COUNTER_END:
            self.out_of_range = True

    def _set_mark(self, task: Task) -> Talk:
        if task.model is not None and task.model.end_ns is None:
            drive, now_ns = task.drive, self.master.now_ns
            task.model = register(
                task.model, now_ns, task.steps, drive.base_sps, drive.rate_spmss, Shape.CONSTANT
            )
        yield from self._mark(True)

    def _slow_down(self, task: Task) -> Talk:
        """Stop softly: a slew ends by itself, an index creeps on and is stopped at its base speed."""
        yield from self._command(Code.STOP_SOFT)
        drive, now_ns, model = task.drive, self.master.now_ns, task.model
        assert model is not None
        halt = stop(model, now_ns, drive.base_sps, drive.rate_spmss, Shape.CONSTANT)
        if task.kind is not Kind.INDEX:
            task.model = halt
            return
        task.model = creep(model, now_ns, drive.base_sps, drive.rate_spmss, Shape.CONSTANT)
        assert halt.end_ns is not None
        while self.master.now_ns < halt.end_ns and not self.cut:
            yield from self._read_all()
            yield PUBLISH
            if not self.busy:
                return
        if not self.cut:
            yield from self._command(Code.STOP_MOTION)
            self.busy = True
            while self.busy:
                yield from self._read_status()
            yield from self._read_position()

    def _cut_meanwhile(self) -> bool:
        """Whether a hard stop was wanted while what was read was looked at."""
        return self.cut

    def _conclude(self, task: Task, began_at: int) -> Talk:
        """The controller stands still: show why, before the motion counts as over."""
        if task.registers and task.marked:
            yield from self._mark(False)
        if task.kind is Kind.SLEW and self.limit_side and not (task.stopping or task.marked):
            self.limit_side = task.direction
        if task.kind is Kind.INDEX and not task.stopping:
            self.stopped_short = self.position != began_at + task.direction * task.steps
        yield PUBLISH
        if not self._cut_meanwhile():
            self.task = None
            if task.following is not None:
                self.tasks.insert(0, task.following)
            yield PUBLISH
