"""Runs a query on a trace by reading columns, finding occurrences and selecting some of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..read.reader import Trace
from ..signals import Catalog, Signal, SignalKind, blocks
from ..signals.stream import Block
from .answer import Answer, Occurrence
from .columns import Column, Memory, Scans, joined
from .language import TOO_DEEP, Query, QueryError, parse
from .numbers import Numbers
from .patterns import Occurrences, Stretches, lengths
from .rows import RowIndex

Array = NDArray[Any]


def query(
    trace: Trace, text: str, *, show: Sequence[str] = (), progress: Callable[[int], None] = lambda scans: None
) -> Answer:
    """Run a query on a trace.

    The trace is read block by block. Memory use depends only on the number of changes in the query's
    conditions, 8 bytes each, and on the values of `show` each time a condition becomes true.

    Args:
        text: the query, see docs/query.md.
        show: signals to return with their values in the first scan of each occurrence.
        progress: called for each block with the number of scans read so far.

    Raises:
        QueryError: the query can't be parsed.
        UnknownSignalError: `show` has an unknown signal.
    """
    catalog = Catalog.of(trace)
    parsed = parse(text, catalog)
    shown_signals = [catalog[name] for name in show]
    reading = _Reading(parsed, shown_signals)
    measured = any(signal.kind is SignalKind.MEASURED for signal in (*parsed.signals, *shown_signals))
    try:
        for block in blocks(trace, progress=progress, measured=measured):
            reading.add(block)
    except RecursionError as error:
        raise QueryError(TOO_DEEP) from error
    except OverflowError as error:
        raise QueryError(f"a product is too large for a sum with a fraction: {error}") from error
    rows = reading.rows
    occurrences = parsed.pattern(reading.stretches, rows)
    returned = occurrences.some(_SLICES[parsed.aggregate](occurrences, rows))
    return Answer(parsed.aggregate, len(occurrences), tuple(_occurrences(returned, reading)))


class _Reading:
    """Collects, from each block, the changes in a query's conditions and the values of the shown signals.

    Attributes:
        rows: number and time of the scan in each row of the trace.
        stretches: the rows in which each condition of the query is true.
    """

    def __init__(self, parsed: Query, shown: Sequence[Signal]) -> None:
        self.rows = RowIndex()
        self.stretches = [Stretches() for _ in parsed.conditions]
        self._query, self._shown, self._memory = parsed, shown, Memory()
        self._begins: list[NDArray[np.int64]] = []  # rows at which the first condition becomes true
        self._columns: list[list[Column]] = [[] for _ in shown]  # values of each shown signal in these rows

    def add(self, block: Block) -> None:
        """Evaluate all conditions for the scans of a block, which follows the blocks before it."""
        signals = {signal.name: signal for signal in (*self._query.signals, *self._shown)}
        values = {name: signal.read(block) for name, signal in signals.items()}
        scans = Scans(block.scan, block.time_ns, values, self._memory)
        rows_before = self.stretches[0].rows
        begins_by_condition = [
            stretches.add(condition(scans))
            for stretches, condition in zip(self.stretches, self._query.conditions, strict=True)
        ]
        begins = begins_by_condition[0]  # row numbers in the block
        self.rows.add(scans.scan, scans.time_ns)
        if self._shown and len(begins):
            self._begins.append(begins + rows_before)
            for column, signal in zip(self._columns, self._shown, strict=True):
                column.append(scans.column(signal)[begins])

    def shown(self, rows: NDArray[np.int64]) -> Iterator[Mapping[str, Any]]:
        """Yield the values of the shown signals in rows at which the first condition becomes true."""
        if not self._shown or not len(rows):
            yield from ({} for _ in rows)
            return
        indexes = np.searchsorted(np.concatenate(self._begins), rows)
        columns = [_values(joined(column)[indexes]) for column in self._columns]
        names = [signal.name for signal in self._shown]
        yield from (dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True))


def _extreme(index_of: Callable[[Array], Any], occurrences: Occurrences, rows: RowIndex) -> slice:
    """Return the longest or shortest occurrence as a slice, which is empty if there are none."""
    if not len(occurrences):
        return slice(0)
    index = int(index_of(lengths(occurrences, rows)))
    return slice(index, index + 1)


_SLICES: Mapping[str | None, Callable[[Occurrences, RowIndex], slice]] = {
    None: lambda occurrences, _rows: slice(None),
    "count": lambda occurrences, _rows: slice(0),
    "first": lambda occurrences, _rows: slice(1),
    "last": lambda occurrences, _rows: slice(max(0, len(occurrences) - 1), None),
    "longest": partial(_extreme, np.argmax),
    "shortest": partial(_extreme, np.argmin),
}
"""The occurrences that each aggregate returns."""


def _occurrences(occurrences: Occurrences, reading: _Reading) -> Iterable[Occurrence]:
    """Yield occurrences with their scans and times, and the shown values in their first scans."""
    rows = reading.rows
    columns = (
        rows.scan(occurrences.first),
        rows.scan(occurrences.last),
        rows.time_ns(occurrences.first),
        rows.time_ns(occurrences.end),
        occurrences.open,
    )
    row_fields = zip(*(column.tolist() for column in columns), reading.shown(occurrences.first), strict=True)
    yield from (Occurrence(*fields) for fields in row_fields)


def _values(column: Column) -> Iterable[int | float | bool | None]:
    return column if isinstance(column, Numbers) else column.tolist()
