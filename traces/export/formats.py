"""The formats of `scanrack export`, in the order of its options.

A new one is a file with a `FORMAT` in this folder, and a word in the row below.
"""

from __future__ import annotations

from . import csvfile, jsonl, mcapfile, parquet, vcd

FORMATS = (csvfile.FORMAT, parquet.FORMAT, vcd.FORMAT, jsonl.FORMAT, mcapfile.FORMAT)
