"""A master's view of the line to a controller, and its errors."""

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
"""Longest wait for an answer; on the line itself an answer takes 6 to 28 ms."""

ANSWER_RANGE_S = (0.01, 60.0)
"""Allowed range of the answer time that the user sets."""

SILENCE_S = 0.004
"""Silence before a request, which reveals a doubled answer: four characters at 9,600 baud."""

LATE_S = 0.1
"""Additional wait after a missing answer; a late one is dropped."""

TRIES = 3
"""Attempts per request, where repeating it does no harm."""

POLL_S = 0.05
"""Time between two reads of a motion's state."""

Progress = Callable[[int], None]
"""Called with the position while a motion runs."""


class LinkError(Exception):
    """The exchange between this program and the controller failed."""

    def __init__(self, message: str, received: bytes = b"") -> None:
        super().__init__(f"{message}: {received.hex(' ')}" if received else message)
        self.reason = message  # the cause, without the bytes
        self.received = received  # the offending bytes, as far as they arrived


class NoAnswerError(LinkError):
    """No answer, or an incomplete one, arrived in time."""


class BadResponseError(LinkError):
    """The answer is damaged, or belongs to another request."""


class RefusedError(LinkError):
    """The controller understood the request and refused it."""


class UnconfirmedMotionError(LinkError):
    """A motion command was sent, and the motor shows no sign of it; it is not repeated."""


class StoppedError(LinkError):
    """A motion ended away from its target."""


def until_answered(ask: Callable[[], Answer]) -> Answer:
    """Call `ask`, up to `TRIES` times while the answer is missing or damaged; return the answer.

    Raises:
        LinkError: the last attempt failed, or the controller refused.
    """
    for _ in range(TRIES - 1):
        with suppress(NoAnswerError, BadResponseError):
            return ask()
    return ask()


class Link(Protocol):
    """Bytes to and from a controller, and the time between them. A lost line raises LinkError."""

    def send(self, data: bytes) -> None:
        """Put bytes on the line."""

    def receive(self, count: int, seconds: float) -> bytes:
        """Return `count` bytes as soon as they have arrived, or fewer when the time is up."""

    def follow(self, line_format: LineFormat) -> None:
        """Change the format for sending and receiving; a link with its own format ignores it."""

    def pause(self, seconds: float) -> None:
        """Wait."""
        Event().wait(seconds)

    def close(self) -> None:
        """Release the line."""


def checked_answer_s(seconds: float) -> float:
    """Return an answer time after a check of its range; ValueError if it is out of `ANSWER_RANGE_S`."""
    shortest, longest = ANSWER_RANGE_S
    if not shortest <= seconds <= longest:
        raise ValueError(f"timeout {seconds:g} s: must be {shortest:g} to {longest:g}")
    return seconds


def drain(link: Link, quiet_s: float) -> bytes:
    """Drop received bytes until the line is silent for `quiet_s`; return them.

    It gives up after 4096 bytes.
    """
    dropped = b""
    while len(dropped) < 4096 and (data := link.receive(1, quiet_s)):
        dropped += data
    return dropped


class SerialLink(Link):
    """A serial port of this machine.

    Args:
        line_format: speed and character format; a pseudo-terminal has no parity and is opened without.

    Raises:
        LinkError: it can't be opened.
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
        """Change the format; bytes already sent have left the port."""
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
    """A TCP connection that carries the same bytes.

    Raises:
        LinkError: nothing listens there.
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
        """Do nothing: the far end sets the format."""

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
