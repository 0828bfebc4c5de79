"""EVENT, and GSV and SSV for the objects of a controller [1756-RM003N, system values].

An attribute is a row of `ATTRIBUTES`. The row has a function that returns the attribute as bytes and, unless
it is read-only, a function that sets it from bytes. The tag of GSV and SSV can be a structure, an array, or
the first member of a structure, as in exports. WallClockTime is the virtual time, which is 1970-01-01 00:00
at power-up, until SSV sets it. Attributes that the runtime does not compute are stored in memory; see
`objects`.
"""

from __future__ import annotations

import datetime
import struct
from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ...compiler.attributes import write_gsv
from ...interpreter import Interpreter
from ...model.arithmetic import wrap
from ...model.errors import LadderError
from ...model.operand_checks import OperandError
from ...model.operands import Group, Place
from ...model.predefined.motion_types import BY_CLASS
from ...model.schedule import ScheduledProgram, ScheduledTask, task_named
from ...model.spec import Spec, Use, action
from ...model.tags import program_of
from ...model.tree import Address, Operand
from ...model.types import HIDDEN
from ...state.lowered import OperandResolver
from ...state.regions import End
from .objects import OBJECTS, StoredValue, stored_value

THIS = "THIS"
"""Instance name for the program of the instruction, or for its task."""

_TASK_OF = "THIS:"
"""Prefix of a program's name in GSV and SSV of a task; it selects the task of this program."""

POWER_UP = datetime.datetime(1970, 1, 1)
"""WallClockTime at virtual time 0."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute of an object."""

    read: Callable[[Interpreter, str], bytes]  # returns bytes, given machine and instance in capitals
    write: Callable[[Interpreter, str, bytes], None] | None = None  # sets it from bytes; None if read-only


# --- PROGRAM

_RECORD = struct.Struct("<qhh8i")  # MajorFaultRecord: time in µs, type, code, eight words of information

_FAULT = struct.Struct("<hh")
_FAULT_AT = 8  # type and code in a fault record, and their offset in bytes


def _program(machine: Interpreter, name: str) -> ScheduledProgram | None:
    """Return a program by its name in capitals, the first program for "", or None if unknown."""
    schedule = machine.lowered.schedule
    programs = schedule.programs if schedule is not None else ()
    return next((program for program in programs if not name or program.name.upper() == name), None)


