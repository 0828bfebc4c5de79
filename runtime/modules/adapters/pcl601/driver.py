"""The driver of a PCL601; it makes one exchange at a time.

configure   stop a program, clear errors, stop, functions off, current on, position := BIAS
idle        status, position, inputs, repeated
motion      changed parameters, the start, then as idle until its end
"""

from __future__ import annotations

from collections.abc import Callable, Generator

from pymodbus.pdu import ModbusPDU
from scanrack.io_images.pcl601 import CAUSES, NO_ERROR, Code, Error, Register
from typing_extensions import override

from ....kinematics import Shape, change_speed, creep
from ....line import pcl601_ascii as ascii
from ....line import pcl601_frames as frames
from ....line import pcl601_pdus as pdus
from ....line.master import PUBLISH, LineRequest, LineTiming, Reply, Step
from ..exchanges import BIAS, LinkLostError, Talk
from ..profile_driver import ProfileDriver, planned_end, planned_stop
from ..task import Task, TaskKind
from .errors import ERRORS
from .pcl601_options import Pcl601Options
from .units import Drive

LINE_TIMING = LineTiming(frames.LINE_FORMAT, gap_ns=1_010_000, patience_ns=50_000_000)
"""The gap is slightly longer than 3.5 characters; a reply may take 50 ms [adapters, timeouts]."""

STARTS = {TaskKind.INDEX: Code.GO, TaskKind.SLEW: Code.GO_SLEW, TaskKind.HOME: Code.HOME_TYPE_1}

MARK_OUTPUT = 7
"""Output that is wired to input 2, to set the mark of a registration move."""

PROXIMITY_OUTPUT = 6
"""Output that option proximity wires to both soft limits, to slow homing down."""

MARKS = {TaskKind.SLEW: MARK_OUTPUT, TaskKind.HOME: PROXIMITY_OUTPUT}
"""The output that sets the mark, by kind of motion."""

FUNCTIONS_OFF = (0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0)
"""4x21 to 4x31: all functions off, encoder ratio 1."""

ESTOP_INPUT = 1 << 3
CAPTURE_INPUT = 1 << 4
HARD_LIMIT = 1 << 6
BOTH_SIDES = 2
"""Value of `Pcl601Driver.limit_side`: a limit is on, but its side is unknown."""


