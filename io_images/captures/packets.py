"""The packets of a pcap or pcapng capture file, in file order [draft-ietf-opsawg-pcap, -pcapng].

A file ends in the middle of a packet if the capture program was killed. Complete packets are read, and
`Capture.cut_off` is the offset of the incomplete packet. Any other error raises a `CaptureError` with the
error's offset.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from struct import Struct
from typing import BinaryIO

BLOCK_MAX = 16 << 20
"""Maximum bytes of a pcapng block."""

PACKET_MAX = 256 << 10
"""Maximum bytes of a packet: the largest snapshot length of tcpdump and Wireshark."""

INTERFACES_MAX = 1024
NS_PER_S = 1_000_000_000

SECTION, INTERFACE, SIMPLE_PACKET, ENHANCED_PACKET = 0x0A0D0D0A, 1, 3, 6
BYTE_ORDER_MAGIC = 0x1A2B3C4D
OPTION_END, OPTION_TSRESOL, OPTION_TSOFFSET = 0, 9, 14
PCAP_MAGICS = {0xA1B2C3D4: 1_000, 0xA1B23C4D: 1}
"""The unit of time in ns, by magic number."""

_US_DECIMALS = 6
_DECIMALS_MAX, _BINARY_MAX = 19, 63


class CaptureError(ValueError):
    """The file is not a capture, or is damaged."""


@dataclass(frozen=True, slots=True)
class Packet:
    """A packet as it appeared on the wire."""

    at_ns: int  # since 1970
    link_type: int  # LINKTYPE number of its first header
    data: bytes  # the captured bytes
    cut: int = 0  # number of bytes that were not captured, because the frame is longer than the snap length


@dataclass(slots=True)
class CutFrames:
    """The number of frames that a capture truncated, and their captured lengths.

    >>> cut = CutFrames()
    >>> cut.add(Packet(0, 1, bytes(68), cut=10)), cut.add(Packet(0, 1, bytes(68))), str(cut)
    (None, None, '1 at 68 bytes')
    """

    count: int = 0
    least: int = 0  # captured bytes of the shortest cut frame
    most: int = 0  # captured bytes of the longest cut frame

    def add(self, packet: Packet) -> None:
        """Count a packet if it was truncated."""
        if packet.cut:
            size = len(packet.data)
            self.least = min(self.least, size) if self.count else size
            self.most = max(self.most, size)
            self.count += 1

    def __str__(self) -> str:
        sizes = f"{self.least:,}" if self.least == self.most else f"{self.least:,} to {self.most:,}"
        return f"{self.count:,} at {sizes} bytes"


@dataclass(frozen=True, slots=True)
class _Interface:
    """A network interface of a pcapng section."""

    link_type: int
    units_per_s: int  # of time stamps
    offset_s: int  # added to time stamps

    def at_ns(self, units: int) -> int:
        """Convert a time stamp to ns since 1970."""
        return self.offset_s * NS_PER_S + units * NS_PER_S // self.units_per_s


class Capture:
    """A capture file, open for reading.

    Attributes:
        cut_off: offset of an incomplete last packet; None for a complete file.
        cut_frames: the truncated frames so far.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._offset = 0
        self.cut_off: int | None = None
        self.cut_frames = CutFrames()

    def packets(self) -> Iterator[Packet]:
        """Yield the packets.

        Raises:
            CaptureError: the file is not a capture, or contains an illegal length or number.
            OSError: the file can't be read.
        """
        head = self._file.read(4)
        big, little = int.from_bytes(head, "big"), int.from_bytes(head, "little")
        self._offset = 4
        if big == SECTION:
            yield from map(self._counted, self._blocks())
        elif big in PCAP_MAGICS or little in PCAP_MAGICS:
            byte_order = ">" if big in PCAP_MAGICS else "<"
            records = self._records(byte_order, PCAP_MAGICS.get(big) or PCAP_MAGICS[little])
            yield from map(self._counted, records)
        else:
            raise CaptureError(f"it is not a capture: it begins with {head.hex(' ') or 'nothing'}")

    def _counted(self, packet: Packet) -> Packet:
        """Count a packet if it was truncated; return it."""
        self.cut_frames.add(packet)
        return packet

    def _read(self, size: int, begin: int) -> bytes:
        """Return `size` bytes of the packet or block at `begin`; b"" at the end of the file.

        The end within a packet or block becomes `cut_off`.
        """
        data = self._file.read(size)
        self._offset += len(data)
        if len(data) == size:
            return data
        if self._offset > begin:
            self.cut_off = begin
        return b""

    # -- pcap -------------------------------------------------------------------------------------

    def _records(self, order: str, unit_ns: int) -> Iterator[Packet]:
        """Yield the packets of a pcap file; `order` is the byte order in the notation of `struct`."""
        head = self._read(20, 0)
        if not head:
            return
        link_type = Struct(f"{order}I").unpack_from(head, 16)[0] & 0xFFFF
        record = Struct(f"{order}IIII")
        while True:
            begin = self._offset
            fields = self._read(record.size, begin)
            if not fields:
                return
            seconds, fraction, captured_bytes, sent_bytes = record.unpack(fields)
            if captured_bytes > PACKET_MAX:
                raise CaptureError(
                    f"byte {begin}: a packet of {captured_bytes:,} bytes; must be at most {PACKET_MAX:,}"
                )
            data = self._read(captured_bytes, begin) if captured_bytes else b""
            if len(data) < captured_bytes:
                return
            at_ns = seconds * NS_PER_S + fraction * unit_ns
            yield Packet(at_ns, link_type, data, max(0, sent_bytes - captured_bytes))

    # -- pcapng -----------------------------------------------------------------------------------

    def _blocks(self) -> Iterator[Packet]:
        """Yield the packets of a pcapng file; `packets` has already read the type of its first block."""
        byte_order = "<"
        interfaces: list[_Interface] = []
        kind, begin = SECTION, 0
        while True:
            length_bytes = self._read(4, begin)
            if not length_bytes:
                return
            head = b""
            if kind == SECTION:  # its byte order, needed for the length, comes after the length
                head = self._read(4, begin)
                if not head:
                    return
                byte_order, interfaces = _byte_order(head, begin), []
            body = self._body(Struct(f"{byte_order}I").unpack(length_bytes)[0], len(head), byte_order, begin)
            if body is None:
                return
            if kind == INTERFACE:
                interfaces.append(_interface(body, byte_order, begin))
                if len(interfaces) > INTERFACES_MAX:
                    raise CaptureError(f"byte {begin}: more than {INTERFACES_MAX:,} interfaces")
            elif kind == ENHANCED_PACKET:
                yield _enhanced(body, byte_order, begin, interfaces)
            elif kind == SIMPLE_PACKET:
                raise CaptureError(f"byte {begin}: a packet without a time; it needs enhanced packet blocks")
            begin = self._offset
            kind_bytes = self._read(4, begin)
            if not kind_bytes:
                return
            kind = int.from_bytes(kind_bytes, "little" if byte_order == "<" else "big")

    def _body(self, length: int, bytes_read: int, order: str, begin: int) -> bytes | None:
        """Return the rest of a block, without the length at its end; None at the end of the file.

        Args:
            length: bytes of the block, including its type and both lengths.
            bytes_read: bytes after the first length that have been read.
        """
        if length % 4 or not 12 + bytes_read <= length <= BLOCK_MAX:
            limits = f"must be a multiple of 4, {12 + bytes_read} to {BLOCK_MAX:,}"
            raise CaptureError(f"byte {begin}: a block of {length:,} bytes; {limits}")
        data = self._read(length - 8 - bytes_read, begin)
        if not data:
            return None
        end_length = Struct(f"{order}I").unpack(data[-4:])[0]
        if end_length != length:
            raise CaptureError(
                f"byte {begin}: a block has the length {length:,} at its beginning, {end_length:,} at its end"
            )
        return data[:-4]


