"""The limit on clients of a listening port: when it is reached, a silent client is dropped for a new one."""

from __future__ import annotations

import socket
from collections.abc import Mapping

CLIENTS_MOST = 64

SILENT_NS = 10_000_000_000
"""Minimum silence after which a client may be dropped when all places are taken."""


def make_place(heard_ns: Mapping[socket.socket, int], now_ns: int) -> tuple[socket.socket | None, bool]:
    """Return the client to drop, if any, and whether there is a place for a new client.

    Args:
        heard_ns: wall time at which each client last sent something.
    """
    if len(heard_ns) < CLIENTS_MOST:
        return None, True
    longest = min(heard_ns, key=lambda place: heard_ns[place])
    if now_ns - heard_ns[longest] < SILENT_NS:
        return None, False
    return longest, True
