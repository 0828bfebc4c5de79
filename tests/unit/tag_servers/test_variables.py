"""Tags as objects and variables: what a browser shows, and the bytes of values."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from scanrack.io_images.enip.listing import DINT, ListedTag, Listing, Part, StructuredKind, part_at
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.variables import (
    VARIABLES_MOST,
    Leaf,
    TagGroup,
    TagTree,
    Variable,
    variables_of,
)
from served_tags import ServedRack, write_rack


def listed(count: int) -> ListedTag:
    """Return an array of structures with one member."""
    return ListedTag("Many", "", StructuredKind("One", 4, (Part("Time", DINT, (), 0),)), (count,))


@pytest.fixture(scope="module")
def variables(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Variable]:
    def walk(items: Iterator[Leaf | TagGroup]) -> Iterator[Variable]:
        for item in items:
            if isinstance(item, TagGroup):
                yield from walk(item.items())
            else:
                yield item.variable

    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path_factory.mktemp("rack")), ports)
        tree = TagTree(Database(rack.desk.listing, rack.setup.writable))
        return {each.path: each for each in walk(tree.roots())}


def test_members_and_elements_have_paths(variables: dict[str, Variable]) -> None:
    assert {
        "aBool",
        "Fill.PRE",
        "Fill.DN",
        "Many[3].Steps[2].Valve",
        "Program:Main.Step.Speed",
        "Local:1:I.Data",
        "Hosts.Level",
        "Texts",
    } <= set(variables)
    assert not any("ZZZ" in path or path.endswith((".CTL", ".Host", ".LEN")) for path in variables)
    assert not TagTree(Database(Listing((listed(VARIABLES_MOST),)))).is_long
    assert TagTree(Database(Listing((listed(VARIABLES_MOST + 1),)))).is_long
    assert {path for path in ("Locked", "Scan", "One.Id", "One.Name") if variables[path].writable} == {
        "One.Name"
    }


def test_the_bytes_of_a_value_have_its_name(tmp_path: Path) -> None:
    """Orders of clients say which part of a tag they write; a browser's names are the oracle."""
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path), ports)
        known = list(variables_of(TagTree(Database(rack.desk.listing)).roots()))
        elements = chain.from_iterable(each.elements() for each in known if each.dims and each.count <= 64)
        for each in [*known, *(leaf.variable for leaf in elements)]:
            tag = rack.desk.listing.tags[each.tag]
            name = tag.full_name.replace("\\", "Program:")
            keep = b"" if each.bit is None else bytes([0xFF ^ 1 << each.bit])
            size = each.size if each.bit is None else 1
            assert name + part_at(tag, each.offset, size, keep) == each.path
            if "INT" in each.type_name and not each.dims:
                assert part_at(tag, each.offset, 1, b"\xf7").endswith(".3")
        tags = {each.name: each for each in rack.desk.listing.tags}
    some = [
        ("Dints", 8, 8),
        ("One", 0, 8),
        ("Many", 144, 8),
        ("Many", 156, 24),
        ("Flags", 0, 4),
        ("Text", 0, 88),
    ]
    assert [part_at(tags[name], offset, size) for name, offset, size in some] == [
        "",
        "",
        "[1]",
        "[1].Steps",
        "",
        "",
    ]


@pytest.mark.parametrize(
    ("name", "offset", "keep", "part"),
    [
        ("N7", 6, "", ":3"),
        ("N7", 6, "fffe", ":3/8"),
        ("N7", 6, "7fff", ":3/7"),
        ("T4", 10, "", ":1.PRE"),
        ("O:1", 4, "", ".2"),
        ("O:1", 4, "fbff", ".2/2"),
    ],
)
def test_parts_of_data_files_are_addresses(
    tmp_path: Path, name: str, offset: int, keep: str, part: str
) -> None:
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path, files=True), ports)
        (tag,) = (each for each in rack.desk.listing.tags if each.name == name)
    assert part_at(tag, offset, 2, bytes.fromhex(keep), files=True) == part


@pytest.mark.parametrize(
    ("path", "value", "data"),
    [
        ("aDint", -2, b"\xfe\xff\xff\xff"),
        ("aReal", 1.5, b"\0\0\xc0?"),
        ("aBool", True, b"\1"),
        ("Hosts.Level", [[1, 2, 3], [4, 5, 6]], b"".join(bytes((at, 0, 0, 0)) for at in range(1, 7))),
        ("Flags", [at in (0, 33) for at in range(64)], b"\1\0\0\0\2\0\0\0"),
        ("Text", "ab", b"\2\0\0\0ab" + bytes(82)),
    ],
)
def test_values_are_bytes_and_back(
    variables: dict[str, Variable], path: str, value: Any, data: bytes
) -> None:
    made = variables[path].change_to(value)
    assert (made.data, made.keep) == (data, b"")
    assert variables[path].value_in(data) == value


def test_a_packed_bit_keeps_its_neighbors(variables: dict[str, Variable]) -> None:
    stop = variables["Hosts.Stop"]
    assert (stop.change_to(True).data, stop.change_to(False).data) == (b"\2", b"\0")
    assert stop.change_to(True).keep == b"\xfd"
    assert [stop.value_in(bytes((byte,))) for byte in (0b10, 0b101)] == [True, False]


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ("Grid", [[1, 2, 3, 4]] * 2, "the array has 3 x 4 elements"),
        ("aDint", 2**31, "aDint is DINT"),
        ("Text", "x" * 83, "the text has 83 characters; 82 fit"),
        ("Text", "\u20ac", "latin-1"),
    ],
)
def test_what_does_not_fit_is_refused(
    variables: dict[str, Variable], path: str, value: Any, told: str
) -> None:
    with pytest.raises(ValueError, match=told):
        variables[path].change_to(value)
    assert variables["Text"].value_in(b"\xff\xff\xff\x7f" + b"x" * 84) == "x" * 82  # LEN exceeds DATA
