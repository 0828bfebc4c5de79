"""What a user's CI gets: the steps of the GitHub action, and the notes of a release."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
NOTES = ROOT / ".ci" / "release-notes"


def steps_of_action() -> dict[str, str]:
    """Return the shell of each named step that has one."""
    text = (ROOT / "action.yml").read_text(encoding="utf-8")
    found = {}
    for step in re.split(r"^    - ", text, flags=re.MULTILINE)[1:]:
        name, shell = (
            re.match(r"name: (\w+)", step),
            re.search(r"^      run: (\|\n)?((?:.+\n?)+)", step, re.MULTILINE),
        )
        if name and shell:
            found[name[1]] = re.sub(r"^ {8}", "", shell[2], flags=re.MULTILINE)
    return found


def run_step(shell: str, folder: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """Run a step as GitHub's bash does, with scanrack and pytest of this environment."""
    here = Path(sys.executable).parent
    env = {**os.environ, "PATH": f"{here}{os.pathsep}{os.environ['PATH']}", **inputs}
    return subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", shell],
        cwd=folder,
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )


RACK = """
name = "idle"
program = "idle.py"
scan_ms = 2
run_for_s = 0.1

[[slot]]
number = 1
module = "amci3601"
"""
PROGRAM = '''"""Do nothing."""

from scanrack import Logic


class Idle(Logic):
    """Nothing."""
'''
TEST = """
def test_it_runs():
    assert sum((1, 1)) == 2
"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "idle.toml").write_text(RACK)
    (tmp_path / "idle.py").write_text(PROGRAM)
    (tmp_path / "test_idle.py").write_text(TEST)
    return tmp_path


@pytest.mark.slow
def test_the_steps_of_the_action_run_and_a_find_of_the_search_fails_them(project):
    steps = steps_of_action()
    assert list(steps) == ["install", "check", "test", "fuzz", "pages"]
    never = "from scanrack import never\n\n@never\ndef running(now):\n    return now.mode == 'run'\n"
    (project / "must_hold.py").write_text(never)
    inputs = {"RACK": "idle.toml", "TESTS": "test_idle.py", "INVARIANTS": "must_hold.py"}
    for name, status in (("check", 0), ("test", 0), ("fuzz", 1)):
        done = run_step(steps[name], project, **inputs, BUDGET="0.1 s", ARTEFACTS="left")
        assert done.returncode == status, f"{name}: {done.stdout}{done.stderr}"
    traces = list((project / "left" / "fuzz").rglob("*.mcap"))
    assert traces
    done = run_step(steps["pages"], project, ARTEFACTS="left")
    assert done.returncode == 0, done.stderr
    assert [each.with_suffix(".html").is_file() for each in traces] == [True] * len(traces)
    assert run_step(steps["pages"], project, ARTEFACTS="none").returncode == 0


@pytest.mark.parametrize("version", ["0.1.0", "v0.1.0"])
def test_release_notes_are_the_section_of_the_version(version):
    done = subprocess.run([sys.executable, NOTES, version], capture_output=True, text=True, check=True)
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert done.stdout.strip() in changelog
    assert done.stdout.startswith("- `scanrack run RACK` runs logic in Python")
    assert "\n## " not in done.stdout


def test_a_version_without_notes_is_told():
    done = subprocess.run([sys.executable, NOTES, "9.9.9"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("CHANGELOG.md has no version 9.9.9, only Unreleased, 0.2.0")
