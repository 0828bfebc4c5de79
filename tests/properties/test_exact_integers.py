"""Integers of any width and sign stay what they are: in queries, comparisons, exports, charts and `show`."""

from __future__ import annotations

import csv
import math
import operator
import tempfile
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_numbers import BITS, PERIOD_NS, ends, integers, record_numbers
from scanrack.traces import Tag, open_trace
from scanrack.traces.compare import Tolerance, compare
from scanrack.traces.export import write_csv, write_vcd
from scanrack.traces.format.tagplan import plan_of
from scanrack.traces.plot import read_chart
from scanrack.traces.plot.page import PackedCurve, PackedNumbers
from scanrack.traces.query import query
from scanrack.traces.query.columns import Scans
from scanrack.traces.query.language import parse
from scanrack.traces.read.tag_text import TagText
from scanrack.traces.signals import Catalog

SCANS = 6
COMPARE = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
SUMS = {"+": operator.add, "-": operator.sub, "*": operator.mul}
WIDE = 2**53 + 1

Part = tuple[str, Callable[[int], Any]]


@st.composite
def columns(draw: st.DrawFn, kinds: Sequence[str] = tuple(BITS)) -> tuple[str, list[int]]:
    kind = draw(st.sampled_from(kinds))
    return kind, draw(st.lists(integers(kind), min_size=SCANS, max_size=SCANS))


@st.composite
def parts(draw: st.DrawFn, tags: dict[str, list[int]], depth: int = 2) -> Part:
    """Draw an expression, and the same one in Python."""
    what = draw(st.sampled_from(["tag", "number", "sum", "abs", "minus"] if depth else ["tag", "number"]))
    if what == "tag":
        name = draw(st.sampled_from(sorted(tags)))
        return name, lambda scan: tags[name][scan]
    if what == "number":
        value: float = draw(integers("ULINT") | st.sampled_from([0.5, 2.0**53, 2.0**63]))
        return (repr(value) if isinstance(value, int) else f"{value:.1f}"), lambda scan: value
    left = draw(parts(tags, depth - 1))
    if what == "abs":
        return f"abs({left[0]})", lambda scan: abs(left[1](scan))
    if what == "minus":
        return f"(-{left[0]})", lambda scan: -left[1](scan)
    right, sign = draw(parts(tags, depth - 1)), draw(st.sampled_from(sorted(SUMS)))
    return f"({left[0]} {sign} {right[0]})", lambda scan: SUMS[sign](left[1](scan), right[1](scan))


@pytest.mark.slow
@given(data=st.data(), a=columns(), b=columns())
def test_queries_are_pythons_arithmetic(
    data: st.DataObject, a: tuple[str, list[int]], b: tuple[str, list[int]]
) -> None:
    tags = {"A": a[1], "B": b[1]}
    left, right = data.draw(parts(tags)), data.draw(parts(tags))
    sign = data.draw(st.sampled_from(sorted(COMPARE)))
    holds = [COMPARE[sign](left[1](scan), right[1](scan)) for scan in range(SCANS)]
    plan = plan_of([Tag("A", a[0]), Tag("B", b[0])])
    values = {f"tags.{field.name}": np.array(tags[field.tag.name], field.letters) for field in plan.fields}
    scans = Scans(np.arange(SCANS), np.arange(SCANS) * PERIOD_NS, values)

    def asked(text: str) -> list[int]:
        (holds,) = parse(text, Catalog([], plan)).conditions
        return np.flatnonzero(holds(scans)).tolist()

    assert asked(f"{left[0]} {sign} {right[0]}") == [scan for scan in range(SCANS) if holds[scan]]
    assert asked("changed(A)") == [scan for scan in range(1, SCANS) if a[1][scan] != a[1][scan - 1]]


def test_the_next_integer_is_another_one(tmp_path: Path) -> None:
    """9007199254740993 has no float64: as one it is its neighbor."""
    path = record_numbers(tmp_path / "t.mcap", {"L8": ("LINT", [WIDE] * 3)})
    with open_trace(path) as trace:
        assert query(trace, f"count(L8 == {WIDE - 1})").count == 0
        (found,) = query(trace, f"L8 == {WIDE}", show=["L8"]).occurrences
        assert list(found.shown.values()) == [WIDE]
        assert query(trace, f"L8 > {WIDE - 1}.0").count == 1


NUMBERS = (*BITS, "REAL", "LREAL")
FLOATS = st.sampled_from([0.0, -0.5, 2.0**53, 2.0**63, 2.0**64, -(2.0**63), 1e300, math.inf, math.nan])


@st.composite
def twins(draw: st.DrawFn) -> tuple[tuple[str, list[float]], tuple[str, list[float]]]:
    """Draw two columns of any types, whose values are often the same."""
    one, other = draw(st.sampled_from(NUMBERS)), draw(st.sampled_from(NUMBERS))
    values: list[list[float]] = [[], []]
    for _ in range(SCANS):
        for kind, own in ((one, values[0]), (other, values[1])):
            near = values[0][-1] if own is values[1] else None
            own.append(draw(_value(kind, near)))
    return (one, values[0]), (other, values[1])


def _value(kind: str, near: float | None) -> st.SearchStrategy[float]:
    if kind not in BITS:
        known = [] if near is None or math.isnan(near) or abs(near) > 1e30 else [float(near)]
        width = FLOATS if kind == "LREAL" else FLOATS.filter(lambda value: value != 1e300)
        return (st.sampled_from(known) | width if known else width).map(_as_real if kind == "REAL" else float)
    least, most = ends(kind)
    if near is None or not math.isfinite(near) or not least <= int(near) <= most:
        return integers(kind)
    return st.just(int(near)) | integers(kind)


