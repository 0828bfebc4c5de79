"""Tests run in forked processes: each once, its report printed, its folders its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system can't fork")

SUPPORT = Path(__file__).parents[2] / "support"
CONFTEST = f"""
import os, sys
import pytest
sys.path.insert(0, {str(SUPPORT)!r})
from processes import Processes

def pytest_configure(config):
    config.pluginmanager.register(Processes(2, lambda item: item.path, os.getpid, pids.append))

pids = []

def pytest_sessionfinish():
    print("processes", len({{*pids, os.getpid()}}))

@pytest.fixture(scope="session", autouse=True)
def session_of_a_process(tmp_path_factory):
    place = tmp_path_factory.mktemp("session", numbered=False)
    yield
    (place / "ended").touch()
"""
TESTS = """
import os

def test_good(tmp_path):
    print("good")

def test_bad():
    print("printed by a process")
    assert 1 == 2

def test_last():
    if "CRASHES" in os.environ:
        os._exit(3)
"""


def run(folder: Path, *options: str, **environment: str) -> str:
    (folder / "conftest.py").write_text(CONFTEST, encoding="utf-8")
    for name in ("test_one.py", "test_two.py", "test_three.py"):
        (folder / name).write_text(TESTS, encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-p", "no:hypothesispytest", "--basetemp=made", *options]
    return subprocess.run(
        words, cwd=folder, env=os.environ | environment, capture_output=True, text=True, encoding="utf-8"
    ).stdout


@pytest.mark.slow
def test_every_test_runs_once_in_one_of_the_processes(tmp_path: Path) -> None:
    said = run(tmp_path)
    assert "3 failed, 6 passed" in said
    assert said.count("printed by a process") == 2 * 3  # the source line, and what it printed
    assert "processes 3" in said
    assert len(list(tmp_path.glob("made/process*/session/ended"))) == 2


@pytest.mark.slow
def test_the_first_failure_ends_all_if_asked(tmp_path: Path) -> None:
    assert "stopping after 1 failures" in run(tmp_path, "--exitfirst")


@pytest.mark.slow
def test_a_process_that_ends_is_a_failure_with_the_name_of_its_test(tmp_path: Path) -> None:
    assert ".py::test_last !!!" in run(tmp_path, CRASHES="1")
