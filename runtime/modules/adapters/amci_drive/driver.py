"""The driver of a networked drive: ten words out and ten words in, exchange after exchange.

    out     words A    words A    words B    words B    ...      function 23
    in      before A   after A    after A    after B

Changed words are sent, and their answer is read, at once; otherwise rpi_ms pass between exchanges. An
answer has the data from before its own write, so the input words are valid for a command from the second
exchange with it on. A bit that stays on makes no second edge: any exchange may be repeated, even a start.

    configure   stop, configuration mode, command mode with the driver enabled, position := B
    idle        no command bit
    motion      the command bit, until a reply shows the end
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from scanrack.io_images.amci3601 import Configuration, StatusMsw
from scanrack.io_images.drives.bits import CommandBit, InputFunction, Modifier, Settings, StatusBit
from scanrack.io_images.drives.configuration import ROLES
from scanrack.io_images.drives.models import WORDS
from scanrack.io_images.number_formats import NumberFormat
from typing_extensions import override

from ....kinematics import blend as plan_blend
from ....kinematics import change_speed
from ....line import drive_frames as frames
from ....line.master import PUBLISH, LinePause, LineRequest, LineTiming, Reply, Step
from ....line.wire import LineFormat
from ..exchanges import BIAS, LinkLostError, PowerLostError, Talk
from ..profile_driver import ProfileDriver, planned_end, planned_stop
from ..task import Task, TaskKind
from .amci_drive_options import AmciDriveOptions
from .units import DriveProfile, segments_of

LINE_FORMAT = LineFormat(100_000_000)
"""Ethernet has no characters: this format only makes the bytes take no time."""

LINE_TIMING = LineTiming(LINE_FORMAT, gap_ns=0, patience_ns=100_000_000)

NS_PER_MS = 1_000_000
STARTS = {
    TaskKind.INDEX: (CommandBit.RELATIVE_MOVE, CommandBit.RELATIVE_MOVE),
    TaskKind.SLEW: (CommandBit.JOG_CW, CommandBit.JOG_CCW),
    TaskKind.HOME: (CommandBit.FIND_HOME_CW, CommandBit.FIND_HOME_CCW),
}
"""The command of a motion, CW and CCW."""

RESETTABLE = (
    StatusBit.COMMAND_ERROR | StatusBit.INPUT_ERROR | StatusBit.INVALID_JOG_CHANGE | StatusBit.STALL_DETECTED
)
"""Errors that Reset Errors clears before a motion; COMMAND_ERROR refuses it [17 p. 82]."""

FAILED = StatusBit.INPUT_ERROR | StatusBit.COMMAND_ERROR | StatusBit.DRIVER_FAULT | StatusBit.STALL_DETECTED

UNFIT = StatusBit.DRIVER_FAULT | StatusBit.CONFIG_ERROR

COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
POSITION_INVALID = StatusMsw.POSITION_INVALID.value

COMPLAINTS: dict[StatusBit, tuple[int, str]] = {
    StatusBit.COMMAND_ERROR: (COMMAND_ERROR, "the drive has refused a command"),
    StatusBit.INVALID_JOG_CHANGE: (COMMAND_ERROR, "the drive has refused a change of speed"),
    StatusBit.DRIVER_FAULT: (
        POSITION_INVALID,
        "the drive reports a fault of its driver, and the motor is off",
    ),
    StatusBit.STALL_DETECTED: (POSITION_INVALID, "the motor has stalled"),
    StatusBit.TEMPERATURE_90C: (0, "the drive is hotter than 90 degC"),
    StatusBit.CONNECTION_LOST: (0, "the drive has lost its connection meanwhile"),
    StatusBit.ENCODER_ERROR: (0, "the drive reports an error of its encoder"),
}
"""Error bits of the drive with the 3601's bits for them; input errors appear at the inputs."""

FUNCTIONS = {role: function for function, role in ROLES.items()}
"""The drive's function of an input of the 3601."""

LOOKS = 3
"""Number of ignored images in which the drive rests without reporting the end of the motion."""

HANDSHAKES_MAX = 50
"""Maximum exchanges until a drive answers a handshake bit."""

