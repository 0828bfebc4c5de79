"""What clients that others wrote list of a rack: tags and templates, in one form beside its own layout."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

from scanrack.io_images.enip.codes import TYPE_CODES
from scanrack.io_images.enip.listing import BOOL, Kind, StructuredKind
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.templates import SHOWN
from served_tags import write_rack

EXAMPLES = Path(__file__).parents[2] / "examples"
BENCH = "bench"
CONTROLLERS: tuple[str, ...] = (
    BENCH,
    "hmi/feeder",
    "l5x/indexer",
    "l5x/mixer",
    "l5x/packer",
    "l5x/palletizer",
)
CONTROLLERS += ("feeder/feeder", "three_stations_ladder/line", "three_stations_panel/line", "own_module/line")
CONTROLLERS += ("first/rack", "three_stations/line", "sequences/labeller", "sequences/jog_panel")
"""The bench and the examples; of those that differ in their adapter only, or have the same images, one."""

CODES = {code: name for name, code in TYPE_CODES.items()}
STRUCTURE, PROGRAM = 0x8000, 0x68
"""A bit of a type's code; the code of a program."""


class Member(NamedTuple):
    """A member of a structure; `number` is the bit of a BOOL, or how many elements an array has."""

    name: str
    type_name: str
    number: int
    offset: int


Names = Callable[[int], str]
"""Names of structures by the numbers of their templates."""


class Listed(NamedTuple):
    """Tags with types and dimensions, and structures with members and bytes."""

    tags: dict[str, tuple[str, tuple[int, ...]]]
    templates: dict[str, tuple[list[Member], int]]

    def without(self, *, sizes: bool = True, dims: Callable[[tuple[int, ...]], Any] = tuple) -> Any:
        """Return what a client keeps that knows less of dimensions and sizes."""
        tags = {name: (kind, dims(each)) for name, (kind, each) in self.tags.items()}
        return tags, {name: each if sizes else each[0] for name, each in self.templates.items()}


def rack_id(name: str) -> str:
    return name.replace("/", "-")


def rack_at(name: str, folder: Path) -> Path:
    """Return the rack file of the bench, or of an example."""
    return write_rack(folder) if name == BENCH else EXAMPLES / f"{name}.toml"


def listed(database: Database) -> Listed:
    """Return the layout that the rack has; aliases are tags, too."""
    every = [each for scope in database.scopes.values() for each in scope]
    tags = {}
    for tag in (each.tag for each in every):
        tags[f"Program:{tag.program}.{tag.name}" if tag.program else tag.name] = _shown(tag.kind, tag.dims)
    templates = {}
    for kind in _structures(each.tag.kind for each in every):
        members = []
        for part in kind.parts:
            name, dims = _shown(part.kind, part.dims)
            number = (part.bit or 0) if name == "BOOL" else prod(dims) if dims else 0
            members.append(Member(part.name, name, number, part.offset))
        templates[SHOWN.get(kind.name, kind.name)] = members, kind.size
    return Listed(tags, templates)


