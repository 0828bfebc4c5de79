"""docs/panel.md: its files are those of the example, and its commands print what it says."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

HERE = Path(__file__).parents[3]
PAGE = (HERE / "docs" / "panel.md").read_text(encoding="utf-8")
EXAMPLE = HERE / "examples" / "three_stations_panel"


def block(kind: str) -> str:
    """Return the page's block of a kind."""
    return PAGE.partition(f"```{kind}\n")[2].partition("```")[0]


def test_the_page_shows_the_files_of_the_example() -> None:
    rack = (EXAMPLE / "line.toml").read_text(encoding="utf-8")
    assert rack.endswith(block("toml"))
    assert block("text") == (EXAMPLE / "line.rung").read_text(encoding="utf-8")


def test_the_words_of_the_configuration_are_those_of_the_program(capsys: pytest.CaptureFixture[str]) -> None:
    exec(block("python"), {})
    words = capsys.readouterr().out.strip()
    assert words.replace("'", "").replace("16#0000", "0").replace("16#01F4", "500") in block("text")


def copy_with_mistakes(folder: Path) -> None:
    """Write a copy of the line without its home switch, with a second coil, and with a speed of 4,000,000."""
    rack = (EXAMPLE / "line.toml").read_text(encoding="utf-8")
    home = '    { input = "home", first = -1500, last = -1300 },\n'
    rungs = (EXAMPLE / "line.rung").read_text(encoding="utf-8")
    assert home in rack
    (folder / "line.toml").write_text(rack.replace(home, ""), encoding="utf-8")
    lamp = "XIC(Run)OTE(Lamp);\n"
    rungs = rungs.replace(lamp, lamp + "XIC(Going)OTE(Lamp);\n").replace(
        "Target,4000,10", "Target,4000000,10"
    )
    (folder / "line.rung").write_text(rungs, encoding="utf-8")


def indented(first: str) -> list[str]:
    """Return the lines of the indented block that begins so."""
    lines = PAGE[PAGE.index(f"    {first}") :].splitlines()
    return [line[4:] for line in lines[: next(at for at, line in enumerate(lines) if not line)]]


def test_check_names_three_planted_mistakes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_with_mistakes(tmp_path)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(build(), ["check", "line.toml"])
    assert result.exit_code == 1
    assert result.stdout.splitlines()[:4] == [*indented("line.rung:40: search"), "3 findings"]


def copy_to_run(folder: Path) -> None:
    """Copy the example without its watchdog: a busy machine is no reason for a fault."""
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    rack = folder / "line.toml"
    rack.write_text("watchdog_ms = 0\n" + rack.read_text(encoding="utf-8"), encoding="utf-8")


@pytest.mark.slow
def test_why_says_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_to_run(tmp_path)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(build(), ["why", "line.toml", "Lamp", "--at", "9.5s"])
    assert result.stdout.splitlines() == indented("after 4,751 scans")


@pytest.mark.slow
@pytest.mark.extra("plot")
def test_the_chart_shows_lamp_step_and_dwell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_to_run(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(build(), ["run", "line.toml", "--quiet"]).exit_code == 0
    (command,) = indented("scanrack plot line.mcap --out")
    svg = command.replace(".png", ".svg").split()[1:]
    assert CliRunner().invoke(build(), svg).exit_code == 0
    text = Path("panel.svg").read_text(encoding="utf-8")
    for name in ("start", "stop", "lamp", "Step", "Dwell.ACC", "Dwell.TT", "Run", "Dwell.PRE 500"):
        assert f">{name}<" in text


@pytest.mark.slow
def test_its_commands_print_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_to_run(tmp_path)
    monkeypatch.chdir(tmp_path)
    for command, printed in re.findall(r"\$ scanrack (.*)\n((?:[^$].*\n)*)", block("console")):
        result = CliRunner().invoke(build(), command.split())
        assert (result.exit_code, result.stdout) == (0, printed)
