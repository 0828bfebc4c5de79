"""Exports a trace as data frames, CSV, Parquet, VCD, JSON lines or MCAP. See docs/query.md."""

from .csvfile import write_csv
from .frames import to_pandas, to_polars
from .jsonl import write_jsonl
from .mcapfile import write_mcap
from .parquet import write_parquet
from .vcd import write_vcd

__all__ = ["to_pandas", "to_polars", "write_csv", "write_jsonl", "write_mcap", "write_parquet", "write_vcd"]
