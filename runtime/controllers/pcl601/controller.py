"""A PCL601 without its line: registers, command codes, inputs, outputs, errors.

Both protocols and the stored program call the same methods. A method that refuses a request sets an error bit
and returns False.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto

from scanrack.io_images.pcl601 import NEEDS_IDLE, NO_ERROR, POSITION_LIMIT, ROWS, Code, Error, Register
from scanrack.io_images.pcl601.terminals import ON_FLY_OUTPUT, RETRIES_OUTPUT

from .activities import AxisActivity
from .inputs import Inputs
from .motor import EncoderModel, Motor
from .pcl601_motor import SimulatedPcl601Axis
from .pins import Pcl601Pins
from .program.machine import ProgramMachine
from .register_values import Values
from .wiring import Wiring


class Protocol(Enum):
    """Protocol used on the line."""

    MODBUS = auto()
    ASCII = auto()


class Aim(Enum):
    """Target of the next Go: steps or an absolute position, whichever was written last."""

    STEPS = auto()
    POSITION = auto()


class Pcl601Controller:
    """A PCL601 without its line.

    Attributes:
        outputs: output register; bit 0 is output 1.
        runner: the stored program, or None if the memory is empty.
        autorun: whether the program starts at power-up; non-volatile.

    Args:
        wiring: SW2 and the thumbwheel.
    """

    def __init__(self, encoder: EncoderModel | None = None, wiring: Wiring | None = None) -> None:
        self.values = Values()
        self.pins = Pcl601Pins()
        self.motor = Motor(encoder)
        self.inputs = Inputs(self.pins, self.motor, wiring or Wiring(), self.values, self.report)
        self.axis = SimulatedPcl601Axis(self.values, self.pins, self.motor, self.report, self._retries_failed)
        self.protocol = Protocol.MODBUS
        self.outputs = 0
        self.errors = NO_ERROR
        self.runner: ProgramMachine | None = None
        self.autorun = False
        self._aim = Aim.STEPS
        self._last_distance = 0  # of the last index, with sign
        self._sent = bytearray()  # output of the stored program
        self._now_ns = 0
        self._due_ns: int | None = None  # the next event
        self._code_actions = self._code_table()

    # power and time

    def power_up(self, now_ns: int) -> None:
        """Restart, as after power-up or a press of the reset button; only non-volatile values survive.

        The restart clears error bits, switches outputs off and selects Modbus RTU.
        """
        self.axis.power_off()
        if self.runner is not None:
            self.runner.stop()
        self.values.reset()
        self.protocol = Protocol.MODBUS
        self.outputs = 0
        self.errors = NO_ERROR
        self._aim, self._last_distance = Aim.STEPS, 0
        self._sent.clear()
        if self.autorun and self.runner is not None:
            self.runner.start(now_ns)
        self.settle(now_ns)

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next event: a switch, the end of a motion, a timer, or an instruction."""
        return self._due_ns

    def advance(self, now_ns: int) -> None:
        """Advance to `now_ns` event by event."""
        while self._due_ns is not None and self._due_ns <= now_ns:
            due_ns = self._due_ns
            self.axis.advance(due_ns)
            self._now_ns = due_ns
            self.settle(due_ns)
        self.axis.advance(now_ns)
        self._now_ns = now_ns

    def settle(self, now_ns: int) -> None:
        """Handle all events that are due now; call this after any external change."""
        self._now_ns = now_ns
        self._due_ns = None
        while True:
            self.axis.jog.allowed = not self.program_running
            if not self.axis.settle(now_ns) and not self._run_program(now_ns):
                break
        self._due_ns = self._next_event_ns()

    def _run_program(self, now_ns: int) -> bool:
        """Carry out the stored program's next instruction if it is due; return whether it was due."""
        if self.runner is None or self.runner.next_wake_ns is None or self.runner.next_wake_ns > now_ns:
            return False
        self.runner.advance(now_ns, self)
        return True

    def _next_event_ns(self) -> int | None:
        """Return the instant of the next event on the axis or in the stored program, or None."""
        instants = (self.axis.next_event_ns(), self.runner.next_wake_ns if self.runner is not None else None)
        return min((instant for instant in instants if instant is not None), default=None)

    @property
    def now_ns(self) -> int:
        """The current instant."""
        return self._now_ns

    # outputs and registers

    @property
    def busy(self) -> bool:
        """Whether a motion is in progress, even if the stored program is waiting."""
        return self.axis.busy

    @property
    def program_running(self) -> bool:
        """Whether a stored program is running."""
        return self.runner is not None and self.runner.running

    @property
    def output_pins(self) -> int:
        """The outputs, including a pulse from the output on the fly."""
        return self.outputs | (ON_FLY_OUTPUT if self.axis.fly.until_ns is not None else 0)

    def read(self) -> Values:
        """Update the status registers, and return all registers.

        The command register is 0, since commands run at once.
        """
        self.values[Register.BUSY] = int(self.busy)
        self.values[Register.ERROR_CODE] = int(self.errors)
        return self.values

    def register(self, register: Register) -> int:
        """Return the current value of a register."""
        return self.read()[register]

    def take_sent(self) -> bytes:
        """Return the stored program's output since the last call."""
        data = bytes(self._sent)
        self._sent.clear()
        return data

    # writes and command codes

    def report(self, error: Error) -> None:
        """Set an error bit."""
        self.errors |= error

    def refuse(self, error: Error) -> bool:
        """Set an error bit and return False."""
        self.report(error)
        return False

    def take_errors(self) -> Error:
        """Return and clear the error code register."""
        errors, self.errors = self.errors, NO_ERROR
        return errors

    def send_text(self, text: str) -> bool:
        """Send a text from the stored program, followed by CR unless the text ends in a line feed.

        In Modbus mode, refuse the text with the mode error.
        """
        if self.protocol is not Protocol.ASCII:
            return self.refuse(Error.MODE)
        self._sent += (text if text.endswith("\n") else text + "\r").encode("latin-1", "replace")
        return True

    def write(self, register: Register, value: int, out_of_range: Error = Error.RANGE) -> bool:
        """Write a register; return whether it was accepted.

        Args:
            value: a signed number.
            out_of_range: the error for a value outside the map's range.
        """
        row = ROWS[register]
        if row.locked and self.busy:
            return self.refuse(Error.BUSY)
        if not row.allows(value):
            return self.refuse(out_of_range)
        self.values[register] = value
        self.written(register)
        return True

    def written(self, register: Register) -> None:
        """If the register sets a target for Go, use this target for the next Go."""
        if register is Register.STEPS:
            self._aim = Aim.STEPS
        elif register is Register.ABS_TARGET:
            self._aim = Aim.POSITION

    def set_outputs(self, outputs: int, mask: int = 0xFF) -> bool:
        """Set the outputs that a mask selects; return True, since this is never refused."""
        self.outputs = self.outputs & ~mask | outputs & mask
        return True

    def set_analog(self, *, speed: bool | None = None, position: bool | None = None) -> bool:
        """Enable or disable analog functions; None leaves a function unchanged."""
        self.values.set_analog(speed=speed, position=position)
        return True

    def do(self, code: int) -> bool:
        """Carry out a command code, 1 to 15, and return whether it was accepted; 0 does nothing."""
        if code == 0:
            return True
        if code not in self._code_actions:
            return self.refuse(Error.COMMAND)
        if code in NEEDS_IDLE and self.busy:
            return self.refuse(Error.BUSY)
        return self._code_actions[Code(code)]()

    def command(self, code: int) -> bool:
        """Carry out a command code from the stored program; a hard stop does not end the program."""
        if code == Code.STOP_MOTION:
            self.axis.stop_hard()
            return True
        return self.do(code)

    def stop_everything(self) -> None:
        """Stop the motion without a ramp and stop the stored program, as code 5 and `.` do."""
        self.axis.stop_hard()
        if self.runner is not None:
            self.runner.stop()

    def speak(self, protocol: Protocol) -> None:
        """Switch to a protocol."""
        self.protocol = protocol

    def run_at_power_up(self, enabled: bool) -> None:
        """Set the autorun flag, which is non-volatile."""
        self.autorun = enabled

    def _code_table(self) -> dict[Code, Callable[[], bool]]:
        """Return the actions of the command codes; each action returns whether its command was accepted.

        Inputs are read when the action is called.
        """
        return {
            Code.GO: self._go,
            Code.HOME_TYPE_0: lambda: self._home(AxisActivity.HOME_0),
            Code.HOME_TYPE_1: lambda: self._home(AxisActivity.HOME_1),
            Code.GO_SLEW: self._slew,
            Code.STOP_MOTION: _never_refused(self.stop_everything),
            Code.STOP_SOFT: _never_refused(lambda: self.axis.stop_soft(self._now_ns)),
            Code.MAX_SPEED_FROM_ANALOG: lambda: self._write_input(
                Register.MAX_SPEED, self.inputs.analog_speed()
            ),
            Code.POSITION_FROM_ANALOG: lambda: self._write_input(
                Register.ABS_TARGET, self.inputs.analog_position()
            ),
            Code.STEPS_FROM_THUMBWHEEL: lambda: self._write_input(Register.STEPS, self.inputs.thumbwheel()),
            Code.CLEAR_ERRORS: _never_refused(self.take_errors),
            Code.SWITCH_TO_ASCII: _never_refused(lambda: self.speak(Protocol.ASCII)),
            Code.RUN_PROGRAM: self._start_program,
            Code.AUTORUN_OFF: _never_refused(lambda: self.run_at_power_up(False)),
            Code.AUTORUN_ON: _never_refused(lambda: self.run_at_power_up(True)),
            Code.ENCODER_RESET: lambda: self.write(Register.ENCODER_POSITION, 0),
        }

    # motion

    def _go(self) -> bool:
        if self._aim is Aim.STEPS:
            return self.move(self.values[Register.STEPS])
        return self.move_to(self.values[Register.ABS_TARGET])

    def move(self, steps: int) -> bool:
        """Index a number of steps in the direction set by the direction register; 0 does not move."""
        direction = 1 if self.values[Register.DIRECTION] else -1
        if not ROWS[Register.STEPS].allows(steps):
            return self.refuse(Error.RANGE)
        return self.index(direction * steps)

    def move_to(self, position: int) -> bool:
        """Index to an absolute position."""
        distance = position - self.values[Register.POSITION]
        if not ROWS[Register.ABS_TARGET].allows(position) or abs(distance) > POSITION_LIMIT:
            return self.refuse(Error.RANGE_OVERFLOW)
        return self.index(distance)

    def index(self, distance: int) -> bool:
        """Index by a signed distance; refuse it if the target is outside the position register's range."""
        if self.busy:
            return self.refuse(Error.BUSY)
        if distance and abs(distance) > self.axis.steps_in_range(1 if distance > 0 else -1):
            return self.refuse(Error.RANGE)
        if not self.axis.speeds.fit():
            return self.refuse(Error.MOTOR)
        if distance:
            self._last_distance = distance
            self.axis.index(self._now_ns, distance)
        return True

    def repeat(self) -> bool:
        """Repeat the last index with the same length and direction."""
        return self.index(self._last_distance)

    def _begin_endless(self, begin: Callable[[], None]) -> bool:
        """Begin an endless motion if the speeds are valid and the position is not at the end of its range."""
        if self.axis.steps_in_range(1 if self.values[Register.DIRECTION] else -1) == 0:
            return self.refuse(Error.RANGE)
        if not self.axis.speeds.fit():
            return self.refuse(Error.MOTOR)
        begin()
        return True

    def _home(self, activity: AxisActivity) -> bool:
        return self._begin_endless(lambda: self.axis.home(self._now_ns, activity))

    def _slew(self) -> bool:
        return self._begin_endless(lambda: self.axis.slew(self._now_ns))

    def aim_at(self, position: int) -> bool:
        """Set the absolute position, the steps and the direction, as ASCII command P does.

        During a motion, set only the absolute position. Return whether the position was accepted.
        """
        if not self.write(Register.ABS_TARGET, position, Error.RANGE_OVERFLOW):
            return False
        distance = position - self.values[Register.POSITION]
        if self.busy:
            return True
        if abs(distance) > POSITION_LIMIT:
            return self.refuse(Error.RANGE_OVERFLOW)
        self.values[Register.STEPS] = abs(distance)
        if distance:
            self.values[Register.DIRECTION] = int(distance > 0)
        self._aim = Aim.STEPS
        return True

    # inputs

    def inputs_raw(self) -> int:
        """Return the levels of the inputs; bit 0 is input 1."""
        return self.inputs.raw()

    def move_thumbwheel(self) -> bool:
        """Read the thumbwheel, and index by that number of steps; return whether both were accepted."""
        steps = self.inputs.thumbwheel()
        return steps is not None and self.move(steps)

    def move_to_analog(self) -> bool:
        """Read the voltage on input 1, and index to its position; return whether both were accepted."""
        position = self.inputs.analog_position()
        return position is not None and self.move_to(position)

    def _write_input(self, register: Register, value: int | None) -> bool:
        """Write a value that was read from an input; return False for None, a refused read."""
        return value is not None and self.write(register, value)

    # program

    def _start_program(self) -> bool:
        """Start the stored program; refuse if the memory is empty."""
        if self.runner is None:
            return self.refuse(Error.MEMORY_COMMAND)
        self.runner.start(self._now_ns)
        return True

    def _retries_failed(self) -> None:
        self.outputs |= RETRIES_OUTPUT


def _never_refused(action: Callable[[], object]) -> Callable[[], bool]:
    """Return a function that carries out an action and returns True."""

    def carry_out() -> bool:
        action()
        return True

    return carry_out
