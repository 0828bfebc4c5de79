"""A controller between `conform` and a simulated 3601, without sockets or clock: time passes by requests.

A request takes a random time; words reach the module, and images the controller, within a scan and an RPI.
"""

from __future__ import annotations

from random import Random
from typing import Any

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image
from scanrack.jobs.conform.moments import SeenImage, Timing, Window

MS = 1_000_000


class SimulatedPath:
    """A path to a module, see `scanrack.jobs.conform.playing.ModulePath`."""

    def __init__(
        self, module: Any, timing: Timing, seed: int = 0, request_ns: tuple[int, int] = (MS, 5 * MS)
    ) -> None:
        self.module = module
        self._timing, self._random, self._request_ns = timing, Random(seed), request_ns
        self._now_ns = 10 * MS
        self._module_ns = 0
        self._outputs = Image()
        self._due: list[tuple[int, Any]] = []

    def now_ns(self) -> int:
        return self._now_ns

    def _asked(self) -> Window:
        low = self._now_ns
        self._now_ns += self._random.randint(*self._request_ns)
        return Window(low, self._now_ns)

    def _act_within(self, window: Window, act: Any) -> Window:
        lag = self._timing.lag_ns - self._timing.module_ns
        at = self._random.randint(window.low_ns, window.high_ns + lag)
        at = max(at, self._due[-1][0] + 1 if self._due else 0)
        self._due.append((at, act))
        return window

    def write(self, words: tuple[int, ...]) -> Window:
        def act() -> None:
            for number, word in enumerate(words):
                self._outputs[number] = word

        return self._act_within(self._asked(), act)

    def operate(self, inputs: int) -> Window:
        def act() -> None:
            for bit in InputBit:
                self.module.operate(bit, bool(inputs & bit))

        return self._act_within(self._asked(), act)

    def read(self) -> SeenImage:
        window = self._asked()
        lag = self._timing.lag_ns - self._timing.module_ns
        at = max(self._random.randint(window.low_ns - lag, window.high_ns), self._module_ns)
        return SeenImage(window, self._at(at))

    def _at(self, at_ns: int) -> tuple[int, ...]:
        while self._due and self._due[0][0] <= at_ns:
            due, act = self._due.pop(0)
            self.module.update(max(due, self._module_ns), self._outputs)
            self._module_ns = max(due, self._module_ns)
            act()
        self._module_ns = at_ns
        return tuple(self.module.update(at_ns, self._outputs))
