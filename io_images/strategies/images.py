"""Complete output images, from common to hostile.

    plausible    the words of a legal command
    nearly right the same with one word changed, as if by a typo or a torn update
    hostile      any command bits, with boundary numbers
    any          eight words

`output_images` mixes them in this order, so that a failing example shrinks toward a plausible one.
"""

from __future__ import annotations

from typing import TypeAlias

from hypothesis import strategies as st

from ..amci3601 import KNOWN, Firmware
from ..image import WORD_MAX, WORD_MIN, WORDS, Image, signed_word
from ..thousands import split_thousands
from .command_values import pick
from .commands import commands

Words: TypeAlias = tuple[int, ...]
"""Eight signed words."""

EDGES = (0, 1, 5, -1, 500, 1000, -999, 2000, 2001, WORD_MAX, WORD_MIN)
"""Boundary values of output words."""

COMMAND_LSWS = (0, 0, 1, 2, 3, 4)
"""Values of the command word LSW that keep a command legal."""


def parameter_words(msw: int, lsw: int, target: int, speed: int, rates: tuple[int, int]) -> Words:
    """Return eight output words with any command bits and parameters.

    >>> parameter_words(2, 0, -12_345, 5_000, (20, 10))
    (2, 0, -12, -345, 5, 0, 20, 10)

    Args:
        msw: command word MSW.
        lsw: command word LSW.
        target: steps, |target| <= 32,767,999.
        speed: steps/s, |speed| <= 32,767,999.
        rates: acceleration and deceleration, any signed words.
    """
    return (msw, lsw, *split_thousands(target), *split_thousands(speed), *rates)


def plausible_images(starting_speed: int, firmware: Firmware = KNOWN[-1]) -> st.SearchStrategy[Image]:
    """Return a strategy of images with a legal command; see `commands`."""
    return commands(starting_speed, firmware).map(lambda command: command.to_image())


def nearly_right_images(starting_speed: int, firmware: Firmware = KNOWN[-1]) -> st.SearchStrategy[Image]:
    """Return a strategy of images that differ from a legal image in at most one word."""

    def changed(image: Image, change: tuple[int, int]) -> Image:
        index, value = change
        changed_image = image.copy()
        changed_image[index] = value
        return changed_image

    change = pick(lambda index, value: (index, value), range(WORDS), EDGES)
    return st.builds(changed, plausible_images(starting_speed, firmware), change)


def _command_words(single: bool, bit: int, high: int, low: int, lsw: int) -> Words:
    return (1 << bit if single else high << 8 | low, lsw)


_ANY_COMMANDS = pick(_command_words, (True, False), range(15), range(0x80), range(0x100), COMMAND_LSWS)
"""A single command bit or any combination, equally often."""

_ANY_NUMBERS = pick(lambda *words: words, *[EDGES] * 6)


def hostile_images() -> st.SearchStrategy[Image]:
    """Return a strategy of images with any command bits (not the mode bit) and boundary numbers."""
    return st.builds(
        lambda command_words, numbers: Image((*command_words, *numbers)), _ANY_COMMANDS, _ANY_NUMBERS
    )


def any_images() -> st.SearchStrategy[Image]:
    """Return a strategy of any eight words."""
    word = st.integers(0, 0xFFFF).map(signed_word)
    return st.lists(word, min_size=WORDS, max_size=WORDS).map(Image)


def output_images(starting_speed: int, firmware: Firmware = KNOWN[-1]) -> st.SearchStrategy[Image]:
    """Return a strategy of output images from plausible to hostile, for a firmware version."""
    return st.one_of(
        plausible_images(starting_speed, firmware),
        nearly_right_images(starting_speed, firmware),
        hostile_images(),
        any_images(),
    )
