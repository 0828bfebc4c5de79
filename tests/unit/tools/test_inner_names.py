"""A private module moves with few changes: tests import from doors of rooms."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[3]
MOST_TEST_FILES = 10
"""Test files that may name one inner module: a move changes no more."""

_INNER = re.compile(r"\bscanrack(?:\.\w+){3,}")


def test_no_inner_module_is_named_by_more_than_ten_test_files() -> None:
    """Names that many tests use come from a door: `from scanrack.ladder import parse_program`."""
    users: dict[str, set[Path]] = defaultdict(set)
    for file in ROOT.glob("tests/**/*.py"):
        for name in set(_INNER.findall(file.read_text(encoding="utf-8"))):
            users[name].add(file)
    assert {name: len(files) for name, files in users.items() if len(files) > MOST_TEST_FILES} == {}
