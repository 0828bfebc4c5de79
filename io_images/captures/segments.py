"""TCP segments in packets: link layer, IPv4 or IPv6, TCP.

Anything but TCP is skipped; nothing is refused. A segment in a frame that the capture cut has the fields of
its header, but no data. IP fragments are skipped: Modbus and the frames of controllers are shorter
than any path's MTU.
"""

from __future__ import annotations

from dataclasses import dataclass
from ipaddress import ip_address
from struct import Struct

from .packets import Packet

IPV4, IPV6 = 0x0800, 0x86DD
VLANS = (0x8100, 0x88A8, 0x9100)
VLANS_MAX = 4
EXTENSIONS = (0, 43, 60)
"""IPv6 extension headers that may precede TCP: hop by hop, routing, destination."""

EXTENSIONS_MAX = 8
TCP = 6
SYN, FIN, RST, ACK = 0x02, 0x01, 0x04, 0x10

ETHERNET, NULL, LOOP, SLL, SLL2 = 1, 0, 108, 113, 276
RAW = (12, 14, 101, 228, 229)
KIND_AT = {ETHERNET: (12, 14), SLL: (14, 16), SLL2: (0, 20)}
"""By link type: offset of the packet's type, and offset of the packet."""

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
    acknowledged: int | None = None  # number of the next byte that the sender expects from the other end
    cut: bool = False  # whether the capture lacks some of its data, so that `data` is empty


def segment_in(packet: Packet) -> Segment | None:
    """Return the TCP segment in a packet; None for anything else."""
    network_at = _network_at(packet)
    if network_at is None or network_at >= len(packet.data):
        return None
    version = packet.data[network_at] >> 4
    size = len(packet.data) + packet.cut
    network = {4: _ipv4, 6: _ipv6}.get(version)
    payload = network(packet.data, network_at, size) if network is not None else None
    if payload is None:
        return None
    source_address, target, begin, end = payload
    captured_bytes = len(packet.data)
    if min(end, captured_bytes) - begin < _TCP.size or end > captured_bytes + packet.cut:
        return None
    source_port, target_port, sequence, next_sequence, offset, flags = _TCP.unpack_from(packet.data, begin)
    data_at = begin + 4 * (offset >> 4)
    if not begin + 20 <= data_at <= end:
        return None
    end_points = (_text(source_address), source_port), (_text(target), target_port)
    data = packet.data[data_at:end] if end <= captured_bytes else b""
    acknowledged = next_sequence if flags & ACK else None
    return Segment(
        packet.at_ns, *end_points, sequence, flags, data, acknowledged, end > max(captured_bytes, data_at)
    )


def _text(address: bytes) -> str:
    return str(ip_address(address))


def _network_at(packet: Packet) -> int | None:
    """Return the offset of the IP packet; None if there is none."""
    if packet.link_type in RAW:
        return 0
    if packet.link_type in (NULL, LOOP):
        return 4
    if packet.link_type not in KIND_AT:
        return None
    kind_at, begin = KIND_AT[packet.link_type]
    for _ in range(VLANS_MAX):
        if len(packet.data) < begin:
            return None
        kind = _KIND.unpack_from(packet.data, kind_at)[0]
        if kind not in VLANS or packet.link_type == SLL2:
            return begin if kind in (IPV4, IPV6) else None
        kind_at, begin = begin + 2, begin + 4
    return None


Found = tuple[bytes, bytes, int, int]
"""Source, target, and offsets of the beginning and the end of TCP."""


def _ipv4(data: bytes, at: int, size: int) -> Found | None:
    if len(data) - at < _IPV4.size:
        return None
    head, total_bytes, fragment, protocol, source_address, target = _IPV4.unpack_from(data, at)
    begin = at + 4 * (head & 0xF)
    end = at + total_bytes if total_bytes else size  # 0 means that the network card segments it later
    is_whole = not fragment & 0x3FFF  # neither the flag "more fragments" nor an offset
    return (source_address, target, begin, end) if protocol == TCP and is_whole and begin >= at + 20 else None


def _ipv6(data: bytes, at: int, whole: int) -> Found | None:
    if len(data) - at < _IPV6.size:
        return None
    _, size, next_header, source_address, target = _IPV6.unpack_from(data, at)
    begin, end = at + 40, at + 40 + size if size else whole
    for _ in range(EXTENSIONS_MAX):
        if next_header not in EXTENSIONS or begin + 2 > min(end, len(data)):
            break
        next_header, begin = data[begin], begin + 8 * (data[begin + 1] + 1)
    return (source_address, target, begin, end) if next_header == TCP else None
