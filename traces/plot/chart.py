"""The contents of a timing chart, read in one pass over a trace."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ..format.layout import SlotInfo, listed
from ..read.reader import Trace
from ..signals import ALL, Block, Catalog, Selection, blocks
from .changes import bit_changes
from .curves import CurveMaker
from .lanes import GROUPS, bit_lanes, card_lanes, ramp_lane
from .marks import Mark, marks
from .panel import Panel
from .tagged import FROM_OUTSIDE, Choice, TagTracks, choose

C = TypeVar("C")


@dataclass(frozen=True, slots=True)
class Chart(Generic[C]):
    """A timing chart."""

    title: str
    start_ns: int  # virtual time of its first scan
    end_ns: int
    first: int  # number of its first scan
    last: int  # number of its last
    scans: int
    panels: Sequence[Panel[C]]  # one per module, in the order of the slots; the program's tags are last
    left_out: int = 0  # number of recorded tag values that are not drawn


def groups_of(chart: Chart[C]) -> list[str]:
    """Return the kinds of bits on a chart, from top to bottom."""
    present = {lane.group for panel in chart.panels for lane in (*panel.lanes, *panel.steady)}
    return [group for group in GROUPS if group in present]


class NothingToPlotError(ValueError):
    """The trace has no 3601, no card with names, and no tags."""


class Tracks(Generic[C]):
    """Gathers the contents of one panel.

    Args:
        maker: returns a new maker of curves.
    """

    def __init__(self, slot: SlotInfo, catalog: Catalog, maker: Callable[[], CurveMaker[C]]) -> None:
        self.slot = slot
        self._sources = [(title, catalog[name]) for title, name in _curve_signals(slot)]
        self._curves = [maker() for _ in self._sources]
        self._inputs = bit_changes(slot.number, "in", slot.words)
        self._outputs = bit_changes(slot.number, "out", slot.words)

    def add(self, block: Block) -> None:
        """Add a block."""
        for (_, signal), curve in zip(self._sources, self._curves, strict=True):
            curve.add(block.time_ns, signal.read(block).astype(np.float64))
        self._inputs.add(block)
        self._outputs.add(block)

    def panel(self, happened: Sequence[Mark]) -> Panel[C]:
        """Return the panel."""
        inputs, outputs = self._inputs.changes(), self._outputs.changes()
        words = self.slot.words
        lanes = (bit_lanes if words.modes else card_lanes)(words, inputs, outputs)
        titles = [title for title, _ in self._sources]
        return Panel(
            self.slot,
            list(zip(titles, [curve.curve() for curve in self._curves], strict=True)),
            ramp_lane(words, inputs) if words.is_axis else None,
            [lane for lane in lanes if not lane.steady],
            [lane for lane in lanes if lane.steady],
            happened,
            self.slot.module,
        )


def _marks_apart(happened: Sequence[Mark], tracks: Sequence[object]) -> list[Mark]:
    """Return the marks of the tags' panel; all marks if it is the only panel."""
    return [mark for mark in happened if mark.of_tags or not tracks]


