"""Find renamed tags: a removed tag and an added one of the same type that rungs use in the same way.

    - Start BOOL     XIC(Start)OTE(Run);  ->  XIC(Begin)OTE(Run);     + Begin BOOL

Both are used equally often, at the same places of rungs with the same instructions, and no other tag matches.
Otherwise they count as a removed and an added tag.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from .outline import Item, Step

_WORD = re.compile(r"(?<![\w.:\\#$])([A-Za-z_]\w*+)(?![\w(:])|'(?:[^'$]++|\$.)*+'")
"""The name of a tag in a key; strings are skipped."""

_MNEMONIC = re.compile(r"([A-Za-z_]\w*+)\(")

TAGS = frozenset(("tag", "local tag", "parameter"))

Use = tuple[str, int]
"""The text or the mnemonics of a rung, and a place among its names."""


def renamed(
    old: Iterable[Item], new: Iterable[Item], before: Sequence[Step], after: Sequence[Step]
) -> dict[str, Item]:
    """Return renamed tags, in their new version, by old name in capitals.

    Args:
        old: removed tags of a scope.
        new: added tags of the scope.
        before: steps of the scope in the old version that may use them.
        after: steps of the scope in the new version.
    """
    removed, added = _tags_of(old), _tags_of(new)
    if not removed or not added:
        return {}
    for tags, steps in ((removed, after), (added, before)):
        for name in {word for step in steps for word in _names_in(step)} & tags.keys():
            del tags[name]
    names: dict[str, Item] = {}
    for shape in (_rest, _mnemonics):  # rungs equal except for names; then rungs with equal mnemonics
        gone, come = _by_use(removed, before, shape), _by_use(added, after, shape)
        for use, old_names in gone.items():
            new_names = come.get(use, [])
            if len(old_names) == len(new_names) == 1:
                names[old_names[0]] = added.pop(new_names[0])
                del removed[old_names[0]]
    return names


def _tags_of(items: Iterable[Item]) -> dict[str, Item]:
    return {item.name.upper(): item for item in items if item.what in TAGS}


def _rest(key: str, names: Mapping[str, Item]) -> str:
    """Return a rung with `?` in place of the tags that only its version has."""
    return _WORD.sub(lambda word: "?" if (word[1] or "").upper() in names else word[0], key)


def _mnemonics(key: str, _names: Mapping[str, Item]) -> str:
    return " ".join(_MNEMONIC.findall(key))


def _by_use(
    tags: Mapping[str, Item], steps: Iterable[Step], shape: Callable[[str, Mapping[str, Item]], str]
) -> dict[object, list[str]]:
    """Return the names of used tags by type and uses."""
    uses: defaultdict[str, list[Use]] = defaultdict(list)
    for step in steps:
        words = _names_in(step)
        if not tags.keys().isdisjoint(words):
            alike = shape(step.key, tags)
            for number, word in enumerate(words):
                if word in tags:
                    uses[word].append((alike, number))
    groups: defaultdict[object, list[str]] = defaultdict(list)
    for name, contexts in uses.items():
        item = tags[name]
        kinds = tuple(text for label, text in item.fields if label in ("DataType", "Dimensions", "TagType"))
        groups[item.what, kinds, frozenset(Counter(contexts).items())].append(name)
    return groups


def _names_in(step: Step) -> list[str]:
    return [(word[1] or "").upper() for word in _WORD.finditer(step.key)]


def with_new_names(step: Step, names: Mapping[str, Item]) -> Step:
    """Return a step with new names in its key."""
    if not names:
        return step

    def new(word: re.Match[str]) -> str:
        item = names.get((word[1] or "").upper())
        return word[0] if item is None else item.name

    return replace(step, key=_WORD.sub(new, step.key))
