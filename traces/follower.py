"""Compares a replay with its recording, scan by scan.

    recording ---> receiver ---> its images in each scan
        |                                |
        +---------- Follower ------------+   stops at the first scan that differs

The receiver is a module, a program or a whole rack. Its owner runs it scan by scan; a `Follower` listens to
the run like a recorder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from .compare import EXACT, Comparison, Tolerance, compare_parts
from .read.columns import Columns
from .read.event_text import describe
from .read.packed import NotedScans
from .replay import Image, PackedTrace


class Follower:
    """Compares a replay with the recording while it runs; a listener of the scan loop.

    Args:
        memory: the memory block of the receiver, with the layout of the recording.
        images: the images that are compared.

    Attributes:
        stop: called at the first scan that differs; None = continue. With a tolerance it is not called, since
            a later scan can show that the difference is within the tolerance.
        stopped: whether `stop` has been called.
    """

    def __init__(
        self,
        recording: PackedTrace,
        memory: bytearray,
        images: Sequence[Image],
        *,
        tolerance: Tolerance = EXACT,
    ) -> None:
        self._recording = recording
        self._memory = memory
        self._images = tuple(images)
        self._tolerance = tolerance
        self.stop: Callable[[], None] | None = None
        self.stopped = False
        self._spans = [recording.span(image) for image in self._images]
        self._recorded = recording.memory
        self._replayed = NotedScans(recording.layout.words)
        self._rules: list[tuple[int, object, str]] = []  # scan, slot and text

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, object]) -> None:
        """Record the rules that fire."""
        if fields.get("kind") == "rule":
            self._rules.append((scan, fields.get("slot"), describe(topic, scan, fields)))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record a scan, and stop the replay if it differs."""
        block, recorded = bytes(self._memory), self._recorded[self.scans]
        self._replayed.add(scan, now_ns, flags, block)
        if self.stop is not None and self._tolerance.exact and self._differ(block, recorded):
            self.stop()
            self.stopped, self.stop = True, None

    def _differ(self, block: bytes, recorded: bytes) -> bool:
        return block != recorded and any(block[span] != recorded[span] for span in self._spans)

    def close(self) -> None:
        """Do nothing, because nothing is open."""

    @property
    def scans(self) -> int:
        """Number of replayed scans."""
        return len(self._replayed)

    def comparison(self) -> Comparison:
        """Return the comparison, with the recording first and the replay second.

        A replay that ended early without a call to `stop` is compared as a shorter recording.
        """
        slots, recorded = self._recording.slots, self._recording.scans.chunks()
        comparison = compare_parts(
            (slots, _first_scans(recorded, self.scans) if self.stopped else recorded),
            (slots, self._replayed.packed().chunks()),
            self._tolerance,
            only=frozenset(self._images),
        )
        if comparison.first is None:
            return comparison
        involved = {detail.slot for detail in comparison.first.details}
        recorded_rules = [
            (event.scan, event.fields.get("slot"), describe(event.topic, event.scan, event.fields))
            for event in self._recording.events
            if event.fields.get("kind") == "rule"
        ]

        def texts(rules: Sequence[tuple[int, object, str]], scan: int | None) -> tuple[str, ...]:
            return tuple(text for rule_scan, slot, text in rules if rule_scan == scan and slot in involved)

        rules_a = texts(recorded_rules, comparison.first.scan)
        rules_b = texts(self._rules, comparison.first.scan_b)
        return replace(comparison, first=replace(comparison.first, rules_a=rules_a, rules_b=rules_b))


def _first_scans(chunks: Iterator[Columns], count: int) -> Iterator[Columns]:
    """Yield the chunks up to the first `count` scans."""
    for columns in chunks:
        yield columns.rows(0, count)
        count -= len(columns.scan)
        if count <= 0:
            return
