"""The loop between a port and a device without I/O: bytes in, bytes out, in step with the wall clock."""

from __future__ import annotations

import socket
from collections.abc import Callable
from contextlib import closing
from typing import Generic, Protocol, TypeVar

from typing_extensions import override

from ...loop.pace import Clock, stopping_on_interrupt
from ..gateway import Gateway, GatewayRequest
from ..wire import Device
from .modbustcp import HEADER, AnswerPdu, ModbusTcpPort, reply_frame
from .port import Port

Client = tuple[socket.socket, bytes]
"""A connection of Modbus TCP and its request frame."""

LONGEST_S = 0.1
"""Longest wait before a server checks whether to stop."""


class Server(Protocol):
    """Serves a device at a port, a step at a time."""

    def step(self, longest_s: float) -> None:
        """Wait for the next event, at most that long, and handle it."""

    def close(self) -> None:
        """Close the port."""


class LineListener(Protocol):
    """Called with the bytes that pass on a line."""

    def received(self, now_ns: int, data: bytes) -> None:
        """Receive bytes on their way to the device."""

    def sent(self, now_ns: int, data: bytes) -> None:
        """Receive bytes that the device has sent."""


AnyPort = TypeVar("AnyPort", Port, ModbusTcpPort)


class PortServer(Server, Generic[AnyPort]):
    """A server with one port and a listener to the bytes that pass."""

    def __init__(self, port: AnyPort, clock: Clock, listener: LineListener | None) -> None:
        self._port: AnyPort = port
        self._clock, self._listener = clock, listener

    @override
    def close(self) -> None:
        self._port.close()

    def _notify(self, now_ns: int, *, received: bytes = b"", sent: bytes = b"") -> None:
        """Pass bytes to the listener."""
        if self._listener is not None and received:
            self._listener.received(now_ns, received)
        if self._listener is not None and sent:
            self._listener.sent(now_ns, sent)


class LineServer(PortServer[Port]):
    """A device at a port that carries the bytes of its serial line.

    Args:
        device: a unit, or a `Segment` of several.
        listener: receives every byte; None = no listener.
    """

    def __init__(
        self, device: Device, port: Port, clock: Clock, listener: LineListener | None = None
    ) -> None:
        super().__init__(port, clock, listener)
        self._device = device

    @override
    def step(self, longest_s: float) -> None:
        data = self._port.wait(self._clock.seconds_until(self._device.next_wake_ns, longest_s))
        now_ns = self._clock.now_ns()
        sent_bytes = self._device.advance(now_ns)
        if data:
            self._device.receive(now_ns, data)
            sent_bytes += self._device.advance(now_ns)
        if sent_bytes:
            self._port.send(sent_bytes)
        self._notify(now_ns, received=data, sent=sent_bytes)
        self._port.follow(self._device.line_format)


class PduServer(PortServer[ModbusTcpPort]):
    """A device at a Modbus TCP port: requests bypass its serial line, but its time runs.

    Args:
        device: a unit, or a `Segment` of several.
        answer: answers a request PDU, at the present instant of the device.
        listener: receives every request and reply, unit and PDU; None = no listener.
    """

    def __init__(
        self,
        device: Device,
        answer: AnswerPdu,
        port: ModbusTcpPort,
        clock: Clock,
        listener: LineListener | None = None,
    ) -> None:
        super().__init__(port, clock, listener)
        self._device = device
        self._answer_pdu = answer

    @override
    def step(self, longest_s: float) -> None:
        self._port.serve(self._clock.seconds_until(self._device.next_wake_ns, longest_s), self._answer)
        self._device.advance(self._clock.now_ns())

    def _answer(self, unit: int, pdu: bytes) -> bytes | None:
        now_ns = self._clock.now_ns()
        self._device.advance(now_ns)
        reply = self._answer_pdu(unit, pdu)
        self._notify(
            now_ns, received=bytes((unit,)) + pdu, sent=b"" if reply is None else bytes((unit,)) + reply
        )
        return reply


class GatewayServer(PortServer[ModbusTcpPort]):
    """A gateway on a Modbus TCP port, which passes requests to the serial line one at a time.

    Args:
        gateway: the master of the line.
        listener: receives every request on arrival and every reply when it is sent; None = no listener.
    """

    def __init__(
        self,
        gateway: Gateway[Client],
        port: ModbusTcpPort,
        clock: Clock,
        listener: LineListener | None = None,
    ) -> None:
        super().__init__(port, clock, listener)
        self._gateway = gateway

    @override
    def step(self, longest_s: float) -> None:
        wait_s = self._clock.seconds_until(self._gateway.next_wake_ns, longest_s)
        requests = [(peer, frame) for peer, frames in self._port.requests(wait_s) for frame in frames]
        now_ns = self._clock.now_ns()
        replies = self._gateway.advance(now_ns)  # before the new requests are queued
        for connection, frame in requests:
            unit, pdu = frame[HEADER.size - 1], frame[HEADER.size :]
            self._notify(now_ns, received=frame[HEADER.size - 1 :])
            refusal = self._gateway.ask(GatewayRequest((connection, frame), unit, pdu))
            if refusal is not None:
                replies.append(((connection, frame), refusal))
        replies += self._gateway.advance(now_ns)
        for (connection, frame), pdu in replies:
            reply = reply_frame(frame, pdu)
            self._notify(now_ns, sent=reply[HEADER.size - 1 :])
            self._port.send(connection, reply)


class Stop:
    """A request to stop, set by Ctrl-C."""

    def __init__(self) -> None:
        self.asked = False

    def ask(self) -> None:
        """Request a stop after the present step."""
        self.asked = True


def serve_until_interrupted(
    server: Server,
    each_step: Callable[[], None] = lambda: None,
    stop: Stop | None = None,
    longest_s: float = LONGEST_S,
) -> None:
    """Serve until Ctrl-C, or until `stop` is set; then close the port.

    Args:
        each_step: called after every step.
    """
    stop = stop or Stop()
    with closing(server), stopping_on_interrupt(stop.ask, server.step.__code__):
        while not stop.asked:
            server.step(longest_s)
            each_step()
