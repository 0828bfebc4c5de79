"""Binds the items of a panel: to tags of a program, words and bits of images, inputs of modules."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from heapq import nlargest
from itertools import pairwise
from typing import Any

from ..history.stretch import Json, Stretch
from .panel_file import ANY, BIT, KINDS, NUMBER

NEAREST = 3
"""Largest number of names suggested for an unknown one."""

HINTS_MOST, COMPARED_MOST = 5, 100
"""Most unknown tags per panel that get suggestions, and most names compared with each: all pages wait."""

HINTS_KEPT = 1000

_NUMBERS = re.compile(r"U?[SDL]?INT|L?REAL|BYTE|D?WORD")
TYPES: Mapping[str, Callable[[str], object]] = {
    BIT: lambda name: name == "BOOL",
    NUMBER: lambda name: name == "BOOL" or _NUMBERS.fullmatch(name) is not None,
    ANY: bool,
}
"""Checks of tag types, by the kind of types that items accept."""


class Bindings:
    """The names in a program and its rack to which items can be bound.

    Args:
        slots: slots as in `hello`.
        tags: tags as in `hello`.
    """

    def __init__(self, program: Stretch, slots: Sequence[Json], tags: Sequence[Json]) -> None:
        self._program = program
        self._tags = {tag["name"].upper(): tag for tag in tags}
        self._inputs = {
            f"slot{slot['number']}.input.{slot_input['name']}": _pressed(slot["number"], slot_input)
            for slot in slots
            for slot_input in slot["inputs"]
        }
        self._at = {source["read"]: source for source in self._inputs.values()}
        self._names = {name.upper(): name for name in (*(tag["name"] for tag in tags), *self._inputs)}
        self._hints_left = HINTS_MOST

    def of(self, item: Mapping[str, Any]) -> Json:
        """Return the binding of an item: how it is read and operated.

        `read` is the name of its value, and `type` the type of the value, "" if unknown. `press` has slot,
        name and level at rest of an input; the level is null if a machine operates the input. `write` is the
        tag that it sets. `broken` says why it does not work, "" if it works.
        """
        kind, tag = KINDS[item["kind"]], item["tag"]
        source, broken = self._found(tag), ""
        if source is None:
            return {"read": "", "type": "", "broken": f"no tag {tag}{self._hint(tag)}"}
        if not TYPES[kind.types](source["type"]):
            type_text = source["type"] or "a structure or an array"
            broken = f"{tag} is {type_text}: {item['kind']} needs {kind.types}"
        elif kind.operates and "press" not in source and "write" not in source:
            broken = f"{tag} can't be set: {item['kind']} needs a tag of the program or an input"
        return {**source, "broken": broken}

    def _hint(self, tag: str) -> str:
        """Return a hint with names for an unknown tag, "" if there are none; the hints are cached."""
        hints, key = self._program.hints, (tag, len(self._names))
        if key not in hints and self._hints_left:
            self._hints_left -= 1
            name_key = tag.upper()
            near_keys = get_close_matches(name_key, _likely(name_key, self._names), NEAREST, 0.5)
            if len(hints) >= HINTS_KEPT:
                hints.clear()
            hints[key] = (
                f"; did you mean {', '.join(self._names[name] for name in near_keys)}?" if near_keys else ""
            )
        return hints.get(key, "")

    def _found(self, tag: str) -> Json | None:
        """Return the binding of a tag; None if there is no such tag."""
        if tag in self._inputs:
            return self._inputs[tag]
        address = self._program.address(tag)
        if address is not None:
            source = {"read": str(address), "type": "INT" if address.bit is None else "BOOL"}
            return self._at.get(source["read"], source)
        tag_row, catalog = self._tags.get(tag.upper()), self._program.catalog
        kind = catalog.type_of(tag) if catalog is not None else None if tag_row is None else tag_row["type"]
        if kind is None:
            return None
        return {"read": tag, "type": kind} | (
            {"write": tag} if tag_row is None or tag_row["writable"] else {}
        )


def _likely(name: str, names: Iterable[str]) -> list[str]:
    """Return the names that share the most letter pairs with the given name, or else its first letter."""
    pairs = {f"{first}{second}" for first, second in pairwise(name)}
    return nlargest(
        COMPARED_MOST, names, key=lambda each: (sum(map(each.__contains__, pairs)), each[:1] == name[:1])
    )


def _pressed(slot: int, bit: Json) -> Json:
    """Return the binding of an input; an input of a card is read as a bit of its image."""
    read_name = f"{slot}.input.{bit['name']}"
    if "word" in bit:
        read_name = f"Local:{slot}:I.Data[{bit['word']}].{bit['bit']}"
    by_machine = "word" not in bit and bit["kind"] != "button"
    rest_level = None if by_machine else bit["rest"]
    return {"read": read_name, "type": "BOOL", "press": [slot, bit["name"], rest_level]}
