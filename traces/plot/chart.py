"""Reads the contents of a timing chart in one pass over a trace."""

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
from .tagged import FROM_OUTSIDE, Choice, TagReader, choose

C = TypeVar("C")


@dataclass(frozen=True, slots=True)
class Chart(Generic[C]):
    """A timing chart."""

    title: str
    start_ns: int  # virtual time of its first scan
    end_ns: int  # virtual time of its last scan
    first: int  # number of its first scan
    last: int  # number of its last scan
    scans: int  # number of its scans
    panels: Sequence[Panel[C]]  # one per module, in the order of the slots, and then one for the tags
    left_out: int = 0  # number of recorded tag values that are not drawn


def groups_of(chart: Chart[C]) -> list[str]:
    """Return the kinds of bits on a chart, from top to bottom."""
    groups = {lane.group for panel in chart.panels for lane in (*panel.lanes, *panel.steady)}
    return [group for group in GROUPS if group in groups]


class NothingToPlotError(ValueError):
    """The trace has no 3601, no card with named channels or bits, and no tags."""


class ModuleReader(Generic[C]):
    """Collects the contents of a module's panel, block by block.

    Args:
        maker: returns a new maker of curves.
    """

    def __init__(self, slot: SlotInfo, catalog: Catalog, maker: Callable[[], CurveMaker[C]]) -> None:
        self.slot = slot
        titles_and_names = _curve_signals(slot)
        self._titles = [title for title, _ in titles_and_names]
        self._signals = [catalog[name] for _, name in titles_and_names]
        self._curves = [maker() for _ in self._signals]
        self._inputs = bit_changes(slot.number, "in", slot.words)
        self._outputs = bit_changes(slot.number, "out", slot.words)

    def add(self, block: Block) -> None:
        """Add a block."""
        for signal, curve in zip(self._signals, self._curves, strict=True):
            curve.add(block.time_ns, signal.read(block).astype(np.float64))
        self._inputs.add(block)
        self._outputs.add(block)

    def panel(self, panel_marks: Sequence[Mark]) -> Panel[C]:
        """Return the panel of the module, with its marks."""
        inputs, outputs = self._inputs.changes(), self._outputs.changes()
        words = self.slot.words
        make_lanes = bit_lanes if words.modes else card_lanes
        lanes = make_lanes(words, inputs, outputs)
        return Panel(
            slot=self.slot,
            curves=list(zip(self._titles, [curve.curve() for curve in self._curves], strict=True)),
            ramp=ramp_lane(words, inputs) if words.is_axis else None,
            lanes=[lane for lane in lanes if not lane.steady],
            steady=[lane for lane in lanes if lane.steady],
            marks=panel_marks,
            about=self.slot.module,
        )


