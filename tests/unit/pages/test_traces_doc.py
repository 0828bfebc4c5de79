"""The page about traces says what happens: its Python and its commands are run."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scanrack.commands import build
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "traces.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
CONSOLE = re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL)
COMMANDS = re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", "".join(CONSOLE), re.MULTILINE)
runner = CliRunner()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the trace of the example, and one whose end is missing."""
    folder = tmp_path_factory.mktemp("doc")
    rack = ROOT / "examples" / "three_stations" / "line.toml"
    trace = folder / "three-stations.mcap"
    result = runner.invoke(build(), ["run", str(rack), "-q", "--record", str(trace)])
    assert result.exit_code == 0
    (folder / "killed.mcap").write_bytes(trace.read_bytes()[:600_000])
    return folder


def run(code: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.chdir(folder)
    names: dict[str, Any] = {}
    exec(compile(code, "docs/traces.md", "exec"), names)
    return names


def test_scan_by_scan(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    run(PYTHON[0], folder, monkeypatch)
    assert capsys.readouterr().out == ""  # the example's line makes no error


def test_arrays(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    names = run(PYTHON[1], folder, monkeypatch)
    assert len(names["steps"]) == 25_000
    assert re.fullmatch(r"[\d,]+ steps in scan \d+, at [\d.]+ s\n", capsys.readouterr().out)


def test_slices(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    names = run(PYTHON[2], folder, monkeypatch)
    assert (names["first"], names["last"]) == (0, 24_999)
    assert np.array_equal(names["some"].scan, np.arange(1_000, 2_000))
    assert names["early"].time_ns[-1] == 2_000_000_000
    whole = run(PYTHON[1], folder, monkeypatch)["images"]["slot1"]["in"]
    assert names["in_motion"] == np.count_nonzero(whole["status_msw"] & 3)
    assert capsys.readouterr().out.startswith(f"{whole['position_msw'][12_345]}\n")


def test_commands(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    assert len(COMMANDS) == 2
    for command, printed in COMMANDS:
        program, *arguments = shlex.split(command)
        assert program == "scanrack"
        result = runner.invoke(build(), arguments)
        assert result.exit_code == 0
        for line in printed.splitlines():
            if line != "...":
                assert told(line) in {told(said) for said in result.output.splitlines()}


def told(line: str) -> str:
    """Return a line without numbers of bytes and versions, which depend on what is installed."""
    return re.sub(
        r"(?<=written by scanrack )\S+|(?<=byte )[\d,]+|[\d,]+(?= bytes)|(?<=of )[\d,]+$|(?<=about )[\d,]+",
        "#",
        line,
    )
