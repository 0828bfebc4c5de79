"""Modules of a document to tags: `Local:1:I`, `Rack:3:O`, `Drive:I1`, `Local:2:C`.

A module in a chassis goes by the chassis and its slot, one on a network by its name. The values in the
document show the members of a tag. A module of a rack connection has aliases to parts of its adapter's tags.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..errors import LadderError
from ..expressions import parse_address
from ..tags import Alias, Declaration, Tag
from ..types import DataType, Structure
from .datatypes import Types
from .records import Document, ModuleRecord, ModuleTagRecord
from .report import Report
from .values import ValueTextError, initial_of

NETWORKS = ("ETHERNET", "CONTROLNET", "DEVICENET", "RHINOBP", "SERCOS", "USB", "RIO", "DH")
"""Types of ports whose addresses are not slots."""

_PARTS = ("Data", "Slot")
"""Arrays in the tag of an adapter that have one element per slot."""


def prefix_of(module: ModuleRecord) -> str:
    """Return what the names of a module's tags begin with: `Local:1`, `Rack:3` or `Drive`."""
    on_network = any(module.bus.upper().startswith(each) for each in NETWORKS)
    return module.name if on_network or not module.address.isdigit() else f"{module.parent}:{module.address}"


def module_tags(document: Document, types: Types, report: Report) -> list[Declaration]:
    """Return the tags of all modules. None is connected to anything; the report says so."""
    found: dict[str, Declaration] = {}
    aliases: list[tuple[ModuleRecord, ModuleTagRecord]] = []
    for module in document.modules:
        for tag in module.tags:
            if tag.kind.endswith("AliasTag"):
                aliases.append((module, tag))
                continue
            made = _tag(module, tag, types, report)
            if made is not None:
                found.setdefault(made.name.upper(), made)
    for module, tag in aliases:
        alias = _alias(module, tag, found)
        if alias is not None:
            found.setdefault(alias.name.upper(), alias)
    return list(found.values())


def _tag(module: ModuleRecord, tag: ModuleTagRecord, types: Types, report: Report) -> Tag | None:
    name = f"{prefix_of(module)}:{tag.suffix}"
    kind = next((each for each in _shown(tag, types) if each is not None), None)
    if kind is None:
        return None
    try:
        initial = initial_of(tag.data, kind, ()) if tag.kind == "ConfigTag" else None
    except (ValueTextError, LadderError) as error:
        report.note(name, f"it starts with zeros: {error}", tag.line)
        initial = None
    return Tag(name, kind, (), initial, f"{module.catalog} {module.name}".strip())


def _shown(tag: ModuleTagRecord, types: Types) -> Iterator[DataType | None]:
    for data in tag.data:
        for inner in data.iterchildren("Structure", "DataValue"):
            yield types.show(inner)


def _alias(module: ModuleRecord, tag: ModuleTagRecord, found: Mapping[str, Declaration]) -> Alias | None:
    """Return the alias of a module of a rack connection, None if its adapter's tag is unknown."""
    way = "I" if tag.kind == "InAliasTag" else "O"
    adapter = found.get(f"{module.parent}:{way}".upper())
    if not isinstance(adapter, Tag) or not isinstance(adapter.type, Structure):
        return None
    part = next((name for name in _PARTS if adapter.type.member(name)), None)
    if part is None or not module.address.isdigit():
        return None
    target = parse_address(f"{adapter.name}.{part}[{int(module.address)}]")
    return Alias(f"{prefix_of(module)}:{way}", target, module.name)
