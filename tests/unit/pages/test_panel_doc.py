"""Parts 4 and 5 of docs/tutorial: files are those of the example, `check` and `plot` do as they say."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

HERE = Path(__file__).parents[3]
PAGE = (HERE / "docs" / "tutorial" / "4-panel.md").read_text(encoding="utf-8")
MISTAKES = (HERE / "docs" / "tutorial" / "5-why.md").read_text(encoding="utf-8")
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


def indented(page: str, first: str) -> list[str]:
    """Return the lines of the indented block that begins so."""
    lines = page[page.index(f"    {first}") :].splitlines()
    return [line[4:] for line in lines[: next(at for at, line in enumerate(lines) if not line)]]


@pytest.mark.slow
def test_check_names_three_planted_mistakes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_with_mistakes(tmp_path)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(build(), ["check", "line.toml"])
    assert result.exit_code == 1
    assert result.stdout.splitlines()[:4] == [*indented(MISTAKES, "line.rung:40: search"), "3 findings"]


def copy_to_run(folder: Path) -> None:
    """Copy the example without its watchdog: a busy machine is no reason for a fault."""
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    rack = folder / "line.toml"
    rack.write_text("watchdog_ms = 0\n" + rack.read_text(encoding="utf-8"), encoding="utf-8")


@pytest.mark.slow
@pytest.mark.extra("plot")
def test_the_chart_shows_lamp_step_and_dwell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_to_run(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(build(), ["run", "line.toml", "--quiet"]).exit_code == 0
    (command,) = indented(PAGE, "scanrack plot line.mcap --out")
    svg = command.replace(".png", ".svg").split()[1:]
    assert CliRunner().invoke(build(), svg).exit_code == 0
    text = Path("panel.svg").read_text(encoding="utf-8")
    for name in ("start", "stop", "lamp", "Step", "Dwell.ACC", "Dwell.TT", "Run", "Dwell.PRE 500"):
        assert f">{name}<" in text
