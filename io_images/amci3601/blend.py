"""The blocks that program a blend profile [chapter 5, Blend Move Programming].

    word  first block                     blocks 2 to 17, one per segment
    0     0                               0
    1     0300h: program and transmit     0300h: program and transmit
    2     number of segments              length MSW (thousands of steps)
    3     types of segments 9 to 16       length LSW
    4     types of segments 1 to 8        speed MSW (thousands of steps/s)
    5     final deceleration and type     speed LSW
    6     0                               rate, steps/ms/s
    7     0                               0

The module reads a block when bit 9 of word 1 rises and answers with BLEND_ACK.
Clearing only bit 9 (word 1 = 0100h) makes the module clear BLEND_ACK and wait for the next block. Clearing
bit 8 as well ends programming.

These classes read only words that they can write; the module also accepts other words (reading A-60).
"""

from __future__ import annotations

from dataclasses import field
from enum import Enum

from ..dataclass import dataclass
from ..image import Image
from ..thousands import PARAMETER_MAX, join_thousands, split_thousands
from .bits import CommandLsw
from .parameters import LIMITS_3601, Limits, require, require_member

SEGMENTS_MIN = 2
SEGMENTS_MAX = 16

PROGRAM_AND_TRANSMIT = (CommandLsw.BLEND_PROGRAM | CommandLsw.BLEND_TRANSMIT).value
"""Word 1 of every block: 0300h."""

_TYPES_PER_WORD = 8
_TYPE_SHIFT = 14
_RATE_MASK = (1 << _TYPE_SHIFT) - 1


class Acceleration(Enum):
    """Acceleration type; the value is the pair of bits, with the S-curve bit first.

    The pair 10b is invalid: the second bit counts only with the first
    [chapter 5, Command Word LSW bit 1].
    """

    CONSTANT = 0b00
    TRIANGULAR = 0b01
    TRAPEZOIDAL = 0b11


def acceleration_of(pair: int) -> Acceleration:
    """Return the acceleration type of a bit pair; raise a ValueError for 10b."""
    try:
        return Acceleration(pair)
    except ValueError:
        raise ValueError(f"acceleration type {pair:02b}b: must be 00b, 01b or 11b") from None


@dataclass(frozen=True, slots=True)
class BlendHeader:
    """The first block: number of segments, their acceleration types, and the end of the profile.

    >>> header = BlendHeader((Acceleration.CONSTANT, Acceleration.TRIANGULAR), 20)
    >>> header.to_image()
    Image([0, 768, 2, 0, 4, 20, 0, 0])

    Raises:
        ValueError: the number of segments or a rate is out of range.
    """

    types: tuple[Acceleration, ...]  # acceleration type of each segment, 2 to 16 of them
    final_deceleration: int  # 1 to 2000 steps/ms/s, from the last segment's speed to the starting speed
    final_type: Acceleration = Acceleration.CONSTANT
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # the module's

    def __post_init__(self) -> None:
        require("number of blend segments", self.segments, SEGMENTS_MIN, SEGMENTS_MAX)
        for acceleration in (*self.types, self.final_type):
            require_member("acceleration type", acceleration, Acceleration)
        require("final deceleration", self.final_deceleration, 1, self.limits.rate)

    @property
    def segments(self) -> int:
        """Number of segments."""
        return len(self.types)

    def to_image(self) -> Image:
        """Return the output image that transmits this block."""
        last_rate = self.final_deceleration | self.final_type.value << _TYPE_SHIFT
        late_types, early_types = (
            _packed_types(self.types[_TYPES_PER_WORD:]),
            _packed_types(self.types[:_TYPES_PER_WORD]),
        )
        return Image((0, PROGRAM_AND_TRANSMIT, self.segments, late_types, early_types, last_rate))

    @classmethod
    def from_image(cls, image: Image) -> BlendHeader:
        """Read the output image of a first block; raise a ValueError for any other image."""
        words = [word & 0xFFFF for word in image]
        require("number of blend segments", words[2], SEGMENTS_MIN, SEGMENTS_MAX)
        type_pairs = words[4] | words[3] << 16
        types = tuple(acceleration_of(type_pairs >> 2 * index & 3) for index in range(words[2]))
        header = cls(types, words[5] & _RATE_MASK, acceleration_of(words[5] >> _TYPE_SHIFT))
        _require_equal(header.to_image(), image, "first block of a blend profile")
        return header


@dataclass(frozen=True, slots=True)
class BlendSegment:
    """The block of one segment: a relative move from the final speed of the previous one.

    >>> BlendSegment(3_500, 12_345, 20).to_image()
    Image([0, 768, 3, 500, 12, 345, 20, 0])

    Raises:
        ValueError: a value is out of range.
    """

    length: int  # 1 to 8,388,607 steps, including the change of speed
    speed: int  # 1 to 1,000,000 steps/s
    rate: int  # rate of the change of speed, 1 to 2000 steps/ms/s
    limits: Limits = field(default=LIMITS_3601, kw_only=True, compare=False, repr=False)  # the module's

    def __post_init__(self) -> None:
        require("length of a blend segment", self.length, 1, PARAMETER_MAX)
        require("speed of a blend segment", self.speed, 1, self.limits.speed)
        require("rate of a blend segment", self.rate, 1, self.limits.rate)

    def to_image(self) -> Image:
        """Return the output image that transmits this block."""
        return Image(
            (0, PROGRAM_AND_TRANSMIT, *split_thousands(self.length), *split_thousands(self.speed), self.rate)
        )

    @classmethod
    def from_image(cls, image: Image) -> BlendSegment:
        """Read the output image of a segment's block; raise a ValueError for any other image."""
        words = image.words.tolist()
        segment = cls(join_thousands(words[2], words[3]), join_thousands(words[4], words[5]), words[6])
        _require_equal(segment.to_image(), image, "segment block of a blend profile")
        return segment


def _packed_types(types: tuple[Acceleration, ...]) -> int:
    return sum(kind.value << 2 * index for index, kind in enumerate(types))


def _require_equal(written: Image, image: Image, block: str) -> None:
    if written != image:
        raise ValueError(f"words {list(image)} are not a {block}: the nearest one is {list(written)}")
