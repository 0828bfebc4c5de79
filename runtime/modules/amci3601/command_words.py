"""An output image in command mode, decoded into words, bits and parameters."""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, Parameters

from ...kinematics import Profile, Shape

S_CURVE = CommandLsw.S_CURVE.value
TRAPEZOIDAL = CommandLsw.TRAPEZOIDAL.value
MODE_CONFIG = CommandMsw.MODE_CONFIG.value
COMMAND_BITS = 0x7FFF
"""Command bits of output word 0."""


class CommandWords:
    """The eight output words, decoded for the commands.

    Attributes:
        words: the eight signed words.
        msw: command word MSW, unsigned.
        lsw: command word LSW, unsigned.
        parameters: target, speed and rates; None for an invalid pair of words.
        shape: the acceleration type that the LSW selects.
    """

    __slots__ = ("lsw", "msw", "parameters", "shape", "words")

    def __init__(self, words: Sequence[int]) -> None:
        self.words = tuple(words)
        self.msw = self.words[0] & 0xFFFF
        self.lsw = self.words[1] & 0xFFFF
        self.parameters = Parameters.read(self.words)
        self.shape = shape_of(self.lsw)

    @property
    def configures(self) -> bool:
        """Whether configuration mode is requested."""
        return bool(self.msw & MODE_CONFIG)

    @property
    def many_bits(self) -> bool:
        """Whether more than one command bit is set."""
        bits = self.msw & COMMAND_BITS
        return bool(bits & (bits - 1))

    def single(self, bit: int) -> CommandWords:
        """Return these words with `bit` as the only command bit."""
        return CommandWords((bit, *self.words[1:]))

    @property
    def target_words(self) -> tuple[int, int]:
        """Output words 2 and 3."""
        return self.words[2], self.words[3]

    @property
    def speed_words(self) -> tuple[int, int]:
        """Output words 4 and 5."""
        return self.words[4], self.words[5]

    def profile(self, start_sps: int) -> Profile:
        """Return the move profile from words that have passed the range checks."""
        speed = self.parameters.speed
        assert speed is not None
        return Profile(
            start_sps, speed, self.parameters.acceleration, self.parameters.deceleration, self.shape
        )


def shape_of(lsw: int) -> Shape:
    """Return the acceleration type of a command LSW; bit 1 has an effect only with bit 0 [chapter 5].

    >>> shape_of(0b01), shape_of(0b10), shape_of(0b11)
    (<Shape.TRIANGULAR: ...>, <Shape.CONSTANT: ...>, <Shape.TRAPEZOIDAL: ...>)
    """
    if not lsw & S_CURVE:
        return Shape.CONSTANT
    return Shape.TRAPEZOIDAL if lsw & TRAPEZOIDAL else Shape.TRIANGULAR
