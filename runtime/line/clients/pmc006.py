"""A client for a PMC006x3s: parameters and values by name, one request at a time.

A reply does not identify its instruction [4.1.1]. The client therefore waits for silence before every
request, and longer after a missing answer, so that it drops late and duplicate answers.

Seven parameters have no read instruction. With data 0, "some" setting instructions read instead of setting
[4.1.1], but the manual does not say which ones, and the others would set the parameter to 0. Reading this way
is therefore optional. The address is never read this way: the device would not answer at an invalid address
[4.1.2], and every answer contains the address.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from scanrack.io_images.pmc006.frame import FRAME_BYTES, REPLY, STATE_ERROR, UNKNOWN_ERROR, Framer, command
from scanrack.io_images.pmc006.instructions import BY_NAME, INSTRUCTIONS, PARAMETERS, InstructionRow, Kind
from scanrack.io_images.pmc006.status import Status1, Status2, firmware_text
from typing_extensions import override

from .link import (
    ANSWER_S,
    LATE_S,
    POLL_S,
    SILENCE_S,
    BadResponseError,
    Link,
    NoAnswerError,
    Progress,
    RefusedError,
    StoppedError,
    checked_answer_s,
    drain,
    until_answered,
)
from .names import check_read_back, settable
from .watching import ControllerView, MotionClient, stopped_when_lost

_ERRORS = {
    STATE_ERROR: "6: wrong state, or value out of range",
    UNKNOWN_ERROR: "7: unknown instruction, or the limit in this direction is active",
}
_MOTIONS = ("step", "zero_back", "speed_mode", "run_user_program")


ADDRESS = "device_address"

READABLE: dict[str, InstructionRow] = {
    row.shows or row.name.removeprefix("read_"): row for row in INSTRUCTIONS if row.kind is Kind.READ
}
"""Values that have a read instruction, each with that instruction."""

BY_ZERO: dict[str, InstructionRow] = {
    row.name: row for row in PARAMETERS if row.asks_by_zero and row.name != ADDRESS
}
"""Parameters that their setting instruction might read if its data is 0."""

SETTABLE: dict[str, InstructionRow] = {
    row.name: row
    for row in sorted(INSTRUCTIONS, key=lambda row: row.name)
    if row.kind is Kind.SET and row.name != "speed_mode"
}
"""Values that can be set."""

NAMED = Status1.EXT1 | Status1.EXT2 | Status1.STALL | Status1.UVL
"""Bits of status register 1 that explain a motion that failed or did not start."""


def _unreadable(name: str, readable: Iterable[str]) -> str:
    """Return the reason why a value can't be read."""
    if name in BY_ZERO:
        return (
            f"{name} has no read instruction: its setting instruction with data 0 may read it or set it to 0 "
            "[4.1.1]; use --by-zero (by_zero=True) to send it"
        )
    return f"{name} can't be read; choose from {', '.join(readable)}"


class _Search:
    """State of the home switch during a zero-back.

    Attributes:
        began_on_switch: whether the switch was active at the start.
        was_free: whether the switch was free, or the motor moved back, which it does only from a free switch
            [4.3.13].
    """

    def __init__(self, on_switch: Callable[[], bool]) -> None:
        self._on_switch = on_switch
        self._furthest: int | None = None
        self.began_on_switch = on_switch()
        self.was_free = not self.began_on_switch

    def look(self, position: int) -> None:
        """Note a position; read the switch until it has been free once."""
        if self.was_free:
            return
        went_back = self._furthest is not None and position < self._furthest
        self._furthest = position
        self.was_free = went_back or not self._on_switch()


