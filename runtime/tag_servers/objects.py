"""Identity, network interface, listing, templates, program name, clock, change counters."""

from __future__ import annotations

import struct
from bisect import bisect_left
from collections.abc import Callable, Mapping
from datetime import datetime, timedelta
from itertools import islice
from operator import attrgetter

from scanrack.io_images.enip.codes import (
    BAD_SEGMENT,
    BAD_VALUE,
    DONE,
    ETHERNET_LINK,
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
    TCP_IP_INTERFACE,
    TOO_LARGE,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from scanrack.io_images.enip.paths import PROGRAM, Instance, Path

from .database import Database, Row
from .tag_services import HEAD_BYTES, Answer
from .tag_snapshot import TagSnapshot

ATTRIBUTES_MOST = 32
"""Maximum number of attributes that a request may name."""

SET_LIST = 4

_VENDOR, _DEVICE, _PRODUCT, _REVISION, _STATUS, _SERIAL = 1, 0x0E, 107, (33, 11), 0x3060, 0x5CA9_9ACC
"""Identity values of a Rockwell controller, because clients check them; the product name is scanrack."""

EPOCH = datetime(1970, 1, 1)
_CONTROLLER = (_VENDOR, _DEVICE, _PRODUCT, *_REVISION)


def identity(name: bytes, kind: tuple[int, ...] = _CONTROLLER, status: int = _STATUS) -> bytes:
    """Return all attributes of the identity object [ODVA volume 1, 5-2].

    Args:
        kind: vendor, device type, product code, major and minor revision.
    """
    head = struct.pack("<HHHBBHI", *kind, status, _SERIAL)
    return head + bytes([len(name)]) + name


# First and end byte of each attribute
_IDENTITY_SPANS = {1: (0, 2), 2: (2, 4), 3: (4, 6), 4: (6, 8), 5: (8, 10), 6: (10, 14), 7: (14, None)}


def answer_identity(attributes: bytes, service: int, path: Path) -> Answer:
    """Answer a request to the identity object."""
    return _answer_values(
        {number: attributes[begin:end] for number, (begin, end) in _IDENTITY_SPANS.items()}, service, path
    )


def _answer_values(values: Mapping[int, bytes], service: int, path: Path) -> Answer:
    """Answer a request for one or all read-only attributes."""
    if service == GET_ALL:
        return DONE, b"".join(values.values())
    if service != GET_ONE:
        raise CipRefusedError(NO_SERVICE)
    value = values.get(path.numbers.get("attribute", 0))
    if value is None:
        raise CipRefusedError(NO_ATTRIBUTE)
    return DONE, value


# --- the network interface

INTERFACES = (TCP_IP_INTERFACE, ETHERNET_LINK)
LOOPBACK = b"\x7f\0\0\1"

_CONFIGURED, _LINK_UP, _SPEED_MBPS = 1, 0x0F, 1000  # 0Fh: link, full duplex, speed and duplex negotiated
_NO_NAME = struct.pack("<H", 0)
_HARDWARE_ADDRESS = b"\x02\0" + _SERIAL.to_bytes(4, "big")  # locally administered
_CLASS_OF_ONE = dict.fromkeys((1, 2, 3), struct.pack("<H", 1))  # revision, greatest instance, instances


def answer_interface(address: bytes, service: int, path: Path) -> Answer:
    """Answer a request to the TCP/IP interface or the Ethernet link object [ODVA volume 2, 5-4 and 5-5].

    Args:
        address: IPv4 address of the server; mask, gateway and names are 0 (not configured).
    """
    link = struct.pack("<HBBBB", 2, 0x20, ETHERNET_LINK, 0x24, 1)  # number of words in a path; the path
    objects: Mapping[tuple[int | None, int | None], Mapping[int, bytes]] = {
        (TCP_IP_INTERFACE, 1): {
            1: struct.pack("<I", _CONFIGURED),
            2: bytes(4),  # capability: nothing can be set
            3: bytes(4),  # control: a static address
            4: link,
            5: address[::-1] + bytes(16) + _NO_NAME,
            6: _NO_NAME,
        },
        (ETHERNET_LINK, 1): {
            1: struct.pack("<I", _SPEED_MBPS),
            2: struct.pack("<I", _LINK_UP),
            3: _HARDWARE_ADDRESS,
        },
        (TCP_IP_INTERFACE, 0): _CLASS_OF_ONE,
        (ETHERNET_LINK, 0): _CLASS_OF_ONE,
    }
    values = objects.get((path.numbers.get("class"), path.numbers.get("instance")))
    if values is None:
        raise CipRefusedError(UNKNOWN_OBJECT)
    return _answer_values(values, service, path)


def attributes_in(data: bytes) -> tuple[int, ...]:
    """Return the attributes that a request names."""
    (attribute_count,) = struct.unpack_from("<H", data)
    if attribute_count > ATTRIBUTES_MOST:
        raise CipRefusedError(BAD_VALUE)
    return struct.unpack_from(f"<{attribute_count}H", data, 2)


def answer_attributes(service: int, data: bytes, values: Mapping[int, bytes], most: int) -> Answer:
    """Answer a request for a list of attributes."""
    if service != GET_LIST:
        raise CipRefusedError(NO_SERVICE)
    numbers = attributes_in(data)
    out = struct.pack("<H", len(numbers))
    for number in numbers:
        out += struct.pack("<HH", number, DONE if number in values else NO_ATTRIBUTE) + values.get(
            number, b""
        )
    if len(out) > most - HEAD_BYTES:
        raise CipRefusedError(TOO_LARGE)
    return (DONE if all(number in values for number in numbers) else SOME_ATTRIBUTES), out


# --- the listing of tags


class Lister:
    """A service that lists the tags of a database in parts."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def answer(self, service: int, path: Path, data: bytes, most: int) -> Answer:
        """Answer a request for the lines of the listing from a given instance."""
        if service != LISTING:
            raise CipRefusedError(NO_SERVICE)
        scope = _scope_of(path)
        numbers, rows = attributes_in(data), self._database.rows(scope)
        if not all(number in _ATTRIBUTES for number in numbers):
            raise CipRefusedError(NO_ATTRIBUTE)
        first_row = bisect_left(rows, path.numbers.get("instance", 0), key=attrgetter("number"))
        bytes_left, lines = most - HEAD_BYTES, []
        for row in islice(rows, first_row, None):
            lines.append(_line(row, numbers))
            bytes_left -= len(lines[-1])
            if bytes_left < 0:
                break
        if bytes_left >= 0:
            return DONE, b"".join(lines)
        if len(lines) == 1:
            raise CipRefusedError(TOO_LARGE)
        return PARTIAL, b"".join(lines[:-1])


def _scope_of(path: Path) -> str:
    """Return the name of the program in a path, or "" without one; refuse any other name."""
    names = [step for step in path.steps if not isinstance(step, Instance)]
    if not names:
        return ""
    if len(names) > 1 or not str(names[0]).lower().startswith(PROGRAM.lower()):
        raise CipRefusedError(BAD_SEGMENT)
    return str(names[0])[len(PROGRAM) :]


def _symbol_name(row: Row) -> bytes:
    text = row.name.encode("ascii", "replace")
    return struct.pack("<H", len(text)) + text


_ATTRIBUTES: Mapping[int, Callable[[Row], bytes]] = {
    1: _symbol_name,
    2: lambda row: struct.pack("<H", row.type_code),
    3: lambda row: struct.pack("<I", 0x1000 + row.number * 16),  # an address, which clients only compare
    5: lambda row: struct.pack("<I", 0x2000 + row.number * 16),
    6: lambda _: struct.pack("<I", 1 << 26),
    7: lambda row: struct.pack("<H", row.element_size),
    8: lambda row: struct.pack("<III", *(*row.dims, 0, 0, 0)[:3]),
    10: lambda row: bytes([row.access]),
}
"""Functions that return a symbol's attributes, by attribute number."""


def _line(row: Row, numbers: tuple[int, ...]) -> bytes:
    return struct.pack("<I", row.number) + b"".join([_ATTRIBUTES[number](row) for number in numbers])


def answer_template(database: Database, service: int, path: Path, data: bytes, most: int) -> Answer:
    """Answer a request for attributes of a template, or for part of its definition."""
    template = database.templates.by_number.get(path.numbers.get("instance", 0))
    if template is None:
        raise CipRefusedError(UNKNOWN_OBJECT)
    if service != READ:
        values = {
            1: struct.pack("<H", template.handle),
            2: struct.pack("<H", len(template.kind.parts)),
            3: struct.pack("<H", 0),
            4: struct.pack("<I", template.words),
            5: struct.pack("<I", template.kind.size),
        }
        return answer_attributes(service, data, values, most)
    offset, size = struct.unpack_from("<IH", data)
    if offset > len(template.padded):
        raise CipRefusedError(GENERAL, OFFSET_BEYOND)
    definition_part = template.padded[offset : offset + size]
    if len(definition_part) <= most - HEAD_BYTES:
        return DONE, definition_part
    if most - HEAD_BYTES < 1:
        raise CipRefusedError(TOO_LARGE)
    return PARTIAL, definition_part[: most - HEAD_BYTES]


def answer_clock(service: int, data: bytes, snapshot: TagSnapshot, most: int) -> Answer:
    """Answer a request to the wall clock; it shows virtual time since 1970."""
    if service == SET_LIST:
        raise CipRefusedError(NOT_SETTABLE)
    micros = snapshot.now_ns // 1000
    if service == GET_ALL:
        return DONE, struct.pack("<Q", micros)
    now = EPOCH + timedelta(microseconds=micros)
    day = (now.year, now.month, now.day, now.hour, now.minute, now.second, now.microsecond)
    values = {number: struct.pack("<Q", micros) for number in (6, 8, 11, 12)}
    values |= dict.fromkeys((5, 7), struct.pack("<7i", *day))
    return answer_attributes(service, data, values, most)


def answer_changes(service: int, data: bytes, snapshot: TagSnapshot, most: int) -> Answer:
    """Answer a request to the change counters; they count program edits."""
    edits = struct.pack("<I", snapshot.version)
    values = {1: struct.pack("<H", 1), 2: edits[:2], 3: edits, 4: edits, 10: edits}
    return answer_attributes(service, data, values, most)
