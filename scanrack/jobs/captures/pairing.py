"""Pairs requests with their replies in the bytes of a connection or line: Modbus TCP, Modbus RTU, PMC006."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from pymodbus.pdu import ModbusPDU
from scanrack.io_images.pmc006 import frame as pmc
from scanrack.runtime.line.modbus_pdus import EXCEPTION, REQUESTS, mismatch
from scanrack.runtime.line.pcl601_pdus import ANSWERS
from scanrack.runtime.line.ports.modbustcp import HEADER, NotModbusError, split_frames
from scanrack.runtime.line.rtu import FRAME_MAX, Framer, Timing, is_frame
from typing_extensions import override

OPEN_MAX = 256
"""Maximum number of open requests on a connection; beyond it, the oldest counts as unanswered."""

GAP_NS = 1_000_000_000
"""Silence after which unfinished bytes of a line are dropped, ns."""


@dataclass(frozen=True, slots=True)
class PairedExchange:
    """A request and its reply.

    Attributes:
        requested_ns, answered_ns: times of the request and the reply; equal without a reply.
        unit: unit address in the request.
        request: PDU of a Modbus request; for a PMC006, the instruction and its data, 5 bytes.
        reply: PDU of the reply; for a PMC006, its data, 4 bytes; None without a reply.
    """

    requested_ns: int
    answered_ns: int
    unit: int
    request: bytes
    reply: bytes | None


class Pairing(Protocol):
    """Finds exchanges in the bytes of one connection."""

    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        """Process bytes and yield the exchanges that they complete.

        Args:
            to_device: whether the bytes go to the controller.
            fresh: whether bytes before these are missing.
        """

    def finish(self) -> Iterator[PairedExchange]:
        """Yield the requests that have no reply."""

    @property
    def passed_over(self) -> str:
        """A sentence about ignored content of the connection; "" if there is none."""
        return ""


def decoded(exchange: PairedExchange) -> tuple[ModbusPDU, ModbusPDU] | None:
    """Return a Modbus request and its reply; None if the request was refused or either can't be decoded."""
    request, reply = REQUESTS.decode(exchange.request), ANSWERS.decode(exchange.reply or b"")
    return None if request is None or reply is None or mismatch(request, reply) else (request, reply)


def _unanswered(requested_ns: int, unit: int, request: bytes) -> PairedExchange:
    return PairedExchange(requested_ns, requested_ns, unit, request, None)


class _OpenRequest(NamedTuple):
    """A request without a reply so far."""

    at_ns: int
    unit: int
    pdu: bytes


class ModbusTcpPairing(Pairing):
    """Modbus TCP: a reply has the transaction number of its request."""

    def __init__(self) -> None:
        self._unparsed = {True: b"", False: b""}
        self._open: OrderedDict[int, _OpenRequest] = OrderedDict()  # by transaction number

    @override
    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        unparsed = b"" if fresh else self._unparsed[to_device]
        try:
            frames, self._unparsed[to_device] = split_frames(unparsed + data)
        except NotModbusError:  # wait until a segment begins with a frame
            self._unparsed[to_device] = b""
            return
        for frame in frames:
            transaction, _, _, unit = HEADER.unpack_from(frame)
            pdu = frame[HEADER.size :]
            if to_device:
                yield from self._note_request(transaction, _OpenRequest(at_ns, unit, pdu))
            elif transaction in self._open and self._open[transaction].at_ns <= at_ns:
                requested_ns, unit, request = self._open.pop(transaction)
                yield PairedExchange(requested_ns, at_ns, unit, request, pdu)

    @override
    def finish(self) -> Iterator[PairedExchange]:
        for request in self._open.values():
            yield _unanswered(*request)
        self._open.clear()

    def _note_request(self, transaction: int, request: _OpenRequest) -> Iterator[PairedExchange]:
        """Store a request; yield the open request that it displaces, as a request without a reply."""
        if transaction in self._open:
            yield _unanswered(*self._open.pop(transaction))
        elif len(self._open) >= OPEN_MAX:
            yield _unanswered(*self._open.popitem(last=False)[1])
        self._open[transaction] = request


