"""Tags with a new name: a removed one and an added one of the same type that rungs use in the same way.

    - Start BOOL     XIC(Start)OTE(Run);  ->  XIC(Begin)OTE(Run);     + Begin BOOL

Both are used equally often, at the same places of rungs with the same instructions, and no other pair is.
Anything less is a removed tag and an added one.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from .outline import Item, Step

_WORD = re.compile(r"(?<![\w.:\\#$])([A-Za-z_]\w*+)(?![\w(:])|'(?:[^'$]++|\$.)*+'")
"""The name of a tag in a key; a string has none."""

_MNEMONIC = re.compile(r"([A-Za-z_]\w*+)\(")

TAGS = frozenset(("tag", "local tag", "parameter"))

Use = tuple[str, int]
"""A rung, or what is alike of it, and a place among its names."""


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
    removed, added = _tags_of(old), _tags_of(new)
    if not removed or not added:
        return {}
    for tags, other in ((removed, after), (added, before)):
        for name in {each for step in other for each in _names_in(step)} & tags.keys():
            del tags[name]
    names: dict[str, Item] = {}
    for shape in (_rest, _mnemonics):  # rungs that are the same but for the names; then those alike
        gone, come = _by_use(removed, before, shape), _by_use(added, after, shape)
        for use, ours in gone.items():
            theirs = come.get(use, [])
            if len(ours) == len(theirs) == 1:
                names[ours[0]] = added.pop(theirs[0])
                del removed[ours[0]]
    return names


def _tags_of(items: Iterable[Item]) -> dict[str, Item]:
    return {each.name.upper(): each for each in items if each.what in TAGS}


def _rest(key: str, names: Mapping[str, Item]) -> str:
    """Return a rung without the names of tags that only its version has."""
    return _WORD.sub(lambda word: "?" if (word[1] or "").upper() in names else word[0], key)


def _mnemonics(key: str, _names: Mapping[str, Item]) -> str:
    return " ".join(_MNEMONIC.findall(key))


def _by_use(
    tags: Mapping[str, Item], steps: Iterable[Step], shape: Callable[[str, Mapping[str, Item]], str]
) -> dict[object, list[str]]:
    """Return the names of tags by type and uses, without those that are not used."""
    uses: defaultdict[str, list[Use]] = defaultdict(list)
    for step in steps:
        words = _names_in(step)
        if not tags.keys().isdisjoint(words):
            alike = shape(step.key, tags)
            for number, word in enumerate(words):
                if word in tags:
                    uses[word].append((alike, number))
    found: defaultdict[object, list[str]] = defaultdict(list)
    for name, each in uses.items():
        item = tags[name]
        kinds = tuple(text for label, text in item.fields if label in ("DataType", "Dimensions", "TagType"))
        found[item.what, kinds, frozenset(Counter(each).items())].append(name)
    return found


def _names_in(step: Step) -> list[str]:
    return [(word[1] or "").upper() for word in _WORD.finditer(step.key)]


def with_new_names(step: Step, names: Mapping[str, Item]) -> Step:
    """Return a step whose key has the new names."""
    if not names:
        return step

    def new(word: re.Match[str]) -> str:
        item = names.get((word[1] or "").upper())
        return word[0] if item is None else item.name

    return replace(step, key=_WORD.sub(new, step.key))
