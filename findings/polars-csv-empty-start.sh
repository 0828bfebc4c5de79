#!/usr/bin/env bash
# what: polars silently reads a column of numbers as text if its first hundred rows are empty
# date: 2026-11-29
# meets: anyone who reads a table of scans whose tag has no value at first
# expected: numbers, or an error, as for a column that begins with whole numbers and continues with fractions
# behavior:
#   read_csv infers types from infer_schema_length rows, 100. A column that is empty in all of them becomes String, and
#   whatever follows is kept as text; a column of whole numbers that continues with 0.5 raises ComputeError, and read_ndjson
#   raises for both. With infer_schema_length=None the numbers are numbers. pandas and DuckDB read numbers.
# product: Parquet has types, so nothing is inferred; for CSV pass `infer_schema_length=None`; see [export](query.md#export)
# output:
#   empty, then 0.5: read_csv String
#   empty, then 0.5: read_csv, infer_schema_length=None Float64
#   empty, then 0.5: read_ndjson ComputeError
#   1, then 0.5: read_csv ComputeError
#   1, then 0.5: read_csv, infer_schema_length=None Float64
#   1, then 0.5: read_ndjson ComputeError
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install polars==2.1.0
observe python - <<'PY'
import json

import polars

READERS = {
    "read_csv": lambda: polars.read_csv("table.csv"),
    "read_csv, infer_schema_length=None": lambda: polars.read_csv("table.csv", infer_schema_length=None),
    "read_ndjson": lambda: polars.read_ndjson("table.jsonl"),
}
for what, first in {"empty, then 0.5": None, "1, then 0.5": 1}.items():
    rows = [{"scan": scan, "level": first if scan < 100 else 0.5} for scan in range(110)]
    with open("table.csv", "w") as file:
        file.write("scan,level\n")
        file.writelines(f"{row['scan']},{'' if row['level'] is None else row['level']}\n" for row in rows)
    with open("table.jsonl", "w") as file:
        file.writelines(json.dumps(row) + "\n" for row in rows)
    for name, read in READERS.items():
        try:
            print(f"{what}: {name}", read()["level"].dtype)
        except polars.exceptions.ComputeError:
            print(f"{what}: {name}", "ComputeError")
PY
