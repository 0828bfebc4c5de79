"""Captures made byte by byte: TCP segments in Ethernet frames, in files of both formats."""

from __future__ import annotations

from collections.abc import Sequence
from ipaddress import ip_address
from struct import pack
from typing import NamedTuple

CLIENT, SERVER = ("10.0.0.1", 50_000), ("10.0.0.2", 502)
SYN, ACK = 0x02, 0x10


class Frame(NamedTuple):
    """A packet of a capture and its time."""

    at_ns: int
    data: bytes


def ethernet(payload: bytes, kind: int = 0x0800, vlans: Sequence[int] = ()) -> bytes:
    tags = b"".join(pack(">HH", 0x8100, vlan) for vlan in vlans)
    return bytes(range(12)) + tags + pack(">H", kind) + payload


def segment(
    data: bytes,
    sequence: int,
    *,
    asked: bool = True,
    flags: int = 0,
    acknowledged: int | None = None,
    fragment: int = 0,
    source: tuple[str, int] = CLIENT,
    target: tuple[str, int] = SERVER,
) -> bytes:
    """Return an IPv4 packet with a TCP segment, from the client if `asked`.

    Args:
        acknowledged: sequence number of the next byte that its sender expects.
    """
    if acknowledged is not None:
        flags |= ACK
    expected = (acknowledged or 0) % 2**32
    (source_ip, source_port), (target_ip, target_port) = (source, target) if asked else (target, source)
    ports = source_port, target_port
    tcp = pack(">HHIIBBHHH", *ports, sequence % 2**32, expected, 5 << 4, flags, 8192, 0, 0) + data
    ends = ip_address(source_ip).packed + ip_address(target_ip).packed
    return pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp), 0, fragment, 64, 6, 0) + ends + tcp


SNAP = 65_535


def pcap(
    frames: Sequence[Frame], order: str = "<", nanoseconds: bool = True, link: int = 1, snap: int = SNAP
) -> bytes:
    magic, unit = (0xA1B23C4D, 1) if nanoseconds else (0xA1B2C3D4, 1000)
    head = pack(f"{order}IHHiIII", magic, 2, 4, 0, 0, snap, link)
    return head + b"".join(
        pack(f"{order}IIII", at_ns // 10**9, at_ns % 10**9 // unit, len(data[:snap]), len(data)) + data[:snap]
        for at_ns, data in frames
    )


def block(kind: int, body: bytes, order: str = "<") -> bytes:
    body += bytes(-len(body) % 4)
    size = 12 + len(body)
    return pack(f"{order}II", kind, size) + body + pack(f"{order}I", size)


def pcapng(
    frames: Sequence[Frame], order: str = "<", link: int = 1, decimals: int = 9, snap: int = SNAP
) -> bytes:
    option = pack(f"{order}HHBxxxHH", 9, 1, decimals, 0, 0)
    blocks = [
        block(0x0A0D0D0A, pack(f"{order}IHHq", 0x1A2B3C4D, 1, 0, -1), order),
        block(1, pack(f"{order}HHI", link, 0, snap) + option, order),
        block(5, bytes(12), order),  # statistics, which nobody reads
    ]
    for at_ns, data in frames:
        units = at_ns // 10 ** (9 - decimals)
        head = pack(f"{order}IIIII", 0, units >> 32, units & 0xFFFFFFFF, len(data[:snap]), len(data))
        blocks.append(block(6, head + data[:snap], order))
    return b"".join(blocks)


def conversation(
    parts: Sequence[tuple[bool, bytes]], every_ns: int = 1_000_000, target: tuple[str, int] = SERVER
) -> list[Frame]:
    """Return a connection: each part a segment, to the server if its first is true."""
    sequences = {True: 1000, False: 5000}
    frames = [
        Frame(0, ethernet(segment(b"", sequences[True] - 1, flags=SYN, target=target))),
        Frame(
            0,
            ethernet(
                segment(
                    b"",
                    sequences[False] - 1,
                    asked=False,
                    flags=SYN,
                    acknowledged=sequences[True],
                    target=target,
                )
            ),
        ),
    ]
    for number, (asked, data) in enumerate(parts, 1):
        part = segment(data, sequences[asked], asked=asked, acknowledged=sequences[not asked], target=target)
        frames.append(Frame(number * every_ns, ethernet(part)))
        sequences[asked] += len(data)
    return frames


def modbus_tcp(transaction: int, pdu: str, unit: int = 1) -> bytes:
    data = bytes.fromhex(pdu)
    return pack(">HHHB", transaction, 0, len(data) + 1, unit) + data
