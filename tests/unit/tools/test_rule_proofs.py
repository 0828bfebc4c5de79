"""`tests/tools/rule_proofs.py`, for the page of rules: it finds the marks, and reports what they lack.

Marks are collected in a process of its own, as pytest does not run within pytest.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import rule_proofs
from rule_proofs import mistakes
from scanrack.io_images.amci3601 import RULES

SUITE = """\
import pytest

CASES = [pytest.param(1, marks=pytest.mark.rules("CMD-02")), pytest.param(2, marks=pytest.mark.rules("X-1"))]
BOTH = pytest.mark.rules("CMD-01", "CMD-02")

@pytest.mark.parametrize("case", CASES)
def test_cases(case): ...

@BOTH
def test_b(): ...

@BOTH
class TestGroup:
    def test_in_it(self): ...

def test_without(): ...
"""


def collected(path: Path) -> subprocess.CompletedProcess[str]:
    script = (
        "import sys, json, pathlib, rule_proofs; json.dump(rule_proofs.collect("
        "pathlib.Path(sys.argv[1])), sys.stdout)"
    )
    tools = str(Path(rule_proofs.__file__).parent)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([tools, *sys.path]), "PYTEST_ADDOPTS": ""}
    return subprocess.run(
        [sys.executable, "-c", script, path],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
        encoding="utf-8",
    )


@pytest.mark.slow
def test_marks_of_functions_classes_and_parameters_are_collected(tmp_path: Path) -> None:
    file = tmp_path / "test_suite.py"
    file.write_text(SUITE, encoding="utf-8")
    done = collected(file)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "CMD-01": ["test_suite.py::TestGroup::test_in_it", "test_suite.py::test_b"],
        "CMD-02": [
            "test_suite.py::TestGroup::test_in_it",
            "test_suite.py::test_b",
            "test_suite.py::test_cases",
        ],
        "X-1": ["test_suite.py::test_cases"],
    }


@pytest.mark.slow
def test_a_file_that_cannot_be_collected_is_named(tmp_path: Path) -> None:
    file = tmp_path / "test_broken.py"
    file.write_text("import nothing_of_that_name\n", encoding="utf-8")
    done = collected(file)
    assert done.returncode != 0
    assert "test_broken.py" in done.stderr
    assert "nothing_of_that_name" in done.stderr


PROVED = {rule.id: ["test_a.py::test_x"] for rule in RULES.values() if rule.testable}


def test_a_mark_that_names_no_rule_is_reported() -> None:
    assert list(mistakes(PROVED)) == []
    assert list(mistakes(PROVED | {"X-1": ["test_b.py::test_y"]})) == [
        "test_b.py::test_y names X-1: no such rule"
    ]


def test_a_rule_without_a_test_is_reported_unless_no_image_can_show_it() -> None:
    some = {rule_id: tests for rule_id, tests in PROVED.items() if rule_id != "CMD-03"}
    assert list(mistakes(some)) == ["CMD-03 has no test"]
    assert not RULES["IOM-05"].testable