def read_chart(
    trace: Trace,
    maker: Callable[[], CurveMaker[C]],
    selection: Selection = ALL,
    *,
    slots: Sequence[int] = (),
    tags: Sequence[str] = (),
    exact: Callable[[], CurveMaker[C]] | None = None,
    title: str | None = None,
    more_marks: Sequence[Mark] = (),
    on_block: Callable[[Block], None] = lambda block: None,
    progress: Callable[[int], None] = lambda scans: None,
) -> Chart[C]:
    """Read a chart from a trace.

    Args:
        maker: returns a new maker of curves: `Envelope` for a picture, `PackedCurve` for a page.
        slots: numbers of the slots to show; empty = every slot that can be drawn.
        tags: names of recorded tags to show, as in a query; empty = as many as fit on the chart,
            or no tags if `slots` is not empty.
        exact: like `maker`, for tags: its curves keep exact values; None = `maker`.
        title: text above the chart; None = the rack's name.
        more_marks: marks in addition to the marks of the trace's events.
        on_block: called with every block.
        progress: called for each block with the number of scans read so far.

    Raises:
        EmptySelectionError: no scan is in the selection.
        NothingToPlotError: the requested slots have no 3601 and no card with names, and there are no tags.
        UnknownSignalError: a name matches no tag.
        ValueError: a name refers to a signal that is not a tag, or the names match too many tags.
    """
    catalog = Catalog.of(trace)
    choice = Choice((), 0) if slots and not tags else choose(trace, catalog, selection, tags)
    modules = [ModuleReader(slot, catalog, maker) for slot in drawn_slots(trace, slots)]
    program = TagReader(choice, catalog[FROM_OUTSIDE], exact or maker)
    extent = ScanExtent()
    for block in blocks(trace, selection, progress=progress):
        extent.add(block)
        on_block(block)
        for module in modules:
            module.add(block)
        program.add(block)
    tag_marks: list[Mark] = []
    rack_marks: list[Mark] = []
    for mark in (*more_marks, *marks(trace.events(), extent.start_ns, extent.end_ns)):
        is_for_tags = bool(choice.signals) and (mark.of_tags or not modules)
        (tag_marks if is_for_tags else rack_marks).append(mark)
    panels = [module.panel(slot_marks(rack_marks, module.slot, modules[0].slot)) for module in modules]
    if choice.signals:
        panels.append(program.panel(tag_marks))
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
    """The first scan, the last scan and the number of scans in the added blocks."""

    def __init__(self) -> None:
        self.start_ns = self.end_ns = self.first = self.last = self.scans = 0

    def add(self, block: Block) -> None:
        """Add a block."""
        if not self.scans:
            self.start_ns, self.first = int(block.time_ns[0]), int(block.scan[0])
        self.end_ns, self.last = int(block.time_ns[-1]), int(block.scan[-1])
        self.scans += len(block)


_DEFAULT_NAME = re.compile(r"word\d|data|ch\d_data")
"""Default names of words that the rack file does not name."""


def _curve_signals(slot: SlotInfo) -> list[tuple[str, str]]:
    """Return the title and signal name of each of a slot's curves.

    A card has a curve for each channel that the rack file names.
    """
    stem = f"slot{slot.number}"
    if slot.words.is_axis:
        return [("position, steps", f"{stem}.in.position"), ("speed, steps/s", f"{stem}.speed")]
    return [
        (name, f"{stem}.{direction}.{name}")
        for direction in ("in", "out")
        for name in slot.words.named(direction)
        if not _DEFAULT_NAME.fullmatch(name)
    ]


def _can_be_drawn(slot: SlotInfo) -> bool:
    return any(slot.words.groups.values()) or bool(_curve_signals(slot))


def drawn_slots(trace: Trace, numbers: Sequence[int]) -> list[SlotInfo]:
    """Return the requested slots; if `numbers` is empty, return all slots that can be drawn.

    Raises:
        NothingToPlotError: a requested slot can't be drawn, or the trace has neither a slot that can be drawn
            nor a tag.
    """
    drawable = {slot.number: slot for slot in trace.head.slots if _can_be_drawn(slot)}
    if not drawable and (numbers or trace.head.tags is None):
        modules = listed(trace.head.slots)
        raise NothingToPlotError(f"no amci3601 and no card with names in the trace to plot ({modules})")
    for number in numbers:
        if number not in drawable:
            slots = ", ".join(map(str, drawable))
            problem = f"slot {number} has neither an amci3601 nor a card with names; these slots do: {slots}"
            raise NothingToPlotError(problem)
    return [drawable[number] for number in dict.fromkeys(numbers or drawable)]


def chart_title(trace: Trace) -> str:
    """Return the rack's name, or the names of its modules."""
    modules = dict.fromkeys(slot.module for slot in trace.head.slots)
    return trace.head.metadata.get("name") or ", ".join(modules)


def slot_marks(rack_marks: Sequence[Mark], slot: SlotInfo, first_slot: SlotInfo) -> list[Mark]:
    """Return the marks for a slot's panel; the panel of `first_slot` also gets the marks without a slot."""
    numbers = (slot.number, None) if slot is first_slot else (slot.number,)
    return [mark for mark in rack_marks if mark.slot in numbers]
