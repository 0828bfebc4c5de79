"""The driver of a networked drive: ten words out and ten words in, exchange after exchange.

    out     words A    words A    words B    words B    ...      function 23
    in      before A   after A    after A    after B

Changed words are sent immediately, and so is the request that reads their effect; otherwise, exchanges are
rpi_ms apart. A response has the data from before its own write, so only the second exchange with a command
shows its effect. A bit that stays on does not make a second edge, so any exchange may be repeated, even one
that starts a motion.

    configure   stop, configuration mode, command mode with the driver enabled, position := BIAS
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
"""Ethernet has no character times; this baud rate makes bytes take practically no time."""

LINE_TIMING = LineTiming(LINE_FORMAT, gap_ns=0, patience_ns=100_000_000)

NS_PER_MS = 1_000_000
STARTS = {
    TaskKind.INDEX: (CommandBit.RELATIVE_MOVE, CommandBit.RELATIVE_MOVE),
    TaskKind.SLEW: (CommandBit.JOG_CW, CommandBit.JOG_CCW),
    TaskKind.HOME: (CommandBit.FIND_HOME_CW, CommandBit.FIND_HOME_CCW),
}
"""The command bits of each motion, CW and CCW."""

RESETTABLE = (
    StatusBit.COMMAND_ERROR | StatusBit.INPUT_ERROR | StatusBit.INVALID_JOG_CHANGE | StatusBit.STALL_DETECTED
)
"""Errors that Reset Errors clears before a motion; the drive refuses motions during COMMAND_ERROR [17 p.
82]."""

FAILED = StatusBit.INPUT_ERROR | StatusBit.COMMAND_ERROR | StatusBit.DRIVER_FAULT | StatusBit.STALL_DETECTED

UNFIT = StatusBit.DRIVER_FAULT | StatusBit.CONFIG_ERROR

COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
POSITION_INVALID = StatusMsw.POSITION_INVALID.value

COMPLAINTS: dict[StatusBit, tuple[int, str]] = {
    StatusBit.COMMAND_ERROR: (COMMAND_ERROR, "the drive has refused a command"),
    StatusBit.INVALID_JOG_CHANGE: (COMMAND_ERROR, "the drive has refused a change of speed"),
    StatusBit.DRIVER_FAULT: (POSITION_INVALID, "the drive reports a driver fault, and the motor is off"),
    StatusBit.STALL_DETECTED: (POSITION_INVALID, "the motor has stalled"),
    StatusBit.TEMPERATURE_90C: (0, "the drive is hotter than 90 degC"),
    StatusBit.CONNECTION_LOST: (0, "the drive lost its connection for a time"),
    StatusBit.ENCODER_ERROR: (0, "the drive reports an encoder error"),
}
"""The 3601's bits and the text for each drive error; input errors appear at the inputs."""

FUNCTIONS = {role: function for function, role in ROLES.items()}
"""The drive's input function for each input of the 3601."""

IMAGES_IGNORED = 3
"""Number of images at rest that are ignored after a start, unless they show the end of the motion."""

HANDSHAKES_MAX = 50
"""Maximum number of exchanges until a drive changes a handshake bit."""

CONFIGURES = CommandBit.MODE_CONFIG.value
ENABLED = Modifier.ENABLE_DRIVER.value
IDLE = (0, ENABLED, *(0,) * (WORDS - 2))

Words = tuple[int, ...]
"""Ten output or input words, unsigned."""


