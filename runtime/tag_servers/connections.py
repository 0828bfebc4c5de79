"""Opening and closing of connections with Forward Open and Forward Close [ODVA volume 1, 3-5.5]."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

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
"""Maximum number of connections per client."""

_PATH = Path({"class": MANAGER, "instance": 1})
_SERVICES = (OPEN, LARGE_OPEN, CLOSE)
_FIRST_ID = 0x2000_0001
_SMALL_OPEN, _LARGE_OPEN = struct.Struct("<6xIHHIB3xIHIHBB"), struct.Struct("<6xIHHIB3xIIIIBB")

Triad = tuple[int, int, int]
"""Serial number of a connection, vendor and serial number of its originator."""


class Direction(NamedTuple):
    """One direction of a requested connection."""

    interval_us: int  # requested packet interval
    size: int  # bytes of a packet, with its sequence count
    type: int  # 2 = point to point


class ForwardOpen(NamedTuple):
    """The data of a Forward Open or a Large Forward Open [ODVA volume 1, 3-5.5.2]."""

    client_id: int  # number of the connection in packets to the client
    triad: Triad
    multiplier: int  # the time-out is 4 << multiplier packet intervals
    to_target: Direction
    to_client: Direction
    transport: int  # trigger and class
    path: bytes

    def reply(self, own_id: int) -> bytes:
        """Return the reply data, with the connection number that packets to this server must carry."""
        intervals_us = self.to_target.interval_us, self.to_client.interval_us
        return struct.pack("<IIHHIIIBB", own_id, self.client_id, *self.triad, *intervals_us, 0, 0)


def forward_open_in(data: bytes, *, large: bool) -> ForwardOpen:
    """Return the request in the data of a (Large) Forward Open; refuse data that is too short."""
    form = _LARGE_OPEN if large else _SMALL_OPEN
    if len(data) < form.size or len(data) < form.size + 2 * data[form.size - 1]:
        raise CipRefusedError(TOO_SHORT)
    client_id, serial, vendor, originator, multiplier, *directions, transport, words = form.unpack_from(data)
    target_us, target_parameters, client_us, client_parameters = directions
    size_mask, type_shift = (0xFFFF, 29) if large else (0x1FF, 13)
    return ForwardOpen(
        client_id=client_id,
        triad=(serial, vendor, originator),
        multiplier=multiplier,
        to_target=Direction(target_us, target_parameters & size_mask, target_parameters >> type_shift & 3),
        to_client=Direction(client_us, client_parameters & size_mask, client_parameters >> type_shift & 3),
        transport=transport,
        path=data[form.size : form.size + 2 * words],
    )


@dataclass(frozen=True, slots=True)
class Connection:
    """An open connection."""

    client_id: int  # its number in packets to the client
    max_size: int  # bytes of a packet to the client, with its sequence count
    triad: Triad


class Connections:
    """The connections of one client."""

    def __init__(self) -> None:
        self._open: dict[int, Connection] = {}
        self._numbers = count(_FIRST_ID)

    def get(self, own_id: int) -> Connection | None:
        """Return the connection with a number that this server assigned, or None."""
        return self._open.get(own_id)

    @staticmethod
    def accepts(request: bytes) -> bool:
        """Return whether a request opens or closes a connection."""
        if len(request) < 2 or request[0] not in _SERVICES:
            return False
        try:  # the path is parsed, since EIPScanner names the object by 16-bit segments
            return parse_path(request[2 : 2 + 2 * request[1]]) == _PATH
        except CipRefusedError:
            return False

    def answer(self, request: bytes) -> bytes:
        """Open or close a connection; return the reply."""
        service, data = request[0], request[2 + 2 * request[1] :]
        try:
            if service == CLOSE:
                reply = self._close(data)
            else:
                reply = self._begin(forward_open_in(data, large=service == LARGE_OPEN))
        except CipRefusedError as refusal:
            return refused(service, refusal, CONNECTION_MOST)
        except struct.error:
            return refused(service, CipRefusedError(TOO_SHORT), CONNECTION_MOST)
        return bytes((service | 0x80, 0, 0, 0)) + reply

    def _begin(self, request: ForwardOpen) -> bytes:
        """Open a connection to this controller's router, or refuse it; return the reply's data."""
        path = parse_path(request.path)
        if any(port != OWN_ROUTE for port in path.ports):
            raise CipRefusedError(NO_CONNECTION, NO_SLOT)
        if path.numbers.get("class") != ROUTER:
            raise CipRefusedError(NO_CONNECTION, NO_TARGET)
        self._check(request.to_client.size, request.triad)
        own_id = next(self._numbers)
        self._open[own_id] = Connection(request.client_id, request.to_client.size, request.triad)
        return request.reply(own_id)

    def _check(self, size: int, triad: Triad) -> None:
        """Refuse a connection that is already open, exceeds the limit, or has packets of a wrong size."""
        if any(connection.triad == triad for connection in self._open.values()):
            raise CipRefusedError(NO_CONNECTION, IN_USE)
        if len(self._open) >= CONNECTIONS_MOST:
            raise CipRefusedError(NO_CONNECTION, NO_PLACES)
        if not CONNECTION_LEAST <= size <= CONNECTION_MOST:
            raise CipRefusedError(NO_CONNECTION, BAD_SIZE)

    def _close(self, data: bytes) -> bytes:
        """Close the connection with the triad in the data, or refuse; return the reply's data."""
        triad: Triad = struct.unpack_from("<HHI", data, 2)
        for own_id, connection in self._open.items():
            if connection.triad == triad:
                del self._open[own_id]
                return struct.pack("<HHIBB", *triad, 0, 0)
        raise CipRefusedError(NO_CONNECTION, NOT_FOUND)
