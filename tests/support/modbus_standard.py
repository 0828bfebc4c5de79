"""Modbus V1.1b3, chapter 6, as plain layouts: what a request says, and which bytes answer it.

The oracle of the tests: it knows nothing of pymodbus and nothing of the product.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, BUSY = 1, 2, 3, 6


@dataclass(frozen=True)
class Layout:
    """A row of the chapter: the request's fields behind the function, and the range of each count.

    Attributes:
        fields: letters of `struct`; a byte count is the last one.
        counts: places of counts among the fields, each with its most.
        bits: the data are bits; else registers.
    """

    section: str
    fields: str
    counts: tuple[tuple[int, int], ...] = ()
    data: bool = False
    bits: bool = False


REQUESTS: dict[int, Layout] = {
    0x01: Layout("6.1", "HH", ((1, 2000),), bits=True),
    0x02: Layout("6.2", "HH", ((1, 2000),), bits=True),
    0x03: Layout("6.3", "HH", ((1, 125),)),
    0x04: Layout("6.4", "HH", ((1, 125),)),
    0x05: Layout("6.5", "HH"),  # the value is 0000h or FF00h
    0x06: Layout("6.6", "HH"),
    0x0F: Layout("6.11", "HHB", ((1, 1968),), data=True, bits=True),
    0x10: Layout("6.12", "HHB", ((1, 123),), data=True),
    0x11: Layout("6.13", ""),
    0x16: Layout("6.16", "HHH"),
    0x17: Layout("6.17", "HHHHB", ((1, 125), (3, 121)), data=True),
}

Said = tuple[int, ...]


def said(pdu: bytes) -> tuple[Said, Said] | None:
    """Return fields and data of a request; None if it is 03h, whatever the addresses."""
    row = REQUESTS[pdu[0]]
    head = Struct(">" + row.fields)
    if len(pdu) < 1 + head.size:
        return None
    fields: Said = head.unpack_from(pdu, 1)
    rest = pdu[1 + head.size :]
    if any(not 1 <= fields[place] <= most for place, most in row.counts):
        return None
    if pdu[0] == 0x05 and fields[1] not in (0, 0xFF00):
        return None
    if not row.data:
        return None if rest else (fields, ())
    count, size = fields[-2], fields[-1]
    if size != (-(-count // 8) if row.bits else 2 * count) or len(rest) != size:
        return None
    if row.bits:
        return fields, tuple(rest[at // 8] >> at % 8 & 1 for at in range(count))
    return fields, Struct(f">{count}H").unpack(rest)


def request(function: int, *fields: int, data: Said = ()) -> bytes:
    """Return the PDU of a request; byte count and data of a write follow its fields."""
    row = REQUESTS[function]
    if not row.data:
        return bytes((function,)) + Struct(">" + row.fields).pack(*fields)
    packed = packed_bits(data) if row.bits else Struct(f">{len(data)}H").pack(*data)
    return bytes((function,)) + Struct(">" + row.fields).pack(*fields, len(data), len(packed)) + packed


def packed_bits(bits: Said) -> bytes:
    """Return bits as bytes, the first one lowest."""
    return bytes(
        sum(bit << place for place, bit in enumerate(bits[at : at + 8])) for at in range(0, len(bits), 8)
    )


def words_reply(function: int, words: Said) -> bytes:
    """Return the reply with registers."""
    return bytes((function, 2 * len(words))) + Struct(f">{len(words)}H").pack(*words)


def bits_reply(function: int, bits: Said) -> bytes:
    """Return the reply with bits."""
    packed = packed_bits(bits)
    return bytes((function, len(packed))) + packed


def write_reply(pdu: bytes) -> bytes:
    """Return the reply to a write: 05, 06 and 16h repeat it, 0Fh and 10h its address and count."""
    return pdu[:5] if pdu[0] in (0x0F, 0x10) else pdu


def exception(pdu: bytes, code: int) -> bytes:
    """Return an exception."""
    return bytes((pdu[0] | 0x80, code))


def judged(asked: bytes, answer: bytes) -> str:
    """Return what an answer is to a valid request: `good`, `refused`, or `bad`."""
    if len(answer) == 2 and answer[0] == asked[0] | 0x80:
        return "refused"
    found = said(asked)
    assert found is not None
    fields, _ = found
    if asked[0] in (0x01, 0x02):
        size = -(-fields[1] // 8)
    elif asked[0] in (0x03, 0x04, 0x17):
        size = 2 * fields[1]
    else:
        return "good" if answer == write_reply(asked) else "bad"
    return "good" if len(answer) == 2 + size and answer[:2] == bytes((asked[0], size)) else "bad"


def crc(data: bytes) -> bytes:
    """Return the CRC, low byte first [Modbus over serial line V1.02, 6.2.2]."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value.to_bytes(2, "little")


def rtu(unit: int, pdu: bytes) -> bytes:
    """Return the frame of a unit and a PDU."""
    body = bytes((unit,)) + pdu
    return body + crc(body)
