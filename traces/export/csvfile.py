"""A trace as a CSV file, with a row per scan, bits as 0 and 1, and empty cells for missing values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain, groupby

import numpy as np
from scanrack.io_images.csv_cells import cell

from ..files.guard import beginning
from ..files.newfile import Target, new_file
from ..read.reader import Trace
from ..signals import ALL, Selection
from .format import ExportFormat
from .table import Column, table

CSV = beginning("a table of scans", b"scan,time_ns")


def write_csv(
    trace: Trace,
    path: Target,
    signals: Sequence[str] = (),
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> int:
    """Write a trace as a CSV file; return the number of rows. The arguments are the same as in `table`.

    Raises:
        UnknownSignalError, EmptySelectionError: see `table`.
    """
    rows = 0
    blocks = table(trace, signals, selection, progress=progress)
    first_block = next(blocks)
    with new_file(path, CSV, newline="") as file:
        file.write(",".join(_quoted(column.name) for column in first_block) + "\n")
        for columns in chain([first_block], blocks):
            file.write(_lines(columns))
            rows += len(columns[0].values)
    return rows


def _lines(columns: Sequence[Column]) -> str:
    """Return the rows of a block as lines; adjacent columns of bits are formatted together, see `_bits`."""
    cells_by_column: list[list[str]] = []
    for is_bits, run_columns in groupby(columns, lambda column: column.values.dtype == bool):
        adjacent_columns = list(run_columns)
        cells_by_column += [_bits(adjacent_columns)] if is_bits else map(_cells, adjacent_columns)
    return "\n".join(map(",".join, zip(*cells_by_column, strict=True))) + "\n"


def _bits(columns: Sequence[Column]) -> list[str]:
    """Return the adjacent cells of several columns of bits as one text per row, such as "0,1,1".

    This is faster than creating a text for each bit.
    """
    rows, width = len(columns[0].values), 2 * len(columns) - 1
    text = np.full((rows, width), ord(","), np.uint8)
    for index, column in enumerate(columns):
        text[:, 2 * index] = column.values + np.uint8(ord("0"))
    digits = text.tobytes().decode("ascii")
    return [digits[start : start + width] for start in range(0, len(digits), width)]


def _cells(column: Column) -> list[str]:
    """Return the values of a column as cells; the cell of a missing value is empty."""
    values = list(map(str, column.values.tolist()))
    if column.values.dtype == object:
        values = list(map(_quoted, values))
    if column.missing is not None:
        for row in np.flatnonzero(column.missing):
            values[row] = ""
    return values


def _quoted(text: str) -> str:
    """Return text as a CSV cell [RFC 4180], see `csv_cells`.

    >>> _quoted("FILL"), _quoted('a "b", c'), _quoted("=1")
    ('FILL', '"a ""b"", c"', "'=1")
    """
    text = str(cell(text))
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\r\n') else text


FORMAT = ExportFormat(
    name="csv",
    kind=CSV,
    write=write_csv,
    help="Write a CSV file, a row per scan.",
    contents="a row per scan; bits as 0 and 1, an empty cell for a missing value",
    reader="spreadsheets",
)
