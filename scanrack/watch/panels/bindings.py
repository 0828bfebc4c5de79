"""Bindings of panel items to tags of a program, words and bits of images, and inputs of modules."""

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
"""Maximum number of names suggested for an unknown name."""

HINTS_MOST, COMPARED_MOST = 5, 100
"""Maximum number of unknown tags per panel with hints, and of names compared with each, since all pages
wait."""

HINTS_KEPT = 1000

_NUMBERS = re.compile(r"U?[SDL]?INT|L?REAL|BYTE|D?WORD")
TYPES: Mapping[str, Callable[[str], object]] = {
    BIT: lambda name: name == "BOOL",
    NUMBER: lambda name: name == "BOOL" or _NUMBERS.fullmatch(name) is not None,
    ANY: bool,
}
"""Checks of tag types, by the `types` of a kind of item."""


class Bindings:
    """The bindings of panel items to a program and its rack.

    Args:
        slots: slots as in `hello`.
        tags: tags as in `hello`.
    """

    def __init__(self, program: Stretch, slots: Sequence[Json], tags: Sequence[Json]) -> None:
        self._program = program
        self._tags = {tag["name"].upper(): tag for tag in tags}
        # bindings of inputs, by their own names and by the names that are read
        self._inputs = {
            f"slot{slot['number']}.input.{slot_input['name']}": _input_binding(slot["number"], slot_input)
            for slot in slots
            for slot_input in slot["inputs"]
        }
        self._inputs_by_address = {source["read"]: source for source in self._inputs.values()}
        # all names that a tag may have, for hints
        self._names = {name.upper(): name for name in (*(tag["name"] for tag in tags), *self._inputs)}
        self._hints_left = HINTS_MOST

    def binding_of(self, item: Mapping[str, Any]) -> Json:
        """Return the binding of an item, which describes how a page reads and operates it.

        `read` is the name of its value, and `type` the type of the value, "" if unknown. `press` has the
        slot, the name and the released level of an input; the level is null if a machine operates the input.
        `write` is the tag that the item sets. `broken` is the reason why the item does not work, or "".
        """
        kind, tag = KINDS[item["kind"]], item["tag"]
        source, broken = self._source_of(tag), ""
        if source is None:
            return {"read": "", "type": "", "broken": f"no tag {tag}{self._hint(tag)}"}
        if not TYPES[kind.types](source["type"]):
            type_text = source["type"] or "a structure or an array"
            broken = f"{tag} is {type_text}: {item['kind']} needs {kind.types}"
        elif kind.operates and "press" not in source and "write" not in source:
            broken = f"{tag} can't be set: {item['kind']} needs a tag of the program or an input"
        return {**source, "broken": broken}

    def _hint(self, tag: str) -> str:
        """Return a hint with names similar to an unknown tag, or ""; hints are cached."""
        hints, key = self._program.hints, (tag, len(self._names))
        if key not in hints and self._hints_left:
            self._hints_left -= 1
            name = tag.upper()
            near = [
                self._names[match]
                for match in get_close_matches(name, _likely(name, self._names), NEAREST, 0.5)
            ]
            if len(hints) >= HINTS_KEPT:
                hints.clear()
            hints[key] = f"; did you mean {', '.join(near)}?" if near else ""
        return hints.get(key, "")

    def _source_of(self, tag: str) -> Json | None:
        """Return the binding of a tag, without `broken`; None for an unknown tag."""
        if tag in self._inputs:
            return self._inputs[tag]
        address = self._program.address(tag)
        if address is not None:
            source = {"read": str(address), "type": "INT" if address.bit is None else "BOOL"}
            return self._inputs_by_address.get(source["read"], source)
        tag_row, catalog = self._tags.get(tag.upper()), self._program.catalog
        if catalog is not None:
            tag_type = catalog.type_of(tag)
        else:
            tag_type = None if tag_row is None else tag_row["type"]
        if tag_type is None:
            return None
        is_writable = tag_row is None or tag_row["writable"]
        return {"read": tag, "type": tag_type} | ({"write": tag} if is_writable else {})


def _likely(name: str, names: Iterable[str]) -> list[str]:
    """Return the names that share the most letter pairs with a name, then those with its first letter."""
    pairs = {f"{first}{second}" for first, second in pairwise(name)}

    def likeness(candidate: str) -> tuple[int, bool]:
        return sum(pair in candidate for pair in pairs), candidate[:1] == name[:1]

    return nlargest(COMPARED_MOST, names, key=likeness)


def _input_binding(slot: int, module_input: Json) -> Json:
    """Return the binding of an input. An input of a card is read as a bit of its image."""
    name, is_card = module_input["name"], "word" in module_input
    read_name = f"{slot}.input.{name}"
    if is_card:
        read_name = f"Local:{slot}:I.Data[{module_input['word']}].{module_input['bit']}"
    is_pressed = is_card or module_input["kind"] == "button"
    released_level = module_input["rest"] if is_pressed else None
    return {"read": read_name, "type": "BOOL", "press": [slot, name, released_level]}
