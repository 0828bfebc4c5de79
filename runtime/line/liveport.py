"""A real line to a device: two threads that only move bytes.

    adapter --send--> queue --sender--> port --receiver--> queue --take--> adapter

The scan loop never waits for the port. A lost port is reopened when it is available again; until then, sent
bytes are dropped, as on a cut line. Only the receiver closes and opens the port, since a port must not be
closed while another thread reads from it. An error never ends a thread; instead the port is closed, and the
adapter reports the reason as an event.
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
"""Longest time, in s, that the receiver waits before it checks whether to end."""

REOPEN_S = 0.5
"""Time, in s, between two attempts to reopen a lost port."""


def check_address(port: str) -> None:
    """Raise an error if a port's address is invalid.

    Raises:
        ValueError: the text is empty, or it is a TCP address without a host or port number.
    """
    if port.startswith(TCP):
        try:
            host, number = split_address(port.removeprefix(TCP))
        except ValueError:
            host, number = "", 0
        if not host or number == 0:
            allowed = "tcp:HOST:PORT or tcp:[IPV6]:PORT, with a port of 1 to 65535"
            raise SettingError("port", f"port {port}: must be {allowed}")
    elif not port.strip():
        allowed = '"sim", a serial device such as /dev/ttyUSB0 or COM3, or tcp:HOST:PORT'
        raise SettingError("port", f"port: must be {allowed}")


def open_port(port: str, line_format: LineFormat) -> Link:
    """Open a serial device or, with `tcp:HOST:PORT`, a connection that carries the line's bytes.

    Raises:
        ValueError: the address is invalid.
        LinkError: the port can't be opened.
    """
    check_address(port)
    if not port.startswith(TCP):
        return SerialLink(port, line_format)
    return TcpLink(*split_address(port.removeprefix(TCP)))


Sending = tuple[bytes, LineFormat] | None
"""Bytes to send and their format, or None to end the sender."""


class LiveLine(Line):
    """A line through a port.

    Args:
        open_link: function that opens the port, at the start and after each loss.

    Raises:
        LinkError: the port can't be opened.
    """

    def __init__(self, open_link: Callable[[], Link]) -> None:
        self._open = open_link
        self._port: Link | None = open_link()
        self._lock = Lock()
        self._closing = Event()
        self._received: SimpleQueue[bytes] = SimpleQueue()
        self._to_send: SimpleQueue[Sending] = SimpleQueue()
        self._losses: SimpleQueue[str] = SimpleQueue()
        self._last_reason = ""  # of the latest loss, or failure to reopen
        self._failure: Exception | None = None  # error of the sender, which the receiver handles
        self._threads = [Thread(target=loop, daemon=True) for loop in (self._receive, self._send)]
        for thread in self._threads:
            thread.start()

    @override
    def next_event_ns(self) -> int | None:
        """Return 0, an instant in the past, if bytes have been received; otherwise None."""
        return None if self._received.empty() else 0

    @override
    def run_until(self, now_ns: int) -> None:
        """Do nothing, since real time advances by itself."""

    @override
    def take(self) -> bytes:
        chunks: list[bytes] = list(_drain(self._received))
        return b"".join(chunks)

    def take_losses(self) -> list[str]:
        """Return the reason of each loss of the port since the last call."""
        return list(_drain(self._losses))

    @override
    def send(self, data: bytes, line_format: LineFormat) -> None:
        self._to_send.put((data, line_format))

    def close(self) -> None:
        """Send the queued bytes, then close the port."""
        self._closing.set()
        self._to_send.put(None)
        for thread in self._threads:
            thread.join()
        self._close_port()

    def _receive(self) -> None:
        """Run the thread that receives, and that closes and reopens the port."""
        while not self._closing.is_set():
            try:
                self._listen()
            except Exception as error:  # an unexpected error must not end the thread silently
                self._note_loss(error)

    def _listen(self) -> None:
        """Wait once for bytes; if the port is lost, try once to reopen it."""
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
        if self._port is None:
            self._reopen()
        elif data := self._port.receive(1, RECEIVE_S):
            self._received.put(data)

    def _send(self) -> None:
        """Run the thread that sends, until `close`."""
        while (sending := self._to_send.get()) is not None:
            with self._lock:
                try:
                    self._pass_on(*sending)
                except Exception as error:  # see `_receive`, which reports the loss
                    self._failure = error

    def _pass_on(self, data: bytes, line_format: LineFormat) -> None:
        """Send bytes through the port; drop them while the port is lost."""
        if self._port is not None:
            self._port.follow(line_format)
            self._port.send(data)

    def _note_loss(self, error: Exception) -> None:
        """Close the port, and store the reason; a repeated failure to reopen is stored once."""
        reason = _message_of(error)
        if self._port is not None or reason != self._last_reason:
            self._losses.put(reason)
        self._last_reason = reason
        self._close_port()

    def _close_port(self) -> None:
        """Close the port, if there is one; an error while closing is another loss."""
        with self._lock:
            port, self._port = self._port, None
            self._failure = None  # an error of the same port, so not a second loss
        if port is None:
            return
        try:
            port.close()
        except Exception as error:  # the port is closed in any case
            self._losses.put(_message_of(error))

    def _reopen(self) -> None:
        """Wait for `REOPEN_S`, then try to open the port, unless the line is closed in the meantime."""
        if self._closing.wait(REOPEN_S):
            return
        try:
            port = self._open()
        except LinkError:
            return
        with self._lock:
            self._port = port


def _message_of(error: Exception) -> str:
    """Return an error's text, preceded by its type unless it is a `LinkError`."""
    return str(error) if isinstance(error, LinkError) else f"{type(error).__name__}: {error}"


def _drain(queue: SimpleQueue[Item]) -> Iterator[Item]:
    """Yield the items of a queue until it is empty."""
    while True:
        try:
            yield queue.get_nowait()
        except Empty:
            return
