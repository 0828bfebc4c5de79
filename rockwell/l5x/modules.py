"""Tags of a document's modules: `Local:1:I`, `Rack:3:O`, `Drive:I1`, `Local:2:C`.

The prefix is the chassis and slot, or the name of a module on a network. The members of a tag are taken from
its values in the document. A module with a rack connection has aliases of parts of its adapter's tags.

`Local:1:I` and `Local:1:O` of a slot in the rack are the images of that slot. Their members have the names of
the generic profile (`Data[0]`), of the 3601's profile (`Data0`, `ModuleOK`) or of cards. All other tags of
modules are unconnected memory, which tests, the debugger and plants may set. Output images and memory start
with the values in the document.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from scanrack.ladder.lowering.calls import MODULE, MODULE_TAG
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.resolver import slot_of_image
from scanrack.ladder.model.tags import Alias, Declaration, Tag
from scanrack.ladder.model.types import DINT, INT, SINT, DataType, Member, Structure
from scanrack.ladder.state.initials import load_bytes
from scanrack.ladder.state.tag_bytes import TagBytes

from .report import Report
from .scopes import note_forces
from .values.datatypes import NAME, Types
from .values.force_values import image_of
from .values.initial_values import initial_of
from .values.value_texts import ValueTextError
from .xml.data import Data
from .xml.elements import number_of
from .xml.parsing import L5xError
from .xml.records import L5xDocument, ModuleRecord, ModuleTagRecord

NETWORKS = ("ETHERNET", "CONTROLNET", "DEVICENET", "RHINOBP", "SERCOS", "USB", "RIO", "DH")
"""Port types whose addresses are not slots."""

_SLOT_ARRAYS = ("Data", "Slot")  # arrays with one element per slot in the tag of an adapter


def prefix_of(module: ModuleRecord) -> str:
    """Return the prefix of a module's tags: `Local:1`, `Rack:3` or `Drive`."""
    on_network = module.bus.upper().startswith(NETWORKS) or number_of(module.address) is None
    return module.name if on_network else f"{module.parent}:{module.address}"


_LOCAL = re.compile(r"Local:(\d+)", re.IGNORECASE)


def is_bound(name: str, slots: Collection[int] | None) -> bool:
    """Return whether a module's tag is an image of a slot in the rack.

    >>> is_bound("Local:1:I", {1, 2}), is_bound("Local:1:C", {1, 2}), is_bound("Local:3:O", {1, 2})
    (True, False, False)
    """
    return slots is not None and slot_of_image(name) in slots


def slot_of(module: ModuleRecord) -> int | None:
    """Return the slot of a module in the controller's own chassis, from 1; None for other modules."""
    local = _LOCAL.fullmatch(prefix_of(module))
    return int(local[1]) if local and int(local[1]) > 0 else None


@dataclass(slots=True)
class ModuleMemory:
    """The tags of modules that are memory, and the initial bytes of the rack's output images."""

    declarations: list[Declaration] = field(default_factory=list)
    outputs: dict[int, bytes] = field(default_factory=dict)  # by slot


def module_tags(
    document: L5xDocument, types: Types, report: Report, slots: Collection[int] | None = None
) -> ModuleMemory:
    """Return the memory of modules; report modules that are not in the rack.

    Args:
        slots: slots of the rack; None without a rack.
    """
    tags: dict[str, Declaration] = {}
    outputs: dict[int, bytes] = {}
    aliases: list[tuple[ModuleRecord, ModuleTagRecord]] = []
    for module in document.modules:
        slot = slot_of(module)
        if slots is not None and module.tags and slot not in slots:
            text = f"{module.catalog} is not in the rack: its tags are memory"
            report.note(prefix_of(module), text, module.line)
        for tag in module.tags:
            if tag.kind.endswith("AliasTag"):
                aliases.append((module, tag))
                continue
            declaration = _tag(module, tag, types, report)
            if declaration is None:
                continue
            if not is_bound(declaration.name, slots):
                tags.setdefault(declaration.name.upper(), declaration)
            elif tag.kind == "OutputTag" and slot is not None and declaration.initial is not None:
                outputs.setdefault(slot, _memory(declaration))
    for module, tag in aliases:  # after all tags that they may refer to
        alias = _alias(module, tag, tags)
        if alias is not None:
            tags.setdefault(alias.name.upper(), alias)
    return ModuleMemory(list(tags.values()), outputs)


def _memory(tag: Tag) -> bytes:
    """Return the bytes of a tag's initial value; zeros if it does not fit."""
    memory = TagBytes(tag.type, 1)
    load_bytes(memory, tag.type, (), tag.initial)
    return bytes(memory.B[:])


