"""A networked drive on EtherNet/IP: objects, and the class 1 connection that owns it [EDS; R-22, R-35].

    assembly 150   ten output words, after a 32-bit run/idle header in the packets to the drive
    assembly 100   ten input words
    assembly 110   configuration of 16 bytes: word 0, word 1, starting speed in 32 bits, steps, counts, idle
                   current, current

The connection is exclusive. Packets that are late or repeat earlier ones are dropped. Without a packet for
the time-out, and after Forward Close, the drive loses its controlling connection. No sockets, no clock.
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
    TOO_SHORT,
    TRANSPORT,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from scanrack.io_images.enip.frames import body_of, items_in
from scanrack.io_images.enip.io_frames import IoPacket, io_packet, io_path, port_in, socket_item
from scanrack.io_images.enip.paths import Path, parse_path
from typing_extensions import override

from ..modules.drives.drive import DriveUnit
from .connections import Connections, Triad
from .objects import INTERFACES, LOOPBACK, answer_identity, answer_interface, identity
from .router import refused, replied, split
from .session import ClientSession, Frame
from .tag_services import Answer
from .tag_snapshot import TagSnapshot

CONSUMED, PRODUCED, CONFIGURATION = 150, 100, 110
"""Instances of the assembly object."""

RPI_US = (1_000, 3_200_000)
"""Least and greatest requested packet interval."""

TO_TARGET_BYTES, TO_ORIGINATOR_BYTES = 2 + 4 + 2 * WORDS, 2 + 2 * WORDS
"""Sizes in an open request: sequence count, run/idle header, words."""

FIRST_PACKET_NS = 10_000_000_000
"""Minimum time-out before the first packet."""

POINT_TO_POINT = 2
CLASS_1 = 1
_SETTINGS = struct.Struct("<HHiHHHH")
_RUN = 1
_OWNED = 1


@dataclass(slots=True)
class IoConnection:
    """The open connection; instants are of the wall clock."""

    ours: int
    theirs: int
    triad: Triad
    place: tuple[str, int]
    every_ns: int
    timeout_ns: int
    due_ns: int
    deadline_ns: int
    awaited_ns: int  # time between packets to the drive
    sent: int = 0
    heard: int | None = None  # number of the latest packet
    heard_ns: int = 0
    sequence: int | None = None

    def takes(self, packet: IoPacket) -> bool:
        """Whether a packet is of this connection, whole, and newer than the latest one."""
        if packet.connection != self.ours or len(packet.data) != TO_TARGET_BYTES - 2:
            return False
        return self.heard is None or 0 < packet.count - self.heard & 0xFFFF_FFFF < 1 << 31


class DriveAdapter:
    """The objects of a drive and its class 1 connection.

    Attributes:
        identity: all attributes of the identity object.
        io: the open connection.
        address: IPv4 address of the server.
        used: whether there has been a connection.
        late_received: packets from owners, more than two packet intervals after the one before.
        late_sent: packets to owners, sent an interval or more after they were due.
    """

    def __init__(self, drive: DriveUnit) -> None:
        assert drive.model.identity is not None
        self.drive, self._product = drive, drive.model.identity
        self.io: IoConnection | None = None
        self.address = LOOPBACK
        self.opened = self.used = False  # by the latest request; by any
        self.late_received = self.late_sent = 0
        self._numbers = count(0x5CA9_0001)

    @property
    def identity(self) -> bytes:
        """All attributes of the identity object."""
        status = 0 if self.io is None else _OWNED
        return identity(self.drive.model.title.encode("ascii"), self._product, status)

    # -- explicit requests ----------------------------------------------------------------------

    def answer(self, request: bytes, _snapshot: TagSnapshot, most: int, _depth: int = 0) -> bytes:
        """Return the reply of at most `most` bytes: service, status, data."""
        service = request[0] if request else 0
        try:
            return replied(service, self._serve(service, parse_path(split(request)[0])), most)
        except CipRefusedError as refusal:
            return refused(service, refusal, most)

    def _serve(self, service: int, path: Path) -> Answer:
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
        values = {3: data, 4: struct.pack("<H", len(data))}
        if path.numbers.get("attribute") not in values:
            raise CipRefusedError(NO_ATTRIBUTE)
        return DONE, values[path.numbers["attribute"]]

    def _assembly(self, instance: int | None) -> bytes:
        if instance == PRODUCED:
            return _packed(self.drive.inputs())
        if instance == CONSUMED:
            return _packed(self.drive.words)
        if instance == CONFIGURATION:
            present = self.drive.layer.state.configuration
            words = (0,) * WORDS if present is None else present.words
            start = 1000 * words[2] + words[3]
            return _SETTINGS.pack(words[0] & 0x7FFF, words[1], start, words[4], *words[6:9])
        raise CipRefusedError(UNKNOWN_OBJECT)

    # -- the connection -------------------------------------------------------------------------

    def open(self, data: bytes, place: tuple[str, int], wall_ns: int, *, large: bool) -> bytes:
        """Open a connection; return the reply's data.

        Args:
            data: data of a Forward Open.
            place: address and port at which the originator gets its packets.

        Raises:
            CipRefusedError: the request is refused; nothing has changed.
        """
        client_id, serial, vendor, origin, multiplier = struct.unpack_from("<IHHIB", data, 6)
        form = struct.Struct("<II" if large else "<IH")
        there_us, there_parameters = form.unpack_from(data, 22)
        back_us, back_parameters = form.unpack_from(data, 22 + form.size)
        offset = 22 + 2 * form.size
        path = io_path(data[offset + 2 : offset + 2 + 2 * data[offset + 1]])
        triad = (serial, vendor, origin)
        self._check_place(path.key, path.numbers, path.points)
        if self.io is not None:
            raise CipRefusedError(NO_CONNECTION, IN_USE if self.io.triad == triad else NOT_OWNER)
        bits, mask = (25, 0xFFFF) if large else (9, 0x1FF)
        kinds = bits + 4
        for is_wrong, status in (
            (data[offset] & 0xF != CLASS_1, TRANSPORT),
            (there_parameters >> kinds & 3 != POINT_TO_POINT, TO_TARGET_TYPE),
            (back_parameters >> kinds & 3 != POINT_TO_POINT, TO_ORIGINATOR_TYPE),
            (there_parameters & mask != TO_TARGET_BYTES, TO_TARGET_SIZE),
            (back_parameters & mask != TO_ORIGINATOR_BYTES, TO_ORIGINATOR_SIZE),
            (len(path.data or b"") not in (0, _SETTINGS.size), CONFIGURATION_SIZE),
            (not all(RPI_US[0] <= interval_us <= RPI_US[1] for interval_us in (there_us, back_us)), BAD_RPI),
            (multiplier > 7, BAD_RPI),
        ):
            if is_wrong:
                raise CipRefusedError(NO_CONNECTION, status)
        if path.data:
            self._configure(path.data)
        timeout_ns = there_us * 1000 * (4 << multiplier)
        self.io = IoConnection(
            next(self._numbers),
            client_id,
            triad,
            place,
            back_us * 1000,
            timeout_ns,
            wall_ns,
            wall_ns + max(timeout_ns, FIRST_PACKET_NS),
            there_us * 1000,
        )
        self.opened = self.used = True
        return struct.pack("<IIHHIIIBB", self.io.ours, client_id, *triad, there_us, back_us, 0, 0)

    def _check_key(self, key: tuple[int, ...]) -> None:
        """Refuse a connection to another product; 0 matches any product."""
        vendor, device, product, major, minor = self._product
        compatible = key[3] >> 7
        for sent_value, own_value, status in (
            (key[0], vendor, OTHER_PRODUCT),
            (key[2], product, OTHER_PRODUCT),
            (key[1], device, OTHER_DEVICE),
            (key[3] & 0x7F, major, OTHER_REVISION),
        ):
            if sent_value not in (0, own_value):
                raise CipRefusedError(NO_CONNECTION, status)
        if key[4] > minor or (not compatible and key[4] not in (0, minor)):
            raise CipRefusedError(NO_CONNECTION, OTHER_REVISION)

    def _check_place(self, key: tuple[int, ...], numbers: dict[str, int], points: Sequence[int]) -> None:
        if key:
            self._check_key(key)
        if numbers.get("instance") != CONFIGURATION:
            raise CipRefusedError(NO_CONNECTION, CONFIGURATION_PATH)
        if points[:1] != (CONSUMED,):
            raise CipRefusedError(NO_CONNECTION, CONSUMED_PATH)
        if points[1:] != (PRODUCED,):
            raise CipRefusedError(NO_CONNECTION, PRODUCED_PATH)

    def _configure(self, data: bytes) -> None:
        """Apply the configuration of an open request; an invalid one sets the drive's error bit for it."""
        word_0, word_1, start, *settings = _SETTINGS.unpack(data)
        upper, lower = divmod(start, 1000) if start >= 0 else (0, 0)
        words = (word_0 | 0x8000, word_1, upper & 0xFFFF, lower, settings[0], 0, *settings[1:], 0)
        self.drive.obey(words)
        self.drive.obey((0,) * WORDS)

    def close(self, triad: Triad) -> bool:
        """Close the connection, if it has these numbers; return whether it has."""
        if self.io is None or self.io.triad != triad:
            return False
        self.end()
        return True

    def end(self) -> None:
        """End the connection, if there is one: the drive loses its controlling connection."""
        if self.io is None:
            return
        self.io = None
        self.drive.plc_run(True)
        self.drive.lose_connection()

    def receive(self, datagram: bytes, host: str, wall_ns: int) -> None:
        """Receive a packet of data; drop it unless it is the owner's next packet."""
        io, packet = self.io, io_packet(datagram)
        if io is None or packet is None or host != io.place[0] or not io.takes(packet):
            return
        if io.heard is not None and wall_ns - io.heard_ns > 2 * io.awaited_ns:
            self.late_received += 1
        io.heard, io.heard_ns, io.deadline_ns = packet.count, wall_ns, wall_ns + io.timeout_ns
        if packet.sequence == io.sequence:
            return
        io.sequence = packet.sequence
        header, *words = struct.unpack(f"<I{WORDS}H", packet.data)
        self.drive.plc_run(bool(header & _RUN))
        self.drive.obey(words)

    def due(self, wall_ns: int) -> tuple[bytes, tuple[str, int]] | None:
        """Return the packet that is due and its destination, or None; end a silent connection."""
        io = self.io
        if io is None:
            return None
        if wall_ns >= io.deadline_ns:
            self.end()
            return None
        if wall_ns < io.due_ns:
            return None
        io.sent += 1
        missed = (wall_ns - io.due_ns) // io.every_ns
        self.late_sent += missed > 0
        io.due_ns += (missed + 1) * io.every_ns
        data = _packed(self.drive.inputs())
        return IoPacket(io.theirs, io.sent & 0xFFFF_FFFF, io.sent & 0xFFFF, data).encoded(), io.place

    @property
    def wake_ns(self) -> int | None:
        """The instant of the next packet or of the time-out; None without a connection."""
        return None if self.io is None else min(self.io.due_ns, self.io.deadline_ns)


