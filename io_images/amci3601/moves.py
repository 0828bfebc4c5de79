"""Motion commands [chapter 4]; `command` has all other commands and the decoder for all commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from enum import Enum, IntEnum

from ..dataclass import dataclass
from ..image import WORD_MAX, WORD_MIN, Image
from ..thousands import PARAMETER_MAX, PARAMETER_MIN, join_thousands, split_thousands
from .bits import CommandLsw, CommandMsw
from .blend import Acceleration, acceleration_of
from .parameters import LIMITS_3601, Limits, require, require_member

_SHAPE = (CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL).value
_ENCODER_MOVE = CommandLsw.ENCODER_MOVE.value
_FOLLOWER = CommandLsw.ENC_FOLLOWER.value
_PROXIMITY = CommandLsw.HOME_PROXIMITY.value
_RESUME = CommandMsw.RESUME_MOVE.value


class Direction(IntEnum):
    """Direction: CW counts up, CCW counts down [chapter 4, Absolute & Relative Moves]."""

    CW = 1
    CCW = -1


class MoveKind(Enum):
    """The meaning of a move's target."""

    ABSOLUTE = CommandMsw.ABSOLUTE_MOVE.value
    RELATIVE = CommandMsw.RELATIVE_MOVE.value


_MANUAL = {Direction.CW: CommandMsw.MANUAL_CW.value, Direction.CCW: CommandMsw.MANUAL_CCW.value}
_FIND_HOME = {Direction.CW: CommandMsw.FIND_HOME_CW.value, Direction.CCW: CommandMsw.FIND_HOME_CCW.value}
_RUN_BLEND = {Direction.CW: CommandMsw.RUN_BLEND_CW.value, Direction.CCW: CommandMsw.RUN_BLEND_CCW.value}


@dataclass(frozen=True, slots=True)
class Move:
    """An absolute or relative move, measured in steps or in encoder counts.

    >>> Move(MoveKind.RELATIVE, -12_345, 5_000, 20, 10).to_image()
    Image([2, 0, -12, -345, 5, 0, 20, 10])

    Raises:
        ValueError: a value is out of range or has the wrong type.
    """

    kind: MoveKind
    target: int  # position or signed distance, -8,388,608 to 8,388,607
    speed: int  # 1 to 1,000,000 steps/s
    acceleration: int  # 1 to 2000 steps/ms/s
    deceleration: int  # 1 to 2000 steps/ms/s
    shape: Acceleration = Acceleration.CONSTANT
    encoder: bool = False  # whether the target is in encoder counts; the ramp down begins at it
    proximity: bool = False  # the backplane home proximity bit, which a move ignores
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # of the module

    def __post_init__(self) -> None:
        require_member("kind", self.kind, MoveKind)
        require_member("shape", self.shape, Acceleration)
        require("target position", self.target, PARAMETER_MIN, PARAMETER_MAX)
        _require_profile(self.limits, self.speed, self.acceleration, self.deceleration)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        lsw = self.shape.value | self.encoder * _ENCODER_MOVE | self.proximity * _PROXIMITY
        return _image(self.kind.value, lsw, self.target, self.speed, self.acceleration, self.deceleration)

    @classmethod
    def read(cls, words: Sequence[int], limits: Limits = LIMITS_3601) -> Move:
        """Read the command from output words; see `command.decode`."""
        return cls(
            kind=MoveKind(words[0]),
            target=join_thousands(words[2], words[3]),
            speed=join_thousands(words[4], words[5]),
            acceleration=words[6],
            deceleration=words[7],
            shape=_shape(words[1]),
            encoder=bool(words[1] & _ENCODER_MOVE),
            proximity=bool(words[1] & _PROXIMITY),
            limits=limits,
        )


