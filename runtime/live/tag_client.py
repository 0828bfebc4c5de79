"""A client connected to a tag server, and the limits on it."""

from __future__ import annotations

import socket
from typing import Any

from ..loop.pace import wall_ns
from ..tag_servers.setup import WireSession
from ..tag_servers.tag_snapshot import BrokenClientError

WAITING_MOST = 32
"""Maximum number of unanswered packets per client."""

RECEIVED_MOST = 1 << 13
"""Maximum number of bytes read from a client before the other clients get their turn."""

UNREAD_MOST = 1 << 16
"""Maximum number of reply bytes that a client can leave unread."""

INCOMPLETE_NS, IDLE_NS = 5_000_000_000, 120_000_000_000
"""Time limits for a connection with an incomplete frame, and for a silent connection."""


class Client:
    """A connected client."""

    def __init__(self, connection: socket.socket, session: WireSession, address: str) -> None:
        self.socket, self.session, self.address = connection, session, address
        self.waiting: list[Any] = []  # packets without a reply
        self.unread = b""  # bytes of replies that are not sent yet
        self.heard_ns = wall_ns()  # when it last sent something
        self.incomplete_ns: int | None = None  # when an incomplete frame began; None without one

    def receive(self) -> None:
        """Read the received bytes; after a BrokenClientError or OSError, the client must be dropped."""
        data = self.socket.recv(RECEIVED_MOST)
        if not data:
            raise BrokenClientError("the client has hung up")
        packets = self.session.receive(data)
        self.waiting += packets
        if len(self.waiting) > WAITING_MOST:
            raise BrokenClientError(f"more than {WAITING_MOST} packets at once")
        self.heard_ns = wall_ns()
        if not self.session.pending:
            self.incomplete_ns = None
        elif packets or self.incomplete_ns is None:
            self.incomplete_ns = self.heard_ns

    def send(self, data: bytes) -> bool:
        """Send bytes after any earlier unsent ones; return whether all of them were sent.

        Raises:
            BrokenClientError: the client is not reading.
        """
        self.unread += data
        try:
            sent_bytes = self.socket.send(self.unread) if self.unread else 0
        except BlockingIOError:
            sent_bytes = 0
        self.unread = self.unread[sent_bytes:]
        if len(self.unread) > UNREAD_MOST:
            raise BrokenClientError("the client does not read")
        return not self.unread

    def is_late(self, now_ns: int) -> bool:
        """Whether the client has been silent, or a frame has been incomplete, for too long."""
        is_stuck = self.incomplete_ns is not None and now_ns - self.incomplete_ns > INCOMPLETE_NS
        return is_stuck or now_ns - self.heard_ns > IDLE_NS
