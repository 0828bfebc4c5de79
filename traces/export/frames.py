"""A trace as a pandas or polars data frame, or as an Arrow table.

    with open_trace(path) as trace:
        frame = to_pandas(trace, ["slot1.in.position", "slot1.in.*ERROR"])

Bits are bool, words int16, and speeds float64. Decoded values are int64; they are
missing in configuration mode.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..extras import need
from ..read.reader import Trace
from ..signals import ALL, Selection
from .table import Column, table

if TYPE_CHECKING:
    import pandas
    import polars


def to_pandas(trace: Trace, signals: Sequence[str] = (), selection: Selection = ALL) -> pandas.DataFrame:
    """Return a trace as a pandas DataFrame; columns that can have missing values have pandas' type Int64.

    Args:
        signals: names or patterns; empty = all bits and decoded values.

    Raises:
        MissingExtraError: pandas is not installed.
        UnknownSignalError: a signal does not exist.
        EmptySelectionError: no scan is in the selection.
    """
    pd = need("pandas", "frames")

    def series(column: Column) -> Any:
        if column.missing is None:
            return column.values
        return pd.arrays.IntegerArray(column.values, column.missing)

    frame: pandas.DataFrame = pd.DataFrame(_series_by_name(trace, signals, selection, series))
    return frame


def to_polars(trace: Trace, signals: Sequence[str] = (), selection: Selection = ALL) -> polars.DataFrame:
    """Return a trace as a polars DataFrame, with null for missing values; see `to_pandas`."""
    pl = need("polars", "frames")

    def series(column: Column) -> Any:
        is_text = column.values.dtype == object  # polars takes texts only from a list
        values = pl.Series(column.name, column.values.tolist() if is_text else column.values)
        if column.missing is None:
            return values
        return values.set(pl.Series(column.missing), None)

    frame: polars.DataFrame = pl.DataFrame(_series_by_name(trace, signals, selection, series))
    return frame


def _series_by_name(
    trace: Trace, signals: Sequence[str], selection: Selection, series: Callable[[Column], Any]
) -> dict[str, Any]:
    """Read the selected signals; return, by name, the result of `series` for each signal's whole column."""
    columns_by_name: dict[str, list[Column]] = {}
    for columns in table(trace, signals, selection):
        for column in columns:
            columns_by_name.setdefault(column.name, []).append(column)
    return {name: series(_joined_column(columns)) for name, columns in columns_by_name.items()}


def _joined_column(columns: Sequence[Column]) -> Column:
    """Join the blocks of a signal's column."""
    masks = [column.missing for column in columns if column.missing is not None]
    return Column(
        columns[0].name,
        np.concatenate([column.values for column in columns]),
        np.concatenate(masks) if masks else None,
    )
