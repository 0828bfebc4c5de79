"""Every rule is proved by a test that names it, and what is written about that is up to date.

The marks are collected in a process of its own: what pytest finds there does not depend on which tests
are being run here.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from collect_proofs import PAGE, PROOFS, contents, unknown, written
from scanrack.io_images.amci3601 import RULES

COLLECT = Path(__file__).parents[1] / "support" / "collect_proofs.py"
REMEDY = "python tests/support/collect_proofs.py --write"


@pytest.fixture(scope="module")
def found():
    """The tests of every rule that a mark names."""
    environment = {**os.environ, "PYTEST_ADDOPTS": "", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": ""}
    done = subprocess.run(
        [sys.executable, COLLECT, "--json"], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["rules"]


def test_marks_name_rules_that_exist(found):
    assert unknown(found) == []


@pytest.mark.parametrize("path", [PROOFS, PAGE], ids=lambda path: path.name)
def test_what_is_written_is_up_to_date(found, path):
    assert path.read_text(encoding="utf-8") == contents(found)[path], f"{path.name} is stale: run {REMEDY}"


def test_every_rule_is_proved_or_not_testable(found):
    bare = [rule.id for rule in RULES.values() if rule.testable and rule.id not in found]
    assert not bare, f"{len(bare)} rules without a test: {' '.join(bare)}"


# -- the collector itself


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


def collected(path):
    script = (
        "import sys, json, pathlib, collect_proofs; json.dump(collect_proofs.collect("
        "pathlib.Path(sys.argv[1])), sys.stdout)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(COLLECT.parent), *sys.path])}
    return subprocess.run(
        [sys.executable, "-c", script, path], capture_output=True, text=True, env=environment, check=False
    )


def test_marks_of_functions_classes_and_parameters_are_collected(tmp_path):
    file = tmp_path / "test_suite.py"
    file.write_text(SUITE, encoding="utf-8")
    done = collected(file)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found == {
        "CMD-01": ["test_suite.py::TestGroup::test_in_it", "test_suite.py::test_b"],
        "CMD-02": [
            "test_suite.py::TestGroup::test_in_it",
            "test_suite.py::test_b",
            "test_suite.py::test_cases",
        ],
        "X-1": ["test_suite.py::test_cases"],
    }
    assert unknown(found) == ["test_suite.py::test_cases names X-1"]


def test_a_file_that_cannot_be_collected_is_named(tmp_path):
    file = tmp_path / "test_broken.py"
    file.write_text("import nothing_of_that_name\n", encoding="utf-8")
    done = collected(file)
    assert done.returncode != 0
    assert "test_broken.py" in done.stderr
    assert "nothing_of_that_name" in done.stderr


def test_the_written_file_has_the_rules_in_the_tables_order_and_reads_back():
    names = [f"test_{'long' * 20}.py::test_x"]
    space: dict[str, object] = {}
    exec(written({"CMD-03": ["a.py::t", "b.py::t"], "IOM-03": names}), space)  # it is Python
    assert list(space["PROOFS"].items()) == [("IOM-03", tuple(names)), ("CMD-03", ("a.py::t", "b.py::t"))]
    assert space["proofs"]("CMD-01") == ()