def _shown(kind: Kind, dims: tuple[int, ...]) -> tuple[str, tuple[int, ...]]:
    """Return type and dimensions as a controller shows them: an array of BOOLs has words of 32."""
    if kind == BOOL and dims:
        return "DWORD", (-(-prod(dims) // 32),)
    return SHOWN.get(kind.name, kind.name), dims


def _structures(kinds: Iterable[Kind]) -> Iterator[StructuredKind]:
    for kind in kinds:
        if isinstance(kind, StructuredKind):
            yield kind
            yield from _structures(part.kind for part in kind.parts)


def _type_of(code: int, names: Names) -> str:
    return names(code & 0xFFF) if code & STRUCTURE else CODES[code & 0xFF]


def _members(rows: Iterable[tuple[str, int, int, int]], names: Names) -> list[Member]:
    """Return members of a definition: name, info, type, offset [1756-PM020]."""
    return [Member(name, _type_of(code, names), info, offset) for name, info, code, offset in rows]


def of_pycomm3(plc: Any) -> Listed:
    """Return what a LogixDriver has listed; it shows STRING under the name that programs have for it."""
    tags, templates = {}, {}
    for name, each in plc.tags.items():
        kind = str(each["data_type_name"])
        tags[name] = SHOWN.get(kind, kind), tuple(filter(None, each["dimensions"]))
    for name, each in plc.data_types.items():
        members = [
            Member(part, SHOWN.get(kind, kind), told["bit" if kind == "BOOL" else "array"], told["offset"])
            for part, told in each["internal_tags"].items()
            for kind in [told["data_type_name"]]
        ]
        templates[SHOWN.get(name, name)] = members, each["template"]["structure_size"]
    return Listed(tags, templates)


def of_pylogix(plc: Any) -> Listed:
    """Return what a PLC has listed. It keeps the first dimension, and no size of a structure."""
    tags, templates = {}, {}

    def name(number: int) -> str:
        return str(plc.UDT[number].Name)

    for each in plc.GetTagList().Value:
        if not each.Struct and each.SymbolType == PROGRAM:
            continue
        code = STRUCTURE * each.Struct | each.DataTypeValue
        tags[each.TagName] = _type_of(code, name), (each.Size,) * bool(each.Array)
    for each in plc.UDT.values():
        rows = [(field.TagName, *struct.unpack("<HHI", field.Bytes)) for field in each.Fields]
        templates[each.Name] = _members(rows, name), 0
    return Listed(tags, templates)


def of_st(told: Mapping[str, Any]) -> Listed:
    """Return what write_tags.cjs lists; of dimensions the package keeps their number."""
    by_number = told["templates"]

    def name(number: int) -> str:
        return str(by_number[str(number)]["name"])

    tags = {key: (_type_of(code, name), (dims,) * bool(dims)) for key, code, dims in told["tags"]}
    templates = {
        each["name"]: (_members(map(tuple, each["members"]), name), each["size"])
        for each in by_number.values()
    }
    return Listed(tags, templates)


def of_libplctag(ask: Callable[..., Mapping[str, str]]) -> Listed:
    """Return what the library reads of `@tags` and `@udt/NUMBER`.

    Args:
        ask: reads by name, as hexadecimal.
    """
    rows = list(_entries(bytes.fromhex(ask("@tags")["@tags"])))
    programs = [f"{name}.@tags" for name, code, _ in rows if code & (STRUCTURE | 0xFF) == PROGRAM]
    for name, data in (ask(*programs) if programs else {}).items():
        inside = _entries(bytes.fromhex(data))
        rows += [(name.replace("@tags", each), code, dims) for each, code, dims in inside]
    rows = [each for each in rows if each[1] & (STRUCTURE | 0xFF) != PROGRAM]
    wanted = {code & 0xFFF for _, code, _ in rows if code & STRUCTURE}
    read: dict[int, tuple[str, int, list[tuple[str, int, int, int]]]] = {}
    while missing := wanted - set(read):
        for name, data in ask(*(f"@udt/{number}" for number in missing)).items():
            read[int(name.partition("/")[2])] = _definition(bytes.fromhex(data))
        wanted |= {
            each[2] & 0xFFF for _, _, members in read.values() for each in members if each[2] & STRUCTURE
        }

    def named(number: int) -> str:
        return read[number][0]

    tags = {name: (_type_of(code, named), dims) for name, code, dims in rows}
    return Listed(tags, {name: (_members(members, named), size) for name, size, members in read.values()})


def _entries(data: bytes) -> Iterator[tuple[str, int, tuple[int, ...]]]:
    """Yield name, type and dimensions; number u32, type u16, bytes u16, dimensions 3 u32, text with u16."""
    at = 0
    while at < len(data):
        _, code, _, *dims, length = struct.unpack_from("<IHH3IH", data, at)
        at += 22 + length
        yield data[at - length : at].decode(), code, tuple(filter(None, dims))


def _definition(data: bytes) -> tuple[str, int, list[tuple[str, int, int, int]]]:
    """Return name, bytes and members; number u16, words u32, bytes u32, members u16, handle u16."""
    _, _, size, count, _ = struct.unpack_from("<HIIHH", data)
    name, *names = data[14 + 8 * count :].split(b"\0")
    rows = struct.iter_unpack("<HHI", data[14 : 14 + 8 * count])
    members = [(each.decode(), *row) for each, row in zip(names, rows, strict=False)]
    return name.partition(b";")[0].decode(), size, members
