"""Tags as OPC UA objects and variables: a structure is an object, other tags are variables."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, islice, product
from math import prod
from typing import Any

from scanrack.io_images.enip.listing import BOOL, Kind, StructuredKind
from scanrack.io_images.enip.paths import PROGRAM

from .database import Database
from .index_ranges import MismatchError, NoDataError, runs
from .tag_snapshot import ReadBytes, WriteBytes, bits_to_write

VARIABLES_MOST = 20_000
"""Maximum number of variables on a server; tags beyond it are omitted."""

ELEMENTS_MOST = 100
"""Maximum length of an array that has a variable for each element."""

TEXT = "STRING"
"""Type name of a variable for LEN and DATA."""

_FORMS = {"SINT": "b", "INT": "h", "DINT": "i", "LINT": "q", "REAL": "f", "LREAL": "d"}
_FORMS |= {"USINT": "B", "UINT": "H", "UDINT": "I", "ULINT": "Q", "DWORD": "I"}


@dataclass(frozen=True)
class Variable:
    """A value or an array of a tag.

    Attributes:
        path: `Recipe.Steps[2].Time`.
        tag: index in the listing.
        offset: byte of the tag.
        bit: bit in the byte at `offset`; None = not a packed bit.
        writable: whether clients may write it.
    """

    path: str
    tag: int
    kind: Kind
    dims: tuple[int, ...]
    offset: int
    bit: int | None
    writable: bool

    @property
    def type_name(self) -> str:
        """`DINT`, `STRING`, ..."""
        return TEXT if isinstance(self.kind, StructuredKind) else self.kind.name

    @cached_property
    def count(self) -> int:
        """Number of values."""
        return prod(self.dims)

    @cached_property
    def size(self) -> int:
        """Number of bytes."""
        if self.kind == BOOL and self.dims:
            return 4 * -(-self.count // 32)
        return self.count * self.kind.size

    @property
    def reads(self) -> ReadBytes:
        """The operation that reads the variable."""
        return ReadBytes(self.tag, self.offset, self.size)

    def elements(self) -> Iterator[Leaf]:
        """Yield a variable for each element of an array, as `[1,2]`."""
        for number, indices in enumerate(product(*map(range, self.dims))):
            name = f"[{','.join(map(str, indices))}]"
            offset, bit = self.offset + number * self.kind.size, None
            if self.kind == BOOL:
                byte_number, bit = divmod((self.bit or 0) + number, 8)
                offset = self.offset + byte_number
            yield Leaf(name, replace(self, path=self.path + name, dims=(), offset=offset, bit=bit))

    def value_in(self, data: bytes) -> Any:
        """Return the value in bytes: a list for an array, nested lists for several dimensions."""
        values = self._values_in(data)
        return _nested(values, self.dims) if self.dims else values[0]

    def _values_in(self, data: bytes) -> list[Any]:
        """Return the values in bytes as a flat list."""
        if isinstance(self.kind, StructuredKind):
            step = self.kind.size
            return [_text_in(self.kind, data[offset : offset + step]) for offset in range(0, len(data), step)]
        if self.kind == BOOL:
            first_bit = self.bit or 0
            bits = int.from_bytes(data, "little") >> first_bit
            return [bool(bits >> index & 1) for index in range(self.count)]
        return list(struct.unpack(f"<{self.count}{_FORMS[self.kind.name]}", data))

    def change_to(self, value: Any) -> WriteBytes:
        """Return the operation that writes a value.

        Raises:
            ValueError: the array length differs, the text is too long, or a number does not fit.
            TypeError: the value has another type.
        """
        values = _flat(value, self.dims)
        if self.bit is not None:
            return self._write_of_run(0, values)
        return WriteBytes(self.tag, self.offset, self._bytes_of(values))

    def part_to(self, ranges: Sequence[range], value: Any, data: bytes) -> list[WriteBytes]:
        """Return the operations that write a part: array elements, or characters of texts.

        Args:
            ranges: the ranges of the part; see `index_ranges`.
            value: nested lists, or one flat list; for a single element, a list or the element.
            data: the present bytes; only characters within the present text can be written.

        Raises:
            NoDataError: an element or a character does not exist.
            MismatchError: the size of the value differs.
            ValueError: a number does not fit.
            TypeError: the value has another type.
        """
        is_text = isinstance(self.kind, StructuredKind)
        element_ranges, characters = (
            (ranges[:-1], ranges[-1]) if is_text and len(ranges) > len(self.dims) else (ranges, None)
        )
        element_runs = runs(element_ranges, self.dims)
        sizes = [len(element) for element in element_ranges]
        values_left = iter(_part_values(value, sizes))
        if characters is not None:
            numbers = chain.from_iterable(element_runs)
            return [
                self._write_of_characters(number, characters, next(values_left), data) for number in numbers
            ]
        return [self._write_of_run(run.start, list(islice(values_left, len(run)))) for run in element_runs]

    def _write_of_run(self, first: int, values: Sequence[Any]) -> WriteBytes:
        """Return the operation that writes successive elements."""
        if self.kind != BOOL:
            return WriteBytes(self.tag, self.offset + first * self.kind.size, self._bytes_of(values))
        return bits_to_write(self.tag, 8 * self.offset + (self.bit or 0) + first, values)

    def _write_of_characters(self, number: int, characters: range, value: Any, data: bytes) -> WriteBytes:
        """Return the operation that writes characters of a text; the text's length does not change."""
        kind = self.kind
        assert isinstance(kind, StructuredKind)
        present = _text_in(kind, data[number * kind.size : (number + 1) * kind.size])
        if characters.stop > len(present):
            raise NoDataError(f"{self.path} has {len(present)} characters")
        raw = _raw(value)
        if len(raw) != len(characters):
            raise MismatchError(f"{len(raw)} characters for {len(characters)}")
        offset = self.offset + number * kind.size + kind.by_name["DATA"].offset
        return WriteBytes(self.tag, offset + characters.start, raw)

    def _bytes_of(self, values: Sequence[Any]) -> bytes:
        """Return values as bytes; raise ValueError for a number or a text that does not fit."""
        if isinstance(self.kind, StructuredKind):
            return b"".join(_text_bytes(self.kind, value) for value in values)
        if self.kind == BOOL:
            bits = sum(bool(value) << index for index, value in enumerate(values))
            return bits.to_bytes(self.size, "little")
        try:
            return struct.pack(f"<{len(values)}{_FORMS[self.kind.name]}", *values)
        except (struct.error, OverflowError) as error:
            raise ValueError(f"{self.path} is {self.kind.name}: {error}") from error


