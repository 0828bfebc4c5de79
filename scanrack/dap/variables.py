"""Scopes and their values, opened one level at a time.

    Rung         the tags that the rung names
    Locals       parameters and local tags of an add-on instruction
    Timers       timers and counters with EN, TT, DN, ACC, PRE
    Tags         of the program, then of the controller
    Inputs       modules, their words, the bits of a word by name
    Outputs

Values are those in the memory at the place of the frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.model.operands import Group, Place
from scanrack.ladder.model.tags import Tag, program_of
from scanrack.ladder.model.types import COUNTER, HIDDEN, TIMER, Structure

from .protocol import DebugError, Json
from .view import Tree

ReadWord = Callable[[int, str, int], int]
"""Returns a word of an image, signed: slot, "I" or "O", word."""


def type_text(where: Place | Group) -> str:
    """Return the type of a tag: `DINT`, `TIMER`, `INT[8]`."""
    name = where.type.name
    dims = where.dims if isinstance(where, Group) else ()
    return f"{name}[{','.join(map(str, dims))}]" if dims else name


class Parts:
    """The members or elements of a tag."""

    def __init__(self, tree: Tree, address: str, where: Group) -> None:
        self._tree, self._address, self._where = tree, address, where

    @property
    def size(self) -> Json:
        """The number of its values, as a protocol object."""
        length = self._where.dims[0] if self._where.dims else 0
        return {"indexedVariables": length} if length else {"namedVariables": len(_members(self._where))}

    def _names(self) -> Iterator[tuple[str, str]]:
        where = self._where
        if not where.dims:
            yield from ((each, f"{self._address}.{each}") for each in _members(where))
        elif len(where.dims) == 1:
            mark = (":{}" if ":" not in self._address else "[{}]") if self._files else "[{}]"
            yield from (
                (f"[{number}]", self._address + mark.format(number)) for number in range(where.dims[0])
            )
        else:
            for number in range(math.prod(where.dims)):
                at = ",".join(map(str, _unravel(number, where.dims)))
                yield f"[{at}]", f"{self._address}[{at}]"

    @property
    def _files(self) -> bool:
        return self._tree.view.engine.lowered.layout.files  # type: ignore[attr-defined, no-any-return]  # of rungs

    def children(self) -> Iterator[Json]:
        """Yield the values."""
        return (self._tree.value(name, address) for name, address in self._names())

    def tag(self, name: str) -> str:
        """Return the address of a member or element."""
        return _named(dict(self._names()), name)


class Names:
    """Some tags by their names."""

    def __init__(self, tree: Tree, names: Callable[[], Sequence[tuple[str, str]]]) -> None:
        self._tree, self._names = tree, names

    def children(self) -> Iterator[Json]:
        """Yield the tags that exist in the memory."""
        tags = self._tree.view.tags
        return (self._tree.value(name, address) for name, address in self._names() if address in tags)

    def tag(self, name: str) -> str:
        """Return the full name of a tag."""
        return _named(dict(self._names()), name)


class ValueNode:
    """The members of the kept copy of a Python value; the program's own members can be set."""

    def __init__(self, tree: Tree, values: Mapping[str, Any], *, owned: bool = False) -> None:
        self._tree, self._values, self._owned = tree, values, owned

    def children(self) -> Iterator[Json]:
        """Yield the values."""
        return (
            python_value(self._tree, name, each, owned=self._owned) for name, each in self._values.items()
        )

    def tag(self, name: str) -> str:
        """Return the name of a member that can be set."""
        if not self._owned:
            raise DebugError(f"{name} is a value of a scan that has run: set a value of the program")
        return _named({each: each for each in self._values}, name)


class BareText(str):
    """A string that is shown without quotes."""

    __slots__ = ()


def python_value(tree: Tree, name: str, value: object, *, owned: bool = False) -> Json:
    """Return a Python value as a protocol object; lists and dicts can be opened."""
    more: Json = {"evaluateName": name} if owned else {}
    if isinstance(value, list | dict):
        inner = value if isinstance(value, dict) else {f"[{at}]": each for at, each in enumerate(value)}
        size = {"namedVariables" if isinstance(value, dict) else "indexedVariables": len(value)}
        kind = type(value).__name__
        return {
            "name": name,
            "value": f"{kind} of {len(value)}",
            "type": kind,
            "node": ValueNode(tree, inner),
            **size,
        }
    text = str(value) if value is None or isinstance(value, bool | BareText) else tree.text(name, value)
    return {"name": name, "value": text, "type": type(value).__name__, **more}


