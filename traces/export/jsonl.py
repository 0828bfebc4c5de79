"""A trace as JSON lines, with an object per scan, bits as false and true, and null for missing values."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from itertools import chain
from math import isfinite
from typing import Any

import numpy as np

from ..files.guard import beginning
from ..files.newfile import Target, new_file
from ..read.reader import Trace
from ..signals import ALL, Selection
from .format import ExportFormat
from .table import Column, table

JSONL = beginning("JSON lines of scans", b'{"scan":')


def write_jsonl(
    trace: Trace,
    path: Target,
    signals: Sequence[str] = (),
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> int:
    """Write a trace as JSON lines; return the number of lines. The arguments are the same as in `table`.

    Raises:
        UnknownSignalError, EmptySelectionError: see `table`.
    """
    rows = 0
    blocks = table(trace, signals, selection, progress=progress)
    first_block = next(blocks)
    encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode
    with new_file(path, JSONL) as file:
        for columns in chain([first_block], blocks):
            names = [column.name for column in columns]
            for row in zip(*map(_values, columns), strict=True):
                file.write(f"{encode(dict(zip(names, row, strict=True)))}\n")
            rows += len(columns[0].values)
    return rows


def _values(column: Column) -> list[Any]:
    """Return the values of a column as JSON values; a missing value, NaN or infinity becomes null."""
    values: list[Any] = column.values.tolist()
    if column.values.dtype.kind == "f":  # JSON has no NaN and no infinity
        values = [value if isfinite(value) else None for value in values]
    if column.missing is not None:
        for row in np.flatnonzero(column.missing):
            values[row] = None
    return values


FORMAT = ExportFormat(
    name="jsonl",
    kind=JSONL,
    write=write_jsonl,
    help="Write JSON lines, an object per scan.",
    contents="an object per scan; bits as false and true, null for a missing value",
    reader="scripts, jq",
)
