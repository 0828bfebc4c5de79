"""docs/prove.md: its programs are proved and refuted as it says, in its order, in one folder."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

pytestmark = pytest.mark.extra("prove")

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "prove.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(?P<kind>\w+)(?: (?P<file>\S+))?\n(?P<text>.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)


def shown(text: str) -> list[str]:
    """Return lines without times and counts of values: those change with the prover, not what it says."""
    return [re.sub(r"\d+\.\d\d s   \([\d,]+ tags of", "T s   (N tags of", line) for line in text.splitlines()]


def test_what_the_page_shows_happens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
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
            assert shown(done.output) == shown(printed), command
            ran += 1
    assert ran >= 6
