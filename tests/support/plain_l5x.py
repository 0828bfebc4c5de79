"""The values of an L5X, read plainly: lxml, and a parser of L5K of its own. Nothing of it is scanrack's.

Values come as pairs of an address, such as `Line.Steps[2]`, and a number or text. Decorated data say all
addresses; L5K data have the order of the memory: members of the document's types, and for add-ons words of 32
BOOLs, then what lies between them [1756-RM084S, page 131].
"""

import re
import struct
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

from lxml import etree

WHOLE = {"SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"}
PLAIN = {"BOOL", "BIT", "REAL", "LREAL"} | WHOLE
STATUS = {
    "TIMER": (("EN", 31), ("TT", 30), ("DN", 29), "PRE", "ACC"),
    "COUNTER": (("CU", 31), ("CD", 30), ("DN", 29), ("OV", 28), ("UN", 27), "PRE", "ACC"),
    "CONTROL": (
        *((name, 31 - at) for at, name in enumerate(["EN", "EU", "DN", "EM", "ER", "UL", "IN", "FD"])),
        *("LEN", "POS"),
    ),
}
Value = int | float | str
Values = Iterator[tuple[str, Value]]
_TOKEN = re.compile(r"\s*(\[|\]|,|'(?:[^'$]|\$.)*'|[^\s,\[\]']+)", re.DOTALL)
_ESCAPE = re.compile(r"\$([0-9A-Fa-f]{2}|.)", re.DOTALL)
_NAMED = {"L": "\n", "N": "\n", "P": "\f", "R": "\r", "T": "\t"}


def plain(text: str) -> str:
    """The characters of a literal."""
    return _ESCAPE.sub(
        lambda at: chr(int(at[1], 16)) if len(at[1]) == 2 else _NAMED.get(at[1].upper(), at[1]), text
    )


def number(text: str, kind: str) -> Value:
    """A value in any radix, as its type keeps it."""
    if kind == "REAL":
        single: float = struct.unpack("<f", struct.pack("<f", float(text)))[0]
        return single
    if kind == "LREAL":
        return float(text)
    base, mark, digits = text.rpartition("#")
    found = int(digits.replace("_", ""), int(base)) if mark else int(text)
    bits = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64}.get(kind, 0)
    return found - (1 << bits) if bits and found >> bits - 1 == 1 else found


def tree(text: str) -> Any:
    """L5K data as lists of texts."""
    stack: list[list[Any]] = [[]]
    for token in _TOKEN.findall(text):
        if token == "[":
            stack.append([])
        elif token == "]":
            inner = stack.pop()
            stack[-1].append(inner)
        elif token != ",":
            stack[-1].append(token)
    return stack[0][0]


class Document:
    """An L5X."""

    def __init__(self, path: Path) -> None:
        self.root = etree.fromstring(path.read_bytes(), etree.XMLParser(huge_tree=True))
        self.types = {each.get("Name"): each for each in self.root.iter("DataType")}
        self.add_ons = {each.get("Name"): each for each in self.root.iter("AddOnInstructionDefinition")}

    def tags(self) -> Iterator[tuple[str, Any]]:
        """Full names and elements of the tags of the controller and of programs."""
        for each in self.root.iterfind("Controller/Tags/Tag"):
            yield each.get("Name"), each
        for program in self.root.iterfind("Controller/Programs/Program"):
            for each in program.iterfind("Tags/Tag"):
                yield rf"\{program.get('Name')}.{each.get('Name')}", each

    def values(self, name: str, tag: Any) -> Values:
        """The values of a tag, as decorated data and as L5K data have them."""
        for data in tag.iterfind("Data[@Format='Decorated']"):
            for each in data:
                yield from self.shown(name, each)
        for data in tag.iterfind("Data[@Format='L5K']"):
            dims = [int(each) for each in re.findall(r"\d+", tag.get("Dimensions") or "")]
            yield from self.listed(name, tag.get("DataType"), dims, tree("".join(data.itertext())))

    # --- decorated

    def shown(self, path: str, element: Any) -> Values:
        """The values in an element of decorated data."""
        kind = element.get("DataType", "")
        if element.tag.startswith("DataValue") and element.get("Value") is not None:
            yield path, number(element.get("Value"), kind)
        elif element.tag.startswith("DataValue"):
            yield path.removesuffix(".DATA"), plain(element.text.strip()[1:-1])
        for each in element.iterchildren("*"):
            if each.tag == "Element" and each.get("Value") is not None:
                yield path + each.get("Index"), number(each.get("Value"), kind)
            elif each.tag == "Element":
                yield from self.shown(path + each.get("Index"), each[0])
            elif not (each.get("Name") == "LEN" and element.find("*[@Name='DATA']") is not None):
                yield from self.shown(f"{path}.{each.get('Name')}", each)

    # --- L5K

    def listed(self, path: str, kind: str, dims: list[int], data: Any) -> Values:
        """The values in L5K data of a type; nothing of types whose memory is not known."""
        if dims:
            flat = data
            for _ in dims[1:]:
                flat = [each for inner in flat for each in inner]
            for index, each in zip(product(*map(range, dims)), flat, strict=True):
                yield from self.listed(f"{path}[{','.join(map(str, index))}]", kind, [], each)
        elif kind in PLAIN:
            yield path, number(data, kind)
        elif kind in STATUS:
            yield from self.status(path, STATUS[kind], data)
        elif kind == "STRING" or (kind in self.types and self.types[kind].get("Family") == "StringFamily"):
            yield path, plain(data[1][1:-1])[: int(data[0])]
        elif kind in self.types:
            yield from self.members(path, self.types[kind], data)
        elif kind in self.add_ons:
            yield from self.instance(path, self.add_ons[kind], data)

    def status(self, path: str, parts: Any, data: Any) -> Values:
        word, rest = int(data[0]), iter(data[1:])
        for part in parts:
            if isinstance(part, tuple):
                yield f"{path}.{part[0]}", word >> part[1] & 1
            else:
                yield f"{path}.{part}", int(next(rest))

    def members(self, path: str, kind: Any, data: Any) -> Values:
        words: dict[str, int] = {}
        parts = iter(data)
        for each in kind.iterfind("Members/Member"):
            name, dim = each.get("Name"), int(each.get("Dimension") or 0)
            if each.get("DataType") == "BIT":
                yield f"{path}.{name}", words[each.get("Target")] >> int(each.get("BitNumber")) & 1
                continue
            part = next(parts)
            if each.get("Hidden") == "true":
                words[name] = int(number(part, each.get("DataType")))
            else:
                yield from self.listed(f"{path}.{name}", each.get("DataType"), [dim] if dim else [], part)

    def instance(self, path: str, definition: Any, data: Any) -> Values:
        own = [
            each
            for each in (
                *definition.iterfind("Parameters/Parameter"),
                *definition.iterfind("LocalTags/LocalTag"),
            )
            if each.get("Usage") != "InOut" and not each.get("AliasFor")
        ]
        parts, word, bit = iter(data), 0, 32
        for each in own:
            name, kind = each.get("Name"), each.get("DataType")
            dims = [int(at) for at in re.findall(r"\d+", each.get("Dimensions") or "")]
            if kind == "BOOL" and not dims:
                if bit == 32:
                    word, bit = int(next(parts)), 0
                yield f"{path}.{name}", word >> bit & 1
                bit += 1
            else:
                yield from self.listed(f"{path}.{name}", kind, dims, next(parts))
