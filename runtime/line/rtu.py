"""Modbus RTU framing: frames in a stream of bytes [Message Framing, Appendix 2].

On a line with the baud rate's timing a frame is between two
silences of 3.5 characters, and a pause of more than 1.5 characters
within a frame makes it invalid:

    ...|  >= 3.5  |addr func data ... crc crc|  >= 3.5  |...

Transports such as TCP, pseudo-terminals and USB adapters do not keep such times.
There a frame is taken as soon as its length, known from its function, has arrived and its
CRC is right. A longer silence resynchronizes after anything else, and garbage before a
frame does not lose the frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pymodbus.framer import FramerRTU

LONGEST = 256
"""Bytes of the longest frame: 1 + 1 + 252 + 2."""

SHORTEST = 4
FIXED_LENGTH = {0x01: 8, 0x02: 8, 0x03: 8, 0x04: 8, 0x05: 8, 0x06: 8, 0x11: 4}
COUNTED = (0x0F, 0x10)
COUNT_AT = 6


def crc(data: bytes) -> bytes:
    """Return the CRC as it is sent, low byte first.

    >>> crc(bytes.fromhex("01 11")).hex(" ")
    'c0 2c'
    >>> crc(bytes.fromhex("00 06 00 00 00 0b")).hex(" ")  # printed as c8 0d, which is address 01's
    'c9 dc'
    """
    return FramerRTU.compute_CRC(data).to_bytes(2, "big")


def frame(address: int, pdu: bytes) -> bytes:
    """Return the frame of an address and a PDU."""
    body = bytes((address,)) + pdu
    return body + crc(body)


def is_frame(data: bytes) -> bool:
    """Whether the CRC is right."""
    return SHORTEST <= len(data) <= LONGEST and crc(data[:-2]) == data[-2:]


@dataclass(frozen=True, slots=True)
class Timing:
    """Rules by which the receiver separates frames."""

    gap_ns: int  # silence that ends a frame
    pause_ns: int | None = None  # silence within a frame that spoils it, None where pauses have no meaning
    by_length: bool = False  # frames are taken as soon as they are complete


class Framer:
    """The receiver: bytes and the time in, frames out."""

    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._buffer = bytearray()
        self._spoilt = False
        self._last_ns = 0
        self.deadline_ns: int | None = None  # time at which silence ends the frame, None without one

    @property
    def gap_ns(self) -> int:
        """Silence that ends a frame."""
        return self._timing.gap_ns

    def receive(self, start_ns: int, now_ns: int, data: bytes) -> list[bytes]:
        """Receive bytes without a pause between them; return frames that are complete without silence.

        Args:
            start_ns: begin of the first byte.
        """
        timing = self._timing
        if self._buffer and timing.pause_ns is not None and start_ns - self._last_ns > timing.pause_ns:
            self._spoilt = True
        self._buffer += data
        self._last_ns = now_ns
        self.deadline_ns = now_ns + timing.gap_ns
        if timing.by_length:
            return list(self._take(final=len(self._buffer) > 2 * LONGEST))
        if len(self._buffer) > LONGEST:  # too long for a frame: only its end matters
            self._spoilt = True
            del self._buffer[:-1]
        return []

    def silence(self) -> list[bytes]:
        """Return the frames received before the gap that has just passed."""
        data, spoilt = bytes(self._buffer), self._spoilt
        self.deadline_ns = None
        if is_frame(data):
            self.clear()
            return [] if spoilt else [data]
        frames = list(self._take(final=True)) if self._timing.by_length else []
        self.clear()
        return frames

    def clear(self) -> None:
        """Drop the bytes of the present frame."""
        self._buffer.clear()
        self._spoilt = False
        self.deadline_ns = None

    def _take(self, *, final: bool) -> Iterator[bytes]:
        """Yield the complete frames; keep the beginning of another one unless `final`."""
        buffer, at = bytes(self._buffer), 0
        while at < len(buffer):
            length = _length(buffer, at)
            if not final and (length is None or at + length > len(buffer)):
                break
            candidate = buffer[at : at + (length or 1)]
            taken = is_frame(candidate)
            if taken:
                yield candidate
            at += len(candidate) if taken else 1
        del self._buffer[:at]
        if not self._buffer:
            self.deadline_ns = None


def _length(buffer: bytes, at: int) -> int | None:
    """Return the length of the request that begins at `at`, None if it is not known (yet)."""
    if at + 1 >= len(buffer):
        return None
    function = buffer[at + 1]
    if function in COUNTED:
        return 9 + buffer[at + COUNT_AT] if at + COUNT_AT < len(buffer) else None
    return FIXED_LENGTH.get(function)
