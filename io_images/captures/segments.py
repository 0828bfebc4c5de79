"""TCP segments in packets: link layer, IPv4 or IPv6, TCP.

Packets without TCP are skipped; no packet is refused. A segment in a truncated frame has its header fields
but no data. IP fragments are skipped: Modbus and the frames of controllers are shorter than any path's MTU.
"""

from __future__ import annotations

from dataclasses import dataclass
from ipaddress import ip_address
from struct import Struct
from typing import NamedTuple

from .packets import Packet

IPV4, IPV6 = 0x0800, 0x86DD
VLANS = (0x8100, 0x88A8, 0x9100)
VLANS_MAX = 4
EXTENSIONS = (0, 43, 60)
"""IPv6 extension headers that may precede TCP: hop-by-hop, routing, destination."""

EXTENSIONS_MAX = 8
TCP = 6
SYN, FIN, RST, ACK = 0x02, 0x01, 0x04, 0x10

ETHERNET, NULL, LOOP, SLL, SLL2 = 1, 0, 108, 113, 276
RAW = (12, 14, 101, 228, 229)
KIND_AT = {ETHERNET: (12, 14), SLL: (14, 16), SLL2: (0, 20)}
"""For each link type, the offsets of the protocol number and the packet."""

_KIND = Struct(">H")
_IPV4 = Struct(">BxHxxHxBxx4s4s")
_IPV6 = Struct(">BxxxHBx16s16s")
_TCP = Struct(">HHIIBB")

End = tuple[str, int]
"""Address and port of one end of a connection."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A TCP segment."""

    at_ns: int
    source: End
    target: End
    sequence: int  # number of its first byte
    flags: int
    data: bytes
    acknowledged: int | None = None  # number of the next byte that the sender expects; None without ACK
    cut: bool = False  # whether the capture lacks some of its data; then `data` is empty


def segment_in(packet: Packet) -> Segment | None:
    """Return the TCP segment in a packet; None for other packets."""
    ip_offset = _ip_offset(packet)
    captured_bytes = len(packet.data)
    if ip_offset is None or ip_offset >= captured_bytes:
        return None
    frame_bytes = captured_bytes + packet.cut
    version = packet.data[ip_offset] >> 4
    payload: _Payload | None = None
    if version == 4:
        payload = _ipv4(packet.data, ip_offset, frame_bytes)
    elif version == 6:
        payload = _ipv6(packet.data, ip_offset, frame_bytes)
    if payload is None:
        return None
    begin, end = payload.begin, payload.end
    if min(end, captured_bytes) - begin < _TCP.size or end > frame_bytes:
        return None
    source_port, target_port, sequence, next_sequence, offset, flags = _TCP.unpack_from(packet.data, begin)
    data_begin = begin + 4 * (offset >> 4)
    if not begin + 20 <= data_begin <= end:  # a TCP header has at least 20 bytes
        return None
    return Segment(
        at_ns=packet.at_ns,
        source=(str(ip_address(payload.source)), source_port),
        target=(str(ip_address(payload.target)), target_port),
        sequence=sequence,
        flags=flags,
        data=packet.data[data_begin:end] if end <= captured_bytes else b"",
        acknowledged=next_sequence if flags & ACK else None,
        cut=end > max(captured_bytes, data_begin),
    )


def _ip_offset(packet: Packet) -> int | None:
    """Return the offset of the IP packet; None for any other protocol."""
    if packet.link_type in RAW:
        return 0
    if packet.link_type in (NULL, LOOP):
        return 4
    if packet.link_type not in KIND_AT:
        return None
    kind_offset, begin = KIND_AT[packet.link_type]
    for _ in range(VLANS_MAX):
        if len(packet.data) < begin:
            return None
        kind = _KIND.unpack_from(packet.data, kind_offset)[0]
        if kind not in VLANS or packet.link_type == SLL2:
            return begin if kind in (IPV4, IPV6) else None
        kind_offset, begin = begin + 2, begin + 4
    return None


class _Payload(NamedTuple):
    """The TCP part of an IP packet, as offsets, and the packet's addresses."""

    source: bytes
    target: bytes
    begin: int
    end: int  # 0 in the length field of IP means that the network card sets it later: then of the frame


def _ipv4(data: bytes, offset: int, frame_bytes: int) -> _Payload | None:
    """Return the payload of an IPv4 packet; None for a fragment, another protocol or a truncated header."""
    if len(data) - offset < _IPV4.size:
        return None
    head, total_bytes, fragment, protocol, source, target = _IPV4.unpack_from(data, offset)
    begin = offset + 4 * (head & 0xF)
    end = offset + total_bytes if total_bytes else frame_bytes
    is_fragment = bool(fragment & 0x3FFF)  # the flag "more fragments", or an offset
    if protocol != TCP or is_fragment or begin < offset + 20:
        return None
    return _Payload(source, target, begin, end)


def _ipv6(data: bytes, offset: int, frame_bytes: int) -> _Payload | None:
    """Return the payload of an IPv6 packet after its extension headers; None for another protocol.

    A fragment has a header of another protocol. A truncated header also yields None.
    """
    if len(data) - offset < _IPV6.size:
        return None
    _, payload_bytes, next_header, source, target = _IPV6.unpack_from(data, offset)
    begin = offset + 40
    end = begin + payload_bytes if payload_bytes else frame_bytes
    for _ in range(EXTENSIONS_MAX):
        if next_header not in EXTENSIONS or begin + 2 > min(end, len(data)):
            break
        next_header, begin = data[begin], begin + 8 * (data[begin + 1] + 1)
    return _Payload(source, target, begin, end) if next_header == TCP else None
