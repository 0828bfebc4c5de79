"""Two traces side by side: the first scan that differs, and how they differ altogether.

    with open_trace(a) as one, open_trace(b) as other:
        found = compare(one, other, Tolerance(time_ns=4_000_000, counts=2))
    for line in report(found, ("one", "other")):
        print(line)

Exactly, scans are paired by number, and every word counts. With a tolerance, as
for recordings of real hardware, they are paired by time, and what one trace
shows has to be shown by the other within the tolerance; see `bytime.tolerantly`.
"""

from .alignment import SAME_CLOCK, Clock, align, realign
from .comparison import Comparison, compare, compare_columns, compare_parts
from .differing import Detail, Extent, First
from .report import report
from .tolerance import EXACT, Tolerance

__all__ = [
    "EXACT",
    "SAME_CLOCK",
    "Clock",
    "Comparison",
    "Detail",
    "Extent",
    "First",
    "Tolerance",
    "align",
    "compare",
    "compare_columns",
    "compare_parts",
    "realign",
    "report",
]
