"""Bounds of recorded tags: 10,000 values and 64 KiB a scan; beyond 1,000 values a run tells the cost."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner

WIDE = """
PROGRAM wide
TAG Few : INT[1000]
TAG Many : INT[9000]
TAG One : BOOL
TAG Long : LINT[8193]
ROUTINE Main
NOP();
END
"""


def run(tmp_path: Path, tags: str, *options: str) -> tuple[int, str]:
    """Run three scans; return exit status and standard error."""
    (tmp_path / "wide.rung").write_text(WIDE, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(
        f"program = 'wide.rung'\ntags = {tags}\n[[slot]]\nnumber = 1\nmodule = '1769-IQ16'\n",
        encoding="utf-8",
    )
    words = ["run", tmp_path / "rack.toml", "--scans", 3, "--record", tmp_path / "wide.mcap", *options]
    result = CliRunner().invoke(build(), [str(word) for word in words])
    return result.exit_code, result.stderr


def test_a_thousand_values_are_recorded_without_a_word(tmp_path: Path) -> None:
    assert run(tmp_path, '["Few"]') == (0, "")


def test_above_a_thousand_values_a_run_tells_what_they_cost(tmp_path: Path) -> None:
    """1,001 values of 20 ns are 20 µs; 1,000 INT and a BOOL are 2,001 bytes."""
    says = "1,001 values of tags are recorded in every scan: about 20 µs, and 2,001 bytes before compression"
    assert run(tmp_path, '["Few"]', "--tag", "One") == (0, f"scanrack: {says}\n")
    assert run(tmp_path, '["Few"]', "--tag", "One", "--quiet") == (0, "")


@pytest.mark.parametrize(
    ("tags", "has"),
    [
        ('["Few", "Many", "One"]', "10,001 values in 20,001 bytes"),
        ('["Long"]', "8,193 values in 65,544 bytes"),
    ],
)
def test_more_than_a_scan_may_have_is_refused(tmp_path: Path, tags: str, has: str) -> None:
    allowed = "must be at most 10,000 values and 65,536 bytes per scan: select fewer tags"
    assert run(tmp_path, tags) == (2, f"scanrack: the tags have {has}; {allowed}\n")
    assert not (tmp_path / "wide.mcap").exists()


def test_ten_thousand_values_are_recorded(tmp_path: Path) -> None:
    status, said = run(tmp_path, '["Few", "Many"]')
    assert (status, said.count("10,000 values")) == (0, 1)
    with open_trace(tmp_path / "wide.mcap") as trace:
        tags = read_columns(trace, tags=True).tags
    assert tags is not None
    assert (tags["few"].shape, tags["many"].shape) == ((3, 1000), (3, 9000))