def _part_values(value: Any, sizes: Sequence[int]) -> list[Any]:
    """Return the value of `Variable.part_to` as one list."""
    count = prod(sizes)
    if not isinstance(value, list):
        return [value] if count == 1 else _flat(value, sizes, MismatchError)
    is_flat = len(value) == count and not isinstance(value[0], list)
    return value if is_flat else _flat(value, sizes, MismatchError)


@dataclass(frozen=True)
class TagGroup:
    """A structure, or a program with its tags."""

    path: str
    name: str
    items: Callable[[], Iterator[Leaf | TagGroup]]


@dataclass(frozen=True)
class Leaf:
    """A variable with its name in a browser."""

    name: str
    variable: Variable


class TagTree:
    """The tags of a rack as a tree of objects and variables."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def roots(self) -> Iterator[Leaf | TagGroup]:
        """Yield the tags of the controller and the images, then the programs."""
        yield from self._items_in("")
        for program in self._database.listing.programs:
            name = f"{PROGRAM}{program}"
            yield TagGroup(name, name, lambda program=program: self._items_in(program.upper()))  # type: ignore[misc]

    @property
    def is_long(self) -> bool:
        """Whether the tree has more than `VARIABLES_MOST` variables."""
        return next(islice(variables_of(self.roots()), VARIABLES_MOST, None), None) is not None

    def _items_in(self, scope: str) -> Iterator[Leaf | TagGroup]:
        """Yield the tags of a scope as variables and groups, without aliases."""
        for symbol in self._database.scopes[scope]:
            if symbol.target:
                continue  # browsers show a tag once
            tag = symbol.tag
            location = _Location(symbol.index, tag.path, plain_path=tag.path, offset=0, bit=None)
            yield self._item(tag.name, location, tag.kind, tag.dims)

    def _item(self, name: str, location: _Location, kind: Kind, dims: tuple[int, ...]) -> Leaf | TagGroup:
        """Return a tag or a part as a variable, or a structure as a group that finds its items later."""
        if not isinstance(kind, StructuredKind) or _is_text(kind):
            writable = self._database.may_write(
                self._database.listing.tags[location.tag], location.plain_path, kind
            )
            return Leaf(
                name,
                Variable(location.path, location.tag, kind, dims, location.offset, location.bit, writable),
            )
        if dims:
            return TagGroup(location.path, name, lambda: self._elements(location, kind, dims))
        return TagGroup(location.path, name, lambda: self._members(location, kind))

    def _elements(
        self, location: _Location, kind: StructuredKind, dims: tuple[int, ...]
    ) -> Iterator[Leaf | TagGroup]:
        for number, indices in enumerate(product(*map(range, dims))):
            name = f"[{','.join(map(str, indices))}]"
            yield self._item(name, location.element(name, number * kind.size), kind, ())

    def _members(self, location: _Location, kind: StructuredKind) -> Iterator[Leaf | TagGroup]:
        for member in kind.by_name.values():
            yield self._item(
                member.name, location.member(member.name, member.offset, member.bit), member.kind, member.dims
            )


def variables_of(items: Iterator[Leaf | TagGroup]) -> Iterator[Variable]:
    """Yield all variables in a tree of items."""
    for item in items:
        if isinstance(item, Leaf):
            yield item.variable
        else:
            yield from variables_of(item.items())


@dataclass(frozen=True)
class _Location:
    """A place in the tags.

    Attributes:
        tag: index in the listing.
        offset: byte of the tag.
        bit: bit in the byte at `offset`; None = not a packed bit.
    """

    tag: int
    path: str
    plain_path: str  # without subscripts
    offset: int
    bit: int | None

    def element(self, name: str, offset: int) -> _Location:
        return _Location(self.tag, self.path + name, self.plain_path, self.offset + offset, None)

    def member(self, name: str, offset: int, bit: int | None) -> _Location:
        names = f"{self.path}.{name}", f"{self.plain_path}.{name}"
        return _Location(self.tag, *names, self.offset + offset, bit)


def _is_text(kind: StructuredKind) -> bool:
    """Return whether a structure consists of LEN and DATA."""
    return list(kind.by_name) == ["LEN", "DATA"] and kind.by_name["DATA"].kind.size == 1


def _text_in(kind: StructuredKind, data: bytes) -> str:
    """Return the text in the bytes of a structure; its length is LEN, but at most the size of DATA."""
    length, text = kind.by_name["LEN"], kind.by_name["DATA"]
    stated_length = int.from_bytes(
        data[length.offset : length.offset + length.kind.size], "little", signed=True
    )
    capacity = prod(text.dims)
    return data[text.offset : text.offset + min(max(stated_length, 0), capacity)].decode("latin-1")


def _text_bytes(kind: StructuredKind, value: Any) -> bytes:
    """Return the bytes of a structure that contains a text; raise ValueError for a text too long."""
    length, text = kind.by_name["LEN"], kind.by_name["DATA"]
    raw, capacity = _raw(value), prod(text.dims)
    if len(raw) > capacity:
        raise ValueError(f"the text has {len(raw)} characters; {capacity} fit")
    text_value = bytearray(kind.size)
    text_value[length.offset : length.offset + length.kind.size] = len(raw).to_bytes(
        length.kind.size, "little"
    )
    text_value[text.offset : text.offset + len(raw)] = raw
    return bytes(text_value)


def _raw(value: Any) -> bytes:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not a text")
    return value.encode("latin-1")


def _nested(values: list[Any], dims: Sequence[int]) -> list[Any]:
    for size in reversed(dims[1:]):
        values = [values[index : index + size] for index in range(0, len(values), size)]
    return values


def _flat(value: Any, dims: Sequence[int], error: type[ValueError] = ValueError) -> list[Any]:
    """Return values in memory order; raise `error` if the dimensions differ."""
    values = [value]
    for size in dims:
        if not all(isinstance(nested_value, list) and len(nested_value) == size for nested_value in values):
            raise error(f"the array has {' x '.join(map(str, dims))} elements")
        values = list(chain.from_iterable(values))
    return values
