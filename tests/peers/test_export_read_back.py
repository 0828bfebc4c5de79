"""Exports, read back by software that others wrote, hold what the trace holds."""

from __future__ import annotations

import csv
import math
import shutil
import signal
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_tags import MadeTags
from made_traces import A3601, PERIOD_NS, idle, record
from scanrack.io_images.amci3601 import StatusView
from scanrack.traces import Scan, ScanRecorder, SlotInfo, Tag, open_trace
from scanrack.traces.export import to_pandas, to_polars, write_csv, write_parquet, write_vcd
from scanrack.traces.signals import Selection

SCANS = 300
SLOTS = (A3601, SlotInfo(2, "a toy"))
SIGNALS = [
    "slot1.in.position",
    "slot1.in.COMMAND_ERROR",
    "slot1.in.MODE_CONFIG",
    "slot2.out.word7",
    "slot1.speed",
]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    words = idle(SCANS, slots=2)
    words[:100, 8] |= 0x0002  # MOVING_CCW
    words[:100, 11] = -7 * np.arange(100) % -1000
    words[:100, 10] = -7 * np.arange(100) // 1000 + 1
    words[100:, 10:12] = (-1, -345)
    words[150:160, 8] |= 0x1000  # COMMAND_ERROR
    words[200:203, 8] = -31_682  # configuration mode: no position
    words[:, 23] = np.arange(SCANS) // 3 - 50
    return record(tmp_path_factory.mktemp("export") / "a.mcap", words, SLOTS)


@pytest.fixture(scope="module")
def scans(path: Path) -> list[Scan]:
    with open_trace(path) as trace:
        return list(trace.scans())


def positions(scans: list[Scan]) -> list[int | None]:
    views = [StatusView(scan.inputs(1)) for scan in scans]
    return [None if view.MODE_CONFIG else view.position for view in views]


def errors(scans: list[Scan]) -> list[bool]:
    return [StatusView(scan.inputs(1)).COMMAND_ERROR for scan in scans]


def word7(scans: list[Scan]) -> list[int]:
    return [scan.outputs(2)[7] for scan in scans]


def test_csv_by_the_standard_library(path: Path, scans: list[Scan], tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    with open_trace(path) as trace:
        assert write_csv(trace, target, SIGNALS) == SCANS
    with target.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["scan"]) for row in rows] == list(range(SCANS))
    assert [int(row["time_ns"]) for row in rows] == [scan.now_ns for scan in scans]
    told = [int(row["slot1.in.position"]) if row["slot1.in.position"] else None for row in rows]
    assert told == positions(scans)
    assert [row["slot1.in.COMMAND_ERROR"] == "1" for row in rows] == errors(scans)
    assert [int(row["slot2.out.word7"]) for row in rows] == word7(scans)


