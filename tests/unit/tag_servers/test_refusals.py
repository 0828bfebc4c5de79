"""What is refused has the status of the manual's tables, and leaves every byte of the tags as it was.

General statuses: [ODVA volume 1, appendix B]; extended ones of tags: [1756-PM020]: 2104h an offset behind the
end, 2105h elements behind it, 2107h another type; of a route: 0312h no such link address.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from scanrack.io_images.enip.codes import LISTING, CipRefusedError
from scanrack.io_images.enip.listing import PLAIN, Part, StructuredKind
from scanrack.io_images.enip.paths import Path as PathParts
from scanrack.runtime.tag_servers.database import Writable
from scanrack.runtime.tag_servers.objects import Lister, attributes_in
from scanrack.runtime.tag_servers.router import refused
from served_tags import Client, ServedRack, batch, frame, message, symbol, unconnected, write_rack

READ, WRITE, MODIFY, READ_PART, WRITE_PART = 0x4C, 0x4D, 0x4E, 0x52, 0x53
COUNTED = {"Scan", "C1", "C2"}
"""Tags that the program itself writes in every scan."""

PATH_WRONG, UNKNOWN, PRIVILEGE = 0x04, 0x05, 0x0F
TOO_SHORT, TOO_MUCH, GENERAL = 0x13, 0x15, 0xFF
OFFSET_BEYOND, BEYOND, OTHER_TYPE = 0x2104, 0x2105, 0x2107


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    with ExitStack() as ports:
        yield Client(ServedRack(write_rack(tmp_path_factory.mktemp("rack")), ports))


def memory(client: Client) -> dict[str, bytes]:
    """Return the bytes of every tag that the program leaves alone, and of the module's outputs."""
    images = client.rack.debugger.images
    tags = {
        tag.full_name: images.read(number, 0, tag.size)
        for number, tag in enumerate(images.listing.tags)
        if tag.name not in COUNTED
    }
    return tags | {"outputs": bytes(client.rack.run.rack.slots[1].outputs.raw)}


def status_of(client: Client, request: bytes) -> tuple[int, ...]:
    """Send a request without a connection; return the general status and the extended ones."""
    reply = client.send(frame(0x6F, unconnected(request), client.handle))[40:]
    return reply[2], *struct.unpack_from(f"<{reply[3]}H", reply, 4)


def write(path: bytes, kind: int, count: int, data: bytes) -> bytes:
    """Return a Write Tag."""
    return message(WRITE, path, struct.pack("<HH", kind, count) + data)


def write_part(path: bytes, kind: int, count: int, skip: int, data: bytes) -> bytes:
    """Return a Write Tag Fragmented."""
    return message(WRITE_PART, path, struct.pack("<HHI", kind, count, skip) + data)


def read(path: bytes, count: int) -> bytes:
    """Return a Read Tag."""
    return message(READ, path, struct.pack("<H", count))


def routed(request: bytes, slot: int) -> bytes:
    """Return an Unconnected Send of a request to a slot of the backplane, which is port 1."""
    head = struct.pack("<BBH", 5, 10, len(request))
    return message(
        0x52, b"\x20\x06\x24\x01", head + request + b"\0" * (len(request) % 2) + bytes((1, 0, 1, slot))
    )


