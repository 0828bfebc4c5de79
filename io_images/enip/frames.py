"""Encapsulation frames, and the items in them [ODVA volume 2, chapter 2].

command u16, length u16, session u32, status u32, context 8 bytes, options u32; body
"""

from __future__ import annotations

import struct

HEAD = struct.Struct("<HHII8sI")

COMMAND_MOST = 0x1FF
"""Largest command number; data with a larger number is not a frame."""

NO_ADDRESS, CONNECTED_ADDRESS, UNCONNECTED_DATA, CONNECTED_DATA = 0, 0xA1, 0xB2, 0xB1
"""Types of items."""

_ITEMS_MOST = 4


def items_in(body: bytes) -> list[tuple[int, bytes]]:
    """Return the type and data of each item in a body; [] if the body is damaged."""
    items: list[tuple[int, bytes]] = []
    if len(body) < 8:
        return items
    number, offset = int.from_bytes(body[6:8], "little"), 8
    for _ in range(number if number <= _ITEMS_MOST else 0):
        if len(body) < offset + 4:
            return []
        kind, size = struct.unpack_from("<HH", body, offset)
        offset += 4 + size
        if offset > len(body):
            return []
        items.append((kind, body[offset - size : offset]))
    return items


def body_of(*items: tuple[int, bytes]) -> bytes:
    """Return a body with these items."""
    item_bytes = (struct.pack("<HH", kind, len(data)) + data for kind, data in items)
    return struct.pack("<IHH", 0, 0, len(items)) + b"".join(item_bytes)