class Pcl601Driver(ProfileDriver[Drive]):
    """The driver of a PCL601.

    Attributes:
        encoder: the encoder count, as last read.
        inputs: the input register, as last read.
        errors: the error bits, as last read.
        limit_side: the active hard limit: +1, -1, 0 for none, or `BOTH_SIDES`.
        direction: direction of the last motion, 0 before the first.
        clear_errors: a request to clear the error bits.
        clear_encoder: a request to set the encoder to 0.
        estop_on_limits: an active input 4 also activates both hard limits.
        has_proximity: the proximity's output slows homing, and the home switch ends it.
        captures_encoder: the capture input captures the encoder count instead of the position.
        polls_marks: a registration move stops after a read of its input, and then makes the remaining steps.
    """

    def __init__(self, options: Pcl601Options, unit: int = 1) -> None:
        super().__init__(LINE_TIMING)
        self.unit = unit
        # read from the device
        self.encoder = self.inputs = 0
        self.errors = NO_ERROR
        self.limit_side = 0
        self.direction = 0
        # requested by the axis
        self.clear_errors = False
        self.clear_encoder = False
        self.estop_on_limits = False
        self.has_proximity = False
        self.captures_encoder = False
        self.polls_marks = False
        # known of the device
        self._outputs = (MARK_OUTPUT, PROXIMITY_OUTPUT) if options.proximity == "jumper" else (MARK_OUTPUT,)
        self._maybe_on = set(self._outputs)  # outputs that are not known to be off
        self._written: dict[Register, tuple[int, ...]] = {}  # words of each block, by its first register
        self._disobeys = False
        self._takes_over = options.takeover

    # -- exchanges ----------------------------------------------------------------------------

    def _request(self, pdu: ModbusPDU) -> LineRequest:
        return frames.request(self.unit, pdu)

    def _insist(self, pdu: ModbusPDU) -> Generator[Step, Reply | None, Reply]:
        return self.insist(self._request(pdu))

    @override
    def identify(self) -> LineRequest:
        return self._request(pdus.report_id())

    @override
    def restore_protocol(self) -> Talk:
        """Switch a device back from AA ASCII to Modbus; in AA ASCII it ignores Modbus."""
        if (yield ascii.ask_address(self.unit)) is not None:
            self.findings.complain(0, "the device used AA ASCII, and is switched back to Modbus")
            yield ascii.back_to_modbus(self.unit)

    @override
    def forget(self) -> None:
        self._written.clear()
        self.clear_errors = self.clear_encoder = False

    @override
    def pending_exchange(self) -> Talk | None:
        if self.clear_errors:
            return self._clear_errors()
        return self._clear_encoder() if self.clear_encoder else None

    def _clear_errors(self) -> Talk:
        yield from self._command(Code.CLEAR_ERRORS)
        self.clear_errors = False
        self.errors = NO_ERROR

    def _clear_encoder(self) -> Talk:
        yield from self._command(Code.ENCODER_RESET)
        self.clear_encoder = False
        self.encoder = 0

    def _write_changed(self, first: Register, *words: int) -> Talk:
        """Write a block of registers, unless the device already has these words."""
        if self._written.get(first) == words:
            return
        reply = yield from self._insist(pdus.write_registers(first, words))
        if reply.refused is not None:  # a program runs, or another master moves the axis: stop both
            yield from self._command(Code.STOP_MOTION)
            reply = yield from self._insist(pdus.write_registers(first, words))
            if reply.refused is not None:
                self._note_disobedience()
                raise LinkLostError
        self._written[first] = words

    def _command(self, code: Code) -> Talk:
        yield from self._insist(pdus.command(code))

    @override
    def stop(self) -> Talk:
        """Stop motion, and a program if one runs."""
        yield from self._command(Code.STOP_MOTION)

    @override
    def halt(self) -> Talk:
        """Stop at once, and clear every mark; before a configuration, also stop a program."""
        if not self._was_ready and not (yield from self.take_control()):
            raise LinkLostError
        yield from super().halt()
        yield from self._clear_marks()

    def _clear_marks(self) -> Talk:
        """Switch off the outputs that may be on; if the device refuses, an output may stay on."""
        for output in self._outputs:
            if output in self._maybe_on:
                reply = yield from self._insist(pdus.write_output(output, False))
                if reply.refused is None:
                    self._maybe_on.discard(output)

    # -- its stored program --------------------------------------------------------------

    @override
    def take_control(self) -> Generator[Step, Reply | None, bool]:
        """Stop a program that runs in the device; return whether the device obeys.

        While a program runs, the device refuses writes of outputs.
        """
        self._maybe_on.update(self._outputs)
        yield from self._clear_marks()
        if not self._maybe_on:
            return True
        yield from self._command(Code.STOP_MOTION)
        yield from self._clear_marks()
        if self._maybe_on:
            self._note_disobedience()
            return False
        self.findings.complain(0, "a program was running in the device, and was stopped")
        self._disobeys = False
        if self._takes_over:
            yield from self._command(Code.AUTORUN_OFF)
        yield from self._clear_errors()  # the refused writes have set errors
        return True

    def _note_disobedience(self) -> None:
        """Complain once, and not again until the device has obeyed."""
        if not self._disobeys:
            self._disobeys = True
            self.findings.complain(0, "the device refuses writes, even after a stop")

    # -- reading ------------------------------------------------------------------------------

    @override
    def read_status(self) -> Talk:
        """Read encoder, busy and errors; complain about new error bits."""
        reply = yield from self._insist(pdus.read_registers(Register.ENCODER_POSITION, 5))
        low_word, high_word, _, busy, errors = reply.words
        self.encoder, self.busy = pdus.signed_pair(low_word, high_word), bool(busy)
        new_errors, self.errors = Error(errors) & ~self.errors, Error(errors)
        for error, bits in ERRORS.items():
            if error & new_errors:
                self.findings.complain(bits, CAUSES[error])

    @override
    def ask_position(self) -> Generator[Step, Reply | None, int]:
        reply = yield from self._insist(pdus.read_registers(Register.POSITION, 2))
        return pdus.signed_pair(*reply.words)

    @override
    def write_position(self, position: int) -> Talk:
        self._written.pop(Register.POSITION, None)
        yield from self._write_changed(Register.POSITION, *pdus.low_high(position))

    @override
    def read_inputs(self) -> Talk:
        """Read the input register, and determine the side of a hard limit."""
        reply = yield from self._insist(pdus.read_input_register())
        (inputs,) = reply.words
        if self._begins_to_capture(inputs):  # the count is read before the image shows the input
            yield from (self.read_status() if self.captures_encoder else self.read_position())
        self.inputs = inputs
        diodes_conduct = self.estop_on_limits and self.inputs & ESTOP_INPUT
        if diodes_conduct or not self.inputs & HARD_LIMIT:
            self.limit_side = 0
        elif self.limit_side in (0, BOTH_SIDES):
            yield from self._determine_limit_side()

    def _begins_to_capture(self, inputs: int) -> bool:
        """Return whether the capture input has become active since the last read."""
        changed_bit = (inputs ^ self.inputs) & CAPTURE_INPUT
        return bool(changed_bit) and bool(inputs & CAPTURE_INPUT) is self.capture_level

    @property
    @override
    def cycle(self) -> tuple[Callable[[], Talk], ...]:
        """Return the reads of a poll; the inputs are read twice so that no 20 ms pulse is missed."""
        return self.read_status, self._read_inputs_early, self.read_position, self.read_inputs

    def _read_inputs_early(self) -> Talk:
        inputs_before = self.inputs
        yield from self.read_inputs()
        if self.inputs != inputs_before:
            yield PUBLISH

    def _determine_limit_side(self) -> Talk:
        """Determine the side of the active limit; a limit stops only motions toward it.

        An index of one step ends before the next read, so it reveals no limit that was already active.
        """
        task, is_new = self.task, self.limit_side == 0
        if task is not None and task.model is not None and (is_new or task.kind is not TaskKind.INDEX):
            yield from self.read_status()
            self.limit_side = self._side_revealed_by(task)
        elif is_new:
            self.limit_side = self.direction or BOTH_SIDES

    def _side_revealed_by(self, task: Task[Drive]) -> int:
        """Return the limit's side: behind a motion that continues, or ahead of a stopped motion.

        A stop for a change of speed reveals nothing; the next motion does.
        """
        if self.busy:
            return -self.direction
        return BOTH_SIDES if task.stopping and task.following is not None else self.direction

    # -- configuration ------------------------------------------------------------------------

    @override
    def configure(self) -> Talk:
        """Clear errors, stop, switch functions off and the current on, and set the counter to `BIAS`."""
        yield from self._insist(pdus.report_id())
        yield from self.read_status()
        if self.errors:
            yield from self._clear_errors()
        yield from self.halt()
        yield from self._write_changed(Register.ANALOG_ENABLE, 0, 1)
        yield from self._write_changed(Register.INDEX_ON_FLY, *FUNCTIONS_OFF)
        self._written[Register.INDEX_ON_FLY] = FUNCTIONS_OFF[:1]  # motions write this register alone
        yield from self.rebase(BIAS)

    # -- motions ------------------------------------------------------------------------------

    @override
    def carry_out(self, task: Task[Drive]) -> Talk:
        """Write the parameters of a motion, start it, and wait for its end."""
        yield from self.keep_counter_in_range(task)
        yield from self._write_parameters(task)
        start_position = self.position
        if not (self.cut or task.stopping):
            self.direction = task.direction
            yield from self.start(task, self._request(pdus.command(self._start_code(task))))
            yield from self.accompany(task)
        if not self.cut:
            yield from self._finish(task, start_position)
            yield from self.conclude(task, start_position)

    def _start_code(self, task: Task[Drive]) -> Code:
        """Return the command code that starts a motion; homing with a proximity has its own type."""
        if task.kind is TaskKind.HOME and self.has_proximity:
            return Code.HOME_TYPE_0
        return STARTS[task.kind]

    def _write_parameters(self, task: Task[Drive]) -> Talk:
        """Write a motion's parameters: mark input, steps if it counts them, speeds and direction.

        The block from STEPS contains the block from ACCEL, so a write of one outdates the other.
        """
        counts_from_mark = task.registers and not self.polls_marks
        yield from self._write_changed(Register.INDEX_ON_FLY, int(counts_from_mark))
        drive = task.drive
        max_speed = jog_speed = drive.max_sps
        direction = int(task.direction > 0)
        words_from_accel = *pdus.low_high(drive.accel_sps2), drive.base_sps, max_speed, jog_speed, direction
        if task.kind is TaskKind.INDEX or counts_from_mark:
            self._written.pop(Register.ACCEL, None)
            yield from self._write_changed(Register.STEPS, *pdus.low_high(task.steps), *words_from_accel)
        else:
            self._written.pop(Register.STEPS, None)
            yield from self._write_changed(Register.ACCEL, *words_from_accel)

    @override
    def set_mark(self, task: Task[Drive]) -> Talk:
        """Set the mark from which a registration move counts its steps, or homing slows down."""
        if task.kind is TaskKind.SLEW and self.polls_marks:
            yield from self.stop_and_index(task)
            return
        if task.model is not None and task.model.end_ns is None:
            drive, now_ns = task.drive, self.master.now_ns
            if task.kind is TaskKind.HOME:
                rate = drive.rate_spmss
                task.model = change_speed(task.model, now_ns, drive.base_sps, rate, rate, Shape.CONSTANT)
            else:
                task.model = planned_end(task, now_ns)
        output = MARKS[task.kind]
        self._maybe_on.add(output)
        yield from self._insist(pdus.write_output(output, True))

    @override
    def slow_down(self, task: Task[Drive]) -> Talk:
        """Stop with a ramp; a slew ends by itself, but an index must be stopped at its base speed."""
        yield from self._command(Code.STOP_SOFT)
        drive, now_ns, model = task.drive, self.master.now_ns, task.model
        assert model is not None
        halt = planned_stop(task, now_ns)
        if task.kind is not TaskKind.INDEX:
            task.model = halt
            return
        task.model = creep(model, now_ns, drive.base_sps, drive.rate_spmss, Shape.CONSTANT)
        assert halt.end_ns is not None
        while self.master.now_ns < halt.end_ns and not self.cut:
            yield from self.read_all()
            yield PUBLISH
            if not self.busy:
                return
        if not self.cut:
            yield from self.stop_and_read_status()

    def _finish(self, task: Task[Drive], start_position: int) -> Talk:
        """Clear the mark; an active limit that ended a slew, or blocked a search, is ahead of the motion."""
        yield from self._clear_marks()
        slew_was_ended = task.kind is TaskKind.SLEW and not (task.stopping or task.marked)
        search_was_blocked = task.kind is TaskKind.HOME and self.position == start_position
        if self.limit_side and (slew_was_ended or search_was_blocked):
            self.limit_side = task.direction
