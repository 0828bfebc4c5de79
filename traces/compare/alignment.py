"""By how much the clock of one trace is ahead of the other's."""

from __future__ import annotations

import numpy as np

from ..reader import Trace
from ..signals import Catalog, Kind, blocks

START = "start"


def align(one: Trace, other: Trace, at: str) -> int:
    """Return what has to be added to the times of the second trace so that something is at one time in both.

    Args:
        one: the first trace.
        other: the second.
        at: "start", their first scans; or the name of a bit, the first scan in which it rises.

    Raises:
        ValueError: there is no such bit, or it never rises in one of them.
    """
    return _time_of(one, at) - _time_of(other, at)


def _time_of(trace: Trace, at: str) -> int:
    if at == START:
        return next(int(block.time_ns[0]) for block in blocks(trace))
    signal = Catalog(trace.head.slots)[at]
    if signal.kind is not Kind.BIT:
        raise ValueError(f"{at} is no bit: traces are aligned at 'start' or at the first rise of a bit")
    before = True
    for block in blocks(trace):
        levels = signal.read(block)
        risen = np.flatnonzero(levels & ~np.concatenate(([before], levels[:-1])))
        if len(risen):
            return int(block.time_ns[risen[0]])
        before = bool(levels[-1])
    raise ValueError(f"{at} never rises in one of the traces, so they can't be aligned there")
