"""Places of a listening port: it has so many clients, and a silent one gives way to the next."""

from __future__ import annotations

import socket
from collections.abc import Mapping

CLIENTS_MOST = 64

SILENT_NS = 10_000_000_000
"""Least silence of a client that gives way when all places are taken."""


def make_place(heard_ns: Mapping[socket.socket, int], now_ns: int) -> tuple[socket.socket | None, bool]:
    """Return the client that gives way, if one has to, and whether another one has a place.

    Args:
        heard_ns: wall time at which each client was heard last.
    """
    if len(heard_ns) < CLIENTS_MOST:
        return None, True
    longest = min(heard_ns, key=lambda each: heard_ns[each])
    if now_ns - heard_ns[longest] < SILENT_NS:
        return None, False
    return longest, True
