#!/usr/bin/env bash
# what: python-pcapng ignores an interface's time offset (if_tsoffset), so its packets are dated 1970
# date: 2026-11-30
# meets: anyone who reads pcapng of a logger that stores short times and their base once
# expected: 1790000005.25, the sum of the offset and the packet's own time
# behavior:
#   The block offers the option as it stands in the file; the packet's timestamp is its own part alone.
# product: Adds the offset of the interface: [captures](captures.md)
# output:
#   if_tsoffset 1790000000, timestamp 5.25
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install python-pcapng==2.1.1
observe python - <<'PY'
import io
import struct

from pcapng import FileScanner
from pcapng.blocks import EnhancedPacket, InterfaceDescription


def block(kind, body):
    length = len(body) + 12
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)


options = struct.pack("<HHB3x", 9, 1, 6) + struct.pack("<HHq", 14, 8, 1_790_000_000) + struct.pack("<HH", 0, 0)
capture = (
    block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
    + block(1, struct.pack("<HHI", 1, 0, 65535) + options)
    + block(6, struct.pack("<IIIII", 0, 0, 5_250_000, 4, 4) + bytes(4))
)
for each in FileScanner(io.BytesIO(capture)):
    if isinstance(each, InterfaceDescription):
        offset = each.options["if_tsoffset"]
    elif isinstance(each, EnhancedPacket):
        print(f"if_tsoffset {offset}, timestamp {each.timestamp}")
PY
