"""The limit on clients of a listening port; at the limit, a new client replaces a silent one."""

from __future__ import annotations

import socket
from collections.abc import Mapping

CLIENTS_MAX = 64

SILENT_NS = 10_000_000_000
"""How long a client must have been silent before it may be dropped at the limit."""


def make_place(heard_ns: Mapping[socket.socket, int], now_ns: int) -> tuple[socket.socket | None, bool]:
    """Return the client to drop, or None, and whether a new client can be accepted.

    Args:
        heard_ns: wall time of the latest bytes of each client.
    """
    if len(heard_ns) < CLIENTS_MAX:
        return None, True
    most_silent = min(heard_ns, key=lambda client: heard_ns[client])
    if now_ns - heard_ns[most_silent] < SILENT_NS:
        return None, False
    return most_silent, True
