"""The plugin beside the plugins of pytest that people combine; each row runs in a process of its own.

No plugin is loaded but scanrack's and those of the row. A row whose plugin is missing skips; `.ci/run` has
all of them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest
from scanrack.traces import open_trace
from tested_racks import TWO, WITHOUT_PAGES, left, write_rack

pytestmark = pytest.mark.slow

pytest_plugins = ["pytester"]

OF_PYTEST_9 = find_spec("_pytest.subtests") is not None

PLUGINS: Mapping[str, tuple[str, str]] = {
    "xdist": ("xdist.plugin", "xdist"),
    "randomly": ("pytest_randomly", "randomly"),
    "cov": ("pytest_cov.plugin", "pytest_cov"),
    "timeout": ("pytest_timeout", "timeout"),
    "rerunfailures": ("pytest_rerunfailures", "rerunfailures"),
    "asyncio": ("pytest_asyncio.plugin", "asyncio"),
    "subtests": ("_pytest.subtests", "")
    if find_spec("_pytest.subtests")
    else ("pytest_subtests", "subtests"),
}
"""Module and name of each plugin; pytest 9 has subtests itself."""

KEPT_OF_TWO = ["test_line.py--test_lamp/line.mcap", "test_line.py--test_rounds/line.mcap"]

ATTEMPTS = """
from itertools import count
attempts = count(1)

def test_lamp(rack):
    line = rack("line.toml")
    attempt = next(attempts)
    line.run_for(f"{10 * attempt} ms")
    assert line["Lamp"] or attempt == LAST
"""
"""Fails at scan 4, 9 and so on, but passes in its last attempt."""

ENDLESS = """
def test_lamp(rack):
    line = rack("line.toml")
    while not line["Lamp"]:
        line.scan()
"""

AWAITED = """
import asyncio
import pytest

@pytest.mark.asyncio
async def test_lamp(rack):
    line = rack("line.toml")
    await asyncio.sleep(0)
    line.run_for("10 ms")
    assert line["Lamp"]
"""

PARTS = """
def test_lamp(rack, subtests):
    line = rack("line.toml")
    for number in range(3):
        with subtests.test(number=number):
            line.run_for("10 ms")
            assert not line["Lamp"] if number == 1 else line["Lamp"]
