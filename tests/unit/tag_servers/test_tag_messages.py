"""Messages of clients, byte by byte [1756-PM020], against a rack of one scan per packet."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack.runtime.live.actions import Store
from scanrack.runtime.tag_servers.tag_snapshot import BrokenClientError
from served_tags import Client, ServedRack, batch, frame, message, symbol, unconnected, write_rack

READ, WRITE, MODIFY, READ_PART, WRITE_PART = 0x4C, 0x4D, 0x4E, 0x52, 0x53
ONE = struct.pack("<H", 1)


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    with ExitStack() as ports:
        yield Client(ServedRack(write_rack(tmp_path), ports))


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("aBool", "c100 00"),
        ("aSint", "c200 fb"),
        ("anInt", "c300 2efb"),
        ("aDint", "c400 40e20100"),
        ("aLint", "c500 000efad5feffffff"),
        ("aUsint", "c600 c8"),
        ("aUint", "c700 60ea"),
        ("aUdint", "c800 00286bee"),
        ("aUlint", "c900 00e40b5402000000"),
        ("aReal", "ca00 0000c03f"),
        ("aLreal", "cb00 0000000000000240"),
    ],
)
def test_each_type_has_its_code_and_bytes(client: Client, name: str, data: str) -> None:
    assert client.ask(message(READ, symbol(name), ONE)) == (0, bytes.fromhex(data))


def test_a_write_is_read_back_and_is_an_order_with_the_address(client: Client) -> None:
    assert client.ask(message(WRITE, symbol("aDint"), struct.pack("<HHi", 0xC4, 1, -9))) == (0, b"")
    assert client.rack.debugger.tags["aDint"] == -9
    assert client.ask(message(READ, symbol("aDint"), ONE)) == (0, struct.pack("<Hi", 0xC4, -9))
    given = [each.order for each in client.rack.hands.applied]
    assert given == [Store("aDint", 0, "f7ffffff", "", "127.0.0.1:5000")]


ALL_OF_TCP_IP = "01000000 00000000 00000000 0200 20f62401 0100007f" + 20 * "00"
ALL_OF_LINK = "e8030000 0f000000 02005ca99acc"


@pytest.mark.parametrize(
    ("service", "path", "status", "data"),
    [
        (0x01, "20f5 2401", 0, ALL_OF_TCP_IP),  # configured, 127.0.0.1, its link is F6h
        (0x01, "20f6 2401", 0, ALL_OF_LINK),  # 1,000 Mbps, link and full duplex
        (0x0E, "20f5 2401 3005", 0, "0100007f" + 18 * "00"),
        (0x0E, "20f6 2401 3003", 0, "02005ca99acc"),
        (0x0E, "20f5 2400 3002", 0, "0100"),  # of the class: its greatest instance
        (0x0E, "20f5 2401 3007", 0x14, ""),
        (0x0E, "20f6 2402 3001", 5, ""),
        (0x10, "20f5 2401 3003", 8, ""),
    ],
)
def test_the_network_interface_is_read_only(
    client: Client, service: int, path: str, status: int, data: str
) -> None:
    """[ODVA volume 2, 5-4.3 and 5-5.3]"""
    asked = message(service, bytes.fromhex(path), b"\0\0\0\0" if service == 0x10 else b"")
    assert client.ask(asked) == (status, bytes.fromhex(data))


def test_a_batch_is_one_scan_and_reads_what_it_writes(client: Client) -> None:
    write = message(WRITE, symbol("aDint"), struct.pack("<HHi", 0xC4, 1, 5))
    reads = [message(READ, symbol(name), ONE) for name in ("Scan", "C1", "C2", "aDint")]
    status, data = client.ask(batch([write, *reads]))
    offsets = struct.unpack_from("<5H", data, 2)
    scan, first, second, own = (struct.unpack_from("<i", data, at + 6)[0] for at in offsets[1:])
    assert (status, first, second, own) == (0, scan, scan, 5)


def test_a_tag_that_is_not_listed_refuses_and_keeps_its_value(client: Client) -> None:
    for service, data in (
        (WRITE, struct.pack("<HHi", 0xC4, 1, 5)),
        (MODIFY, struct.pack("<HII", 4, 1, 0xFF)),
    ):
        assert client.ask(message(service, symbol("Locked"), data)) == (0x0F, b"")
    part = struct.pack("<HHIi", 0xC4, 1, 0, 5)
    assert client.ask(message(WRITE_PART, symbol("Locked"), part)) == (0x0F, b"")
    assert client.ask(message(WRITE, symbol("Locked", "3"), struct.pack("<HHB", 0xC1, 1, 1))) == (0x0F, b"")
    assert client.rack.debugger.tags["Locked"] == 7


def test_a_list_with_members_opens_these_members_only(client: Client) -> None:
    assert client.ask(message(WRITE, symbol("One", "Id"), struct.pack("<HHh", 0xC3, 1, 5)))[0] == 0x0F
    time = message(WRITE, symbol("One", "Steps", 2, "Time"), struct.pack("<HHi", 0xC4, 1, 5))
    assert client.ask(time) == (0, b"")
    assert client.rack.debugger.tags["One.Steps[2].Time"] == 5


def test_a_mask_sets_and_clears_bits_and_leaves_the_rest(client: Client) -> None:
    client.rack.debugger.tags["anInt"] = 0x0F0F
    assert client.ask(message(MODIFY, symbol("anInt"), struct.pack("<HHH", 2, 0x00F0, 0x00FF))) == (0, b"")
    assert client.rack.debugger.tags["anInt"] == 0x00FF


def test_an_array_comes_in_parts_and_goes_in_parts(client: Client) -> None:
    data, values = b"", struct.pack("<3000i", *range(3000))
    for at in range(0, len(values), 400):
        part = struct.pack("<HHI", 0xC4, 3000, at) + values[at : at + 400]
        assert client.ask(message(WRITE_PART, symbol("Dints"), part)) == (0, b"")
    status = 6
    while status == 6:
        wanted = struct.pack("<HI", 3000, len(data))
        status, part = client.ask(message(READ_PART, symbol("Dints"), wanted))
        data += part[2:]
    assert (status, data) == (0, values)


def test_a_string_stays_within_its_room(client: Client) -> None:
    room = client.ask(message(READ, symbol("Text"), ONE))[1]
    too_long = room[:4] + ONE + struct.pack("<i", 83) + bytes(84)
    assert client.ask(message(WRITE, symbol("Text"), too_long))[0] == 9
    assert client.ask(message(WRITE, symbol("Text", "LEN"), struct.pack("<HHi", 0xC4, 1, -1)))[0] == 9
    assert client.rack.debugger.tags["Text"] == "hello"


def test_no_path_names_a_hidden_member(client: Client) -> None:
    assert client.ask(message(READ, symbol("Hosts", "Host"), ONE))[0] == 4
    assert client.ask(message(WRITE, symbol("Hosts", "Stop"), struct.pack("<HHB", 0xC1, 1, 1))) == (0, b"")
    assert client.rack.debugger.tags["Hosts.Stop"] is True


@pytest.mark.parametrize(
    ("path", "status"),
    [
        (symbol("Nope"), 4),
        (symbol("Dints", 3000), 0xFF),
        (symbol("Grid", 3, 0), 0xFF),
        (symbol("Grid", 0, 0, 0), 5),
        (symbol("aDint", "32"), 4),
        (symbol("aReal", "3"), 4),
        (symbol("aDint", 0), 5),
        (symbol("Program:Nope", "Step"), 4),
        (b"\x91\x09Dint\0\0", 4),
        (b"\x20\x6b\x25\x00\xff\xff", 4),
        (b"\x20\x37\x24\x01", 5),
    ],
)
def test_a_path_to_nothing_gets_its_status(client: Client, path: bytes, status: int) -> None:
    assert client.ask(message(READ, path, ONE))[0] == status


def test_outputs_are_written_by_words_and_inputs_are_not(client: Client) -> None:
    word = message(WRITE, symbol("Local:1:O", "Data", 7), struct.pack("<HHh", 0xC3, 1, 321))
    assert client.ask(word) == (0, b"")
    assert client.rack.run.rack.slots[1].outputs[7] == 321
    word = message(WRITE, symbol("Local:1:I", "Data", 7), struct.pack("<HHh", 0xC3, 1, 321))
    assert client.ask(word)[0] == 0x0F


def test_batches_nest_twice_and_a_route_leads_to_slot_0(client: Client) -> None:
    read = message(READ, symbol("aDint"), ONE)
    deep = batch([batch([batch([read])])])
    status, data = client.ask(deep)
    assert (status, data.count(b"\x8a\0\x08\0")) == (0, 1)
    for slot, wanted in ((0, 0), (3, 1)):
        routed = struct.pack("<BBH", 5, 10, len(read)) + read + bytes((1, 0, 1, slot))
        reply = client.send(
            frame(0x6F, unconnected(message(0x52, b"\x20\x06\x24\x01", routed)), client.handle)
        )
        assert reply[42] == wanted


def test_a_reply_never_exceeds_its_connection(client: Client) -> None:
    reads = [message(READ, symbol("Dints"), struct.pack("<H", 1000)) for _ in range(20)]
    reply = client.send(frame(0x6F, unconnected(batch(reads)), client.handle))
    assert len(reply) <= 24 + 16 + 504
    assert client.ask(batch(reads * 5))[0] == 0x11


@pytest.mark.parametrize("manager", [b"\x20\x06\x24\x01", b"\x21\0\x06\0\x25\0\x01\0"])
def test_a_connection_is_opened_used_and_closed(client: Client, manager: bytes) -> None:
    """EIPScanner, which eip2nats 1.3.2 has, names the connection manager by 16-bit segments."""
    triad = struct.pack("<HHI", 7, 1, 99)
    head = struct.pack("<BBII", 10, 5, 0, 0xABCD) + triad + struct.pack("<BBH", 0, 0, 0)
    opened = (
        head
        + struct.pack("<IHIHB", 2000, 0x43F8 & 0xFFFF, 2000, 0x4000 | 100, 0xA3)
        + b"\x02\x20\x02\x24\x01"
    )
    status, data = client.ask(message(0x54, manager, opened))
    assert (status, data[4:8]) == (0, struct.pack("<I", 0xABCD))
    read = message(READ, symbol("Dints"), struct.pack("<H", 1000))
    items = (
        struct.pack("<IHHHH", 0, 0, 2, 0xA1, 4)
        + data[:4]
        + struct.pack("<HHH", 0xB1, 2 + len(read), 1)
        + read
    )
    reply = client.send(frame(0x70, items, client.handle))
    assert reply[48] == 6
    assert 90 <= len(reply) - 44 <= 100
    assert client.ask(message(0x54, manager, opened))[0] == 1  # it is open
    assert client.ask(message(0x4E, manager, b"\5\5" + triad + b"\0\0"))[0] == 0
    assert client.send(frame(0x70, items, client.handle)) == b""


def test_a_session_is_its_clients_own(client: Client) -> None:
    read = unconnected(message(READ, symbol("aDint"), ONE))
    assert client.send(frame(0x6F, read, client.handle + 1))[8:12] == b"\x64\0\0\0"
    assert client.send(frame(0x65, b"\1\0\0\0"))[8:12] == b"\1\0\0\0"
    with pytest.raises(BrokenClientError):
        client.send(frame(0x66, b"", client.handle))


def test_a_frame_that_is_too_long_ends_its_connection(client: Client) -> None:
    with pytest.raises(BrokenClientError, match="no frame"):
        client.session.receive(frame(0x6F, length=4_601))
