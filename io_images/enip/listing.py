"""The tags of a server, with their types and byte offsets, as clients see them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from functools import cached_property
from math import prod

from ..dataclass import dataclass
from .codes import TYPE_CODES
from .paths import PROGRAM

_BYTES = {"BOOL": 1, "SINT": 1, "INT": 2, "DINT": 4, "LINT": 8, "USINT": 1, "UINT": 2, "UDINT": 4}
_BYTES |= {"ULINT": 8, "REAL": 4, "LREAL": 8, "DWORD": 4}


@dataclass(frozen=True)
class PlainKind:
    """An elementary type."""

    name: str
    size: int  # bytes
    code: int

    @cached_property
    def bits(self) -> int:
        """Number of addressable bits; 0 unless it is an integer."""
        return 0 if self.name in ("BOOL", "REAL", "LREAL") else 8 * self.size


PLAIN: Mapping[str, PlainKind] = {name: PlainKind(name, _BYTES[name], TYPE_CODES[name]) for name in _BYTES}
"""The elementary types by name."""

BOOL, DWORD, SINT, INT, DINT = (PLAIN[name] for name in ("BOOL", "DWORD", "SINT", "INT", "DINT"))


@dataclass(frozen=True)
class Part:
    """A member of a structure."""

    name: str
    kind: Kind
    dims: tuple[int, ...]
    offset: int  # byte
    bit: int | None = None  # bit in that byte, for a BOOL
    hidden: bool = False  # whether it is a host of packed bits, which no path names


@dataclass(frozen=True)
class StructuredKind:
    """A structure; structures with equal fields are equal."""

    name: str
    size: int  # bytes
    parts: tuple[Part, ...]

    @cached_property
    def by_name(self) -> Mapping[str, Part]:
        """The members that paths may name, by uppercase name."""
        return {member.name.upper(): member for member in self.parts if not member.hidden}


Kind = PlainKind | StructuredKind


class ExternalAccess(StrEnum):
    """How clients may access a tag [1756-PM004, External Access]; the values are as in an L5X file."""

    READ_WRITE = "Read/Write"
    READ_ONLY = "Read Only"
    NONE = "None"


@dataclass(frozen=True)
class ListedTag:
    """A tag."""

    name: str  # without its program
    program: str  # "" for the controller
    kind: Kind
    dims: tuple[int, ...] = ()
    access: ExternalAccess = ExternalAccess.READ_WRITE
    comment: str = ""

    @property
    def full_name(self) -> str:
        r"""Its name in the rack: `Run`, `\Main.Run`."""
        return rf"\{self.program}.{self.name}" if self.program else self.name

    @property
    def path(self) -> str:
        """The name that clients use: `Run`, `Program:Main.Run`."""
        return f"{PROGRAM}{self.program}.{self.name}" if self.program else self.name

    @property
    def is_bits(self) -> bool:
        """Whether the tag is an array of BOOLs, which clients see as DWORDs."""
        return self.kind == BOOL and bool(self.dims)

    @cached_property
    def element(self) -> int:
        """Size of an element, bytes."""
        return DWORD.size if self.is_bits else self.kind.size

    @cached_property
    def count(self) -> int:
        """Number of elements."""
        return -(-prod(self.dims) // 32) if self.is_bits else prod(self.dims)

    @cached_property
    def size(self) -> int:
        """Size of the tag, bytes."""
        return self.element * self.count


def part_at(tag: ListedTag, offset: int, size: int, keep: bytes = b"", *, files: bool = False) -> str:
    """Return the smallest part of a tag that contains some bytes: `.Steps[2].Time`, `[3]`, `.5`.

    "" is the whole tag. If the bytes span several elements or members, the part is the array or structure
    that contains them.

    Args:
        offset: offset of the bytes in the tag.
        size: number of bytes.
        keep: mask of the bits in these bytes to ignore; b"" to ignore none.
        files: whether the tag is a data file, with parts such as `:3`, `:3/5`, `:0.PRE`, or `.0` of an image.
    """
    kind, dims = _in_words(tag.kind, tag.dims)
    path = ""
    mask = int.from_bytes(keep or bytes(size), "little") ^ (1 << 8 * size) - 1  # of bits that count
    is_bit = mask.bit_count() == 1
    while True:
        if dims:
            number, byte_offset = divmod(offset, kind.size)
            if byte_offset + size > kind.size or (kind == DWORD and not is_bit):
                return path
            if kind == DWORD:
                return f"{path}[{32 * number + _bit(mask, byte_offset)}]"
            path += _numbered(tag, number) if files else _subscripts(number, dims)
            offset, dims = byte_offset, ()
        elif isinstance(kind, StructuredKind):
            part = _part_with(kind, offset, size, mask)
            if part is None:
                return path
            path += f".{part.name}"
            kind, dims = _in_words(part.kind, part.dims)
            offset -= part.offset
            if part.bit is not None:
                return path
        elif is_bit and kind.bits:
            return f"{path}{'/' if files else '.'}{_bit(mask, offset)}"
        else:
            return path


def _numbered(tag: ListedTag, number: int) -> str:
    """Return the text for an element of a data file or a word of an image."""
    return f".{number}" if ":" in tag.name else f":{number}"


def _subscripts(number: int, dims: Sequence[int]) -> str:
    """Return the subscripts of an element from its number in memory order."""
    indexes: list[int] = []
    for length in reversed(dims):
        number, index = divmod(number, length)
        indexes.insert(0, index)
    return f"[{','.join(map(str, indexes))}]"


def _bit(mask: int, offset: int) -> int:
    """Return the number of the only bit in a mask that begins at a byte offset."""
    return 8 * offset + mask.bit_length() - 1


def _part_with(kind: StructuredKind, offset: int, size: int, mask: int) -> Part | None:
    """Return the member that contains some bytes of a structure; None if they are in several members."""
    for part in kind.by_name.values():
        if part.bit is not None:
            if mask.bit_count() == 1 and _bit(mask, offset) == 8 * part.offset + part.bit:
                return part
            continue
        element, dims = _in_words(part.kind, part.dims)
        if part.offset <= offset and offset + size <= part.offset + element.size * prod(dims):
            return part
    return None


def _in_words(kind: Kind, dims: tuple[int, ...]) -> tuple[Kind, tuple[int, ...]]:
    """Return type and dimensions as clients see them: an array of BOOLs appears as an array of words."""
    return (DWORD, (-(-prod(dims) // 32),)) if kind == BOOL and dims else (kind, dims)


@dataclass(frozen=True)
class ListedAlias:
    """A second name for a tag or a part of a tag."""

    name: str  # without its program
    program: str  # "" for the controller
    target: str  # `Recipe.Steps[2].Time`, `Program:Main.Step`, `Local:1:I.Data[0].3`
    comment: str = ""


@dataclass(frozen=True)
class Listing:
    """All tags of a server.

    Attributes:
        files: whether the tags are data files of an SLC 500 or MicroLogix.
    """

    tags: tuple[ListedTag, ...]
    files: bool = False
    aliases: tuple[ListedAlias, ...] = ()

    @property
    def programs(self) -> Iterator[str]:
        """Programs with their own tags, in order."""
        owners = [tag.program for tag in self.tags] + [alias.program for alias in self.aliases]
        return iter(dict.fromkeys(filter(None, owners)))


def patched(old: bytes, data: bytes, keep: bytes) -> bytes:
    r"""Return `data`, with the bits in the mask `keep` taken from `old`.

    >>> patched(b"\x0f", b"\x80", b"\x7f").hex()
    '8f'
    """
    if not keep:
        return data
    old_bits, new_bits, mask = (int.from_bytes(part, "little") for part in (old, data, keep))
    return (new_bits & ~mask | old_bits & mask).to_bytes(len(data), "little")
