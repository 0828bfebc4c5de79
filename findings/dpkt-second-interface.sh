#!/usr/bin/env bash
# what: dpkt reads every packet of a pcapng with the time resolution and the link type of its first interface
# date: 2026-11-30
# meets: anyone who measures cycle times in a capture of two network cards, or in two captures that were merged
# expected: equal times, since both packets were captured in the same second, and a link type for each packet
# behavior:
#   The second interface counts nanoseconds, the first microseconds: its packet is 1,000 times too late. datalink() has
#   one answer for the file. A Simple Packet Block, which has no time, is left out without a word.
# product: Reads resolution, offset and link type of each interface: [captures](captures.md)
# output:
#   blocks: microseconds, nanoseconds, simple
#   times: 1790000000.0 1790000000000.0
#   link type: 1
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install dpkt==1.9.8
observe python - <<'PY'
import io
import struct

import dpkt

ETHERNET, RAW_IP = 1, 101
SECOND = 1_790_000_000


def block(kind, body):
    body += bytes(-len(body) % 4)
    length = len(body) + 12
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)


def interface(link_type, decimals):
    resolution = struct.pack("<HHB3x", 9, 1, decimals)
    return block(1, struct.pack("<HHI", link_type, 0, 65535) + resolution + struct.pack("<HH", 0, 0))


def packet(number, units, data):
    return block(6, struct.pack("<IIIII", number, units >> 32, units & 0xFFFFFFFF, len(data), len(data)) + data)


capture = (
    block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
    + interface(ETHERNET, 6)
    + interface(RAW_IP, 9)
    + packet(0, SECOND * 10**6, bytes(20))
    + packet(1, SECOND * 10**9, bytes(20))
    + block(3, struct.pack("<I", 20) + bytes(20))
)
reader = dpkt.pcapng.Reader(io.BytesIO(capture))
print("blocks: microseconds, nanoseconds, simple")
print("times:", *[time for time, _ in reader])
print("link type:", reader.datalink())
PY
