"""A lamp unit: output word 0, bit 0 makes it blink; input word 0, bit 0 is the lamp, word 1 the flashes."""

from typing import Annotated

from pydantic import Field
from scanrack.modules import BitPlace, Event, Image, ModuleRecord, ModuleWords, Options

REST = tuple(f"word{number}" for number in range(2, 8))
WORDS = ModuleWords(
    "Blinker",
    outputs=("control", "word1", *REST),
    inputs=("state", "flashes", *REST),
    groups={"command": {"ON": BitPlace("O", 0, 0)}, "status": {"LIT": BitPlace("I", 0, 0)}},
)


class BlinkerOptions(Options):
    """What a rack file can set."""

    owner = "blinker"
    half_ms: Annotated[int, Field(ge=1, le=10_000)] = 500  # time on, and time off


class Blinker:
    """It blinks while it is on."""

    def __init__(self, options: BlinkerOptions) -> None:
        self.events: list[Event] = []
        self._half_ns = options.half_ms * 1_000_000
        self._inputs = Image()
        self._on_since_ns: int | None = None  # when its output bit came on
        self._now_ns = 0

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Continue to an instant with these outputs; return the inputs of that instant."""
        if not outputs.bit(0, 0):
            self._on_since_ns = None
        elif self._on_since_ns is None:
            self._on_since_ns = self._now_ns  # the outputs are in force since the last call
        self._now_ns = now_ns
        halves = None if self._on_since_ns is None else (now_ns - self._on_since_ns) // self._half_ns
        self._inputs.set_bit(0, 0, halves is not None and halves % 2 == 0)
        self._inputs[1] = 0 if halves is None else (halves // 2 + 1) % 10_000
        return self._inputs

    def plc_run(self, running: bool) -> None:
        """It continues without a running controller."""

    def power_cycle(self) -> None:
        """It restarts if it is on."""
        self._on_since_ns = None


RECORD = ModuleRecord(
    name="blinker",
    words=lambda _: WORDS,
    option_table=lambda: BlinkerOptions,
    make=lambda *, options, **_: Blinker(BlinkerOptions.of(options)),
)
