"""What a user's CI gets: the steps of the GitHub action, notes of a release, versions that are tried."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
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
        encoding="utf-8",
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
    (tmp_path / "idle.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "idle.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "test_idle.py").write_text(TEST, encoding="utf-8")
    return tmp_path


@pytest.mark.long
@pytest.mark.slow
def test_the_steps_of_the_action_run_and_a_find_of_the_search_fails_them(project):
    steps = steps_of_action()
    assert list(steps) == ["install", "start", "check", "test", "fuzz", "pages"]
    never = "from scanrack import never\n\n@never\ndef running(now):\n    return now.mode == 'run'\n"
    (project / "must_hold.py").write_text(never, encoding="utf-8")
    inputs = {"RACK": "idle.toml", "TESTS": "test_idle.py", "INVARIANTS": "must_hold.py"}
    inputs |= {"BUDGET": "0.1 s", "ARTIFACTS": "left", "RUNNER_TEMP": str(temporary(project))}
    for name, status in (("start", 0), ("check", 0), ("test", 0), ("fuzz", 1)):
        done = run_step(steps[name], project, **inputs)
        assert done.returncode == status, f"{name}: {done.stdout}{done.stderr}"
    traces = list((project / "left" / "fuzz").rglob("*.mcap"))
    assert traces
    ran = project / "ran"
    record_other_python(project, f"open({str(ran)!r}, 'w').close()")
    assert ran.exists()
    ran.unlink()
    done = run_step(steps["pages"], project, **inputs)
    assert done.returncode == 0, done.stderr
    assert [each.with_suffix(".html").is_file() for each in traces] == [True] * len(traces)
    assert not ran.exists()
    assert run_step(steps["pages"], project, **inputs | {"ARTIFACTS": "none"}).returncode == 0


def temporary(project: Path) -> Path:
    """Return the folder that GitHub gives the steps of a job."""
    folder = project.parent / f"{project.name}-temporary"
    folder.mkdir()
    return folder


def record_other_python(project: Path, line: str) -> None:
    """Put a recording of a program that the project does not have, by a line, among the artifacts."""
    folder = project / "elsewhere"
    folder.mkdir()
    (folder / "idle.toml").write_text(RACK, encoding="utf-8")
    (folder / "idle.py").write_text(f"{PROGRAM}\n\n{line}\n", encoding="utf-8")
    trace = project / "left" / "foreign.mcap"
    run_step(f"scanrack run idle.toml --record '{trace}' -q", folder).check_returncode()


ECHO = '#!/bin/sh\necho "in $PWD"\nprintf \'with %s\\n\' "$@"\n'


def echoing(project: Path, program: str) -> str:
    """Return a PATH whose first folder has a program that says where and with what it is called."""
    folder = project / "echoing"
    folder.mkdir()
    (folder / program).write_text(ECHO, encoding="utf-8")
    (folder / program).chmod(0o755)
    return f"{folder}{os.pathsep}{os.environ['PATH']}"


def test_what_pytest_gets_is_neither_expanded_nor_run(project):
    (project / "a b").mkdir()
    done = run_step(
        steps_of_action()["test"],
        project,
        PATH=echoing(project, "python"),
        TESTS="test_*.py\n 'a b' -k \"one and two\" $HOME `touch ran`; $(touch ran)",
        ARTIFACTS="left here",
    )
    assert done.returncode == 0, done.stderr
    given = [line.removeprefix("with ") for line in done.stdout.splitlines()[1:]]
    assert given[:4] == ["-m", "pytest", "--scanrack-artifacts", "left here"]
    assert given[4:8] == ["test_*.py", "a b", "-k", "one and two"]
    assert given[8:] == ["$HOME", "`touch", "ran`;", "$(touch", "ran)"]
    assert not (project / "ran").exists()


def test_only_recordings_of_this_run_get_a_page_and_none_is_trusted(project):
    path = echoing(project, "scanrack")
    left, line = project / "left over", project / "line"
    for folder in (left, line):
        folder.mkdir()
    old, new, done_already = left / "old.mcap", left / "new one.mcap", left / "failed.mcap"
    old.write_bytes(b"")
    in_a_day = time.time() + 86_400
    os.utime(old, (in_a_day, in_a_day))
    inputs = {"RACK": "line/idle.toml", "ARTIFACTS": "left over", "PATH": path}
    inputs["RUNNER_TEMP"] = str(temporary(project))
    assert run_step(steps_of_action()["start"], project, **inputs).returncode == 0
    for each in (new, done_already, done_already.with_suffix(".html")):
        each.write_bytes(b"")
        os.utime(each, (in_a_day, in_a_day))
    done = run_step(steps_of_action()["pages"], project, **inputs)
    assert done.stdout.splitlines() == [f"in {line}", "with share", f"with {new}"], done.stderr


@pytest.mark.parametrize("version", ["0.1.0", "v0.1.0"])
def test_release_notes_are_the_page_of_the_version(version):
    done = subprocess.run(
        [sys.executable, NOTES, version], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    assert done.stdout.strip() in (ROOT / "docs/changes/0.1.0.md").read_text(encoding="utf-8")
    assert done.stdout.startswith("- `scanrack run RACK` runs logic in Python")


def test_a_version_without_notes_is_told():
    done = subprocess.run(
        [sys.executable, NOTES, "9.9.9"], capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert done.returncode == 1
    assert done.stderr.startswith("docs/changes has no version 9.9.9, only 0.2.0, 0.1.0")


def test_lowest_versions_run_the_slow_files_that_say_so():
    claims = sorted(
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "tests" / "unit").rglob("test_*.py")
        if "`.ci/lowest` runs this file" in path.read_text(encoding="utf-8").split("import", 1)[0]
    )
    assert "tests/unit/prove/test_versions.py" in claims
    assert f"pytest -q -m slow {' '.join(claims)}\n" in (ROOT / ".ci" / "lowest").read_text("utf-8")
