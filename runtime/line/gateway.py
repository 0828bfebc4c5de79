"""A gateway from Modbus TCP to a serial line, without I/O; it sends one request at a time, with a timeout.

    client 1  |request|............|reply|
    client 2      |request|.....................|reply|
    line       |frame|  |frame of the reply|  |frame|  |...

Received bytes count as a reply if their checksum, address and function are correct. If no reply arrives in
time, the client receives exception 0Bh, *gateway target device failed to respond* [Modbus application
protocol, section 7].
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from .rtu import frame, is_frame
from .wire import Device

FAILED_TO_RESPOND = 0x0B
BUSY = 0x06
EXCEPTION = 0x80
BROADCAST = 0
WAITING_MAX = 64
"""Maximum number of requests that wait for the line; others get exception 06h, *server device busy*."""

SILENCE_CHARACTERS = 3.5

Client = TypeVar("Client")


@dataclass(frozen=True, slots=True)
class GatewayRequest(Generic[Client]):
    """A request: its client, its unit and its PDU."""

    client: Client
    unit: int
    pdu: bytes

    def refused(self, code: int) -> bytes:
        """Return the reply that refuses the request with an exception code."""
        return bytes((self.pdu[0] | EXCEPTION, code))


Replies = list[tuple[Client, bytes]]


class Gateway(Generic[Client]):
    """The master of a line, on behalf of Modbus TCP clients.

    Args:
        line: the units on the line, as one device.
        address_of: function that returns the address on the line for a client's unit number.
        timeout_ns: time from the end of a request on the line to exception 0Bh.
        timed: whether characters take time on the line; if so, a reply ends with a silence.
    """

    def __init__(
        self, line: Device, address_of: Callable[[int], int], timeout_ns: int, *, timed: bool
    ) -> None:
        self._line = line
        self._address_of = address_of
        self._timeout_ns = timeout_ns
        self._timed = timed
        self._waiting: deque[GatewayRequest[Client]] = deque()
        self._sent: GatewayRequest[Client] | None = None
        self._received = bytearray()
        self._give_up_ns = 0
        self._frame_end_ns: int | None = None  # the instant at which silence ends a received frame

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the line's next event, or of the end of the current request."""
        instants = [self._line.next_wake_ns]
        if self._sent is not None:
            instants += [self._give_up_ns, self._frame_end_ns]
        return min((instant for instant in instants if instant is not None), default=None)

    def ask(self, request: GatewayRequest[Client]) -> bytes | None:
        """Queue a request; return an exception if too many are waiting."""
        if len(self._waiting) >= WAITING_MAX:
            return request.refused(BUSY)
        self._waiting.append(request)
        return None

    def advance(self, now_ns: int) -> Replies[Client]:
        """Advance the line and the requests to `now_ns`; return the replies, each with its client."""
        replies: Replies[Client] = []
        while True:
            self._begin(now_ns)
            due_ns = self.next_wake_ns
            if due_ns is None or due_ns > now_ns:
                break
            replies += self._step(due_ns)
        replies += self._step(now_ns)
        self._begin(now_ns)
        return replies

    def _begin(self, now_ns: int) -> None:
        """Send the next request if the line is free."""
        if self._sent is not None or not self._waiting:
            return
        self._sent = request = self._waiting.popleft()
        self._line.advance(now_ns)  # drop late bytes: no request waits for them
        self._received.clear()
        data = frame(self._address_of(request.unit), request.pdu)
        sent_ns = now_ns + self._span_ns(len(data))
        broadcast = request.unit == BROADCAST and self._address_of(BROADCAST) == BROADCAST
        self._give_up_ns = sent_ns + (self._span_ns(SILENCE_CHARACTERS) if broadcast else self._timeout_ns)
        self._frame_end_ns = None
        self._line.receive(now_ns, data)

    def _span_ns(self, characters: float) -> int:
        """Return the time of characters on the line, in ns; 0 if characters take no time."""
        return self._line.line_format.span_ns(int(2 * characters)) // 2 if self._timed else 0

    def _step(self, now_ns: int) -> Replies[Client]:
        """Advance the line to `now_ns`; return a complete reply, or the exception for a late reply."""
        data = self._line.advance(now_ns)
        if self._sent is None:
            return []
        if data:
            self._received += data
            self._frame_end_ns = now_ns + self._span_ns(SILENCE_CHARACTERS)
        if self._frame_end_ns is not None and now_ns >= self._frame_end_ns:
            self._frame_end_ns = None
            reply, request = bytes(self._received), self._sent
            self._received.clear()
            if self._is_reply(reply, request):
                self._sent = None
                return [(request.client, reply[1:-2])]
        return self._give_up_if_due(now_ns)

    def _is_reply(self, data: bytes, request: GatewayRequest[Client]) -> bool:
        """Return whether bytes are a frame of the request's unit with the request's function."""
        is_from_unit = is_frame(data) and data[0] == self._address_of(request.unit)
        return is_from_unit and data[1] & ~EXCEPTION == request.pdu[0]

    def _give_up_if_due(self, now_ns: int) -> Replies[Client]:
        """End the request at its time limit; return exception 0Bh, or nothing for a broadcast."""
        request = self._sent
        if request is None or now_ns < self._give_up_ns:
            return []
        self._sent = None
        if self._address_of(request.unit) == BROADCAST:
            return []
        return [(request.client, request.refused(FAILED_TO_RESPOND))]