@dataclass(frozen=True, slots=True)
class Resume:
    """Continue a held move to its target.

    Raises:
        ValueError: a value is out of range or has the wrong type.
    """

    speed: int  # 1 to 1,000,000 steps/s
    acceleration: int  # 1 to 2000 steps/ms/s
    deceleration: int  # 1 to 2000 steps/ms/s
    shape: Acceleration = Acceleration.CONSTANT  # may differ from the held move's
    proximity: bool = False  # the backplane home proximity bit, which a move ignores
    target_words: tuple[int, int] = (0, 0)  # words 2 and 3, ignored
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # of the module

    def __post_init__(self) -> None:
        require_member("shape", self.shape, Acceleration)
        _require_profile(self.limits, self.speed, self.acceleration, self.deceleration)
        require_words("target_words", self.target_words, 2)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        lsw = self.shape.value | self.proximity * _PROXIMITY
        image = _image(_RESUME, lsw, 0, self.speed, self.acceleration, self.deceleration)
        image[2], image[3] = self.target_words
        return image

    @classmethod
    def read(cls, words: Sequence[int], limits: Limits = LIMITS_3601) -> Resume:
        """Read the command from output words; see `command.decode`."""
        return cls(
            speed=join_thousands(words[4], words[5]),
            acceleration=words[6],
            deceleration=words[7],
            shape=_shape(words[1]),
            proximity=bool(words[1] & _PROXIMITY),
            target_words=(words[2], words[3]),
            limits=limits,
        )


@dataclass(frozen=True, slots=True)
class FindHome:
    """Search for the home signal; the target is 0, and S-curves are not possible.

    Raises:
        ValueError: a value is out of range or has the wrong type.
    """

    direction: Direction  # first direction; it needs an end limit configured on that side
    speed: int  # 1 to 1,000,000 steps/s
    acceleration: int  # 1 to 2000 steps/ms/s
    deceleration: int  # 1 to 2000 steps/ms/s
    proximity: bool = False  # the backplane home proximity bit; when it rises, the axis slows down
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # of the module

    def __post_init__(self) -> None:
        require_member("direction", self.direction, Direction)
        _require_profile(self.limits, self.speed, self.acceleration, self.deceleration)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        lsw = self.proximity * _PROXIMITY
        msw = _FIND_HOME[self.direction]
        return _image(msw, lsw, 0, self.speed, self.acceleration, self.deceleration)

    @classmethod
    def read(cls, words: Sequence[int], limits: Limits = LIMITS_3601) -> FindHome:
        """Read the command from output words; see `command.decode`."""
        speed = join_thousands(words[4], words[5])
        proximity = bool(words[1] & _PROXIMITY)
        return cls(_direction(_FIND_HOME, words[0]), speed, words[6], words[7], proximity, limits=limits)


@dataclass(frozen=True, slots=True)
class Manual:
    """A manual move, which runs while its bit is set; with `registration`, a registration move.

    >>> Manual(Direction.CW, 5_000, 20, 10).to_image()
    Image([128, 0, 0, 0, 5, 0, 20, 10])

    Raises:
        ValueError: a value is out of range or has the wrong type.
    """

    direction: Direction
    speed: int  # 0 to 1,000,000 steps/s; 0 makes one step; without a ramp up to the starting speed
    acceleration: int = 0  # 0 to 2000 steps/ms/s; above the starting speed at least 1
    deceleration: int = 0  # 0 to 2000 steps/ms/s; above the starting speed at least 1
    registration: int = 0  # steps after the stop command, 0 to 8,388,607 (firmware 3.1)
    shape: Acceleration = Acceleration.CONSTANT
    proximity: bool = False  # the backplane home proximity bit, which a move ignores
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # of the module

    def __post_init__(self) -> None:
        require_member("direction", self.direction, Direction)
        require_member("shape", self.shape, Acceleration)
        require("programmed speed", self.speed, 0, self.limits.speed)
        require("registration distance", self.registration, 0, PARAMETER_MAX)
        require("acceleration", self.acceleration, 0, self.limits.rate)
        require("deceleration", self.deceleration, 0, self.limits.rate)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        lsw = self.shape.value | self.proximity * _PROXIMITY
        msw = _MANUAL[self.direction]
        return _image(msw, lsw, self.registration, self.speed, self.acceleration, self.deceleration)

    @classmethod
    def read(cls, words: Sequence[int], limits: Limits = LIMITS_3601) -> Manual:
        """Read the command from output words; see `command.decode`."""
        return cls(
            direction=_direction(_MANUAL, words[0]),
            speed=join_thousands(words[4], words[5]),
            acceleration=words[6],
            deceleration=words[7],
            registration=join_thousands(words[2], words[3]),
            shape=_shape(words[1]),
            proximity=bool(words[1] & _PROXIMITY),
            limits=limits,
        )


