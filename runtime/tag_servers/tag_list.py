"""The list of tags for HMI projects: each value with its type and its address in every protocol.

name         type  access      Modbus              OPC UA              EtherNet/IP
HmiLength    DINT  read/write  holding register 0  ns=2;s=HmiLength    HmiLength
Strokes.ACC  DINT  read only   input register 2    ns=2;s=Strokes.ACC  Strokes.ACC
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from math import prod

from scanrack.io_images.enip.listing import BOOL, DWORD, PLAIN
from scanrack.io_images.enip.paths import PathStep

from ..config.server_table import ModbusTable
from .database import Database, Symbol, Target
from .mapped_tags import ADDRESSES, COILS, DISCRETE_INPUTS, HOLDING_REGISTERS, INPUT_REGISTERS, TABLES
from .tag_paths import target_of
from .variables import TagTree, Variable, variables_of

NAMESPACE_INDEX = 2
"""Index of the tags' namespace on the OPC UA server."""

SINGULAR: Mapping[str, str] = {
    COILS: "coil",
    DISCRETE_INPUTS: "discrete input",
    INPUT_REGISTERS: "input register",
    HOLDING_REGISTERS: "holding register",
}

_ELEMENT = re.compile(r"(?P<file>[A-Z]{1,2}\d*)\[(?P<number>\d+)\]", re.IGNORECASE)

MapAddresses = dict[str, str]
"""Tag names in the rack file, by Modbus address, as `coil 0`."""

Span = tuple[int, int, int]
"""Range of bits in a tag: tag number, first bit, number of bits."""


@dataclass(frozen=True)
class TagRow:
    """A value or an array.

    Attributes:
        name: `Recipe.Steps[2].Time`, `Program:Main.Step`.
        type_name: type of an element: `DINT`, `STRING`, ...
        dims: dimensions; empty for a single value.
        writable: whether clients may write the tag.
        description: comment of the tag.
        node: identifier of its OPC UA node; "" for a tag without a node.
        enip: its EtherNet/IP name; in a program with data files, this is an address.
        in_files: whether `enip` is an address in a data file.
        modbus: its addresses in the map of the rack file, as `coil 0`.
    """

    name: str
    type_name: str
    dims: tuple[int, ...]
    writable: bool
    description: str
    node: str
    enip: str
    in_files: bool = False
    modbus: tuple[str, ...] = ()

    @property
    def type(self) -> str:
        """Type with dimensions, such as `DINT` or `INT[3,4]`."""
        return f"{self.type_name}[{','.join(map(str, self.dims))}]" if self.dims else self.type_name

    @property
    def access(self) -> str:
        """Client access, `read/write` or `read only`."""
        return "read/write" if self.writable else "read only"

    def elements(self) -> Iterator[TagRow]:
        """Yield a row for each element of an array; only the array has Modbus addresses."""
        for indices in product(*map(range, self.dims)):
            subscript = f"[{','.join(map(str, indices))}]"
            name, node = self.name + subscript, self.node and self.node + subscript
            enip = file_address(name) if self.in_files else name
            yield replace(self, name=name, dims=(), node=node, enip=enip, modbus=())


def tag_rows(database: Database, table: ModbusTable | None = None) -> Iterator[TagRow]:
    """Yield a row for each value and array, for each alias, and for parts of tags in the Modbus map.

    Raises:
        ValueError: the map names a tag that does not exist.
    """
    addresses_by_span = _addresses_by_span(database, table)
    tags = database.listing.tags
    for variable in variables_of(TagTree(database).roots()):
        yield _variable_row(
            variable,
            database,
            tags[variable.tag].comment,
            addresses_by_span.pop(_variable_span(variable), {}),
        )
    for symbol in chain.from_iterable(database.scopes.values()):
        if symbol.target:
            target = database.resolve(symbol.target)
            yield _alias_row(symbol, target, database, addresses_by_span.pop(_target_span(target), {}))
    for addresses in addresses_by_span.values():
        tag_name = next(iter(addresses.values()))
        yield _part_row(tag_name, target_of(database, tag_name), database, addresses)


def _variable_row(variable: Variable, database: Database, comment: str, addresses: MapAddresses) -> TagRow:
    """Return the row of an OPC UA variable, with its node and its Modbus addresses."""
    is_file = database.listing.files
    return TagRow(
        variable.path,
        variable.type_name,
        variable.dims,
        variable.writable,
        description=comment,
        node=f"ns={NAMESPACE_INDEX};s={variable.path}",
        enip=file_address(variable.path) if is_file else variable.path,
        in_files=is_file,
        modbus=tuple(addresses),
    )


