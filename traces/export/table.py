"""The selected signals of a trace as columns, block by block, with a table's types."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..read.reader import Trace
from ..signals import ALL, Block, Catalog, Selection, Signal, SignalKind, blocks
from ..signals.signal import named, whole_numbers

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a block."""

    name: str  # the signal's name, or "scan" or "time_ns"
    values: Array  # bool, whole numbers, floats, or texts (of type object)
    missing: NDArray[np.bool_] | None = None  # rows without a value; None if there are none


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
        progress: called at each block with the number of scans read so far.

    Raises:
        UnknownSignalError: no such signal; raised at once.
        EmptySelectionError: no scan is in the selection.
    """
    chosen_signals = Catalog.of(trace).matching(signals)
    return (_columns(block, chosen_signals) for block in blocks(trace, selection, progress=progress))


def _columns(block: Block, chosen: Sequence[Signal]) -> list[Column]:
    time_columns = [Column("scan", block.scan), Column("time_ns", block.time_ns)]
    return time_columns + [_column(signal, signal.read(block)) for signal in chosen]


def _column(signal: Signal, values: Array) -> Column:
    if signal.kind is SignalKind.VALUE:
        return Column(signal.name, *whole_numbers(values))
    if signal.kind is SignalKind.CODE:
        return Column(signal.name, np.array(named(values, signal.names), dtype=object))
    return Column(signal.name, values)