@dataclass(frozen=True, slots=True)
class RunBlend:
    """Run the stored blend profile; all other words are 0."""

    direction: Direction

    def __post_init__(self) -> None:
        require_member("direction", self.direction, Direction)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        return Image((_RUN_BLEND[self.direction],))

    @classmethod
    def read(cls, words: Sequence[int]) -> RunBlend:
        """Read the command from output words; see `command.decode`."""
        return cls(_direction(_RUN_BLEND, words[0]))


@dataclass(frozen=True, slots=True)
class Follower:
    """Encoder follower mode: steps are counts * multiplier / divisor (firmware 4.1).

    Raises:
        ValueError: a value is out of range or has the wrong type.
    """

    direction: Direction | None  # CW with the encoder, CCW against it, None to stand still in this mode
    multiplier: int  # 1 to 32,767
    divisor: int  # 1 to 32,767
    acceleration: int = 0  # 0 to 2000 steps/ms/s; 0 jumps to the new speed
    deceleration: int = 0  # 0 to 2000 steps/ms/s; 0 jumps to the new speed
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # of the module

    def __post_init__(self) -> None:
        if self.direction is not None:
            require_member("direction", self.direction, Direction)
        require("multiplier", self.multiplier, 1, WORD_MAX)
        require("divisor", self.divisor, 1, WORD_MAX)
        require("acceleration", self.acceleration, 0, self.limits.rate)
        require("deceleration", self.deceleration, 0, self.limits.rate)

    def to_image(self) -> Image:
        """Return the output image of this command."""
        msw = 0 if self.direction is None else _MANUAL[self.direction]
        words = (self.multiplier, self.divisor, 0, 0, self.acceleration, self.deceleration)
        return Image((msw, _FOLLOWER, *words))

    @classmethod
    def read(cls, words: Sequence[int], limits: Limits = LIMITS_3601) -> Follower:
        """Read the command from output words; see `command.decode`."""
        direction = _direction(_MANUAL, words[0]) if words[0] else None
        return cls(direction, words[2], words[3], words[6], words[7], limits=limits)


def require_words(name: str, words: tuple[int, ...], count: int) -> None:
    """Raise a ValueError unless there are `count` signed words."""
    if len(words) != count:
        raise ValueError(f"{name} has {len(words)} words, not {count}")
    for word in words:
        require(f"word of {name}", word, WORD_MIN, WORD_MAX)


def _require_profile(limits: Limits, speed: int, acceleration: int, deceleration: int) -> None:
    """Raise a ValueError unless a speed and its ramps are at least 1 and within the module's limits."""
    require("programmed speed", speed, 1, limits.speed)
    require("acceleration", acceleration, 1, limits.rate)
    require("deceleration", deceleration, 1, limits.rate)


def _image(msw: int, lsw: int, target: int, speed: int, acceleration: int, deceleration: int) -> Image:
    return Image((msw, lsw, *split_thousands(target), *split_thousands(speed), acceleration, deceleration))


def _shape(lsw: int) -> Acceleration:
    return acceleration_of(lsw & _SHAPE)


def _direction(bits: dict[Direction, int], msw: int) -> Direction:
    """Return the direction whose command bit equals the MSW."""
    return next(direction for direction, bit in bits.items() if bit == msw)
