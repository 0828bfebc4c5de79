"""A trace for other programs: data frames, CSV, Parquet, VCD. See docs/query.md."""

from .csvfile import write_csv
from .frames import to_pandas, to_polars
from .parquet import write_parquet
from .vcd import write_vcd

__all__ = ["to_pandas", "to_polars", "write_csv", "write_parquet", "write_vcd"]
