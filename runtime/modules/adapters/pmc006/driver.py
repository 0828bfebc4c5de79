"""The driver of a PMC006x3s; it makes one exchange at a time.

    configure   motor on, speed mode off, stop, speeds, external stops, position := BIAS
    idle        status, position, levels, repeated; every tenth time, the second status
    motion      changed parameters, the start, then as idle until its end

Nothing is ever saved (instruction t): the EEPROM wears out.
"""

from __future__ import annotations

from collections.abc import Generator

from scanrack.io_images.amci3601 import Configuration, InputBit, StatusMsw
from scanrack.io_images.pmc006.status import Level, Status1, Status2
from typing_extensions import override

from ....controllers.pmc006.ramps import Pmc006Speeds, plan_move, plan_run, plan_slowing
from ....line import pmc006_frames as frames
from ....line.master import LineRequest, LineTiming, Reply, Step
from ..driver import Driver
from ..exchanges import BIAS, Talk
from ..task import Task, TaskKind
from .pmc006_options import Pmc006Options
from .units import START_MIN, fitted

LINE_TIMING = LineTiming(frames.LINE_FORMAT, gap_ns=0, patience_ns=100_000_000, second_ns=20_000_000)

EXT1_STOP, EXT2_STOP = 1, 2
"""External stops: bits of instructions f and J."""

LATCHES = (
    (EXT1_STOP, Status1.EXT1, "clear_ext1_flag"),
    (EXT2_STOP, Status1.EXT2, "clear_ext2_flag"),
)
"""External stops, their latches, and the instructions that clear the latches."""

POLLS_PER_CHECKUP = 10
"""Number of polls per read of the second status."""

POSITION_INVALID = StatusMsw.POSITION_INVALID.value

LOW_SUPPLY = "the supply voltage is too low"
OVERHEATED = "the device is too hot"


