"""Plays scenes on a path to a module: writes words and reads images."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.image import Image
from scanrack.io_images.times import time_text

from .moments import ImageWords, PlayedScene, SeenImage, Transmission, Window
from .plan import PlannedScene, ScenePlan, SceneStep

STILL_NS = 20_000_000
"""Time after which a read is stored even if it shows the same words as the previous read."""

AHEAD_NS = 20_000_000
"""Longest time from sending parameters to sending their command bit, ns."""

HALT_NS = 40_000_000
"""Time for which each step of a halt stays in effect, ns."""

RESET, STOP = CommandMsw.RESET_ERRORS.value, CommandMsw.IMMEDIATE_STOP.value


class ModulePath(Protocol):
    """The path to a module. All windows use one clock, which never goes backward."""

    def now_ns(self) -> int:
        """Return the time of the clock that measures waits, ns."""

    def write(self, words: ImageWords) -> Window:
        """Set the eight output words."""

    def operate(self, inputs: int) -> Window:
        """Set the levels of the wired inputs, a mask of `InputBit`."""

    def read(self) -> SeenImage:
        """Read the input image."""


def play(scene: PlannedScene, path: ModulePath, plan: ScenePlan) -> PlayedScene:
    """Play a scene. If the scene is interrupted, stop the axis and write zero words.

    Raises:
        OSError: the path is lost.
    """
    return _Player(path, plan).play(scene)


def halt(path: ModulePath) -> None:
    """Stop the axis: send Reset Errors, Immediate Stop, and then zero words.

    Raises:
        OSError: the path is lost.
    """
    for command in (RESET, STOP):  # during a command error only Reset Errors is accepted
        path.write((0,) * 8)
        _wait(path, HALT_NS)
        path.write((command, *(0,) * 7))
        _wait(path, HALT_NS)
    path.write((0,) * 8)


def _wait(path: ModulePath, time_ns: int) -> None:
    end_ns = path.now_ns() + time_ns
    while path.now_ns() < end_ns:
        path.read()


class _Player:
    """Plays the scenes of a plan on a path."""

    def __init__(self, path: ModulePath, plan: ScenePlan) -> None:
        self._path, self._plan = path, plan
        self._outputs = Image()
        self._played = PlayedScene("")

    def play(self, scene: PlannedScene) -> PlayedScene:
        """Play a scene until it ends or one of its steps takes too long.

        Halt the axis if it did not end.
        """
        self._played = PlayedScene(scene.name)
        is_complete = False
        try:
            for step in scene.steps:
                self._step(step)
                if self._played.note:
                    break
            is_complete = not self._played.note
        finally:
            if not is_complete:
                halt(self._path)
        return self._played

    def _step(self, step: SceneStep) -> None:
        """Send a step's words or inputs; read images until they have taken effect and the step is over."""
        if step.step is None:
            window = self._path.operate(step.inputs)
            self._played.moments.append(Transmission(window, None, step.inputs))
        else:
            previous = tuple(self._outputs)
            step.step.write(self._outputs)
            self._send(previous, tuple(self._outputs))
        least_ns = 2 * self._plan.timing.lag_ns  # by then the words have acted, and images show it
        self._read_until(lambda image, lasted_ns: lasted_ns >= least_ns and step.over(image, lasted_ns), step)

    def _send(self, previous: ImageWords, words: ImageWords) -> None:
        """Send words. Parameters are sent before a new command bit, so that a torn write is harmless."""
        has_rising_bit = words[0] & ~previous[0] or words[1] & ~previous[1]
        parameters_only = (previous[0], previous[1], *words[2:])
        if has_rising_bit and parameters_only != previous and not previous[0]:
            self._write(parameters_only)
            wait_ns = min(2 * self._plan.timing.lag_ns, AHEAD_NS)
            self._read_until(lambda _image, lasted_ns: lasted_ns >= wait_ns, None)
        if words != previous or not self._played.moments:
            self._write(words)

    def _write(self, words: ImageWords) -> None:
        self._played.moments.append(Transmission(self._path.write(words), words))

    def _read_until(self, is_over: Callable[[Image, int], bool], step: SceneStep | None) -> None:
        """Read images until a condition is true, or note that the step took too long.

        Args:
            is_over: the condition, given an image and the time since the call, ns.
        """
        begin_ns = self._path.now_ns()
        kept: SeenImage | None = None  # the last read that was kept
        while True:
            read = self._path.read()
            if (
                kept is None
                or read.words != kept.words
                or read.window.low_ns - kept.window.low_ns >= STILL_NS
            ):
                self._played.moments.append(read)
                kept = read
            lasted_ns = self._path.now_ns() - begin_ns
            if is_over(Image(read.words), lasted_ns):
                return
            if lasted_ns > self._plan.limit_ns:
                line = step.step.line if step is not None and step.step is not None else 0
                self._played.note = f"a step took longer than {time_text(self._plan.limit_ns)} (line {line})"
                return
