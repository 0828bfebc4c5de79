"""docs/adapter-tables.md: its tables of refusals are the rows that refuse."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.runtime.modules.registry import MODULES

PAGE = Path(__file__).parents[3] / "docs" / "adapter-tables.md"


TABLES = {name: record.capabilities for name, record in MODULES.items() if record.capabilities is not None}


@pytest.mark.parametrize("module", TABLES)
def test_the_page_has_the_table_of_refusals(module):
    text = PAGE.read_text(encoding="utf-8")
    begin = f"<!-- refusals: {module} -->\n"
    assert text.partition(begin)[2].partition("<!-- end -->")[0] == TABLES[module]()