DINT, INT, BOOL, REAL = 0xC4, 0xC3, 0xC1, 0xCA
ONES = b"\xff" * 8
A_DINT, DINTS, GRID = symbol("aDint"), symbol("Dints"), symbol("Grid")
WRONG: dict[str, tuple[Any, ...]] = {
    "a DINT's first byte": (write(A_DINT, DINT, 1, ONES[:1]), TOO_SHORT),
    "half a DINT": (write(A_DINT, DINT, 1, ONES[:2]), TOO_SHORT),
    "a DINT but one byte": (write(A_DINT, DINT, 1, ONES[:3]), TOO_SHORT),
    "no value": (write(A_DINT, DINT, 1, b""), TOO_SHORT),
    "no bit": (write(symbol("aDint", "3"), BOOL, 1, b""), TOO_SHORT),
    "one element of two": (write(DINTS, DINT, 2, ONES[:4]), TOO_SHORT),
    "no count": (message(WRITE, A_DINT, struct.pack("<H", DINT)), TOO_SHORT),
    "an INT to a DINT": (write(A_DINT, INT, 1, ONES[:4]), GENERAL, OTHER_TYPE),
    "a REAL to a DINT": (write(A_DINT, REAL, 1, ONES[:4]), GENERAL, OTHER_TYPE),
    "a DINT to a bit": (write(symbol("aDint", "3"), DINT, 1, ONES[:4]), GENERAL, OTHER_TYPE),
    "another structure": (write(symbol("Many", 0), 0x2A0, 1, ONES), GENERAL, OTHER_TYPE),
    "no elements": (write(DINTS, DINT, 0, ONES), GENERAL, BEYOND),
    "two of a single one": (write(A_DINT, DINT, 2, ONES), GENERAL, BEYOND),
    "one behind the last": (write(symbol("Dints", 3000), DINT, 1, ONES[:4]), GENERAL, BEYOND),
    "the last and one more": (write(symbol("Dints", 2999), DINT, 2, ONES), GENERAL, BEYOND),
    "a row too many": (write(symbol("Grid", 3, 0), INT, 1, ONES[:2]), GENERAL, BEYOND),
    "a column too many": (write(symbol("Grid", 0, 4), INT, 1, ONES[:2]), GENERAL, BEYOND),
    "a part behind the end": (write_part(A_DINT, DINT, 1, 4, ONES[:1]), GENERAL, OFFSET_BEYOND),
    "a part over the end": (write_part(A_DINT, DINT, 1, 2, ONES[:3]), TOO_MUCH),
    "an empty part": (write_part(A_DINT, DINT, 1, 0, b""), TOO_SHORT),
    "a part without offset": (write(A_DINT, DINT, 1, b"").replace(b"\x4d", b"\x53", 1), TOO_SHORT),
    "a part of another type": (write_part(A_DINT, INT, 1, 0, ONES[:2]), GENERAL, OTHER_TYPE),
    "a part of too many": (write_part(A_DINT, DINT, 2, 0, ONES), GENERAL, BEYOND),
    "a mask for a REAL": (message(MODIFY, symbol("aReal"), struct.pack("<H", 4) + ONES), GENERAL, OTHER_TYPE),
    "a mask for a bit": (
        message(MODIFY, symbol("aDint", "3"), struct.pack("<H", 1) + ONES[:2]),
        GENERAL,
        OTHER_TYPE,
    ),
    "a mask for a structure": (
        message(MODIFY, symbol("Many", 0), struct.pack("<H", 4) + ONES),
        GENERAL,
        OTHER_TYPE,
    ),
    "a mask behind the last": (
        message(MODIFY, symbol("Dints", 3000), struct.pack("<H", 4) + ONES),
        GENERAL,
        BEYOND,
    ),
    "a bit behind the last": (write(symbol("Dints", 3000, "3"), BOOL, 1, b"\1"), GENERAL, BEYOND),
    "a member behind the last": (write(symbol("Many", 4, "Id"), INT, 1, ONES[:2]), GENERAL, BEYOND),
    "what is not listed": (write(symbol("Locked"), DINT, 1, ONES[:4]), PRIVILEGE),
    "a bit of it": (write(symbol("Locked", "3"), BOOL, 1, b"\1"), PRIVILEGE),
    "a part of it": (write_part(symbol("Locked"), DINT, 1, 0, ONES[:4]), PRIVILEGE),
    "a mask for it": (message(MODIFY, symbol("Locked"), struct.pack("<H", 4) + ONES), PRIVILEGE),
    "an input": (write(symbol("Local:1:I", "Data", 7), INT, 1, ONES[:2]), PRIVILEGE),
    "no such tag": (write(symbol("Nope"), DINT, 1, ONES[:4]), PATH_WRONG),
    "no such member": (write(symbol("Many", 0, "Nope"), DINT, 1, ONES[:4]), PATH_WRONG),
    "no such bit": (write(symbol("aDint", "32"), BOOL, 1, b"\1"), PATH_WRONG),
    "a member of an array": (write(symbol("Many", "Id"), INT, 1, ONES[:2]), PATH_WRONG),
    "an element of a single one": (write(symbol("aDint", 0), DINT, 1, ONES[:4]), UNKNOWN),
    "one subscript too many": (write(symbol("Grid", 0, 0, 0), INT, 1, ONES[:2]), UNKNOWN),
    "a write to no object": (write(b"\x20\x37\x24\x01", DINT, 1, ONES[:4]), UNKNOWN),
    "another slot": (routed(write(A_DINT, DINT, 1, ONES[:4]), 3), 0x01, 0x0312),
    "a read of nothing": (read(A_DINT, 0), GENERAL, BEYOND),
    "a read of too many": (read(DINTS, 3001), GENERAL, BEYOND),
    "a read behind the end": (read(symbol("Grid", 3, 0), 1), GENERAL, BEYOND),
    "a read from behind the end": (
        message(READ_PART, A_DINT, struct.pack("<HI", 1, 4)),
        GENERAL,
        OFFSET_BEYOND,
    ),
    "a read without count": (message(READ, A_DINT), TOO_SHORT),
}
"""A refused request by what is wrong with it, and its statuses."""


