"""A request and its reply between two processes, through shared memory: the scan loop never waits.

head     asked, answered, bytes of the request, bytes of the reply, beats of the server; 8 bytes each
request  written by the server, then `asked` is incremented
reply    written between two scans, then `answered` is incremented, and a byte wakes the server
"""

from __future__ import annotations

import socket
from contextlib import suppress

from .shared_memory import SharedMemory

AREA_BYTES = 1 << 20
"""Maximum bytes of a request, and of a reply."""

_HEAD_BYTES = 64
_ASKED, _ANSWERED, _REQUEST, _REPLY, _BEATS = range(5)


class Mailbox:
    """One side of a mailbox.

    Args:
        memory: memory of the other side; None = create it.
    """

    def __init__(self, memory: SharedMemory | None = None) -> None:
        self.memory = memory or SharedMemory(_HEAD_BYTES + 2 * AREA_BYTES)
        self._memory = self.memory.map
        self._head = memoryview(self._memory)[:_HEAD_BYTES].cast("Q")

    # --- the server's side

    def ask(self, request: bytes) -> None:
        """Post a request; ValueError if it is too long."""
        if len(request) > AREA_BYTES:
            raise ValueError(f"a request of {len(request)} bytes: {AREA_BYTES} fit")
        self._memory[_HEAD_BYTES : _HEAD_BYTES + len(request)] = request
        self._head[_REQUEST] = len(request)
        self._head[_ASKED] += 1

    @property
    def waits(self) -> bool:
        """Whether a request has no reply yet."""
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
        """How often servers have reported that they are alive."""
        return self._head[_BEATS]

    def request(self) -> bytes:
        """Return the request that waits."""
        return self._memory[_HEAD_BYTES : _HEAD_BYTES + min(self._head[_REQUEST], AREA_BYTES)]

    def answer(self, reply: bytes) -> None:
        """Post the reply; a reply that does not fit is replaced by an empty one."""
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
