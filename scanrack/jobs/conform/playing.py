"""Plays scenes on a path to a module: words out, images in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.image import Image
from scanrack.io_images.times import time_text

from .moments import ImageWords, PlayedScene, SeenImage, Transmission, Window
from .plan import PlannedScene, ScenePlan, SceneStep

STILL_NS = 20_000_000
"""A read that shows what the one before showed is kept after this time."""

AHEAD_NS = 20_000_000
"""Longest time by which parameters go ahead of their command bit."""


HALT_NS = 40_000_000
"""How long each word of a halt stays."""

RESET, STOP = CommandMsw.RESET_ERRORS.value, CommandMsw.IMMEDIATE_STOP.value


class ModulePath(Protocol):
    """The way to a module. Windows are of one clock, which never goes back."""

    def now_ns(self) -> int:
        """Return the time of the clock that waits go by."""

    def write(self, words: ImageWords) -> Window:
        """Set the eight output words."""

    def operate(self, inputs: int) -> Window:
        """Set the levels of the wired inputs, a mask of `InputBit`."""

    def read(self) -> SeenImage:
        """Read the input image."""


def play(scene: PlannedScene, path: ModulePath, plan: ScenePlan) -> PlayedScene:
    """Play a scene; an interrupted one leaves zero words behind.

    Raises:
        OSError: the path is lost.
    """
    return _Player(path, plan).play(scene)


def halt(path: ModulePath) -> None:
    """Stop the axis: Immediate Stop until an image shows no motion, then zero words.

    Raises:
        OSError: the path is lost.
    """
    for command in (RESET, STOP):  # under a command error nothing but Reset Errors is accepted
        path.write((0,) * 8)
        _pass(path, HALT_NS)
        path.write((command, *(0,) * 7))
        _pass(path, HALT_NS)
    path.write((0,) * 8)


def _pass(path: ModulePath, time_ns: int) -> None:
    end_ns = path.now_ns() + time_ns
    while path.now_ns() < end_ns:
        path.read()


class _Player:
    def __init__(self, path: ModulePath, plan: ScenePlan) -> None:
        self._path, self._plan = path, plan
        self._outputs = Image()
        self._played = PlayedScene("")

    def play(self, scene: PlannedScene) -> PlayedScene:
        self._played = PlayedScene(scene.name)
        whole = False
        try:
            for step in scene.steps:
                self._step(step)
                if self._played.note:
                    break
            whole = not self._played.note
        finally:
            if not whole:
                halt(self._path)
        return self._played

    def _step(self, step: SceneStep) -> None:
        if step.step is None:
            window = self._path.operate(step.inputs)
            self._played.moments.append(Transmission(window, None, step.inputs))
        else:
            before = tuple(self._outputs)
            step.step.write(self._outputs)
            self._send(before, tuple(self._outputs))
        begin_ns, least_ns = (
            self._path.now_ns(),
            2 * self._plan.timing.lag_ns,
        )  # its words have acted, and show
        self._read_until(
            lambda image, lasted: lasted >= least_ns and step.over(image, lasted), begin_ns, step
        )

    def _send(self, before: ImageWords, words: ImageWords) -> None:
        """Send words: parameters ahead of a new command bit, so that a torn write harms nothing."""
        rises = words[0] & ~before[0] or words[1] & ~before[1]
        ahead = (before[0], before[1], *words[2:])
        if rises and ahead != before and not before[0]:
            self._write(ahead)
            least = self._path.now_ns()
            wait_ns = min(2 * self._plan.timing.lag_ns, AHEAD_NS)
            self._read_until(lambda _image, lasted: lasted >= wait_ns, least, None)
        if words != before or not self._played.moments:
            self._write(words)

    def _write(self, words: ImageWords) -> None:
        self._played.moments.append(Transmission(self._path.write(words), words))

    def _read_until(self, over: Callable[[Image, int], bool], begin_ns: int, step: SceneStep | None) -> None:
        kept: SeenImage | None = None
        while True:
            seen = self._path.read()
            still = kept is not None and seen.words == kept.words
            if not still or kept is None or seen.window.low_ns - kept.window.low_ns >= STILL_NS:
                self._played.moments.append(seen)
                kept = seen
            lasted = self._path.now_ns() - begin_ns
            if over(Image(seen.words), lasted):
                return
            if lasted > self._plan.limit_ns:
                line = step.step.line if step is not None and step.step is not None else 0
                self._played.note = f"a step took longer than {time_text(self._plan.limit_ns)} (line {line})"
                return