def module_objects(
    document: L5xDocument, types: Types, declared: Collection[Declaration]
) -> Iterator[Declaration]:
    """Yield a tag of type MODULE for each module, because an add-on's argument may be a module's name.

    If a module's name is already declared, its tag gets a generated name.
    """
    try:
        kind = types.find(MODULE)
    except LadderError:
        return
    declared_names = {declaration.name.upper() for declaration in declared}
    modules: dict[str, ModuleRecord] = {}
    for module in document.modules:
        modules.setdefault(module.name.upper(), module)
    for key, module in modules.items():
        if NAME.fullmatch(module.name):
            name = f"{MODULE_TAG}{module.name}" if key in declared_names else module.name
            yield Tag(name, kind, (), None, f"{module.catalog} {module.name}".strip())


def _tag(module: ModuleRecord, tag: ModuleTagRecord, types: Types, report: Report) -> Tag | None:
    """Return a tag with the values of the document; None if its type is not known."""
    name = f"{prefix_of(module)}:{tag.suffix}"
    kind = _shown_type(tag, types) or _sized(module, tag, types)
    if tag.forced:
        note_forces(tag, kind or DINT, (), types, report, name)
    if kind is None:
        if any(map(_has_values, tag.data)):
            report.leave_out(name, "its values do not show its type", tag.line)
        return None
    for host in types.apart.get(kind.name, ()):
        text = f"BOOLs of its {host} have their own memory: the file does not say which bits they are"
        report.note(name, text, tag.line)
    remarks: list[str] = []
    initial = _initial(tag, kind, types, remarks.append)
    for text in remarks[:1]:
        report.lose(name, text, tag.line)
    return Tag(name, kind, (), initial, f"{module.catalog} {module.name}".strip())


def _initial(tag: ModuleTagRecord, kind: DataType, types: Types, remark: Callable[[str], None]) -> Any:
    """Return the initial value of a tag; None for zeros, or for an unreadable value, with a remark."""
    try:
        if tag.data:
            return initial_of(tag.data, kind, (), types, remark)
        return image_of(tag.forced, kind, types.layouts)
    except L5xError:
        raise
    except (ValueTextError, LadderError) as error:
        remark(f"it starts with zeros: {error}")
        return None


def _has_values(data: Data) -> bool:
    """Return whether the data contains a nonzero digit."""
    return any(character in "123456789ABCDEF" for character in "".join(data.element.itertext()))


def _sized(module: ModuleRecord, tag: ModuleTagRecord, types: Types) -> Structure | None:
    """Return a type with a module's words if only their size is known; None if it is unknown.

    The words are Data; the bytes of inputs begin with Fault.
    """
    is_input = tag.kind == "InputTag"
    size = tag.size
    if is_input and module.catalog.startswith(GENERIC):
        size -= FAULT_BYTES
    if tag.kind not in ("InputTag", "OutputTag") or size < 2:
        return None
    name = f"{module.catalog}:{tag.suffix}"
    value_count = next(filter(None, map(_numbers_in, tag.data)), 0)
    if value_count and tag.size % value_count == 0 and tag.size // value_count in _BY_BYTES:
        return types.own(
            Structure(name, (Member("Data", _BY_BYTES[tag.size // value_count], (value_count,)),))
        )
    fault = (Member("Fault", DINT),) if is_input else ()
    return types.own(Structure(name, (*fault, Member("Data", INT, (size // 2,)))))


_BY_BYTES = {1: SINT, 2: INT, 4: DINT}
_ONE_LIST = re.compile(r"\s*\[\s*\[([-\d,\s]*+)\]\s*\]\s*")


def _numbers_in(data: Data) -> int:
    """Return the length of the only list in L5K data; 0 for other data."""
    match = _ONE_LIST.fullmatch("".join(data.element.itertext())) if data.form == "L5K" else None
    return match[1].count(",") + 1 if match else 0


GENERIC = "1769-MODULE"
"""Catalog number of the generic profile."""

FAULT_BYTES = 4
"""Size of the Fault member at the beginning of an input tag."""


def _shown_type(tag: ModuleTagRecord, types: Types) -> DataType | None:
    """Return the type inferred from the first readable values of a tag."""
    for data in tag.data:
        for inner in data.element.iterchildren("Structure", "DataValue"):
            kind = types.show(inner)
            if kind is not None:
                return kind
    return None


def _alias(module: ModuleRecord, tag: ModuleTagRecord, tags: Mapping[str, Declaration]) -> Alias | None:
    """Return the alias of a rack connection; None if the adapter's tag is unknown."""
    direction = "I" if tag.kind == "InAliasTag" else "O"
    adapter = tags.get(f"{module.parent}:{direction}".upper())
    if not isinstance(adapter, Tag) or not isinstance(adapter.type, Structure):
        return None
    array = next((name for name in _SLOT_ARRAYS if adapter.type.member(name)), None)
    slot = number_of(module.address)
    if array is None or slot is None:
        return None
    target = parse_address(f"{adapter.name}.{array}[{slot}]")
    return Alias(f"{prefix_of(module)}:{direction}", target, module.name)
