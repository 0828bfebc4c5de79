"""docs/adapters.md: its tables of refusals are the rows that refuse."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.runtime.modules.adapters.table import refusals

PAGE = Path(__file__).parents[2] / "docs" / "adapters.md"


@pytest.mark.parametrize("controller", ["PCL601", "PMC006"])
def test_the_page_has_the_table_of_refusals(controller):
    text = PAGE.read_text(encoding="utf-8")
    begin = f"<!-- refusals: {controller} -->\n"
    assert text.partition(begin)[2].partition("<!-- end -->")[0] == refusals(controller)
