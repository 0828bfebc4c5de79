"""Scopes and their values, listed one level at a time.

    Rung         the tags that the rung names
    Locals       parameters and local tags of an add-on instruction
    Timers       timers and counters with EN, TT, DN, ACC, PRE
    Tags         of the program, then of the controller
    Inputs       modules, their words, the bits of a word by name
    Outputs

The values are those at the current place of the scan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from itertools import product
from typing import Any

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.model.operands import Group, Place
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.model.types import COUNTER, HIDDEN, TIMER, Structure

from .protocol import DebugError, Json
from .view import Tree

ReadWord = Callable[[int, str, int], int]
"""A function of slot, "I" or "O", and word number that returns a word of an image, signed."""


def type_text(place: Place | Group) -> str:
    """Return the type of a tag, such as `DINT`, `TIMER` or `INT[8]`."""
    name = place.type.name
    dims = place.dims if isinstance(place, Group) else ()
    return f"{name}[{','.join(map(str, dims))}]" if dims else name


def size_of(place: Group) -> Json:
    """Return the number of values of a structure or array, as protocol fields."""
    length = place.dims[0] if place.dims else 0
    return {"indexedVariables": length} if length else {"namedVariables": len(_members(place))}


def parts_of(tree: Tree, address: str, place: Group, *, files: bool) -> Iterator[Json]:
    """Yield a tag's members or elements; with `files`, elements have data file addresses like `N7:0`."""
    if not place.dims:
        names = [(member, f"{address}.{member}") for member in _members(place)]
    elif len(place.dims) == 1:
        form = ":{}" if files and ":" not in address else "[{}]"
        names = [(f"[{number}]", address + form.format(number)) for number in range(place.dims[0])]
    else:
        subscripts = [f"[{','.join(map(str, indices))}]" for indices in product(*map(range, place.dims))]
        names = [(subscript, address + subscript) for subscript in subscripts]
    return tags_in(tree, names)


def tags_in(tree: Tree, names: Iterable[tuple[str, str]]) -> Iterator[Json]:
    """Yield the tags that exist in memory; `names` has short and full names."""
    tags = tree.view.tags
    return (tree.value(name, address) for name, address in names if address in tags)


def values_in(tree: Tree, values: Mapping[str, Any], *, owned: bool = False) -> Iterator[Json]:
    """Yield Python values; with `owned`, they are values of the program, which can be set."""
    return (python_value(tree, name, value, owned=owned) for name, value in values.items())


class BareText(str):
    """A text that is shown without quotes."""

    __slots__ = ()


def python_value(tree: Tree, name: str, value: object, *, owned: bool = False) -> Json:
    """Return a Python value as a protocol object; lists and dicts can be opened."""
    fields: Json = {"name": name, "type": type(value).__name__}
    if owned:
        fields["evaluateName"] = name
    if isinstance(value, list | dict):
        if isinstance(value, dict):
            children, size_name = value, "namedVariables"
        else:
            children = {f"[{index}]": element for index, element in enumerate(value)}
            size_name = "indexedVariables"
        size, node = {size_name: len(value)}, partial(values_in, tree, children)
        return {**fields, "value": f"{fields['type']} of {len(value)}", "node": node, **size}
    text = str(value) if value is None or isinstance(value, bool | BareText) else tree.text(name, value)
    return {**fields, "value": text}


def modules_in(words: Mapping[int, ModuleWords], image: str, read: ReadWord) -> Iterator[Json]:
    """Yield the modules that have an image in one direction, "I" or "O"."""
    for slot, names in words.items():
        node = partial(_words_in, slot, names, image, read)
        yield {"name": f"slot {slot}", "value": names.message, "type": "module", "node": node}


def _words_in(slot: int, words: ModuleWords, image: str, read: ReadWord) -> Iterator[Json]:
    """Yield the words of an image; each opens to its bits by name."""
    for number, name in enumerate(words.named(image)):
        value, address = read(slot, image, number), f"Local:{slot}:{image}.Data[{number}]"
        bits = {bit: label for label, bit in words.bits(image, number)}
        yield {
            "name": name,
            "value": f"{value} (16#{value & 0xFFFF:04X})",
            "type": "INT",
            "evaluateName": address,
            "node": partial(_bits_in, address, value, bits),
        }


def _bits_in(address: str, value: int, names: Mapping[int, str]) -> Iterator[Json]:
    """Yield the named bits of a word, or all bits if none has a name."""
    for bit in sorted(names) or range(16):
        name = names.get(bit, str(bit))
        yield {
            "name": name,
            "value": str(value >> bit & 1),
            "type": "BOOL",
            "evaluateName": f"{address}.{bit}",
        }


def tags_of(engine: WatchedEngine, program: str, *, counted: bool = False) -> list[tuple[str, str]]:
    """Return the short and full names of a program's tags.

    Args:
        program: "" for the tags of the controller.
        counted: whether to return only timers and counters.
    """
    names = [
        tag.name
        for tag in engine.lowered.layout.tags().values()
        if HIDDEN not in tag.name and program_of(tag.name).upper() == program.upper()
        if not counted or (tag.type in (TIMER, COUNTER) and not tag.dims)
    ]
    return [(name.rpartition(".")[2] if program else name, name) for name in names]


def _members(place: Group) -> list[str]:
    kind = place.type
    assert isinstance(kind, Structure)
    return [member.name for member in kind.members if not member.hidden and "~" not in member.name]


def _unquoted(text: str) -> str:
    quoted = len(text) > 1 and text[0] in "'\"" and text[-1] == text[0]
    return text[1:-1] if quoted else text


def value_in(text: str, current: object) -> Any:
    """Parse a text as a value with the type of a tag's current value.

    >>> value_in("16#1F", 0), value_in("true", False), value_in("1", False), value_in("'run'", "")
    (31, True, True, 'run')

    Raises:
        DebugError: the text is not a value of that type.
    """
    trimmed = text.strip()
    if isinstance(current, str):
        return _unquoted(trimmed)
    words = {"true": True, "false": False, "on": True, "off": False}
    if trimmed.lower() in words:
        return words[trimmed.lower()]
    base, sign, digits = trimmed.rpartition("#")
    try:
        number = int(digits, int(base)) if sign else int(trimmed.replace("_", ""), 0)
    except ValueError:
        try:
            return float(trimmed)
        except ValueError:
            raise DebugError(f"{text!r} is not a value: give a number, true, false, or 16#1F") from None
    if isinstance(current, bool) and number in (0, 1):
        return bool(number)
    return float(number) if isinstance(current, float) else number