def _byte_order(magic: bytes, begin: int) -> str:
    """Return the byte order of a section, in the notation of `struct`, from its magic number."""
    for byte_order in "<>":
        if Struct(f"{byte_order}I").unpack(magic)[0] == BYTE_ORDER_MAGIC:
            return byte_order
    raise CaptureError(f"byte {begin}: a section with the byte order {magic.hex(' ')}")


def _interface(body: bytes, order: str, begin: int) -> _Interface:
    """Return the interface that a block describes; without an option, its time stamps are in µs."""
    if len(body) < 8:
        raise CaptureError(f"byte {begin}: an interface of {len(body)} bytes; must be at least 8")
    link_type = Struct(f"{order}H").unpack_from(body)[0]
    units, offset_s, offset = 10**_US_DECIMALS, 0, 8
    option = Struct(f"{order}HH")
    while offset + option.size <= len(body):
        code, size = option.unpack_from(body, offset)
        value = body[offset + 4 : offset + 4 + size]
        if code == OPTION_END or len(value) < size:
            break
        if code == OPTION_TSRESOL and size == 1:
            units = _units(value[0], begin)
        if code == OPTION_TSOFFSET and size == 8:
            offset_s = Struct(f"{order}q").unpack(value)[0]
        offset += 4 + -(-size // 4) * 4  # values are padded to 4 bytes
    return _Interface(link_type, units, offset_s)


def _units(resolution: int, begin: int) -> int:
    """Return the units per second of if_tsresol: a power of 10, or of 2 if the highest bit is set."""
    base, power = (2, resolution & 0x7F) if resolution & 0x80 else (10, resolution)
    if power > (_BINARY_MAX if base == 2 else _DECIMALS_MAX):
        raise CaptureError(f"byte {begin}: unsupported unit of time, {base}**-{power} s")
    return int(base**power)


def _enhanced(body: bytes, order: str, begin: int, interfaces: list[_Interface]) -> Packet:
    """Return the packet in an enhanced packet block; refuse an unknown interface and an impossible size."""
    head = Struct(f"{order}IIIII")
    if len(body) < head.size:
        raise CaptureError(f"byte {begin}: a packet block of {len(body)} bytes; must be at least {head.size}")
    number, high_time, low_time, captured_bytes, sent_bytes = head.unpack_from(body)
    if number >= len(interfaces):
        raise CaptureError(f"byte {begin}: a packet of interface {number}; must be below {len(interfaces)}")
    if captured_bytes > min(PACKET_MAX, len(body) - head.size):
        data_room = len(body) - head.size
        raise CaptureError(
            f"byte {begin}: a packet of {captured_bytes:,} bytes in a block with room for {data_room:,}"
        )
    interface = interfaces[number]
    data = body[head.size : head.size + captured_bytes]
    return Packet(
        at_ns=interface.at_ns(high_time << 32 | low_time),
        link_type=interface.link_type,
        data=data,
        cut=max(0, sent_bytes - captured_bytes),
    )
