"""Connections: forward open and close [ODVA volume 1, 3-5.5]."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import count

from scanrack.io_images.enip.codes import (
    BAD_SIZE,
    CLOSE,
    CONNECTION_LEAST,
    CONNECTION_MOST,
    IN_USE,
    LARGE_OPEN,
    MANAGER,
    NO_CONNECTION,
    NO_PLACES,
    NO_SLOT,
    NO_TARGET,
    NOT_FOUND,
    OPEN,
    ROUTER,
    TOO_SHORT,
    CipRefusedError,
)
from scanrack.io_images.enip.paths import Path, parse_path

from .router import OWN_ROUTE, refused

CONNECTIONS_MOST = 16
"""Maximum connections of a client."""

_PATH = Path({"class": MANAGER, "instance": 1})
_SERVICES = (OPEN, LARGE_OPEN, CLOSE)
_OWN = 0x2000_0000

Triad = tuple[int, int, int]
"""Serial number of a connection, vendor and serial number of its originator."""


@dataclass(frozen=True, slots=True)
class Connection:
    """An open connection."""

    theirs: int  # its number in packets to the client
    most: int  # bytes of a packet to the client, with its sequence count
    triad: Triad


class Connections:
    """The connections of one client."""

    def __init__(self) -> None:
        self._open: dict[int, Connection] = {}
        self._numbers = count(_OWN + 1)

    def get(self, number: int) -> Connection | None:
        """Return a connection by the number that this server gave it."""
        return self._open.get(number)

    @staticmethod
    def is_meant(request: bytes) -> bool:
        """Whether a request opens or closes a connection; EIPScanner names the object by 16-bit segments."""
        if len(request) < 2 or request[0] not in _SERVICES:
            return False
        try:
            return parse_path(request[2 : 2 + 2 * request[1]]) == _PATH
        except CipRefusedError:
            return False

    def answer(self, request: bytes) -> bytes:
        """Open or close a connection; return the reply."""
        service, data = request[0], request[2 + 2 * request[1] :]
        try:
            reply = self._close(data) if service == CLOSE else self._begin(data, large=service == LARGE_OPEN)
        except CipRefusedError as refusal:
            return refused(service, refusal, CONNECTION_MOST)
        except (struct.error, IndexError):
            return refused(service, CipRefusedError(TOO_SHORT), CONNECTION_MOST)
        return bytes((service | 0x80, 0, 0, 0)) + reply

    def _begin(self, data: bytes, *, large: bool) -> bytes:
        client_id, serial, vendor, origin = struct.unpack_from("<IHHI", data, 6)
        form = struct.Struct("<II" if large else "<IH")
        there_us, _ = form.unpack_from(data, 22)
        back_us, back_parameters = form.unpack_from(data, 22 + form.size)
        offset = 22 + 2 * form.size + 1
        if len(data) < offset + 1 + 2 * data[offset]:
            raise CipRefusedError(TOO_SHORT)
        path = parse_path(data[offset + 1 : offset + 1 + 2 * data[offset]])
        if any(port != OWN_ROUTE for port in path.ports):
            raise CipRefusedError(NO_CONNECTION, NO_SLOT)
        if path.numbers.get("class") != ROUTER:
            raise CipRefusedError(NO_CONNECTION, NO_TARGET)
        size, triad = back_parameters & (0xFFFF if large else 0x1FF), (serial, vendor, origin)
        self._check(size, triad)
        own_id = next(self._numbers)
        self._open[own_id] = Connection(client_id, size, triad)
        return struct.pack("<IIHHIIIBB", own_id, client_id, *triad, there_us, back_us, 0, 0)

    def _check(self, size: int, triad: Triad) -> None:
        if any(connection.triad == triad for connection in self._open.values()):
            raise CipRefusedError(NO_CONNECTION, IN_USE)
        if len(self._open) >= CONNECTIONS_MOST:
            raise CipRefusedError(NO_CONNECTION, NO_PLACES)
        if not CONNECTION_LEAST <= size <= CONNECTION_MOST:
            raise CipRefusedError(NO_CONNECTION, BAD_SIZE)

    def _close(self, data: bytes) -> bytes:
        triad: Triad = struct.unpack_from("<HHI", data, 2)
        for number, connection in self._open.items():
            if connection.triad == triad:
                del self._open[number]
                return struct.pack("<HHIBB", *triad, 0, 0)
        raise CipRefusedError(NO_CONNECTION, NOT_FOUND)
