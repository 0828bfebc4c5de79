"""An axis in Python that a test commands.

hand = Hand.ready()                                     # configured, position 0
command = hand.ask(lambda axis: axis.move_to(4000, **SLOW))
hand.bench.until(lambda: command.done)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bench3601 import ENCODER, configuration
from scanrack import Axis3601, Configuration, Logic
from scanrack.io_images.image import Image
from sequence_bench import SETUP, SequenceBench

Ask = Callable[[Axis3601], Any]


def configured(add: int = 0) -> Configuration:
    """Return the usual configuration with further bits of word 0."""
    return Configuration.from_image(Image(configuration(add=add)))


class OneAxis(Logic):
    """An axis that a test commands: `ask` is called with the axis in the next scan."""

    axis = Axis3601(1, SETUP)

    def __init__(self) -> None:
        self.ask: Ask | None = None
        self.command: Any = None

    def every_scan(self) -> None:
        if self.ask is not None:
            ask, self.ask = self.ask, None
            self.command = ask(self.axis)


class Hand:
    """The axis in the hand of a test."""

    def __init__(self, kind: type[OneAxis] = OneAxis, **options: Any) -> None:
        self.bench = SequenceBench(kind, **options)
        self.axis = self.bench.logic.axis

    @classmethod
    def configured(cls, kind: type[OneAxis] = OneAxis, **options: Any) -> Hand:
        """Return one whose module is configured; the position is not valid."""
        hand = cls(kind, **options)
        hand.bench.scan()
        hand.does(lambda axis: axis.configure())
        return hand

    @classmethod
    def ready(cls, kind: type[OneAxis] = OneAxis, **options: Any) -> Hand:
        """Return one at a valid position 0."""
        hand = cls.configured(kind, **options)
        hand.does(lambda axis: axis.set_position(0))
        return hand

    def ask(self, ask: Ask) -> Any:
        """Ask for a command in the next scan; return it."""
        self.bench.logic.ask = ask
        self.bench.scan()
        return self.bench.logic.command

    def does(self, ask: Ask, scans: int = 20_000) -> Any:
        """Ask for a command and let it end well."""
        command = self.ask(ask)
        self.bench.until(lambda: not command.busy, scans)
        command.result()
        return command

    def run(self, ms: int) -> Hand:
        """Let time pass."""
        self.bench.scan(ms // 2)
        return self


class Geared(OneAxis):
    """One with an encoder."""

    axis = Axis3601(1, configured(ENCODER))
