"""What a quick run leaves out of a product of parameters."""

from __future__ import annotations

from itertools import combinations, product
from types import SimpleNamespace
from typing import Any

import pytest
from pairs import left_out, played

LENGTHS = [(9, 2, 2), (2, 3, 4), (5, 3, 3), (2, 2, 2, 2), (4, 1, 3, 2)]


@pytest.mark.parametrize("lengths", LENGTHS, ids=str)
def test_all_values_of_all_but_one_parameter_meet(lengths):
    cases = list(product(*map(range, lengths)))
    chosen = [case for case, plays in zip(cases, played(cases), strict=True) if plays]
    assert len(chosen) <= len(cases) / 2 + 1
    for some in combinations(range(len(lengths)), len(lengths) - 1):
        if len([each for each in some if lengths[each] > 1]) < len([each for each in lengths if each > 1]):
            seen = {tuple(case[each] for each in some) for case in chosen}
            assert seen == set(product(*(range(lengths[each]) for each in some))), some


@pytest.mark.parametrize(
    "cases", [list(product("ab", "cd")), [*product("ab", "cd", "ef")][1:], [("a", "c", "e")]], ids=len
)
def test_what_is_no_product_of_three_parameters_is_played_in_full(cases):
    assert played(cases) == [True] * len(cases)


def test_names_that_are_set_together_are_one_parameter():
    """As pytest gives them: the names and the value of `name, value` in one mark, a fixture's in none."""
    marks = [SimpleNamespace(args=("name, value", [])), SimpleNamespace(args=(("moment",), []))]
    cases = product([("a", 1), ("b", 1), ("a", 2)], "cd", "ef")
    items: list[Any] = [
        SimpleNamespace(
            nodeid=f"test_x[{number}]",
            callspec=SimpleNamespace(params={"name": a, "value": b, "moment": moment, "fixture": kind}),
            iter_markers=lambda _name: iter(marks),
        )
        for number, ((a, b), moment, kind) in enumerate(cases)
    ]
    out = left_out(items)
    assert len(out) == 6
    for one, other in zip(items[::2], items[1::2], strict=True):  # they differ in the fixture
        assert (one in out) != (other in out)
    items.append(SimpleNamespace(nodeid="test_y"))
    assert left_out(items) == out
