"""Rungs and lines of two versions: the same, moved, changed, added, removed.

the same     the longest chain in both orders, see `alignment`
moved        the same key elsewhere in the routine
changed      of the rest between two unchanged ones: the most similar, or those with the same comment
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from .alignment import Pair, aligned
from .outline import LINE, Step

TOKEN = re.compile(r"'(?:[^'$]++|\$.)*+'|\"[^\"]*+\"|[\w.:#\\$%/?]++|\S")
"""A token of a rung or a line: a mnemonic, an operand, or a sign."""

_NAMED = re.compile(r"ID=((?:(?! \w+=).)*+)")
"""The name of an element in a connection."""

ALIKE = 0.5
"""Minimum similarity of a changed rung's two versions."""

WINDOW = 20
"""Number of rungs before and after the corresponding place that are compared with a changed rung."""

MOST_TOKENS = 200_000
"""Maximum tokens of a stretch; beyond it only rungs at the same place are compared."""

SHORTEST = 8
"""Minimum characters of a moved line: `END_IF;` is everywhere."""


class Pairing(NamedTuple):
    """A step in both versions; None in a version that lacks it."""

    old: Step | None
    new: Step | None
    moved: bool = False  # whether the same step is at another place


def tokens_of(text: str) -> list[str]:
    """Split a rung or a line into tokens.

    >>> tokens_of("XIC(Motor.Run)EQU(S,'a b');")
    ['XIC', '(', 'Motor.Run', ')', 'EQU', '(', 'S', ',', "'a b'", ')', ';']
    """
    return TOKEN.findall(text)


def paired(old: Sequence[Step], new: Sequence[Step]) -> list[Pairing]:
    """Return the steps of two versions in pairs, in the order of the new one."""
    before, after = [step.key for step in old], [step.key for step in new]
    pairs = aligned(before, after)
    free = _Free(old, new, pairs)
    moved = list(free.moved())
    for (i, k), (j, n) in pairwise([(-1, -1), *pairs, (len(old), len(new))]):
        free.pair(range(i + 1, j), range(k + 1, n))
    pairings = [Pairing(old[i], new[k]) for i, k in (*pairs, *free.changed)]
    pairings += [Pairing(old[i], new[k], moved=True) for i, k in moved]
    added = [Pairing(None, new[k]) for k in free.new]
    return _in_order(pairings + added, [old[i] for i in sorted(free.old)])


def without_followers(pairs: Sequence[Pairing]) -> list[Pairing]:
    """Leave out connections that changed only because an element was renamed."""
    names = {
        pair.old.name: pair.new.name
        for pair in pairs
        if pair.old is not None and pair.new is not None and pair.old.name != pair.new.name
    }
    return [pair for pair in pairs if not (names and _follows(pair, names))]


def _follows(pair: Pairing, names: Mapping[str, str]) -> bool:
    if pair.old is None or pair.new is None or pair.old.key == pair.new.key or pair.old.name:
        return False
    key = _NAMED.sub(lambda found: f"ID={names.get(found[1], found[1])}", pair.old.key)
    return key == pair.new.key


def _in_order(found: list[Pairing], removed: list[Step]) -> list[Pairing]:
    """Sort in the order of the new version; a removed step comes after its predecessor in the old one."""
    found.sort(key=lambda each: each.new.number if each.new is not None else -1)
    followed: defaultdict[int, list[Pairing]] = defaultdict(list)
    places = sorted(pairing.old.number for pairing in found if pairing.old is not None and not pairing.moved)
    index, last = 0, -1
    for step in removed:
        while index < len(places) and places[index] < step.number:
            last = places[index]
            index += 1
        followed[last].append(Pairing(step, None))
    ordered = followed.pop(-1, [])
    for pairing in found:
        ordered.append(pairing)
        if pairing.old is not None and not pairing.moved:
            ordered += followed.pop(pairing.old.number, [])
    return ordered


class _Free:
    """Places of steps that have no pair yet."""

    def __init__(self, old: Sequence[Step], new: Sequence[Step], pairs: Sequence[Pair]) -> None:
        self._old, self._new = old, new
        self.old = set(range(len(old))) - {i for i, _ in pairs}
        self.new = set(range(len(new))) - {k for _, k in pairs}
        self.changed: list[Pair] = []

    def take(self, i: int, k: int) -> None:
        self.old.discard(i)
        self.new.discard(k)

    def moved(self) -> Iterator[Pair]:
        """Yield moved steps; a line must be long and unique in both versions."""
        places: defaultdict[str, list[int]] = defaultdict(list)
        for i in sorted(self.old, reverse=True):
            places[self._old[i].key].append(i)
        counts = Counter(self._new[k].key for k in self.new)
        for k in sorted(self.new):
            step = self._new[k]
            candidates = places.get(step.key)
            is_plain = step.what == LINE and (
                len(step.key) < SHORTEST or counts[step.key] > 1 or len(candidates or ()) > 1
            )
            if candidates and not is_plain:
                i = candidates.pop()
                self.take(i, k)
                yield i, k

    def pair(self, olds: range, news: range) -> None:
        """Pair what is left of a stretch, the most similar ones first."""
        before, after = sorted(self.old.intersection(olds)), sorted(self.new.intersection(news))
        if not before or not after:
            return
        ranked = [
            (-alike, abs(i - olds.start - k + news.start), i, k)
            for i, k, alike in self._similarities(before, after)
            if alike >= ALIKE
        ]
        for _, _, i, k in sorted(ranked):
            if i in self.old and k in self.new:
                self.take(i, k)
                self.changed.append((i, k))

    def _similarities(self, before: list[int], after: list[int]) -> Iterator[tuple[int, int, float]]:
        """Yield pairs at about the same place with their similarity, which is full for equal comments."""
        olds = {i: _weights(self._old[i].key) for i in before}
        news = {k: _weights(self._new[k].key) for k in after}
        words = sum(map(len, (*olds.values(), *news.values())))
        window = WINDOW if words <= MOST_TOKENS else 0
        for number, i in enumerate(before):
            middle = number * len(after) // len(before)
            comment = self._old[i].comment
            for k in after[max(middle - window, 0) : middle + window + 1]:
                same_comment = comment and comment == self._new[k].comment
                yield i, k, 1.0 if same_comment else _similarity(olds[i], news[k])


def _weights(key: str) -> Counter[str]:
    """Return the weights of a rung's words: an operand counts twice, a sign not at all."""
    tokens = tokens_of(key)
    words: Counter[str] = Counter()
    for token, after in zip(tokens, [*tokens[1:], ""], strict=True):
        if token[0].isalnum() or token[0] in "_'\"\\#":
            words[token] += 1 if after == "(" else 2
    return words


def _similarity(one: Counter[str], other: Counter[str]) -> float:
    total = one.total() + other.total()
    few, many = (one, other) if len(one) < len(other) else (other, one)
    common_count = sum(min(count, many[word]) for word, count in few.items())
    return 2 * common_count / total if total else 0.0
