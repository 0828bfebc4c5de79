"""The page about the PMC006: its tables are the project's, its examples run."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest
from scanrack.io_images.pmc006.page import instruction_table, option_table, user_table

DOCS = Path(__file__).parents[3] / "docs"


@pytest.mark.parametrize("table", [instruction_table, user_table, option_table])
def test_the_tables_are_those_that_the_code_goes_by(table: object) -> None:
    assert callable(table)
    assert table() in (DOCS / "pmc006.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", ["pmc006.md"])
def test_examples_of_the_page(page: str) -> None:
    results = doctest.testfile(str(DOCS / page), module_relative=False)
    assert results.attempted >= 4
    assert results.failed == 0