class DriveConnections(Connections):
    """The connections of one client: explicit ones, and the one that owns the drive."""

    def __init__(self, adapter: DriveAdapter, host: str) -> None:
        super().__init__()
        self._adapter = adapter
        self.place = (host, 0)
        self.wall_ns = 0

    @override
    def _begin(self, data: bytes, *, large: bool) -> bytes:
        offset = 22 + 2 * (8 if large else 6)
        if len(data) < offset + 2 or len(data) < offset + 2 + 2 * data[offset + 1]:
            raise CipRefusedError(TOO_SHORT)
        if io_path(data[offset + 2 : offset + 2 + 2 * data[offset + 1]]).numbers.get("class") != ASSEMBLY:
            return super()._begin(data, large=large)
        return self._adapter.open(data, self.place, self.wall_ns, large=large)

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
        self._drive, self._io_port, self._host = adapter, io_port, host
        self._own = DriveConnections(adapter, host)
        super().__init__(adapter, address, port, self._own)

    def answer_at(self, packet: Frame, snapshot: TagSnapshot, wall_ns: int) -> bytes:
        """Answer a packet at an instant of the wall clock; b"" if it gets no answer.

        Raises:
            BrokenClientError: the client ends its session.
        """
        self._own.wall_ns = wall_ns
        return self.reply(packet, snapshot)

    @override
    def _sent(self, packet: Frame, snapshot: TagSnapshot, *, planning: bool) -> tuple[int, bytes]:
        self._own.place = (self._host, port_in(items_in(packet.body)))
        self._drive.opened = False
        status, body = super()._sent(packet, snapshot, planning=planning)
        if self._drive.opened:
            body = body_of(*items_in(body), socket_item(self._io_port))
        return status, body


def _packed(words: Sequence[int]) -> bytes:
    return struct.pack(f"<{WORDS}H", *(word & 0xFFFF for word in words))
