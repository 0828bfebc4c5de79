"""Parts of arrays and texts by OPC UA index ranges: `5`, `2:5`, `1:2,0:1` [OPC UA part 4, 7.27].

array of DINT[10]     "3"         the list of one element
                      "3:5"       three elements
array of INT[3,4]     "1:2,0:1"   two rows of two
STRING                "1:3"       the second to the fourth character
array of STRING[3]    "0:1"       two texts
                      "0:1,1:3"   the second to the fourth character of two texts
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import product
from typing import Any

_BOUNDS = re.compile(r"([0-9]{1,20})(?::([0-9]{1,20}))?")

DIMENSIONS_MOST = 32
"""Maximum number of dimensions of a range."""


class NoDataError(ValueError):
    """A well-formed range that contains no data."""


class MismatchError(ValueError):
    """A value whose size differs from the range to write."""


def parse_ranges(text: str) -> list[range]:
    """Return the indices in an index range, by dimension.

    >>> parse_ranges("1:2,0")
    [range(1, 3), range(0, 1)]

    Raises:
        ValueError: the text is not a range; `5:5` and `7:5` are not ranges either.
    """
    matches = [_BOUNDS.fullmatch(index_text) for index_text in text.split(",", DIMENSIONS_MOST)]
    if any(match is None or (match[2] and int(match[2]) <= int(match[1])) for match in matches):
        raise ValueError(f"{text[:50]!r} is not a range; use 5, 2:5 or 1:2,0:1")
    return [range(int(match[1]), int(match[2] or match[1]) + 1) for match in matches if match is not None]


def part_of(value: Any, ranges: Sequence[range], rank: int) -> Any:
    """Return part of a value; an upper bound beyond the value means the end of the value.

    >>> part_of([[1, 2, 3], [4, 5, 6]], parse_ranges("1,1:9"), 2)
    [[5, 6]]
    >>> part_of("scanrack", parse_ranges("0:3"), 0)
    'scan'

    Args:
        rank: number of dimensions; 0 = a single value.

    Raises:
        NoDataError: a lower bound is beyond the value, or the number of dimensions differs.
    """
    if rank == 0 and len(ranges) == 1 and isinstance(value, str | bytes):
        if ranges[0].start >= len(value):
            raise NoDataError(f"it has {len(value)} characters")
        return value[ranges[0].start : ranges[0].stop]
    characters = None
    if len(ranges) == rank + 1 and rank:  # the last range selects characters of texts
        ranges, characters = ranges[:-1], ranges[-1]
    if not rank or len(ranges) != rank:
        raise NoDataError(f"it has {rank} dimensions")
    return _elements(value, ranges, characters)


def _elements(values: Any, ranges: Sequence[range], characters: range | None) -> list[Any]:
    """Return the elements in ranges of nested lists, or characters of them; refuse an empty result."""
    first_range, *inner_ranges = ranges
    elements = values[first_range.start : first_range.stop] if isinstance(values, list) else []
    if not elements:
        raise NoDataError(f"no element {first_range.start}")
    if inner_ranges:
        return [_elements(element, inner_ranges, characters) for element in elements]
    return elements if characters is None else [_characters(element, characters) for element in elements]


def _characters(text: Any, characters: range) -> Any:
    """Return characters of an element, or None if the element is too short."""
    if text is not None and not isinstance(text, str | bytes):
        raise NoDataError("it is not a text")
    return (text or "")[characters.start : characters.stop] or None


def shape_of(value: Any) -> list[int]:
    """Return the lengths of nested lists.

    >>> shape_of([[5, 6]]), shape_of(5)
    ([1, 2], [])
    """
    return [len(value), *shape_of(value[0] if value else None)] if isinstance(value, list) else []


def runs(ranges: Sequence[range], dims: Sequence[int]) -> list[range]:
    """Return the memory positions of the elements in ranges, as runs.

    >>> runs(parse_ranges("1:2,0:1"), (3, 4))
    [range(4, 6), range(8, 10)]

    Raises:
        NoDataError: the number of dimensions differs, or an element does not exist.
    """
    has_elements = all(bounds.stop <= size for bounds, size in zip(ranges, dims, strict=False))
    if len(ranges) != len(dims) or not has_elements:
        raise NoDataError(f"the array has {' x '.join(map(str, dims))} elements")
    if not dims:
        return [range(1)]
    *outer_ranges, last_range = ranges
    element_runs = []
    for indices in product(*outer_ranges):
        row = 0
        for index, size in zip(indices, dims, strict=False):
            row = row * size + index
        element_runs.append(range(row * dims[-1] + last_range.start, row * dims[-1] + last_range.stop))
    return element_runs