class AmciDriver(ProfileDriver[DriveProfile]):
    """The driver of a networked drive.

    Attributes:
        status: the status bits as last read.
        encoder: the encoder count as last read.
        late: number of exchanges that took longer than the RPI, including those without a response.
        changed: whether new values for the jog in progress are to be sent.
        minimum: minimum distance of the next registration move, steps.
        found_home: whether the last search for home ended at home.
        clear_errors: whether the drive's errors are to be reset.
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
        # the configuration
        self._configuration: Words = (0,) * WORDS
        self._inverted = 0  # mask of inputs whose status bits are inverted
        self._start_sps = 1
        # the exchanges
        self._transaction = 0
        self._due_ns = 0  # the instant of the next exchange without a change
        self._words = IDLE  # output words in force
        self._last_written: Words | None = None  # words of the last write that the drive answered
        self._fresh = False  # the last image shows the effect of `_words`, and is still unprocessed
        self._refused_registers = False
        # the motion
        self._counter = 0  # the drive's position in the last image
        self._start_position = 0
        self._images_to_ignore = 0  # see `IMAGES_IGNORED`
        self._hold_requested = False  # a refusal of Hold means that the move has already ended

    def note_configuration(self, configuration: Configuration) -> None:
        """Build the drive's configuration: input functions and levels, encoder, starting speed."""
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
        return self._next_request(None)

    def _next_request(self, words: Sequence[int] | None) -> LineRequest:
        """Return an exchange that writes words, or only reads for None, with a new transaction number."""
        self._transaction = self._transaction + 1 & 0xFFFF
        if words is None:
            return frames.read(self.unit, self._transaction, self._options.axis)
        return frames.exchange(self.unit, self._transaction, self._options.axis, words)

    def _exchange(self, words: Words | None) -> Talk:
        """Repeat an exchange until the drive answers, and read the drive's image; None writes nothing."""
        while True:
            self._due_ns = self.master.now_ns + self._rpi_ns
            reply = yield from self.try_once(self._next_request(words))
            self.master.expect_nothing_late()  # a response identifies its request
            if reply is None or self.master.now_ns > self._due_ns:
                self._note_late()
            if reply is not None:
                break
        if reply.refused is not None:
            if not self._refused_registers:
                self.findings.complain(0, f"the drive refuses its registers with exception {reply.refused}")
            self._refused_registers = True
            raise LinkLostError
        self._refused_registers = False
        was_configuring = self._last_written is not None and bool(self._last_written[0] & CONFIGURES)
        if words is not None:
            self._last_written = words
        if not was_configuring:
            self._read_image(reply.words)

    def _note_late(self) -> None:
        """Count a late exchange; report the 1st, the 10th, the 100th and so on."""
        self.late += 1
        is_power_of_ten = str(self.late).strip("0") == "1"
        if is_power_of_ten:
            exchanges = "exchange" if self.late == 1 else "exchanges"
            text = f"{self.late} {exchanges} took longer than the RPI of {self._options.rpi_ms} ms"
            self.findings.complain(0, text)

    def _read_image(self, words: Words) -> None:
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
            self._images_to_ignore = 0
        self.unfit = bool(status & UNFIT) and self._was_ready
        if self._was_ready and status & StatusBit.CONFIG_ERROR:
            raise PowerLostError
        if self._hold_requested or status & StatusBit.CONFIG_ERROR:  # it refuses every command
            new_bits &= ~StatusBit.COMMAND_ERROR
        for bit, (bits, text) in COMPLAINTS.items():
            if new_bits & bit:
                self.findings.complain(bits, text)

    def _write_with_edge(self, words: Words) -> Talk:
        """Write words, and read the image after them; a bit that is already on goes off and on again."""
        self._words = words
        before = self._last_written
        if before is not None and before != words and before[0] & words[0] & ~CONFIGURES:
            yield from self._exchange(IDLE)
        yield from self._refresh()

    def _write_without_edge(self, words: Words) -> Talk:
        """Write words, and read the image after them; a bit that is already on stays on."""
        self._words = words
        yield from self._refresh()

    def _refresh(self) -> Talk:
        """Read an image that shows the effect of the output words in force."""
        if not (self._was_ready or self.setup):
            yield from self._poll(None)  # nothing is written before a configuration
        elif self._last_written != self._words:
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
        self._last_written = None
        self._fresh = False
        self._words = IDLE
        self._zeroing = self._hold_requested = self.changed = self.clear_errors = False

    @override
    def pending_exchange(self) -> Talk | None:
        return self._reset_errors() if self.clear_errors else None

    def _reset_errors(self) -> Talk:
        self.clear_errors = False
        yield from self._write_with_edge((CommandBit.RESET_ERRORS.value, *IDLE[1:]))
        yield from self._write_with_edge(IDLE)

    @override
    def stop(self) -> Talk:
        """Stop immediately; the stop bit makes a new edge each time."""
        if self._last_written is None or self.setup or not self._was_ready:
            yield from self._exchange(IDLE)  # the drive may have any words in force
        yield from self._write_with_edge((CommandBit.IMMEDIATE_STOP.value, *IDLE[1:]))

    # -- reading ------------------------------------------------------------------------------

    @override
    def read_status(self) -> Talk:
        """Read the image, unless the image after the last command is still unprocessed."""
        is_fresh, self._fresh = self._fresh, False
        if not is_fresh or self._last_written != self._words:
            yield from self._refresh()
            self._fresh = False

    @override
    def ask_position(self) -> Generator[Step, Reply | None, int]:
        """Return the counter of the last image; its status, position and inputs are simultaneous."""
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
        yield from self._write_with_edge(preset)
        self._words = IDLE

    # -- configuration ------------------------------------------------------------------------

    @override
    def configure(self) -> Talk:
        """Stop, write the configuration, enable the driver, set the counter to `BIAS`."""
        yield from self.halt()
        yield from self._exchange(self._configuration)
        yield from self._write_with_edge(IDLE)
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
        """Start a motion and wait for its end; a blend move needs its segments in the drive first."""
        if self.status & RESETTABLE:
            yield from self._reset_errors()
        yield from self.keep_counter_in_range(task)
        is_stored = True
        if task.drive.program is not None:
            is_stored = yield from self._store_segments(task.drive)
        start_position = self.position
        if is_stored and not (self.cut or task.stopping):
            self._zeroing, self.found_home = task.kind is TaskKind.HOME, False
            self._images_to_ignore, self._start_position = IMAGES_IGNORED, start_position
            yield from self._write_with_edge(self._start_words(task))
            self.model(task)
            yield from self.accompany(task)
        if not self.cut:
            yield from self._finish_search(task)
            yield from self.conclude(task, start_position)
        self._zeroing = self._hold_requested = self.changed = False
        if not self.cut:
            self._words = IDLE

    def _start_words(self, task: Task[DriveProfile]) -> Words:
        """Return the output words that start a motion."""
        drive = task.drive
        if drive.program is not None:
            backward = Modifier.REVERSE_BLEND.value if task.direction < 0 else 0
            return (CommandBit.RUN_ASSEMBLED_MOVE.value, ENABLED | backward, *IDLE[2:])
        start_cw, start_ccw = STARTS[task.kind]
        command = start_cw if task.direction > 0 else start_ccw
        speed_and_rates = drive.max_sps, drive.acceleration, drive.deceleration
        if task.registers:
            modifiers = ENABLED | Modifier.REGISTRATION_MOVE.value
            minimum_words = NumberFormat.THOUSANDS.split(self.minimum)
            return _command(command, modifiers, task.steps, speed_and_rates, minimum_words)
        steps = task.direction * task.steps if task.kind is TaskKind.INDEX else task.steps
        return _command(command, ENABLED, steps, speed_and_rates, (0, drive.jerk))

    def _store_segments(self, drive: DriveProfile) -> Generator[Step, Reply | None, bool]:
        """Store the segments of a blend move in the drive; return whether the drive accepted them."""
        assert drive.program is not None
        programs = CommandBit.PROGRAM_ASSEMBLED
        yield from self._write_with_edge(_command(programs))
        is_ready = yield from self._await_segment_request(True)
        for steps, *speed_and_rates in segments_of(drive.program, drive.start_sps):
            for bits, is_requesting in ((programs | CommandBit.READ_ASSEMBLED_DATA, False), (programs, True)):
                if is_ready and not self.cut:
                    words = _command(bits, target=steps, speed_and_rates=speed_and_rates)
                    yield from self._write_without_edge(words)
                    is_ready = yield from self._await_segment_request(is_requesting)
        yield from self._write_without_edge(IDLE)
        if not is_ready and not self.status & StatusBit.COMMAND_ERROR:
            self.findings.complain(COMMAND_ERROR, "the drive does not accept the segments of a blend move")
        return is_ready

    def _await_segment_request(self, is_requesting: bool) -> Generator[Step, Reply | None, bool]:
        """Wait until the drive requests a segment or stops requesting one; return whether it did."""
        for _ in range(HANDSHAKES_MAX):
            if self.status & StatusBit.COMMAND_ERROR or self.cut:
                return False
            if bool(self.status & StatusBit.WAITING_FOR_SEGMENT) is is_requesting:
                return True
            yield from self._refresh()
        return False

    @override
    def model(self, task: Task[DriveProfile]) -> None:
        """Plan the motion as the drive makes it, from its start on."""
        now_ns, start_sps, program = self.master.now_ns, task.drive.start_sps, task.drive.program
        if program is None:
            super().model(task)
        else:
            legs, final_rate, shape = program.segments, program.final_deceleration, program.final_shape
            origin = 0  # a model counts steps from the start of its motion
            task.model = plan_blend(now_ns, origin, task.direction, start_sps, legs, final_rate, shape)

    @override
    def watch(self, task: Task[DriveProfile]) -> Talk:
        """Change a jog's speed on request; find out whether a drive at rest has ended the motion."""
        if self.changed:
            self.changed = False
            drive, now_ns = task.drive, self.master.now_ns
            yield from self._write_without_edge(self._start_words(task))
            if task.model is not None:
                profile = drive.profile
                rates = profile.acceleration_spmss, profile.deceleration_spmss
                task.model = change_speed(task.model, now_ns, drive.max_sps, *rates, profile.shape)
            self.busy = True  # the last image is older than the change
        if not self.busy and self._images_to_ignore:
            self._images_to_ignore -= 1
            self.busy = not self._shows_an_end(task)
        yield from super().watch(task)
        if task.kind is TaskKind.HOME and not self.busy and not self.status & (StatusBit.AT_HOME | FAILED):
            self.busy = not (yield from self._stays_at_rest())

    def _shows_an_end(self, task: Task[DriveProfile]) -> bool:
        """Return whether a drive at rest has completed its motion; it may respond before it starts."""
        if self.status & FAILED or task.stopping or task.marked:
            return True
        if task.kind is TaskKind.INDEX:
            return self.position == self._start_position + task.direction * task.steps
        return self.position != self._start_position

    def _stays_at_rest(self) -> Generator[Step, Reply | None, bool]:
        """Return whether a search without a result has ended; a search also pauses where it reverses."""
        counter_before = self._counter
        for _ in range(HANDSHAKES_MAX):
            yield from self._refresh()
            has_result = self.status & (StatusBit.AT_HOME | FAILED)
            if self.cut or self.busy or has_result or self._counter != counter_before:
                return False
        return True

    @override
    def slow_down(self, task: Task[DriveProfile]) -> Talk:
        """Release a jog; hold a move until it is at rest; stop any other motion without a ramp."""
        if task.kind is TaskKind.SLEW and not task.registers:
            yield from self._write_without_edge(IDLE)
            if task.model is not None:
                task.model = planned_stop(task, self.master.now_ns)
        elif task.kind is TaskKind.INDEX:
            self._hold_requested = True
            yield from self._write_with_edge((CommandBit.HOLD_MOVE.value, *self._start_words(task)[1:]))
            while not self.cut and not (yield from self.confirm_standstill()):
                yield from self.read_position()
                yield PUBLISH
        else:
            yield from self.stop_and_read_status()
            text = "the drive can't slow this motion down, and was stopped without a ramp"
            self.findings.complain(POSITION_INVALID, text)

    @override
    def set_mark(self, task: Task[DriveProfile]) -> Talk:
        """Release a registration move's bit; the move counts steps from then or from an earlier input."""
        words = self._start_words(task)
        yield from self._write_without_edge((0, *words[1:]))
        if task.model is not None and task.model.end_ns is None:
            task.model = planned_end(task, self.master.now_ns)

    def _finish_search(self, task: Task[DriveProfile]) -> Talk:
        """After a search, set the counter to `BIAS` at home, where the drive has set it to 0."""
        if task.kind is TaskKind.HOME:
            self._zeroing = False
            self.found_home = bool(self.status & StatusBit.AT_HOME)
            if self.found_home:
                self.position = self._counter
                yield from self.rebase(BIAS)


def _command(
    bits: CommandBit,
    modifiers: int = ENABLED,
    target: int = 0,
    speed_and_rates: Sequence[int] = (0, 0, 0),
    last_words: tuple[int, int] = (0, 0),
) -> Words:
    """Return ten output words, unsigned.

    Args:
        target: position or distance, steps.
        speed_and_rates: speed in steps/s, acceleration and deceleration in steps/ms/s.
        last_words: words 8 and 9.
    """
    speed, *rates = speed_and_rates
    split_number = NumberFormat.THOUSANDS.split
    words = (bits.value, modifiers, *split_number(target), *split_number(speed), *rates, *last_words)
    return tuple(word & 0xFFFF for word in words)
