"""Figures of a benchmark with their bars: a missed bar is a row and exit status 1, not a traceback."""

from __future__ import annotations

import os
import sys
from pathlib import Path


class Bars:
    """Bars, and which are missed.

    Args:
        count: whether a missed bar counts; those of a smoke run do not, since its figures say nothing.
    """

    def __init__(self, *, count: bool = True) -> None:
        self._count = count
        self._missed: list[str] = []

    def most(self, what: str, figure: float, bar: float) -> str:
        """Return the words of a bar that a figure may reach.

        >>> bars = Bars()
        >>> bars.most("ns a rung", 77.9, 78), bars.most("MiB", 301.5, 300), bars.status()
        missed: MiB 301.5, bar 300
        ('bar: 78', 'bar: 300', 1)
        """
        if self._count and figure > bar:
            self._missed.append(f"{what} {figure:g}, bar {bar:g}")
        return f"bar: {bar:g}"

    def status(self) -> int:
        """Print what is missed; return the exit status."""
        for each in self._missed:
            print(f"missed: {each}")
        return int(bool(self._missed))


def children_s() -> float:
    """Return the processor time of the ended child processes, s, in whole ticks."""
    times = os.times()
    return times.children_user + times.children_system


def highest_mib() -> float:
    """Return the most memory that this process has had, MiB."""
    status = Path("/proc/self/status")
    if status.exists():  # getrusage also counts what the process was forked from
        line = next(
            line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith("VmHWM")
        )
        return int(line.split()[1]) / 1024
    import resource  # Windows has none

    unit = 1 << 20 if sys.platform == "darwin" else 1 << 10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
