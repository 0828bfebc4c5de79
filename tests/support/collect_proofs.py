"""Which tests prove which rules: collects the `rules` marks of all tests, keeps the two files made of them.

    python tests/support/collect_proofs.py            compare, and report what differs (exit status 1)
    python tests/support/collect_proofs.py --write    rewrite the two files
    python tests/support/collect_proofs.py --json     the marks as JSON: {"rules": {id: [test, ...]}}

The files are `io_images/amci3601/rules/proofs.py` and `docs/rules-amci3601.md`. Tests against other people's
software are left out: they are not collected where that software is missing.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import sys
from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import RULES
from scanrack.runtime.cli.rules_page import page

ROOT = Path(__file__).parents[2]
PROOFS = ROOT / "io_images" / "amci3601" / "rules" / "proofs.py"
PAGE = ROOT / "docs" / "rules-amci3601.md"
WIDTH = 110

HEAD = '''\
"""Which tests prove which rule; written by tests/support/collect_proofs.py --write, never by hand."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType


def proofs(rule_id: str) -> tuple[str, ...]:
    """Return the tests that prove a rule, "file.py::test_name" each; none for a rule that no test names."""
    return PROOFS.get(rule_id, ())


PROOFS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
'''
TAIL = """\
    }
)
"""


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


def collect(*paths: Path) -> dict[str, list[str]]:
    """Return the tests of every rule that a mark names, sorted.

    Raises:
        ValueError: there is a file that can't be collected.
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


def unknown(found: dict[str, list[str]]) -> list[str]:
    """Return a line for every mark that names no rule."""
    return [f"{test} names {rule}" for rule in found if rule not in RULES for test in found[rule]]


def written(found: dict[str, list[str]]) -> str:
    """Return the source of proofs.py: rules in the table's order."""
    rows = [_row(rule_id, found[rule_id]) for rule_id in RULES if rule_id in found]
    return HEAD + "".join(rows) + TAIL


def _row(rule_id: str, tests: list[str]) -> str:
    line = f'        "{rule_id}": ("{tests[0]}",),\n'
    if len(tests) == 1 and len(line) <= WIDTH + 1:
        return line
    lines = "".join(f'            "{test}",\n' for test in tests)
    return f'        "{rule_id}": (\n{lines}        ),\n'


def contents(found: dict[str, list[str]]) -> dict[Path, str]:
    """Return both files as they should be."""
    text = page(tuple(RULES.values()), lambda rule_id: found.get(rule_id, ()))
    return {PROOFS: written(found), PAGE: text}


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Which tests prove which rules.")
    parser.add_argument("--write", action="store_true", help="rewrite the files")
    parser.add_argument("--json", action="store_true", help="print the marks instead")
    given = parser.parse_args(arguments)
    found = collect()
    wrong = unknown(found)
    if given.json:
        json.dump({"rules": found}, sys.stdout)
        return 0
    for line in wrong:
        sys.stderr.write(f"unknown rule: {line}\n")
    write = given.write and not wrong
    stale = [path for path, text in contents(found).items() if not _is(path, text)]
    for path in stale:
        if write:
            path.write_text(contents(found)[path], encoding="utf-8")
        sys.stderr.write(f"{'rewritten' if write else 'stale'}: {path.relative_to(ROOT)}\n")
    return 1 if wrong or (stale and not write) else 0


def _is(path: Path, text: str) -> bool:
    return path.exists() and path.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
