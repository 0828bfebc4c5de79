"""A client's line to a device, and its errors."""

from __future__ import annotations

import socket
from collections.abc import Callable
from contextlib import suppress
from threading import Event
from typing import Protocol, TypeVar

import serial
from typing_extensions import override

from ..hosts import join_address
from ..serialport import PORT_ERRORS, reason, settings
from ..wire import LineFormat

Answer = TypeVar("Answer")

ANSWER_S = 0.2
"""Longest wait for an answer, s; on a serial line an answer takes 6 to 28 ms."""

ANSWER_RANGE_S = (0.01, 60.0)
"""Allowed range for the user's setting of this wait, s."""

SILENCE_S = 0.004
"""Silence before a request, s (four characters at 9,600 baud); a duplicate answer shows up during it."""

LATE_S = 0.1
"""Additional wait after a missing answer, s; an answer that arrives during it is dropped."""

TRIES = 3
"""Number of attempts for a request that can safely be repeated."""

POLL_S = 0.05
"""Time between two reads of a motion's state, s."""

Progress = Callable[[int], None]
"""Function that is called with the position during a motion."""


class LinkError(Exception):
    """An exchange with the device failed.

    Attributes:
        reason: the error message, without the received bytes.
        received: the bytes of an incomplete or damaged answer that arrived.
    """

    def __init__(self, message: str, received: bytes = b"") -> None:
        super().__init__(f"{message}: {received.hex(' ')}" if received else message)
        self.reason = message
        self.received = received


class NoAnswerError(LinkError):
    """No complete answer arrived in time."""


class BadResponseError(LinkError):
    """The answer is damaged, or it belongs to another request."""


class RefusedError(LinkError):
    """The device refused the request."""


class UnconfirmedMotionError(LinkError):
    """A motion command was sent, but no motion was seen; the command is not repeated."""


class StoppedError(LinkError):
    """A motion did not end at its target."""


def until_answered(exchange: Callable[[], Answer]) -> Answer:
    """Call `exchange` until a valid answer arrives, at most `TRIES` times; return the answer.

    Raises:
        LinkError: the last attempt failed, or the device refused.
    """
    for _ in range(TRIES - 1):
        with suppress(NoAnswerError, BadResponseError):
            return exchange()
    return exchange()


class Link(Protocol):
    """A line that carries bytes to and from a device. A lost line raises LinkError."""

    def send(self, data: bytes) -> None:
        """Send bytes."""

    def receive(self, count: int, seconds: float) -> bytes:
        """Return `count` bytes as soon as they have arrived, or fewer if `seconds` have passed."""

    def follow(self, line_format: LineFormat) -> None:
        """Change the format for sending and receiving; a link that has no format ignores the change."""

    def pause(self, seconds: float) -> None:
        """Wait."""
        Event().wait(seconds)

    def close(self) -> None:
        """Release the line."""


def checked_answer_s(seconds: float) -> float:
    """Return an answer time; raise ValueError if it is outside `ANSWER_RANGE_S`."""
    shortest, longest = ANSWER_RANGE_S
    if not shortest <= seconds <= longest:
        raise ValueError(f"timeout {seconds:g} s: must be {shortest:g} to {longest:g}")
    return seconds


def drain(link: Link, quiet_s: float) -> bytes:
    """Read bytes until the line has been silent for `quiet_s`, but at most 4,096 bytes; return them."""
    dropped = b""
    while len(dropped) < 4096 and (data := link.receive(1, quiet_s)):
        dropped += data
    return dropped


class SerialLink(Link):
    """A serial port of this machine.

    Args:
        line_format: speed and character format; a pseudo-terminal is opened without parity.

    Raises:
        LinkError: the port can't be opened.
    """

    def __init__(self, path: str, line_format: LineFormat) -> None:
        self._path = path
        try:
            self._port = serial.Serial(
                path,
                **settings(path, line_format),
                exclusive=True,
                write_timeout=2.0,
            )
        except PORT_ERRORS as error:
            raise LinkError(f"{path} can't be opened: {reason(error)}") from error

    @override
    def follow(self, line_format: LineFormat) -> None:
        """Change the format; `send` returns only after its bytes have left the port."""
        try:
            self._port.apply_settings(settings(self._path, line_format))
        except PORT_ERRORS as error:
            raise LinkError(f"{self._path} can't be set to {line_format}: {error}") from error

    @override
    def send(self, data: bytes) -> None:
        try:
            self._port.write(data)
            self._port.flush()
        except PORT_ERRORS as error:
            raise LinkError(f"{self._path} is gone: {reason(error)}") from error

    @override
    def receive(self, count: int, seconds: float) -> bytes:
        try:
            self._port.timeout = seconds
            return bytes(self._port.read(count))
        except PORT_ERRORS as error:
            raise LinkError(f"{self._path} is gone: {reason(error)}") from error

    @override
    def close(self) -> None:
        self._port.close()


class TcpLink(Link):
    """A TCP connection that carries the line's bytes.

    Raises:
        LinkError: the connection fails.
    """

    def __init__(self, host: str, port: int, timeout_s: float = 3.0) -> None:
        self._name = join_address(host, port)
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except OSError as error:
            raise LinkError(f"{self._name} can't be reached: {error.strerror or error}") from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    @override
    def follow(self, line_format: LineFormat) -> None:
        """Do nothing: the other end sets the format."""

    @override
    def send(self, data: bytes) -> None:
        try:
            self._socket.settimeout(2.0)
            self._socket.sendall(data)
        except OSError as error:
            raise LinkError(f"{self._name} is gone: {error}") from error

    @override
    def receive(self, count: int, seconds: float) -> bytes:
        """Return `count` bytes, or fewer after a silence of `seconds`."""
        data = b""
        self._socket.settimeout(seconds)
        while len(data) < count:
            try:
                received = self._socket.recv(count - len(data))
            except TimeoutError:
                return data
            except OSError as error:
                raise LinkError(f"{self._name} is gone: {error}") from error
            if not received:
                raise LinkError(f"{self._name} has closed the connection")
            data += received
        return data

    @override
    def close(self) -> None:
        self._socket.close()