class Pmc006Driver(Driver[Pmc006Speeds]):
    """The driver of a PMC006x3s.

    Attributes:
        clear_stops: a request to clear latched stops that are no longer active.
        levels: the levels of the pins, as last read.
        flags: the latched external stops, as last read.
    """

    def __init__(self, options: Pmc006Options, unit: int) -> None:
        super().__init__(LINE_TIMING)
        self.unit = unit
        self.clear_stops = False
        self.levels = Level.EXT1 | Level.EXT2 | Level.FSET
        self.flags = Status1(0)
        self._home_stroke = options.home_stroke or 1  # without the option every configuration is refused
        self._peak_current = options.peak_current
        self._start_sps = START_MIN
        self._limit_stops = 0  # external stops that are end limits
        self._active_high_stops = 0  # external stops that act at a high level, on a rising edge
        self._polls = 0
        self._faults: dict[str, bool] = {}  # whether a fault was present when it was read last, by its text
        self._written: dict[str, int] = {}  # values of parameters that the device has, by instruction

    def note_configuration(self, configuration: Configuration) -> None:
        """Adopt the starting speed, the limits that stop the motor, and their active levels.

        A terminal that is active high pulls its pin low when it is active.
        """
        self._start_sps = configuration.starting_speed
        inputs_used, active_high = configuration.inputs_used, configuration.active_high
        cw, ccw = InputBit.CW_LIMIT.value, InputBit.CCW_LIMIT.value
        self._limit_stops = (EXT1_STOP if inputs_used & ccw else 0) | (EXT2_STOP if inputs_used & cw else 0)
        ext1 = ccw if inputs_used & ccw else InputBit.HOME.value
        self._active_high_stops = (0 if active_high & ext1 else EXT1_STOP) | (
            0 if active_high & cw else EXT2_STOP
        )

    def is_active(self, stop: int) -> bool:
        """Return whether the pin of an external stop is at its active level."""
        level = Level.EXT1 if stop == EXT1_STOP else Level.EXT2
        return bool(self.levels & level) == bool(self._active_high_stops & stop)

    # -- exchanges ----------------------------------------------------------------------------

    @override
    def identify(self) -> LineRequest:
        return frames.reading(self.unit, "read_status1")

    @override
    def forget(self) -> None:
        self._written.clear()
        self._zeroing = self.clear_stops = False

    @override
    def pending_exchange(self) -> Talk | None:
        return self._clear_stops() if self.clear_stops else None

    def _clear_stops(self, armed: int = EXT1_STOP | EXT2_STOP) -> Talk:
        """Clear latched external stops that are not armed or are no longer active."""
        self.clear_stops = False
        for stop, flag, clear in LATCHES:
            if self.flags & flag and not (armed & stop and self.is_active(stop)):
                yield from self._do(clear)

    def _do(self, name: str, value: int = 0) -> Talk:
        """Send an instruction until the device answers."""
        yield from self.insist(frames.instruction(self.unit, name, value))

    def _set(self, **values: int) -> Talk:
        """Set parameters, unless the device already has the values."""
        for name, value in values.items():
            if self._written.get(name) != value:
                yield from self._do(name, value)
                self._written[name] = value

    @override
    def stop(self) -> Talk:
        yield from self._do("abort")

    # -- reading ------------------------------------------------------------------------------

    @override
    def read_status(self) -> Talk:
        """Read whether the motor is moving, and the cause of a stop."""
        reply = yield from self.insist(frames.reading(self.unit, "read_status1"))
        status = Status1(frames.value_of(reply) & 0xFF)
        self.busy = bool(status & (Status1.BUSY | Status1.HOME))
        self.flags = status & (Status1.EXT1 | Status1.EXT2)
        self._note_fault("the motor has stalled", POSITION_INVALID, bool(status & Status1.STALL))
        self._note_fault(LOW_SUPPLY, 0, bool(status & Status1.UVL))

    def _check_up(self) -> Talk:
        """Read whether the device is too hot, and whether the motor was released."""
        reply = yield from self.insist(frames.reading(self.unit, "read_status2"))
        status = Status2(frames.value_of(reply) & 0xFF)
        self._note_fault("the motor has been released", POSITION_INVALID, bool(status & Status2.FREE_RUN))
        self._note_fault(OVERHEATED, 0, bool(status & Status2.OTS))

    def _note_fault(self, text: str, bits: int, is_present: bool) -> None:
        """Complain about a new fault; ignore a reply that may belong to another request."""
        if self.master.overdue:
            return
        if is_present and not self._faults.get(text):
            self.findings.complain(bits, text)
        self._faults[text] = is_present
        self.unfit = any(self._faults.get(fault) for fault in (LOW_SUPPLY, OVERHEATED))

    @override
    def ask_position(self) -> Generator[Step, Reply | None, int]:
        reply = yield from self.insist(frames.reading(self.unit, "read_position"))
        return frames.value_of(reply)

    @override
    def write_position(self, position: int) -> Talk:
        yield from self._do("set_position", position)

    @override
    def read_inputs(self) -> Talk:
        """Read the levels of the pins, and the position when the capture input becomes active."""
        reply = yield from self.insist(frames.reading(self.unit, "read_levels"))
        levels = Level(frames.value_of(reply) & 0xF)
        is_energized = not levels & Level.FSET
        if (levels ^ self.levels) & Level.FSET and is_energized is self.capture_level:
            yield from self.read_position()  # before the image shows the input
        self.levels = levels
        if self._polls % POLLS_PER_CHECKUP == 0:
            yield from self._check_up()
        self._polls += 1

    # -- configuration ------------------------------------------------------------------------

    @override
    def configure(self) -> Talk:
        """Stop the motor, clear latched stops, arm the configured stops, and set the counter to `BIAS`."""
        yield from self._set(free_run=0)
        yield from self._do("speed_mode", 0)
        yield from self.halt()
        yield from self._set(start_speed=self._start_sps, stop_speed=self._start_sps)
        if self._peak_current is not None:
            yield from self._set(peak_current=self._peak_current)
        yield from self._set(ext_stop_enable=0)
        yield from self._do("clear_ext1_flag")
        yield from self._do("clear_ext2_flag")
        yield from self._set(ext_trigger_mode=self._active_high_stops, ext_stop_enable=self._limit_stops)
        yield from self._set(auto_current_decay=1)
        yield from self.rebase(BIAS)

    # -- motions ------------------------------------------------------------------------------

    @override
    def carry_out(self, task: Task[Pmc006Speeds]) -> Talk:
        """Arm the stops for a motion, start it, and wait for its end."""
        yield from self._arm(self._stops_for(task))
        yield from self._set_speeds(task)
        start_position = self.position
        if not (self.cut or task.stopping):
            self._zeroing = task.kind is TaskKind.HOME
            yield from self.start(task, self._request_for(task))
            yield from self.accompany(task)
        if not self.cut:
            yield from self._finish_search(task)
            yield from self.conclude(task, start_position)
        self._zeroing = False

    def _stops_for(self, task: Task[Pmc006Speeds]) -> int:
        """Return the external stops that may end a motion, except an active stop behind the motion."""
        stop_ahead, stop_behind = (EXT2_STOP, EXT1_STOP) if task.direction > 0 else (EXT1_STOP, EXT2_STOP)
        if task.kind is TaskKind.SLEW:
            return self._limit_stops & stop_ahead
        stops = self._limit_stops
        if task.kind is TaskKind.HOME:  # EXT1 is the home switch
            stops &= EXT2_STOP
        return stops & ~stop_behind if self.is_active(stop_behind) else stops

    def _arm(self, stops: int) -> Talk:
        """Arm external stops, and clear the latches of all others."""
        yield from self._set(ext_stop_enable=stops)
        yield from self._clear_stops(stops)

    def _set_speeds(self, task: Task[Pmc006Speeds]) -> Talk:
        """Set the speeds, ramps and direction of a motion; a search has its own speed and direction."""
        drive = task.drive
        yield from self._set(start_speed=drive.start_sps, stop_speed=drive.stop_sps)
        speed = "zero_back_speed" if task.kind is TaskKind.HOME else "max_speed"
        yield from self._set(**{speed: drive.max_sps})
        yield from self._set(accel_coefficient=drive.acceleration, decel_coefficient=drive.deceleration)
        if task.kind is not TaskKind.HOME:
            yield from self._set(direction=int(task.direction > 0))

    def _request_for(self, task: Task[Pmc006Speeds]) -> LineRequest:
        """Return the instruction that starts a motion."""
        if task.kind is TaskKind.INDEX:
            return frames.instruction(self.unit, "step", task.steps)
        if task.kind is TaskKind.HOME:
            return frames.instruction(self.unit, "zero_back", self._home_stroke)
        return frames.instruction(self.unit, "speed_mode", 1)

    @override
    def model(self, task: Task[Pmc006Speeds]) -> None:
        """Plan the motion with the device's own ramps."""
        now_ns, drive = self.master.now_ns, task.drive
        if task.kind is TaskKind.INDEX:
            task.model = plan_move(now_ns, 0, task.direction * task.steps, drive)
        else:
            task.model = plan_run(now_ns, 0, task.direction, drive)

    @override
    def slow_down(self, task: Task[Pmc006Speeds]) -> Talk:
        """Ramp down by leaving speed mode; stop any other motion without a ramp."""
        if task.kind is not TaskKind.SLEW:
            yield from self.stop_and_read_status()
            return
        yield from self._do("speed_mode", 0)
        if task.model is not None:
            drive = task.drive
            task.model = plan_slowing(task.model, self.master.now_ns, drive.stop_sps, drive.deceleration)

    @override
    def set_mark(self, task: Task[Pmc006Speeds]) -> Talk:
        """Stop, and index the remaining steps."""
        yield from self.stop_and_index(task)

    @override
    def drive_over(self, drive: Pmc006Speeds, steps: int) -> Pmc006Speeds:
        return fitted(drive, steps)

    @override
    def watch(self, task: Task[Pmc006Speeds]) -> Talk:
        """Rearm a limit once the axis has left it."""
        if task.kind is not TaskKind.SLEW:
            yield from self._set(ext_stop_enable=self._stops_for(task))

    def _finish_search(self, task: Task[Pmc006Speeds]) -> Talk:
        """Set the counter to `BIAS` if the search ended at the home switch; otherwise read the position."""
        if task.kind is not TaskKind.HOME:
            return
        self._zeroing = False
        if self.is_active(EXT1_STOP):
            yield from self._do("clear_ext1_flag")
            yield from self.rebase(BIAS)
        else:
            yield from self.read_position()