def _alias_row(symbol: Symbol, target: Target, database: Database, addresses: MapAddresses) -> TagRow:
    """Return the row of an alias; it has no OPC UA node, because browsers show a tag once."""
    tag = symbol.tag
    writable = database.may_write(target.tag, target.name, target.kind)
    comment = tag.comment or f"alias of {_text_of(symbol.target)}"
    return TagRow(
        tag.path,
        tag.kind.name,
        tag.dims,
        writable,
        description=comment,
        node="",
        enip=tag.path,
        modbus=tuple(addresses),
    )


def _part_row(tag_name: str, target: Target, database: Database, addresses: MapAddresses) -> TagRow:
    """Return the row of part of a tag, such as a bit, that only the Modbus map names."""
    writable = database.may_write(target.tag, target.name, target.kind)
    dims = (target.count,) if target.count > 1 else ()
    return TagRow(
        tag_name,
        target.kind.name,
        dims,
        writable,
        description=target.tag.comment,
        node="",
        enip=tag_name,
        in_files=database.listing.files,
        modbus=tuple(addresses),
    )


def _text_of(steps: Sequence[PathStep]) -> str:
    """Return path steps as text."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)[1:]


def _addresses_by_span(database: Database, table: ModbusTable | None) -> dict[Span, MapAddresses]:
    """Return the Modbus addresses in a map, by the tag bits that they contain."""
    addresses_by_span: dict[Span, MapAddresses] = {}
    for name in TABLES if table is not None else ():
        for row in getattr(table, name):
            span = _target_span(target_of(database, row.tag))
            addresses_by_span.setdefault(span, {})[f"{SINGULAR[name]} {row.address}"] = row.tag
    return addresses_by_span


def _variable_span(variable: Variable) -> Span:
    bits = 1 if variable.bit is not None and not variable.dims else 8 * variable.size
    return variable.tag, 8 * variable.offset + (variable.bit or 0), bits


def _target_span(target: Target) -> Span:
    bits = 1 if target.bit is not None else 8 * target.kind.size * target.count
    return target.symbol.index, 8 * target.offset + (target.bit or 0), bits


def file_address(path: str) -> str:
    """Return a data file path in the notation of SLC and MicroLogix.

    >>> file_address("N7[3]"), file_address("T4[0].PRE"), file_address("I:1[2]"), file_address("N7")
    ('N7:3', 'T4:0.PRE', 'I:1.2', 'N7')
    """
    image = re.fullmatch(r"([IO]:\d+)\[(\d+)\]", path, re.IGNORECASE)
    if image is not None:
        return f"{image[1]}.{image[2]}"
    return _ELEMENT.sub(lambda match: f"{match['file']}:{match['number']}", path, count=1)


# --- a first map


def first_map(rows: Iterable[TagRow], patterns: Sequence[str]) -> tuple[str, list[str]]:
    """Return tables `[server]` and `[server.modbus]` for a rack file, with a row for each value.

    Writable values become coils and holding registers, and the rest become discrete inputs and input
    registers.

    Args:
        patterns: tags that clients may write.

    Returns:
        The tables, and the names of values without a Modbus address: texts, and values beyond the last
            address.
    """
    tables: dict[str, list[str]] = {name: [] for name in TABLES}
    free_addresses, left_out = dict.fromkeys(TABLES, 0), []
    for row in rows:
        # an image is mapped word by word, since `I:1` would be word 1 of file I
        elements = row.elements() if row.in_files and ":" in row.name and row.dims else [row]
        assigned = [_assign_addresses(element, tables, free_addresses) for element in elements]
        if not all(assigned):
            left_out.append(row.name)
    return _toml_of(tables, patterns), left_out


def _toml_of(tables: Mapping[str, Sequence[str]], patterns: Sequence[str]) -> str:
    """Return the tables as text of a rack file; a Modbus table without entries is omitted."""
    pattern_list = ", ".join(f'"{pattern}"' for pattern in patterns)
    lines = ["[server]", f"writable = [{pattern_list}]    # tags that clients may write"]
    lines += ["", "[server.modbus]"]
    for name, entries in tables.items():
        lines += [f"{name} = [", *(f"    {entry}," for entry in entries), "]"] if entries else []
    return "\n".join(lines) + "\n"


def _assign_addresses(row: TagRow, tables: dict[str, list[str]], free: dict[str, int]) -> bool:
    """Assign the next addresses of its table to a value; return False for a text or a full table."""
    kind, count = PLAIN.get(row.type_name), prod(row.dims)
    if kind is None:
        return False
    if kind in (BOOL, DWORD):
        table = COILS if row.writable else DISCRETE_INPUTS
        size = 32 * -(-count // 32) if row.dims else 1
        size *= 32 if kind == DWORD and row.dims else 1
    else:
        table = HOLDING_REGISTERS if row.writable else INPUT_REGISTERS
        size = max(1, kind.size // 2) * count
    if free[table] + size > ADDRESSES:
        return False
    tables[table].append(f'{{ address = {free[table]}, tag = "{row.enip}" }}')
    free[table] += size
    return True
