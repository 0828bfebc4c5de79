"""A folder with a rack and tests of it, for the tests of the plugin of pytest."""

from __future__ import annotations

from pathlib import Path

RUNGS = """PROGRAM Line
TAG Lamp : BOOL
TAG Rounds : COUNTER
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Lamp);
XIC(Lamp)CTU(Rounds,2,0);
END
"""
RACK = """program = "line.rung"
[[slot]]
number = 1
module = "1769-IQ16"
options = { inputs = { start = 0 } }
"""

TWO = """
import pytest

def test_dark(rack):
    line = rack("line.toml")
    line.slot[1].press("start", "10 ms")
    line.run_for("20 ms")

def test_rounds(rack):
    line = rack("line.toml")
    line.slot[1].press("start", "10 ms")
    line.run_until("Rounds.DN", within="100 ms")

@pytest.mark.rack("line.toml")
def test_lamp(bench):
    bench.slot[1].press("start", "10 ms")
    bench.run_for("20 ms")
    assert bench["Lamp"], "the lamp stays on"
"""
"""A test that passes, and two that fail in scans 54 and 14."""

WITHOUT_PAGES = """
from scanrack.testing import artifacts

artifacts.page_line = lambda *given: "(the page)"
"""
"""A conftest: a page costs a second."""


def write_rack(folder: Path) -> None:
    (folder / "line.rung").write_text(RUNGS, encoding="utf-8")
    (folder / "line.toml").write_text(RACK, encoding="utf-8")


def left(folder: Path) -> list[str]:
    """Return the files that the tests of a folder have left."""
    base = folder / "scanrack-artifacts"
    names = (each.relative_to(base).as_posix() for each in base.rglob("*") if each.is_file())
    return sorted(name for name in names if not name.rpartition("/")[2].startswith("."))
