"""Structures in the template object, with members and offsets followed by names [1756-PM020]."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from functools import cached_property
from math import prod

from scanrack.io_images.enip.codes import TYPE_CODES
from scanrack.io_images.enip.listing import BOOL, Kind, Part, PlainKind, StructuredKind

NUMBERS: Mapping[str, int] = {"TIMER": 0xF83, "COUNTER": 0xF82, "CONTROL": 0xF81, "STRING": 0xFCE}
"""Fixed instance numbers of a controller's built-in structures."""

SHOWN: Mapping[str, str] = {"STRING": "ASCIISTRING82"}
"""Names that a controller shows for structures."""

FIRST = 0x100
"""Instance number of the first structure without a fixed number."""

ARRAY, STRUCTURE = 0x2000, 0x8000
"""Bits of a type code."""


class Template:
    """A structure and its instance number."""

    def __init__(self, kind: StructuredKind, number: int, templates: Templates) -> None:
        self.kind, self.number, self._templates = kind, number, templates

    @cached_property
    def definition(self) -> bytes:
        """Members, eight bytes each; then the name with two letters per member; then the members' names."""
        members = self.kind.parts
        scope = "".join("E@" if member.hidden else "EC" for member in members)
        names = [
            f"{SHOWN.get(self.kind.name, self.kind.name)};n{scope}",
            *(member.name for member in members),
        ]
        text = b"".join(name.encode("ascii", "replace") + b"\0" for name in names)
        return b"".join(map(self._member, members)) + text

    def _member(self, part: Part) -> bytes:
        """Return the eight bytes of a member: its array length or bit number, type code and offset."""
        if part.kind == BOOL and not part.dims:
            return struct.pack("<HHI", part.bit or 0, TYPE_CODES["BOOL"], part.offset)
        count, code = prod(part.dims) if part.dims else 0, self._templates.code_of(part.kind)
        if part.kind == BOOL:
            count, code = -(-count // 32), TYPE_CODES["DWORD"]
        return struct.pack("<HHI", count, code | (ARRAY if part.dims else 0), part.offset)

    @property
    def words(self) -> int:
        """Attribute 4: number of 32-bit words in the definition; clients subtract 20 to 23 bytes."""
        return -(-(len(self.definition) + 23) // 4)

    @cached_property
    def padded(self) -> bytes:
        """The definition, padded to the length that clients read."""
        return self.definition.ljust(self.words * 4 - 20, b"\0")

    @cached_property
    def handle(self) -> int:
        """Number that identifies the structure in messages."""
        return NUMBERS.get(self.kind.name) or zlib.crc32(self.definition) & 0xFFFF


class Templates:
    """The structures of a listing, by number."""

    def __init__(self) -> None:
        self._by_kind: dict[StructuredKind, Template] = {}
        self.by_number: dict[int, Template] = {}

    def template_of(self, kind: StructuredKind) -> Template:
        """Return the template of a structure; add templates for the structures that it contains."""
        template = self._by_kind.get(kind)
        if template is None:
            number = NUMBERS.get(kind.name, 0)
            if not number or number in self.by_number:
                number = FIRST + len(self.by_number)
            template = self._by_kind[kind] = self.by_number[number] = Template(kind, number, self)
            for member in kind.parts:
                self.code_of(member.kind)
        return template

    def code_of(self, kind: Kind) -> int:
        """Return the code of a type in a listing."""
        return kind.code if isinstance(kind, PlainKind) else STRUCTURE | self.template_of(kind).number
