"""Finds renamed tags: a removed tag and an added tag of the same type that rungs use in the same way.

    - Start BOOL     XIC(Start)OTE(Run);  ->  XIC(Begin)OTE(Run);     + Begin BOOL

Rungs with the same instructions use both tags at the same places, and no other tag matches.
Otherwise, they count as a removed and an added tag.
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
"""The form of a rung, and an index among its names."""


def renamed(
    removed_items: Iterable[Item],
    added_items: Iterable[Item],
    old_steps: Sequence[Step],
    new_steps: Sequence[Step],
) -> dict[str, Item]:
    """Return the renamed tags of a scope, in their new version, by old name in capitals.

    Args:
        old_steps: steps of the old version that may use the tags.
        new_steps: steps of the new version that may use the tags.
    """
    removed, added = _tags_of(removed_items), _tags_of(added_items)
    if not removed or not added:
        return {}
    _remove_used(removed, new_steps)
    _remove_used(added, old_steps)
    names: dict[str, Item] = {}
    for form in (_without_names, _mnemonics):  # rungs equal except for names; then rungs with equal mnemonics
        added_by_use = _by_use(added, new_steps, form)
        for use, old_names in _by_use(removed, old_steps, form).items():
            new_names = added_by_use.get(use, [])
            if len(old_names) == len(new_names) == 1:
                names[old_names[0]] = added.pop(new_names[0])
                del removed[old_names[0]]
    return names


def _tags_of(items: Iterable[Item]) -> dict[str, Item]:
    return {item.name.upper(): item for item in items if item.noun in TAGS}


def _remove_used(tags: dict[str, Item], steps: Iterable[Step]) -> None:
    """Remove the tags that the version without them still uses, because another scope declares them."""
    for step in steps:
        for name in tags.keys() & _names_in(step):
            del tags[name]


def _without_names(key: str, tags: Mapping[str, Item]) -> str:
    """Return a rung with `?` instead of tags."""
    return _WORD.sub(lambda word: "?" if (word[1] or "").upper() in tags else word[0], key)


def _mnemonics(key: str, _tags: Mapping[str, Item]) -> str:
    return " ".join(_MNEMONIC.findall(key))


def _by_use(
    tags: Mapping[str, Item], steps: Iterable[Step], form: Callable[[str, Mapping[str, Item]], str]
) -> dict[object, list[str]]:
    """Return the names of used tags by type and uses."""
    uses_by_name: defaultdict[str, list[Use]] = defaultdict(list)
    for step in steps:
        names = _names_in(step)
        if not tags.keys().isdisjoint(names):
            rung_form = form(step.key, tags)
            for index, name in enumerate(names):
                if name in tags:
                    uses_by_name[name].append((rung_form, index))
    groups: defaultdict[object, list[str]] = defaultdict(list)
    for name, uses in uses_by_name.items():
        tag = tags[name]
        kind = tuple(text for label, text in tag.fields if label in ("DataType", "Dimensions", "TagType"))
        groups[tag.noun, kind, frozenset(Counter(uses).items())].append(name)
    return groups


def _names_in(step: Step) -> list[str]:
    """Return the names in a step, in capitals; "" for a string."""
    return [(word[1] or "").upper() for word in _WORD.finditer(step.key)]


def with_new_names(step: Step, new_tags: Mapping[str, Item]) -> Step:
    """Return a step with the new names of renamed tags in its key; `new_tags` comes from `renamed`."""
    if not new_tags:
        return step

    def new_name(word: re.Match[str]) -> str:
        tag = new_tags.get((word[1] or "").upper())
        return word[0] if tag is None else tag.name

    return replace(step, key=_WORD.sub(new_name, step.key))