"""
"""Two of three subtests fail, after scans 4 and 14."""

PARTS_THAT_PASS = PARTS.replace("if number == 1", "if True")

LAMP = "test_line.py--test_lamp/line.mcap"
OFF = "Lamp is off: Main rung 0: XIC(Local:1:I.Data.0) is false"


def at_scan(scan: int, trace: str = LAMP) -> str:
    return f"  scanrack watch 'scanrack-artifacts/{trace}#scan={scan}'"


@dataclass(frozen=True)
class Row:
    """A run of tests with a plugin, or several.

    Attributes:
        scans: last scan of each recording that is left; -1 for one that ends wherever it was.
        said: lines of the report, in order.
        pages: how many failures have the line of a page.
    """

    plugins: tuple[str, ...]
    options: str
    tests: str
    outcomes: Mapping[str, int]
    scans: Mapping[str, int]
    said: tuple[str, ...]
    pages: int


OF_TWO = {KEPT_OF_TWO[0]: 14, KEPT_OF_TWO[1]: 54}
SAID_OF_TWO = {name: at_scan(scan, name) for name, scan in OF_TWO.items()}
ALL_OF_TWO = {"passed": 1, "failed": 2}

ROWS: Mapping[str, Row] = {
    "no other plugin": Row((), "", TWO, ALL_OF_TWO, OF_TWO, (), 2),
    "xdist": Row(("xdist",), "-n 2", TWO, ALL_OF_TWO, OF_TWO, (), 2),
    "randomly": Row(("randomly",), "--randomly-seed=7", TWO, ALL_OF_TWO, OF_TWO, (), 2),
    "randomly, another order": Row(("randomly",), "--randomly-seed=8", TWO, ALL_OF_TWO, OF_TWO, (), 2),
    "cov": Row(("cov",), "--cov=. --cov-report=", TWO, ALL_OF_TWO, OF_TWO, (), 2),
    "timeout": Row(
        ("timeout",),
        "--timeout=1",
        ENDLESS,
        {"failed": 1},
        {LAMP: -1},
        ("*Timeout (>1.0s)*",),
        1,
    ),
    "rerunfailures, the last fails": Row(
        ("rerunfailures",),
        "--reruns=2",
        ATTEMPTS.replace("LAST", "9"),
        {"failed": 1, "rerun": 2},
        {LAMP: 14},
        (OFF, "line: scan 14, 0.028 s", at_scan(14), "  (the page)"),
        1,
    ),
    "rerunfailures, the last passes": Row(
        ("rerunfailures",), "--reruns=2", ATTEMPTS.replace("LAST", "3"), {"passed": 1, "rerun": 2}, {}, (), 0
    ),
    "asyncio": Row(("asyncio",), "", AWAITED, {"failed": 1}, {LAMP: 4}, (OFF, at_scan(4), "  (the page)"), 1),
    "subtests": Row(
        ("subtests",),
        "",
        PARTS,
        {},
        {LAMP: 14},
        ("*test_lamp*number=0*", OFF, at_scan(4), "*test_lamp*number=2*", OFF, at_scan(14)),
        1,
    ),
    "subtests that pass": Row(("subtests",), "", PARTS_THAT_PASS, {"passed": 1}, {}, (), 0),
    "all at once": Row(
        tuple(PLUGINS),
        "-n 2 --randomly-seed=7 --cov=. --cov-report= --timeout=60 --reruns=1 --rung-coverage",
        ATTEMPTS.replace("LAST", "9") + AWAITED.replace("test_lamp", "test_later"),
        {"failed": 2, "rerun": 2},
        {LAMP: 9, "test_line.py--test_later/line.mcap": 4},
        (),
        2,
    ),
}


@pytest.mark.parametrize("name", ROWS)
def test_a_run_with_other_plugins_reports_and_keeps_the_same(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    row = ROWS[name]
    for each in row.plugins:
        pytest.importorskip(PLUGINS[each][0], reason=f"pytest-{each} is not installed")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    write_rack(pytester.path)
    pytester.makeconftest(WITHOUT_PAGES)
    pytester.makepyfile(test_line=row.tests)
    names = ["scanrack", *(PLUGINS[each][1] for each in row.plugins), "no:cacheprovider"]
    loaded = [word for name in names if name for word in ("-p", name)]
    result = pytester.runpytest_subprocess(*loaded, *row.options.split(), timeout=120)
    if row.outcomes:
        assert result.parseoutcomes() == row.outcomes
    somewhere = {each for each, scan in row.scans.items() if scan < 0}
    assert last_scans(pytester.path, somewhere) == row.scans
    result.stdout.fnmatch_lines([each.replace("[", "[[]") for each in row.said])
    assert result.outlines.count("  (the page)") == row.pages
    if row.tests == TWO:
        assert {each for each in result.outlines if "scanrack watch" in each} == {*SAID_OF_TWO.values()}


def last_scans(folder: Path, somewhere: set[str]) -> dict[str, int]:
    """Return the last scan of each recording that is left, or -1."""
    found = {}
    for name in left(folder):
        with open_trace(folder / "scanrack-artifacts" / name) as trace:
            last = max(each.scan for each in trace.scans())
            assert not trace.notes
        found[name] = -1 if name in somewhere else last
    return found


def test_coverage_of_python_logic_is_measured_beside_that_of_rungs(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pytest_cov.plugin", reason="pytest-cov is not installed")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    write_rack(pytester.path)
    (pytester.path / "logic.py").write_text(
        "def logic(scan):\n    if scan.number < 5:\n        return\n    scan.number\n", encoding="utf-8"
    )
    rack = (pytester.path / "line.toml").read_text(encoding="utf-8").replace("line.rung", "logic.py")
    (pytester.path / "python.toml").write_text(rack, encoding="utf-8")
    pytester.makepyfile(test_line="def test_it(rack):\n    rack('python.toml').scan(3)\n")
    words = ("-p", "scanrack", "-p", "pytest_cov", "--rung-coverage")
    result = pytester.runpytest_subprocess(*words, "--cov=.", "--cov-report=json")
    result.assert_outcomes(passed=1)
    covered = json.loads((pytester.path / "coverage.json").read_text(encoding="utf-8"))["files"]["logic.py"]
    assert (covered["executed_lines"], covered["missing_lines"]) == ([1, 2, 3], [4])
    assert (pytester.path / "rung-coverage.html").exists()
