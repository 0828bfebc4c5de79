"""A client of a PCL601 over Modbus: registers by name, moves, homing, outputs."""

from __future__ import annotations

from struct import unpack

from ....io_images.pcl601 import NEEDS_IDLE, POSITION_LIMIT, ROWS, Code, Error, Register
from ....io_images.pcl601.errors import CAUSES
from ....io_images.pcl601.registers import Row, firmware_text, word_of
from ....io_images.pcl601.terminals import HARD_LIMIT_BIT, OUTPUT_COUNT
from .. import pcl601_pdus as pdus
from .link import (
    POLL_S,
    BadAnswerError,
    LinkError,
    NoAnswerError,
    Progress,
    RefusedError,
    StoppedError,
    UncertainError,
    until_answered,
)
from .modbus import ModbusLine
from .watching import stopped_when_lost

READABLE: dict[str, Row] = {row.register.name.lower(): row for row in ROWS.values()}
"""The registers by name."""

SETTABLE: dict[str, Row] = {
    name: row for name, row in READABLE.items() if row.writable and row.register is not Register.COMMAND
}
"""Those that can be set; commands are `Pcl601Client.command`."""


class Pcl601Client:
    """A controller at the other end of a line.

    Attributes:
        unit: its address, 1 to 99.
        faults: answers so far that were missing or could not be right.

    Args:
        line: Modbus RTU, 38,400 baud 8E1, or Modbus TCP.
        unit: of the controller.
    """

    def __init__(self, line: ModbusLine, unit: int = 1) -> None:
        if not 1 <= unit <= 99:
            raise ValueError(f"unit {unit}: allowed is 1 to 99")
        self._line = line
        self.unit = unit
        self.faults = 0

    # -- by name -----------------------------------------------------------------------------

    def read(self, name: str) -> int:
        """Return a register by its name in `READABLE`, signed where its range is.

        Raises:
            ValueError: there is none of that name.
            LinkError: no good answer.
        """
        row = READABLE.get(name)
        if row is None:
            raise ValueError(f"{name} can't be read: can be {', '.join(READABLE)}")
        words = unpack(f">{row.words}H", self._asked(pdus.read_registers(row.register, row.words)))
        value: int = sum(word << 16 * at for at, word in enumerate(words))
        return value - (1 << 32) if row.low < 0 and value >> 31 else value

    def set(self, name: str, value: int) -> None:
        """Set a register by its name in `SETTABLE`, and read it back.

        Raises:
            ValueError: it can't be set, or not to that.
            LinkError: no good answer, or the controller refuses it.
        """
        row = SETTABLE.get(name)
        if row is None:
            raise ValueError(f"{name} can't be set: can be {', '.join(SETTABLE)}")
        if not row.allows(value):
            raise ValueError(f"{name} {value}: allowed is {row.low} to {row.high}")
        if row.register is Register.ADDRESS:
            self._set_address(value)
            return
        self._asked(_write(row, value))
        if (kept := self.read(name)) != value:
            raise RefusedError(f"{name} was set to {value} and reads {kept}")

    @property
    def position(self) -> int:
        """The position register, read; steps."""
        return self.read("position")

    @property
    def busy(self) -> bool:
        """Whether the motor moves, read."""
        return bool(self.read("busy"))

    @property
    def errors(self) -> Error:
        """The error code register, read."""
        return Error(self.read("error_code"))

    @property
    def firmware(self) -> str:
        """The firmware version as text, read."""
        return firmware_text(self.read("firmware"))

    @property
    def hard_limit(self) -> bool:
        """Whether a hard limit is active, read; the controller does not show which."""
        return bool(self.inputs >> HARD_LIMIT_BIT & 1)

    @property
    def inputs(self) -> int:
        """The input bits as function 02 has them, read; bit 0 is input 1, 1 is active."""
        return int.from_bytes(self._asked(pdus.read_inputs()), "little")

    @property
    def outputs(self) -> int:
        """The outputs, read; bit 0 is output 1, 1 is on."""
        return int.from_bytes(self._asked(pdus.read_outputs()), "little")

    def set_output(self, number: int, on: bool) -> None:
        """Switch an output, 1 to 8.

        Raises:
            ValueError: no such output.
            LinkError: no good answer, or the controller refuses it.
        """
        if not 1 <= number <= OUTPUT_COUNT:
            raise ValueError(f"output {number}: allowed is 1 to {OUTPUT_COUNT}")
        self._asked(pdus.write_output(number, on))

    # -- commands ----------------------------------------------------------------------------

    def command(self, code: Code) -> None:
        """Write a command code; one that starts something is written once, others until answered.

        Raises:
            RefusedError: the controller refuses it, or sets an error bit for it.
            UncertainError: it was to start a motion, was not answered, and nothing moves.
            LinkError: no good answer.
        """
        if code in NEEDS_IDLE:
            self._start(code)
        else:
            self._asked(pdus.command(code))

    def start_move(self, steps: int) -> int:
        """Start a move over so many steps, its sign the direction; return where it should end.

        Raises:
            ValueError: 0, or too many steps.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        if not 1 <= abs(steps) <= POSITION_LIMIT:
            raise ValueError(f"{steps} steps: allowed is 1 to {POSITION_LIMIT} in either direction")
        self.set("direction", int(steps > 0))
        self.set("steps", abs(steps))
        target = self.position + steps
        self._start(Code.GO)
        return target

    def move(self, steps: int, progress: Progress = lambda _: None) -> int:
        """Move over so many steps and wait for the end; return the position.

        Raises:
            ValueError: 0, or too many steps.
            StoppedError: it ended elsewhere, or with the encoder outside its window.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        encoder = self.read("encoder_position") if self.read("encoder_autocorrect") else None
        target = self.start_move(steps)
        position = self.wait(progress)
        with stopped_when_lost(self.stop):
            if position != target:
                raise StoppedError(f"the move ended at {position}, not at {target}{self._shown()}")
            if encoder is not None:
                self._check_encoder(encoder + steps * self.read("encoder_ratio"))
        return position

    def home(self, kind: int, progress: Progress = lambda _: None) -> int:
        """Look for the home switch by the manual's home type 0 or 1; return the position at the end.

        The position is left as counted: the controller does not set it to 0. It does not show its home
        input either: a search counts as done if it has ended and no hard limit is active.

        Raises:
            ValueError: no such type.
            StoppedError: it ended on a hard limit.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        if kind not in (0, 1):
            raise ValueError(f"home type {kind}: allowed are 0 and 1")
        self._start(Code.HOME_TYPE_1 if kind else Code.HOME_TYPE_0)
        position = self.wait(progress)
        with stopped_when_lost(self.stop):
            if self.hard_limit:
                raise StoppedError(f"the search for home ended at {position}, not at home{self._shown()}")
        return position

    def wait(self, progress: Progress = lambda _: None) -> int:
        """Wait for the end of a motion; return the position.

        Raises:
            LostSightError: the line failed.
        """
        with stopped_when_lost(self.stop):
            while self.busy:
                progress(self.position)
                self._line.pause(POLL_S)
            position = self.position
        progress(position)
        return position

    def stop(self) -> None:
        """Stop motion and program at once; asked again until it is answered.

        Raises:
            LinkError: no good answer.
        """
        self._asked(pdus.command(Code.STOP_MOTION))

    # -- inside ------------------------------------------------------------------------------

    def _start(self, code: Code) -> None:
        """Write what starts something, once; without an answer, look whether it has begun."""
        before, errors = self.position, self.errors
        if self.busy:
            raise RefusedError("a motion is under way")
        with stopped_when_lost(self.stop):
            failure = self._sent(code, before, errors)
        if failure is not None:
            raise failure

    def _sent(self, code: Code, before: int, errors: Error) -> LinkError | None:
        """Write what starts something, once; return why it has not begun, None if it has."""
        try:
            self._once(pdus.command(code))
        except RefusedError as refusal:
            return refusal
        except (NoAnswerError, BadAnswerError):
            if not self._has_begun(before):
                return UncertainError(f"{code.name} was not answered, and nothing moves; it is not repeated")
        raised = self.errors & ~errors
        if raised and not self._has_begun(before):  # a question doubled on the line is refused then
            return RefusedError(f"{code.name} is refused{_told(raised)}")
        return None

    def _has_begun(self, before: int) -> bool:
        return self.busy or self.position != before

    def _check_encoder(self, expected: int) -> None:
        """Raise StoppedError if the encoder is outside its window after a move."""
        off, window = self.read("encoder_position") - expected, self.read("encoder_window")
        if abs(off) > window:
            message = f"the move ended with the encoder {off:+} pulses off, its window is ±{window}"
            raise StoppedError(f"{message}{self._shown()}")

    def _shown(self) -> str:
        """Return what the controller shows besides its position, to be put after a sentence."""
        limit = "; a hard limit is active" if self.hard_limit else ""
        return limit + _told(self.errors)

    def _set_address(self, value: int) -> None:
        """Change the address: the former one answers, the new one listens afterwards."""
        former, pdu = self.unit, _write(ROWS[Register.ADDRESS], value)
        try:
            self._once(pdu)
        except (NoAnswerError, BadAnswerError):
            self.unit = value
            try:
                self.read("address")
            except NoAnswerError:
                self.unit = former
                raise
        self.unit = value

    def _asked(self, pdu: bytes) -> bytes:
        """Ask, up to `TRIES` times; return the data of the answer."""
        return until_answered(lambda: self._once(pdu))

    def _once(self, pdu: bytes) -> bytes:
        try:
            return self._line.ask(self.unit, pdu)
        except (NoAnswerError, BadAnswerError):
            self.faults += 1
            raise


def _write(row: Row, value: int) -> bytes:
    """Return the question that writes a value, both words of it at once."""
    words = [word_of(value, at) for at in range(row.words)]
    if row.words == 1:
        return pdus.write_register(row.register, words[0])
    return pdus.write_registers(row.register, words)


def _told(errors: Error) -> str:
    """Return what error bits mean, to be put after a sentence."""
    return "".join(f"; {error.name}: {CAUSES[error]}" for error in errors)
