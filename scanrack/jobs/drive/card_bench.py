"""The bench of `scanrack drive` for cards: images in and out, inputs by name."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import Field
from scanrack.io_images.image import Image
from scanrack.runtime.loop.module import Module
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.modules.record import ModuleRecord, NamedInputs

from .image_bench import NS_PER_MS, time_ms
from .requests import Level, Milliseconds, RequestError, Strict, Word, read


class CardOptions(Strict):
    """Options of a fresh bench."""

    scan_ms: Annotated[Decimal, Field(gt=0, le=10_000, decimal_places=6)] = Decimal(2)
    options: dict[str, Any] = Field(default_factory=dict)


class CardRequest(Strict):
    """A request to a card. `out` may have fewer words than the module; the other words are 0."""

    new: CardOptions | None = None
    power_cycle: Literal[True] | None = None
    plc_mode: Literal["run", "program"] | None = None
    out: list[Word] | None = None
    inputs: dict[str, Level] = Field(default_factory=dict)
    for_ms: Milliseconds = Decimal(0)
    changes: Annotated[bool, Field(strict=True)] = False


class CardBench:
    """A card on the bench."""

    def __init__(self, record: ModuleRecord) -> None:
        self._record = record
        self._renew(CardOptions())

    def _renew(self, options: CardOptions) -> None:
        """Start a fresh bench at time 0; raise RequestError for options that are not allowed."""
        try:
            self.module: Module = self._record.make(
                firmware="4.1", machine=MachineSpec(), seed=0, options=options.options, wiring=None
            )
        except ValueError as error:
            raise RequestError(f"new: {error}") from None
        if self._record.follows(options.options):
            raise RequestError("new: options.cam: this bench has no other slot")
        self.words = self._record.words(options.options)
        self.scan_ns = int(options.scan_ms * NS_PER_MS)
        self.now_ns = self.scan = 0
        self._outputs = Image(size=len(self.words.outputs))
        self._inputs = self.module.update(0, self._outputs)

    def answer(self, line: str) -> dict[str, Any]:
        """Carry out the request in a line; return the reply that `drive` prints.

        Raises:
            RequestError: a value is illegal; nothing has changed, except that a fresh bench may have started.
        """
        request = read(line, CardRequest)
        if request.new is not None:
            self._renew(request.new)
        if request.out is not None and len(request.out) > len(self.words.outputs):
            raise RequestError(f"out: {len(request.out)} words: must be at most {len(self.words.outputs)}")
        self._set_inputs(request.inputs)
        if request.power_cycle:
            self.module.power_cycle()
        if request.plc_mode is not None:
            self.module.plc_run(request.plc_mode == "run")
        if request.out is not None:
            self._outputs = Image(request.out, size=len(self.words.outputs))
        changes = self._run(-(-int(request.for_ms * NS_PER_MS) // self.scan_ns))
        return self._reply() | ({"changes": changes} if request.changes else {})

    def _set_inputs(self, levels: dict[str, int]) -> None:
        """Set the levels of inputs; raise RequestError for an input that the card lacks."""
        names = self.words.groups.get("input", {})
        for name, level in levels.items():
            if name not in names or not isinstance(self.module, NamedInputs):
                raise RequestError(f"inputs.{name}: unknown key; choose from {', '.join(names) or 'none'}")
            self.module.set_input(name, bool(level))

    def _run(self, scans: int) -> list[list[Any]]:
        """Run exchange periods; return the times and contents of changed input images.

        Without a period, the module is updated at the current time, and no change is returned.
        """
        if not scans:
            self._inputs = self.module.update(self.now_ns, self._outputs)
        changes: list[list[Any]] = []
        latest_words = list(self._inputs)
        for _ in range(scans):
            self.now_ns += self.scan_ns
            self.scan += 1
            self._inputs = self.module.update(self.now_ns, self._outputs)
            if list(self._inputs) != latest_words:
                latest_words = list(self._inputs)
                changes.append([time_ms(self.now_ns), latest_words])
        return changes

    def _energized(self, group: str, image: Image) -> list[str]:
        places = self.words.groups.get(group, {})
        return [name for name, place in places.items() if image.bit(place.word, place.bit)]

    def _reply(self) -> dict[str, Any]:
        """Return the reply: the time, the images, and the events since the last reply."""
        events = [event.text for event in self.module.events]
        self.module.events.clear()
        return {
            "t_ms": time_ms(self.now_ns),
            "scan": self.scan,
            "in": list(self._inputs),
            "bits": self._energized("input", self._inputs),
            "outputs": self._energized("output", self._outputs),
            "events": events,
        }
