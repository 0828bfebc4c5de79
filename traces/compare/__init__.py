"""Compares two traces; finds the first scan that differs, and all differences.

    with open_trace("a.mcap") as a, open_trace("b.mcap") as b:
        comparison = compare(a, b, Tolerance(time_ns=4_000_000, counts=2))
    for line in report(comparison, ("a.mcap", "b.mcap")):
        print(line)

Both traces are read block by block, in one pass:

    stream      scans of a trace in memory, ordered by a key: scan number or time
    blocks      the scans of two streams that are compared with each other
    differing   finds the fields that differ, from `fields` and `tagged`
    findings    the first difference, and the extent of each difference, over all blocks
    report      the findings as text

Without a tolerance, scans are paired by number, and every word is compared. With a tolerance, as for
recordings of real hardware, scans are paired by time, and each trace must have the other's values within the
tolerance.
"""

from .alignment import SAME_CLOCK, TimeMap, align, realign
from .comparison import Comparison, compare, compare_parts
from .fields import EXACT, Tolerance
from .findings import Detail, Extent, First
from .report import report

__all__ = [
    "EXACT",
    "SAME_CLOCK",
    "Comparison",
    "Detail",
    "Extent",
    "First",
    "TimeMap",
    "Tolerance",
    "align",
    "compare",
    "compare_parts",
    "realign",
    "report",
]
