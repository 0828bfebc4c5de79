"""Data files of an SLC program over PCCC [1770-RM516, chapter 7]."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from served_tags import Client, ServedRack, message, write_rack

REQUESTOR = bytes.fromhex("07 4d00 78563412")
READ, WRITE, MASKED = 0xA2, 0xAA, 0xAB


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    with ExitStack() as ports:
        yield Client(ServedRack(write_rack(tmp_path, files=True), ports))


def execute(client: Client, function: int, size: int, *address: int, data: bytes = b"") -> tuple[int, bytes]:
    """Execute a command; return STS and data."""
    command = struct.pack("<BBHBB", 0x0F, 0, 9, function, size) + bytes(address) + data
    status, reply = client.ask(message(0x4B, b"\x20\x67\x24\x01", REQUESTOR + command))
    assert (status, reply[: len(REQUESTOR)], reply[7:8], reply[9:11]) == (0, REQUESTOR, b"\x4f", b"\x09\0")
    return reply[8], reply[11:]


@pytest.mark.parametrize(
    ("address", "size", "data"),
    [
        ((7, 0x89, 3, 0), 4, "fcff 0500"),
        ((3, 0x85, 1, 0), 2, "0500"),
        ((4, 0x86, 1, 1), 4, "1400 0300"),
        ((5, 0x87, 0, 0), 6, "0080 0a00 0300"),
        ((6, 0x88, 0, 0), 6, "0000 0400 0100"),
        ((8, 0x8A, 1, 0), 4, "000010c0"),
        ((9, 0x8D, 0, 0), 6, "0300 6261 0063"),
        ((10, 0x91, 1, 0), 4, "f9ffffff"),
        ((0, 0x82, 1, 0), 2, "0000"),
        ((1, 0x8C, 1, 0), 2, "0064"),
    ],
    ids=["N", "B", "T", "C", "R", "F", "ST", "L", "O", "I"],
)
def test_each_kind_of_file_has_its_bytes(
    client: Client, address: tuple[int, ...], size: int, data: str
) -> None:
    assert execute(client, READ, size, *address) == (0, bytes.fromhex(data))


def test_writes_go_to_elements_parts_and_bits(client: Client) -> None:
    tags = client.rack.debugger.tags
    assert execute(client, WRITE, 4, 7, 0x89, 10, 0, data=b"\1\0\2\0") == (0, b"")
    assert execute(client, WRITE, 2, 4, 0x86, 0, 1, data=b"\x09\3") == (0, b"")
    assert execute(client, MASKED, 2, 3, 0x85, 1, 0, data=b"\x10\0\xff\xff") == (0, b"")
    assert execute(client, WRITE, 6, 9, 0x8D, 1, 0, data=b"\3\0zy\0x") == (0, b"")
    assert (tags["N7:10"], tags["N7:11"], tags["T4:0.PRE"], tags["B3:1"]) == (1, 2, 777, 0x15)
    assert tags["ST9:1"] == "yzx"


@pytest.mark.parametrize(
    ("function", "size", "address", "data"),
    [
        (WRITE, 6, (4, 0x86, 0, 1), b"\x09\3"),
        (WRITE, 2, (7, 0x89, 0, 0), b"\1\0\2\0"),
        (WRITE, 2, (7, 0x89, 16, 0), b"\1\0"),
        (WRITE, 2, (9, 0x8D, 0, 0), b"\x53\0"),
        (READ, 2, (7, 0x89, 16, 0), b""),
        (READ, 2, (7, 0x8A, 0, 0), b""),
        (READ, 2, (200, 0x89, 0, 0), b""),
        (READ, 237, (7, 0x89, 0, 0), b""),
        (READ, 2, (4, 0x86, 0, 3), b""),
        (0x77, 2, (7, 0x89, 0, 0), b""),
        (READ, 2, (7,), b""),
    ],
)
def test_what_does_not_fit_is_refused_and_changes_nothing(
    client: Client, function: int, size: int, address: tuple[int, ...], data: bytes
) -> None:
    memory = client.rack.debugger.engine.memory
    before = {path: value for path, value in memory.snapshot().items() if not path.startswith(("S", "T4"))}
    status, _ = execute(client, function, size, *address, data=data)
    assert status in (0x10, 0xF0)
    assert {path: value for path, value in memory.snapshot().items() if path in before} == before
    assert client.rack.debugger.tags["T4:0.PRE"] == 500


@pytest.mark.parametrize(
    ("address", "data", "path", "value"),
    [
        ((6, 0x88, 0, 1), b"\5\0", "R6:0.LEN", 5),
        ((6, 0x88, 0, 2), b"\3\0", "R6:0.POS", 3),
        ((5, 0x87, 0, 2), b"\4\0", "C5:0.ACC", 4),
        ((2, 0x84, 7, 0), b"\3\0", "S:7", 3),
    ],
)
def test_words_of_controls_counters_and_the_status_are_written(
    client: Client, address: tuple[int, ...], data: bytes, path: str, value: int
) -> None:
    assert execute(client, WRITE, 2, *address, data=data) == (0, b"")
    assert client.rack.debugger.tags[path] == value


@pytest.mark.parametrize("function", [WRITE, MASKED])
def test_an_input_image_refuses_as_without_privilege(client: Client, function: int) -> None:
    """EXT STS 0Bh: access denied [1770-6.5.16, chapter 8, EXT STS codes of command 0Fh]."""
    data = b"\xff\xff\3\0"[-4 if function == MASKED else -2 :]
    assert execute(client, function, 2, 1, 0x8C, 1, 0, data=data) == (0xF0, b"\x0b")
    assert execute(client, READ, 2, 1, 0x8C, 1, 0) == (0, b"\0\x64")
    assert execute(client, function, 2, 0, 0x8B, 1, 0, data=data) == (0, b"")


def test_a_field_goes_on_in_the_next_element_of_a_file_of_timers(client: Client) -> None:
    """From the preset of the first timer: two words of it, then the three words of the second."""
    first, second = (execute(client, READ, size, 4, 0x86, *at)[1] for size, at in ((4, (0, 1)), (6, (1, 0))))
    assert second[2:] == bytes.fromhex("1400 0300")
    assert execute(client, READ, 10, 4, 0x86, 0, 1) == (0, first + second)


@pytest.mark.parametrize(("command", "function"), [(0x06, 0x00), (0x0F, 0x03)])
def test_only_function_3_of_command_6_is_the_status_of_the_processor(
    client: Client, command: int, function: int
) -> None:
    asked = message(0x4B, b"\x20\x67\x24\x01", REQUESTOR + struct.pack("<BBHB", command, 0, 9, function))
    _, reply = client.ask(asked)
    assert reply[len(REQUESTOR) :] == bytes((command | 0x40, 0x10, 9, 0))  # 10h: illegal command