def _as_real(value: float) -> float:
    return float(np.float32(value))


@pytest.mark.slow
@pytest.mark.parametrize("tolerant", [False, True])
@settings(max_examples=amount(6))
@given(pairs=st.lists(twins(), min_size=8, max_size=8))
def test_numbers_of_two_types_compare_as_pythons(
    pairs: list[tuple[tuple[str, list[float]], tuple[str, list[float]]]], *, tolerant: bool
) -> None:
    """NaN is equal to NaN; with a tolerance of one scan a value must be there within a scan."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [
            record_numbers(
                Path(folder) / f"{side}.mcap", {f"N{at}": pair[side] for at, pair in enumerate(pairs)}
            )
            for side in (0, 1)
        ]
        with open_trace(paths[0]) as first, open_trace(paths[1]) as second:
            found = compare(first, second, Tolerance(time_ns=PERIOD_NS if tolerant else 0))
    extents = {extent.name: extent for extent in found.extents}
    for at, ((_, a), (_, b)) in enumerate(pairs):
        wanted = {scan for scan in range(SCANS) if missing(a, b, scan, int(tolerant))}
        if tolerant:  # either trace must have what the other shows
            wanted |= {scan for scan in range(SCANS) if missing(b, a, scan, 1)}
            wanted &= set(range(1, SCANS - 1))  # beyond the ends nothing is known
        extent = extents.get(f"tags.N{at}")
        if tolerant:
            assert not wanted or (extent is not None and extent.scans >= len(wanted))
            assert wanted or extent is None or extent.first in (0, SCANS - 1)
        else:
            assert (0 if extent is None else extent.scans) == len(wanted)
    for detail in found.first.details if found.first else ():
        one, other = pairs[int(detail.name[1:])]
        assert found.first is not None
        said = one[1][found.first.scan], other[1][found.first.scan_b]
        assert (float(detail.text_a), float(detail.text_b)) == pytest.approx(said, nan_ok=True)


def missing(values: list[float], others: list[float], scan: int, reach: int) -> bool:
    near = others[max(0, scan - reach) : scan + reach + 1]
    return not any(values[scan] == each or (math.isnan(values[scan]) and math.isnan(each)) for each in near)


@settings(max_examples=amount(6))
@given(data=st.data())
def test_exports_have_every_digit(data: st.DataObject) -> None:
    """Every type of integer is recorded, and a number that never changes."""
    tags = {kind: (kind, data.draw(columns([kind]))[1]) for kind in BITS}
    tags["Same"] = "ULINT", [data.draw(integers("ULINT"))] * SCANS
    with tempfile.TemporaryDirectory() as folder:
        with open_trace(record_numbers(Path(folder) / "t.mcap", tags)) as trace:
            write_csv(trace, Path(folder) / "t.csv", ["tags.*"])
            write_vcd(trace, Path(folder) / "t.vcd", ["tags.*"])
            assert trace.head.tags is not None
            text, rows = TagText(trace.head.tags, {}, every=True), [scan.tags for scan in trace.scans()]
            program = read_chart(trace, PackedCurve, exact=PackedNumbers, tags=["Same"]).panels[-1]
        with (Path(folder) / "t.csv").open(newline="", encoding="utf-8") as file:
            cells = list(csv.DictReader(file))
        told = [text.changes(*pair).split() for pair in pairwise(rows)]
        for name, (kind, values) in tags.items():
            assert [int(each[f"tags.{name.lower()}"]) for each in cells] == values
            assert vcd_values(Path(folder) / "t.vcd", name.lower(), kind) == values
            for words, (before, after) in zip(told, pairwise(values), strict=True):
                at = words.index(name) if name in words else None
                assert (at is None) == (before == after)
                assert at is None or words[at : at + 4] == [name, str(before), "->", str(after)]
        assert dict(program.unchanged) == {"Same": str(tags["Same"][1][0])}


def vcd_values(path: Path, name: str, kind: str) -> list[int]:
    """Read a number of a dump, in every scan."""
    signed, at, found = not kind.startswith("U"), 0, {}
    lines = path.read_text("ascii").splitlines()
    (declared,) = [line.split() for line in lines if line.startswith("$var") and f" {name} " in line]
    assert declared[1:3] == ["integer" if signed else "wire", str(BITS[kind])]
    for line in lines:
        if line.startswith("#"):
            at = int(line[1:]) // PERIOD_NS
        elif line.startswith("b") and line.split()[1] == declared[3]:
            value = int(line[1:].split()[0], 2)
            found[at] = value - 2 ** BITS[kind] * (signed and value >= 2 ** (BITS[kind] - 1))
    values = [found[0]]
    for scan in range(1, SCANS):
        values.append(found.get(scan, values[-1]))
    return values


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["LINT", "ULINT"])
def test_frames_and_parquet_have_every_digit(tmp_path: Path, kind: str) -> None:
    from scanrack.traces.export import to_pandas, to_polars, write_parquet

    values = [*ends(kind), WIDE, 2**63 - 1]
    path = record_numbers(tmp_path / "t.mcap", {"N": (kind, values)})
    pytest.importorskip("pandas")
    with open_trace(path) as trace:
        assert to_pandas(trace, ["N"])["tags.n"].tolist() == values
    pytest.importorskip("polars")
    with open_trace(path) as trace:
        assert to_polars(trace, ["N"])["tags.n"].to_list() == values
    parquet = pytest.importorskip("pyarrow.parquet")
    with open_trace(path) as trace:
        write_parquet(trace, tmp_path / "t.parquet", ["N"])
    assert parquet.read_table(tmp_path / "t.parquet").to_pydict()["tags.n"] == values
