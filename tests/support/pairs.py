"""Which tests of a product of parameters a quick run plays: all values of all but one of them meet.

    3 parameters, 352 tests     88 causes with motions, at 2 moments, with 2 scan periods
    in a quick run 176          each cause at each moment and with each period, each moment with each period

A test is played where the places of its values add up to a multiple of the shortest parameter's length:
whatever the other values are, one value of that parameter fits. Two parameters are played in full.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Sequence
from math import prod

import pytest

PARAMETERS = 3
"""A product of fewer is played in full."""


def left_out(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """Return the tests that a quick run leaves out."""
    tests = defaultdict[str, list[pytest.Item]](list)
    for item in items:
        if hasattr(item, "callspec"):
            tests[item.nodeid.partition("[")[0]].append(item)
    found: list[pytest.Item] = []
    for cases in tests.values():
        is_played = played([_values(item) for item in cases])
        found += [item for item, plays in zip(cases, is_played, strict=True) if not plays]
    return found


def _values(item: pytest.Item) -> list[Hashable]:
    """Return what stands for the value of each parameter of a test; names that are set together are one."""
    values = dict(item.callspec.params)  # type: ignore[attr-defined]  # of a test with parameters
    found: list[Hashable] = []
    for mark in item.iter_markers("parametrize"):
        names = mark.args[0]
        listed = [each.strip() for each in names.split(",")] if isinstance(names, str) else names
        found.append(tuple(id(values.pop(name)) for name in listed))
    return found + [id(each) for each in values.values()]  # of fixtures


def played(cases: Sequence[Sequence[Hashable]]) -> list[bool]:
    """Return of each test whether a quick run plays it, from its values.

    >>> played([(a, b, c) for a in "ab" for b in "cd" for c in "ef"])
    [True, False, False, True, False, True, True, False]
    """
    parameters = [list(dict.fromkeys(values)) for values in zip(*cases, strict=True)]
    lengths = [len(each) for each in parameters if len(each) > 1]
    if len(lengths) < PARAMETERS or prod(lengths) != len(cases):
        return [True] * len(cases)
    shortest = min(lengths)
    places = [sum(each.index(value) for each, value in zip(parameters, case, strict=True)) for case in cases]
    return [place % shortest == 0 for place in places]
