"""Pairs the rungs and lines of two versions: unchanged, moved, changed, added, removed.

unchanged    the longest chain in both orders, see `alignment`
moved        the same key elsewhere in the routine
changed      between two unchanged steps, the most similar of the others, or two with the same comment
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from .alignment import Pair, aligned
from .outline import LINE, Step

TOKEN = re.compile(r"'(?:[^'$]++|\$.)*+'|\"[^\"]*+\"|[\w.:#\\$%/?]++|\S")
"""A token of a rung or line: a mnemonic, an operand, or a punctuation mark."""

_NAMED = re.compile(r"ID=((?:(?! \w+=).)*+)")
"""The name of an element in a connection."""

ALIKE = 0.5
"""Minimum similarity of a changed rung's two versions."""

WINDOW = 20
"""Number of rungs before and after the corresponding rung to compare with a changed rung."""

MOST_TOKENS = 200_000
"""Maximum number of tokens in a stretch; in a longer one, only corresponding rungs are compared."""

SHORTEST = 8
"""Minimum number of characters of a moved line, because lines like `END_IF;` are everywhere."""


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
    pairs = aligned([step.key for step in old], [step.key for step in new])
    unpaired = _FreeSteps(old, new, pairs)
    moved = list(unpaired.take_moved())
    for (i, k), (next_i, next_k) in pairwise([(-1, -1), *pairs, (len(old), len(new))]):
        pairs += unpaired.take_changed(range(i + 1, next_i), range(k + 1, next_k))
    pairings = [Pairing(old[i], new[k]) for i, k in pairs]
    pairings += [Pairing(old[i], new[k], moved=True) for i, k in moved]
    pairings += [Pairing(None, new[k]) for k in unpaired.new]
    return _in_order(pairings, [old[i] for i in sorted(unpaired.old)])


def without_renamed_ends(pairs: Sequence[Pairing]) -> list[Pairing]:
    """Return the pairs without the connections that changed only because an element was renamed."""
    names = {
        pair.old.name: pair.new.name
        for pair in pairs
        if pair.old is not None and pair.new is not None and pair.old.name != pair.new.name
    }
    return [pair for pair in pairs if not (names and _has_renamed_end(pair, names))]


def _has_renamed_end(pair: Pairing, names: Mapping[str, str]) -> bool:
    """Return whether a connection differs only because elements were renamed."""
    if pair.old is None or pair.new is None or pair.old.key == pair.new.key or pair.old.name:
        return False
    key = _NAMED.sub(lambda match: f"ID={names.get(match[1], match[1])}", pair.old.key)
    return key == pair.new.key


def _in_order(pairings: list[Pairing], removed: list[Step]) -> list[Pairing]:
    """Return pairings and removed steps in the order of the new version.

    A removed step comes after its predecessor in the old version, unless the predecessor has moved.
    """
    pairings.sort(key=lambda pairing: -1 if pairing.new is None else pairing.new.number)
    kept = sorted(pairing.old.number for pairing in pairings if pairing.old is not None and not pairing.moved)
    followers: defaultdict[int, list[Pairing]] = defaultdict(list)  # by the old number before them, or -1
    for step in removed:
        index = bisect_left(kept, step.number)
        followers[kept[index - 1] if index else -1].append(Pairing(step, None))
    ordered = followers.pop(-1, [])
    for pairing in pairings:
        ordered.append(pairing)
        if pairing.old is not None and not pairing.moved:
            ordered += followers.pop(pairing.old.number, [])
    return ordered


class _FreeSteps:
    """The steps without a pair: their indexes in the old and in the new version."""

    def __init__(self, old: Sequence[Step], new: Sequence[Step], pairs: Sequence[Pair]) -> None:
        self._old_steps, self._new_steps = old, new
        self.old = set(range(len(old))) - {i for i, _ in pairs}
        self.new = set(range(len(new))) - {k for _, k in pairs}

    def _take(self, i: int, k: int) -> Pair:
        self.old.discard(i)
        self.new.discard(k)
        return i, k

    def take_moved(self) -> Iterator[Pair]:
        """Yield the pairs of moved steps; a moved line must be long enough and unique in both versions."""
        old_indexes: defaultdict[str, list[int]] = defaultdict(list)  # by key, the last one first
        for i in sorted(self.old, reverse=True):
            old_indexes[self._old_steps[i].key].append(i)
        counts = Counter(self._new_steps[k].key for k in self.new)
        for k in sorted(self.new):
            step = self._new_steps[k]
            candidates = old_indexes.get(step.key)
            if not candidates:
                continue
            is_unique = len(candidates) == counts[step.key] == 1
            if step.noun != LINE or (is_unique and len(step.key) >= SHORTEST):
                yield self._take(candidates.pop(), k)

    def take_changed(self, old_range: range, new_range: range) -> Iterator[Pair]:
        """Yield the pairs of changed steps in a stretch, the most similar first."""
        old_indexes = sorted(self.old.intersection(old_range))
        new_indexes = sorted(self.new.intersection(new_range))
        if not old_indexes or not new_indexes:
            return
        ranked = []
        for i, k, similarity in self._similarities(old_indexes, new_indexes):
            if similarity >= ALIKE:
                distance = abs((i - old_range.start) - (k - new_range.start))
                ranked.append((-similarity, distance, i, k))
        for _, _, i, k in sorted(ranked):
            if i in self.old and k in self.new:
                yield self._take(i, k)

    def _similarities(
        self, old_indexes: list[int], new_indexes: list[int]
    ) -> Iterator[tuple[int, int, float]]:
        """Yield pairs at about the same place with their similarity, which is 1.0 for equal comments."""
        old_weights = {i: _weights(self._old_steps[i].key) for i in old_indexes}
        new_weights = {k: _weights(self._new_steps[k].key) for k in new_indexes}
        words = sum(map(len, (*old_weights.values(), *new_weights.values())))
        window = WINDOW if words <= MOST_TOKENS else 0
        for number, i in enumerate(old_indexes):
            middle = number * len(new_indexes) // len(old_indexes)
            comment = self._old_steps[i].comment
            for k in new_indexes[max(middle - window, 0) : middle + window + 1]:
                same_comment = comment and comment == self._new_steps[k].comment
                yield i, k, 1.0 if same_comment else _similarity(old_weights[i], new_weights[k])


def _weights(key: str) -> Counter[str]:
    """Return the weights of a rung's words: 1 for a mnemonic, 2 for an operand; punctuation is omitted."""
    tokens = tokens_of(key)
    words: Counter[str] = Counter()
    for token, next_token in zip(tokens, [*tokens[1:], ""], strict=True):
        if token[0].isalnum() or token[0] in "_'\"\\#":
            words[token] += 1 if next_token == "(" else 2
    return words


def _similarity(first: Counter[str], second: Counter[str]) -> float:
    """Return the similarity of two rungs by the weights of their words, 0 to 1."""
    total = first.total() + second.total()
    few, many = sorted((first, second), key=len)
    common_weight = sum(min(weight, many[word]) for word, weight in few.items())
    return 2 * common_weight / total if total else 0.0
