"""Identity, listing, templates, program name, clock, change counters."""

from __future__ import annotations

import struct
from bisect import bisect_left
from collections.abc import Mapping
from datetime import datetime, timedelta
from functools import lru_cache

from ...io_images.enip.codes import (
    BAD_SEGMENT,
    BAD_VALUE,
    DONE,
    GENERAL,
    GET_ALL,
    GET_LIST,
    GET_ONE,
    LISTING,
    NO_ATTRIBUTE,
    NO_SERVICE,
    NOT_SETTABLE,
    OFFSET_BEYOND,
    PARTIAL,
    READ,
    SOME_ATTRIBUTES,
    TOO_LARGE,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from ...io_images.enip.paths import Instance, Path
from .database import PROGRAM, Database, Row
from .room import Room
from .tag_services import HEAD_BYTES, Answer

ATTRIBUTES_MOST = 32
"""Most attributes that a request may name."""

SET_LIST = 4

_VENDOR, _DEVICE, _PRODUCT, _REVISION, _STATUS, _SERIAL = 1, 0x0E, 107, (33, 11), 0x3060, 0x5CA9_9ACC
"""A controller of Rockwell's, since clients look for one; the product's name says scanrack."""

EPOCH = datetime(1970, 1, 1)


def identity(name: bytes) -> bytes:
    """Return all attributes of the identity object [ODVA volume 1, 5-2]."""
    head = struct.pack("<HHHBBHI", _VENDOR, _DEVICE, _PRODUCT, *_REVISION, _STATUS, _SERIAL)
    return head + bytes([len(name)]) + name


_IDENTITY_PLACES = {1: (0, 2), 2: (2, 4), 3: (4, 6), 4: (6, 8), 5: (8, 10), 6: (10, 14), 7: (14, None)}


def answer_identity(whole: bytes, service: int, path: Path) -> Answer:
    """Answer a request to the identity object."""
    if service == GET_ALL:
        return DONE, whole
    if service != GET_ONE:
        raise CipRefusedError(NO_SERVICE)
    place = _IDENTITY_PLACES.get(path.numbers.get("attribute", 0))
    if place is None:
        raise CipRefusedError(NO_ATTRIBUTE)
    return DONE, whole[place[0] : place[1]]


def attributes_in(data: bytes) -> tuple[int, ...]:
    """Return the attributes that a request names."""
    (count,) = struct.unpack_from("<H", data)
    if count > ATTRIBUTES_MOST:
        raise CipRefusedError(BAD_VALUE)
    return struct.unpack_from(f"<{count}H", data, 2)


def answer_attributes(service: int, data: bytes, values: Mapping[int, bytes], most: int) -> Answer:
    """Answer a request for a list of attributes."""
    if service != GET_LIST:
        raise CipRefusedError(NO_SERVICE)
    wanted = attributes_in(data)
    out = struct.pack("<H", len(wanted))
    for each in wanted:
        value = values.get(each)
        out += (
            struct.pack("<HH", each, NO_ATTRIBUTE)
            if value is None
            else struct.pack("<HH", each, DONE) + value
        )
    if len(out) > most - HEAD_BYTES:
        raise CipRefusedError(TOO_LARGE)
    return (DONE if all(each in values for each in wanted) else SOME_ATTRIBUTES), out


# --- the listing of tags


class Lister:
    """Lists the tags of a database in parts; keeps the lines of the latest kinds of requests."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lines = lru_cache(maxsize=64)(self._made)

    def answer(self, service: int, path: Path, data: bytes, most: int) -> Answer:
        """Answer a request for lines from an instance on."""
        if service != LISTING:
            raise CipRefusedError(NO_SERVICE)
        scope = _scope_of(path)
        numbers, lines = self._lines(scope.upper(), attributes_in(data))
        first = at = bisect_left(numbers, path.numbers.get("instance", 0))
        left = most - HEAD_BYTES
        while at < len(lines) and len(lines[at]) <= left:
            left -= len(lines[at])
            at += 1
        if at == first < len(lines):
            raise CipRefusedError(TOO_LARGE)
        return (DONE if at == len(lines) else PARTIAL), b"".join(lines[first:at])

    def _made(self, scope: str, wanted: tuple[int, ...]) -> tuple[list[int], list[bytes]]:
        rows = self._database.rows(scope)
        return [row[0] for row in rows], [_line(row, wanted) for row in rows]


def _scope_of(path: Path) -> str:
    names = [each for each in path.steps if not isinstance(each, Instance)]
    if not names:
        return ""
    if len(names) > 1 or not str(names[0]).lower().startswith(PROGRAM.lower()):
        raise CipRefusedError(BAD_SEGMENT)
    return str(names[0])[len(PROGRAM) :]


def _line(row: Row, wanted: tuple[int, ...]) -> bytes:
    number, name, code, size, dims, access = row
    text = name.encode("ascii", "replace")
    values = {
        1: struct.pack("<H", len(text)) + text,
        2: struct.pack("<H", code),
        3: struct.pack("<I", 0x1000 + number * 16),  # addresses: clients compare them only
        5: struct.pack("<I", 0x2000 + number * 16),
        6: struct.pack("<I", 1 << 26),
        7: struct.pack("<H", size),
        8: struct.pack("<III", *(*dims, 0, 0, 0)[:3]),
        10: bytes([access]),
    }
    if any(each not in values for each in wanted):
        raise CipRefusedError(NO_ATTRIBUTE)
    return struct.pack("<I", number) + b"".join(values[each] for each in wanted)


def answer_template(database: Database, service: int, path: Path, data: bytes, most: int) -> Answer:
    """Answer a request to a template: its attributes, or a part of its definition."""
    found = database.templates.by_number.get(path.numbers.get("instance", 0))
    if found is None:
        raise CipRefusedError(UNKNOWN_OBJECT)
    if service != READ:
        values = {
            1: struct.pack("<H", found.handle),
            2: struct.pack("<H", len(found.kind.parts)),
            3: struct.pack("<H", 0),
            4: struct.pack("<I", found.words),
            5: struct.pack("<I", found.kind.size),
        }
        return answer_attributes(service, data, values, most)
    offset, size = struct.unpack_from("<IH", data)
    if offset > len(found.padded):
        raise CipRefusedError(GENERAL, OFFSET_BEYOND)
    part = found.padded[offset : offset + size]
    if len(part) <= most - HEAD_BYTES:
        return DONE, part
    if most - HEAD_BYTES < 1:
        raise CipRefusedError(TOO_LARGE)
    return PARTIAL, part[: most - HEAD_BYTES]


def answer_clock(service: int, data: bytes, room: Room, most: int) -> Answer:
    """Answer a request to the wall clock: virtual time since 1970."""
    if service == SET_LIST:
        raise CipRefusedError(NOT_SETTABLE)
    micros = room.now_ns // 1000
    if service == GET_ALL:
        return DONE, struct.pack("<Q", micros)
    now = EPOCH + timedelta(microseconds=micros)
    day = (now.year, now.month, now.day, now.hour, now.minute, now.second, now.microsecond)
    values = {number: struct.pack("<Q", micros) for number in (6, 8, 11, 12)}
    values |= dict.fromkeys((5, 7), struct.pack("<7i", *day))
    return answer_attributes(service, data, values, most)


def answer_changes(service: int, data: bytes, room: Room, most: int) -> Answer:
    """Answer a request to the change counters: they count edits of the program."""
    edits = struct.pack("<I", room.version)
    values = {1: struct.pack("<H", 1), 2: edits[:2], 3: edits, 4: edits, 10: edits}
    return answer_attributes(service, data, values, most)
