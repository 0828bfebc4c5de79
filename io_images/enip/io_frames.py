"""Class 1 connections: the path of the open request, and packets [ODVA volume 1, 3-5.5; volume 2, 3-2].

The path of an open request has an electronic key, class and instance of the configuration assembly, the
consumed and the produced assembly, and configuration data:

    34 04 ...  20 04 24 6E  2C 96  2C 64  80 08 ...

A packet over UDP has two items: connection and packet count; sequence count and data.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from .codes import BAD_SEGMENT, CipRefusedError

SEQUENCED_ADDRESS, IO_DATA = 0x8002, 0x00B1
SOCKET_TO_TARGET, SOCKET_TO_ORIGINATOR = 0x8000, 0x8001
"""Types of the items that contain the socket address where the target or originator receives packets."""

IO_PORT = 2222
"""UDP port of class 1 packets."""

_LOGICAL = {0x20: "class", 0x24: "instance", 0x2C: "point"}
_KEY_SEGMENT, _DATA_SEGMENT = 0x34, 0x80
_HEAD = struct.Struct("<HHHIIHH")
_SOCKET = struct.Struct(">HH4s8x")
_KEY = struct.Struct("<HHHBB")
_INTERNET = 2


@dataclass(frozen=True, slots=True)
class IoPath:
    """The content of the path in an open request."""

    key: tuple[int, ...]  # vendor, device type, product code, major revision and flag, minor; () without
    numbers: dict[str, int]  # of `class` and `instance`
    points: tuple[int, ...]  # the connection points: consumed and produced assembly
    data: bytes | None  # of the configuration; None without


def io_path(data: bytes) -> IoPath:
    r"""Read the path of an open request.

    >>> path = io_path(bytes.fromhex("20 04 24 6E 2C 96 2C 64 80 01 00 04"))
    >>> path.numbers, path.points, path.data
    ({'class': 4, 'instance': 110}, (150, 100), b'\x00\x04')

    Raises:
        CipRefusedError: the data is not the path of an open request.
    """
    key: tuple[int, ...] = ()
    numbers: dict[str, int] = {}
    points: list[int] = []
    settings: bytes | None = None
    offset = 0
    while offset + 2 <= len(data):
        kind, value, size = data[offset], data[offset + 1], 2
        if kind == _KEY_SEGMENT and offset + 2 + _KEY.size <= len(data):
            size = 2 + _KEY.size
            key = _KEY.unpack_from(data, offset + 2)
        elif kind == _DATA_SEGMENT:
            size = 2 + 2 * value
            settings = data[offset + 2 : offset + size]
        elif kind & ~1 in _LOGICAL:
            if kind & 1:
                size = 4
                value = int.from_bytes(data[offset + 2 : offset + size], "little")
            if _LOGICAL[kind & ~1] == "point":
                points.append(value)
            else:
                numbers[_LOGICAL[kind & ~1]] = value
        elif not 0 < kind < 0x10:  # a port: part of the route to this device
            raise CipRefusedError(BAD_SEGMENT)
        offset += size
    if offset != len(data):
        raise CipRefusedError(BAD_SEGMENT)
    return IoPath(key, numbers, tuple(points), settings)


@dataclass(frozen=True, slots=True)
class IoPacket:
    """A data packet.

    Attributes:
        connection: the connection ID that the receiver chose.
        count: packet count, 32 bits.
        sequence: sequence count of the data, 16 bits; it changes only when the data changes.
    """

    connection: int
    count: int
    sequence: int
    data: bytes

    def encoded(self) -> bytes:
        r"""Return the datagram.

        >>> IoPacket(1, 2, 3, b"\4\0").encoded().hex(" ")
        '02 00 02 80 08 00 01 00 00 00 02 00 00 00 b1 00 04 00 03 00 04 00'
        """
        size = 2 + len(self.data)
        head = _HEAD.pack(2, SEQUENCED_ADDRESS, 8, self.connection, self.count, IO_DATA, size)
        return head + struct.pack("<H", self.sequence) + self.data


def io_packet(datagram: bytes) -> IoPacket | None:
    r"""Return the packet in a datagram; None for any other datagram.

    >>> io_packet(IoPacket(1, 2, 3, b"\4\0").encoded()) == IoPacket(1, 2, 3, b"\4\0")
    True
    """
    if len(datagram) < _HEAD.size + 2:
        return None
    item_count, kind, size, connection, number, data_type, length = _HEAD.unpack_from(datagram)
    if (item_count, kind, size, data_type) != (2, SEQUENCED_ADDRESS, 8, IO_DATA):
        return None
    if length != len(datagram) - _HEAD.size:
        return None
    (sequence,) = struct.unpack_from("<H", datagram, _HEAD.size)
    return IoPacket(connection, number, sequence, datagram[_HEAD.size + 2 :])


def socket_item(port: int) -> tuple[int, bytes]:
    """Return the item with a target's UDP port; its address is the address of the TCP connection."""
    return SOCKET_TO_TARGET, _SOCKET.pack(_INTERNET, port, bytes(4))


def port_in(items: list[tuple[int, bytes]]) -> int:
    """Return the UDP port at which an originator receives packets; by default 2222."""
    for kind, data in items:
        if kind == SOCKET_TO_ORIGINATOR and len(data) == _SOCKET.size:
            return int(_SOCKET.unpack(data)[1])
    return IO_PORT
