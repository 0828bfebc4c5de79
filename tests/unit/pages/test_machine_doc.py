"""The page about machines says what happens: its examples are run."""

from __future__ import annotations

import doctest
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "machine.md"


def test_examples_of_the_page() -> None:
    # A blank line ends an example's output before the closing fence would count as part of it.
    results = doctest.testfile(str(PAGE), module_relative=False)
    assert results.attempted >= 10
    assert results.failed == 0
