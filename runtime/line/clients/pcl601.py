"""A client for a PCL601 over Modbus: registers by name, moves, homing, outputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from pymodbus.pdu import ModbusPDU
from scanrack.io_images.pcl601 import CAUSES, NEEDS_IDLE, POSITION_LIMIT, ROWS, WORDS, Code, Error, Register
from scanrack.io_images.pcl601.registers import Row, firmware_text, word_of
from scanrack.io_images.pcl601.terminals import HARD_LIMIT_BIT, OUTPUT_COUNT
from typing_extensions import override

from .. import pcl601_pdus as pdus
from ..modbus_pdus import number_of
from .link import BadResponseError, NoAnswerError, Progress, RefusedError, StoppedError, until_answered
from .modbus import ModbusExceptionError, ModbusLine
from .names import check_read_back, row_of, settable
from .watching import ControllerView, MotionClient, stopped_when_lost

READABLE: dict[str, Row] = {row.register.name.lower(): row for row in ROWS.values()}
"""The registers by name."""

SETTABLE: dict[str, Row] = {
    name: row for name, row in READABLE.items() if row.writable and row.register is not Register.COMMAND
}
"""Registers that can be set; for commands see `Pcl601Client.command`."""

STATE_WORDS = [(row, word) for row, word in WORDS if Register.POSITION <= row.register <= Register.ERROR_CODE]
"""Words of one read: the registers from position to errors, including everything that a motion changes."""

EXCEPTIONS = {
    1: "unknown function",
    2: "no such register, or a read-only register",
    3: "the value is out of range",
    6: "a program is running, or the register is locked while the motor moves",
}

MOTIONS = frozenset({Code.GO, Code.GO_SLEW, Code.HOME_TYPE_0, Code.HOME_TYPE_1})


@dataclass(frozen=True, slots=True)
class Registers(ControllerView):
    """One read of a PCL601: its registers from position to errors."""

    values: Mapping[Register, int] = field(compare=False, default_factory=dict)


class Pcl601Client(MotionClient[Registers]):
    """A client for a PCL601.

    Every method raises LinkError if there is no valid answer, and RefusedError if the device refuses; for
    motions see `MotionClient`.

    Args:
        line: Modbus RTU, 38,400 baud 8E1, or Modbus TCP.
    """

    harmless = Error.ENCODER_CORRECTED

    def __init__(self, line: ModbusLine, unit: int = 1) -> None:
        if not 1 <= unit <= 99:
            raise ValueError(f"unit {unit}: must be 1 to 99")
        super().__init__(unit)
        self._line = line

    # -- by name -----------------------------------------------------------------------------

    def read(self, name: str) -> int:
        """Return a register by its name in `READABLE`; it is signed if its range is signed.

        Raises:
            ValueError: the name is unknown.
        """
        row = row_of(READABLE, name, "read")
        return value_of(row, self._exchange(pdus.read_registers(row.register, row.words)).registers)

    def set(self, name: str, value: int) -> None:
        """Set a register by its name in `SETTABLE`, and read it back.

        Raises:
            ValueError: the register can't be set, or the value is not allowed.
        """
        row = settable(SETTABLE, name, value)
        if row.register is Register.ADDRESS:
            self._change_address(value, lambda: self._send_once(_write(row, value)), "address")
            return
        self._exchange(_write(row, value))
        check_read_back(name, value, self.read(name))

    @override
    def look(self) -> Registers:
        """Read position, motion and errors in one exchange."""
        words = self._exchange(pdus.read_registers(Register.POSITION, len(STATE_WORDS))).registers
        words_by_row: dict[Row, list[int]] = {}
        for (row, _), word in zip(STATE_WORDS, words, strict=True):
            words_by_row.setdefault(row, []).append(word)
        values = {row.register: value_of(row, row_words) for row, row_words in words_by_row.items()}
        position, is_moving = values[Register.POSITION], bool(values[Register.BUSY])
        return Registers(position, is_moving, values[Register.ERROR_CODE], values)

    @property
    def busy(self) -> bool:
        """Whether the motor is moving; reads it from the device."""
        return bool(self.read("busy"))

    @property
    def errors(self) -> Error:
        """The error code register; reads it from the device."""
        return Error(self.read("error_code"))

    @property
    def firmware(self) -> str:
        """The firmware version as text; reads it from the device."""
        return firmware_text(self.read("firmware"))

    @property
    def hard_limit(self) -> bool:
        """Whether one of the hard limits is active; reads it from the device."""
        return bool(self.inputs >> HARD_LIMIT_BIT & 1)

    @property
    def inputs(self) -> int:
        """The input bits, read with function 02. Bit 0 is input 1; 1 means active."""
        return number_of(self._exchange(pdus.read_inputs()).bits)

    @property
    def outputs(self) -> int:
        """The outputs, read from the device. Bit 0 is output 1; 1 means on."""
        return number_of(self._exchange(pdus.read_outputs()).bits)

    def set_output(self, number: int, on: bool) -> None:
        """Switch an output, 1 to 8, and read it back; raise ValueError for an unknown output."""
        if not 1 <= number <= OUTPUT_COUNT:
            raise ValueError(f"output {number}: must be 1 to {OUTPUT_COUNT}")
        self._exchange(pdus.write_output(number, on))
        if bool(self.outputs >> number - 1 & 1) != on:
            requested, is_now = ("on", "off") if on else ("off", "on")
            raise RefusedError(f"output {number} was switched {requested}, but reads {is_now}")

    # -- commands ----------------------------------------------------------------------------

    def command(self, code: Code) -> None:
        """Write a command code: only once if it starts a motion, otherwise until the device answers.

        Raises:
            RefusedError: the device refuses the command, or sets an error bit for it.
            UnconfirmedMotionError: a start command caused no visible motion, or got no answer.
        """
        if code in NEEDS_IDLE:
            self._start(code)
        else:
            self._exchange(pdus.command(code))

    def clear(self) -> None:
        """Clear the error register, and read it; raise RefusedError if errors remain."""
        self.command(Code.CLEAR_ERRORS)
        errors_left = self.errors
        if errors_left:
            raise RefusedError(f"the errors were cleared, but are still set{_meanings(errors_left)}")

    def start_move(self, steps: int) -> int:
        """Start a move by a signed number of steps; return its target.

        Raises:
            ValueError: the number of steps is 0 or too large.
        """
        if not 1 <= abs(steps) <= POSITION_LIMIT:
            raise ValueError(f"{steps} steps: must be 1 to {POSITION_LIMIT} in either direction")
        self.set("direction", int(steps > 0))
        self.set("steps", abs(steps))
        return self._start(Code.GO).position + steps

    @override
    def _prepare_check(self, steps: int) -> Callable[[Registers], None]:
        """Return a function that checks the encoder after a move, if the device's autocorrect is on."""
        values_before = self.look().values
        if not values_before[Register.ENCODER_AUTOCORRECT]:
            return super()._prepare_check(steps)
        counts = steps * values_before[Register.ENCODER_RATIO]
        expected_position = values_before[Register.ENCODER_POSITION] + counts
        return lambda state: self._check_encoder(state, expected_position)

    def home(self, kind: int, progress: Progress = lambda _: None) -> int:
        """Home the axis with the manual's home type 0 or 1; return the final position.

        The device does not set the position to 0 and does not report its home input. A search succeeds if a
        motion was seen and ended without an error and without an active hard limit.

        Raises:
            ValueError: the type does not exist.
            StoppedError: the search ended at a hard limit, or with an error.
        """
        if kind not in (0, 1):
            raise ValueError(f"home type {kind}: must be 0 or 1")
        self._start(Code.HOME_TYPE_1 if kind else Code.HOME_TYPE_0)
        state = self.watch(progress)
        with stopped_when_lost(self.stop):
            if self.hard_limit:
                end_text = f"the search for home ended at {state.position}, not at home"
                raise StoppedError(f"{end_text}{self.reasons(state.errors)}")
            self.check_errors("search for home", state)
        return state.position

    # -- inside ------------------------------------------------------------------------------

    @override
    def halt(self) -> None:
        """Stop motion and program at once; repeat the request until the device answers."""
        self._exchange(pdus.command(Code.STOP_MOTION))

    @override
    def pause(self, seconds: float) -> None:
        self._line.pause(seconds)

    @override
    def reasons(self, errors: int) -> str:
        limit = "; a hard limit is active" if self.hard_limit else ""
        return limit + _meanings(Error(errors))

    def _start(self, code: Code) -> Registers:
        """Send a command code once; return the state before it, see `begin`."""
        return self.begin(code.name, lambda: self._send_once(pdus.command(code)), moves=code in MOTIONS)

    def _check_encoder(self, state: Registers, expected_position: int) -> None:
        """Raise a StoppedError if the encoder differs from a position, in pulses, by more than its window."""
        deviation = state.values[Register.ENCODER_POSITION] - expected_position
        window = state.values[Register.ENCODER_WINDOW]
        if abs(deviation) > window:
            message = f"the move ended with the encoder {deviation:+} pulses off; its window is ±{window}"
            raise StoppedError(f"{message}{self.reasons(state.errors)}")

    def _exchange(self, request: ModbusPDU) -> ModbusPDU:
        """Send a request, up to `TRIES` times; return the answer."""
        return until_answered(lambda: self._send_once(request))

    def _send_once(self, request: ModbusPDU) -> ModbusPDU:
        """Send a request once; return the answer. Explain an exception, and count a missing answer."""
        try:
            return self._line.ask(self.address, request)
        except ModbusExceptionError as error:
            meaning = EXCEPTIONS.get(error.code, "not in the manual")
            raise ModbusExceptionError(error.function, error.code, meaning) from None
        except (NoAnswerError, BadResponseError):
            self.faults += 1
            raise


def value_of(row: Row, words: Sequence[int]) -> int:
    """Return the value of a row's words, low word first; it is signed if the row's range is signed."""
    value = sum(word << 16 * index for index, word in enumerate(words))
    return value - (1 << 32) if row.low < 0 and value >> 31 else value


def _write(row: Row, value: int) -> ModbusPDU:
    """Return the request that writes all words of a value together."""
    words = [word_of(value, index) for index in range(row.words)]
    if row.words == 1:
        return pdus.write_register(row.register, words[0])
    return pdus.write_registers(row.register, words)


def _meanings(errors: Error) -> str:
    """Return the meanings of error bits, as text to append to a sentence."""
    return "".join(f"; {error.name}: {CAUSES[error]}" for error in errors)