class RtuPairing(Pairing):
    """Modbus RTU: a reply follows its request, which determines the length of the reply."""

    def __init__(self) -> None:
        self._framer = Framer(Timing(GAP_NS, by_length=True))
        self._request: tuple[int, bytes] | None = None  # time and frame
        self._received = bytearray()

    @override
    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        """See `Pairing`; after missing bytes or a silence, drop the unfinished frame of a request."""
        if not to_device:
            yield from self._receive_reply(at_ns, data)
            return
        if fresh or (self._framer.deadline_ns is not None and at_ns > self._framer.deadline_ns):
            self._framer.clear()
        for frame in self._framer.receive(at_ns, at_ns, data):
            yield from self.finish()
            self._request = at_ns, frame

    @override
    def finish(self) -> Iterator[PairedExchange]:
        if self._request is not None:
            requested_ns, frame = self._request
            yield _unanswered(requested_ns, frame[0], frame[1:-2])  # without address and checksum
        self._request = None
        self._received.clear()

    def _receive_reply(self, at_ns: int, data: bytes) -> Iterator[PairedExchange]:
        """Collect bytes; yield the exchange when its reply is complete. An invalid reply becomes None."""
        if self._request is None or at_ns < self._request[0]:
            return
        requested_ns, request = self._request
        self._received += data[:FRAME_MAX]
        size = _reply_bytes(request, bytes(self._received))
        if size is None or len(self._received) < size:
            return
        reply = bytes(self._received[:size])
        is_valid = is_frame(reply) and reply[0] == request[0] and reply[1] & 0x7F == request[1]
        self._request = None
        self._received.clear()
        pdu = reply[1:-2] if is_valid else None
        yield PairedExchange(requested_ns, at_ns, request[0], request[1:-2], pdu)


def _reply_bytes(request: bytes, received: bytes) -> int | None:
    """Return the length of the reply that begins with `received`; None if it is still unknown."""
    if len(received) < 2 or received[1] & ~EXCEPTION != request[1]:
        return None
    kind = ANSWERS.lookupPduClass(received)
    return None if kind is None else kind.calculateRtuFrameSize(received) or None


class PmcPairing(Pairing):
    """PMC006 frames, paired in order because a reply does not name its instruction."""

    def __init__(self) -> None:
        self._framers = {True: pmc.Framer(), False: pmc.Framer()}
        self._open: deque[tuple[int, pmc.Frame]] = deque()

    @override
    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        if fresh:
            self._framers[to_device].drop()
        for frame in self._framers[to_device].feed(data):
            if to_device and frame.second != pmc.REPLY:
                yield from self.finish()  # one at a time: the earlier one stays unanswered
                self._open.append((at_ns, frame))
            elif self._is_reply(at_ns, frame):
                requested_ns, request = self._open.popleft()
                reply = _signed(frame.data)
                yield PairedExchange(requested_ns, at_ns, request.second, _instruction(request), reply)

    def _is_reply(self, at_ns: int, frame: pmc.Frame) -> bool:
        """Return whether a frame is the reply to the open request."""
        if not self._open or frame.second != pmc.REPLY:
            return False
        requested_ns, request = self._open[0]
        return frame.third == request.second and requested_ns <= at_ns

    @override
    def finish(self) -> Iterator[PairedExchange]:
        while self._open:
            requested_ns, request = self._open.popleft()
            yield _unanswered(requested_ns, request.second, _instruction(request))


def _instruction(frame: pmc.Frame) -> bytes:
    return bytes((frame.third,)) + _signed(frame.data)


def _signed(data: int) -> bytes:
    return data.to_bytes(4, "little", signed=True)
