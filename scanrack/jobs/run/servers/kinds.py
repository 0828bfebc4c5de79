"""The kinds of servers for `--server`, in one row each, and their addresses."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from scanrack.io_images.enip.codes import PORT
from scanrack.io_images.installing import how_to_install
from scanrack.runtime.line.hosts import join_address, split_address
from scanrack.runtime.tag_servers.setup import ETHERNET_IP, MODBUS_TCP, OPC_UA

HOST = "127.0.0.1"

OPEN, ENCRYPTED = "none", "encrypted"
"""Values of `--opc-ua-security`."""


@dataclass(frozen=True, slots=True)
class ServerKind:
    """A protocol and its server.

    Attributes:
        main: main function of the server's process.
        port: default port.
        answers_datagrams: whether it also uses the UDP port.
        package: package that it needs in addition to scanrack's requirements, and the extra that installs it.
        maps: table of the rack file that it serves; "" = all tags.
    """

    title: str
    main: str
    port: int
    answers_datagrams: bool = False
    package: tuple[str, str] | None = None
    maps: str = ""


_SERVER = "scanrack.runtime.live.tag_server:main"

KINDS: Mapping[str, ServerKind] = {
    ETHERNET_IP: ServerKind("EtherNet/IP", _SERVER, PORT, answers_datagrams=True),
    OPC_UA: ServerKind(
        "OPC UA", "scanrack.runtime.live.opcua_server:main", 4840, package=("asyncua", "opcua")
    ),
    MODBUS_TCP: ServerKind("Modbus TCP", _SERVER, 502, maps="server.modbus"),
}


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """A server and its listening address.

    Attributes:
        encrypted: whether clients must encrypt; OPC UA only.
        users: file of users who may log in; None = anyone.
    """

    protocol: str
    host: str
    port: int
    encrypted: bool = False
    users: Path | None = None

    @classmethod
    def parse(cls, text: str) -> ServerAddress:
        """Parse `PROTOCOL[:[HOST:]PORT]`.

        >>> ServerAddress.parse("ethernet-ip:0")
        ServerAddress(protocol='ethernet-ip', host='127.0.0.1', port=0, encrypted=False, users=None)

        Raises:
            ValueError: the protocol is unknown, the address is invalid, or a package is not installed.
        """
        protocol, _, remainder = text.partition(":")
        kind = KINDS.get(protocol)
        if kind is None:
            raise ValueError(f"--server {text}: must be {', '.join(KINDS)}, each with :PORT or :HOST:PORT")
        if kind.package is not None and find_spec(kind.package[0]) is None:
            package, extra = kind.package
            raise ValueError(f"--server {text} needs {package}: {how_to_install(extra)}")
        if not remainder:
            return cls(protocol, HOST, kind.port)
        try:
            host, port = split_address(remainder)
        except ValueError as error:
            raise ValueError(f"--server {text}: {error}") from error
        return cls(protocol, host or HOST, port)

    @property
    def kind(self) -> ServerKind:
        """The kind of this server."""
        return KINDS[self.protocol]

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach it."""
        return self.host in ("localhost", "::1") or self.host.startswith("127.")

    def listen(self) -> list[socket.socket]:
        """Open and return the listening socket, and the UDP socket if the protocol has one.

        Raises:
            ValueError: the port is in use, or not allowed.
        """
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        host_and_port = (self.host, self.port)
        with ExitStack() as opened:
            try:
                sockets = [
                    opened.enter_context(socket.create_server(host_and_port, family=family, backlog=64))
                ]
                if self.kind.answers_datagrams:
                    sockets.append(opened.enter_context(socket.socket(family, socket.SOCK_DGRAM)))
                    sockets[1].bind((self.host, sockets[0].getsockname()[1]))
            except OSError as error:
                text = os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
                address = f"{self.protocol}:{join_address(*host_and_port)}"
                raise ValueError(f"--server {address}: {text}: choose another port") from error
            opened.pop_all()  # do not close the sockets
        return sockets


def addresses(
    texts: Sequence[str] | None, security: str | None = None, users: Path | None = None
) -> tuple[ServerAddress, ...]:
    """Return the server addresses for options.

    Args:
        security: `OPEN` or `ENCRYPTED` for the OPC UA server; None = open on this machine, else encrypted.
        users: file of users who may log in to the OPC UA server.

    Raises:
        ValueError: an address is not allowed, a protocol occurs twice, or an option of the OPC UA server is
            given without that server.
    """
    servers = [ServerAddress.parse(text) for text in texts or ()]
    names = [server.protocol for server in servers]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"--server {name} occurs twice: a rack has one server of each kind")
    _check_security(names, security, users)
    return tuple(
        _secured(server, security, users) if server.protocol == OPC_UA else server for server in servers
    )


def _check_security(names: Sequence[str], security: str | None, users: Path | None) -> None:
    """Raise ValueError for options of an OPC UA server that is missing or not encrypted."""
    if (security or users) and OPC_UA not in names:
        raise ValueError(f"--opc-ua-{'security' if security else 'users'} needs --server {OPC_UA}")
    if users and security == OPEN:
        raise ValueError(f"--opc-ua-users needs encryption: it can't go with --opc-ua-security {OPEN}")


def _secured(address: ServerAddress, security: str | None, users: Path | None) -> ServerAddress:
    """Return an address with its encryption; by default, only an address on this machine is open."""
    encrypted = security == ENCRYPTED if security else bool(users) or not address.is_local
    return replace(address, encrypted=encrypted, users=users)
