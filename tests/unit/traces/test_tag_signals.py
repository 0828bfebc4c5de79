"""Recorded tags are signals like any other: query, CSV, Parquet, VCD, show, compare, plot."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from struct import pack

import numpy as np
import pytest
from made_tags import MadeTags
from recorded_numbers import record_numbers
from scanrack.commands import build
from scanrack.traces import ScanRecorder, SlotInfo, Tag, open_trace
from scanrack.traces.compare import Tolerance, compare, report
from scanrack.traces.export import write_csv, write_vcd
from scanrack.traces.format.flags import flag_names
from scanrack.traces.format.tagplan import plan_of
from scanrack.traces.query import query
from scanrack.traces.read.changes import ChangeRows
from scanrack.traces.read.tag_text import TagText
from scanrack.traces.signals import Catalog
from scanrack.traces.signals.catalog import UnknownSignalError
from typer.testing import CliRunner

SCANS = 300
SLOTS = [SlotInfo(1, "amci3601", "4.1")]
TEXTS = ("water", 'oil, "hot"', "")
TAGS = [
    Tag(r"\Main.Lamp", "BOOL"),
    Tag("Fill.ACC", "DINT"),
    Tag("Step", "ENUM", 0, ("IDLE", "FILL", "HOLD")),
    Tag("Recipe", "INT", 2),
    Tag("Level", "REAL"),
    Tag("Medium", "TEXT"),
]


def row(scan: int, step: int) -> bytes:
    return pack("<ifHhhH?", 2 * scan, scan / 2, step, scan, 7, scan // 100, scan % 20 < 5)


def texts(scan: int) -> Mapping[str, Sequence[tuple[int, str]]]:
    return {} if scan % 100 else {"Medium": [(scan // 100, TEXTS[scan // 100])]}


def made(path: Path, changed: Mapping[int, int] = {}) -> Path:
    memory = bytearray(32)
    tags = MadeTags(memory, TAGS, lambda scan: row(scan, changed.get(scan, scan // 10 % 3)), texts)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags)
    for scan in range(SCANS):
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace with tags of every kind."""
    return made(tmp_path_factory.mktemp("tags") / "made.mcap")