def read_chart(
    trace: Trace,
    maker: Callable[[], CurveMaker[C]],
    selection: Selection = ALL,
    *,
    slots: Sequence[int] = (),
    tags: Sequence[str] = (),
    exact: Callable[[], CurveMaker[C]] | None = None,
    title: str | None = None,
    more: Sequence[Mark] = (),
    watch: Callable[[Block], None] = lambda block: None,
    progress: Callable[[int], None] = lambda scans: None,
) -> Chart[C]:
    """Read a chart from a trace.

    Args:
        maker: returns a new maker of curves: `Envelope` for a picture, `PackedCurve` for a page.
        slots: numbers of the slots to show; empty = every slot that can be drawn.
        tags: names of recorded tags to show, as in a query; empty = as many as fit on the chart,
            or none if slots are chosen.
        exact: returns a new maker of curves that keeps exact values, for tags; by default `maker`.
        title: text above it; the rack's name if None.
        more: marks in addition to those of the trace's events.
        watch: called with every block.
        progress: called at each block with the number of scans read so far.

    Raises:
        EmptySelectionError: no scan is in the selection.
        NothingToPlotError: the requested slots have no 3601 and no card with names, and there are no tags.
        UnknownSignalError: a name matches no tag.
        ValueError: a name belongs to a signal that is no tag, or the names match too many tags.
    """
    catalog = Catalog.of(trace)
    choice = Choice((), 0) if slots and not tags else choose(trace, catalog, selection, tags)
    tracks = [Tracks(slot, catalog, maker) for slot in wanted_slots(trace, slots)]
    program = TagTracks(choice, catalog[FROM_OUTSIDE], exact or maker)
    extent = ScanExtent()
    for block in blocks(trace, selection, progress=progress):
        extent.add(block)
        watch(block)
        for track in tracks:
            track.add(block)
        program.add(block)
    happened = [*more, *marks(trace.events(), extent.start_ns, extent.end_ns)]
    apart = _marks_apart(happened, tracks) if choice.signals else []
    shared_marks = [mark for mark in happened if mark not in apart]
    panels = [track.panel(marks_of(shared_marks, track.slot, tracks[0].slot)) for track in tracks]
    if choice.signals:
        panels.append(program.panel(apart))
    return Chart(
        title=title if title is not None else chart_title(trace),
        start_ns=extent.start_ns,
        end_ns=extent.end_ns,
        first=extent.first,
        last=extent.last,
        scans=extent.scans,
        panels=panels,
        left_out=choice.left_out,
    )


class ScanExtent:
    """First and last scan of the added blocks."""

    def __init__(self) -> None:
        self.start_ns = self.end_ns = self.first = self.last = self.scans = 0

    def add(self, block: Block) -> None:
        """Add a block."""
        if not self.scans:
            self.start_ns, self.first = int(block.time_ns[0]), int(block.scan[0])
        self.end_ns, self.last = int(block.time_ns[-1]), int(block.scan[-1])
        self.scans += len(block)


_PLAIN = re.compile(r"word\d|data|ch\d_data")
"""Default names of words, for words without a name in the rack file."""


def _curve_signals(slot: SlotInfo) -> list[tuple[str, str]]:
    """Return titles and signals of a slot's curves; for a card, the channels that the rack file names."""
    stem = f"slot{slot.number}"
    if slot.words.is_axis:
        return [("position, steps", f"{stem}.in.position"), ("speed, steps/s", f"{stem}.speed")]
    named_words = (("in", slot.words.inputs), ("out", slot.words.outputs))
    return [
        (name, f"{stem}.{direction}.{name}")
        for direction, names in named_words
        for name in names
        if not _PLAIN.fullmatch(name)
    ]


def _can_be_drawn(slot: SlotInfo) -> bool:
    return any(slot.words.groups.values()) or bool(_curve_signals(slot))


def wanted_slots(trace: Trace, numbers: Sequence[int]) -> list[SlotInfo]:
    """Return the requested slots that can be drawn.

    Raises:
        NothingToPlotError: there is no such slot and no tag, or a requested slot can't be drawn.
    """
    have = {slot.number: slot for slot in trace.head.slots if _can_be_drawn(slot)}
    if not have and (numbers or trace.head.tags is None):
        modules = listed(trace.head.slots)
        raise NothingToPlotError(f"no amci3601 and no card with names in the trace to plot ({modules})")
    for number in numbers:
        if number not in have:
            slots = ", ".join(map(str, have))
            problem = f"no amci3601 and no card with names in slot {number}; there is one in {slots}"
            raise NothingToPlotError(problem)
    return [have[number] for number in dict.fromkeys(numbers or have)]


def chart_title(trace: Trace) -> str:
    """Return the rack's name, or the names of its modules."""
    return trace.head.metadata.get("name") or ", ".join(
        dict.fromkeys(slot.module for slot in trace.head.slots)
    )


def marks_of(happened: Sequence[Mark], slot: SlotInfo, first: SlotInfo) -> list[Mark]:
    """Return the marks of a slot; marks of the rack belong to the slot `first`."""
    return [mark for mark in happened if mark.slot == slot.number or (mark.slot is None and slot is first)]
