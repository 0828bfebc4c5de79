"""The driver of a PCL601: its exchanges, one after the other.

configure   stop a program, clear errors, stop, functions off, current on, position := B
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
"""A gap of 3.5 characters and a little; a reply may take 50 ms [adapters, timeouts]."""

STARTS = {TaskKind.INDEX: Code.GO, TaskKind.SLEW: Code.GO_SLEW, TaskKind.HOME: Code.HOME_TYPE_1}

MARK_OUTPUT = 7
"""Wired to input 2: it sets the mark of a registration move."""

PROXIMITY_OUTPUT = 6
"""By option proximity wired to both soft limits: it slows homing down."""

MARKS = {TaskKind.SLEW: MARK_OUTPUT, TaskKind.HOME: PROXIMITY_OUTPUT}
"""The output that is the mark of a motion."""

FUNCTIONS_OFF = (0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0)
"""4x21 to 4x31: everything off, encoder ratio 1."""

ESTOP_INPUT = 1 << 3
CAPTURE_INPUT = 1 << 4
HARD_LIMIT = 1 << 6
BOTH_SIDES = 2
"""Value of `Pcl601Driver.limit_side`: a limit is on, its side is unknown."""


class Pcl601Driver(ProfileDriver[Drive]):
    """The driver's view of a PCL601.

    Args:
        options: wiring, and whether the controller's own program is kept from restarting.
    """

    def __init__(self, options: Pcl601Options, unit: int = 1) -> None:
        super().__init__(LINE_TIMING)
        self.unit = unit
        self.encoder = self.inputs = 0
        self.errors = NO_ERROR
        self.limit_side = 0  # the active hard limit: +1, -1, 0 for none, `BOTH_SIDES`
        self.direction = 0  # direction of the last motion, 0 before the first
        self.clear_errors = False  # a request to clear the error bits
        self.clear_encoder = False  # a request to set the encoder to 0
        self.estop_on_limits = False  # an active input 4 also activates both hard limits
        self.has_proximity = False  # the proximity's output slows homing, the switch ends it
        self.captures_encoder = False  # capture the encoder's count instead of the position
        self._takes_over = options.takeover
        self.polls_marks = False  # a registration move stops after a read of its input, and indexes the rest
        self._disobeys = False
        self._outputs = (MARK_OUTPUT, PROXIMITY_OUTPUT) if options.proximity == "jumper" else (MARK_OUTPUT,)
        self._maybe_on = set(self._outputs)
        self._written: dict[Register, tuple[int, ...]] = {}

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
        """Bring the controller back from AA ASCII, in which it ignores Modbus."""
        if (yield ascii.ask_address(self.unit)) is not None:
            self.findings.complain(0, "the controller was in AA ASCII, and is sent back to Modbus")
            yield ascii.back_to_modbus(self.unit)

    @override
    def forget(self) -> None:
        """Reset known parameters and requests to clear."""
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

    def _write(self, first: Register, *words: int) -> Talk:
        """Write registers that contain other words."""
        if self._written.get(first) == words:
            return
        reply = yield from self._insist(pdus.write_registers(first, words))
        if reply.refused is not None:  # a program runs, or another master moves the axis: stop both
            yield from self._command(Code.STOP_MOTION)
            reply = yield from self._insist(pdus.write_registers(first, words))
            if reply.refused is not None:
                self._disobeyed()
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
        """Stop at once, and clear every mark; before a configuration a program may run."""
        if not self._was_ready and not (yield from self.admit()):
            raise LinkLostError
        yield from super().halt()
        yield from self._clear_marks()

    def _clear_marks(self) -> Talk:
        """Switch off the outputs that may be on; a refused one may still be on."""
        for output in [output for output in self._outputs if output in self._maybe_on]:
            reply = yield from self._insist(pdus.write_output(output, False))
            if reply.refused is None:
                self._maybe_on.discard(output)

    # -- its stored program --------------------------------------------------------------

    @override
    def admit(self) -> Generator[Step, Reply | None, bool]:
        """Stop a program that runs in the controller; return whether the controller obeys.

        A running program is detected by its refusal to write outputs.
        """
        self._maybe_on.update(self._outputs)
        yield from self._clear_marks()
        if not self._maybe_on:
            return True
        yield from self._command(Code.STOP_MOTION)
        yield from self._clear_marks()
        if self._maybe_on:
            self._disobeyed()
            return False
        self.findings.complain(0, "a program was running in the controller, and has been stopped")
        self._disobeys = False
        if self._takes_over:
            yield from self._command(Code.AUTORUN_OFF)
        yield from self._clear_errors()  # the refused writes have set errors
        return True

    def _disobeyed(self) -> None:
        """Complain once, then not again until the controller has obeyed."""
        if not self._disobeys:
            self._disobeys = True
            self.findings.complain(0, "the controller refuses what is written, and a stop has not helped")

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
        yield from self._write(Register.POSITION, *pdus.low_high(position))

    @override
    def read_inputs(self) -> Talk:
        """Read the input register, and determine the side of a hard limit."""
        reply = yield from self._insist(pdus.read_input_register())
        (inputs,) = reply.words
        if self._begins_to_capture(inputs):
            yield from (self.read_status() if self.captures_encoder else self.read_position())
        self.inputs = inputs
        diodes_conduct = self.estop_on_limits and self.inputs & ESTOP_INPUT
        if diodes_conduct or not self.inputs & HARD_LIMIT:
            self.limit_side = 0
        elif self.limit_side in (0, BOTH_SIDES):
            yield from self._determine_limit_side()

    def _begins_to_capture(self, inputs: int) -> bool:
        """Return whether the capture input becomes active: the value is read before the input is shown."""
        changed_bit = (inputs ^ self.inputs) & CAPTURE_INPUT
        return bool(changed_bit) and bool(inputs & CAPTURE_INPUT) is self.captures

    @property
    @override
    def cycle(self) -> tuple[Callable[[], Talk], ...]:
        """The reads of a poll; inputs twice, so that no pulse of 20 ms is missed."""
        return self.read_status, self._read_inputs_early, self.read_position, self.read_inputs

    def _read_inputs_early(self) -> Talk:
        inputs_before = self.inputs
        yield from self.read_inputs()
        if self.inputs != inputs_before:
            yield PUBLISH

    def _determine_limit_side(self) -> Talk:
        """Determine the side of the active limit: it stops a motion toward it, and no motion away from it.

        An index of one step ends before the next read, and gives no information about an earlier active
        limit.
        """
        task, unheard_of = self.task, self.limit_side == 0
        if task is not None and task.model is not None and (unheard_of or task.kind is not TaskKind.INDEX):
            yield from self.read_status()
            self.limit_side = self._side_by(task)
        elif unheard_of:
            self.limit_side = self.direction or BOTH_SIDES

    def _side_by(self, task: Task[Drive]) -> int:
        """Return the limit that a motion reveals by continuing or stopping.

        A motion that is stopped for another speed always stops; only the next motion reveals the limit.
        """
        if self.busy:
            return -self.direction
        return BOTH_SIDES if task.stopping and task.following is not None else self.direction

    # -- configuration ------------------------------------------------------------------------

    @override
    def configure(self) -> Talk:
        """Clear errors, stop, switch every function off and the current on, set the counter to B."""
        yield from self._insist(pdus.report_id())
        yield from self.read_status()
        if self.errors:
            yield from self._clear_errors()
        yield from self.halt()
        yield from self._write(Register.ANALOG_ENABLE, 0, 1)
        yield from self._write(Register.INDEX_ON_FLY, *FUNCTIONS_OFF)
        self._written[Register.INDEX_ON_FLY] = FUNCTIONS_OFF[:1]
        yield from self.rebase(BIAS)

    # -- motions ------------------------------------------------------------------------------

    @override
    def carry_out(self, task: Task[Drive]) -> Talk:
        yield from self.make_room(task)
        yield from self._write_parameters(task)
        began_at = self.position
        if not (self.cut or task.stopping):
            self.direction = task.direction
            yield from self.start(task, self._request(pdus.command(self._start_of(task))))
            yield from self.accompany(task)
        if not self.cut:
            yield from self._finish(task, began_at)
            yield from self.conclude(task, began_at)

    def _start_of(self, task: Task[Drive]) -> Code:
        if task.kind is TaskKind.HOME and self.has_proximity:
            return Code.HOME_TYPE_0
        return STARTS[task.kind]

    def _write_parameters(self, task: Task[Drive]) -> Talk:
        drive = task.drive
        registers = task.registers and not self.polls_marks
        yield from self._write(Register.INDEX_ON_FLY, int(registers))
        direction = int(task.direction > 0)
        speeds = (*pdus.low_high(drive.accel_sps2), drive.base_sps, drive.max_sps, drive.max_sps)
        if task.kind is TaskKind.INDEX or registers:
            self._written.pop(Register.ACCEL, None)
            yield from self._write(Register.STEPS, *pdus.low_high(task.steps), *speeds, direction)
        else:
            self._written.pop(Register.STEPS, None)
            yield from self._write(Register.ACCEL, *speeds, direction)

    @override
    def set_mark(self, task: Task[Drive]) -> Talk:
        """Set the mark from which a registration move's steps count, or homing slows down."""
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
        """Stop softly: a slew ends by itself, an index creeps and is stopped at its base speed."""
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

    def _finish(self, task: Task[Drive], began_at: int) -> Talk:
        """Clear the mark; a limit that ended a slew, or blocked a search, lies in its direction."""
        yield from self._clear_marks()
        slew_ended = task.kind is TaskKind.SLEW and not (task.stopping or task.marked)
        is_blocked = task.kind is TaskKind.HOME and self.position == began_at
        if self.limit_side and (slew_ended or is_blocked):
            self.limit_side = task.direction
