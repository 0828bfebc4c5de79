"""A whole trace in memory, as columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..layout import SLOT_BYTES, SlotInfo
from ..reader import Trace
from ..signals.stream import Columns, _columns

SLOT_WORDS = SLOT_BYTES // 2
"""Columns of a slot: output words, then input words."""


def read_columns(trace: Trace) -> Columns:
    """Read all scans of a trace."""
    parts = list(_columns(trace))
    if not parts:
        words = SLOT_WORDS * len(trace.head.slots)
        return Columns(
            np.zeros(0, np.int64),
            np.zeros(0, np.int64),
            np.zeros(0, np.uint32),
            np.zeros((0, words), np.int16),
        )
    return Columns(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def slot_places(slots: Sequence[SlotInfo]) -> Mapping[int, int]:
    """Return for each slot the first column of its output words."""
    return {slot.number: SLOT_WORDS * place for place, slot in enumerate(slots)}
