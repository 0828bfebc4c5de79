"""The eight-byte frames of a PMC006x3s [4.1].

    command   A5  address  instruction  d0 d1 d2 d3  sum        host to controller
    reply     A5  7A       address      d0 d1 d2 d3  sum        controller to host

The data is a signed 32-bit value, low byte first: 12345678h is sent as 78 56 34 12. The manual calls this
"big-end mode", but its examples are little-endian. The last byte is the sum of the others, ignoring carry. A
reply does not name its instruction; the host matches replies to commands by order.
"""

from __future__ import annotations

from ..dataclass import dataclass

HEAD = 0xA5
"""First byte of every frame."""

REPLY = 0x7A
"""Second byte of every reply."""

FRAME_BYTES = 8
FACTORY_ADDRESS = 0xFF
"""Default address of a controller [4.1.2]."""

STATE_ERROR = 6
"""Reply data for an invalid state or an out-of-range value [4.1.1]."""

UNKNOWN_ERROR = 7
"""Reply data for an unknown instruction, or a step toward a limit that has been reached [4.1.1]."""

BAUD = 9600
"""Baud rate of the line, 8N1; no instruction changes it [6.1.1]."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame with a valid sum."""

    second: int  # the address in a command, `REPLY` in a reply
    third: int  # the instruction in a command, the controller's address in a reply
    data: int  # 32 bits, signed


def encode(second: int, third: int, data: int = 0) -> bytes:
    """Return the eight bytes of a frame.

    >>> encode(0x01, 0x73, 287).hex(" ")  # 4.3.1: address 1, run 287 steps
    'a5 01 73 1f 01 00 00 39'

    Args:
        second: 0 to 255, see `Frame`.
        third: 0 to 255.
        data: -2**31 to 2**32 - 1, sent as 32 bits.

    Raises:
        ValueError: a value does not fit.
    """
    if not 0 <= second <= 255 or not 0 <= third <= 255:
        raise ValueError(f"frame bytes {second} and {third}: must be 0 to 255")
    if not -(1 << 31) <= data < 1 << 32:
        raise ValueError(f"frame data {data}: must be -2147483648 to 4294967295")
    body = bytes((HEAD, second, third)) + (data & 0xFFFFFFFF).to_bytes(4, "little")
    return body + bytes((sum(body) & 0xFF,))


def command(address: int, code: int, data: int = 0) -> bytes:
    """Return the frame of an instruction to the controller at `address`."""
    return encode(address, code, data)


def reply(address: int, data: int = 0) -> bytes:
    """Return the frame of a reply from the controller at `address`.

    >>> reply(0x02, 4).hex(" ")  # 4.3.2: microstepping is 4
    'a5 7a 02 04 00 00 00 25'
    """
    return encode(REPLY, address, data)


def decode(frame: bytes) -> Frame | None:
    """Return the content of an eight-byte frame; None if the head or the sum is wrong.

    >>> decode(bytes.fromhex("a5 02 6d 04 00 00 00 18"))
    Frame(second=2, third=109, data=4)
    """
    if len(frame) != FRAME_BYTES or frame[0] != HEAD or sum(frame[:7]) & 0xFF != frame[7]:
        return None
    return Frame(frame[1], frame[2], int.from_bytes(frame[3:7], "little", signed=True))


class Framer:
    """Finds the frames in a stream of bytes.

    Bytes before a head are skipped. If eight bytes have a wrong sum, only the first byte is skipped, so that
    a valid frame after noise is still found.
    """

    __slots__ = ("_bytes", "skipped")

    def __init__(self) -> None:
        self._bytes = bytearray()
        self.skipped = 0  # number of skipped bytes, so far

    def __len__(self) -> int:
        """Return the number of bytes in an unfinished frame."""
        return len(self._bytes)

    def feed(self, data: bytes) -> list[Frame]:
        """Add bytes and return the frames that they complete."""
        self._bytes += data
        frames = []
        while self._seek_head():
            frame = decode(bytes(self._bytes[:FRAME_BYTES]))
            if frame is None:
                self._skip(1)
            else:
                frames.append(frame)
                del self._bytes[:FRAME_BYTES]
        return frames

    def drop(self) -> None:
        """Skip an unfinished frame, for example after a silence."""
        self._skip(len(self._bytes))

    def _seek_head(self) -> bool:
        """Skip bytes before a head; return whether eight bytes follow."""
        head = self._bytes.find(HEAD)
        self._skip(len(self._bytes) if head < 0 else head)
        return len(self._bytes) >= FRAME_BYTES

    def _skip(self, count: int) -> None:
        self.skipped += count
        del self._bytes[:count]
