"""Aligns two sequences in nearly linear time.

1. Elements of the common beginning and of the common end are paired. 2. Keys that both sequences contain once
are anchors. The longest chain of anchors that ascends in both
   sequences is kept, and the stretches between them are aligned in the same way.
3. A short stretch without an anchor is aligned by `difflib`. A long stretch is aligned by occurrence: the
   first occurrence of a key with the first one, and so on.

Thousands of equal rungs have no anchor, and `difflib` would compare every pair of them.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterator, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

SMALL = 1_024
"""Maximum product of two stretches' lengths up to which `difflib` aligns them."""

DEEPEST = 40
"""Maximum depth of the search for anchors between anchors."""

Pair = tuple[int, int]
"""Indexes of an element in the old and in the new sequence."""


class _Stretch(NamedTuple):
    """The part of each sequence between two anchors; ends are exclusive."""

    old_begin: int
    old_end: int
    new_begin: int
    new_end: int


def aligned(old: Sequence[Hashable], new: Sequence[Hashable]) -> list[Pair]:
    """Return ascending pairs of indexes of equal keys.

    >>> aligned("abcd", "axcbd")
    [(0, 0), (2, 2), (3, 4)]
    """
    return sorted(_pairs(old, new))


def _pairs(old: Sequence[Hashable], new: Sequence[Hashable]) -> Iterator[Pair]:
    """Yield pairs in no particular order: equal beginnings and ends, anchors, and pairs between them."""
    todo = [(_Stretch(0, len(old), 0, len(new)), 0)]
    while todo:
        (i, old_end, k, new_end), depth = todo.pop()
        while i < old_end and k < new_end and old[i] == new[k]:
            yield i, k
            i, k = i + 1, k + 1
        while i < old_end and k < new_end and old[old_end - 1] == new[new_end - 1]:
            old_end, new_end = old_end - 1, new_end - 1
            yield old_end, new_end
        if i == old_end or k == new_end:
            continue
        stretch = _Stretch(i, old_end, k, new_end)
        anchors = _anchors(old, new, stretch) if depth < DEEPEST else []
        if not anchors:
            yield from _pairs_without_anchor(old, new, stretch)
            continue
        yield from anchors
        for next_i, next_k in [*anchors, (old_end, new_end)]:
            todo.append((_Stretch(i, next_i, k, next_k), depth + 1))
            i, k = next_i + 1, next_k + 1


def _anchors(old: Sequence[Hashable], new: Sequence[Hashable], stretch: _Stretch) -> list[Pair]:
    """Return ascending pairs of keys that occur only once in both parts of a stretch."""
    old_indexes = _unique(old, stretch.old_begin, stretch.old_end)
    new_indexes = _unique(new, stretch.new_begin, stretch.new_end)
    return longest_chain([(i, new_indexes[key]) for key, i in old_indexes.items() if key in new_indexes])


def _unique(keys: Sequence[Hashable], begin: int, end: int) -> dict[Hashable, int]:
    """Return the indexes of the keys that occur once in a stretch, in order."""
    counts = Counter(keys[begin:end])
    return {keys[index]: index for index in range(begin, end) if counts[keys[index]] == 1}


def _pairs_without_anchor(
    old: Sequence[Hashable], new: Sequence[Hashable], stretch: _Stretch
) -> Iterator[Pair]:
    """Yield ascending pairs: for a short stretch by `difflib`, else equal keys by occurrence."""
    old_begin, old_end, new_begin, new_end = stretch
    if (old_end - old_begin) * (new_end - new_begin) <= SMALL:
        matcher = SequenceMatcher(None, old[old_begin:old_end], new[new_begin:new_end], autojunk=False)
        for block in matcher.get_matching_blocks():
            for offset in range(block.size):
                yield old_begin + block.a + offset, new_begin + block.b + offset
        return
    occurrences: defaultdict[Hashable, list[int]] = defaultdict(list)  # indexes in `new`, the last one first
    for k in range(new_end - 1, new_begin - 1, -1):
        occurrences[new[k]].append(k)
    yield from longest_chain(
        [(i, occurrences[old[i]].pop()) for i in range(old_begin, old_end) if occurrences.get(old[i])]
    )


def longest_chain(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the longest subsequence of pairs that ascends in both indexes; `pairs` ascend in the first.

    >>> longest_chain([(0, 5), (1, 1), (2, 2), (3, 9)])
    [(1, 1), (2, 2), (3, 9)]
    """
    # for each length: the smallest new index at which a chain of that length ends, and the number of its pair
    ends: list[int] = []
    last_pairs: list[int] = []
    predecessors: list[int] = []  # for each pair: the number of the pair before it in the chain, or -1
    for number, (_, new_index) in enumerate(pairs):
        length = bisect_left(ends, new_index)
        predecessors.append(last_pairs[length - 1] if length else -1)
        ends[length : length + 1], last_pairs[length : length + 1] = [new_index], [number]
    chain: list[Pair] = []
    number = last_pairs[-1] if last_pairs else -1
    while number >= 0:
        chain.append(pairs[number])
        number = predecessors[number]
    return chain[::-1]
