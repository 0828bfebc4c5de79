"""Ranges of OPC UA as part 4, 7.27, has them: what is none, what is not there, which elements are meant."""

from __future__ import annotations

from typing import Any

import pytest
from scanrack.runtime.tag_servers.index_ranges import NoDataError, parse_ranges, part_of, runs

GRID = [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12]]
CUBE = [[[100 * a + 10 * b + c for c in range(4)] for b in range(3)] for a in range(2)]
TEXTS = ["TestString", "Test", "String"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "a",
        "-1",
        "+1",
        "1:",
        ":1",
        "5:5",
        "7:5",
        "1:2:3",
        "1, 2",
        "1,",
        ",1",
        "1,,2",
        "1.5",
        "0x1",
        "\u0661",
        "1;2",
    ],
)
def test_no_range(text: str) -> None:
    with pytest.raises(ValueError, match="is not a range; use 5, 2:5 or 1:2,0:1"):
        parse_ranges(text)


@pytest.mark.parametrize(
    ("value", "rank", "text", "part"),
    [
        ([7, 8, 9], 1, "0", [7]),
        ([7, 8, 9], 1, "1:2", [8, 9]),
        ([7, 8, 9], 1, "1:9", [8, 9]),  # an upper bound that is not there
        (GRID, 2, "1:2,0:1", [[5, 6], [9, 10]]),
        (GRID, 2, "1,2", [[7]]),
        (GRID, 2, "0:9,3:9", [[4], [8], [12]]),
        (CUBE, 3, "1,0:1,2:3", [[[102, 103], [112, 113]]]),
        ("scanrack", 0, "4:7", "rack"),
        ("scanrack", 0, "0", "s"),
        ("scanrack", 0, "4:99", "rack"),
        (TEXTS, 1, "1:2", ["Test", "String"]),
        (TEXTS, 1, "0:2,7:9", ["ing", None, None]),  # the specification's own example
        (b"\1\2\3", 0, "1:2", b"\2\3"),
    ],
)
def test_parts(value: Any, rank: int, text: str, part: Any) -> None:
    assert part_of(value, parse_ranges(text), rank) == part


@pytest.mark.parametrize(
    ("value", "rank", "text"),
    [
        ([7, 8, 9], 1, "3"),
        ([7, 8, 9], 1, "3:4"),
        ([7, 8, 9], 1, "0,0"),  # all dimensions shall be there, and no more
        ([], 1, "0"),
        (GRID, 2, "0"),
        (GRID, 2, "3,0"),
        (GRID, 2, "0,4"),
        (GRID, 2, "0,0,0"),
        (5, 0, "0"),
        (None, 0, "0"),
        ("abc", 0, "3"),
        ("", 0, "0"),
        ("abc", 0, "0,0"),
    ],
)
def test_what_is_not_there(value: Any, rank: int, text: str) -> None:
    with pytest.raises(NoDataError):
        part_of(value, parse_ranges(text), rank)


@pytest.mark.parametrize(
    ("text", "dims", "places"),
    [
        ("5", (10,), [[5]]),
        ("5:7", (10,), [[5, 6, 7]]),
        ("1:2,0:1", (3, 4), [[4, 5], [8, 9]]),
        ("1,0:1,2:3", (2, 3, 4), [[14, 15], [18, 19]]),
    ],
)
def test_elements_in_the_order_of_memory(text: str, dims: tuple[int, ...], places: list[list[int]]) -> None:
    assert [list(each) for each in runs(parse_ranges(text), dims)] == places


@pytest.mark.parametrize(
    ("text", "dims"), [("10", (10,)), ("9:10", (10,)), ("0", (3, 4)), ("0,0", (10,)), ("0", ())]
)
def test_a_write_needs_all_of_a_range(text: str, dims: tuple[int, ...]) -> None:
    with pytest.raises(NoDataError):
        runs(parse_ranges(text), dims)
