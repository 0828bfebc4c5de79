"""A networked drive on EtherNet/IP: its objects, and the class 1 connection that owns it [EDS; R-22, R-35].

    assembly 150   ten output words, after a 32-bit run/idle header in the packets to the drive
    assembly 100   ten input words
    assembly 110   configuration of 16 bytes: word 0, word 1, starting speed in 32 bits, steps, counts, idle
                   current, current

The connection is exclusive. Packets that are late or repeat earlier ones are dropped. After Forward Close, or
after a time-out without packets, the drive loses its controlling connection. The adapter uses no sockets and
no clock.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

from scanrack.io_images.drives.models import WORDS
from scanrack.io_images.enip.codes import (
    ASSEMBLY,
    BAD_RPI,
    BAD_SEGMENT,
    CONFIGURATION_PATH,
    CONFIGURATION_SIZE,
    CONSUMED_PATH,
    DONE,
    GET_ONE,
    IDENTITY,
    IN_USE,
    NO_ATTRIBUTE,
    NO_CONNECTION,
    NO_SERVICE,
    NOT_OWNER,
    OTHER_DEVICE,
    OTHER_PRODUCT,
    OTHER_REVISION,
    PRODUCED_PATH,
    TO_ORIGINATOR_SIZE,
    TO_ORIGINATOR_TYPE,
    TO_TARGET_SIZE,
    TO_TARGET_TYPE,
    TRANSPORT,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from scanrack.io_images.enip.frames import body_of, items_in
from scanrack.io_images.enip.io_frames import IoPacket, IoPath, io_packet, io_path, port_in, socket_item
from scanrack.io_images.enip.paths import Path, parse_path
from typing_extensions import override

from ..modules.drives.drive import DriveUnit
from .connections import Connections, ForwardOpen, Triad
from .objects import INTERFACES, LOOPBACK, answer_identity, answer_interface, identity
from .router import refused, replied, split
from .session import ClientSession, Frame
from .tag_services import Answer
from .tag_snapshot import TagSnapshot

CONSUMED, PRODUCED, CONFIGURATION = 150, 100, 110
"""Instances of the assembly object."""

RPI_US = (1_000, 3_200_000)
"""Minimum and maximum requested packet interval."""

TO_TARGET_BYTES, TO_ORIGINATOR_BYTES = 2 + 4 + 2 * WORDS, 2 + 2 * WORDS
"""Sizes in an open request; they include the sequence count, the run/idle header and the words."""

FIRST_PACKET_NS = 10_000_000_000
"""Minimum time-out before the first packet."""

POINT_TO_POINT = 2
CLASS_1 = 1
_SETTINGS = struct.Struct("<HHiHHHH")
_RUN = 1
_OWNED = 1


@dataclass(slots=True)
class IoConnection:
    """The open connection; instants are in wall-clock time.

    Attributes:
        own_id: connection number in packets to the drive.
        client_id: connection number in packets to the owner.
        destination: address and port to which packets to the owner are sent.
        receive_interval_ns: time between packets to the drive.
        send_interval_ns: time between packets to the owner.
        due_ns: instant of the next packet to the owner.
        deadline_ns: instant of the time-out.
        sent_count: number of packets to the owner.
        received_count: count in the latest packet to the drive.
        received_ns: instant of the latest packet to the drive.
        sequence: sequence count of the data in that packet.
    """

    own_id: int
    client_id: int
    triad: Triad
    destination: tuple[str, int]
    receive_interval_ns: int
    send_interval_ns: int
    timeout_ns: int
    due_ns: int
    deadline_ns: int
    sent_count: int = 0
    received_count: int | None = None
    received_ns: int = 0
    sequence: int | None = None

    def accepts(self, packet: IoPacket) -> bool:
        """Return whether a packet belongs to this connection, is complete, and is newer than the last."""
        if packet.connection != self.own_id or len(packet.data) != TO_TARGET_BYTES - 2:
            return False
        return self.received_count is None or 0 < packet.count - self.received_count & 0xFFFF_FFFF < 1 << 31


class DriveAdapter:
    """The objects of a drive and its class 1 connection.

    Attributes:
        identity: all attributes of the identity object.
        io: the open connection.
        address: IPv4 address of the server.
        opened: whether the latest request opened a connection.
        used: whether any request has opened a connection.
        late_received: number of packets from owners that came more than two intervals after the previous
            packet.
        late_sent: number of packets to owners that were sent one or more intervals after they were due.
    """

    def __init__(self, drive: DriveUnit) -> None:
        assert drive.model.identity is not None
        self.drive, self._product = drive, drive.model.identity
        self.io: IoConnection | None = None
        self.address = LOOPBACK
        self.opened = self.used = False
        self.late_received = self.late_sent = 0
        self._numbers = count(0x5CA9_0001)

    @property
    def identity(self) -> bytes:
        """All attributes of the identity object."""
        status = 0 if self.io is None else _OWNED
        return identity(self.drive.model.title.encode("ascii"), self._product, status)

    # -- explicit requests ----------------------------------------------------------------------

    def answer(self, request: bytes, _snapshot: TagSnapshot, most: int, _depth: int = 0) -> bytes:
        """Return the reply (service, status, data), at most `most` bytes long."""
        service = request[0] if request else 0
        try:
            return replied(service, self._serve(service, parse_path(split(request)[0])), most)
        except CipRefusedError as refusal:
            return refused(service, refusal, most)

    def _serve(self, service: int, path: Path) -> Answer:
        """Return status and data of a read of the identity, the network interface or an assembly."""
        kind, instance = path.numbers.get("class"), path.numbers.get("instance")
        if kind == IDENTITY and instance == 1:
            return answer_identity(self.identity, service, path)
        if kind in INTERFACES:
            return answer_interface(self.address, service, path)
        if kind != ASSEMBLY:
            raise CipRefusedError(BAD_SEGMENT if kind is None else UNKNOWN_OBJECT)
        data = self._assembly(instance)
        if service != GET_ONE:
            raise CipRefusedError(NO_SERVICE)
        values = {3: data, 4: struct.pack("<H", len(data))}  # attributes data and size
        if path.numbers.get("attribute") not in values:
            raise CipRefusedError(NO_ATTRIBUTE)
        return DONE, values[path.numbers["attribute"]]

    def _assembly(self, instance: int | None) -> bytes:
        """Return the data of an assembly: inputs, outputs or the present configuration; refuse others."""
        if instance == PRODUCED:
            return _packed(self.drive.inputs())
        if instance == CONSUMED:
            return _packed(self.drive.words)
        if instance == CONFIGURATION:
            configuration = self.drive.layer.state.configuration
            words = (0,) * WORDS if configuration is None else configuration.words
            starting_speed = 1000 * words[2] + words[3]
            return _SETTINGS.pack(words[0] & 0x7FFF, words[1], starting_speed, words[4], *words[6:9])
        raise CipRefusedError(UNKNOWN_OBJECT)

    # -- the connection -------------------------------------------------------------------------

    def open(self, request: ForwardOpen, destination: tuple[str, int], wall_ns: int) -> bytes:
        """Open a connection, and configure the drive if the path has data; return the reply's data.

        Args:
            destination: address and port to which packets to the originator are sent.

        Raises:
            CipRefusedError: the request is refused, and nothing has changed.
        """
        path, to_target, to_client = io_path(request.path), request.to_target, request.to_client
        self._check_path(path)
        if self.io is not None:
            raise CipRefusedError(NO_CONNECTION, IN_USE if self.io.triad == request.triad else NOT_OWNER)
        for is_wrong, status in (
            (request.transport & 0xF != CLASS_1, TRANSPORT),
            (to_target.type != POINT_TO_POINT, TO_TARGET_TYPE),
            (to_client.type != POINT_TO_POINT, TO_ORIGINATOR_TYPE),
            (to_target.size != TO_TARGET_BYTES, TO_TARGET_SIZE),
            (to_client.size != TO_ORIGINATOR_BYTES, TO_ORIGINATOR_SIZE),
            (len(path.data or b"") not in (0, _SETTINGS.size), CONFIGURATION_SIZE),
            (not RPI_US[0] <= to_target.interval_us <= RPI_US[1], BAD_RPI),
            (not RPI_US[0] <= to_client.interval_us <= RPI_US[1], BAD_RPI),
            (request.multiplier > 7, BAD_RPI),
        ):
            if is_wrong:
                raise CipRefusedError(NO_CONNECTION, status)
        if path.data:
            self._configure(path.data)
        timeout_ns = to_target.interval_us * 1000 * (4 << request.multiplier)
        self.io = IoConnection(
            own_id=next(self._numbers),
            client_id=request.client_id,
            triad=request.triad,
            destination=destination,
            receive_interval_ns=to_target.interval_us * 1000,
            send_interval_ns=to_client.interval_us * 1000,
            timeout_ns=timeout_ns,
            due_ns=wall_ns,
            deadline_ns=wall_ns + max(timeout_ns, FIRST_PACKET_NS),
        )
        self.opened = self.used = True
        return request.reply(self.io.own_id)

    def _check_key(self, key: tuple[int, ...]) -> None:
        """Refuse a connection to another product; 0 matches any product."""
        own_vendor, own_device, own_product, own_major, own_minor = self._product
        vendor, device, product, major_and_flag, minor = key
        compatible, major = divmod(major_and_flag, 0x80)
        for sent_value, own_value, status in (
            (vendor, own_vendor, OTHER_PRODUCT),
            (product, own_product, OTHER_PRODUCT),
            (device, own_device, OTHER_DEVICE),
            (major, own_major, OTHER_REVISION),
        ):
            if sent_value not in (0, own_value):
                raise CipRefusedError(NO_CONNECTION, status)
        if minor > own_minor or (not compatible and minor not in (0, own_minor)):
            raise CipRefusedError(NO_CONNECTION, OTHER_REVISION)

    def _check_path(self, path: IoPath) -> None:
        """Refuse a path that names another product or other assemblies."""
        if path.key:
            self._check_key(path.key)
        if path.numbers.get("instance") != CONFIGURATION:
            raise CipRefusedError(NO_CONNECTION, CONFIGURATION_PATH)
        if path.points[:1] != (CONSUMED,):
            raise CipRefusedError(NO_CONNECTION, CONSUMED_PATH)
        if path.points[1:] != (PRODUCED,):
            raise CipRefusedError(NO_CONNECTION, PRODUCED_PATH)

    def _configure(self, data: bytes) -> None:
        """Apply the configuration in an open request; if invalid, set the drive's configuration error."""
        word_0, word_1, starting_speed, *settings = _SETTINGS.unpack(data)
        upper, lower = divmod(starting_speed, 1000) if starting_speed >= 0 else (0, 0)
        words = (word_0 | 0x8000, word_1, upper & 0xFFFF, lower, settings[0], 0, *settings[1:], 0)
        self.drive.obey(words)
        self.drive.obey((0,) * WORDS)

    def close(self, triad: Triad) -> bool:
        """Close the connection if it has the given triad; return whether it was closed."""
        if self.io is None or self.io.triad != triad:
            return False
        self.end()
        return True

    def end(self) -> None:
        """End the connection, if one is open; the drive loses its controlling connection."""
        if self.io is None:
            return
        self.io = None
        self.drive.plc_run(True)
        self.drive.lose_connection()

    def receive(self, datagram: bytes, host: str, wall_ns: int) -> None:
        """Receive a packet of data; drop it unless it is the owner's next packet."""
        io, packet = self.io, io_packet(datagram)
        if io is None or packet is None or host != io.destination[0] or not io.accepts(packet):
            return
        if io.received_count is not None and wall_ns - io.received_ns > 2 * io.receive_interval_ns:
            self.late_received += 1
        io.received_count, io.received_ns = packet.count, wall_ns
        io.deadline_ns = wall_ns + io.timeout_ns
        if packet.sequence == io.sequence:
            return
        io.sequence = packet.sequence
        header, *words = struct.unpack(f"<I{WORDS}H", packet.data)
        self.drive.plc_run(bool(header & _RUN))
        self.drive.obey(words)

    def due(self, wall_ns: int) -> tuple[bytes, tuple[str, int]] | None:
        """Return the packet that is due and its destination, or None; end a timed-out connection."""
        io = self.io
        if io is None:
            return None
        if wall_ns >= io.deadline_ns:
            self.end()
            return None
        if wall_ns < io.due_ns:
            return None
        io.sent_count += 1
        missed = (wall_ns - io.due_ns) // io.send_interval_ns
        self.late_sent += missed > 0
        io.due_ns += (missed + 1) * io.send_interval_ns
        data = _packed(self.drive.inputs())
        packet = IoPacket(io.client_id, io.sent_count & 0xFFFF_FFFF, io.sent_count & 0xFFFF, data)
        return packet.encoded(), io.destination

    @property
    def wake_ns(self) -> int | None:
        """The instant of the next packet or of the time-out; None without a connection."""
        return None if self.io is None else min(self.io.due_ns, self.io.deadline_ns)


