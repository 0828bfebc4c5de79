"""Operations of packets and their results, as bytes sent between the server process and the scan process.

    request    version u32, packets u16; per packet: client's address, operations u16
    operation  kind u8 (read, write, masked write), tag u32, offset u32, size u32; data, mask of bits to keep
    reply      version u32, now_ns u64; per operation size u32, bytes; size FFFFFFFF: refused

After an edit of the program, a request from the previous version gets only the header of a reply.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence

from .tag_snapshot import Operation, ReadBytes, WriteBytes

HEAD, PACKET, OPERATION = struct.Struct("<IH"), struct.Struct("<BH"), struct.Struct("<BIII")
ANSWER, SIZE = struct.Struct("<IQ"), struct.Struct("<I")
REFUSED = 0xFFFF_FFFF
_READ, _WRITE, _KEEP = range(3)

Packet = tuple[str, Sequence[Operation]]
"""A client's address, and the operations of its packet."""


def request_of(version: int, packets: Sequence[Packet]) -> bytes:
    """Return the bytes of a request for the operations of packets, for one version of the program."""
    chunks = [HEAD.pack(version, len(packets))]
    for client, operations in packets:
        name = client.encode()[:255]
        chunks += [PACKET.pack(len(name), len(operations)), name]
        for operation in operations:
            if isinstance(operation, ReadBytes):
                chunks.append(OPERATION.pack(_READ, operation.tag, operation.offset, operation.size))
            else:
                kind = _KEEP if operation.keep else _WRITE
                chunks += [
                    OPERATION.pack(kind, operation.tag, operation.offset, len(operation.data)),
                    operation.data,
                    operation.keep,
                ]
    return b"".join(chunks)


def packets_in(data: bytes) -> Iterator[Packet]:
    """Yield the packets of a request; raise struct.error for a damaged request."""
    _, packet_count = HEAD.unpack_from(data)
    start = HEAD.size
    for _ in range(packet_count):
        length, operation_count = PACKET.unpack_from(data, start)
        start += PACKET.size + length
        client = data[start - length : start].decode("utf-8", "replace")
        unpacked: list[Operation] = []
        for _ in range(operation_count):
            kind, tag, offset, size = OPERATION.unpack_from(data, start)
            start += OPERATION.size
            if kind == _READ:
                unpacked.append(ReadBytes(tag, offset, size))
                continue
            end = start + size
            keep_mask = data[end : end + size] if kind == _KEEP else b""
            unpacked.append(WriteBytes(tag, offset, data[start:end], keep_mask))
            start = end + len(keep_mask)
        yield client, unpacked


def version_of(data: bytes) -> int:
    """Return the program version in a request."""
    version: int = HEAD.unpack_from(data)[0]
    return version


def answered(
    data: bytes, version: int, now_ns: int, carry_out: Callable[[str, Operation], bytes | None]
) -> bytes:
    """Carry out a request; return the reply."""
    chunks = [ANSWER.pack(version, now_ns)]
    for client, operations in packets_in(data) if version_of(data) == version else ():
        for operation in operations:
            result = carry_out(client, operation)
            chunks += [SIZE.pack(REFUSED)] if result is None else [SIZE.pack(len(result)), result]
    return b"".join(chunks)


def results_in(data: bytes, packets: Sequence[Packet]) -> list[list[bytes | None]]:
    """Return the results in a reply, a list per packet: bytes read, b"" for a write, None if refused."""
    offset, answers = ANSWER.size, []
    for _, operations in packets:
        packet_results: list[bytes | None] = []
        for _ in operations:
            (size,) = SIZE.unpack_from(data, offset)
            offset += SIZE.size
            if size == REFUSED:
                packet_results.append(None)
                continue
            packet_results.append(data[offset : offset + size])
            offset += size
        answers.append(packet_results)
    return answers