class Pmc006Client(MotionClient[ControllerView]):
    """A client for a PMC006x3s.

    Every method raises LinkError if there is no valid answer, and RefusedError if the device refuses; for
    motions see `MotionClient`.

    Args:
        link: the line, 9,600 baud, 8N1.
        answer_s: longest wait for an answer, 0.01 to 60 s.
        by_zero: whether to also read the values in `BY_ZERO`.
    """

    final = Status1.STALL

    def __init__(
        self, link: Link, address: int = 255, *, answer_s: float = ANSWER_S, by_zero: bool = False
    ) -> None:
        if not 1 <= address <= 120 and address != 255:
            raise ValueError(f"address {address}: must be 1 to 120, or 255 (factory setting)")
        super().__init__(address)
        self._link = link
        self._answer_s = checked_answer_s(answer_s)
        self._readable = READABLE | BY_ZERO if by_zero else READABLE
        self._quiet_s = SILENCE_S  # silence before the next request, longer after a missing answer

    # -- by name -----------------------------------------------------------------------------

    @property
    def readable(self) -> tuple[str, ...]:
        """The names that `read` accepts, sorted."""
        return tuple(sorted({*self._readable, ADDRESS}))

    def read(self, name: str) -> int:
        """Return a value by its name in `readable`; raise ValueError if it can't be read."""
        if name == ADDRESS:
            self.read("status1")
            return self.address
        row = self._readable.get(name)
        if row is None:
            raise ValueError(_unreadable(name, self.readable))
        return self._exchange(row.code, 0)

    def set(self, name: str, value: int) -> None:
        """Set a parameter by its name in `SETTABLE`, and read it back if it can be read.

        Without `save`, the value is lost at power-off.

        Raises:
            ValueError: the parameter can't be set, or the value is not allowed.
        """
        row = settable(SETTABLE, name, value)
        if name == ADDRESS:
            self._set_address(row, value)
            return
        self._check(row, self._exchange(row.code, value), value)
        read_name = "position" if name == "set_position" else name
        if read_name in self._readable:
            check_read_back(name, value, self.read(read_name))

    def _set_address(self, row: InstructionRow, address: int) -> None:
        def send() -> None:
            self._check(row, self._send_once(row.code, address, address), address)

        self._change_address(address, send, "status1")

    def do(self, name: str, data: int = 0) -> None:
        """Carry out an action that can safely be repeated, such as clearing a flag.

        Raises:
            ValueError: the name is not an action, or the action starts a motion.
        """
        row = BY_NAME.get(name)
        if row is None or row.kind is not Kind.ACTION or name in _MOTIONS:
            raise ValueError(f"{name} is not an action that may be repeated")
        self._check(row, self._exchange(row.code, data), None)

    def clear(self) -> None:
        """Clear and read the emergency stops of EXT1 and EXT2; raise RefusedError if any remains."""
        self.do("clear_ext1_flag")
        self.do("clear_ext2_flag")
        if stops_left := self.status1 & (Status1.EXT1 | Status1.EXT2):
            raise RefusedError(
                f"the emergency stops were cleared, but are still set{self.reasons(stops_left)}"
            )

    def save(self) -> None:
        """Save the parameters in the EEPROM, which has a limited number of writes [4.3.17]."""
        self._check(BY_NAME["save_parameters"], self._send_once(BY_NAME["save_parameters"].code, 0), None)

    @property
    def status1(self) -> Status1:
        """Status register 1; reads it from the device."""
        return Status1(self.read("status1") & 0xFF)

    @property
    def status2(self) -> Status2:
        """Status register 2; reads it from the device."""
        return Status2(self.read("status2") & 0xFF)

    @property
    def firmware(self) -> str:
        """The firmware version as text; reads it from the device."""
        return firmware_text(self.read("firmware"))

    # -- motion ------------------------------------------------------------------------------

    @override
    def look(self) -> ControllerView:
        """Read status register 1, then the position, which is final if the motor is not moving."""
        status = self.status1
        return ControllerView(self.position, bool(status & (Status1.BUSY | Status1.HOME)), status & NAMED)

    def start_move(self, steps: int) -> int:
        """Start a move by a signed number of steps; return its target.

        Raises:
            ValueError: the number of steps is 0 or too large.
        """
        if not 1 <= abs(steps) <= BY_NAME["step"].high:  # type: ignore[operator]
            raise ValueError(f"{steps} steps: must be 1 to {BY_NAME['step'].high} in either direction")
        self.set("direction", int(steps > 0))
        return self._start(BY_NAME["step"], abs(steps)).position + steps

    def home(self, stroke: int, progress: Progress = lambda _: None) -> int:
        """Move back to the switch on EXT1, and wait; return the position at the switch.

        The switch is found if EXT1 is active at the end and was free before, or if the motor moved back: with
        a stuck switch, EXT1 is always active, and the motor only retreats.

        Args:
            stroke: longest travel, in steps.
            progress: called with the position.

        Raises:
            ValueError: the stroke is out of range.
            StoppedError: the switch was not found, or is stuck.
        """
        row = BY_NAME["zero_back"]
        if not row.allows(stroke):
            raise ValueError(f"stroke {stroke}: must be {row.allowed}")
        search = _Search(self._on_switch)
        self._start(row, stroke, moves=False)  # a short motion may end before the first read

        def note_position(position: int) -> None:
            search.look(position)
            progress(position)

        state = self.watch(note_position, 0 if search.began_on_switch else POLL_S)
        end_text = f"zero-back ended at {state.position}"
        with stopped_when_lost(self.stop):
            if not self._on_switch() or state.errors & (Status1.EXT2 | Status1.STALL):
                raise StoppedError(f"{end_text} without the switch{self.reasons(state.errors)}")
            if not search.was_free:
                switch_text = "with the switch active all the time; it may be stuck"
                raise StoppedError(f"{end_text} {switch_text}{self.reasons(state.errors)}")
        return state.position

    def run(self) -> None:
        """Run at the maximum speed in the selected direction, until `slow_down` or `stop`."""
        self._start(BY_NAME["speed_mode"], 1)

    def slow_down(self) -> None:
        """Ramp down from speed mode; raise RefusedError if the motor is still in speed mode."""
        self._check(BY_NAME["speed_mode"], self._exchange(BY_NAME["speed_mode"].code, 0), None)
        if self.status2 & Status2.SPEED_MODE:
            raise RefusedError("speed_mode 0 was answered, but the motor is still in speed mode")

    # -- inside ------------------------------------------------------------------------------

    @override
    def halt(self) -> None:
        """Stop at once, without a ramp; repeat the request until the device answers."""
        self.do("abort")

    @override
    def pause(self, seconds: float) -> None:
        self._link.pause(seconds)

    @override
    def reasons(self, errors: int) -> str:
        error_names = ", ".join(str(bit.name) for bit in Status1(errors))
        return f": {error_names}" if error_names else ""

    def _start(self, row: InstructionRow, data: int, *, moves: bool = True) -> ControllerView:
        """Send an instruction once; return the state before it, see `begin`."""

        def send() -> None:
            self._check(row, self._send_once(row.code, data), None)

        return self.begin(row.name, send, moves=moves)

    def _on_switch(self) -> bool:
        """Return whether EXT1 is at the level that follows its configured edge."""
        rising = self.read("ext_trigger_mode") & 1
        return (self.read("levels") >> 2 & 1) == rising

    def _check(self, row: InstructionRow, response: int, value: int | None) -> None:
        """Raise RefusedError for response 6 or 7, unless that is the value that was set."""
        if response in _ERRORS and response != value:
            raise RefusedError(f"{row.name} is refused with error {_ERRORS[response]}")

    def _exchange(self, code: int, data: int) -> int:
        """Send an instruction, up to `TRIES` times; return the answer's data."""
        return until_answered(lambda: self._send_once(code, data))

    def _send_once(self, code: int, data: int, new_address: int | None = None) -> int:
        """Send an instruction once; return the data of the answer, which can come from a new address."""
        drain(self._link, self._quiet_s)
        self._quiet_s = self._answer_s + LATE_S
        self.faults += 1  # until a valid answer arrives
        self._link.send(command(self.address, code, data))
        received = self._link.receive(FRAME_BYTES, self._answer_s)
        frames = Framer().feed(received)
        if len(received) < FRAME_BYTES:
            raise NoAnswerError(
                f"address {self.address} does not answer within {self._answer_s:g} s", received
            )
        if not frames or frames[0].second != REPLY:
            raise BadResponseError(f"a damaged answer from address {self.address}", received)
        if frames[0].third not in (self.address, new_address):
            raise BadResponseError(f"an answer from address {frames[0].third}, not {self.address}", received)
        self._quiet_s = SILENCE_S
        self.faults -= 1
        return frames[0].data
