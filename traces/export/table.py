"""The selected signals of a trace as columns of a table, block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..read.reader import Trace
from ..signals import ALL, Block, Catalog, Selection, Signal, SignalKind, blocks
from ..signals.signal import names_of, whole_numbers

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a block."""

    name: str  # the signal's name, or "scan" or "time_ns"
    values: Array  # bool, whole numbers, floats, or texts (of type object)
    missing: NDArray[np.bool_] | None = None  # True in rows without a value; None if no row can lack one


def table(
    trace: Trace,
    signals: Sequence[str] = (),
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> Iterator[list[Column]]:
    """Iterate over a trace as a table, a block of rows at a time: scan, time_ns, and a column per signal.

    Args:
        signals: names or patterns, see `Catalog.matching`.
        progress: called for each block with the number of scans read so far.

    Raises:
        UnknownSignalError: a signal does not exist; raised by the call itself, before the first block.
        EmptySelectionError: no scan is in the selection.
    """
    chosen_signals = Catalog.of(trace).matching(signals)
    return (_columns(block, chosen_signals) for block in blocks(trace, selection, progress=progress))


def _columns(block: Block, signals: Sequence[Signal]) -> list[Column]:
    time_columns = [Column("scan", block.scan), Column("time_ns", block.time_ns)]
    return time_columns + [_column(signal, signal.read(block)) for signal in signals]


def _column(signal: Signal, values: Array) -> Column:
    """Return a signal's values as a column: integers for decoded values, names or texts for codes."""
    if signal.kind is SignalKind.VALUE:
        return Column(signal.name, *whole_numbers(values))
    if signal.kind is SignalKind.CODE:
        return Column(signal.name, np.array(names_of(values, signal.names), dtype=object))
    return Column(signal.name, values)
