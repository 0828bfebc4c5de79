"""The 3601's commands: the eight output words in command mode and their meanings.

    word  meaning
    0     command MSW: at most one bit
    1     command LSW: acceleration type, encoder move, follower, blend, registration, proximity
    2, 3  target position, steps (thousands)
    4, 5  programmed speed, steps/s (thousands)
    6     acceleration, steps/ms/s
    7     deceleration, steps/ms/s

`to_image` and `decode` are exact inverses. `decode` is strict: it refuses words that the module would refuse,
and also words with bits that the module would ignore. `Parameters.read` accepts any words.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..dataclass import dataclass
from ..image import Image
from ..thousands import PARAMETER_MAX, PARAMETER_MIN, join_thousands, split_thousands
from .bits import CommandLsw, CommandMsw
from .moves import FindHome, Follower, Manual, Move, Resume, RunBlend, require_words
from .parameters import LIMITS_3601, Limits, require

_FOLLOWER = CommandLsw.ENC_FOLLOWER.value
_BLEND = (CommandLsw.BLEND_PROGRAM | CommandLsw.BLEND_TRANSMIT).value
_STORE = CommandLsw.STORE_MIN_REG.value
_MODE = CommandMsw.MODE_CONFIG.value


@dataclass(frozen=True, slots=True)
class Idle:
    """No command.

    Attributes:
        rest: words 1 to 7, which the module ignores. They need not be 0, because a program can stop a manual
            move by clearing only word 0. Bits 7 to 10 of word 1 are commands and must be 0.
    """

    rest: tuple[int, ...] = (0,) * 7

    def __post_init__(self) -> None:
        require_words("rest", self.rest, 7)
        if self.rest[0] & (_FOLLOWER | _BLEND | _STORE):
            raise ValueError(
                f"word 1 is {self.rest[0] & 0xFFFF:04X}h: without a command, bits 7 to 10 must be 0"
            )

    def to_image(self) -> Image:
        """Return the output image, with no bit of the command MSW set."""
        return Image((0, *self.rest))


@dataclass(frozen=True, slots=True)
class Hold:
    """Hold the running absolute or relative move; words 1 to 7 are ignored [chapter 4, Hold Move]."""

    rest: tuple[int, ...] = (0,) * 7

    def __post_init__(self) -> None:
        require_words("rest", self.rest, 7)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((CommandMsw.HOLD_MOVE.value, *self.rest))


@dataclass(frozen=True, slots=True)
class ImmediateStop:
    """Stop without a ramp; the position becomes invalid. Words 1 to 7 are ignored (reading A-30)."""

    rest: tuple[int, ...] = (0,) * 7

    def __post_init__(self) -> None:
        require_words("rest", self.rest, 7)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((CommandMsw.IMMEDIATE_STOP.value, *self.rest))


@dataclass(frozen=True, slots=True)
class PresetPosition:
    """Set position and diagnostic count, -8,388,608 to 8,388,607 steps; the position becomes valid."""

    value: int

    def __post_init__(self) -> None:
        require("preset position", self.value, PARAMETER_MIN, PARAMETER_MAX)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((CommandMsw.PRESET_POSITION.value, 0, *split_thousands(self.value)))


@dataclass(frozen=True, slots=True)
class PresetEncoder:
    """Set the encoder value, -8,388,608 to 8,388,607 counts."""

    value: int

    def __post_init__(self) -> None:
        require("preset encoder value", self.value, PARAMETER_MIN, PARAMETER_MAX)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((CommandMsw.PRESET_ENCODER.value, 0, *split_thousands(self.value)))


@dataclass(frozen=True, slots=True)
class ResetErrors:
    """Clear recoverable errors; word 1 must be 0, words 2 to 7 are ignored (reading A-92)."""

    rest: tuple[int, ...] = (0,) * 6

    def __post_init__(self) -> None:
        require_words("rest", self.rest, 6)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((CommandMsw.RESET_ERRORS.value, 0, *self.rest))


@dataclass(frozen=True, slots=True)
class StoreMinimumRegistration:
    """Store the initial distance over which a registration move ignores its input (firmware 3.1).

    >>> StoreMinimumRegistration(12_345).to_image()
    Image([0, 1024, 12, 345, 0, 0, 0, 0])
    """

    steps: int  # 0 to 8,388,607; 0 disables the function

    def __post_init__(self) -> None:
        require("minimum registration distance", self.steps, 0, PARAMETER_MAX)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((0, _STORE, *split_thousands(self.steps)))


Command = (
    Idle
    | Move
    | Hold
    | Resume
    | ImmediateStop
    | FindHome
    | Manual
    | PresetPosition
    | PresetEncoder
    | ResetErrors
    | RunBlend
    | Follower
    | StoreMinimumRegistration
)
"""All commands in command mode, except the blend programming blocks, which are in `blend`."""


_Reader = Callable[[Sequence[int], Limits], Command]


def decode(image: Image, limits: Limits = LIMITS_3601) -> Command:
    """Return the command in an output image; raise a ValueError with the reason if there is none.

    >>> decode(Image([0x0002, 0, 12, 345, 5, 0, 20, 10]))  # doctest: +ELLIPSIS
    Move(kind=<MoveKind.RELATIVE: 2>, target=12345, speed=5000, acceleration=20, deceleration=10, ...)
    """
    words = image.words.tolist()
    if words[0] & _MODE:
        raise ValueError(f"word 0 is {words[0] & 0xFFFF:04X}h: this is a configuration, not a command")
    command = _reader(words[0], words[1])(words, limits)
    encoded = command.to_image()
    if encoded != image:
        raise ValueError(f"words {words} are not a command; the nearest one is {list(encoded)}")
    return command


def _reader(msw: int, lsw: int) -> _Reader:
    """Return the function that reads a command with these two words; refuse words that are not a command."""
    if msw == 0 and lsw & _BLEND:
        raise ValueError(f"word 1 is {lsw & 0xFFFF:04X}h: this is a block of a blend profile, not a command")
    if lsw & _FOLLOWER and msw in (0, CommandMsw.MANUAL_CW, CommandMsw.MANUAL_CCW):
        return Follower.read
    if msw == 0 and lsw & _STORE:
        return lambda words, _: StoreMinimumRegistration(join_thousands(words[2], words[3]))
    if msw in _READERS:
        return _READERS[msw]
    raise ValueError(f"word 0 is {msw & 0xFFFF:04X}h: exactly one command bit of 0 to 13 is allowed")


_READERS: dict[int, _Reader] = {
    0: lambda words, _: Idle(tuple(words[1:])),
    CommandMsw.ABSOLUTE_MOVE: Move.read,
    CommandMsw.RELATIVE_MOVE: Move.read,
    CommandMsw.HOLD_MOVE: lambda words, _: Hold(tuple(words[1:])),
    CommandMsw.RESUME_MOVE: Resume.read,
    CommandMsw.IMMEDIATE_STOP: lambda words, _: ImmediateStop(tuple(words[1:])),
    CommandMsw.FIND_HOME_CW: FindHome.read,
    CommandMsw.FIND_HOME_CCW: FindHome.read,
    CommandMsw.MANUAL_CW: Manual.read,
    CommandMsw.MANUAL_CCW: Manual.read,
    CommandMsw.PRESET_POSITION: lambda words, _: PresetPosition(join_thousands(words[2], words[3])),
    CommandMsw.PRESET_ENCODER: lambda words, _: PresetEncoder(join_thousands(words[2], words[3])),
    CommandMsw.RESET_ERRORS: lambda words, _: ResetErrors(tuple(words[2:])),
    CommandMsw.RUN_BLEND_CW: lambda words, _: RunBlend.read(words),
    CommandMsw.RUN_BLEND_CCW: lambda words, _: RunBlend.read(words),
}
