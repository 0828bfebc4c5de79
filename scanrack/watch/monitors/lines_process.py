"""Finds the executed lines of a Python program, in its own process, since the program runs again.

The recording may still be growing, so its latest scans come with the question.
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
    """Return the lines that were executed in scans of a recording.

    Args:
        more: the latest scans, which may not be written yet.
        latest: orders, see `lines_of_trace`.

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
