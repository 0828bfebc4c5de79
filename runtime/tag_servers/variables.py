"""Tags as objects and variables, for OPC UA: a structure is an object, everything else a variable."""

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
"""Maximum variables that a server shows; the tags after them are left out."""

ELEMENTS_MOST = 100
"""Maximum length of an array whose elements are also shown as variables."""

TEXT = "STRING"
"""Type name of a variable that stands for LEN and DATA."""

_FORMS = {"SINT": "b", "INT": "h", "DINT": "i", "LINT": "q", "REAL": "f", "LREAL": "d"}
_FORMS |= {"USINT": "B", "UINT": "H", "UDINT": "I", "ULINT": "Q", "DWORD": "I"}


@dataclass(frozen=True)
class Variable:
    """A value of a tag, or an array of them.

    Attributes:
        path: its name: `Recipe.Steps[2].Time`.
        tag: index in the listing.
        offset: byte of the tag.
        bit: bit of that byte; None = it is not a packed bit.
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
        """Bytes."""
        if self.kind == BOOL and self.dims:
            return 4 * -(-self.count // 32)
        return self.count * self.kind.size

    @property
    def reads(self) -> ReadBytes:
        """The read operation for its bytes."""
        return ReadBytes(self.tag, self.offset, self.size)

    def elements(self) -> Iterator[Leaf]:
        """Yield a variable for each element of an array, as `[1,2]`."""
        for number, indices in enumerate(product(*map(range, self.dims))):
            name = f"[{','.join(map(str, indices))}]"
            offset, bit = self.offset + number * self.kind.size, None
            if self.kind == BOOL:
                places, bit = divmod((self.bit or 0) + number, 8)
                offset = self.offset + places
            yield Leaf(name, replace(self, path=self.path + name, dims=(), offset=offset, bit=bit))

    def value_in(self, data: bytes) -> Any:
        """Return the value in bytes; arrays as lists, of several dimensions as lists of lists."""
        values = self._values_in(data)
        return _nested(values, self.dims) if self.dims else values[0]

    def _values_in(self, data: bytes) -> list[Any]:
        if isinstance(self.kind, StructuredKind):
            step = self.kind.size
            return [_text_in(self.kind, data[offset : offset + step]) for offset in range(0, len(data), step)]
        if self.kind == BOOL:
            first_bit = self.bit or 0
            bits = int.from_bytes(data, "little") >> first_bit
            return [bool(bits >> index & 1) for index in range(self.count)]
        return list(struct.unpack(f"<{self.count}{_FORMS[self.kind.name]}", data))

    def change_to(self, value: Any) -> WriteBytes:
        """Return the write of a value.

        Raises:
            ValueError: the array has another length, the text is too long, or a number does not fit.
            TypeError: the value has another type.
        """
        values = _flat(value, self.dims)
        if self.bit is not None:
            return self._run(0, values)
        return WriteBytes(self.tag, self.offset, self._bytes_of(values))

    def part_to(self, ranges: Sequence[range], value: Any, data: bytes) -> list[WriteBytes]:
        """Return the writes of a part: elements of an array, or characters of texts.

        Args:
            ranges: the ranges of the part, see `index_ranges`.
            value: nested lists, or one flat list; a single element also without a list.
            data: the present bytes; characters are written within the length of a text.

        Raises:
            NoDataError: an element or a character does not exist.
            MismatchError: the value has another size.
            ValueError: a number that does not fit.
            TypeError: the value has another type.
        """
        is_text = isinstance(self.kind, StructuredKind)
        elements, characters = (
            (ranges[:-1], ranges[-1]) if is_text and len(ranges) > len(self.dims) else (ranges, None)
        )
        places = runs(elements, self.dims)
        sizes = [len(element) for element in elements]
        values_taken = iter(_part_values(value, sizes))
        if characters is not None:
            numbers = chain.from_iterable(places)
            return [self._characters(number, characters, next(values_taken), data) for number in numbers]
        return [self._run(span.start, list(islice(values_taken, len(span)))) for span in places]

    def _run(self, first: int, values: Sequence[Any]) -> WriteBytes:
        """Return the write of successive elements."""
        if self.kind != BOOL:
            return WriteBytes(self.tag, self.offset + first * self.kind.size, self._bytes_of(values))
        return bits_to_write(self.tag, 8 * self.offset + (self.bit or 0) + first, values)

    def _characters(self, number: int, places: range, value: Any, data: bytes) -> WriteBytes:
        """Return the write of characters of a text, which keeps its length."""
        kind = self.kind
        assert isinstance(kind, StructuredKind)
        present = _text_in(kind, data[number * kind.size : (number + 1) * kind.size])
        if places.stop > len(present):
            raise NoDataError(f"{self.path} has {len(present)} characters")
        raw = _raw(value)
        if len(raw) != len(places):
            raise MismatchError(f"{len(raw)} characters for {len(places)}")
        offset = self.offset + number * kind.size + kind.by_name["DATA"].offset
        return WriteBytes(self.tag, offset + places.start, raw)

    def _bytes_of(self, values: Sequence[Any]) -> bytes:
        if isinstance(self.kind, StructuredKind):
            return b"".join(_text_bytes(self.kind, value) for value in values)
        if self.kind == BOOL:
            return sum(bool(value) << index for index, value in enumerate(values)).to_bytes(
                self.size, "little"
            )
        try:
            return struct.pack(f"<{len(values)}{_FORMS[self.kind.name]}", *values)
        except (struct.error, OverflowError) as error:
            raise ValueError(f"{self.path} is {self.kind.name}: {error}") from error


def _part_values(value: Any, sizes: Sequence[int]) -> list[Any]:
    """Return the values of a part in one list, see `Variable.part_to`."""
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
    """A variable under the name that a browser shows."""

    name: str
    variable: Variable


class TagTree:
    """The tags of a rack, as a browser shows them."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def roots(self) -> Iterator[Leaf | TagGroup]:
        """Yield the tags of the controller and the images, then the programs."""
        yield from self._scope("")
        for program in self._database.listing.programs:
            name = f"{PROGRAM}{program}"
            yield TagGroup(name, name, lambda program=program: self._scope(program.upper()))  # type: ignore[misc]

    @property
    def is_long(self) -> bool:
        """Whether the tree has more variables than a server shows."""
        return next(islice(variables_of(self.roots()), VARIABLES_MOST, None), None) is not None

    def _scope(self, scope: str) -> Iterator[Leaf | TagGroup]:
        for symbol in self._database.scopes[scope]:
            if symbol.target:
                continue  # browsers show a tag once
            tag = symbol.tag
            base = _Place(symbol.index, tag.path, tag.path, 0, None)
            yield self._item(tag.name, base, tag.kind, tag.dims)

    def _item(self, name: str, at: _Place, kind: Kind, dims: tuple[int, ...]) -> Leaf | TagGroup:
        if not isinstance(kind, StructuredKind) or _is_text(kind):
            writable = self._database.may_write(self._database.listing.tags[at.tag], at.plain, kind)
            return Leaf(name, Variable(at.path, at.tag, kind, dims, at.offset, at.bit, writable))
        if dims:
            return TagGroup(at.path, name, lambda: self._elements(at, kind, dims))
        return TagGroup(at.path, name, lambda: self._members(at, kind))

    def _elements(self, at: _Place, kind: StructuredKind, dims: tuple[int, ...]) -> Iterator[Leaf | TagGroup]:
        for number, indices in enumerate(product(*map(range, dims))):
            name = f"[{','.join(map(str, indices))}]"
            yield self._item(name, at.element(name, number * kind.size), kind, ())

    def _members(self, at: _Place, kind: StructuredKind) -> Iterator[Leaf | TagGroup]:
        for member in kind.by_name.values():
            yield self._item(
                member.name, at.member(member.name, member.offset, member.bit), member.kind, member.dims
            )