class Modules:
    """The images of one direction, a node for each module."""

    def __init__(self, words: dict[int, ModuleWords], image: str, read: ReadWord) -> None:
        self._words, self._image, self._read = words, image, read

    def children(self) -> Iterator[Json]:
        """Yield the modules."""
        for slot, words in self._words.items():
            node = Words(slot, words, self._image, self._read)
            yield {"name": f"slot {slot}", "value": words.message, "type": "module", "node": node}

    def tag(self, name: str) -> str:
        """Refuse: a module is not a value."""
        raise DebugError(f"{name} is a module: set one of its words or bits")


class Words:
    """The words of an image of a module."""

    def __init__(self, slot: int, words: ModuleWords, image: str, read: ReadWord) -> None:
        self._slot, self._words, self._image, self._read = slot, words, image, read

    def children(self) -> Iterator[Json]:
        """Yield the words; each opens to its bits by name."""
        names = self._words.inputs if self._image == "I" else self._words.outputs
        for number, name in enumerate(names):
            value = self._read(self._slot, self._image, number)
            bits = {
                bit.bit: each
                for group in self._words.groups.values()
                for each, bit in group.items()
                if (bit.image, bit.word) == (self._image, number)
            }
            address = f"Local:{self._slot}:{self._image}.Data[{number}]"
            yield {
                "name": name,
                "value": f"{value} (16#{value & 0xFFFF:04X})",
                "type": "INT",
                "evaluateName": address,
                "node": Bits(address, value, bits),
            }

    def tag(self, name: str) -> str:
        """Return the address of a word."""
        names = self._words.inputs if self._image == "I" else self._words.outputs
        addresses = {each: f"Local:{self._slot}:{self._image}.Data[{n}]" for n, each in enumerate(names)}
        return _named(addresses, name)


class Bits:
    """The bits of a word."""

    def __init__(self, address: str, value: int, names: dict[int, str]) -> None:
        self._address, self._value, self._names = address, value, names

    def children(self) -> Iterator[Json]:
        """Yield the bits with a name, or all bits of a word without names."""
        for bit in sorted(self._names) or range(16):
            name, value = self._names.get(bit, str(bit)), str(self._value >> bit & 1)
            yield {"name": name, "value": value, "type": "BOOL", "evaluateName": f"{self._address}.{bit}"}

    def tag(self, name: str) -> str:
        """Return the address of a bit."""
        numbers = {self._names.get(bit, str(bit)): f"{self._address}.{bit}" for bit in range(16)}
        return _named(numbers, name)


def tags_of(engine: WatchedEngine, program: str, *, counted: bool = False) -> list[tuple[str, str]]:
    """Return the tags of a program by short and full name, "" for the controller; `counted` = only timers."""
    found = []
    for tag in engine.lowered.layout.tags().values():
        if HIDDEN in tag.name or program_of(tag.name).upper() != program.upper():
            continue
        if counted and not _is_counted(tag):
            continue
        found.append((tag.name.rpartition(".")[2] if program else tag.name, tag.name))
    return found


def _is_counted(tag: Tag) -> bool:
    return tag.type in (TIMER, COUNTER) and not tag.dims


def _members(where: Group) -> list[str]:
    kind = where.type
    assert isinstance(kind, Structure)
    return [each.name for each in kind.members if not each.hidden and "~" not in each.name]


def _unravel(number: int, dims: Sequence[int]) -> list[int]:
    found: list[int] = []
    for length in reversed(dims):
        number, index = divmod(number, length)
        found.insert(0, index)
    return found


def _named(addresses: dict[str, str], name: str) -> str:
    if name not in addresses:
        raise DebugError(f"no value {name!r} here")
    return addresses[name]


def _unquoted(text: str) -> str:
    quoted = len(text) > 1 and text[0] in "'\"" and text[-1] == text[0]
    return text[1:-1] if quoted else text


def value_in(text: str, current: object) -> Any:
    """Parse a text as a value of the same kind as a tag's present value.

    >>> value_in("16#1F", 0), value_in("true", False), value_in("1", False), value_in("'run'", "")
    (31, True, True, 'run')

    Raises:
        DebugError: the text is not a value of that kind.
    """
    written = text.strip()
    if isinstance(current, str):
        return _unquoted(written)
    words = {"true": True, "false": False, "on": True, "off": False}
    if written.lower() in words:
        return words[written.lower()]
    base, mark, digits = written.rpartition("#")
    try:
        number = int(digits, int(base)) if mark else int(written.replace("_", ""), 0)
    except ValueError:
        try:
            return float(written)
        except ValueError:
            raise DebugError(f"{text!r} is not a value: give a number, true, false, or 16#1F") from None
    if isinstance(current, bool) and number in (0, 1):
        return bool(number)
    return float(number) if isinstance(current, float) else number
