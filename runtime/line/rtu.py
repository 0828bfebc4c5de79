"""Modbus RTU framing: frames in a stream of bytes [Message Framing, Appendix 2].

On a line with the baud rate's timing a frame lies between two
silences of 3.5 characters, and a pause of more than 1.5 characters
within a frame makes it invalid:

    ...|  >= 3.5  |addr func data ... crc crc|  >= 3.5  |...

Transports such as TCP, pseudo-terminals and USB adapters do not keep such times.
There a frame is taken as soon as its length, known from its function, has arrived and its
CRC is right, whatever time its pieces take. Silence only resynchronizes: bytes after it may
complete the frame before it, or begin a frame:

    addr func da   ....   ta crc crc           one frame
    addr func      ....   addr func data crc crc   a beginning that is dropped, and a frame

Garbage before a frame does not lose the frame. A function of unknown length ends with silence.

Of pymodbus's `FramerRTU` only the CRC is used: 3.15 and 3.16 lose the second of two frames in one read, 3.16
loses a frame after noise, and neither knows the time between characters (tests/unit/line/test_pymodbus.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pymodbus.framer import FramerRTU

LONGEST = 256
"""Bytes of the longest frame: 1 + 1 + 252 + 2."""

SHORTEST = 4
FIXED_LENGTH = {0x01: 8, 0x02: 8, 0x03: 8, 0x04: 8, 0x05: 8, 0x06: 8, 0x11: 4}
WRITE_REGISTERS = 0x10
COUNTED = (0x0F, WRITE_REGISTERS)
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
        self._is_quiet = True
        self._starts: list[int] = []  # places in the buffer after a silence
        self.deadline_ns: int | None = None  # time at which silence ends the frame, None without one

    @property
    def gap_ns(self) -> int:
        """Silence that ends a frame."""
        return self._timing.gap_ns

    def receive(self, start_ns: int, now_ns: int, data: bytes) -> list[bytes]:
        """Receive bytes without a pause between them; return the frames whose end needs no silence.

        Args:
            start_ns: start of the first byte.
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
            return list(self._take(final=len(self._buffer) > 2 * LONGEST))
        if len(self._buffer) > LONGEST:  # too long for a frame: only its end matters
            self._spoilt = True
            del self._buffer[:-1]
        return []

    def silence(self) -> list[bytes]:
        """Return the frames received before the gap that has just passed."""
        self.deadline_ns, self._is_quiet = None, True
        if self._timing.by_length:
            return list(self._take(final=True))
        data, spoilt = bytes(self._buffer), self._spoilt
        self.clear()
        return [data] if is_frame(data) and not spoilt else []

    def clear(self) -> None:
        """Drop the bytes of the present frame."""
        self._buffer.clear()
        self._starts.clear()
        self._spoilt, self._is_quiet = False, True
        self.deadline_ns = None

    def _take(self, *, final: bool) -> Iterator[bytes]:
        """Yield the complete frames; keep what may be the beginning of another one.

        Args:
            final: a silence has passed, so also look for frames after an unlikely beginning.
        """
        buffer, offset, end = bytes(self._buffer), 0, 0
        while offset < len(buffer):
            frame = _frame_at(buffer, offset)
            if not frame and final and offset in self._starts and is_frame(buffer[offset:]):
                frame = buffer[offset:]  # the length of this function is unknown
            if frame and (start := self._within(buffer, offset, frame)) is not None:
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
        self._drop(max(end, len(buffer) - LONGEST) if final else offset)

    def _may_begin(self, buffer: bytes, at: int) -> bool:
        return at in self._starts and _begins(buffer, at)

    def _within(self, buffer: bytes, at: int, outer: bytes) -> int | None:
        """Return where a frame begins after a silence within another one, if it is the likelier of the two.

        It is likelier unless only the other frame ends exactly with the received bytes.
        """
        if self._starts[-1:] <= [at]:
            return None
        end = at + len(outer)
        start = self._frame_after(buffer, at)
        if start is None or start >= end:
            return None
        inner_frame = _frame_at(buffer, start) or b""
        return None if end == len(buffer) != start + len(inner_frame) else start

    def _frame_after(self, buffer: bytes, at: int) -> int | None:
        """Return the first place after a silence and after `at` where a frame begins."""
        return next((start for start in self._starts if start > at and _frame_at(buffer, start)), None)

    def _drop(self, count: int) -> None:
        """Drop bytes at the beginning of the buffer."""
        if count == len(self._buffer):
            self._buffer.clear()
            self._starts.clear()
            self.deadline_ns = None
        else:
            del self._buffer[:count]
            self._starts = [start - count for start in self._starts if start >= count]


def _frame_at(buffer: bytes, at: int) -> bytes | None:
    """Return the frame that begins at `at`: b"" if none does, None if it is not known (yet)."""
    length = _length(buffer, at)
    if length is None or at + length > len(buffer):
        return b"" if length is not None and length > LONGEST else None
    candidate = buffer[at : at + length]
    return candidate if is_frame(candidate) else b""


def _begins(buffer: bytes, at: int) -> bool:
    """Whether a frame that is not complete has a known function, and a count that fits its quantity."""
    head = buffer[at + 1 : at + COUNT_AT + 1]
    if len(head) == COUNT_AT and head[0] in COUNTED:
        quantity = int.from_bytes(head[3:5], "big")
        return head[5] == (2 * quantity if head[0] == WRITE_REGISTERS else -(-quantity // 8))
    return not head or head[0] in (*FIXED_LENGTH, *COUNTED)


def _length(buffer: bytes, at: int) -> int | None:
    """Return the length of the request that begins at `at`, None if it is not known (yet)."""
    if at + 1 >= len(buffer):
        return None
    function = buffer[at + 1]
    if function in COUNTED:
        return 9 + buffer[at + COUNT_AT] if at + COUNT_AT < len(buffer) else None
    return FIXED_LENGTH.get(function)
