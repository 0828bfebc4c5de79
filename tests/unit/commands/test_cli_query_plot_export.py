"""`scanrack query`, `plot` and `export`: what they print, and what they refuse in one line."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest
from made_traces import idle, record
from scanrack.commands import build
from scanrack.traces import extras
from typer.testing import CliRunner

runner = CliRunner()


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    words = idle(100)
    words[40:43, 8] |= 0x1000
    words[70:90, 8] |= 0x1000
    words[:, 11] = np.arange(100)
    return record(tmp_path_factory.mktemp("cli") / "run.mcap", words, metadata={"name": "a rack"})


def run(*arguments: object) -> tuple[int, str, str]:
    result = runner.invoke(build(), [str(argument) for argument in arguments])
    return result.exit_code, result.stdout, result.stderr


def test_query_prints_a_row_for_each_time(path: Path) -> None:
    status, out, err = run("query", path, "slot1.in.COMMAND_ERROR", "--show", "slot1.in.position")
    lines = [line.split() for line in out.splitlines()]
    assert lines[1] == ["40", "42", "0.080", "6", "ms", "40"]
    assert lines[2] == ["70", "89", "0.140", "40", "ms", "70"]
    assert lines[3] == ["2", "times"]
    assert (status, err) == (0, "")


def test_query_counts(path: Path) -> None:
    assert run("query", path, "count(rose(slot1.in.COMMAND_ERROR))") == (0, "2\n", "")


def test_query_gives_the_longest_of_how_many(path: Path) -> None:
    _, out, _ = run("query", path, "longest(slot1.in.COMMAND_ERROR)")
    assert [line.split() for line in out.splitlines()[1:]] == [["70", "89", "0.140", "40", "ms"], ["of", "2"]]


def test_query_limits_its_rows(path: Path) -> None:
    _, out, _ = run("query", path, "slot1.in.COMMAND_ERROR", "--limit", 1)
    assert "... and 1 more" in out


def test_query_that_finds_nothing_ends_with_1(path: Path) -> None:
    assert run("query", path, "slot1.in.INPUT_ERROR") == (1, "never\n", "")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("query", "{}", "rose(slot1.in.X)"), "column 6: no signal 'slot1.in.X'"),
        (("query", "{}", "scan > 1", "--show", "slot1.in.positon"), "did you mean slot1.in.position"),
        (("query", "none.mcap", "scan > 1"), "none.mcap: No such file or directory"),
        (("plot", "{}", "--out", "{}.gif"), "the suffix must be .png, .svg, .html"),
        (("plot", "{}", "--title", "Line", "--slot", 2), "with names; these slots do: 1"),
        (("plot", "{}", "--range", "500:"), "no scan in scans from 500; it has scans 0 to 99"),
        (("plot", "{}", "--range", "3s:1s"), "ends before it begins"),
        (("plot", "{}", "--range", "3s"), "must be A:B, A: or :B"),
        (("plot", "{}", "--range", "1.5:2"), "write a number and a unit"),
        (("plot", "{}", "--range", "1:2", "--range", "3:4"), "--range 1:2 and 3:4: give only one"),
        (("export", "{}", "--csv", "{}"), "is the trace itself: choose another file"),
        (
            ("export", "{}", "--csv", "{}.csv", "--bits", "--signal", "*.position"),
            "--bits: no signal of *.position is a bit",
        ),
        (("export", "{}", "--mcap", "{}.mcap", "--bits"), "--bits: not possible for a copy as MCAP"),
        (("export", "{}"), "no output: give one or more of --csv, --parquet, --vcd"),
        (("export", "{}", "--csv", "{}.csv", "--signal", "slot9.*"), "no signal 'slot9.*'"),
        (("export", "{}", "--csv", "{}.csv", "--range", "200:"), "no scan in scans from 200"),
    ],
)
def test_mistakes_are_one_line_on_stderr(path: Path, arguments: tuple[object, ...], says: str) -> None:
    status, out, err = run(*(str(argument).format(path) for argument in arguments))
    assert (status, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1
    assert err.startswith("scanrack: ")


def test_an_export_that_fails_leaves_no_file(path: Path, tmp_path: Path) -> None:
    for option in ("--csv", "--parquet", "--vcd"):
        assert run("export", path, option, tmp_path / "a", "--range", "200:")[0] == 2
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_ends_with_3(path: Path, tmp_path: Path) -> None:
    for arguments in (("plot", path, "--out"), ("export", path, "--vcd")):
        status, _, err = run(*arguments, tmp_path / "no" / "a.html")
        assert status == 3
        assert err == f"scanrack: {tmp_path}/no/a.html: No such file or directory\n"


def test_plot_writes_a_page_beside_the_trace(path: Path) -> None:
    status, out, _ = run("plot", path)
    page = path.with_suffix(".html")
    assert status == 0
    assert out == f"{page}: {page.stat().st_size:,} bytes\n"
    assert "<title>a rack</title>" in page.read_text(encoding="utf-8")


def test_export_writes_bits_alone(path: Path, tmp_path: Path) -> None:
    csv, vcd = tmp_path / "a.csv", tmp_path / "a.vcd"
    assert run("export", path, "--csv", csv, "--vcd", vcd, "--bits", "--signal", "slot1.in.*")[0] == 0
    declared = [line.split() for line in vcd.read_text(encoding="ascii").splitlines() if "$var" in line]
    assert {tuple(words[1:3]) for words in declared} == {("wire", "1")}
    names = [words[4] for words in declared]
    assert "COMMAND_ERROR" in names
    head = csv.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert head == ["scan", "time_ns", *(f"slot1.in.{name}" for name in names)]


def test_export_writes_several_files_of_a_slice(path: Path, tmp_path: Path) -> None:
    csv, vcd = tmp_path / "a.csv", tmp_path / "a.vcd"
    arguments = ("--range", "20ms:40ms", "--signal", "slot1.in.position")
    status, out, _ = run("export", path, "--csv", csv, "--vcd", vcd, *arguments)
    assert status == 0
    assert [line.partition(", ")[0] for line in out.splitlines()] == [f"{csv}: 11 scans", f"{vcd}: 11 scans"]
    rows = csv.read_text(encoding="utf-8").splitlines()
    assert rows[0] == "scan,time_ns,slot1.in.position"
    assert (rows[1], rows[-1]) == ("10,20000000,10", "20,40000000,20")


@pytest.mark.parametrize(
    ("arguments", "library", "extra"),
    [
        (("plot", "--out", "a.png"), "matplotlib", "plot"),
        (("export", "--parquet", "a.parquet"), "pyarrow", "parquet"),
    ],
)
def test_a_missing_library_is_named_with_its_extra(
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    library: str,
    extra: str,
) -> None:
    def missing(name: str) -> object:
        if name.partition(".")[0] == library:
            raise ModuleNotFoundError(f"No module named {name!r}", name=library)
        return importlib.import_module(name)

    monkeypatch.setattr(extras, "import_module", missing)
    command, option, target = arguments
    status, _, err = run(command, path, option, tmp_path / target)
    assert status == 2
    assert (
        err == f'scanrack: {library} is not installed: pip install ".[{extra}]" in a checkout of scanrack\n'
    )
    assert list(tmp_path.iterdir()) == []
