"""Align two sequences in nearly linear time.

1. The common beginning and the common end are matched.
2. Keys that both have once are anchors; the longest chain of anchors in both orders stays, and the stretches
   between them are aligned in the same way.
3. A short stretch without an anchor is aligned by `difflib`; a long one by the first, second, … of each key.

Thousands of equal rungs have no anchor, and `difflib` would compare every pair of them.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterator, Sequence
from difflib import SequenceMatcher

SMALL = 1_024
"""Largest product of two lengths that `difflib` aligns."""

DEEPEST = 40
"""Maximum depth of anchors between anchors."""

Pair = tuple[int, int]


def aligned(old: Sequence[Hashable], new: Sequence[Hashable]) -> list[Pair]:
    """Return ascending pairs of places with equal keys.

    >>> aligned("abcd", "axcbd")
    [(0, 0), (2, 2), (3, 4)]
    """
    return sorted(_pairs(old, new))


def _pairs(old: Sequence[Hashable], new: Sequence[Hashable]) -> Iterator[Pair]:
    todo = [(0, len(old), 0, len(new), 0)]
    while todo:
        i, j, k, n, depth = todo.pop()
        while i < j and k < n and old[i] == new[k]:
            yield i, k
            i, k = i + 1, k + 1
        while i < j and k < n and old[j - 1] == new[n - 1]:
            j, n = j - 1, n - 1
            yield j, n
        if i == j or k == n:
            continue
        anchors = _anchors(old, new, (i, j, k, n)) if depth < DEEPEST else []
        if not anchors:
            yield from _without_anchor(old, new, (i, j, k, n))
            continue
        yield from anchors
        for (from_i, from_k), (to, to_k) in zip(
            [(i, k), *((a + 1, b + 1) for a, b in anchors)], [*anchors, (j, n)], strict=True
        ):
            todo.append((from_i, to, from_k, to_k, depth + 1))


def _anchors(old: Sequence[Hashable], new: Sequence[Hashable], span: tuple[int, ...]) -> list[Pair]:
    i, j, k, n = span
    once = Counter(old[i:j])
    other_counts = Counter(new[k:n])
    places = {new[place]: place for place in range(k, n) if other_counts[new[place]] == 1}
    return longest_chain(
        [
            (place, places[old[place]])
            for place in range(i, j)
            if once[old[place]] == 1 and old[place] in places
        ]
    )


def _without_anchor(
    old: Sequence[Hashable], new: Sequence[Hashable], span: tuple[int, ...]
) -> Iterator[Pair]:
    i, j, k, n = span
    if (j - i) * (n - k) <= SMALL:
        matcher = SequenceMatcher(None, old[i:j], new[k:n], autojunk=False)
        for block in matcher.get_matching_blocks():
            yield from ((i + block.a + offset, k + block.b + offset) for offset in range(block.size))
        return
    places: defaultdict[Hashable, list[int]] = defaultdict(list)
    for place in range(n - 1, k - 1, -1):
        places[new[place]].append(place)
    yield from longest_chain(
        [(place, places[old[place]].pop()) for place in range(i, j) if places.get(old[place])]
    )


def longest_chain(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the longest subsequence of pairs that ascends in both places; `pairs` ascend in the first.

    >>> longest_chain([(0, 5), (1, 1), (2, 2), (3, 9)])
    [(1, 1), (2, 2), (3, 9)]
    """
    ends: list[int] = []
    last: list[int] = []
    before: list[int] = []
    for number, (_, place) in enumerate(pairs):
        index = bisect_left(ends, place)
        before.append(last[index - 1] if index else -1)
        ends[index : index + 1], last[index : index + 1] = [place], [number]
    chain: list[Pair] = []
    index = last[-1] if last else -1
    while index >= 0:
        chain.append(pairs[index])
        index = before[index]
    return chain[::-1]
