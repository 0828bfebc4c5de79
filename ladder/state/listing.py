"""The tags that a server lists for its clients, and their types."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

from scanrack.io_images.enip.listing import DINT as DOUBLE
from scanrack.io_images.enip.listing import INT as WORD
from scanrack.io_images.enip.listing import (
    PLAIN,
    SINT,
    Kind,
    ListedAlias,
    ListedTag,
    Listing,
    Part,
    StructuredKind,
)

from ..model.tags import Alias, Layout, Tag, program_of
from ..model.tree import Address
from ..model.types import (
    BOOL,
    DataType,
    Elementary,
    Member,
    Structure,
    count_of,
    members_at,
    size_of,
)
from .named_parts import alias_place

MOST_ALIASES = 20
"""Maximum number of aliases in a chain."""

_HOST = "ZZZZZZZZZZ"
"""Name prefix for a byte that hosts BOOLs, as in Logix Designer."""

Places = Mapping[str, tuple[int, int | None]]
"""Byte and bit of members by name, in capitals."""


def listing_of(layout: Layout) -> Listing:
    """Return the tags of a program, in the order of its layout, and the aliases of a Logix controller."""
    aliases = () if layout.files else tuple(_aliases(layout))
    return Listing(tuple(_listed(layout)), layout.files, aliases)


def _listed(layout: Layout) -> Iterator[ListedTag]:
    """Yield each tag, with its name in its program."""
    for tag in layout.tags().values():
        program = program_of(tag.name)
        name = tag.name[len(program) + 2 :] if program else tag.name
        yield ListedTag(name, program, kind_of(tag.type), tag.dims, tag.access, tag.comment)


def _aliases(layout: Layout) -> Iterator[ListedAlias]:
    """Yield the aliases with a constant address; their targets are not aliases."""
    for declaration in layout.declarations.values():
        if isinstance(declaration, Alias) and declaration.type is None:
            program, target = program_of(declaration.name), _without_aliases(layout, declaration)
            if target is not None:
                name = declaration.name[len(program) + 2 :] if program else declaration.name
                yield ListedAlias(name, program, target, declaration.comment)


def _without_aliases(layout: Layout, alias: Alias) -> str | None:
    """Return the address at the end of a chain of aliases; None if it does not end at a tag or a module."""
    target, scope = alias.target, program_of(alias.name)
    for _ in range(MOST_ALIASES):
        declaration = layout.declaration(target.name.upper(), scope)
        if isinstance(declaration, Alias) and declaration.type is None:
            target, scope = (
                Address(declaration.target.name, declaration.target.steps + target.steps),
                program_of(declaration.name),
            )
        elif isinstance(declaration, Tag):
            return str(Address(declaration.name, target.steps))
        else:
            return str(target) if declaration is None else None  # an address of a module
    return None


@lru_cache(maxsize=1024)
def kind_of(kind: DataType) -> Kind:
    """Return a type in the form that is sent to clients."""
    if isinstance(kind, Elementary):
        return PLAIN[kind.name]
    places = {member.name.upper(): (offset, bit) for member, offset, bit in members_at(kind)}
    parts = (*_control_word(kind), *_parts(kind, places))
    return StructuredKind(kind.name, size_of(kind), parts)


def _control_word(kind: Structure) -> Iterator[Part]:
    """Yield the word of a predefined structure's status bits."""
    bits = [member.bit for member in kind.members if member.bit is not None]
    if bits:
        yield Part("CTL", DOUBLE if max(bits) > 15 else WORD, (), 0, hidden=True)


def _parts(kind: Structure, places: Places) -> Iterator[Part]:
    """Yield the members of a structure; before the first BOOL in a byte, a hidden member for that byte."""
    hosts: set[int] = set()
    for member in kind.members:
        if member.at:
            yield _alias_part(kind, member)
            continue
        offset, bit = places[member.name.upper()]
        if bit is not None and member.bit is None and offset not in hosts:
            hosts.add(offset)
            yield Part(f"{_HOST}{kind.name[:20]}{len(hosts)}", SINT, (), offset, hidden=True)
        yield Part(member.name, kind_of(member.type), member.dims, offset, bit, member.hidden)


def _alias_part(kind: Structure, member: Member) -> Part:
    """Return a member that is an alias of a part of another member, such as a packed bit or `Delay.PRE`."""
    target_type, dims, first_bit = alias_place(kind, member)
    bit = first_bit % 8 if target_type is BOOL and not dims else None
    return Part(member.name, kind_of(target_type), dims, first_bit // 8, bit)


def string_capacities(kind: DataType, dims: tuple[int, ...] = ()) -> Iterator[tuple[int, int]]:
    """Yield, for each STRING in one element, the byte of its LEN and its maximum number of characters."""
    if not isinstance(kind, Structure):
        return
    if kind.is_string:
        yield 0, kind.members[1].dims[0]
        return
    for member, offset, _ in members_at(kind):
        size = size_of(member.type) if member.type is not BOOL else 0
        for string_offset, capacity in tuple(string_capacities(member.type)):
            for number in range(count_of(member.dims)):
                yield offset + number * size + string_offset, capacity
