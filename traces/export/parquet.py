"""Writes a trace as a Parquet file, in row groups of whole blocks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

from scanrack.io_images.installing import install_line

from ..extras import need
from ..files.guard import beginning
from ..files.newfile import Target, new_file
from ..read.reader import Trace
from ..signals import ALL, Selection
from .format import ExportFormat
from .table import Column, table

PARQUET = beginning("a Parquet file", b"PAR1")

ROWS = 65_536
"""Minimum rows in each row group but the last, since small groups compress poorly and are slow to read."""


def write_parquet(
    trace: Trace,
    path: Target,
    signals: Sequence[str] = (),
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> int:
    """Write a trace as a Parquet file with zstd; return the number of rows. For the arguments, see `table`.

    Raises:
        MissingExtraError: pyarrow is not installed.
        UnknownSignalError, EmptySelectionError: see `table`.
    """
    pyarrow, parquet = need("pyarrow", "parquet"), need("pyarrow.parquet", "parquet")
    batches = (_batch(pyarrow, columns) for columns in table(trace, signals, selection, progress=progress))
    first_batch = next(batches)
    rows, waiting_rows = 0, []
    with (
        new_file(path, PARQUET, "wb") as file,
        parquet.ParquetWriter(
            file,
            first_batch.schema,
            compression="zstd",
            write_statistics=_columns_with_statistics(pyarrow, first_batch.schema),
        ) as writer,
    ):
        for batch in chain([first_batch], batches):
            waiting_rows.append(batch)
            rows += batch.num_rows
            if sum(waiting.num_rows for waiting in waiting_rows) >= ROWS:
                writer.write_table(pyarrow.Table.from_batches(waiting_rows))
                waiting_rows.clear()
        if waiting_rows:
            writer.write_table(pyarrow.Table.from_batches(waiting_rows))
    return rows


def _columns_with_statistics(pyarrow: Any, schema: Any) -> list[str]:
    """Return the names of all columns except floats.

    The minimum and maximum in a float's statistics ignore NaN. DuckDB would therefore skip row groups with a
    NaN that a query selects; see docs/findings.md.
    """
    return [field.name for field in schema if not pyarrow.types.is_floating(field.type)]


def _batch(pyarrow: Any, columns: Sequence[Column]) -> Any:
    arrays = [pyarrow.array(column.values, mask=column.missing) for column in columns]
    return pyarrow.RecordBatch.from_arrays(arrays, names=[column.name for column in columns])


FORMAT = ExportFormat(
    name="parquet",
    kind=PARQUET,
    write=write_parquet,
    help="Write a Parquet file, a row per scan.",
    contents=f"as CSV, typed and compressed; needs `{install_line('parquet')}`",
    reader="pandas, polars, DuckDB",
    binary=True,
)
