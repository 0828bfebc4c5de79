"""Tags and aliases of the controller and of programs, as declarations."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from decimal import Decimal, InvalidOperation
from math import inf
from typing import Any

from scanrack.io_images.enip.listing import ExternalAccess
from scanrack.ladder.instructions.motion.axes import MotionData
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.predefined.motion_types import AXIS_TYPES
from scanrack.ladder.model.stubs import Remote
from scanrack.ladder.model.tags import Alias, Declaration, Tag, scoped
from scanrack.ladder.model.types import MAX_DIMENSIONS, DataType

from .report import Report
from .values.datatypes import Types
from .values.force_values import forces_of
from .values.initial_values import initial_of
from .values.value_texts import ValueTextError
from .xml.parsing import L5xError
from .xml.records import Element, ModuleTagRecord, TagRecord

_CONNECTION_NOTES = {
    "PRODUCED": "it is produced: a linked rack can consume it",
    "CONSUMED": "it is consumed: without a partner in [stubs] it keeps its initial value",
}


def scope_of(
    records: Iterable[TagRecord], types: Types, report: Report, owner: str = ""
) -> list[Declaration]:
    """Return the declarations of tags and report their forces; report and omit invalid tags.

    Args:
        owner: the program of the tags; "" for tags of the controller.
    """
    declarations: list[Declaration] = []
    for record in records:
        full_name, tag_kind = scoped(owner, record.name), record.kind.upper()
        if tag_kind in _CONNECTION_NOTES:
            report.note(full_name, _CONNECTION_NOTES[tag_kind], record.line)
        if owner and record.usage.upper() == "INOUT":
            text = "it is a parameter by reference; scanrack gives it its own memory"
            report.note(full_name, text, record.line)
        try:
            if tag_kind == "ALIAS" or record.target:
                declarations.append(Alias(record.name, parse_address(record.target), record.comment))
                continue
            kind = type_of(record, types)
            declarations.append(tag_of(record, kind, types, report, owner))
            if record.forced:
                note_forces(record, kind, record.dims, types, report, full_name)
        except L5xError:  # a LadderError, but the file as a whole is invalid
            raise
        except LadderError as error:
            report.leave_out(full_name, str(error), record.line)
    return declarations


def note_forces(
    record: TagRecord | ModuleTagRecord,
    kind: DataType,
    dims: tuple[int, ...],
    types: Types,
    report: Report,
    name: str,
) -> None:
    """Report the forces of a tag by their addresses; note the forces that can't be read."""
    try:
        for path, value in forces_of(record.forced, kind, dims, types):
            report.forces[f"{name}{path}"] = value
    except ValueTextError as error:
        report.note(name, f"its forces are not read: {error}", record.line)


def type_of(record: TagRecord, types: Types) -> DataType:
    """Return a tag's type, found by its name or inferred from the tag's decorated values.

    Raises:
        UnknownTypeError: the type is undefined.
        LadderError: the type is unusable.
    """
    try:
        return types.find(record.type)
    except LadderError:
        for structure in _structures_shown(record):
            kind = types.show(structure)
            if kind is not None:
                return kind
        raise


def _structures_shown(record: TagRecord) -> Iterator[Element]:
    """Yield the decorated structures of a tag; for an array, the structure of its first element."""
    for data in record.data:
        if data.form == "Decorated":
            inner = next(data.element.iterchildren("Structure", "Array"), None)
            if inner is not None and inner.tag == "Array":
                inner = inner.find("Element/Structure")
            if inner is not None:
                yield inner


def tag_of(record: TagRecord, kind: DataType, types: Types, report: Report, owner: str = "") -> Tag:
    """Return a tag with its initial value; raise a LadderError if its dimensions are invalid."""
    if record.wrong_dims:
        raise LadderError(f"its dimensions {record.wrong_dims!r} are not numbers")
    if len(record.dims) > MAX_DIMENSIONS or min(record.dims, default=1) < 1:
        raise LadderError(f"it has dimensions {record.dims}")
    types.take(kind, record.dims)
    initial = read_initial(record, kind, types, report, scoped(owner, record.name))
    return Tag(record.name, kind, record.dims, initial, record.comment, _access(record))