def test_the_order_of_the_row_is_that_of_the_plan() -> None:
    fields = [field.name for field in plan_of(TAGS).fields]
    assert fields == ["fill_acc", "level", "step", "recipe", "medium", "main_lamp"]


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("rose(tags.main_lamp)", SCANS // 20 - 1),  # on from scan 0, where nothing rises
        ("rose(Lamp)", SCANS // 20 - 1),
        ("rose(main_lamp)", SCANS // 20 - 1),
        ("tags.step.FILL", SCANS // 30),
        ("Step.HOLD", SCANS // 30),
        ("tags.fill_acc >= 100", 1),
        ("Fill.ACC == 100", 1),
        ("tags.fill_acc.2", SCANS * 2 // 8),  # bit 2 of 0, 2, 4, ...: on for two scans in four
        ("tags.recipe.0 == 7", 1),
        ("tags.recipe.1 == 7", 1),
        ("changed(tags.medium)", 2),
        (r"\Main.Lamp and Recipe[0] < 20", 1),
        ("Recipe[1] == 7", 1),
        ('Step == "FILL"', SCANS // 30),
        ('Step != "FILL"', SCANS // 30 + 1),
        ("""Medium == 'oil, "hot"'""", 1),
        ('"water" == Medium', 1),
        ('Medium == "never there"', 0),
        ("I:1.0/14", 0),
    ],
)
def test_queries(trace: Path, text: str, count: int) -> None:
    with open_trace(trace) as opened:
        assert query(opened, f"count({text})").count == count


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('Level == "full"', "column 7: use == or != to compare a text with a step, or with a tag"),
        ('Step > "FILL"', "use == or != to compare a text with a step, or with a tag"),
        ("Recipe > 3", r"Recipe has 2 values: write Recipe[0] or Recipe[1]"),
    ],
)
def test_texts_and_parts_that_are_refused(trace: Path, text: str, says: str) -> None:
    with open_trace(trace) as opened, pytest.raises(ValueError, match=re.escape(says)):
        query(opened, text)


@pytest.mark.parametrize("name", ["tags.level.3", "tags.step.NONE", "tags.recipe.2", "Lam"])
def test_there_is_no_such_signal(trace: Path, name: str) -> None:
    with open_trace(trace) as opened, pytest.raises(UnknownSignalError):
        Catalog.of(opened)[name]


def test_a_name_of_two_tags_means_neither() -> None:
    catalog = Catalog(SLOTS, plan_of([Tag(r"\A.Run", "BOOL"), Tag(r"\B.Run", "BOOL")]))
    assert "Run" not in catalog
    assert catalog["a_run"].name == "tags.a_run"


def test_csv_has_names_for_codes(trace: Path, tmp_path: Path) -> None:
    with open_trace(trace) as opened:
        write_csv(opened, tmp_path / "tags.csv", ["tags.*"])
    with (tmp_path / "tags.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == SCANS
    assert rows[115]["tags.fill_acc"] == "230"
    assert rows[115]["tags.step"] == "HOLD"
    assert rows[115]["tags.medium"] == 'oil, "hot"'
    assert rows[115]["tags.recipe.0"] == "115"
    assert rows[115]["tags.level"] == "57.5"
    assert rows[115]["tags.main_lamp"] == "0"


@pytest.mark.extra("parquet")
def test_parquet_has_names_for_codes(trace: Path, tmp_path: Path) -> None:
    from pyarrow import parquet
    from scanrack.traces.export import write_parquet

    with open_trace(trace) as opened:
        write_parquet(opened, tmp_path / "tags.parquet", ["tags.*"])
    read = parquet.read_table(tmp_path / "tags.parquet").to_pydict()
    assert read["tags.step"][115] == "HOLD"
    assert read["tags.fill_acc"][115] == 230


def test_vcd_has_strings_and_numbers(trace: Path, tmp_path: Path) -> None:
    with open_trace(trace) as opened:
        write_vcd(opened, tmp_path / "tags.vcd", ["tags.*"])
    lines = (tmp_path / "tags.vcd").read_text("ascii").splitlines()
    (step,) = [line.split()[3] for line in lines if line.endswith(" step $end")]
    told = [line for line in lines if line.startswith("s") and line.endswith(f" {step}")]
    assert told[:4] == [f"sIDLE {step}", f"sFILL {step}", f"sHOLD {step}", f"sIDLE {step}"]
    assert len(told) == SCANS // 10


def test_columns_keep_the_type_of_the_tag(trace: Path) -> None:
    from scanrack.traces.signals import blocks

    with open_trace(trace) as opened:
        catalog = Catalog.of(opened)
        (block,) = blocks(opened)
        assert catalog["tags.level"].read(block).dtype == np.float32
        assert catalog["tags.fill_acc"].read(block).dtype == np.int32


@pytest.mark.parametrize("every", [False, True])
def test_show_tells_changes_by_full_name(trace: Path, *, every: bool) -> None:
    with open_trace(trace) as opened:
        assert opened.head.tags is not None
        tags = TagText(opened.head.tags, opened.texts(), every=every)
        changes = ChangeRows(SLOTS, flag_names, every=every, tags=tags)
        rows = [
            row
            for section in opened.sections
            for part in opened.scan_rows(section)
            for row in changes.rows_of(part, np.ones(len(part), bool), opened.as_scans)
        ]
    told = {row.scan: row.text for row in rows if row.direction == "tags"}
    if every:
        assert told[11] == "Fill.ACC 20 -> 22 Level 5.0 -> 5.5 Recipe[0] 10 -> 11"
    else:
        assert told[0] == r"Step IDLE Medium 'water' +\Main.Lamp"
        assert told[5] == r"-\Main.Lamp"
        assert told[10] == "Step IDLE -> FILL"
        assert told[100] == r"""Step IDLE -> FILL Medium 'water' -> 'oil, "hot"' +\Main.Lamp"""
        assert 11 not in told


def test_rows_one_by_one_are_those_of_arrays(trace: Path) -> None:
    with open_trace(trace) as opened:
        assert opened.head.tags is not None
        tags = TagText(opened.head.tags, opened.texts())
        one, other = (ChangeRows(SLOTS, flag_names, tags=tags) for _ in range(2))
        by_scan = [row for scan in opened.scans() for row in one.rows(scan)]
        by_array = [
            row
            for section in opened.sections
            for part in opened.scan_rows(section)
            for row in other.rows_of(part, np.ones(len(part), bool), opened.as_scans)
        ]
    assert by_scan == by_array


def test_show_prints_tags(trace: Path) -> None:
    result = CliRunner().invoke(build(), ["show", str(trace)])
    assert result.exit_code == 0, result.output
    assert "Step FILL -> HOLD" in result.output


def test_the_same_tags_compare_equal(trace: Path, tmp_path: Path) -> None:
    with open_trace(trace) as one, open_trace(made(tmp_path / "same.mcap")) as other:
        assert compare(one, other).same


@pytest.mark.parametrize("tolerance", [Tolerance(), Tolerance(time_ns=2_000_000)])
def test_a_tag_that_differs_is_told_by_name(trace: Path, tmp_path: Path, tolerance: Tolerance) -> None:
    with open_trace(trace) as one, open_trace(made(tmp_path / "other.mcap", {115: 0})) as other:
        found = compare(one, other, tolerance)
    assert found.first is not None
    assert (found.first.scan, found.differing) == (115, 1)
    (detail,) = found.first.details
    assert (detail.direction, detail.name, detail.text_a, detail.text_b) == ("tags", "Step", "HOLD", "IDLE")
    assert [extent.name for extent in found.extents] == ["tags.Step"]
    assert any("Step" in line and "HOLD" in line and "IDLE" in line for line in report(found, ("a", "b")))


def test_codes_are_compared_by_what_they_stand_for(tmp_path: Path) -> None:
    def write(name: str, names: tuple[str, ...], code: int, more: list[Tag]) -> Path:
        memory, path = bytearray(32), tmp_path / name
        wanted = [Tag("Step", "ENUM", 0, names), Tag("Level", "REAL"), *more]
        tags = MadeTags(memory, wanted, lambda _: pack("<fH", float("nan"), code) + bytes(len(more)))
        recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags)
        recorder.scan(0, 0, 0)
        recorder.close()
        return path

    one = write("one.mcap", ("IDLE", "FILL"), 1, [])
    other = write("other.mcap", ("FILL", "IDLE"), 0, [Tag("Lamp", "BOOL")])
    with open_trace(one) as a, open_trace(other) as b:
        found = compare(a, b)
    assert found.same, "FILL is FILL, and NaN is NaN"
    assert ("tags of one trace only", "", "Lamp") in found.heads


def test_vcd_has_all_digits_of_a_number(tmp_path: Path) -> None:
    """0.1 + 0.2 takes 17 digits."""
    numbers = [0.1 + 0.2, 0.3, 1e300, -1 / 3]
    recorded = record_numbers(tmp_path / "reals.mcap", {"Level": ("LREAL", numbers)})
    with open_trace(recorded) as opened:
        write_vcd(opened, tmp_path / "reals.vcd", ["tags.*"])
    lines = (tmp_path / "reals.vcd").read_text("ascii").splitlines()
    assert [float(line[1:].split()[0]) for line in lines if line.startswith("r")] == numbers