def variables_of(items: Iterator[Leaf | TagGroup]) -> Iterator[Variable]:
    """Yield all variables below items."""
    for item in items:
        if isinstance(item, Leaf):
            yield item.variable
        else:
            yield from variables_of(item.items())


@dataclass(frozen=True)
class _Place:
    tag: int
    path: str
    plain: str  # without subscripts
    offset: int
    bit: int | None

    def element(self, name: str, offset: int) -> _Place:
        return _Place(self.tag, self.path + name, self.plain, self.offset + offset, None)

    def member(self, name: str, offset: int, bit: int | None) -> _Place:
        names = f"{self.path}.{name}", f"{self.plain}.{name}"
        return _Place(self.tag, *names, self.offset + offset, bit)


def _is_text(kind: StructuredKind) -> bool:
    """Whether a structure is LEN and DATA."""
    return list(kind.by_name) == ["LEN", "DATA"] and kind.by_name["DATA"].kind.size == 1


def _text_in(kind: StructuredKind, data: bytes) -> str:
    length, text = kind.by_name["LEN"], kind.by_name["DATA"]
    length_stated = int.from_bytes(
        data[length.offset : length.offset + length.kind.size], "little", signed=True
    )
    capacity = prod(text.dims)
    return data[text.offset : text.offset + min(max(length_stated, 0), capacity)].decode("latin-1")


def _text_bytes(kind: StructuredKind, value: Any) -> bytes:
    length, text = kind.by_name["LEN"], kind.by_name["DATA"]
    raw, capacity = _raw(value), prod(text.dims)
    if len(raw) > capacity:
        raise ValueError(f"a text of {len(raw)} characters: {capacity} fit")
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
    """Return values in the order of memory; raise `error` if the dimensions differ."""
    values = [value]
    for size in dims:
        if not all(isinstance(nested_value, list) and len(nested_value) == size for nested_value in values):
            raise error(f"the array has {' x '.join(map(str, dims))} elements")
        values = list(chain.from_iterable(values))
    return values
