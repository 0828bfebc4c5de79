"""A string is a path, wherever a file is read or written; `-` is standard output in an export."""

import csv
import io
import sys

import pytest
from made_traces import idle, record
from scanrack import open_bench
from scanrack.commands import build
from scanrack.jobs import load_program
from scanrack.jobs.fuzz.invariants.invariants import InvariantError, load_invariants
from scanrack.runtime import load_rack_file
from scanrack.traces import open_trace
from scanrack.traces.export import write_csv, write_parquet, write_vcd
from scanrack.traces.plot import Envelope, read_chart, save_figure, save_page
from scanrack.traces.read.reader import open_records
from scanrack.traces.repair import repair
from scanrack.traces.write.line import LineRecorder, UnitColumns
from typer.testing import CliRunner


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    record(tmp_path / "a.mcap", idle(20))
    (tmp_path / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    rack = 'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    (tmp_path / "line.toml").write_text(rack, encoding="utf-8")
    return tmp_path


def test_reading(folder):
    with open_trace("a.mcap") as trace:
        assert len(list(trace.scans())) == 20
    open_records("a.mcap").close()
    assert load_rack_file("line.toml").spec.program == "line.py"
    assert load_program("line.py", str(folder)).name == "logic"
    with open_bench("line.toml", "b.mcap") as bench:
        assert bench.scans == 0
    with pytest.raises(InvariantError, match=r"nowhere\.py: no such file"):
        load_invariants("nowhere.py")


def test_writing(folder):
    with open_trace("a.mcap") as trace:
        assert write_csv(trace, "a.csv") == write_vcd(trace, "a.vcd") == 20
        save_page(trace, "a.html")
    LineRecorder("line.mcap", [UnitColumns(1, ("position",))], {}).close()
    (folder / "cut.mcap").write_bytes((folder / "a.mcap").read_bytes()[:-100])
    repair("cut.mcap", "whole.mcap")
    made = {path.name for path in folder.iterdir()}
    assert {"a.csv", "a.vcd", "a.html", "line.mcap", "whole.mcap"} <= made


@pytest.mark.slow
@pytest.mark.extra("parquet")
@pytest.mark.extra("plot")
def test_writing_with_the_extras(folder):
    with open_trace("a.mcap") as trace:
        assert write_parquet(trace, "a.parquet") == 20
        save_figure(read_chart(trace, Envelope), "a.svg")
    assert (folder / "a.svg").stat().st_size > 1000


def export(*arguments):
    return CliRunner().invoke(build(), ["export", "a.mcap", *arguments])


def test_an_export_to_standard_output(folder):
    done = export("--csv", "-")
    assert (done.exit_code, done.stderr) == (0, "-: 20 scans\n")
    assert len(list(csv.DictReader(io.StringIO(done.stdout)))) == 20
    assert not (folder / "-").exists()
    assert export("--csv", "a.csv").exit_code == 0
    assert (folder / "a.csv").read_text(encoding="utf-8") == done.stdout


def test_vcd_goes_there_too(folder):
    assert "$enddefinitions" in export("--vcd", "-", "--quiet").stdout


@pytest.mark.extra("parquet")
def test_parquet_goes_there_too(folder):
    assert export("--parquet", "-").stdout_bytes[:4] == b"PAR1"


def test_one_format_at_a_time_goes_there(folder):
    done = export("--csv", "-", "--vcd", "-")
    assert (done.exit_code, done.stderr) == (2, "scanrack: only one output can go to standard output\n")
