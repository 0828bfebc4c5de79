"""Check that every rule has a test that names it, and that the page of rules is current.

    python tests/tools/rule_proofs.py            report what is wrong (exit status 1)
    python tests/tools/rule_proofs.py --write    also write docs/rules-amci3601.md

The tests name their rules with the mark `rules`; this script collects the marks of all tests. It leaves out
the tests against other people's software, which are not collected where that software is missing.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from rules_page import page
from scanrack.io_images.amci3601 import RULES

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "rules-amci3601.md"
REMEDY = "python tests/tools/rule_proofs.py --write"

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
            yield from (f"{test} names {rule_id}: there is no such rule" for test in tests)
    for rule in RULES.values():
        if rule.testable and rule.id not in found:
            yield f"{rule.id} has no test"


def page_of(found: Found) -> str:
    """Return the page as it should be."""
    return page(tuple(RULES.values()), lambda rule_id: found.get(rule_id, ()))


def main(arguments: list[str]) -> int:
    """Report what is wrong, and write the page if asked; return the exit status."""
    parser = argparse.ArgumentParser(description="Check that every rule has a test, and the page of rules.")
    parser.add_argument("--write", action="store_true", help="write the page")
    write = parser.parse_args(arguments).write
    found = collect()
    wrong = list(mistakes(found))
    text = page_of(found)
    if write:
        PAGE.write_text(text, encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != text:
        wrong.append(f"{PAGE.relative_to(ROOT)} is stale: run {REMEDY}")
    sys.stderr.writelines(f"{line}\n" for line in wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
