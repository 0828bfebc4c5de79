"""A TCP connection: encapsulation frames, one session and its connections [ODVA volume 2, chapter 2]."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from scanrack.io_images.enip.codes import (
    BAD_COMMAND,
    BAD_DATA,
    BAD_LENGTH,
    BAD_REVISION,
    BAD_SESSION,
    FRAME_MOST,
    LIST_IDENTITY,
    LIST_INTERFACES,
    LIST_SERVICES,
    NOP,
    PORT,
    REGISTER,
    SEND,
    SEND_CONNECTED,
    UNCONNECTED_MOST,
    UNREGISTER,
)
from scanrack.io_images.enip.frames import (
    COMMAND_MOST,
    CONNECTED_ADDRESS,
    CONNECTED_DATA,
    HEAD,
    NO_ADDRESS,
    UNCONNECTED_DATA,
    body_of,
    items_in,
)

from .connections import Connections
from .objects import LOOPBACK
from .tag_snapshot import BrokenClientError, Plan, TagSnapshot

_COMMANDS = (NOP, LIST_SERVICES, LIST_IDENTITY, LIST_INTERFACES, REGISTER, UNREGISTER, SEND, SEND_CONNECTED)
_SERVICES = struct.pack("<HHHHH16s", 1, 0x100, 20, 1, 0x120, b"Communications")
_RUNNING = b"\x03"


@dataclass(frozen=True, slots=True)
class Frame:
    """A received frame."""

    command: int
    session: int
    context: bytes
    body: bytes
    status: int = 0  # status of the refusal; 0 = not refused


class Objects(Protocol):
    """Objects that answer requests."""

    @property
    def identity(self) -> bytes:
        """All attributes of the identity object."""

    def answer(self, request: bytes, snapshot: TagSnapshot, most: int, depth: int = 0) -> bytes:
        """Return the reply (service, status, data), at most `most` bytes long."""


class ClientSession:
    """The state of a client's connection.

    Attributes:
        pending: bytes of an incomplete frame.
    """

    _numbers = count(0x10100)

    def __init__(
        self,
        router: Objects,
        address: bytes = LOOPBACK,
        port: int = PORT,
        connections: Connections | None = None,
    ) -> None:
        self.router, self._address, self._port = router, address, port
        self.pending = b""
        self._handle = 0  # number of the session; 0 before the client has registered
        self._connections = connections or Connections()
        self._plan_key = (0, b"")  # version and body of the packet whose plan is cached
        self._cached_plan = Plan(0)

    def receive(self, data: bytes) -> list[Frame]:
        """Receive bytes; return the complete packets.

        Raises:
            BrokenClientError: the bytes are not a frame, or a frame is too long.
        """
        data = self.pending + data
        packets, offset = [], 0
        while len(data) >= offset + HEAD.size:
            command, length, session, _, context, options = HEAD.unpack_from(data, offset)
            if length > FRAME_MOST or command > COMMAND_MOST:
                raise BrokenClientError(f"no frame: {data[offset : offset + HEAD.size].hex(' ')}")
            end = offset + HEAD.size + length
            if len(data) < end:
                break
            body, offset = data[offset + HEAD.size : end], end
            if command not in _COMMANDS:
                packets.append(Frame(command, session, context, b"", BAD_COMMAND))
            elif options == 0 and command != NOP:  # frames with options are dropped; NOP has no answer
                packets.append(Frame(command, session, context, body))
        self.pending = data[offset:]
        return packets

    def plan(self, packet: Frame, version: int) -> Plan:
        """Return the operations of a packet, without any effect; a repeated packet reuses its plan."""
        if packet.command not in (SEND, SEND_CONNECTED) or not self._is_in_session(packet):
            return Plan(version)
        if self._plan_key != (version, packet.body):
            plan = Plan(version)
            self._answer_message(packet, plan, planning=True)
            self._plan_key, self._cached_plan = (version, packet.body), plan
        return self._cached_plan

    def reply(self, packet: Frame, snapshot: TagSnapshot) -> bytes:
        """Return the reply to a packet, or b"" if the packet needs no reply.

        Raises:
            BrokenClientError: the client ends its session.
        """
        status, body = (packet.status, b"") if packet.status else self._answer(packet, snapshot)
        if status < 0:
            return b""
        handle = self._handle if packet.command == REGISTER else packet.session
        return HEAD.pack(packet.command, len(body), handle, status, packet.context, 0) + body

    def _is_in_session(self, packet: Frame) -> bool:
        return self._handle != 0 and packet.session == self._handle

    def _answer(self, packet: Frame, snapshot: TagSnapshot) -> tuple[int, bytes]:
        """Return the status and body of the reply; a negative status means no reply."""
        if packet.command == REGISTER:
            return self._register(packet.body)
        if packet.command == LIST_IDENTITY:
            return 0, self.listed_identity()
        if packet.command == LIST_SERVICES:
            return 0, _SERVICES
        if packet.command == LIST_INTERFACES:
            return 0, bytes(2)
        if not self._is_in_session(packet):
            return BAD_SESSION, b""
        if packet.command == UNREGISTER:
            raise BrokenClientError("the client has ended its session")
        return self._answer_message(packet, snapshot, planning=False)

    def _register(self, body: bytes) -> tuple[int, bytes]:
        """Begin the session of the connection; return the status and body of the reply."""
        if len(body) != 4:
            return BAD_LENGTH, b""
        if body[:2] != b"\1\0":
            return BAD_REVISION, b"\1\0\0\0"
        if self._handle:
            return BAD_COMMAND, b""
        self._handle = next(self._numbers)
        return 0, body

    def _answer_message(self, packet: Frame, snapshot: TagSnapshot, *, planning: bool) -> tuple[int, bytes]:
        """Return the status and body of the reply to a request; a negative status means no reply.

        With `planning`, no connection is opened or closed.
        """
        items = items_in(packet.body)
        if len(items) < 2:
            return BAD_DATA, b""
        (address_type, address), (data_type, data) = items[:2]
        if packet.command == SEND:
            if (address_type, address, data_type) != (NO_ADDRESS, b"", UNCONNECTED_DATA):
                return BAD_DATA, b""
            message = self._answer_unconnected(data, snapshot, planning=planning)
            return 0, body_of((NO_ADDRESS, b""), (data_type, message))
        if (address_type, data_type) != (CONNECTED_ADDRESS, CONNECTED_DATA):
            return BAD_DATA, b""
        if len(address) != 4 or len(data) < 4:
            return BAD_DATA, b""
        connection = self._connections.get(int.from_bytes(address, "little"))
        if connection is None:
            return -1, b""  # a controller does not answer
        message = self.router.answer(data[2:], snapshot, connection.max_size - 2)
        client_id = struct.pack("<I", connection.client_id)
        return 0, body_of((address_type, client_id), (data_type, data[:2] + message))

    def _answer_unconnected(self, request: bytes, snapshot: TagSnapshot, *, planning: bool) -> bytes:
        if not Connections.accepts(request):
            return self.router.answer(request, snapshot, UNCONNECTED_MOST)
        return b"" if planning else self._connections.answer(request)

    def listed_identity(self) -> bytes:
        """Return the body of the reply to List Identity."""
        socket_address = struct.pack(">HH4s8x", 2, self._port, self._address)
        item = struct.pack("<H", 1) + socket_address + self.router.identity + _RUNNING
        return struct.pack("<HHH", 1, 0x0C, len(item)) + item
