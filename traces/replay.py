"""Packed traces in memory, for a replay or an explanation."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.memory_layout import MemoryLayout

from .format.layout import SlotInfo, block_layout
from .read.arrays import column_chunks_and_events, extent
from .read.columns import Columns
from .read.packed import PackedScans, memory_blocks
from .read.reader import Trace, TraceEvent

Image = tuple[int, str]
"""An image in a scan: the slot number, and "in" or "out"."""


@dataclass(frozen=True)
class PackedTrace:
    """A packed trace in memory."""

    slots: tuple[SlotInfo, ...]
    scans: PackedScans
    events: tuple[TraceEvent, ...]  # all messages except scans, in order

    @classmethod
    def of(cls, trace: Trace, more: Columns | None = None) -> PackedTrace:
        """Read a trace.

        Args:
            more: scans that may not be in the file yet; scans that are already in the file are ignored.

        Raises:
            TraceError: the file can't be read, even without its damaged parts.
            ValueError: the trace has no scans.
        """
        scans, events = PackedScans(trace.head.layout.words), list[TraceEvent]()
        for columns, new_events in column_chunks_and_events(trace):
            scans.add(columns)
            events += new_events
        if more is not None:
            edge_scans = extent(trace).scan.tolist()
            first_row = bisect_right(more.scan.tolist(), edge_scans[-1]) if edge_scans else 0
            scans.add(more.rows(first_row, len(more.scan)))
        if not len(scans):
            raise ValueError("the trace has no scans to replay")
        return cls(trace.head.slots, scans, tuple(events))

    @property
    def columns(self) -> Columns:
        """All scans of the trace as columns, unpacked."""
        return self.scans.columns()

    @cached_property
    def numbers(self) -> Sequence[int]:
        """Numbers of the scans."""
        return self.scans.view(lambda columns: columns.scan.tolist())

    @cached_property
    def times(self) -> Sequence[int]:
        """Virtual times of the scans, ns."""
        return self.scans.view(lambda columns: columns.time_ns.tolist())

    @cached_property
    def flags(self) -> Sequence[int]:
        """The controller's flags in the scans."""
        return self.scans.view(lambda columns: columns.flags.tolist())

    @cached_property
    def distinct_flags(self) -> frozenset[int]:
        """All values of the controller's flags."""
        return frozenset(flag for chunk in self.scans.chunks() for flag in np.unique(chunk.flags).tolist())

    @property
    def memory(self) -> Sequence[bytes]:
        """The rack's memory block in each scan."""
        return self.scans.view(memory_blocks)

    def images(self, image: Image) -> Sequence[bytes]:
        """Return one image in each scan."""
        span = self.span(image)
        return self.scans.view(lambda columns: [block[span] for block in memory_blocks(columns)])

    @cached_property
    def layout(self) -> MemoryLayout:
        """The locations of the images in the memory block."""
        return block_layout(self.slots)

    def span(self, image: Image) -> slice:
        """Return the byte range of an image in the memory block; raise a KeyError for an unknown slot."""
        return self.layout.places[image[0]].image(image[1])
