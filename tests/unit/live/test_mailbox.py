"""The waker of a mailbox: it blocks on no system, and asks for no flag that one lacks."""

from __future__ import annotations

import socket
from contextlib import suppress
from typing import Any

import pytest
from scanrack.runtime.live.mailbox import wake


class SocketOfWindows:
    """A socket that takes no flags: Windows has no MSG_DONTWAIT."""

    def __init__(self) -> None:
        self.sent = b""

    def send(self, said: bytes) -> int:
        """Send."""
        self.sent += said
        return len(said)


def test_a_wake_takes_no_flags(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(socket, "MSG_DONTWAIT", raising=False)
    waker: Any = SocketOfWindows()
    wake(waker)
    assert waker.sent == b"\1"


def test_a_full_or_closed_waker_neither_blocks_nor_raises() -> None:
    here, there = socket.socketpair()
    here.setblocking(False)
    with suppress(BlockingIOError):
        while True:
            here.send(bytes(1 << 16))
    wake(here)
    there.close()
    here.close()
    wake(here)
