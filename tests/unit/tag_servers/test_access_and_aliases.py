"""External Access of an exported controller, and its aliases, as clients meet them.

[1756-PM004, External Access: Read/Write, Read Only, None; an alias has that of its base tag]. Broken on
purpose: an alias that is writable under its own name, tags without access listed: a test turns red.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from aliased_tags import write_aliases
from served_tags import Client, ServedRack, batch, message, symbol

READ, WRITE = 0x4C, 0x4D
ONE = struct.pack("<H", 1)
BAD_PATH, NO_PRIVILEGE = 0x04, 0x0F


@pytest.fixture(params=["generic", "3601"])
def client(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Client]:
    with ExitStack() as ports:
        yield Client(ServedRack(write_aliases(tmp_path, request.param), ports))


def read(client: Client, name: str) -> tuple[int, bytes]:
    return client.ask(message(READ, symbol(name), ONE))


def write(client: Client, name: str, value: int) -> int:
    return client.ask(message(WRITE, symbol(name), struct.pack("<HHi", 0xC4, 1, value)))[0]


def test_what_has_no_access_is_not_there(client: Client) -> None:
    names = [row[1] for row in client.rack.setup.database.rows("")]
    assert {"Open", "Seen"} <= set(names)
    assert not {"Hid", "Secret", "Round", "Trip"} & set(names)
    for name in ("Hid", "Secret", "Round"):
        assert read(client, name)[0] == BAD_PATH
        assert write(client, name, 1) == BAD_PATH


def test_read_only_narrows_what_the_rack_lists(client: Client) -> None:
    assert write(client, "Open", 5) == 0
    for name in ("Seen", "Shown"):
        assert read(client, name) == (0, struct.pack("<Hi", 0xC4, 0))
        assert write(client, name, 5) == NO_PRIVILEGE
    access = {row[1]: row[5] for row in client.rack.setup.database.rows("")}
    assert (access["Open"], access["Seen"], access["Shown"], access["Own"]) == (0, 2, 2, 0)


def test_an_alias_is_what_it_names(client: Client) -> None:
    seven = struct.pack("<Hi", 0xC4, 7)
    read(client, "Row")  # a scan, which moves 7 to Row[2]
    for name in ("Third", "Again"):
        assert read(client, name) == (0, seven)
    assert read(client, "Bit") == (0, struct.pack("<HB", 0xC1, 0))  # 7 has no bit 5
    assert write(client, "Own", 9) == 0
    assert client.rack.debugger.tags["Open"] == 9
    status, data = client.ask(message(READ, symbol("Whole"), struct.pack("<H", 4)))
    assert (status, data) == (0, struct.pack("<H4i", 0xC4, 0, 0, 7, 0))


def test_a_bit_of_an_image_has_the_name_of_its_alias(client: Client) -> None:
    """Bit 3 of status MSW is STOPPED: off before the module is configured."""
    assert read(client, "Stopped") == (0, struct.pack("<HB", 0xC1, 0))
    assert client.ask(message(WRITE, symbol("Stopped"), struct.pack("<HHB", 0xC1, 1, 1)))[0] != 0


def test_rows_of_a_listing_have_the_type_of_what_is_named(client: Client) -> None:
    rows = {row[1]: row for row in client.rack.setup.database.rows("")}
    assert [rows[name][2] for name in ("Third", "Bit", "Whole")] == [0xC4, 0xC1, 0xC4 | 1 << 13]
    assert rows["Whole"][4] == (4,)
    numbers = [row[0] for row in client.rack.setup.database.rows("")]
    assert numbers == list(range(1, len(numbers) + 1))


def test_a_program_has_aliases_of_its_own(client: Client) -> None:
    assert [row[1] for row in client.rack.setup.database.rows("MAIN")] == ["Mine"]
    assert write(client, "Program:Main.Mine", 3) == 0
    assert client.rack.debugger.tags["Row"][1] == 3


def test_several_names_of_one_tag_in_a_batch_are_one_value(client: Client) -> None:
    writes = message(WRITE, symbol("Own"), struct.pack("<HHi", 0xC4, 1, 11))
    status, data = client.ask(batch([writes, message(READ, symbol("Open"), ONE)]))
    assert (status, data[-4:]) == (0, struct.pack("<i", 11))
