"""Data types, tags and values as real controllers have them, for `real_mix`.

Types have 8 to 300 members: packed bits, nested types, arrays, timers and strings. A tag's values are printed
as an export prints them, member by member.
"""

import re
from collections.abc import Iterator
from itertools import zip_longest
from random import Random
from typing import NamedTuple

from l5x_files import cdata, data_type, member, tag

STRINGS = {"STRING": 82, "Name20": 20}
ITEMS = 1_000
"""Elements of an array of structures in a controller of as many rungs or more."""

FILLED = 50
"""Elements of such an array with values; those behind are zeros, printed as all others."""

BEHIND = 20
"""An index stays so far from the end of its array: a copy takes what follows with it."""


class Part(NamedTuple):
    """A member of a type, or a tag."""

    name: str
    kind: str
    length: int = 0


_NUMBER = re.compile(r'Value="[^"]*"')

Types = dict[str, tuple[Part, ...]]

_BASE: Types = {
    "Flags": tuple(Part(f"Flag{number}", "BOOL") for number in range(8)),
    "Limits": (
        *(Part(f"High{at}", "REAL") for at in range(4)),
        *(Part(f"Low{at}", "DINT") for at in range(4)),
    ),
    "Item": (
        Part("Id", "DINT"),
        Part("Count", "DINT"),
        Part("Weight", "REAL"),
        *(Part(f"Flag{number}", "BOOL") for number in range(6)),
        Part("Codes", "DINT", 4),
        Part("Name", "Name20"),
    ),
    "Record": (
        Part("Count", "DINT"),
        Part("Weight", "REAL"),
        Part("Flag0", "BOOL"),
        Part("Flag1", "BOOL"),
        Part("Codes", "INT", 4),
        Part("Late", "TIMER"),
    ),
}
_SIZES = (8, 20, 60, 150, 300)
_MEMBERS = {
    "BOOL": 45,
    "DINT": 20,
    "REAL": 10,
    "INT": 4,
    "TIMER": 5,
    "COUNTER": 2,
    "STRING": 2,
    "Name20": 2,
    "Flags": 2,
    "Limits": 2,
    "Unit8": 1,
}
_LONG = {"DINT": 10, "REAL": 5, "INT": 8}


def units(largest: int) -> tuple[str, ...]:
    """Return the names of the types of up to so many members."""
    return tuple(f"Unit{size}" for size in _SIZES if size <= largest)


def types_of(draw: Random, largest: int) -> Types:
    """Return the types, each after those of its members."""
    types = dict(_BASE)
    for name in units(largest):
        size = int(name.removeprefix("Unit"))
        members = []
        for number in range(size):
            (kind,) = draw.choices(tuple(_MEMBERS), tuple(_MEMBERS.values()))
            if kind == name:
                kind = "Flags"
            long = kind in _LONG and draw.random() < 0.2
            members.append(Part(f"{kind[:4]}{number}", kind, _LONG[kind] if long else 0))
        types[name] = (Part("Value", "DINT"), Part("Label", "Name20"), *members)
    return types


def type_text(name: str, parts: tuple[Part, ...]) -> str:
    """Return a type as an export prints it: eight bits in a hidden byte."""
    lines = []
    host, used = "", 8
    for each in parts:
        if each.kind != "BOOL":
            used = 8
            lines.append(member(each.name, each.kind, each.length))
            continue
        if used == 8:
            host, used = f"ZZZZ{name}{len(lines)}", 0
            lines.append(member(host, "SINT", hidden=True))
        lines.append(member(each.name, "BIT", target=host, bit=used))
        used += 1
    return data_type(name, *lines)


def string_type() -> str:
    """Return the type of a short string."""
    return data_type("Name20", member("LEN", "DINT"), member("DATA", "SINT", 20), family="StringFamily")


class Values:
    """Prints tags with values drawn for their type."""

    def __init__(self, draw: Random, types: Types) -> None:
        self._draw, self._types = draw, types

    def tag(self, part: Part) -> str:
        """Return a tag with its values."""
        data = self._array(part) if part.length else self._structure("Structure", "", part.kind)
        return tag(part.name, part.kind, str(part.length or ""), data, comment=f"{part.name} of the plant")

    def _array(self, part: Part, head: str = "Array", name: str = "") -> str:
        kind = part.kind
        if kind in STRINGS or kind in self._types:
            zeros = f"\n{self._structure('Structure', '', kind)}"
            zeros = _NUMBER.sub('Value="0"', zeros)
            inside = (f"\n{self._structure('Structure', '', kind)}" for _ in range(min(part.length, FILLED)))
            listed = (
                f'<Element Index="[{at}]">{each or zeros}</Element>\n'
                for at, each in zip_longest(range(part.length), inside)
            )
        else:
            listed = (
                f'<Element Index="[{at}]" Value="{self._number(kind)}"/>\n' for at in range(part.length)
            )
        return f'<{head}{name} DataType="{kind}" Dimensions="{part.length}">\n{"".join(listed)}</{head}>\n'

    def _structure(self, head: str, name: str, kind: str) -> str:
        """Return a value without dimensions."""
        if kind not in self._types and kind not in STRINGS and kind not in ("TIMER", "COUNTER"):
            end = "Member" if name else ""
            return f'<DataValue{end}{name} DataType="{kind}" Radix="Decimal" Value="{self._number(kind)}"/>\n'
        return f'<{head}{name} DataType="{kind}">\n{"".join(self._members(kind))}</{head}>\n'

    def _members(self, kind: str) -> Iterator[str]:
        if kind in STRINGS:
            text = f"part{self._draw.randrange(100)}"
            yield f'<DataValueMember Name="LEN" DataType="DINT" Radix="Decimal" Value="{len(text)}"/>\n'
            inside = cdata(f"'{text}'")
            yield f'<DataValueMember Name="DATA" DataType="{kind}" Radix="ASCII">{inside}</DataValueMember>\n'
        elif kind in ("TIMER", "COUNTER"):
            preset = self._draw.choice((20, 50, 200, 1_000, 5_000))
            yield f'<DataValueMember Name="PRE" DataType="DINT" Radix="Decimal" Value="{preset}"/>\n'
            yield '<DataValueMember Name="ACC" DataType="DINT" Radix="Decimal" Value="0"/>\n'
            yield '<DataValueMember Name="DN" DataType="BOOL" Value="0"/>\n'
        else:
            for each in self._types[kind]:
                name = f' Name="{each.name}"'
                if each.length:
                    yield self._array(each, "ArrayMember", name)
                else:
                    yield self._structure("StructureMember", name, each.kind)

    def _number(self, kind: str) -> str:
        if kind == "BOOL":
            return str(self._draw.randrange(2))
        return f"{self._draw.randrange(100)}.5" if kind == "REAL" else str(self._draw.randrange(100))


def places(types: Types, part: Part) -> Iterator[tuple[str, str]]:
    """Yield a tag's path and those of its members, with their kinds; of an array, those of one element."""
    kind = part.kind
    path = f"{part.name}[{min(3, part.length - 1)}]" if part.length else part.name
    yield path, kind
    for each in types.get(kind, ()):
        yield from places(types, Part(f"{path}.{each.name}", each.kind, each.length))
