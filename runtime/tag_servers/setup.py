"""The tags and settings of a server, and the sessions of its clients by protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from scanrack.io_images.enip.codes import LIST_IDENTITY
from scanrack.io_images.enip.frames import HEAD
from scanrack.io_images.enip.listing import Listing

from ..config.server_table import ModbusTable
from .database import Database
from .modbus_session import ModbusSession
from .register_map import RegisterMap
from .router import Router
from .session import ClientSession, Frame
from .tag_snapshot import Instant, Plan, TagSnapshot
from .ua_security import UaSecurity

ETHERNET_IP, MODBUS_TCP, OPC_UA = "ethernet-ip", "modbus-tcp", "opc-ua"
"""The names of the protocols in `--server`."""


@dataclass(frozen=True, slots=True)
class TagSetup:
    """The tags and settings of a server.

    Attributes:
        version: edition number of the program.
        writable: patterns of tags that clients may write; empty for a read-only server.
        name: name of the rack.
        product: name of the controller.
        address: address of the server, for List Identity.
        modbus: the map of coils and registers.
        ua_security: security settings of an encrypted OPC UA server.
    """

    listing: Listing
    version: int
    writable: tuple[str, ...]
    name: str
    product: str
    address: bytes
    port: int
    protocol: str = ETHERNET_IP
    modbus: ModbusTable | None = None
    ua_security: UaSecurity | None = None

    @property
    def database(self) -> Database:
        """The tags by name."""
        return Database(self.listing, self.writable)


class WireSession(Protocol):
    """The state of a client's connection.

    Attributes:
        pending: bytes of an incomplete packet.
        router: answers requests; replaced after an edit of the program.
    """

    pending: bytes
    router: Any

    def receive(self, data: bytes) -> list[Any]:
        """Receive bytes; return the complete packets. A BrokenClientError ends the connection."""

    def plan(self, packet: Any, version: int) -> Plan:
        """Return the operations of a packet, without any effect."""

    def reply(self, packet: Any, snapshot: TagSnapshot) -> bytes:
        """Return the reply to a packet. A BrokenClientError ends the connection."""


class Sessions(Protocol):
    """The sessions of one protocol.

    Attributes:
        router: the object that answers requests.
    """

    router: Any

    def open(self) -> WireSession:
        """Return the session of a new client."""

    def datagram(self, data: bytes) -> bytes:
        """Return the reply to a datagram, or b"" if the datagram needs no reply."""
        return b""


class EnipSessions(Sessions):
    """The sessions of EtherNet/IP."""

    def __init__(self, setup: TagSetup) -> None:
        self.router = Router(setup.database, setup.name, setup.product, setup.address)
        self._setup = setup

    def open(self) -> WireSession:
        """Return the session of a new client."""
        return ClientSession(self.router, self._setup.address, self._setup.port)

    def datagram(self, data: bytes) -> bytes:
        """Return the reply to List Identity, or b"" for other datagrams."""
        if len(data) != HEAD.size or int.from_bytes(data[:2], "little") != LIST_IDENTITY:
            return b""
        frame = Frame(LIST_IDENTITY, 0, data[12:20], b"")
        return self.open().reply(frame, Instant((), 0, self._setup.version))


class ModbusSessions(Sessions):
    """The sessions of Modbus TCP."""

    def __init__(self, setup: TagSetup) -> None:
        self.router = RegisterMap(setup.database, setup.modbus or ModbusTable())

    def open(self) -> WireSession:
        """Return the session of a new client."""
        return ModbusSession(self.router)


SESSIONS: Mapping[str, Callable[[TagSetup], Sessions]] = {
    ETHERNET_IP: EnipSessions,
    MODBUS_TCP: ModbusSessions,
}
"""The session classes of the protocols that work on bytes, without sockets, by name."""
