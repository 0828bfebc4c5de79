"""Modules of two, of 31, and of 8 + 4 words, as a user's own file has them: see docs/own-module.md.

Each repeats its output words in its input words, but for the last input word. While bit 0 of the last output
word is on, that counts milliseconds, up to 9,999.

    outputs    out0, out1, ...           the last one: bit 0 is COUNT
    inputs     in0, in1, ..., counted    in0: bit 0 is LIT, as written
"""

from functools import partial
from typing import Any

from scanrack.modules import BitPlace, Event, Image, ModuleRecord, ModuleWords, Options

SIZES = {"small": (2, 2), "large": (31, 31), "mixed": (8, 4)}
"""Number of output and of input words, by name."""


class Repeater:
    """It repeats and counts."""

    def __init__(self, outputs: int, inputs: int) -> None:
        self.events: list[Event] = []
        self._last, self._inputs = outputs - 1, Image(size=inputs)
        self._since_ns: int | None = None  # when its output bit came on
        self._now_ns = 0

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Continue to an instant with these outputs; return the inputs of that instant."""
        if not outputs.bit(self._last, 0):
            self._since_ns = None
        elif self._since_ns is None:
            self._since_ns = self._now_ns  # the outputs are in force since the last call
        self._now_ns = now_ns
        last = len(self._inputs) - 1
        for word in range(last):
            self._inputs[word] = outputs[word]
        counted = 0 if self._since_ns is None else (now_ns - self._since_ns) // 1_000_000
        self._inputs[last] = min(counted, 9_999)
        return self._inputs

    def plc_run(self, running: bool) -> None:
        """It continues without a running controller."""

    def power_cycle(self) -> None:
        """It counts again from 0."""
        self._since_ns = None


def words_of(name: str) -> ModuleWords:
    """Return the words of a module of `SIZES`."""
    outputs, inputs = SIZES[name]
    return ModuleWords(
        f"{name.title()}Repeater",
        outputs=tuple(f"out{word}" for word in range(outputs)),
        inputs=(*(f"in{word}" for word in range(inputs - 1)), "counted"),
        groups={
            "command": {"COUNT": BitPlace("O", outputs - 1, 0)},
            "status": {"LIT": BitPlace("I", 0, 0)},
        },
    )


class NoOptions(Options):
    """It has no options."""

    owner = "repeater"


def _made(name: str, *, options: Any, **_: Any) -> Repeater:
    NoOptions.of(options)
    return Repeater(*SIZES[name])


def record_of(name: str) -> ModuleRecord:
    """Return the record of a module of `SIZES`."""
    words = words_of(name)
    return ModuleRecord(
        name=name,
        words=lambda _: words,
        option_table=lambda: NoOptions,
        make=partial(_made, name),
    )


SMALL, LARGE, MIXED = map(record_of, SIZES)

MODULES = "\n".join(f'{name} = "sized.py:{name.upper()}"' for name in SIZES)
