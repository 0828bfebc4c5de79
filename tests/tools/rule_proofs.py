"""Check that every rule has a test that names it, and that the page of rules is current.

The tests name their rules with the mark `rules`; this script collects the marks of all tests. It leaves out
the tests against other people's software, which are not collected where that software is missing.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path

import pytest
from rules_page import page
from scanrack.io_images.amci3601 import RULES

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "rules-amci3601.md"
REMEDY = "python -m tests.tools.generate rules"

Found = dict[str, list[str]]
"""The tests of every rule that a mark names, "file.py::test_name" each, sorted."""


class Marks:
    """A pytest plugin that notes the marks of all tests it collects."""

    def __init__(self) -> None:
        self.tests: dict[str, set[str]] = {}
        self.errors: list[str] = []

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            test = "::".join([item.path.name, *item.nodeid.split("[")[0].split("::")[1:]])
            for mark in item.iter_markers("rules"):
                for rule_id in mark.args:
                    self.tests.setdefault(rule_id, set()).add(test)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.errors.append(f"{report.nodeid}: {report.longreprtext}")


def collect(*paths: Path) -> Found:
    """Return the tests of every rule that a mark names.

    Raises:
        ValueError: a file can't be collected.
    """
    marks = Marks()
    arguments = ["--collect-only", "-q", "-p", "no:cacheprovider", f"--rootdir={ROOT}"]
    arguments += [f"-c={ROOT / 'pyproject.toml'}", f"--ignore={ROOT / 'tests' / 'peers'}"]
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        status = pytest.main([*arguments, *map(str, paths or [ROOT / "tests"])], plugins=[marks])
    if marks.errors or status != pytest.ExitCode.OK:
        raise ValueError("\n".join(marks.errors) or said.getvalue())
    return {rule_id: sorted(tests) for rule_id, tests in sorted(marks.tests.items())}


def mistakes(found: Found) -> Iterator[str]:
    """Yield the marks that name no rule, and the rules that no mark names though an image can show them."""
    for rule_id, tests in found.items():
        if rule_id not in RULES:
            yield from (f"{test} names {rule_id}: no such rule" for test in tests)
    for rule in RULES.values():
        if rule.testable and rule.id not in found:
            yield f"{rule.id} has no test"


def page_of(found: Found) -> str:
    """Return the page as it should be."""
    return page(tuple(RULES.values()), lambda rule_id: found.get(rule_id, ()))
