"""Aligns the clocks of two traces: by their first scans, or by the rises of a bit.

first trace     0 ----- rise --------- rise ------------ rise ---
second trace    7 ------- rise ---------- rise --------- rise ---
                shifted   |  stretched    |  stretched   |  shifted
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from ..read.reader import Trace
from ..signals import Catalog, SignalKind, blocks

Times = NDArray[np.int64]

START = "start"


@dataclass(frozen=True, slots=True)
class TimeMap:
    """Converts times of the second trace to times of the first.

    >>> clock = TimeMap((100, 200), (90, 190))
    >>> clock(np.array([90, 140, 190, 200])).tolist()
    [100, 150, 200, 210]
    """

    first: tuple[int, ...] = (0,)  # times in the first trace, ns, ascending
    second: tuple[int, ...] = (0,)  # the same instants in the second trace; the same number of them

    def __call__(self, times: Times) -> Times:
        """Return times of the second trace as times of the first, ns."""
        first_times, second_times = np.array(self.first), np.array(self.second)
        # the shift is constant beyond the ends
        shift_ns = np.interp(times, second_times, first_times - second_times)
        mapped: Times = times + np.rint(shift_ns).astype(np.int64)
        return mapped


SAME_CLOCK = TimeMap()
"""Both traces have the same clock."""


def align(one: Trace, other: Trace, at: str) -> TimeMap:
    """Return the clock that makes an event simultaneous in both traces.

    Args:
        at: "start" for their first scans, or the name of a bit for the first scan in which it rises.

    Raises:
        ValueError: no such bit, or it never rises in one of them.
    """
    return TimeMap(_times_of(one, at)[:1], _times_of(other, at)[:1])


def realign(one: Trace, other: Trace, signal: str) -> TimeMap:
    """Return the clock that makes a bit rise at the same times in both traces, as often as it does in both.

    Small delays, as on a real machine, do not add up.

    Raises:
        ValueError: no such bit, or it never rises in one of them.
    """
    first_times, second_times = _times_of(one, signal), _times_of(other, signal)
    return TimeMap(first_times[: len(second_times)], second_times[: len(first_times)])


def _times_of(trace: Trace, at: str) -> tuple[int, ...]:
    """Return the times of an event, at least one."""
    if at == START:
        return (next(int(block.time_ns[0]) for block in blocks(trace)),)
    signal = Catalog.of(trace)[at]
    if signal.kind is not SignalKind.BIT:
        raise ValueError(f"{at} is not a bit: traces are aligned at 'start' or where a bit rises")
    was_on, times = True, list[int]()
    for block in blocks(trace):
        levels = signal.read(block)
        risen_rows = np.flatnonzero(levels & ~np.concatenate(([was_on], levels[:-1])))
        times += block.time_ns[risen_rows].tolist()
        was_on = bool(levels[-1])
    if not times:
        raise ValueError(f"{at} never rises in one of the traces, so they can't be aligned there")
    return tuple(times)
