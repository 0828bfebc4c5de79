"""`pytest --rung-coverage`: what a user's tests went through, alone and under pytest-xdist."""

from __future__ import annotations

import subprocess
import sys

import pytest
from scanrack import open_bench, pytest_plugin
from scanrack.jobs.bench.opening import OBSERVER
from scanrack.jobs.fuzz.explain.bench_coverage import BenchCoverage

RUNGS = """PROGRAM Line
TAG Lamp : BOOL
TAG Both : BOOL
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Lamp);
XIC(Local:1:I.Data.0)XIC(Local:1:I.Data.1)OTE(Both);
END
"""
PYTHON = """def logic(scan):
    if scan.slot[1].inputs[0] & 1:
        lit = 1
    else:
        lit = 0
"""
RACK = """program = "{}"
[[slot]]
number = 1
module = "1769-IQ16"
options = {{ inputs = {{ start = 0, more = 1 }} }}
"""
FIRST = """from scanrack import open_bench

def test_start():
    with open_bench("line.toml") as line:
        line.slot[1].press("start", "10 ms")
        line.scan(10)
"""
SECOND = """from scanrack import open_bench

def test_more():
    with open_bench("line.toml") as line:
        line.slot[1].press("more", "10 ms")
        line.scan(10)

def test_python():
    with open_bench("other.toml") as line:
        line.scan(3)
"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "line.rung").write_text(RUNGS, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK.format("line.rung"), encoding="utf-8")
    (tmp_path / "other.py").write_text(PYTHON, encoding="utf-8")
    (tmp_path / "other.toml").write_text(RACK.format("other.py"), encoding="utf-8")
    (tmp_path / "test_first.py").write_text(FIRST, encoding="utf-8")
    (tmp_path / "test_second.py").write_text(SECOND, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\n", encoding="utf-8")
    return tmp_path


@pytest.fixture
def gathered():
    coverage = BenchCoverage()
    before = OBSERVER.set(coverage)
    yield coverage
    OBSERVER.reset(before)


def gaps(coverage):
    """Return the lines with gaps, by the program's name."""
    return {
        name.rpartition("/")[2]: {each.place: each.never for each in lines if each.never}
        for name, lines in coverage.programs()
    }


def pressed(rack, *inputs):
    with open_bench(rack) as line:
        for energized in (True, False):
            for name in inputs:
                line.slot[1].set_input(name, energized)
            line.scan(5)


def test_what_no_bench_had_on_is_a_gap_and_two_benches_add_up(project, gathered):
    pressed(project / "line.toml", "start")
    more = ("XIC(Local:1:I.Data.1): never on", "OTE(Both): never on")
    assert gaps(gathered) == {"line.rung": {"Main rung 1": more}}
    pressed(project / "line.toml", "start", "more")
    assert gaps(gathered) == {"line.rung": {}}


def test_branches_of_a_program_in_python_that_no_bench_took(project, gathered):
    pressed(project / "other.toml")
    assert gaps(gathered) == {"other.py": {"other.py:3": ("never reached",)}}
    pressed(project / "other.toml", "start")
    assert gaps(gathered) == {"other.py": {}}


def test_rows_of_other_processes_are_merged(project, gathered):
    other = BenchCoverage()
    pressed(project / "line.toml", "start")
    pressed(project / "other.toml", "start")
    other.merge(gathered.row())
    assert gaps(other) == gaps(gathered)


def test_a_bench_that_nobody_observes_notes_nothing(project):
    coverage = BenchCoverage()
    pressed(project / "line.toml", "start")
    assert list(coverage.programs()) == []


@pytest.mark.slow
def test_the_option_writes_the_page_of_two_processes(project):
    pytest.importorskip("xdist", reason="pytest-xdist is not installed")
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rung-coverage", "-n", "2"]
    done = subprocess.run(words, cwd=project, capture_output=True, text=True, check=False, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "line.rung: 1 of 2 lines have gaps" in done.stdout
    page = (project / "rung-coverage.html").read_text(encoding="utf-8")
    assert "OTE(Both): never on" in page
    assert "other.py:3" in page


@pytest.mark.slow
def test_without_the_option_nothing_of_scanrack_is_imported(tmp_path):
    (tmp_path / "test_it.py").write_text(
        "import sys\n\ndef test_it():\n"
        "    assert not [name for name in sys.modules if name.startswith('scanrack.jobs')]\n",
        encoding="utf-8",
    )
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "/dev/null", "test_it.py"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr


def test_pytest_rewrites_no_assertions_of_scanrack_for_the_plugin(monkeypatch):
    class Finder:
        def __init__(self):
            self._must_rewrite = {"scanrack", "other_plugin"}  # what pytest's own finder has

        def find_spec(self, *_args):
            return None

    finder = Finder()
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, finder])
    pytest_plugin.pytest_addoption(pytest.Parser(_ispytest=True))
    assert finder._must_rewrite == {"other_plugin"}
