"""A trace read part by part, with its progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..read.arrays import column_chunks
from ..read.columns import Columns
from ..read.reader import Trace

Progress = Callable[[int], None]
"""Called with the number of further scans read."""


def read_parts(trace: Trace, progress: Progress) -> Iterator[Columns]:
    """Yield the scans of a trace chunk by chunk, and report how many with each chunk."""
    for columns in column_chunks(trace, tags=True):
        progress(len(columns.scan))
        yield columns
