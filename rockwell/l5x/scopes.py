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

_FILLED = {
    "PRODUCED": "it is produced: a rack beside this one can consume it",
    "CONSUMED": "it is consumed: without a partner in [stubs] it keeps its initial value",
}


def scope_of(
    records: Iterable[TagRecord], types: Types, report: Report, owner: str = ""
) -> list[Declaration]:
    """Return the tag declarations of a program, or if `owner` is "", the controller; report invalid tags."""
    declarations: list[Declaration] = []
    for record in records:
        if record.kind.upper() in _FILLED:
            report.note(scoped(owner, record.name), _FILLED[record.kind.upper()], record.line)
        if owner and record.usage.upper() == "INOUT":
            text = "it is a parameter by reference, and has its own memory here"
            report.note(scoped(owner, record.name), text, record.line)
        try:
            if record.kind.upper() == "ALIAS" or record.target:
                declarations.append(Alias(record.name, parse_address(record.target), record.comment))
                continue
            kind = type_of(record, types)
            declarations.append(tag_of(record, kind, types, report, owner))
            if record.forced:
                note_forces(record, kind, record.dims, types, report, scoped(owner, record.name))
        except L5xError:
            raise
        except LadderError as error:
            report.leave_out(scoped(owner, record.name), str(error), record.line)
    return declarations


def note_forces(
    record: TagRecord | ModuleTagRecord,
    kind: DataType,
    dims: tuple[int, ...],
    types: Types,
    report: Report,
    name: str,
) -> None:
    """Report the forces of a tag by their addresses; note those that can't be read."""
    try:
        for path, value in forces_of(record.forced, kind, dims, types):
            report.forces[f"{name}{path}"] = value
    except ValueTextError as error:
        report.note(name, f"its forces are not read: {error}", record.line)


def type_of(record: TagRecord, types: Types) -> DataType:
    """Return a tag's type by its name or its values.

    Raises:
        UnknownTypeError: the type is undefined.
        LadderError: the type is unusable.
    """
    try:
        return types.find(record.type)
    except LadderError:
        shown = (types.show(data) for data in _shown(record))
        shown_type = next((candidate for candidate in shown if candidate is not None), None)
        if shown_type is None:
            raise
        return shown_type


def _shown(record: TagRecord) -> Iterator[Element]:
    """Yield the decorated data that show a tag's structure, or its first element's structure."""
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
        raise LadderError(f"{record.wrong_dims!r} are not dimensions")
    if len(record.dims) > MAX_DIMENSIONS or min(record.dims, default=1) < 1:
        raise LadderError(f"it has dimensions {record.dims}")
    types.take(kind, record.dims)
    initial = read_initial(record, kind, types, report, scoped(owner, record.name))
    return Tag(record.name, kind, record.dims, initial, record.comment, _access(record))


def _access(record: TagRecord) -> ExternalAccess:
    """Return the access of clients; an unknown word in the file means no access."""
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
    what: str = "it starts with zeros",
) -> Any:
    """Return the initial value of a tag or parameter; note an unreadable one, with the consequence."""
    losses: list[str] = []
    try:
        initial = initial_of(record.data, kind, record.dims, types, losses.append)
    except ValueTextError as error:
        report.lose(name, f"{what}: {error}", record.line)
        return None
    if losses:
        suffix = f", and {len(losses) - 1} more" * (len(losses) > 1)
        report.lose(name, f"{losses[0]}{suffix}", record.line)
    return initial


def motion_of(records: Iterable[TagRecord]) -> MotionData:
    """Return the axes of coordinate systems, and the unwind values of rotary axes."""
    systems, unwinds = {}, {}
    for record in records:
        if record.type.upper() == "COORDINATE_SYSTEM":
            systems[record.name.upper()] = _attributes(record).get("Axes", "").split()
        elif record.type.upper() in AXIS_TYPES:
            attributes = _attributes(record)
            if attributes.get("RotaryAxis", "") == "Rotary":
                unwinds[record.name.upper()] = _ratio(
                    attributes.get("PositionUnwind"), attributes.get("ConversionConstant")
                )
    return MotionData(systems, unwinds)


def remotes_of(records: Iterable[TagRecord], owner: str = "") -> dict[str, Remote]:
    """Return the remotes of consumed tags and of tags that receive message data, by tag in capitals."""
    remotes = {}
    for record in records:
        name = scoped(owner, record.name).upper()
        if record.kind.upper() == "CONSUMED":
            remotes[name] = Remote(record.remote, _rpi_ns(record.rpi))
        elif record.type.upper() == "MESSAGE":
            parameters = _attributes(record)
            target = parameters.get("DestinationTag") or parameters.get("LocalElement") or ""
            if target:
                remotes[name] = Remote(_full_name(owner, target, records))
    return remotes


def _full_name(owner: str, to: str, records: Iterable[TagRecord]) -> str:
    """Return a tag's full name: with the program, if it is a program's own tag."""
    head = re.split(r"[.\[]", to, maxsplit=1)[0].upper()
    return scoped(owner, to) if any(record.name.upper() == head for record in records) else to


def _rpi_ns(text: str) -> int:
    try:
        rpi_ns = Decimal(text) * 1_000_000
    except InvalidOperation:
        return 0
    return int(rpi_ns) if 0 < rpi_ns < 1 << 62 else 0


def _attributes(record: TagRecord) -> dict[str, str]:
    """Return the parameters of an axis or coordinate system."""
    inner = (child for data in record.data for child in data.element.iterchildren("*"))
    return next((dict(child.items()) for child in inner if child.tag.endswith("Parameters")), {})


def _ratio(counts: str | None, per_unit: str | None) -> float:
    try:
        ratio = float(counts or 0) / float(per_unit or 0)
    except (ValueError, ZeroDivisionError):
        return 0.0
    return ratio if 0 < ratio < inf else 0.0