CONFIGURES = CommandBit.MODE_CONFIG.value
ENABLED = Modifier.ENABLE_DRIVER.value
IDLE = (0, ENABLED, *(0,) * (WORDS - 2))

Words = tuple[int, ...]


class AmciDriver(ProfileDriver[DriveProfile]):
    """The driver's view of a networked drive.

    Attributes:
        status: the status bits that were read last.
        encoder: the encoder count that was read last.
        late: exchanges that took longer than the RPI, including exchanges without an answer.
        changed: new values for the running jog are requested.
        minimum: minimum distance of the registration move that begins.
        found_home: whether the last search has ended at home.
        clear_errors: a request to reset the drive's errors.

    Args:
        options: axis, wiring and motor.
    """

    def __init__(self, options: AmciDriveOptions, unit: int = 1) -> None:
        super().__init__(LINE_TIMING)
        self.unit = unit
        self.status = StatusBit(0)
        self.encoder = 0
        self.late = 0
        self.changed = self.clear_errors = self.found_home = False
        self.minimum = 0
        self._options = options
        self._rpi_ns = NS_PER_MS * options.rpi_ms
        self._configuration: Words = (0,) * WORDS
        self._inverted = 0
        self._start_sps = 1
        self._transaction = 0
        self._due_ns = 0
        self._words = IDLE
        self._taken: Words | None = None  # words written by the last answered exchange
        self._fresh = False  # the last image follows the words in force, and is still unprocessed
        self._counter = 0
        self._unseen = self._began_at = 0  # images at rest still to be ignored; start of the motion
        self._holds = False  # a refused Hold is ignored: the move has already ended
        self._refuses = False

    def note_configuration(self, configuration: Configuration) -> None:
        """Build the drive's configuration: functions and levels of its inputs, encoder, starting speed."""
        options, bits, high_inputs = self._options, 0, 0
        for index, role in enumerate(options.wired):
            is_used = role & configuration.inputs_used
            function = FUNCTIONS[role] if is_used else InputFunction.GENERAL_PURPOSE
            bits |= function << 3 * index
            if not is_used or configuration.active_high & role:
                high_inputs |= 1 << index
        if configuration.quadrature_encoder:
            bits |= Settings.USE_ENCODER.value
        self._inverted = 3 & ~high_inputs
        self._start_sps = configuration.starting_speed
        self._configuration = (
            bits | CONFIGURES,
            high_inputs,
            *divmod(self._start_sps, 1000),
            options.steps_per_turn,
            0,
            options.counts_per_turn if configuration.quadrature_encoder else 0,
            options.idle_percent,
            options.current,
            0,
        )

    @property
    def levels(self) -> int:
        """Electrical levels of inputs 1 and 2 as last read, bits 0 and 1."""
        return (self.status >> 16 & 3) ^ self._inverted

    # -- exchanges ----------------------------------------------------------------------------

    @override
    def identify(self) -> LineRequest:
        return self._question(None)

    def _question(self, words: Sequence[int] | None) -> LineRequest:
        self._transaction = self._transaction + 1 & 0xFFFF
        if words is None:
            return frames.read(self.unit, self._transaction, self._options.axis)
        return frames.exchange(self.unit, self._transaction, self._options.axis, words)

    def _exchange(self, words: Words | None) -> Talk:
        """Make an exchange, until it is answered; None writes nothing."""
        while True:
            began_ns = self.master.now_ns
            self._due_ns = began_ns + self._rpi_ns
            reply = yield from self.ask(self._question(words))
            self.master.expect_nothing_late()  # an answer identifies its request
            if reply is None or self.master.now_ns > self._due_ns:
                self._note_late()
            if reply is not None:
                break
        if reply.refused is not None:
            if not self._refuses:
                self.findings.complain(0, f"the drive refuses its registers with exception {reply.refused}")
            self._refuses = True
            raise LinkLostError
        self._refuses = False
        was_configuring = self._taken is not None and bool(self._taken[0] & CONFIGURES)
        if words is not None:
            self._taken = words
        if not was_configuring:
            self._note(reply.words)

    def _note_late(self) -> None:
        """Count a late exchange; report the 1st, the 10th, the 100th and so on."""
        self.late += 1
        if str(self.late).strip("0") == "1":
            exchanges = "exchange has" if self.late == 1 else "exchanges have"
            self.findings.complain(
                0, f"{self.late} {exchanges} taken longer than the RPI of {self._options.rpi_ms} ms"
            )

    def _note(self, words: Words) -> None:
        """Read the ten words of the drive in command mode."""
        if words[0] & CONFIGURES:
            return
        status = StatusBit(words[0] | words[1] << 16)
        new_bits, self.status = status & ~self.status, status
        position = NumberFormat.THOUSANDS.join(words[2], words[3])
        encoder = NumberFormat.THOUSANDS.join(words[4], words[5])
        self._counter = self._counter if position is None else position
        self.encoder = self.encoder if encoder is None else encoder
        self.busy = not status & StatusBit.STOPPED
        if self.busy:
            self._unseen = 0
        self.unfit = bool(status & UNFIT) and self._was_ready
        if self._was_ready and status & StatusBit.CONFIG_ERROR:
            raise PowerLostError
        if self._holds or status & StatusBit.CONFIG_ERROR:  # without a configuration it refuses all commands
            new_bits &= ~StatusBit.COMMAND_ERROR
        for bit, (bits, text) in COMPLAINTS.items():
            if new_bits & bit:
                self.findings.complain(bits, text)

    def _put(self, words: Words) -> Talk:
        """Write words, and read the drive's answer to them; a bit that is already on is given an edge."""
        self._words = words
        if self._taken is not None and self._taken != words and self._taken[0] & words[0] & ~CONFIGURES:
            yield from self._exchange(IDLE)
        yield from self._refresh()

    def _keep(self, words: Words) -> Talk:
        """Write changed words whose command bit stays on, and read the answer."""
        self._words = words
        yield from self._refresh()

    def _refresh(self) -> Talk:
        """Read the input words that follow the output words in force."""
        if not (self._was_ready or self.setup):
            yield from self._poll(None)  # nothing is written before a configuration
        elif self._taken != self._words:
            yield from self._exchange(self._words)
            yield from self._exchange(self._words)
            self._fresh = True
        else:
            yield from self._poll(self._words)

    def _poll(self, words: Words | None) -> Talk:
        """Make an exchange that changes nothing, when the next one is due."""
        yield LinePause(max(0, self._due_ns - self.master.now_ns))
        yield from self._exchange(words)

    @override
    def wake_for_requests(self) -> None:
        task = self.task
        if self.has_work() or self.changed or (task is not None and (task.stopping or task.marked)):
            self.master.wake()

    @override
    def forget(self) -> None:
        self._taken = None
        self._fresh = False
        self._words = IDLE
        self._zeroing = self._holds = self.changed = self.clear_errors = False

    @override
    def pending_exchange(self) -> Talk | None:
        return self._reset_errors() if self.clear_errors else None

    def _reset_errors(self) -> Talk:
        self.clear_errors = False
        yield from self._put((CommandBit.RESET_ERRORS.value, *IDLE[1:]))
        yield from self._put(IDLE)

    @override
    def stop(self) -> Talk:
        """Stop at once; the bit gets an edge each time."""
        if self._taken is None or self.setup or not self._was_ready:
            yield from self._exchange(IDLE)  # the words in force there are unknown
        yield from self._put((CommandBit.IMMEDIATE_STOP.value, *IDLE[1:]))

    # -- reading ------------------------------------------------------------------------------

    @override
    def read_status(self) -> Talk:
        """Read the image, unless the image after the last command is still unprocessed."""
        is_fresh, self._fresh = self._fresh, False
        if not is_fresh or self._taken != self._words:
            yield from self._refresh()
            self._fresh = False

    @override
    def ask_position(self) -> Generator[Step, Reply | None, int]:
        """Return the counter of the last image, whose status, position and inputs are simultaneous."""
        yield from ()
        return self._counter

    @override
    def read_inputs(self) -> Talk:
        """Do nothing: the inputs are part of the image."""
        yield from ()

    @property
    @override
    def cycle(self) -> tuple[Callable[[], Talk], ...]:
        return self.read_status, self.read_position

    @override
    def write_position(self, position: int) -> Talk:
        upper, lower = NumberFormat.THOUSANDS.split(position)
        preset = (CommandBit.PRESET_POSITION.value, ENABLED, upper & 0xFFFF, lower & 0xFFFF, *IDLE[4:])
        yield from self._put(preset)
        self._words = IDLE

    # -- configuration ------------------------------------------------------------------------

    @override
    def configure(self) -> Talk:
        """Stop, write the configuration, enable the driver, set the counter to B."""
        yield from self.halt()
        yield from self._exchange(self._configuration)
        yield from self._put(IDLE)
        if self.status & StatusBit.CONFIG_ERROR:
            text = "the drive has refused its configuration"
            self.findings.complain(StatusMsw.CONFIG_ERROR.value, text)
            raise LinkLostError
        if self.status & RESETTABLE:
            yield from self._reset_errors()
        yield from self.rebase(BIAS)

    # -- motions ------------------------------------------------------------------------------

    @override
    def carry_out(self, task: Task[DriveProfile]) -> Talk:
        if self.status & RESETTABLE:
            yield from self._reset_errors()
        yield from self.make_room(task)
        program = task.drive.program
        is_stored = program is None or (yield from self._store(task.drive))
        began_at = self.position
        if is_stored and not (self.cut or task.stopping):
            self._zeroing, self.found_home = task.kind is TaskKind.HOME, False
            self._unseen, self._began_at = LOOKS, began_at
            yield from self._put(self._words_of(task))
            self.model(task)
            yield from self.accompany(task)
        if not self.cut:
            yield from self._find_zero(task)
            yield from self.conclude(task, began_at)
        self._zeroing = self._holds = self.changed = False
        if not self.cut:
            self._words = IDLE

    def _words_of(self, task: Task[DriveProfile]) -> Words:
        """Return the words that start a motion."""
        drive = task.drive
        if drive.program is not None:
            backward = Modifier.REVERSE_BLEND.value if task.direction < 0 else 0
            return (CommandBit.RUN_ASSEMBLED_MOVE.value, ENABLED | backward, *IDLE[2:])
        command = STARTS[task.kind][task.direction < 0]
        steps = task.direction * task.steps if task.kind is TaskKind.INDEX else task.steps
        modifiers = ENABLED | (Modifier.REGISTRATION_MOVE.value if task.registers else 0)
        last_words = NumberFormat.THOUSANDS.split(self.minimum) if task.registers else (0, drive.jerk)
        return _command(
            command, modifiers, steps, (drive.max_sps, drive.acceleration, drive.deceleration), last_words
        )

    def _store(self, drive: DriveProfile) -> Generator[Step, Reply | None, bool]:
        """Store the segments of a blend move in the drive; return whether the drive accepted them."""
        assert drive.program is not None
        programs = CommandBit.PROGRAM_ASSEMBLED
        yield from self._put(_command(programs, ENABLED, 0, (0, 0, 0), (0, 0)))
        is_ready = yield from self._wait_for(StatusBit.WAITING_FOR_SEGMENT, on=True)
        for steps, *values in segments_of(drive.program, drive.start_sps):
            for bits, waits in ((programs | CommandBit.READ_ASSEMBLED_DATA, False), (programs, True)):
                if is_ready and not self.cut:
                    yield from self._keep(_command(bits, ENABLED, steps, values, (0, 0)))
                    is_ready = yield from self._wait_for(StatusBit.WAITING_FOR_SEGMENT, on=waits)
        yield from self._keep(IDLE)
        if not is_ready and not self.status & StatusBit.COMMAND_ERROR:
            self.findings.complain(COMMAND_ERROR, "the drive does not take the segments of a blend move")
        return is_ready

    def _wait_for(self, bit: StatusBit, *, on: bool) -> Generator[Step, Reply | None, bool]:
        """Wait for a bit of a handshake; return whether it came."""
        for _ in range(HANDSHAKES_MAX):
            if self.status & StatusBit.COMMAND_ERROR or self.cut:
                return False
            if bool(self.status & bit) is on:
                return True
            yield from self._refresh()
        return False

    @override
    def model(self, task: Task[DriveProfile]) -> None:
        now_ns, start_sps, program = self.master.now_ns, task.drive.start_sps, task.drive.program
        if program is None:
            super().model(task)
        else:
            legs, final_rate, shape = program.segments, program.final_deceleration, program.final_shape
            task.model = plan_blend(now_ns, 0, task.direction, start_sps, legs, final_rate, shape)

    @override
    def watch(self, task: Task[DriveProfile]) -> Talk:
        """Change the speed of a jog on request; note the end of the counter's range."""
        if self.changed:
            self.changed = False
            drive, now_ns = task.drive, self.master.now_ns
            yield from self._keep(self._words_of(task))
            if task.model is not None:
                profile = drive.profile
                rates = profile.acceleration_spmss, profile.deceleration_spmss
                task.model = change_speed(task.model, now_ns, drive.max_sps, *rates, profile.shape)
            self.busy = True  # the image that ends the jog follows the change
        if not self.busy and self._unseen:
            self._unseen -= 1
            self.busy = not self._shows_an_end(task)
        yield from super().watch(task)
        if task.kind is TaskKind.HOME and not self.busy and not self.status & (StatusBit.AT_HOME | FAILED):
            self.busy = not (yield from self._rests_long())

    def _shows_an_end(self, task: Task[DriveProfile]) -> bool:
        """Whether a drive at rest has processed the start, which it may do after its answer."""
        has_moved = self.position != self._began_at
        has_ended = self.status & FAILED or task.stopping or task.marked
        return bool(has_ended) or (task.kind is not TaskKind.INDEX and has_moved) or self._is_there(task)

    def _is_there(self, task: Task[DriveProfile]) -> bool:
        return task.kind is TaskKind.INDEX and self.position == self._began_at + task.direction * task.steps

    def _rests_long(self) -> Generator[Step, Reply | None, bool]:
        """Whether a search without a result has ended: a search pauses where it reverses."""
        counter_before = self._counter
        for _ in range(HANDSHAKES_MAX):
            yield from self._refresh()
            if (
                self.cut
                or self.busy
                or self._counter != counter_before
                or self.status & (StatusBit.AT_HOME | FAILED)
            ):
                return False
        return True

    @override
    def slow_down(self, task: Task[DriveProfile]) -> Talk:
        """Release a jog; hold a move until it is at rest; stop any other motion without a ramp."""
        if task.kind is TaskKind.SLEW and not task.registers:
            yield from self._keep(IDLE)
            if task.model is not None:
                task.model = planned_stop(task, self.master.now_ns)
        elif task.kind is TaskKind.INDEX:
            self._holds = True
            yield from self._put((CommandBit.HOLD_MOVE.value, *self._words_of(task)[1:]))
            while not self.cut and not (yield from self.rest()):
                yield from self.read_position()
                yield PUBLISH
        else:
            yield from self.stop_and_read_status()
            text = "the drive can't slow this motion down, and has been stopped without a ramp"
            self.findings.complain(POSITION_INVALID, text)

    @override
    def set_mark(self, task: Task[DriveProfile]) -> Talk:
        """Release the bit of a registration move: its steps count from then, or from an earlier input."""
        words = self._words_of(task)
        yield from self._keep((0, *words[1:]))
        if task.model is not None and task.model.end_ns is None:
            task.model = planned_end(task, self.master.now_ns)

    def _find_zero(self, task: Task[DriveProfile]) -> Talk:
        """Set the counter to B at home, where the drive has set it to 0."""
        if task.kind is TaskKind.HOME:
            self._zeroing = False
            self.found_home = bool(self.status & StatusBit.AT_HOME)
            if self.found_home:
                self.position = self._counter
                yield from self.rebase(BIAS)


def _command(
    bits: CommandBit, modifiers: int, target: int, values: Sequence[int], last: tuple[int, int]
) -> Words:
    """Return ten words, unsigned.

    Args:
        values: speed in steps/s, acceleration and deceleration in steps/ms/s.
        last: words 8 and 9 of the output.
    """
    speed, *rates = values
    split_number = NumberFormat.THOUSANDS.split
    words = (bits.value, modifiers, *split_number(target), *split_number(speed), *rates, *last)
    return tuple(word & 0xFFFF for word in words)