MALFORMED = {
    "a mask of three bytes": message(MODIFY, A_DINT, struct.pack("<H", 3) + ONES[:6]),
    "half a mask": message(MODIFY, A_DINT, struct.pack("<H", 4) + ONES[:7]),
    "a mask for two DINTs": message(MODIFY, A_DINT, struct.pack("<H", 8) + ONES * 2),
    "a batch without messages": batch([]),
}
"""Requests that the tables have no one status for."""


@pytest.mark.parametrize("what", WRONG)
def test_a_refusal_has_its_statuses_and_changes_nothing(client: Client, what: str) -> None:
    request, *wanted = WRONG[what]
    before, given = memory(client), len(client.rack.hands.applied)
    assert status_of(client, request) == tuple(wanted)
    assert memory(client) == before
    assert len(client.rack.hands.applied) == given, "an order was given"


@pytest.mark.parametrize("what", MALFORMED)
def test_what_is_malformed_is_refused_and_changes_nothing(client: Client, what: str) -> None:
    before, given = memory(client), len(client.rack.hands.applied)
    assert status_of(client, MALFORMED[what])[0] != 0
    assert memory(client) == before
    assert len(client.rack.hands.applied) == given, "an order was given"


def test_what_is_compared_is_what_writes_change(client: Client) -> None:
    before = memory(client)
    assert status_of(client, write(A_DINT, DINT, 1, struct.pack("<i", -2))) == (0,)
    assert {name for name, data in memory(client).items() if data != before[name]} == {"aDint"}


def test_a_refusal_in_a_batch_keeps_its_extended_status_and_stops_no_other(client: Client) -> None:
    good = write(A_DINT, DINT, 1, struct.pack("<i", 77))
    half = write(A_DINT, DINT, 1, ONES[:2])
    beyond = write(symbol("Dints", 3000), DINT, 1, ONES[:4])
    before = memory(client)
    reply = client.send(frame(0x6F, unconnected(batch([good, half, beyond])), client.handle))[44:]
    starts = struct.unpack_from("<3H", reply, 2)
    assert [reply[at : at + 4 + 2 * reply[at + 3]] for at in starts] == [
        b"\xcd\0\0\0",
        b"\xcd\0\x13\0",
        b"\xcd\0\xff\1\x05\x21",
    ]
    assert memory(client) == before | {"aDint": struct.pack("<i", 77)}


@pytest.mark.parametrize(("most", "data"), [(6, "cd00ff010521"), (5, "cd00ff00")])
def test_an_extended_status_is_left_out_only_where_it_has_no_room(most: int, data: str) -> None:
    """Four bytes of head, and two of the word."""
    assert refused(WRITE, CipRefusedError(GENERAL, BEYOND), most).hex() == data


def test_a_list_names_32_attributes_at_most() -> None:
    assert attributes_in(struct.pack("<33H", 32, *range(32))) == tuple(range(32))
    with pytest.raises(CipRefusedError):
        attributes_in(struct.pack("<34H", 33, *range(33)))


def test_a_listing_has_what_fits_behind_the_head_of_its_reply(client: Client) -> None:
    """A line is here the number of a tag and its name behind a length [1756-PM020]; a head has four bytes."""
    database = client.rack.setup.database
    lines = [struct.pack("<IH", row[0], len(row[1])) + row[1].encode() for row in database.rows("")]
    for count in (1, 2, 5):
        whole = b"".join(lines[:count])
        for room in (4 + len(whole), 3 + len(b"".join(lines[: count + 1]))):
            asked = struct.pack("<HH", 1, 1)
            assert Lister(database).answer(LISTING, PathParts(), asked, room) == (0x06, whole)


def test_a_structure_is_open_to_writes_in_part_where_one_of_its_members_is() -> None:
    parts = [
        Part(name, PLAIN["DINT"], (), at, hidden=name == "Host") for at, name in ((0, "Host"), (4, "PRE"))
    ]
    wait = StructuredKind("Wait", 8, tuple(parts))
    assert [Writable([each]).any_of("Wait", wait) for each in ("Wait.PRE", "Wait.Host")] == [True, False]
