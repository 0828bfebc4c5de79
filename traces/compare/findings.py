"""Joins the findings of all blocks: the first scan that differs, and how much differs in all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..format.layout import SlotInfo
from .before import changes_before
from .differing import Differing, Extent, First, Side


class Findings:
    """What differs in the blocks of two traces.

    Attributes:
        first: the first scan that differs; None if none does.
        differing: in how many scans anything differs.
        compared: how many scans of either trace have been compared with any of the other.
    """

    def __init__(self, slots: Sequence[SlotInfo]) -> None:
        self._slots = slots
        self._extents: dict[str, Extent] = {}
        self.first: First | None = None
        self.differing = 0
        self.compared = (0, 0)

    def add(self, one: Side, other: Side, found: Sequence[Differing], compared: tuple[int, int]) -> None:
        """Add what was found in a block that follows those before.

        Args:
            one: what is in memory of the first trace; the rows of the fields are rows of it.
            other: the same of the second.
            found: the fields that differ, each with its rows in ascending order.
            compared: how many scans of either have been compared.
        """
        self.compared = self.compared[0] + compared[0], self.compared[1] + compared[1]
        if not found:
            return
        if self.first is None:
            self.first = _first(found, one, other, self._slots)
        for extent in (extent for each in found for extent in each.extents(one, other)):
            before = self._extents.get(extent.name)
            self._extents[extent.name] = extent if before is None else _joined(before, extent)
        self.differing += len(np.unique(np.concatenate([each.a for each in found])))

    @property
    def extents(self) -> tuple[Extent, ...]:
        """How much differs in each bit, value and word, by the first scan in which it does."""
        return tuple(sorted(self._extents.values(), key=lambda extent: extent.first))


def _first(found: Sequence[Differing], a: Side, b: Side, slots: Sequence[SlotInfo]) -> First:
    row, row_b = min((int(each.a[0]), int(each.b[0])) for each in found)
    details = [each.detail(a, b, row) for each in found]
    return First(
        int(a.columns.scan[row]),
        int(a.columns.time_ns[row]),
        int(b.columns.scan[row_b]),
        int(b.columns.time_ns[row_b]),
        tuple(detail for detail in details if detail is not None),
        changes_before(a, slots, row),
        changes_before(b, slots, row_b),
    )


def _joined(before: Extent, after: Extent) -> Extent:
    most = max((each.most for each in (before, after) if each.most is not None), default=None)
    return replace(before, scans=before.scans + after.scans, last=after.last, most=most)
