"""The process that finds the executed lines of a Python program by rerunning it.

The trace may still be growing, so the question includes its latest scans.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scanrack.jobs.bench.of_trace import lines_of_trace
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.reader import open_trace


def answer(
    path: str, first: int, last: int, more: Columns, latest: Sequence[tuple[int, str]]
) -> dict[str, Any]:
    """Return the lines that were executed in scans of a trace.

    Args:
        more: the latest scans, which may not be in the trace yet.
        latest: the latest actions, see `lines_of_trace`.

    Raises:
        ValueError: the trace can't be used, or lacks the scans.
    """
    with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
        result = lines_of_trace(trace, Path(folder), (first, last), more, latest)
    changes: list[tuple[int, tuple[int, ...]]] = []
    for scan in range(first, last + 1):
        lines = result.lines.get(scan, ())
        if not changes or lines != changes[-1][1]:
            changes.append((scan, lines))
    return {"from": first, "to": last, "ran": changes, "departs": result.departs}
