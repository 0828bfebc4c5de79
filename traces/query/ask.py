"""Runs a query on a trace: reads columns, finds occurrences, and selects some of them."""

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

    The trace is read block by block. However many scans there are, memory is used only for changes of its
    conditions, 8 bytes each, and for values of `show` at beginnings of a condition.

    Args:
        text: the query, see docs/query.md.
        show: further signals, whose values at the beginning of each occurrence are returned.
        progress: called at each block with the number of scans read so far.

    Raises:
        QueryError: the query can't be parsed.
        UnknownSignalError: an unknown signal in `show`.
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
    chosen_occurrences = occurrences.some(_PICKS[parsed.aggregate](occurrences, rows))
    return Answer(parsed.aggregate, len(occurrences), tuple(_occurrences(chosen_occurrences, reading)))


class _Reading:
    """What a query keeps of the blocks that were read."""

    def __init__(self, question: Query, shown: Sequence[Signal]) -> None:
        self.rows = RowIndex()
        self.stretches = [Stretches() for _ in question.conditions]
        self._question, self._shown, self._memory = question, shown, Memory()
        self._begins: list[NDArray[np.int64]] = []
        self._columns: list[list[Column]] = [[] for _ in shown]  # values of the signals in these rows

    def add(self, block: Block) -> None:
        signals = {signal.name: signal for signal in (*self._question.signals, *self._shown)}
        values = {name: signal.read(block) for name, signal in signals.items()}
        scans = Scans(block.scan, block.time_ns, values, self._memory)
        rows_before, first_rows = self.stretches[0].rows, []
        for stretches, condition in zip(self.stretches, self._question.conditions, strict=True):
            first_rows.append(stretches.add(condition(scans)))
        self.rows.add(scans.scan, scans.time_ns)
        if self._shown and len(first_rows[0]):
            self._begins.append(first_rows[0] + rows_before)
            for column, signal in zip(self._columns, self._shown, strict=True):
                column.append(scans.column(signal)[first_rows[0]])

    def shown(self, rows: NDArray[np.int64]) -> Iterator[Mapping[str, Any]]:
        """Yield the values of the shown signals in some rows at which the first condition begins to hold."""
        if not self._shown or not len(rows):
            yield from ({} for _ in rows)
            return
        places = np.searchsorted(np.concatenate(self._begins), rows)
        columns = [_values(joined(column)[places]) for column in self._columns]
        names = [signal.name for signal in self._shown]
        yield from (dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True))


def _at(pick: Callable[[Array], Any], occurrences: Occurrences, rows: RowIndex) -> slice:
    if not len(occurrences):
        return slice(0)
    index = int(pick(lengths(occurrences, rows)))
    return slice(index, index + 1)


_PICKS: Mapping[str | None, Callable[[Occurrences, RowIndex], slice]] = {
    None: lambda found, _rows: slice(None),
    "count": lambda found, _rows: slice(0),
    "first": lambda found, _rows: slice(1),
    "last": lambda found, _rows: slice(max(0, len(found) - 1), None),
    "longest": partial(_at, np.argmax),
    "shortest": partial(_at, np.argmin),
}


def _occurrences(occurrences: Occurrences, reading: _Reading) -> Iterable[Occurrence]:
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
