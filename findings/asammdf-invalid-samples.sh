#!/usr/bin/env bash
# what: asammdf computes with samples that are marked invalid: resample uses their values, and a table has numbers in their place
# date: 2026-11-30
# meets: anyone who evaluates a measurement whose sensor or bus failed for a moment
# expected: no sample or NaN at the two invalid times, in every way to read the file
# behavior:
#   The samples at 1 and 3 s are invalid and hold 2 and 4. get leaves them out. to_dataframe and the CSV export hold 15.5
#   and 30 there, a line between the neighbors and the last one, without a mark. resample interpolates with the invalid
#   values: 17 at 2.5 s is the mean of 30 and the invalid 4. A conversion to MDF 3, which has no such bits, makes all four
#   valid. mf4-rs reads NaN.
# product: Exports are VCD, CSV and Parquet, and no sample of a recording is marked invalid: [export](query.md#export)
# output:
#   written: 1 2 30 4, valid yes no yes no
#   get: 0s 1, 2s 30
#   to_dataframe: 0s 1, 1s 15.5, 2s 30, 3s 30
#   resample(0.5): 0s 1, 0.5s 1.5, 2s 30, 2.5s 17
#   as MDF 3.30: 0s 1, 1s 2, 2s 30, 3s 4
#   mf4-rs: 1 nan 30 nan
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asammdf==8.8.28 mf4-rs==3.7.0 numpy==2.4.6 pandas==3.1.1
observe python - <<'PY'
import mf4_rs
import numpy as np
from asammdf import MDF, Signal

VALUES = np.array([1.0, 2.0, 30.0, 4.0])
INVALID = np.array([False, True, False, True])


def show(name, times, values):
    print(f"{name}:", ", ".join(f"{time:g}s {value:g}" for time, value in zip(times, values)))


def show_signal(name, file):
    signal = file.get("level")
    show(name, signal.timestamps, signal.samples)


with MDF(version="4.11") as file:
    file.append([Signal(VALUES, np.arange(4.0), name="level", invalidation_bits=INVALID)])
    file.save("level.mf4")
print(f"written: {' '.join(f'{value:g}' for value in VALUES)}, valid", *["no" if invalid else "yes" for invalid in INVALID])
with MDF("level.mf4") as file:
    show_signal("get", file)
    table = file.to_dataframe()
    show("to_dataframe", table.index, table["level"])
    show_signal("resample(0.5)", file.resample(0.5))
    file.convert("3.30").save("level.mdf")
with MDF("level.mdf") as file:
    show_signal("as MDF 3.30", file)
print("mf4-rs:", *[f"{value:g}" for value in mf4_rs.Mdf("level.mf4").values("level")])
PY
