"""Runs a query on a trace: reads its columns, finds occurrences, and selects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..read.reader import Trace
from ..signals import Catalog, Signal, blocks
from .answer import Answer, Occurrence
from .columns import Column, Scans
from .language import TOO_DEEP, QueryError, parse
from .numbers import Numbers
from .patterns import Occurrences

Array = NDArray[Any]


def query(
    trace: Trace, text: str, *, show: Sequence[str] = (), progress: Callable[[int], None] = lambda scans: None
) -> Answer:
    """Run a query on a trace.

    It takes memory only for the columns in the query: per scan 16 bytes, 1 for a bit, at most
    8 for a number.

    Args:
        text: the query, see docs/query.md.
        show: further signals, whose values at the begin of each occurrence are returned.
        progress: called at each block with the number of scans read so far.

    Raises:
        QueryError: the query can't be parsed.
        UnknownSignalError: an unknown signal in `show`.
    """
    catalog = Catalog.of(trace)
    asked = parse(text, catalog)
    shown = [catalog[name] for name in show]
    scans = read_scans(trace, (*asked.signals, *shown), progress)
    try:
        found = asked.pattern(scans)
    except RecursionError as error:
        raise QueryError(TOO_DEEP) from error
    except OverflowError as error:
        raise QueryError(f"a product is too large for a sum with a fraction: {error}") from error
    wanted = found.some(_PICKS[asked.aggregate](found, scans))
    return Answer(asked.aggregate, len(found), tuple(_occurrences(wanted, scans, shown)))


def read_scans(trace: Trace, signals: Iterable[Signal], progress: Callable[[int], None]) -> Scans:
    """Read some signals of all scans."""
    columns: dict[str, list[Array]] = {signal.name: [] for signal in signals}
    wanted = {signal.name: signal for signal in signals}
    numbers, times = [], []
    for block in blocks(trace, progress=progress):
        numbers.append(block.scan)
        times.append(block.time_ns)
        for name, signal in wanted.items():
            columns[name].append(signal.read(block))
    joined = {name: np.concatenate(parts) for name, parts in columns.items()}
    return Scans(np.concatenate(numbers), np.concatenate(times), joined)


def _at(pick: Callable[[Array], Any], found: Occurrences, scans: Scans) -> slice:
    if not len(found):
        return slice(0)
    place = int(pick(scans.time_ns[found.end] - scans.time_ns[found.first]))
    return slice(place, place + 1)


_PICKS: Mapping[str | None, Callable[[Occurrences, Scans], slice]] = {
    None: lambda found, _scans: slice(None),
    "count": lambda found, _scans: slice(0),
    "first": lambda found, _scans: slice(1),
    "last": lambda found, _scans: slice(max(0, len(found) - 1), None),
    "longest": partial(_at, np.argmax),
    "shortest": partial(_at, np.argmin),
}


def _occurrences(found: Occurrences, scans: Scans, shown: Sequence[Signal]) -> Iterable[Occurrence]:
    shown_at = [list(_values(scans.column(signal)[found.first])) for signal in shown]
    for place in range(len(found)):
        values = {signal.name: column[place] for signal, column in zip(shown, shown_at, strict=True)}
        first, last, end = (int(rows[place]) for rows in (found.first, found.last, found.end))
        yield Occurrence(
            first=int(scans.scan[first]),
            last=int(scans.scan[last]),
            start_ns=int(scans.time_ns[first]),
            end_ns=int(scans.time_ns[end]),
            open=bool(found.open[place]),
            shown=values,
        )


def _values(column: Column) -> Iterable[int | float | bool | None]:
    return column if isinstance(column, Numbers) else column.tolist()
