"""docs/panel.md: its files are those of the example, and its commands print what it says."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from scanrack.runtime.cli import build
from typer.testing import CliRunner

HERE = Path(__file__).parents[2]
PAGE = (HERE / "docs" / "panel.md").read_text(encoding="utf-8")
EXAMPLE = HERE / "examples" / "three_stations_panel"


def block(kind: str) -> str:
    """Return the page's block of a kind."""
    return PAGE.partition(f"```{kind}\n")[2].partition("```")[0]


def test_the_page_shows_the_files_of_the_example() -> None:
    rack = (EXAMPLE / "line.toml").read_text(encoding="utf-8")
    assert rack.endswith(block("toml"))
    assert block("text") in (EXAMPLE / "line.rung").read_text(encoding="utf-8")


def test_its_commands_print_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(EXAMPLE, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    for command, printed in re.findall(r"\$ scanrack (.*)\n((?:[^$].*\n)*)", block("console")):
        result = CliRunner().invoke(build(), command.split())
        assert (result.exit_code, result.stdout) == (0, printed)
