"""The card in its slot: inputs follow what is wired to them at once, outputs follow the image.

scan n         the program reads the input word as it was at the scan's instant
the program writes the output word; lamps show it until the next one
program mode   outputs are off
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from typing_extensions import override

from ....io_images.image import Image, signed_word
from ...loop.events import Event
from ...loop.module import Module
from .options import DiscreteOptions


class Change(NamedTuple):
    """An input's contact changes.

    Attributes:
        at_ns: when.
        input: which, by its name.
        acted_on: True = operated from then on, False = released.
    """

    at_ns: int
    input: str
    acted_on: bool


class DiscreteCard(Module):
    """A card with its power on, at t = 0.

    Attributes:
        options: its wiring.
        lit: mask of the outputs that are on.

    Args:
        options: its wiring.
    """

    def __init__(self, options: DiscreteOptions | None = None) -> None:
        self.options = options or DiscreteOptions()
        self.events: list[Event] = []
        self.lit = 0
        self._levels = self.options.at_rest
        self._changes = sorted(_changes(self.options), key=lambda change: change.at_ns)
        self._next = 0
        self._runs = True
        self._image = Image()

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        while self._next < len(self._changes) and self._changes[self._next].at_ns <= now_ns:
            self._act(self._changes[self._next])
            self._next += 1
        self.lit = outputs[0] & 0xFFFF if self._runs else 0
        self._image[0] = signed_word(self._levels)
        return self._image

    @override
    def plc_run(self, running: bool) -> None:
        self._runs = running

    @override
    def power_cycle(self) -> None:
        """Nothing is volatile: contacts stay as they are, and the next image is the same."""

    def set_input(self, name: str, energised: bool) -> None:
        """Give an input a level from now on.

        Raises:
            ValueError: an unknown input.
        """
        if name not in self.options.inputs:
            known = ", ".join(self.options.inputs) or "none"
            raise ValueError(f"there is no input {name!r}: inputs are {known}")
        bit = 1 << self.options.inputs[name]
        self._levels = self._levels | bit if energised else self._levels & ~bit

    def _act(self, change: Change) -> None:
        energised = change.acted_on is not (change.input in self.options.normally_closed)
        self.set_input(change.input, energised)
        level = "energised" if energised else "de-energised"
        text = f"The {change.input} input is {level}."
        self.events.append(Event(change.at_ns, "stimulus", change.input, text, {"energised": energised}))


def _changes(options: DiscreteOptions) -> Iterator[Change]:
    for press in options.timeline:
        yield Change(press.begin_ns, press.input, True)
        if press.end_ns is not None:
            yield Change(press.end_ns, press.input, False)
