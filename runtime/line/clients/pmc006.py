"""A client of a PMC006x3s: everything by name, over one line, one question at a time.

A reply does not say which instruction it answers [4.1.1], so the line is kept
silent before every question, and longer after an answer that did not come: a
late or a doubled answer is dropped, and not taken for the next one.

Values are read by read instructions. Seven parameters have none; their setting
instructions may or may not read with data 0: the manual says that "some" do
[4.1.1]. On a controller where one does not, asking would set the parameter to 0,
so it is done only on request. The address is never asked for so: an address out
of range cuts the controller off [4.1.2], and every answer carries it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from typing_extensions import override

from ....io_images.pmc006.frame import FRAME_BYTES, REPLY, STATE_ERROR, UNKNOWN_ERROR, Framer, command
from ....io_images.pmc006.instructions import BY_NAME, INSTRUCTIONS, PARAMETERS, Instruction, Kind
from ....io_images.pmc006.status import Status1, Status2, firmware_text
from .link import (
    ANSWER_S,
    LATE_S,
    POLL_S,
    SILENCE_S,
    BadAnswerError,
    Link,
    NoAnswerError,
    Progress,
    RefusedError,
    StoppedError,
    checked_answer_s,
    drain,
    until_answered,
)
from .names import settable
from .watching import MotionClient, Seen, stopped_when_lost

_ERRORS = {
    STATE_ERROR: "6: its state does not allow it, or the value is out of range",
    UNKNOWN_ERROR: "7: it does not know the instruction, or the limit in that direction is reached",
}
_MOTIONS = ("step", "zero_back", "speed_mode", "run_user_program")


ADDRESS = "device_address"
"""Every answer carries it."""

READABLE: dict[str, Instruction] = {
    row.shows or row.name.removeprefix("read_"): row for row in INSTRUCTIONS if row.kind is Kind.READ
}
"""What can be read by a read instruction, and by which."""

BY_ZERO: dict[str, Instruction] = {
    row.name: row for row in PARAMETERS if row.asks_by_zero and row.name != ADDRESS
}
"""What may be readable by its setting instruction with data 0; the manual offers no reading of the rest."""

SETTABLE: dict[str, Instruction] = {
    row.name: row
    for row in sorted(INSTRUCTIONS, key=lambda row: row.name)
    if row.kind is Kind.SET and row.name != "speed_mode"
}
"""What can be set."""

NAMED = Status1.EXT1 | Status1.EXT2 | Status1.STALL | Status1.UVL
"""The bits of status register 1 that say why a motion was not made, or not well."""


def _unreadable(name: str, readable: Iterable[str]) -> str:
    """Return why a value can't be read."""
    if name in BY_ZERO:
        return (
            f"{name} has no read instruction. Its setting instruction with data 0 may read it or set it to 0 "
            "[4.1.1: some read]; it is sent with --by-zero (by_zero=True) only"
        )
    return f"{name} can't be read: can be {', '.join(readable)}"


class _Search:
    """What is seen of the switch during a zero-back.

    Attributes:
        began_on_switch: it was active at the start.
        was_free: it was seen free, or the motor going back, which it does only from a free switch [4.3.13].
    """

    def __init__(self, on_switch: Callable[[], bool]) -> None:
        self._on_switch = on_switch
        self._furthest: int | None = None
        self.began_on_switch = on_switch()
        self.was_free = not self.began_on_switch

    def look(self, position: int) -> None:
        """Take a position, and look at the switch as long as it has not been seen free."""
        if self.was_free:
            return
        went_back = self._furthest is not None and position < self._furthest
        self._furthest = position
        self.was_free = went_back or not self._on_switch()


