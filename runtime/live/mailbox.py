"""A mailbox in shared memory for one request and its reply, so that the scan loop never waits.

head     number of requests, replies, bytes in each, and server beats; 8 bytes each
request  written by the server, which then increments the number of requests
reply    written between two scans; then the number of replies is set, and a byte wakes the server
"""

from __future__ import annotations

import socket
from contextlib import suppress

from .shared_memory import SharedMemory

AREA_BYTES = 1 << 20
"""Maximum number of bytes in a request, and in a reply."""

_HEAD_BYTES = 64
_ASKED, _ANSWERED, _REQUEST, _REPLY, _BEATS = range(5)


class Mailbox:
    """One side of a mailbox.

    Args:
        memory: the memory that the other side has created; None = create it.
    """

    def __init__(self, memory: SharedMemory | None = None) -> None:
        self.memory = memory or SharedMemory(_HEAD_BYTES + 2 * AREA_BYTES)
        self._memory = self.memory.map
        self._head = memoryview(self._memory)[:_HEAD_BYTES].cast("Q")

    # --- the server's side

    def post_request(self, request: bytes) -> None:
        """Post a request; raise ValueError if it is too long."""
        if len(request) > AREA_BYTES:
            raise ValueError(f"the request has {len(request):,} bytes; at most {AREA_BYTES:,} fit")
        self._memory[_HEAD_BYTES : _HEAD_BYTES + len(request)] = request
        self._head[_REQUEST] = len(request)
        self._head[_ASKED] += 1

    @property
    def has_request(self) -> bool:
        """Whether there is a request without a reply."""
        return self._head[_ASKED] != self._head[_ANSWERED]

    def beat(self) -> None:
        """Signal that the server is alive."""
        self._head[_BEATS] += 1

    def reply(self) -> bytes:
        """Return the latest reply."""
        begin = _HEAD_BYTES + AREA_BYTES
        return self._memory[begin : begin + min(self._head[_REPLY], AREA_BYTES)]

    # --- the scan process's side

    @property
    def beats(self) -> int:
        """Number of times that servers have signaled that they are alive."""
        return self._head[_BEATS]

    def request(self) -> bytes:
        """Return the waiting request."""
        return self._memory[_HEAD_BYTES : _HEAD_BYTES + min(self._head[_REQUEST], AREA_BYTES)]

    def post_reply(self, reply: bytes) -> None:
        """Post the reply, or an empty one if it does not fit."""
        stored_reply = reply if len(reply) <= AREA_BYTES else b""
        begin = _HEAD_BYTES + AREA_BYTES
        self._memory[begin : begin + len(stored_reply)] = stored_reply
        self._head[_REPLY] = len(stored_reply)
        self._head[_ANSWERED] = self._head[_ASKED]

    def close(self) -> None:
        """Release the memory."""
        self._head.release()
        self._memory.close()
        self.memory.close()


def wake(waker: socket.socket) -> None:
    """Wake the other side through a non-blocking socket; ignore a full or closed one."""
    with suppress(OSError):
        waker.send(b"\1")
