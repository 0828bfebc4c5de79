"""A trace for other programs: data frames, CSV, Parquet, VCD. See docs/query.md."""
