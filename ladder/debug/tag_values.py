r"""Finds tags by pattern for a recorder, with the Python expressions that read them.

The expressions use the variables of the compiled program, which are the cells of its memory.

| pattern | matches |
|---|---|
| `Run`, `fill.acc` | a tag, a member; case does not matter |
| `Fill` | all members of a structure except hidden ones; packed bits by name |
| `\Main.*`, `S?` | all tags that match |
| `Recipe[3].T`, `Recipe[3]` | an element |
| an alias | its target; for a bit, its word |
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from scanrack.io_images.tag_names import TEXT, NamesByPattern, element_of, normal, without_ranges

from ..model.errors import LadderError
from ..model.expressions import parse_address
from ..model.operands import Constant, Place, first_leaf, fixed_index_in
from ..model.resolver import AmbiguousTagError, Resolver
from ..model.stretches import Spot
from ..model.tags import Alias, Layout, Leaf
from ..model.tree import Address, BitStep
from ..model.types import DataType, Elementary, Member, Structure, count_of

_PACKED = re.compile(r"(?P<host>\w+)\.(?P<bit>\d+)")  # host and bit of a packed bit


@dataclass(frozen=True, slots=True)
class TagValue:
    """A value or an array of a program."""

    name: str  # its full name; for an array see `io_images.tag_names`
    type: str  # its elementary type, such as DINT; TEXT for a STRING
    length: int  # elements of an array; 0 for a single value
    source: str  # the expression that reads it: `*name` for an array, length and data for a TEXT


class ImageNamedError(LadderError):
    """The pattern matches part of a module's image, which is not a tag."""


