"""Traces of tags that are numbers, and integers around the places where floats and types end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from struct import Struct

from hypothesis import strategies as st
from made_tags import MadeTags
from scanrack.traces import ScanRecorder, SlotInfo, Tag

PERIOD_NS = 2_000_000

BITS = {"SINT": 8, "USINT": 8, "INT": 16, "UINT": 16, "DINT": 32, "UDINT": 32, "LINT": 64, "ULINT": 64}
"""Types of integers, and their widths."""

Values = Mapping[str, tuple[str, Sequence[float]]]
"""By name of a tag: its type, and its value in each scan."""


def ends(kind: str) -> tuple[int, int]:
    """Return the least and the greatest value of a type."""
    bits = BITS[kind]
    return (0, 2**bits - 1) if kind.startswith("U") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def integers(kind: str) -> st.SearchStrategy[int]:
    """Integers of a type, often where a float64 skips one or another type ends."""
    least, most = ends(kind)
    landmarks = [
        sign * 2**power + step for sign in (1, -1) for power in (7, 31, 53, 63) for step in range(-2, 3)
    ]
    near = [value for value in (*landmarks, least, least + 1, most - 1, most, 0) if least <= value <= most]
    return st.sampled_from(near) | st.integers(least, most)


def record_numbers(path: Path, values: Values) -> Path:
    """Record tags that are numbers; each has a value for every scan."""
    tags = [Tag(name, kind) for name, (kind, _) in values.items()]
    made = MadeTags(bytes(32), tags, lambda scan: row(scan))
    form = Struct(f"<{made.plan.letters}")
    columns = [values[field.tag.name][1] for field in made.plan.fields]

    def row(scan: int) -> bytes:
        return form.pack(*(column[scan] for column in columns))

    recorder = ScanRecorder(
        path, bytearray(32), [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=PERIOD_NS, tags=made
    )
    for scan in range(len(columns[0])):
        recorder.scan(scan, scan * PERIOD_NS, 0)
    recorder.close()
    return path
