"""Texts that others may have made are no formulas in any table that scanrack writes."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import pytest
from house import ROOMS
from scanrack.commands import build
from scanrack.io_images.csv_cells import FORMULA
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]

PROGRAM = """PROGRAM p
TAG Note : STRING := "{}"
TAG Run : BOOL
ROUTINE Main
XIC(Run)OTE(Run);
END
"""
RACK = """program = "p.rung"
tags = ["Note"]
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.mark.parametrize("begin", [each for each in FORMULA if each.isprintable()])
def test_a_text_of_a_trace_is_no_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begin: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.rung").write_text(PROGRAM.format(f"{begin}1, 2"), encoding="utf-8")
    Path("r.toml").write_text(RACK, encoding="utf-8")
    for words in (
        ["run", "r.toml", "--scans", "2", "--record", "r.mcap", "-q"],
        ["export", "r.mcap", "--csv", "r.csv"],
    ):
        assert CliRunner().invoke(build(), words).exit_code == 0
    rows = list(csv.DictReader(io.StringIO(Path("r.csv").read_text(encoding="utf-8"))))
    assert {row["tags.note"] for row in rows} == {f"'{begin}1, 2"}


def test_tables_are_written_in_one_place() -> None:
    """`csv.writer` knows no formulas; `traces.export.csvfile`, which is faster, has the same guard."""
    files = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    texts = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in files}
    assert [name for name, text in texts.items() if re.search(r"^import csv|csv\.writer", text, re.M)] == [
        "io_images/csv_cells.py"
    ]
    users = [name for name, text in texts.items() if re.search(r"csv_cells import", text)]
    assert users == [
        "scanrack/commands/programs/tags_job.py",
        "scanrack/jobs/run/servers/tag_formats.py",
        "traces/export/csvfile.py",
    ]
