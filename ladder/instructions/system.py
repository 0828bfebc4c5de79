"""EVENT, and GSV and SSV for the objects that a controller has here [1756-RM003N, system values].

An attribute is a row of `ATTRIBUTES`: how it is read as bytes, and, if it can be set, how it is set from
bytes. The tag of GSV and SSV may be a structure, an array, or the first member of a structure, as exports
name it. WallClockTime is the virtual time, from 1970-01-01 00:00 at power-up on.
"""

from __future__ import annotations

import datetime
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..interpreter import Interpreter
from ..lowered import OperandResolver
from ..operand_checks import OperandError
from ..operands import Group, Place
from ..regions import End, put, take
from ..schedule import ScheduledProgram, ScheduledTask, task_named
from ..spec import Use, action
from ..tags import program_of
from ..tree import Address, Operand

__all__ = ["EVENT", "GSV", "SSV"]

THIS = "THIS"
"""Instance name of the program in which an instruction stands."""

POWER_UP = datetime.datetime(1970, 1, 1)
"""WallClockTime at virtual time 0."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute of an object.

    Attributes:
        read: returns it as bytes; gets the machine and the instance's name in capitals.
        write: sets it from as many bytes as there are; None if it can only be read.
    """

    read: Callable[[Interpreter, str], bytes]
    write: Callable[[Interpreter, str, bytes], None] | None = None


# --- PROGRAM

_RECORD = struct.Struct("<qhh8i")
"""MajorFaultRecord: time in µs, type, code, eight words of information."""

_FAULT = struct.Struct("<hh")
_FAULT_AT = 8
"""Type and code in a fault record, and the byte at which they begin."""


def _program(machine: Interpreter, name: str) -> ScheduledProgram | None:
    schedule = machine.lowered.schedule
    programs = schedule.programs if schedule is not None else ()
    return next((each for each in programs if not name or each.name.upper() == name), None)


def _read_major_fault(machine: Interpreter, name: str) -> bytes:
    program = _program(machine, name)
    if program is None:
        return bytes(_RECORD.size)
    kind, code = (int(machine.memory.read(leaf)) for leaf in (program.fault_type, program.fault_code))
    return _RECORD.pack(machine.now_ns // 1_000 if kind else 0, kind, code, *[0] * 8)


def _write_major_fault(machine: Interpreter, name: str, data: bytes) -> None:
    program = _program(machine, name)
    if program is None or len(data) < _FAULT_AT + _FAULT.size:
        return
    for leaf, value in zip(
        (program.fault_type, program.fault_code), _FAULT.unpack_from(data, _FAULT_AT), strict=True
    ):
        machine.memory.write(leaf, 0, value)


# --- TASK


def _task(machine: Interpreter, name: str) -> ScheduledTask | None:
    schedule = machine.lowered.schedule
    return task_named(schedule.tasks, name) if schedule is not None else None


Reader = Callable[[Interpreter, str], bytes]


def _of_task(code: str, value: Callable[[Interpreter, ScheduledTask], int]) -> Reader:
    """Return what reads a number of a task."""

    def read(machine: Interpreter, name: str) -> bytes:
        task = _task(machine, name)
        return struct.pack(code, value(machine, task) if task is not None else 0)

    return read


def _write_overlaps(machine: Interpreter, name: str, data: bytes) -> None:
    task = _task(machine, name)
    if task is not None and len(data) >= 4:
        machine.memory.write(task.overlaps, 0, struct.unpack_from("<i", data)[0])


# --- WALLCLOCKTIME


def _microseconds(machine: Interpreter, _name: str) -> bytes:
    return struct.pack("<q", machine.now_ns // 1_000)


def _date(machine: Interpreter, _name: str) -> bytes:
    now = POWER_UP + datetime.timedelta(microseconds=machine.now_ns // 1_000)
    return struct.pack("<7i", *now.timetuple()[:6], now.microsecond)


ATTRIBUTES: Mapping[tuple[str, str], Attribute] = {
    ("PROGRAM", "MAJORFAULTRECORD"): Attribute(_read_major_fault, _write_major_fault),
    ("TASK", "RATE"): Attribute(_of_task("<i", lambda _machine, each: each.task.rate_ns // 1_000)),
    ("TASK", "PRIORITY"): Attribute(_of_task("<h", lambda _machine, each: each.task.priority)),
    ("TASK", "OVERLAPCOUNT"): Attribute(
        _of_task("<i", lambda machine, each: int(machine.memory.read(each.overlaps))), _write_overlaps
    ),
    ("WALLCLOCKTIME", "CURRENTVALUE"): Attribute(_microseconds),
    ("WALLCLOCKTIME", "DATETIME"): Attribute(_date),
    ("WALLCLOCKTIME", "LOCALDATETIME"): Attribute(_date),
}
"""Attributes by class and name in capitals."""


def _resolve(
    resolver: OperandResolver, given: tuple[Operand, ...], *, written: bool
) -> tuple[str, str, str, Place | Group]:
    """Return class, instance and attribute in capitals, and the tag.

    Args:
        resolver: resolves operands.
        given: operands of the instruction.
        written: whether the tag is written.
    """
    kind, instance, name = (str(each).upper() for each in given[:3])
    attribute = ATTRIBUTES.get((kind, name))
    if attribute is None or not (written or attribute.write):
        known = [f"{a} {b}" for (a, b), row in ATTRIBUTES.items() if written or row.write]
        raise OperandError(f"there is no attribute {name} of {kind} here", f"there are {', '.join(known)}")
    if instance == THIS:
        instance = program_of(resolver.named(""))
    if not isinstance(given[3], Address):
        raise OperandError(f"{given[3]} is not a tag", "name a tag")
    return kind, instance, name, resolver.memory(given[3], written=written)


def _count(end: End, size: int) -> int:
    """Return how many elements hold that many bytes, as far as there are."""
    store, region, first = end
    return min(region.left(first, store), -(-size // region.size))


def _gsv(machine: Interpreter, kind: str, instance: str, name: str, target: Place | Group) -> None:
    data = ATTRIBUTES[kind, name].read(machine, instance)
    store, region, first = end = machine.end(target)
    count = _count(end, len(data))
    room = count * region.size
    data = data[:room]
    if len(data) < room:
        data += take(store, region, first, count)[len(data) :]
    put(store, region, first, count, data)


def _ssv(machine: Interpreter, kind: str, instance: str, name: str, source: Place | Group) -> None:
    attribute = ATTRIBUTES[kind, name]
    assert attribute.write is not None
    store, region, first = end = machine.end(source)
    size = len(attribute.read(machine, instance))
    attribute.write(machine, instance, take(store, region, first, _count(end, size))[:size])


# --- EVENT


def _event(machine: Interpreter, name: str) -> None:
    task = _task(machine, name)
    if task is not None and machine.scheduler is not None:
        machine.scheduler.trigger(task)


# --- the rows

EVENT = action("EVENT", Use.LABEL, run=_event)
GSV = action(
    "GSV",
    Use.LABEL,
    Use.LABEL,
    Use.LABEL,
    Use.DESTINATION,
    resolve=lambda resolver, given: _resolve(resolver, given, written=True),
    run=_gsv,
)
SSV = action(
    "SSV",
    Use.LABEL,
    Use.LABEL,
    Use.LABEL,
    Use.SOURCE,
    resolve=lambda resolver, given: _resolve(resolver, given, written=False),
    run=_ssv,
)
