"""The workflows: which systems the tests run on, what they run first, and versions of what they use."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
WORKFLOWS = {
    each.name: each.read_text(encoding="utf-8") for each in (ROOT / ".github/workflows").glob("*.yml")
}
TESTS = WORKFLOWS["tests.yml"]


def _list(key: str) -> list[str]:
    (found,) = re.findall(rf"^ +{key}: \[(.*)\]$", TESTS, re.MULTILINE)
    return [each.strip('"') for each in found.split(", ")]


def test_the_tests_run_on_each_system_with_the_first_and_the_last_python_and_on_ubuntu_with_all() -> None:
    left_out = set(re.findall(r'- \{ system: (\S+), python: "(\S+)" \}', TESTS))
    cells = {(system, python) for system in _list("system") for python in _list("python")} - left_out
    classifiers = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    pythons = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', classifiers)
    assert cells == {
        *(("ubuntu-latest", python) for python in pythons),
        *(
            (system, python)
            for system in ("windows-latest", "macos-latest")
            for python in (pythons[0], pythons[-1])
        ),
    }


@pytest.mark.parametrize(
    ("system", "begin"), [("runner.os != 'Windows'", "python3 "), ("runner.os == 'Windows'", "py ")]
)
def test_they_begin_with_the_two_commands_of_the_readme(system: str, begin: str) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = re.findall(rf"^    ({begin}.*)$", readme, re.MULTILINE)
    assert len(commands) == 2  # install and run, install and test
    assert re.findall(rf"- if: {re.escape(system)}\n        run: (.*)", TESTS) == commands


@pytest.mark.parametrize("name", WORKFLOWS)
def test_what_a_workflow_uses_has_a_version(name: str) -> None:
    used = re.findall(r"uses: (\S+)", WORKFLOWS[name])
    assert used
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@v\d[\w.]*|\./", each) for each in used), used
    assert "index-url" not in WORKFLOWS[name]