def _read_major_fault(machine: Interpreter, name: str) -> bytes:
    """Return the MajorFaultRecord of a program.

    Its time is the time of the read, because a record exists only in the scan of the fault, in the fault
    routine.
    """
    program = _program(machine, name)
    if program is None:
        return bytes(_RECORD.size)
    kind, code = (
        machine.whole(machine.memory.read(leaf)) for leaf in (program.fault_type, program.fault_code)
    )
    no_information = [0] * 8
    return _RECORD.pack(machine.now_ns // 1_000 if kind else 0, kind, code, *no_information)


def _write_major_fault(machine: Interpreter, name: str, data: bytes) -> None:
    """Set a program's fault type and code from a MajorFaultRecord; ignore a record that is too short."""
    program = _program(machine, name)
    if program is None or len(data) < _FAULT_AT + _FAULT.size:
        return
    for leaf, value in zip(
        (program.fault_type, program.fault_code), _FAULT.unpack_from(data, _FAULT_AT), strict=True
    ):
        machine.memory.write(leaf, 0, value)


# --- TASK


def _task(machine: Interpreter, name: str) -> ScheduledTask | None:
    """Return the task with a name, or the task of a program; see `_TASK_OF`."""
    schedule = machine.lowered.schedule
    if schedule is None:
        return None
    if not name.startswith(_TASK_OF):
        return task_named(schedule.tasks, name)
    owner = name.removeprefix(_TASK_OF)
    for task in schedule.tasks:
        if any(program.name.upper() == owner for program in task.programs):
            return task
    return None


Reader = Callable[[Interpreter, str], bytes]


def _of_task(code: str, value: Callable[[Interpreter, ScheduledTask], int]) -> Reader:
    """Return a function that reads a numeric attribute of a task."""

    def read(machine: Interpreter, name: str) -> bytes:
        task = _task(machine, name)
        return struct.pack(code, value(machine, task) if task is not None else 0)

    return read


def _write_overlaps(machine: Interpreter, name: str, data: bytes) -> None:
    task = _task(machine, name)
    if task is not None and len(data) >= 4:
        machine.memory.write(task.overlaps, 0, struct.unpack_from("<i", data)[0])


# --- WALLCLOCKTIME


CLOCK = "WALLCLOCKTIME"
_LATEST_US = 8_000 * 365 * 86_400 * 1_000_000  # maximum setting of the clock, µs since power-up


def _path(kind: str, instance: str, name: str) -> str:
    """Return the path of an attribute that is stored in memory."""
    return f"{HIDDEN}gsv.{kind}.{instance}.{name}"


_OFFSET = _path(CLOCK, "", "OFFSET")


def _virtual_us(machine: Interpreter) -> int:
    return machine.now_ns // 1_000


def _wall_us(machine: Interpreter) -> int:
    leaf = machine.lowered.layout.find(_OFFSET)
    offset = machine.whole(machine.memory.read(leaf)) if leaf is not None else 0
    return _virtual_us(machine) + offset


def _set_wall(machine: Interpreter, now_us: int) -> None:
    """Set the clock; ignore a time out of range."""
    leaf = machine.lowered.layout.find(_OFFSET)
    if leaf is not None and 0 <= now_us < _LATEST_US:
        machine.memory.write(leaf, 0, now_us - _virtual_us(machine))


def _of_clock(value: Callable[[Interpreter], int]) -> Reader:
    """Return a function that reads the time of a clock."""
    return lambda machine, _name: struct.pack("<q", value(machine))


def _write_microseconds(machine: Interpreter, _name: str, data: bytes) -> None:
    if len(data) >= 8:
        _set_wall(machine, struct.unpack_from("<q", data)[0])


def _date(machine: Interpreter, _name: str) -> bytes:
    return _date_at(_wall_us(machine))


@lru_cache(maxsize=4)
def _date_at(wall_us: int) -> bytes:
    """Return the date at an instant. It is cached, because several instructions in a scan can need it."""
    now = POWER_UP + datetime.timedelta(microseconds=wall_us)
    day = now.year, now.month, now.day
    return struct.pack("<7i", *day, now.hour, now.minute, now.second, now.microsecond)


def _write_date(machine: Interpreter, _name: str, data: bytes) -> None:
    """Set the clock from seven DINTs, from year to microsecond; ignore other data."""
    if len(data) < 28:
        return
    try:
        moment = datetime.datetime(*struct.unpack_from("<7i", data))
    except (ValueError, OverflowError):  # not a date: the clock is not set
        return
    _set_wall(machine, (moment - POWER_UP) // datetime.timedelta(microseconds=1))


# --- names


_NAME_SIZE = 82


def _name_of(_machine: Interpreter, name: str) -> bytes:
    """Return a name as a STRING."""
    text = name.encode("latin-1", "replace")[:_NAME_SIZE]
    return struct.pack("<i", len(text)) + text.ljust(_NAME_SIZE, b"\0")


def _name_of_task(machine: Interpreter, name: str) -> bytes:
    """Return the name of a task in capitals, like the names of other instances; "" for an unknown task."""
    task = _task(machine, name)
    return _name_of(machine, task.task.name.upper() if task is not None else "")


ATTRIBUTES: Mapping[tuple[str, str], Attribute] = {
    ("PROGRAM", "MAJORFAULTRECORD"): Attribute(_read_major_fault, _write_major_fault),
    ("TASK", "RATE"): Attribute(_of_task("<i", lambda _machine, row: row.task.rate_ns // 1_000)),
    ("TASK", "PRIORITY"): Attribute(_of_task("<h", lambda _machine, row: row.task.priority)),
    ("TASK", "OVERLAPCOUNT"): Attribute(
        _of_task("<i", lambda machine, row: machine.whole(machine.memory.read(row.overlaps))),
        _write_overlaps,
    ),
    (CLOCK, "CURRENTVALUE"): Attribute(_of_clock(_wall_us), _write_microseconds),
    (CLOCK, "DATETIME"): Attribute(_date, _write_date),
    (CLOCK, "LOCALDATETIME"): Attribute(_date, _write_date),
    ("CST", "CURRENTVALUE"): Attribute(_of_clock(_virtual_us)),
    ("TIMESYNCHRONIZE", "CURRENTTIMEMICROSECONDS"): Attribute(_of_clock(_virtual_us)),
    ("TIMESYNCHRONIZE", "CURRENTTIMENANOSECONDS"): Attribute(_of_clock(lambda machine: machine.now_ns)),
    ("CONTROLLER", "NAME"): Attribute(lambda machine, _name: _name_of(machine, machine.lowered.name)),
    **{(kind, "NAME"): Attribute(_name_of) for kind in ("MODULE", "PROGRAM", "ROUTINE")},
    ("TASK", "NAME"): Attribute(_name_of_task),
}
"""Attributes that the runtime computes, by class and name in capitals."""


def _attribute_of(kind: str, name: str, stored: StoredValue) -> Attribute:
    """Return an attribute that is stored in memory."""

    def read(machine: Interpreter, instance: str) -> bytes:
        leaf = machine.lowered.layout.leaf(_path(kind, instance, name))
        return machine.bytes_of(machine.whole(machine.memory.read(leaf)), stored.size)

    def write(machine: Interpreter, instance: str, data: bytes) -> None:
        leaf = machine.lowered.layout.leaf(_path(kind, instance, name))
        number = machine.integer_in(data[: min(8, stored.size)])
        machine.memory.write(leaf, 0, wrap(number, 64))

    return Attribute(read, write if stored.set else None)


@lru_cache(maxsize=256)
def _attribute(kind: str, name: str) -> Attribute | None:
    """Return an attribute that is computed or stored in memory; None if it does not exist."""
    stored = stored_value(kind, name)
    return ATTRIBUTES.get((kind, name)) or (None if stored is None else _attribute_of(kind, name, stored))


def _choices(kind: str, *, written: bool) -> str:
    """List the attributes of a class, or the classes if it has none.

    For SSV, which does not write a tag, list only attributes that can be set.
    """
    rows = [attribute for attribute, row in ATTRIBUTES.items() if written or row.write]
    for owner, stored in OBJECTS.items():
        rows += [(owner, name) for name, row in stored.items() if written or row.set]
    names = [name for class_name, name in rows if class_name == kind]
    return ", ".join(names or dict.fromkeys(class_name for class_name, _ in rows))


def _resolve(
    resolver: OperandResolver, operands: tuple[Operand, ...], *, written: bool
) -> tuple[str, str | Place, str, Place | Group]:
    """Return class, instance and attribute in capitals, and the tag.

    For an axis, the instance is the member of its tag that has the attribute.
    """
    kind, instance, name = (str(word).upper() for word in operands[:3])
    tag = operands[3]
    if kind in BY_CLASS and isinstance(operands[1], Address) and isinstance(tag, Address):
        member = _member(resolver, operands[1], str(operands[2]))
        return kind, member, name, resolver.memory(tag, written=written)
    attribute = _attribute(kind, name)
    if attribute is None or not (written or attribute.write):
        choices = _choices(kind, written=written)
        raise OperandError(f"no attribute {name} of {kind}", f"choose from {choices}")
    if kind == "CONTROLLER":
        instance = ""  # the controller is the only instance
    if instance == THIS:
        program = program_of(resolver.named(""))
        instance = f"{_TASK_OF}{program}" if kind == "TASK" else program
    _reserve(resolver, kind, instance, name)
    if not isinstance(tag, Address):
        raise OperandError(f"{tag} is not a tag", "name a tag")
    return kind, instance, name, resolver.memory(tag, written=written)


def _reserve(resolver: OperandResolver, kind: str, instance: str, name: str) -> None:
    """Reserve memory for a stored attribute, and for the clock offset."""
    stored = None if (kind, name) in ATTRIBUTES else stored_value(kind, name)
    if stored is not None:
        resolver.kept(_path(kind, instance, name), stored.initial)
    elif kind == CLOCK:
        resolver.kept(_OFFSET, 0)


def _member(resolver: OperandResolver, tag: Address, name: str) -> Place:
    """Return the member of an axis's tag for an attribute; raise an OperandError if it is missing."""
    try:
        member = resolver.any_operand(tag.member(name))
    except LadderError:
        member = None
    if not isinstance(member, Place) or member.type.is_bool:
        raise OperandError(f"{tag} has no attribute {name}", "name a member of the tag")
    return member


def _read(machine: Interpreter, kind: str, instance: str | Place, name: str) -> bytes:
    """Return the bytes of an attribute; for an axis, `instance` is the member of its tag."""
    if isinstance(instance, Place):
        store, region, first = machine.end(instance)
        return machine.take_bytes(store, region, first, 1)
    attribute = _attribute(kind, name)
    assert attribute is not None
    return attribute.read(machine, instance)


def _element_count(end: End, size: int) -> int:
    """Return the number of elements in `size` bytes, limited to the array."""
    store, region, first = end
    return min(region.left(first, store), -(-size // region.size))


def _gsv(machine: Interpreter, kind: str, instance: str | Place, name: str, target: Place | Group) -> None:
    """Copy the bytes of an attribute to the target, up to the end of its array."""
    data = _read(machine, kind, instance, name)
    store, region, first = end = machine.end(target)
    count = _element_count(end, len(data))
    room = count * region.size
    data = data[:room]
    if len(data) < room:  # the last element keeps its other bytes
        data += machine.take_bytes(store, region, first, count)[len(data) :]
    machine.put_bytes(store, region, first, count, data)


def _ssv(machine: Interpreter, kind: str, instance: str | Place, name: str, source: Place | Group) -> None:
    """Set an attribute from the bytes of the source; for an axis, only if there are enough bytes."""
    store, region, first = end = machine.end(source)
    size = len(_read(machine, kind, instance, name))
    data = machine.take_bytes(store, region, first, _element_count(end, size))[:size]
    if isinstance(instance, Place):
        store, region, first = machine.end(instance)
        if len(data) == size:
            machine.put_bytes(store, region, first, 1, data)
        return
    attribute = _attribute(kind, name)
    assert attribute is not None
    assert attribute.write is not None
    attribute.write(machine, instance, data)


# --- EVENT


def _event(machine: Interpreter, name: str) -> None:
    task = _task(machine, name)
    if task is not None and machine.scheduler is not None:
        machine.scheduler.trigger(task)


# --- the rows


def _row(name: str, use: Use, *, written: bool, **parts: Any) -> Spec:
    resolve = partial(_resolve, written=written)
    return action(name, Use.LABEL, Use.LABEL, Use.LABEL, use, resolve=resolve, **parts)


EVENT = action("EVENT", Use.LABEL, run=_event)
GSV = _row(
    "GSV",
    Use.DESTINATION,
    written=True,
    run=_gsv,
    write=write_gsv,
    fetch=lambda machine, *operands: _read(machine, *operands[:3]),
    partly=True,
    faults=False,
)
SSV = _row("SSV", Use.SOURCE, written=False, run=_ssv)
