"""A private module moves with few changes: tests speak to doors of rooms, a script does the rest."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import pytest
from moved import ROOT, Move

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


BUILD = Move("scanrack.ladder.files", "scanrack.ladder.texts.forms")


@pytest.mark.parametrize(
    ("path", "before", "after"),
    [
        ("ladder/__init__.py", "from .files.rungfile import (\n", "from .texts.forms.rungfile import (\n"),
        ("ladder/debug/causes.py", "    from ..files import a\n", "    from ..texts.forms import a\n"),
        ("ladder/files/rungfile.py", "from ..model.tree import Rung\n", "from ...model.tree import Rung\n"),
        ("ladder/files/rungfile.py", "from .steps import Steps\n", "from .steps import Steps\n"),
        (
            "scanrack/jobs/run/a.py",
            "from scanrack.ladder.files.a import b\n",
            "from scanrack.ladder.texts.forms.a import b\n",
        ),
        ("ladder/a.py", "from . import files\n", "from .texts import forms as files\n"),
        (
            "tests/a.py",
            "from scanrack.ladder.files.a import b\n",
            "from scanrack.ladder.texts.forms.a import b\n",
        ),
        ("tests/a.py", 'patch("scanrack.ladder.filesystem.a")\n', 'patch("scanrack.ladder.filesystem.a")\n'),
        ("CONTRIBUTING.md", "see ladder/files/steps.py\n", "see ladder/texts/forms/steps.py\n"),
    ],
)
def test_a_move_rewrites_imports_names_and_paths(path: str, before: str, after: str) -> None:
    text = before
    if before.endswith("(\n"):
        text, after = f"{before}    x,\n)\n", f"{after}    x,\n)\n"
    elif before.startswith("    "):
        text, after = f"if True:\n{before}", f"if True:\n{after}"
    assert BUILD.rewritten(text, Path(path)) == after