class DriveConnections(Connections):
    """One client's connections: explicit connections, and the class 1 connection that owns the drive."""

    def __init__(self, adapter: DriveAdapter, host: str) -> None:
        super().__init__()
        self._adapter = adapter
        self.destination = (host, 0)
        self.wall_ns = 0

    @override
    def _begin(self, request: ForwardOpen) -> bytes:
        if io_path(request.path).numbers.get("class") != ASSEMBLY:
            return super()._begin(request)
        return self._adapter.open(request, self.destination, self.wall_ns)

    @override
    def _close(self, data: bytes) -> bytes:
        triad: Triad = struct.unpack_from("<HHI", data, 2)
        if self._adapter.close(triad):
            return struct.pack("<HHIBB", *triad, 0, 0)
        return super()._close(data)


class DriveSession(ClientSession):
    """A TCP connection of a client.

    Args:
        port: TCP port of the server.
        io_port: UDP port of its class 1 packets.
        host: address of the client.
    """

    def __init__(self, adapter: DriveAdapter, address: bytes, port: int, io_port: int, host: str) -> None:
        self._adapter, self._io_port, self._host = adapter, io_port, host
        self._drive_connections = DriveConnections(adapter, host)
        super().__init__(adapter, address, port, self._drive_connections)

    def answer_at(self, packet: Frame, snapshot: TagSnapshot, wall_ns: int) -> bytes:
        """Return the reply to a packet at a wall-clock time, or b"" if the packet needs no reply.

        Raises:
            BrokenClientError: the client ends its session.
        """
        self._drive_connections.wall_ns = wall_ns
        return self.reply(packet, snapshot)

    @override
    def _answer_message(self, packet: Frame, snapshot: TagSnapshot, *, planning: bool) -> tuple[int, bytes]:
        """Answer a message; the reply to an opened connection also states the UDP port of its packets."""
        self._drive_connections.destination = (self._host, port_in(items_in(packet.body)))
        self._adapter.opened = False
        status, body = super()._answer_message(packet, snapshot, planning=planning)
        if self._adapter.opened:
            body = body_of(*items_in(body), socket_item(self._io_port))
        return status, body


def _packed(words: Sequence[int]) -> bytes:
    return struct.pack(f"<{WORDS}H", *(word & 0xFFFF for word in words))
