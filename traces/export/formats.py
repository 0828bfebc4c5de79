"""The formats of `scanrack export`, in the order of its options.

To add a format, add a module with a `FORMAT` to this folder, and its name to the list below.
"""

from __future__ import annotations

from . import csvfile, jsonl, mcapfile, parquet, vcd

FORMATS = (csvfile.FORMAT, parquet.FORMAT, vcd.FORMAT, jsonl.FORMAT, mcapfile.FORMAT)
