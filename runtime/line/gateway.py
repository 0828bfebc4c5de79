"""A gateway from Modbus TCP to a serial line, without I/O: one request after another, each with a time limit.

    client 1  |request|............|reply|
    client 2      |request|.....................|reply|
    line       |frame|  |frame of the reply|  |frame|  |...

Received bytes count as a reply if their checksum, address and function are right. Without a reply in time
the client gets exception 0Bh [Modbus application protocol, section 7]: *gateway target device failed to
respond*.
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
MOST_WAITING = 64
"""Requests that wait for the line; the next one gets exception 06h, *server device busy*."""

SILENCE_CHARACTERS = 3.5

Asker = TypeVar("Asker")


@dataclass(frozen=True, slots=True)
class GatewayRequest(Generic[Asker]):
    """A request: who sent it, for which unit, and its PDU."""

    asker: Asker
    unit: int
    pdu: bytes

    def refused(self, code: int) -> bytes:
        """Return the exception with that code."""
        return bytes((self.pdu[0] | EXCEPTION, code))


Answered = list[tuple[Asker, bytes]]


class Gateway(Generic[Asker]):
    """The master of a line, on behalf of Modbus TCP clients.

    Args:
        line: units on a line, as one device.
        address_of: returns the address on the line of a unit that a client names.
        timeout_ns: from the end of a request on the line to exception 0Bh.
        timed: whether characters take time on the line; a reply then ends with a silence.
    """

    def __init__(
        self, line: Device, address_of: Callable[[int], int], timeout_ns: int, *, timed: bool
    ) -> None:
        self._line = line
        self._address_of = address_of
        self._timeout_ns = timeout_ns
        self._timed = timed
        self._waiting: deque[GatewayRequest[Asker]] = deque()
        self._sent: GatewayRequest[Asker] | None = None
        self._heard = bytearray()
        self._give_up_ns = 0
        self._quiet_ns: int | None = None  # instant at which received bytes become a frame, or None

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the line's next event, or of the end of the present request."""
        times = [] if self._line.next_wake_ns is None else [self._line.next_wake_ns]
        if self._sent is not None:
            times.append(
                self._give_up_ns if self._quiet_ns is None else min(self._quiet_ns, self._give_up_ns)
            )
        return min(times, default=None)

    def ask(self, request: GatewayRequest[Asker]) -> bytes | None:
        """Queue a request; return an exception if too many wait."""
        if len(self._waiting) >= MOST_WAITING:
            return request.refused(BUSY)
        self._waiting.append(request)
        return None

    def advance(self, now_ns: int) -> Answered[Asker]:
        """Advance line and requests to `now_ns`; return the replies, each with its sender."""
        replies: Answered[Asker] = []
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
        if self._sent is not None or not self._waiting:
            return
        self._sent = request = self._waiting.popleft()
        self._heard += self._line.advance(now_ns)
        self._heard.clear()  # late: no request waits for it
        data = frame(self._address_of(request.unit), request.pdu)
        sent_ns = now_ns + self._span_ns(len(data))
        broadcast = request.unit == BROADCAST and self._address_of(BROADCAST) == BROADCAST
        self._give_up_ns = sent_ns + (self._span_ns(SILENCE_CHARACTERS) if broadcast else self._timeout_ns)
        self._quiet_ns = None
        self._line.receive(now_ns, data)

    def _span_ns(self, characters: float) -> int:
        return self._line.line_format.span_ns(int(2 * characters)) // 2 if self._timed else 0

    def _step(self, now_ns: int) -> Answered[Asker]:
        data = self._line.advance(now_ns)
        if self._sent is None:
            return []
        if data:
            self._heard += data
            self._quiet_ns = now_ns + self._span_ns(SILENCE_CHARACTERS)
        if self._quiet_ns is not None and now_ns >= self._quiet_ns:
            self._quiet_ns = None
            reply, request = bytes(self._heard), self._sent
            self._heard.clear()
            if self._is_reply(reply, request):
                self._sent = None
                return [(request.asker, reply[1:-2])]
        return self._given_up(now_ns)

    def _is_reply(self, heard: bytes, sent: GatewayRequest[Asker]) -> bool:
        right = is_frame(heard) and heard[0] == self._address_of(sent.unit)
        return right and heard[1] & ~EXCEPTION == sent.pdu[0]

    def _given_up(self, now_ns: int) -> Answered[Asker]:
        request = self._sent
        if request is None or now_ns < self._give_up_ns:
            return []
        self._sent = None
        if self._address_of(request.unit) == BROADCAST:
            return []
        return [(request.asker, request.refused(FAILED_TO_RESPOND))]
