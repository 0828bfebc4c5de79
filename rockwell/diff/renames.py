"""Tags with a new name: a removed one and an added one of the same type that rungs use in the same way.

    - Start BOOL     XIC(Start)OTE(Run);  ->  XIC(Begin)OTE(Run);     + Begin BOOL

Both are used equally often, at the same places of rungs with the same instructions, and no other pair is.
Anything less is a removed tag and an added one.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from .outline import Item, Step

_WORD = re.compile(r"(?<![\w.:\\#$])([A-Za-z_]\w*+)(?![\w(:])|'(?:[^'$]++|\$.)*+'")
"""The name of a tag in a key; a string has none."""

_MNEMONIC = re.compile(r"([A-Za-z_]\w*+)\(")

TAGS = frozenset(("tag", "local tag", "parameter"))

Uses = Mapping[str, list[tuple[str, int]]]
"""By a name in capitals: the instructions of each rung that has it, and its place among the rung's names."""


def uses_of(steps: Iterable[Step]) -> Uses:
    """Return the uses of names."""
    found: defaultdict[str, list[tuple[str, int]]] = defaultdict(list)
    for step in steps:
        shape = " ".join(_MNEMONIC.findall(step.key))
        for number, word in enumerate(_WORD.finditer(step.key)):
            if word[1]:
                found[word[1].upper()].append((shape, number))
    return found


def renamed(
    old: Iterable[Item], new: Iterable[Item], before: Sequence[Step], after: Sequence[Step]
) -> dict[str, Item]:
    """Return the new tags of removed ones by the old name in capitals.

    Args:
        old: removed tags of a scope.
        new: added ones.
        before: steps of the scope in the old version that may use them.
        after: those of the new one.
    """
    removed = [each for each in old if each.what in TAGS]
    added = [each for each in new if each.what in TAGS]
    if not removed or not added:
        return {}
    were, are = uses_of(before), uses_of(after)
    gone = _by_use(removed, were, are)
    come = _by_use(added, are, were)
    return {
        ours[0].name.upper(): come[use][0]
        for use, ours in gone.items()
        if len(ours) == 1 and len(come.get(use, ())) == 1
    }


def _by_use(tags: Iterable[Item], own: Uses, other: Uses) -> dict[object, list[Item]]:
    """Return tags that only their version uses, by type and uses."""
    found: defaultdict[object, list[Item]] = defaultdict(list)
    for each in tags:
        name = each.name.upper()
        if own.get(name) and not other.get(name):
            kinds = tuple(
                text for label, text in each.fields if label in ("DataType", "Dimensions", "TagType")
            )
            uses = frozenset(Counter(own[name]).items())
            found[each.what, kinds, uses].append(each)
    return found


def with_new_names(step: Step, names: Mapping[str, Item]) -> Step:
    """Return a step whose key has the new names."""
    if not names:
        return step

    def new(word: re.Match[str]) -> str:
        item = names.get((word[1] or "").upper())
        return word[0] if item is None else item.name

    return replace(step, key=_WORD.sub(new, step.key))