class Pmc006Client(MotionClient[Seen]):
    """A controller at the other end of a line.

    Args:
        link: the line, 9,600 baud, 8N1.
        address: of the controller.
        answer_s: how long an answer may take, 0.01 to 60 s.
        by_zero: also read what is in `BY_ZERO`.
    """

    def __init__(
        self, link: Link, address: int = 255, *, answer_s: float = ANSWER_S, by_zero: bool = False
    ) -> None:
        if not 1 <= address <= 120 and address != 255:
            raise ValueError(f"address {address}: allowed is 1 to 120, or 255 as from the factory")
        super().__init__()
        self._link = link
        self._answer_s = checked_answer_s(answer_s)
        self._readable = READABLE | BY_ZERO if by_zero else READABLE
        self.address = address
        self._quiet_s = SILENCE_S

    # -- by name -----------------------------------------------------------------------------

    @property
    def readable(self) -> tuple[str, ...]:
        """The names that `read` takes, sorted."""
        return tuple(sorted({*self._readable, ADDRESS}))

    def read(self, name: str) -> int:
        """Return a value by its name in `readable`.

        Raises:
            ValueError: it can't be read.
            LinkError: no good answer.
        """
        if name == ADDRESS:
            self.read("status1")
            return self.address
        row = self._readable.get(name)
        if row is None:
            raise ValueError(_unreadable(name, self.readable))
        return self._asked(row.code, 0)

    def set(self, name: str, value: int) -> None:
        """Set a parameter by its name in `SETTABLE`; where it can be read, it is read back.

        It is in force until power goes; `save` keeps what can be kept.

        Raises:
            ValueError: it can't be set, or not to that.
            LinkError: no good answer, or the controller refuses it.
        """
        row = settable(SETTABLE, name, value)
        if name == ADDRESS:
            self._set_address(row, value)
            return
        answer = self._asked(row.code, value)
        self._check(row, answer, value)
        shown = "position" if name == "set_position" else name
        if shown in self._readable and (kept := self.read(shown)) != value:
            raise RefusedError(f"{name} was set to {value} and reads {kept}")

    def do(self, name: str, data: int = 0) -> None:
        """Carry out an action that may be carried out twice, such as clearing a flag.

        Raises:
            ValueError: it starts a motion, or is not an action.
            LinkError: no good answer, or the controller refuses it.
        """
        row = BY_NAME.get(name)
        if row is None or row.kind is not Kind.ACTION or name in _MOTIONS:
            raise ValueError(f"{name} is not an action that may be carried out twice")
        self._check(row, self._asked(row.code, data), None)

    def clear(self) -> None:
        """Clear the emergency stops of EXT1 and EXT2, and read them.

        Raises:
            LinkError: no good answer, or stops that stay.
        """
        self.do("clear_ext1_flag")
        self.do("clear_ext2_flag")
        if left := self.status1 & (Status1.EXT1 | Status1.EXT2):
            raise RefusedError(f"the emergency stops were cleared and are still set{self.reasons(left)}")

    def save(self) -> None:
        """Keep the parameters in force in the EEPROM, which does not last for ever [4.3.17].

        Raises:
            LinkError: no good answer.
        """
        self._check(BY_NAME["save_parameters"], self._once(BY_NAME["save_parameters"].code, 0), None)

    @property
    def status1(self) -> Status1:
        """Status register 1, read."""
        return Status1(self.read("status1") & 0xFF)

    @property
    def status2(self) -> Status2:
        """Status register 2, read."""
        return Status2(self.read("status2") & 0xFF)

    @property
    def firmware(self) -> str:
        """The firmware version as text, read."""
        return firmware_text(self.read("firmware"))

    @property
    def position(self) -> int:
        """The position register, read; steps."""
        return self.read("position")

    # -- motion ------------------------------------------------------------------------------

    @override
    def look(self) -> Seen:
        """Read status register 1, then the position, which is final if nothing moved."""
        status = self.status1
        return Seen(self.position, bool(status & (Status1.BUSY | Status1.HOME)), status & NAMED)

    def start_move(self, steps: int) -> int:
        """Start a move over so many steps, its sign the direction; return where it should end.

        Raises:
            ValueError: 0, or too many steps.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        if not 1 <= abs(steps) <= BY_NAME["step"].high:  # type: ignore[operator]
            raise ValueError(f"{steps} steps: allowed is 1 to {BY_NAME['step'].high} in either direction")
        self.set("direction", int(steps > 0))
        return self._start(BY_NAME["step"], abs(steps)).position + steps

    def move(self, steps: int, progress: Progress = lambda _: None) -> int:
        """Move over so many steps and wait for the end; return the position.

        Raises:
            ValueError: 0, or too many steps.
            StoppedError: it ended elsewhere, or with a stall; the message says why.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        target = self.start_move(steps)
        seen = self.watch(progress)
        with stopped_when_lost(self.stop):
            self.check_end("move", seen, target)
            self.check_errors("move", seen)
        return seen.position

    def home(self, stroke: int, progress: Progress = lambda _: None) -> int:
        """Go back to the switch on EXT1 and wait for it; return the position there.

        It counts as found if EXT1 is at its active level at the end and was seen to be free before, or the
        motor was seen to go back: a switch that is stuck is active all the time, and the motor only retreats.

        Args:
            stroke: the most that it may travel, in steps.
            progress: called with the position.

        Raises:
            ValueError: no such stroke.
            StoppedError: the switch was not found, or is stuck.
            LostSightError: the line failed when it had been started.
            LinkError: it was refused, or it is not known to have begun.
        """
        row = BY_NAME["zero_back"]
        if not row.allows(stroke):
            raise ValueError(f"stroke {stroke}: allowed is {row.allowed}")
        search = _Search(self._on_switch)
        self._start(row, stroke, moves=False)  # short ones are over before a look; the switch shows the end

        def looked(position: int) -> None:
            search.look(position)
            progress(position)

        seen = self.watch(looked, 0 if search.began_on_switch else POLL_S)
        ended = f"zero-back ended at {seen.position}"
        with stopped_when_lost(self.stop):
            if not self._on_switch() or seen.errors & (Status1.EXT2 | Status1.STALL):
                raise StoppedError(f"{ended} without the switch{self.reasons(seen.errors)}")
            if not search.was_free:
                stuck = "with the switch active all the time, as if it were stuck"
                raise StoppedError(f"{ended} {stuck}{self.reasons(seen.errors)}")
        return seen.position

    def run(self) -> None:
        """Run at the maximum speed in the chosen direction, until `slow_down` or `stop`.

        Raises:
            LinkError: it was refused, or it is not known to have begun.
        """
        self._start(BY_NAME["speed_mode"], 1)

    def slow_down(self) -> None:
        """Leave speed mode by the ramp, and look whether it was left.

        Raises:
            LinkError: no good answer, or the motor is still in speed mode.
        """
        self._check(BY_NAME["speed_mode"], self._asked(BY_NAME["speed_mode"].code, 0), None)
        if self.status2 & Status2.SPEED_MODE:
            raise RefusedError("speed_mode 0 was answered, and the motor is still in speed mode")

    # -- inside ------------------------------------------------------------------------------

    @override
    def halt(self) -> None:
        """Stop at once, without a ramp; asked again until it is answered."""
        self.do("abort")

    @override
    def pause(self, seconds: float) -> None:
        self._link.pause(seconds)

    @override
    def reasons(self, errors: int) -> str:
        named = ", ".join(str(bit.name) for bit in Status1(errors))
        return f": {named}" if named else ""

    def _start(self, row: Instruction, data: int, *, moves: bool = True) -> Seen:
        return self.begin(row.name, lambda: self._check(row, self._once(row.code, data), None), moves=moves)

    def _on_switch(self) -> bool:
        """Return whether EXT1 is at the level to which its edge leads."""
        rising = self.read("ext_trigger_mode") & 1
        return (self.read("levels") >> 2 & 1) == rising

    def _set_address(self, row: Instruction, value: int) -> None:
        """Change the address, which counts at once: the answer may come from either."""
        former = self.address
        try:
            answer = self._once(row.code, value, value)
        except (NoAnswerError, BadAnswerError):
            self.address = value
            try:
                self.read("status1")
            except NoAnswerError:
                self.address = former
                raise
            return
        self._check(row, answer, value)
        self.address = value

    def _check(self, row: Instruction, answer: int, value: int | None) -> None:
        """Raise what an answer says; 6 and 7 are values, too, where 6 or 7 was set."""
        if answer in _ERRORS and answer != value:
            raise RefusedError(f"{row.name} is refused with error {_ERRORS[answer]}")

    def _asked(self, code: int, data: int) -> int:
        """Ask, up to `TRIES` times; return the data of the answer."""
        return until_answered(lambda: self._once(code, data))

    def _once(self, code: int, data: int, new_address: int | None = None) -> int:
        """Ask once; return the data of the answer."""
        drain(self._link, self._quiet_s)
        self._quiet_s = self._answer_s + LATE_S
        self.faults += 1
        self._link.send(command(self.address, code, data))
        received = self._link.receive(FRAME_BYTES, self._answer_s)
        frames = Framer().feed(received)
        if len(received) < FRAME_BYTES:
            raise NoAnswerError(
                f"address {self.address} does not answer within {self._answer_s:g} s", received
            )
        if not frames or frames[0].second != REPLY:
            raise BadAnswerError(f"a damaged answer from address {self.address}", received)
        if frames[0].third not in (self.address, new_address):
            raise BadAnswerError(f"an answer from address {frames[0].third}, not {self.address}", received)
        self._quiet_s = SILENCE_S
        self.faults -= 1
        return frames[0].data
