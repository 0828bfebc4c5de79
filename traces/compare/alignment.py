"""Aligns the clocks of two traces by their first scans or by a bit's rising edges.

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

    first: tuple[int, ...] = (0,)  # times of events in the first trace, ns, ascending
    second: tuple[int, ...] = (0,)  # times of the same events in the second trace, ns

    def __call__(self, times: Times) -> Times:
        """Return times of the second trace as times of the first, ns."""
        first_times, second_times = np.array(self.first), np.array(self.second)
        # `interp` keeps the shift constant before the first event and after the last event
        shift_ns = np.interp(times, second_times, first_times - second_times)
        converted: Times = times + np.rint(shift_ns).astype(np.int64)
        return converted


SAME_CLOCK = TimeMap()
"""Both traces have the same clock."""


def align(a: Trace, b: Trace, event: str) -> TimeMap:
    """Return the time conversion that aligns an event in both traces.

    Args:
        event: "start" for the first scan, or the name of a bit for the first scan in which the bit rises.

    Raises:
        ValueError: a trace has no such bit, or the bit never rises in it.
    """
    return TimeMap(_times_of(a, event)[:1], _times_of(b, event)[:1])


def realign(a: Trace, b: Trace, bit: str) -> TimeMap:
    """Return the time conversion that aligns each rise of a bit in both traces.

    Small delays, such as those on a real machine, therefore do not accumulate. If one trace has more rises,
    its last ones are ignored.

    Raises:
        ValueError: a trace has no such bit, or the bit never rises in it.
    """
    times_a, times_b = _times_of(a, bit), _times_of(b, bit)
    return TimeMap(times_a[: len(times_b)], times_b[: len(times_a)])


def _times_of(trace: Trace, event: str) -> tuple[int, ...]:
    """Return the times of an event, ns. There is at least one."""
    if event == START:
        return (next(int(block.time_ns[0]) for block in blocks(trace)),)
    signal = Catalog.of(trace)[event]
    if signal.kind is not SignalKind.BIT:
        raise ValueError(f"{event} is not a bit: align traces at 'start' or at a bit that rises")
    was_on, times = True, list[int]()
    for block in blocks(trace):
        levels = signal.read(block)
        risen_rows = np.flatnonzero(levels & ~np.concatenate(([was_on], levels[:-1])))
        times += block.time_ns[risen_rows].tolist()
        was_on = bool(levels[-1])
    if not times:
        raise ValueError(f"{event} never rises in one of the traces: align them at another bit or at 'start'")
    return tuple(times)