class TagValues:
    """Finds values of a program's tags by pattern."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self.all_values = list(_all_values(layout))
        self._names = NamesByPattern((without_ranges(value.name) for value in self.all_values), fold=True)

    def matching(self, pattern: str) -> list[TagValue]:
        """Return the values that a pattern matches; raise a LadderError for an image, or for no match."""
        plain = without_ranges(normal(pattern))
        one_element = "[" in plain and not {"*", "?"} & set(plain)
        matches = [self.all_values[index] for index in self._names.indexes(plain)]
        if matches and not one_element:
            return matches
        address = Resolver(self._layout).address_of(plain)
        return self.matching(str(address)) if str(address) != plain else self._matching_address(address)

    def _matching_address(self, address: Address) -> list[TagValue]:
        """Return the values at an address: for an alias, at its target; for a bit, the whole word."""
        layout, resolver = self._layout, Resolver(self._layout)
        declaration = layout.declarations.get(address.name.upper())
        if isinstance(declaration, Alias) and not declaration.type:
            target = declaration.target
            return self.matching(str(Address(target.name, (*target.steps, *address.steps))))
        if address.steps and isinstance(address.steps[-1], BitStep):
            return self.matching(str(Address(address.name, address.steps[:-1])))
        operand = resolver.address(address)
        if isinstance(operand, Place) and operand.leaf.is_image:
            raise ImageNamedError(
                f"{address} is a part of slot {operand.leaf.slot}'s images, which every trace has; "
                f"remove it and use slot{operand.leaf.slot}.in and slot{operand.leaf.slot}.out"
            )
        index = fixed_index_in(first_leaf(operand).dims, operand.indices)
        if index is None:
            raise LadderError(f"{address} is not a whole tag")
        if isinstance(operand, Place):
            return [_value_at(layout, resolver.full_name(str(address)), operand)]
        name = f"{resolver.full_name(str(address))}{_ranges(layout, operand.dims)}"
        return list(_values(layout, operand.path, name, operand.type, index, operand.dims))


def tag_values(layout: Layout, patterns: Sequence[str]) -> list[TagValue]:
    """Return the values that patterns match, without duplicates; may raise a LadderError, see `TagValues`."""
    by_name: dict[str, TagValue] = {}
    values = TagValues(layout)
    for pattern in patterns:
        try:
            matches = values.matching(pattern)
        except ImageNamedError as error:
            raise ImageNamedError(f"{pattern!r}: {error}") from None
        except AmbiguousTagError:
            raise
        except LadderError as error:
            raise _no_match(pattern, values.all_values) from error
        for match in matches:
            by_name.setdefault(match.name, match)
    elements = {element_of(value.name, place) for value in by_name.values() for place in range(value.length)}
    return [value for value in by_name.values() if value.name not in elements]


def _no_match(pattern: str, values: Sequence[TagValue]) -> LadderError:
    names = {value.name.upper(): value.name for value in values}
    close = get_close_matches(pattern.upper(), names, 1)
    return LadderError(f"no tag matches {pattern!r}{f'; did you mean {names[close[0]]}?' if close else ''}")


def _all_values(layout: Layout) -> Iterator[TagValue]:
    for tag in layout.tags().values():
        yield from _values(layout, tag.name, f"{tag.name}{_ranges(layout, tag.dims)}", tag.type, 0, tag.dims)


def _ranges(layout: Layout, dims: tuple[int, ...]) -> str:
    """Return the range of subscripts in the name of an array.

    >>> _ranges(Layout([]), (2, 3)), _ranges(Layout([], files=True), (10,)), _ranges(Layout([]), ())
    ('[0..1,0..2]', ':0..9', '')
    """
    ranges = ",".join(f"0..{length - 1}" for length in dims)
    return f":{ranges}" if layout.files and dims else f"[{ranges}]" if dims else ""


def _array_name(layout: Layout, name: str) -> str:
    """Return the name of an array; a single subscript at its end is omitted."""
    plain = without_ranges(name)
    return plain if not layout.files and name.startswith(f"{plain}[") and name.count("..") == 1 else name


def _values(
    layout: Layout, path: str, name: str, kind: DataType, index: int, dims: tuple[int, ...]
) -> Iterator[TagValue]:
    """Yield the values at and below a path; `name` is the path with subscripts and ranges."""
    count = count_of(dims)
    if isinstance(kind, Elementary):
        yield _value(layout, name, layout.leaf(path), index * count, count if dims else 0)
    elif kind.is_string:
        for number in range(count):
            yield _string_value(
                layout, path, element_of(name, number) if dims else name, index * count + number
            )
    else:
        for member in kind.members:
            member_path, member_name = f"{path}.{member.name}", f"{name}.{member.name}"
            if member.hidden or "~" in member.name:
                continue
            if member.at:
                yield from _alias_values(layout, path, member_name, kind, member, index, dims)
            else:
                array_name = f"{member_name}{_ranges(layout, member.dims)}"
                yield from _values(layout, member_path, array_name, member.type, index, dims + member.dims)


def _alias_values(
    layout: Layout,
    path: str,
    name: str,
    kind: Structure,
    member: Member,
    index: int,
    dims: tuple[int, ...],
) -> Iterator[TagValue]:
    """Yield the value of a member that has `index`, usually a packed bit."""
    packed = _PACKED.fullmatch(member.at)
    host = kind.member(packed["host"]) if packed else None
    if packed and host is not None and not host.dims and isinstance(host.type, Elementary):
        count = count_of(dims)
        leaf = layout.leaf(f"{path}.{host.name}")
        yield _bit(layout, name, leaf, int(packed["bit"]), index * count, count if dims else 0)
    elif not dims:
        place = Resolver(layout).address(parse_address(name))
        if isinstance(place, Place) and place.fixed_index is not None:
            yield _value_at(layout, name, place)


def _value_at(layout: Layout, name: str, place: Place) -> TagValue:
    """Return the value of a place with fixed subscripts; the place can be a bit."""
    index = place.fixed_index
    assert index is not None
    if isinstance(place.bit, Constant):
        return _bit(layout, name, place.leaf, int(place.bit.value), index, 0)
    return _value(layout, name, place.leaf, index, 0)


def _bit(layout: Layout, name: str, leaf: Leaf, bit: int, start: int, length: int) -> TagValue:
    """Return a bit, or with a `length` an array of bits, in elements of a leaf from `start`."""
    source = _source(layout, leaf, start, length)
    if not length:
        return TagValue(name, "BOOL", 0, f"({source} >> {bit} & 1)")
    words = source.removeprefix("*")
    return TagValue(_array_name(layout, name), "BOOL", length, f"*[each >> {bit} & 1 for each in {words}]")


def source_of(layout: Layout, place: Place) -> str:
    """Return the expression that reads a place with fixed subscripts; the place can be in an image."""
    return _value_at(layout, place.text, place).source


def _value(layout: Layout, name: str, leaf: Leaf, start: int, length: int) -> TagValue:
    """Return an element of a leaf, or with a `length` an array of that many elements, from `start`."""
    return TagValue(_array_name(layout, name), leaf.type.name, length, _source(layout, leaf, start, length))


def _string_value(layout: Layout, path: str, name: str, index: int) -> TagValue:
    """Return a string; its source reads the length and the characters."""
    data = layout.leaf(f"{path}.DATA")
    capacity = data.dims[-1]
    characters = _source(layout, data, index * capacity, capacity).removeprefix("*")
    spot = layout.spot(data)
    if spot is not None and spot.view:
        characters += ".tolist()"  # a slice of a view changes with it
    return TagValue(name, TEXT, 0, f"{_source(layout, layout.leaf(f'{path}.LEN'), index, 0)}, {characters}")


def _source(layout: Layout, leaf: Leaf, start: int, length: int) -> str:
    """Return the expression that reads an element of a leaf, or with a `length` that many elements."""
    spot = layout.spot(leaf)
    if spot is not None:
        return _source_in_bytes(spot, start, length)
    if not leaf.dims:
        return leaf.ident
    if not length:
        return f"{leaf.ident}[{start}]"
    return f"*{leaf.ident}" if length == leaf.size else f"*{leaf.ident}[{start}:{start + length}]"


def _source_in_bytes(spot: Spot, start: int, length: int) -> str:
    """Return the expression that reads elements from bytes or a list that members share."""
    offsets = [spot.at(start + number) for number in range(length or 1)]
    if spot.unit == 1:
        bits = [f"{spot.variable}[{offset >> 3}] >> {offset & 7} & 1" for offset in offsets]
        return f"*({', '.join(bits)},)" if length else bits[0]
    if not length:
        return f"{spot.variable}[{offsets[0]}]"
    step = offsets[1] - offsets[0] if length > 1 else 1
    if offsets == list(range(offsets[0], offsets[0] + step * length, step)):
        return f"*{spot.variable}[{offsets[0]}:{offsets[-1] + 1}:{step}]"
    return f"*({', '.join(f'{spot.variable}[{offset}]' for offset in offsets)})"
