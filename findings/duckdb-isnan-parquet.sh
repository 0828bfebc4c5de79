#!/usr/bin/env bash
# what: DuckDB finds no NaN in Parquet files of pyarrow and polars, because their statistics omit NaN
# date: 2026-11-29
# meets: anyone who filters an exported recording for missing or faulty measurements
# expected: every reader finds the two NaN, since minimum and maximum say nothing about NaN
# behavior:
#   pyarrow and polars write minimum and maximum of the numbers and ignore NaN. DuckDB orders NaN above all numbers,
#   trusts the maximum and concludes that no row is NaN: isnan finds none, not isnan finds all rows, the NaN among them,
#   and level > 100 finds none. DuckDB's own files have no minimum and maximum in a column with NaN; there it finds two.
#   polars and pyarrow find both NaN in every file.
# product: The export writes no statistics for REAL, and a test checks this in DuckDB, DataFusion, polars and pyarrow; see [export](query.md#export)
# output:
#   pyarrow wrote minimum 1.0 maximum 3.0
#     duckdb isnan(level) 0
#     duckdb not isnan(level) 5
#     duckdb level > 100 0
#     polars is_nan 2
#     pyarrow is_nan 2
#   polars wrote minimum 1.0 maximum 3.0
#     duckdb isnan(level) 0
#     duckdb not isnan(level) 5
#     duckdb level > 100 0
#     polars is_nan 2
#     pyarrow is_nan 2
#   duckdb wrote minimum None maximum None
#     duckdb isnan(level) 2
#     duckdb not isnan(level) 3
#     duckdb level > 100 2
#     polars is_nan 2
#     pyarrow is_nan 2
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyarrow==26.0.1 polars==2.1.0 duckdb==2.0.1
observe python - <<'PY'
import duckdb
import polars
import pyarrow
import pyarrow.compute
import pyarrow.parquet

levels = [1.0, float("nan"), 2.0, float("nan"), 3.0]
rows = pyarrow.table({"level": levels})
pyarrow.parquet.write_table(rows, "pyarrow.parquet")
polars.DataFrame({"level": levels}).write_parquet("polars.parquet")
duckdb.sql("copy (select * from rows) to 'duckdb.parquet' (format parquet)")
for writer in ("pyarrow", "polars", "duckdb"):
    name = f"{writer}.parquet"
    kept = pyarrow.parquet.read_metadata(name).row_group(0).column(0).statistics
    print(writer, "wrote minimum", kept.min, "maximum", kept.max)
    for where in ("isnan(level)", "not isnan(level)", "level > 100"):
        print("  duckdb", where, duckdb.sql(f"select count(*) from '{name}' where {where}").fetchall()[0][0])
    print("  polars is_nan", polars.scan_parquet(name).filter(polars.col("level").is_nan()).collect().height)
    print("  pyarrow is_nan", pyarrow.compute.is_nan(pyarrow.parquet.read_table(name)["level"]).to_pylist().count(True))
PY