def test_every_csv_row_has_every_column(path: Path, tmp_path: Path) -> None:
    with open_trace(path) as trace:
        write_csv(trace, tmp_path / "all.csv")
    with (tmp_path / "all.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert len(head) > 60
    assert {len(row) for row in rows} == {len(head)}


@pytest.mark.slow
@pytest.mark.extra("parquet")
def test_parquet_by_pyarrow(path: Path, scans: list[Scan], tmp_path: Path) -> None:
    from pyarrow import parquet

    target = tmp_path / "a.parquet"
    with open_trace(path) as trace:
        assert write_parquet(trace, target, SIGNALS, Selection(first=90, last=209)) == 120
    table = parquet.read_table(target).to_pydict()
    assert table["scan"] == list(range(90, 210))
    assert table["slot1.in.position"] == positions(scans)[90:210]
    assert table["slot1.in.COMMAND_ERROR"] == errors(scans)[90:210]
    assert table["slot2.out.word7"] == word7(scans)[90:210]


FAULTY = range(102, 120)
"""Scans in which a measurement is NaN."""

STEPS = ("IDLE", "FILL")


def row(n: int) -> bytes:
    """Return the tags of a scan: level, step, lamp."""
    return struct.pack("<fH?", math.nan if n in FAULTY else n / 4, n // 100 % 2, n % 3 == 0)


@pytest.fixture(scope="module")
def tagged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace with a REAL, a code and a bit of the program."""
    path, memory = tmp_path_factory.mktemp("tagged") / "a.mcap", bytearray(32)
    tags = MadeTags(memory, [Tag("Level", "REAL"), Tag("Step", "ENUM", 0, STEPS), Tag("Lamp", "BOOL")], row)
    recorder = ScanRecorder(path, memory, [A3601], scan_period_ns=PERIOD_NS, tags=tags)
    for n in range(SCANS):
        recorder.scan(n, n * PERIOD_NS, 0)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def measured(tagged: Path) -> Path:
    """Return a Parquet file of it."""
    with open_trace(tagged) as trace:
        write_parquet(trace, tagged.with_suffix(".parquet"))
    return tagged.with_suffix(".parquet")


def by_duckdb(path: Path) -> list[int]:
    found = pytest.importorskip("duckdb", reason="duckdb is not installed").connect()
    question = 'select scan from read_parquet(?) where isnan("tags.level") order by scan'
    return [scan for (scan,) in found.execute(question, [str(path)]).fetchall()]


def by_datafusion(path: Path) -> list[int]:
    context = pytest.importorskip("datafusion", reason="datafusion is not installed").SessionContext()
    context.register_parquet("scans", str(path))
    found = context.sql('select scan from scans where isnan("tags.level") order by scan').to_pydict()
    scans: list[int] = found["scan"]
    return scans


def by_polars(path: Path) -> list[int]:
    polars = pytest.importorskip("polars", reason="polars is not installed")
    found = polars.scan_parquet(path).filter(polars.col("tags.level").is_nan()).select("scan").collect()
    scans: list[int] = found["scan"].to_list()
    return scans


def by_pyarrow(path: Path) -> list[int]:
    from pyarrow import compute, dataset

    table = dataset.dataset(path).to_table(["scan"], filter=compute.is_nan(compute.field("tags.level")))
    scans: list[int] = table["scan"].to_pylist()
    return scans


@pytest.mark.slow
@pytest.mark.extra("parquet")
@pytest.mark.parametrize("reader", [by_duckdb, by_datafusion, by_polars, by_pyarrow])
def test_each_reader_of_parquet_finds_the_faulty_scans(
    measured: Path, reader: Callable[[Path], list[int]]
) -> None:
    """DuckDB 2.0.1 skips row groups by statistics, which have no NaN: findings/duckdb-isnan-parquet."""
    assert reader(measured) == list(FAULTY)


@pytest.mark.slow
@pytest.mark.extra("frames")
def test_pandas(path: Path, scans: list[Scan]) -> None:
    import pandas

    with open_trace(path) as trace:
        frame = to_pandas(trace, SIGNALS)
    assert frame["time_ns"].tolist() == [scan.now_ns for scan in scans]
    position = frame["slot1.in.position"]
    assert [None if pandas.isna(value) else int(value) for value in position] == positions(scans)
    rising = frame.index[frame["slot1.in.COMMAND_ERROR"].astype(int).diff() == 1]
    assert rising.tolist() == [150]


@pytest.mark.slow
@pytest.mark.extra("frames")
def test_polars(path: Path, scans: list[Scan]) -> None:
    with open_trace(path) as trace:
        frame = to_polars(trace, SIGNALS)
    assert frame["slot1.in.position"].to_list() == positions(scans)
    assert frame["slot1.in.COMMAND_ERROR"].to_list() == errors(scans)


def signed(bits: str, width: int) -> int | None:
    """Return what a reader of value change dumps gave as bits."""
    if "x" in bits:
        return None
    value = int(bits, 2)
    return value - (1 << width) if value >> (width - 1) else value


def dump(path: Path, target: Path) -> Path:
    with open_trace(path) as trace:
        write_vcd(trace, target)
    return target


@pytest.fixture
def vcdvcd() -> Any:
    """The reader; importing it lets a closed pipe kill the process, which is undone."""
    before = signal.getsignal(signal.SIGPIPE)
    module = pytest.importorskip("vcdvcd", reason="vcdvcd is not installed")
    signal.signal(signal.SIGPIPE, before)
    return module


def test_vcd_by_vcdvcd(path: Path, scans: list[Scan], tmp_path: Path, vcdvcd: Any) -> None:
    read = vcdvcd.VCDVCD(str(dump(path, tmp_path / "a.vcd")))
    assert float(read.timescale["timescale"]) == 1e-9
    times = [scan.now_ns for scan in scans]
    position = read["slot1.in.position"]
    assert [signed(position[time], 32) for time in times] == positions(scans)
    error = read["slot1.in.COMMAND_ERROR"]
    assert [error[time] == "1" for time in times] == errors(scans)
    assert error.tv == [(0, "0"), (150 * PERIOD_NS, "1"), (160 * PERIOD_NS, "0")]  # changes, nothing else
    unknown = [time for time, bits in position.tv if "x" in bits]
    assert unknown == [200 * PERIOD_NS]  # once, though for three scans
    word = read["slot2.out.word7[15:0]"]
    assert [signed(word[time], 16) for time in times] == word7(scans)
    assert read.endtime == times[-1]


def test_vcd_by_pyvcd(path: Path, tmp_path: Path) -> None:
    reader = pytest.importorskip("vcd.reader", reason="pyvcd is not installed")
    with dump(path, tmp_path / "a.vcd").open("rb") as file:
        tokens = list(reader.tokenize(file))
    scopes, depth = [], []
    for token in tokens:
        if token.kind is reader.TokenKind.SCOPE:
            depth.append(token.data.ident)
        elif token.kind is reader.TokenKind.UPSCOPE:
            depth.pop()
        elif token.kind is reader.TokenKind.VAR:
            scopes.append((".".join(depth), token.data.reference, token.data.type_.value, token.data.size))
    assert depth == []
    assert ("slot1.in", "position", "integer", 32) in scopes
    assert ("slot1.out", "ABSOLUTE_MOVE", "wire", 1) in scopes
    assert ("slot2.in", "word0", "wire", 16) in scopes
    times = [token.data for token in tokens if token.kind is reader.TokenKind.CHANGE_TIME]
    assert times[:2] == [0, PERIOD_NS]
    assert times == sorted(set(times[:-1])) + times[-1:]


@pytest.mark.skipif(shutil.which("vcd2fst") is None, reason="GTKWave's vcd2fst is not installed")
def test_vcd_by_gtkwave(path: Path, tmp_path: Path, vcdvcd: Any) -> None:
    source = dump(path, tmp_path / "a.vcd")
    fst, back = tmp_path / "a.fst", tmp_path / "back.vcd"
    subprocess.run(["vcd2fst", source, fst], check=True, capture_output=True, timeout=120)
    with back.open("wb") as file:
        subprocess.run(["fst2vcd", fst], check=True, stdout=file, timeout=120)
    first, second = (vcdvcd.VCDVCD(str(file)) for file in (source, back))
    names = {"slot1.in.position": 32, "slot1.in.COMMAND_ERROR": 1, "slot2.out.word7[15:0]": 16}
    for name, width in names.items():
        there = next(other for other in second.signals if other.startswith(name.partition("[")[0]))
        times = [PERIOD_NS * scan for scan in range(SCANS)]
        was, now = ([signed(one[time], width) for time in times] for one in (first[name], second[there]))
        assert was == now


Changes = dict[str, list[tuple[int, str | float]]]
"""Changes by variable: time, and bits, a number or a text."""

BITS_OF_LAMP = [(n * PERIOD_NS, "1" if n % 3 == 0 else "0") for n in range(SCANS) if n % 3 != 2]
NAMES_OF_STEP = [(n * PERIOD_NS, STEPS[n // 100 % 2]) for n in range(0, SCANS, 100)]


def changes_in(path: Path) -> Changes:
    """Return what the reader of pyvcd finds in a value change dump."""
    reader = pytest.importorskip("vcd.reader", reason="pyvcd is not installed")
    kinds, now = reader.TokenKind, 0
    names: dict[str, list[str]] = {}
    found: Changes = {}
    with path.open("rb") as file:
        for token in reader.tokenize(file):
            if token.kind is kinds.VAR:
                names.setdefault(token.data.id_code, []).append(token.data.reference)
            elif token.kind is kinds.CHANGE_TIME:
                now = token.data
            elif token.kind in (kinds.CHANGE_SCALAR, kinds.CHANGE_REAL, kinds.CHANGE_STRING):
                for name in names[token.data.id_code]:
                    found.setdefault(name, []).append((now, token.data.value))
    return found


@pytest.fixture(scope="module")
def tagged_dump(tagged: Path) -> Path:
    """Return a value change dump of the tags."""
    with open_trace(tagged) as trace:
        write_vcd(trace, tagged.with_suffix(".vcd"), ["tags.*"])
    return tagged.with_suffix(".vcd")


def test_pyvcd_reads_names_of_codes(tagged_dump: Path) -> None:
    found = changes_in(tagged_dump)
    assert (found["step"], found["lamp"]) == (NAMES_OF_STEP, BITS_OF_LAMP)
    levels = dict(found["level"])
    assert levels[101 * PERIOD_NS] == 101 / 4
    assert math.isnan(float(levels[102 * PERIOD_NS]))


def test_vcdvcd_reads_bits_and_numbers_beside_a_code(tagged_dump: Path, vcdvcd: Any) -> None:
    """It gives no value of a string variable: findings/vcdvcd-strings."""
    read = vcdvcd.VCDVCD(str(tagged_dump))
    assert read["tags.lamp"].tv == BITS_OF_LAMP
    assert read["tags.step"].tv == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "steps"),
    [
        ("fst", NAMES_OF_STEP),
        ("lxt2", [(0, math.nan)]),  # neither has texts
        ("vzt", [(0, 0.0)]),
    ],
)
def test_gtkwave_converts_bits_beside_a_code(
    tagged_dump: Path, tmp_path: Path, form: str, steps: list[tuple[int, str | float]]
) -> None:
    if shutil.which(f"vcd2{form}") is None:
        pytest.skip(f"GTKWave's vcd2{form} is not installed")
    converted, back = tmp_path / f"a.{form}", tmp_path / "back.vcd"
    subprocess.run([f"vcd2{form}", tagged_dump, converted], check=True, capture_output=True, timeout=120)
    with back.open("wb") as file:
        subprocess.run([f"{form.removesuffix('2')}2vcd", converted], check=True, stdout=file, timeout=120)
    found = changes_in(back)
    assert found["lamp"] == BITS_OF_LAMP
    assert repr(found["step"]) == repr(steps)  # NaN is not equal to itself
