"""A real line to a controller: two threads that only move bytes.

    adapter --send--> queue --sender--> port --receiver--> queue --take--> adapter

The scan loop never waits for the port. A lost port is reopened when it is available again;
until then sent bytes are dropped, as on a cut line. Only the receiver closes and opens the port:
a port must not be closed while another thread reads from it. No error ends a thread: each one
closes the port, and its reason is kept for the adapter's events.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from typing import TypeVar

from scanrack.io_images.site import SettingError
from typing_extensions import override

from .adapter_line import Line
from .clients.link import Link, LinkError, SerialLink, TcpLink
from .hosts import split_address
from .wire import LineFormat

Item = TypeVar("Item")

TCP = "tcp:"
RECEIVE_S = 0.05
"""Longest wait of the receiver before it checks for the end."""

REOPEN_S = 0.5
"""Time between two attempts to reopen a lost port."""


def check_address(port: str) -> None:
    """Refuse an address that names no port.

    Raises:
        ValueError: an address over TCP without host or number, or nothing at all.
    """
    if port.startswith(TCP):
        try:
            host, number = split_address(port.removeprefix(TCP))
        except ValueError:
            host, number = "", 0
        if not host or number == 0:
            raise SettingError(
                "port",
                f"port {port}: over TCP it is tcp:HOST:PORT or tcp:[IPV6]:PORT, and a port is 1 to 65535",
            )
    elif not port.strip():
        raise SettingError(
            "port", 'port: "sim", a serial device such as /dev/ttyUSB0 or COM3, or tcp:HOST:PORT'
        )


def open_port(port: str, line_format: LineFormat) -> Link:
    """Open a serial device or, with `tcp:HOST:PORT`, a connection that carries the line's own bytes.

    Raises:
        ValueError: the address is invalid.
        LinkError: it can't be opened.
    """
    check_address(port)
    if not port.startswith(TCP):
        return SerialLink(port, line_format)
    return TcpLink(*split_address(port.removeprefix(TCP)))


Sending = tuple[bytes, LineFormat] | None
"""Bytes to send and their format; None ends the sender."""


class LiveLine(Line):
    """A line whose bytes go through a port.

    Args:
        opened: opens the port, at the start and after each loss.

    Raises:
        LinkError: it can't be opened.
    """

    def __init__(self, opened: Callable[[], Link]) -> None:
        self._opened = opened
        self._port: Link | None = opened()
        self._lock = Lock()
        self._over = Event()
        self._heard: SimpleQueue[bytes] = SimpleQueue()
        self._said: SimpleQueue[Sending] = SimpleQueue()
        self._lost: SimpleQueue[str] = SimpleQueue()
        self._reason = ""
        self._failure: Exception | None = None
        self._threads = [Thread(target=loop, daemon=True) for loop in (self._receive, self._send)]
        for thread in self._threads:
            thread.start()

    @override
    def next_event_ns(self) -> int | None:
        """Return 0, which is in the past, if something has been received, else None."""
        return None if self._heard.empty() else 0

    @override
    def run_until(self, now_ns: int) -> None:
        """Do nothing: real time runs by itself."""

    @override
    def take(self) -> bytes:
        chunks: list[bytes] = list(_emptied(self._heard))
        return b"".join(chunks)

    def take_losses(self) -> list[str]:
        """Return the reason of each loss of the port since the last call."""
        return list(_emptied(self._lost))

    @override
    def send(self, data: bytes, line_format: LineFormat) -> None:
        self._said.put((data, line_format))

    def close(self) -> None:
        """Send the queued bytes, then close the port."""
        self._over.set()
        self._said.put(None)
        for thread in self._threads:
            thread.join()
        self._drop()

    def _receive(self) -> None:
        while not self._over.is_set():
            try:
                self._listen()
            except Exception as error:  # not even an unexpected error may end the thread silently
                self._lose(error)

    def _listen(self) -> None:
        """Wait for bytes once; without a port, try once to open it."""
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
        if self._port is None:
            self._reopen()
        elif data := self._port.receive(1, RECEIVE_S):
            self._heard.put(data)

    def _send(self) -> None:
        while (sending := self._said.get()) is not None:
            with self._lock:
                try:
                    self._pass_on(*sending)
                except Exception as error:  # see `_receive`, which reports the loss
                    self._failure = error

    def _pass_on(self, data: bytes, line_format: LineFormat) -> None:
        if self._port is not None:
            self._port.follow(line_format)
            self._port.send(data)

    def _lose(self, error: Exception) -> None:
        """Close the port and keep the reason; repeated identical failures to open are kept once."""
        reason = _words_of(error)
        if self._port is not None or reason != self._reason:
            self._lost.put(reason)
        self._reason = reason
        self._drop()

    def _drop(self) -> None:
        with self._lock:
            port, self._port = self._port, None
            self._failure = None  # it concerns the same port: one loss, not two
        if port is None:
            return
        try:
            port.close()
        except Exception as error:  # the port is closed in any case
            self._lost.put(_words_of(error))

    def _reopen(self) -> None:
        if self._over.wait(REOPEN_S):
            return
        try:
            port = self._opened()
        except LinkError:
            return
        with self._lock:
            self._port = port


def _words_of(error: Exception) -> str:
    """Return the text of a `LinkError`; any other error with its type."""
    return str(error) if isinstance(error, LinkError) else f"{type(error).__name__}: {error}"


def _emptied(queue: SimpleQueue[Item]) -> Iterator[Item]:
    while True:
        try:
            yield queue.get_nowait()
        except Empty:
            return