def _access(record: TagRecord) -> ExternalAccess:
    """Return the external access of a tag; an unknown word in the file means no access."""
    if not record.access:
        return ExternalAccess.READ_WRITE
    levels = {access.value.upper(): access for access in ExternalAccess}
    return levels.get(record.access.upper(), ExternalAccess.NONE)


def read_initial(
    record: TagRecord,
    kind: DataType,
    types: Types,
    report: Report,
    name: str,
    consequence: str = "it starts with zeros",
) -> Any:
    """Return the initial value of a tag or parameter.

    If it can't be read, return None and note the consequence. If parts of it are lost, note the first loss.
    """
    losses: list[str] = []
    try:
        initial = initial_of(record.data, kind, record.dims, types, losses.append)
    except ValueTextError as error:
        report.lose(name, f"{consequence}: {error}", record.line)
        return None
    if losses:
        suffix = f", and {len(losses) - 1} more" if len(losses) > 1 else ""
        report.lose(name, f"{losses[0]}{suffix}", record.line)
    return initial


def motion_of(records: Iterable[TagRecord]) -> MotionData:
    """Return the axes of coordinate systems, and the unwind values of rotary axes."""
    systems, unwinds = {}, {}
    for record in records:
        if record.type.upper() == "COORDINATE_SYSTEM":
            systems[record.name.upper()] = _parameters(record).get("Axes", "").split()
        elif record.type.upper() in AXIS_TYPES:
            attributes = _parameters(record)
            if attributes.get("RotaryAxis", "") == "Rotary":
                unwinds[record.name.upper()] = _ratio(
                    attributes.get("PositionUnwind"), attributes.get("ConversionConstant")
                )
    return MotionData(systems, unwinds)


def remotes_of(records: Iterable[TagRecord], owner: str = "") -> dict[str, Remote]:
    """Return the remote tags of consumed tags and of messages, by tag in capitals.

    Args:
        owner: the program of the tags; "" for tags of the controller.
    """
    remotes = {}
    for record in records:
        name = scoped(owner, record.name).upper()
        if record.kind.upper() == "CONSUMED":
            remotes[name] = Remote(record.remote, _rpi_ns(record.rpi))
        elif record.type.upper() == "MESSAGE":
            parameters = _parameters(record)
            target = parameters.get("DestinationTag") or parameters.get("LocalElement") or ""
            if target:
                remotes[name] = Remote(_full_name(owner, target, records))
    return remotes


def _full_name(owner: str, address: str, records: Iterable[TagRecord]) -> str:
    """Return an address as text; add the program's name if the tag is one of the program's own."""
    name = re.split(r"[.\[]", address, maxsplit=1)[0].upper()
    is_own = any(record.name.upper() == name for record in records)
    return scoped(owner, address) if is_own else address


def _rpi_ns(text: str) -> int:
    """Convert an RPI from ms to ns; return 0 if it is missing or invalid."""
    try:
        rpi_ns = Decimal(text) * 1_000_000
    except InvalidOperation:
        return 0
    return int(rpi_ns) if 0 < rpi_ns < 1 << 62 else 0


def _parameters(record: TagRecord) -> dict[str, str]:
    """Return the parameters of an axis, a coordinate system or a message by name; {} without any."""
    for data in record.data:
        for child in data.element.iterchildren("*"):
            if child.tag.endswith("Parameters"):
                return dict(child.items())
    return {}


def _ratio(counts: str | None, per_unit: str | None) -> float:
    """Return counts divided by counts per unit; 0.0 if the ratio is not a positive number."""
    try:
        ratio = float(counts or 0) / float(per_unit or 0)
    except (ValueError, ZeroDivisionError):
        return 0.0
    return ratio if 0 < ratio < inf else 0.0
