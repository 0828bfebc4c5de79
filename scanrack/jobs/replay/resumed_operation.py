"""Replays of recordings with modules that were in operation before the first scan; see `resumed`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.amci3601 import ALL_INPUTS, Configuration
from scanrack.io_images.image import Image
from scanrack.runtime.loop.module import Module
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.traces.replay import PackedTrace

from .resumed import ResumedModule, Words, configuration_in, words_of


class ResumedOperation:
    """The slots of a recording with a 3601 that was in operation before the first scan.

    Args:
        simulated: the firmware of each simulated 3601, by slot.
        forced: whether forces were in effect, by row.
        configuration: configuration words at the beginning; None = the first that the recording shows.
        captured: whether the recording is a capture, which can begin during operation.
        sampled: whether the recording consists of a client's reads.

    Attributes:
        slots: numbers of these slots.
        modules: the modules that `around` has replaced, by slot.

    Raises:
        ValueError: `configuration` is not a valid configuration.
    """

    def __init__(
        self,
        recording: PackedTrace,
        simulated: Mapping[int, str],
        forced: Sequence[bool],
        configuration: Words | None = None,
        *,
        captured: bool = False,
        sampled: bool = False,
    ) -> None:
        self._recording, self._forced, self._sampled = recording, forced, sampled
        self._given_configuration: Words | None = None
        if configuration is not None:  # converted to check it
            self._given_configuration = tuple(Configuration.from_image(Image(configuration)).to_image())
        may_begin_late = captured or recording.numbers[0] > 0  # any other recording begins at power-up
        self.slots = [
            slot.number
            for slot in (recording.slots if may_begin_late else ())
            if slot.number in simulated and self._begins_late(slot.number, simulated[slot.number])
        ]
        self._first_shown = {slot: self._first_configuration(slot) for slot in self.slots}
        self.modules: dict[int, ResumedModule] = {}

    def _begins_late(self, slot: int, firmware: str) -> bool:
        fresh = bytes(Amci3601(firmware).update(0, Image()).raw)
        return self._recording.images((slot, "in"))[0] != fresh

    def _first_configuration(self, slot: int) -> tuple[int, Words] | None:
        """Return the first row that shows a configuration, and its words; None if no row does."""
        for row, image in enumerate(self._recording.images((slot, "in"))):
            words = configuration_in(words_of(image))
            if words is not None:
                return row, words
        return None

    def words(self, slot: int) -> Words | None:
        """Return the configuration words of a slot at the beginning; None if they are unknown."""
        first = self._first_shown[slot]
        return self._given_configuration or (None if first is None else first[1])

    @property
    def active_high(self) -> Mapping[int, int]:
        """Masks of inputs that are active when energized, by slot; slots with unknown words are omitted."""
        return {slot: words[1] & ALL_INPUTS for slot in self.slots if (words := self.words(slot)) is not None}

    def around(self, number: int, module: Module, *, exact_inputs: bool) -> Module:
        """Return a `ResumedModule` for a slot that was in operation; for other slots the module itself."""
        if number not in self.slots or not isinstance(module, Amci3601):
            return module
        resumed = ResumedModule(
            module,
            images=self._recording.images((number, "in")),
            outputs=self._recording.images((number, "out")),
            times=self._recording.times,
            forced=self._forced,
            configuration=self.words(number),
            exact_inputs=exact_inputs,
            sampled=self._sampled,
        )
        self.modules[number] = resumed
        return resumed

    def notes(self, compared: Sequence[int]) -> list[str]:
        """Return sentences about assumptions and about scans that are not compared.

        Raises:
            ValueError: nothing is known about the compared slots.
        """
        if compared and all(slot in self.modules and self._is_unknown(slot) for slot in compared):
            reason = "; ".join(f"slot {slot}: {', '.join(self.modules[slot].unknown)}" for slot in compared)
            hint = "" if self._given_configuration else "; give the missing words with --configuration"
            raise ValueError(
                f"the trace begins in the middle of operation, and nothing can be compared: {reason}{hint}"
            )
        return [note for slot in self.modules for note in self._notes_of(slot)]

    def _is_unknown(self, slot: int) -> bool:
        """Return whether no scan of a slot is compared."""
        return sum(self.modules[slot].unknown.values()) >= len(self._recording.numbers)

    def _notes_of(self, slot: int) -> Iterator[str]:
        """Yield sentences about a slot: its start state, and its scans that are not compared."""
        module, numbers = self.modules[slot], self._recording.numbers
        if self._is_unknown(slot):
            reason = ", ".join(module.unknown)
            yield f"slot {slot}: the trace begins in the middle of operation; it is not compared: {reason}"
            return
        start = module.starts[0]
        source = self._source(slot, start.row)
        yield (
            f"slot {slot}: the trace begins in the middle of operation; the module starts with the state of "
            f"scan {numbers[start.row]:,}, position {start.position:,}{source}; "
            "it is compared from the next scan on"
        )
        rows = sum(module.unknown.values())
        reasons = "; ".join(f"{count:,}: {reason}" for reason, count in module.unknown.items())
        yield f"slot {slot}: {rows:,} of {len(numbers):,} scans are not compared; {reasons}"

    def _source(self, slot: int, row: int) -> str:
        """Return a phrase about the configuration in a row; "" if the recording has shown it before."""
        first = self._first_shown[slot]
        if first is not None and first[0] < row:
            return ""
        if self._given_configuration is not None:
            return ", configuration as given"
        if first is None:
            return ", without a configuration"
        return f", configuration of scan {self._recording.numbers[first[0]]:,}, the first that it shows"
