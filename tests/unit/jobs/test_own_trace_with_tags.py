"""A recording of one's own program with recorded tags is not a foreign one: its table of tags is not run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import forked
import pytest

PROGRAM = """
from scanrack import Logic

class Line(Logic):
    rounds = 0

    def every_scan(self) -> None:
        self.rounds += 1
"""

RACK = """
program = "line.py"
trace = "line.mcap"
tags = ["line.rounds"]
run_for_s = 0.1

[[slot]]
number = 1
module = "amci3601"
"""


def scanrack(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return forked.run(
        [sys.executable, "-m", "scanrack", *words],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        encoding="utf-8",
    )


@pytest.mark.slow
def test_a_rerun_of_ones_own_program_with_recorded_tags_needs_no_trust(tmp_path: Path) -> None:
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    assert scanrack("run", "line.toml", folder=tmp_path).returncode == 0
    again = scanrack("replay", "--into", "session", "line.mcap", folder=tmp_path)
    assert "--trust" not in again.stderr
    assert again.returncode == 0, again.stderr
