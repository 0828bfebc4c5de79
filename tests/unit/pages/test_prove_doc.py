"""docs/prove.md: its programs are proved and refuted as it says, in its order, in one folder."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

pytestmark = pytest.mark.extra("prove")

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "prove.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(?P<kind>\w+)(?: (?P<file>\S+))?\n(?P<text>.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)


MENDS = "    rung([~status.MODULE_OK, status.CONFIG_ERROR], CLR(outputs[0]))"


def shown(text: str) -> list[str]:
    """Return lines without times, counts of values, and which of the shortest runs was found."""
    timed = r"\d+\.\d\d s   \([\d,]+ tags of"
    lines = [re.sub(timed, "T s   (N tags of", line) for line in text.splitlines()]
    runs = [re.sub(r"^    scan (\d+): .*", r"    scan \1: what changes", line) for line in lines]
    return [re.sub(r"^    on the rack: .*", "    on the rack: what it did", line) for line in runs]


def unmended(folder: Path) -> None:
    """Write the line in rungs as it was before the page's rung was there."""
    shutil.copytree(folder / "examples" / "three_stations_ladder", folder / "before")
    text = (folder / "before" / "line.py").read_text("utf-8")
    assert MENDS in text
    assert MENDS in TEXT
    (folder / "before" / "line.py").write_text(text.replace(MENDS, "    pass"), "utf-8")


def test_the_properties_are_those_of_the_example() -> None:
    rack = (ROOT / "examples" / "three_stations_ladder" / "line.toml").read_text("utf-8")
    (shown,) = [
        each["text"]
        for each in BLOCK.finditer(TEXT)
        if "lost position" in each["text"][:60] and each["kind"] == "toml"
    ]
    assert rack.endswith(shown)


def test_the_test_of_the_page_passes() -> None:
    names: dict[str, Any] = {}
    (code,) = [each["text"] for each in BLOCK.finditer(TEXT) if each["kind"] == "python"]
    exec(code, names)
    names["test_one_direction"]()


@pytest.mark.slow
def test_what_the_page_shows_happens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    unmended(tmp_path)
    ran = 0
    for block in BLOCK.finditer(TEXT):
        if block["file"]:
            (tmp_path / block["file"]).write_text(block["text"], encoding="utf-8")
        if block["kind"] != "console":
            continue
        for command, printed in COMMAND.findall(block["text"]):
            program, *words = shlex.split(command)
            assert program == "scanrack"
            done = CliRunner().invoke(build(), words)
            assert shown(done.stdout) == shown(printed), command  # stderr: what is left
            ran += 1
    assert ran >= 6
