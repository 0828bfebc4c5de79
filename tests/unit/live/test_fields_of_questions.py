"""Fields that several questions of a page have."""

import pytest
from scanrack.watch.monitors.fields import columns_in


def test_rungs_are_drawn_in_88_columns_unless_a_page_says_more():
    assert [columns_in(asked) for asked in ({}, {"columns": 40}, {"columns": 160})] == [88, 40, 160]


@pytest.mark.parametrize("columns", [39, 161, 88.0, "88", None, True])
def test_a_refusal_of_columns_names_the_value(columns):
    with pytest.raises(ValueError, match=rf"^columns {columns!r}: must be 40 to 160$"):
        columns_in({"columns": columns})
