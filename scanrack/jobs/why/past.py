"""The history of a rack up to a scan: how long a bit has had its value, and the events."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.event_text import describe
from scanrack.traces.read.packed import CHUNK_SCANS
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.read.sequence_steps import Step, steps_of
from scanrack.traces.replay import PackedTrace

ALL_BITS = 0xFFFF


def event_text(event: TraceEvent) -> str:
    """Return an event as text, with its scan in the same form as in the rest of an answer."""
    text = describe(event.topic, event.scan, event.fields)
    return text.replace(f" at scan {event.scan}:", f" at scan {event.scan:,}:", 1)


@dataclass(frozen=True)
class Past:
    """A recording up to the scan in `row`; later scans are ignored."""

    recording: PackedTrace
    row: int

    @property
    def scan(self) -> int:
        """Number of the scan."""
        return self.recording.numbers[self.row]

    def when(self, row: int) -> str:
        """Return the number and time of a scan as text."""
        return f"scan {self.recording.numbers[row]} ({seconds(self.recording.times[row])} s)"

    def words(self, slot: int, image: str, row: int) -> tuple[int, ...]:
        """Return an image of a slot in a scan; `image` is "in" or "out"."""
        chunk = self.recording.scans.chunk(row // CHUNK_SCANS)
        return tuple(chunk.words[row % CHUNK_SCANS, self._columns(slot, image)].tolist())

    def last_change(self, slot: int, image: str, word: int, mask: int = ALL_BITS) -> int | None:
        """Return the row in which bits of a word last changed, or None; see `changes`."""
        rows = self.changes(slot, image, word, mask)
        return None if not rows else rows[-1]

    def changes(self, slot: int, image: str, word: int, mask: int = ALL_BITS) -> list[int]:
        """Return the rows in which bits of a word changed, in order.

        All words are 0 before the first scan, unless the recording begins in a running session.
        """
        column = self._column(slot, image, word)
        before = 0 if self.recording.numbers[0] == 0 else None
        rows: list[int] = []
        for number, columns in enumerate(self._chunks()):
            start = number * CHUNK_SCANS
            # int32, because a mask with bit 15 does not fit int16
            values = columns[: self.row + 1 - start, column].astype(np.int32) & mask
            if before is None:
                before = int(values[0])
            differs = np.flatnonzero(np.diff(values, prepend=before))
            rows += (differs + start).tolist()
            before = int(values[-1])
        return rows

    def last_change_between(self, slot: int, image: str, word: int, first: int, last: int) -> int | None:
        """Return the last row from `first` to `last` (exclusive) that changed a word, or None."""
        for row in range(last - 1, max(first, 1) - 1, -1):
            if self.words(slot, image, row)[word] != self.words(slot, image, row - 1)[word]:
                return row
        return 0 if first == 0 < last and self.words(slot, image, 0)[word] else None

    def first_on(self, slot: int, image: str, word: int, mask: int) -> int | None:
        """Return the first row in which a bit in a mask is on; None if there is none."""
        column = self._column(slot, image, word)
        for number, columns in enumerate(self._chunks()):
            on = np.flatnonzero(columns[:, column].astype(np.int32) & mask)
            if len(on):
                return int(on[0]) + number * CHUNK_SCANS
        return None

    def _column(self, slot: int, image: str, word: int) -> int:
        return int(self._columns(slot, image).start) + word

    def _columns(self, slot: int, image: str) -> slice:
        return self.recording.layout.places[slot].columns(image)

    def _chunks(self) -> Iterator[np.ndarray[tuple[int, int], np.dtype[np.int16]]]:
        for number in range(self.row // CHUNK_SCANS + 1):
            yield self.recording.scans.chunk(number).words

    @cached_property
    def events(self) -> Sequence[TraceEvent]:
        """The events, in order."""
        return [event for event in self.recording.events if event.scan <= self.scan]

    @cached_property
    def sequences(self) -> Sequence[Step]:
        """The current waits of the program's sequences."""
        return [steps[-1] for steps in steps_of(self.events).values()]

    def rules(self, slot: int) -> Sequence[TraceEvent]:
        """Return the manual's rules that have fired in a module, in order."""
        return [
            event
            for event in self.events
            if event.fields.get("kind") == "rule" and event.fields.get("slot") == slot
        ]


@dataclass(frozen=True)
class SlotPast:
    """The history of one module."""

    past: Past
    slot: SlotInfo

    @cached_property
    def out(self) -> tuple[int, ...]:
        """The current output image."""
        return self.past.words(self.slot.number, "out", self.past.row)

    @cached_property
    def inputs(self) -> tuple[int, ...]:
        """The current input image."""
        return self.past.words(self.slot.number, "in", self.past.row)

    def since(self, image: str, word: int, mask: int) -> str:
        """Return when bits got their values: " since scan 7 (0.014 s)"; "" if they never changed."""
        row = self.past.last_change(self.slot.number, image, word, mask)
        return "" if row is None else f" since {self.past.when(row)}"

    def words_at(self, image: str, row: int) -> tuple[int, ...]:
        """Return an image in an earlier scan."""
        return self.past.words(self.slot.number, image, row)

    def rises(self, mask: int) -> Iterator[tuple[int, int]]:
        """Yield the rows in which bits of output word 0 turned on, latest first, each with these bits."""
        for row in reversed(self.past.changes(self.slot.number, "out", 0, mask)):
            before = self.words_at("out", row - 1)[0] if row else 0
            if new := self.words_at("out", row)[0] & ~before & mask:
                yield row, new
