"""Modbus RTU framing: frames in a stream of bytes [Message Framing, Appendix 2].

On a line with exact timing, a frame lies between two silences of 3.5 characters, and a pause of more than 1.5
characters within a frame makes it invalid:

    ...|  >= 3.5  |addr func data ... crc crc|  >= 3.5  |...

TCP, pseudo-terminals and USB adapters do not keep this timing. There, a frame is complete when as many bytes
as its function requires have arrived and its CRC is correct, regardless of pauses. Silence only
resynchronizes: the bytes after it either complete the frame before it, or begin a new frame:

    addr func da   ....   ta crc crc               one frame
    addr func      ....   addr func data crc crc   a fragment that is dropped, and a frame

A frame after garbage is not lost. A frame ends with silence if its function has no known length.

Only the CRC of pymodbus's `FramerRTU` is used. Versions 3.15 and 3.16 lose the second of two frames in one
read, and ignore the time between characters; 3.16 loses a frame after noise
(tests/unit/line/test_pymodbus.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pymodbus.framer import FramerRTU

FRAME_MAX = 256
"""Number of bytes in the longest frame: 1 + 1 + 252 + 2."""

FRAME_MIN = 4
FIXED_LENGTH = {0x01: 8, 0x02: 8, 0x03: 8, 0x04: 8, 0x05: 8, 0x06: 8, 0x11: 4}
WRITE_REGISTERS = 0x10
COUNTED = (0x0F, WRITE_REGISTERS)
COUNT_AT = 6


def crc(data: bytes) -> bytes:
    """Return the CRC as it is sent, low byte first.

    >>> crc(bytes.fromhex("01 11")).hex(" ")
    'c0 2c'
    >>> crc(bytes.fromhex("00 06 00 00 00 0b")).hex(" ")  # the manual prints c8 0d, the CRC for address 01
    'c9 dc'
    """
    return FramerRTU.compute_CRC(data).to_bytes(2, "big")


def frame(address: int, pdu: bytes) -> bytes:
    """Return the frame of an address and a PDU."""
    body = bytes((address,)) + pdu
    return body + crc(body)


def is_frame(data: bytes) -> bool:
    """Return whether the length and the CRC are correct."""
    return FRAME_MIN <= len(data) <= FRAME_MAX and crc(data[:-2]) == data[-2:]


@dataclass(frozen=True, slots=True)
class Timing:
    """Timing that separates frames."""

    gap_ns: int  # silence that ends a frame
    pause_ns: int | None = None  # silence in a frame that spoils it, None if pauses have no effect
    by_length: bool = False  # a frame ends with its last byte, without a silence


class Framer:
    """The receiver, which finds frames in bytes and time."""

    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._buffer = bytearray()
        self._spoilt = False
        self._last_ns = 0
        self._is_quiet = True
        self._starts: list[int] = []  # offsets in the buffer after a silence
        self.deadline_ns: int | None = None  # instant at which silence ends the frame, None without one

    @property
    def gap_ns(self) -> int:
        """Silence that ends a frame."""
        return self._timing.gap_ns

    def receive(self, start_ns: int, now_ns: int, data: bytes) -> list[bytes]:
        """Receive bytes that arrive without a pause; return the frames that are complete without a silence.

        Args:
            start_ns: instant at which the first byte starts.
        """
        timing = self._timing
        if self._buffer and timing.pause_ns is not None and start_ns - self._last_ns > timing.pause_ns:
            self._spoilt = True
        if self._is_quiet:
            self._starts.append(len(self._buffer))
        self._is_quiet = False
        self._buffer += data
        self._last_ns = now_ns
        self.deadline_ns = now_ns + timing.gap_ns
        if timing.by_length:
            return list(self._take(final=len(self._buffer) > 2 * FRAME_MAX))
        if len(self._buffer) > FRAME_MAX:  # too long for a frame: keep only its end
            self._spoilt = True
            del self._buffer[:-1]
        return []

    def silence(self) -> list[bytes]:
        """Return the frames before the silence that has just passed."""
        self.deadline_ns, self._is_quiet = None, True
        if self._timing.by_length:
            return list(self._take(final=True))
        data, spoilt = bytes(self._buffer), self._spoilt
        self.clear()
        return [data] if is_frame(data) and not spoilt else []

    def clear(self) -> None:
        """Drop the bytes of the current frame."""
        self._buffer.clear()
        self._starts.clear()
        self._spoilt, self._is_quiet = False, True
        self.deadline_ns = None

    def _take(self, *, final: bool) -> Iterator[bytes]:
        """Yield the complete frames, and keep bytes that could begin another frame.

        Args:
            final: whether a silence has passed; if so, also find frames after bytes that are unlikely to
                begin one.
        """
        buffer, offset, end = bytes(self._buffer), 0, 0
        while offset < len(buffer):
            frame = _frame_at(buffer, offset)
            if not frame and final and offset in self._starts and is_frame(buffer[offset:]):
                frame = buffer[offset:]  # a function of unknown length
            if frame and (start := self._likelier_start(buffer, offset, frame)) is not None:
                offset = start
            elif frame:
                yield frame
                offset = end = offset + len(frame)
            elif frame is not None or (final and not self._may_begin(buffer, offset)):
                offset += 1
            elif (start := self._frame_after(buffer, offset)) is not None:
                offset = start
            else:
                break
        self._drop(max(end, len(buffer) - FRAME_MAX) if final else offset)

    def _may_begin(self, buffer: bytes, offset: int) -> bool:
        return offset in self._starts and _may_be_head(buffer[offset : offset + COUNT_AT + 1])

    def _likelier_start(self, buffer: bytes, offset: int, outer: bytes) -> int | None:
        """Return the start of a likelier frame, which begins after a silence in the outer frame, or None.

        The inner frame is likelier, unless only the outer frame ends exactly with the received bytes.
        """
        if self._starts[-1:] <= [offset]:
            return None
        outer_end = offset + len(outer)
        start = self._frame_after(buffer, offset)
        if start is None or start >= outer_end:
            return None
        inner_end = start + len(_frame_at(buffer, start) or b"")
        return None if outer_end == len(buffer) != inner_end else start

    def _frame_after(self, buffer: bytes, offset: int) -> int | None:
        """Return the first start of a frame that follows a silence after `offset`, or None."""
        return next((start for start in self._starts if start > offset and _frame_at(buffer, start)), None)

    def _drop(self, count: int) -> None:
        """Drop bytes at the beginning of the buffer."""
        if count == len(self._buffer):
            self._buffer.clear()
            self._starts.clear()
            self.deadline_ns = None
        else:
            del self._buffer[:count]
            self._starts = [start - count for start in self._starts if start >= count]


def _frame_at(buffer: bytes, offset: int) -> bytes | None:
    """Return the frame at an offset, b"" if there is none, or None if more bytes could complete one."""
    length = _length(buffer, offset)
    if length is None or offset + length > len(buffer):
        return b"" if length is not None and length > FRAME_MAX else None
    candidate = buffer[offset : offset + length]
    return candidate if is_frame(candidate) else b""


def _may_be_head(data: bytes) -> bool:
    """Return whether bytes could begin a frame: a known function, and a byte count that fits the quantity."""
    head = data[1:]
    if len(head) == COUNT_AT and head[0] in COUNTED:
        quantity = int.from_bytes(head[3:5], "big")
        return head[5] == (2 * quantity if head[0] == WRITE_REGISTERS else -(-quantity // 8))
    return not head or head[0] in (*FIXED_LENGTH, *COUNTED)


def _length(buffer: bytes, offset: int) -> int | None:
    """Return the length of the request at an offset, or None if it is not known, or not known yet."""
    if offset + 1 >= len(buffer):
        return None
    function = buffer[offset + 1]
    if function in COUNTED:
        return 9 + buffer[offset + COUNT_AT] if offset + COUNT_AT < len(buffer) else None
    return FIXED_LENGTH.get(function)
