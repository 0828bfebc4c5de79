"""The real-time loop between a port and a device that does no I/O itself."""

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
"""A Modbus TCP connection and its request frame."""

LONGEST_S = 0.1
"""Longest wait, s, until a server checks whether to stop."""


class Server(Protocol):
    """Serves a device on a port, step by step."""

    def step(self, longest_s: float) -> None:
        """Wait for the next event, at most `longest_s`, and handle it."""

    def close(self) -> None:
        """Close the port."""


class LineListener(Protocol):
    """A listener for the bytes on a line."""

    def received(self, now_ns: int, data: bytes) -> None:
        """Note bytes that were sent to the device."""

    def sent(self, now_ns: int, data: bytes) -> None:
        """Note bytes that the device sent."""


PortType = TypeVar("PortType", Port, ModbusTcpPort)


class PortServer(Server, Generic[PortType]):
    """A server with one port and a listener."""

    def __init__(self, port: PortType, clock: Clock, listener: LineListener | None) -> None:
        self._port: PortType = port
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
    """Serves a device on a port that carries the bytes of its serial line.

    Args:
        device: a unit, or a `BusSegment` of several units.
        listener: called with all bytes.
    """

    def __init__(
        self, device: Device, port: Port, clock: Clock, listener: LineListener | None = None
    ) -> None:
        super().__init__(port, clock, listener)
        self._device = device

    @override
    def step(self, longest_s: float) -> None:
        """Wait for bytes or the device's next event; pass the bytes on, and send the replies."""
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
    """Serves a device on a Modbus TCP port; requests bypass its serial line, but its time still advances.

    Args:
        device: a unit, or a `BusSegment` of several units.
        answer: function that carries out a request PDU at the device's current instant and returns the reply
            PDU.
        listener: called with every request and reply, as unit and PDU.
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
        self._answer = answer

    @override
    def step(self, longest_s: float) -> None:
        wait_s = self._clock.seconds_until(self._device.next_wake_ns, longest_s)
        self._port.serve(wait_s, self._advance_and_answer)
        self._device.advance(self._clock.now_ns())

    def _advance_and_answer(self, unit: int, pdu: bytes) -> bytes | None:
        """Return the reply to a request at the current instant, and notify the listener of both."""
        now_ns = self._clock.now_ns()
        self._device.advance(now_ns)
        reply, address = self._answer(unit, pdu), bytes((unit,))
        self._notify(now_ns, received=address + pdu, sent=b"" if reply is None else address + reply)
        return reply


class GatewayServer(PortServer[ModbusTcpPort]):
    """Serves a gateway on a Modbus TCP port; the gateway passes requests to the serial line one at a time.

    Args:
        gateway: the master of the line.
        listener: called with every request when it arrives, and with every reply when it is sent.
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
        """Wait for requests or the line's next event; queue the requests, and send the replies."""
        wait_s = self._clock.seconds_until(self._gateway.next_wake_ns, longest_s)
        requests = list(self._port.requests(wait_s))
        now_ns = self._clock.now_ns()
        replies = self._gateway.advance(now_ns)  # before the new requests are queued
        for connection, frames in requests:
            for frame in frames:
                # the header ends with the unit
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
        self.requested = False

    def request(self) -> None:
        """Request a stop after the current step."""
        self.requested = True


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
    with closing(server), stopping_on_interrupt(stop.request, server.step.__code__):
        while not stop.requested:
            server.step(longest_s)
            each_step()
