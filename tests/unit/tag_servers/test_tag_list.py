"""The list of tags: servers resolve each name of it. Names in a rack file without a tag are refused."""

from __future__ import annotations

import csv
import json
import tomllib
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from aliased_tags import write_aliases
from scanrack.io_images.enip.paths import steps_of
from scanrack.jobs.run.servers.tag_formats import FORMATS
from scanrack.runtime.config.server_table import ModbusTable
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.nearest import unknown_patterns
from scanrack.runtime.tag_servers.register_map import RegisterMap
from scanrack.runtime.tag_servers.tag_list import TagRow, first_map, tag_rows
from scanrack.runtime.tag_servers.tag_paths import target_of
from scanrack.runtime.tag_servers.variables import ELEMENTS_MOST
from served_tags import ServedRack, write_rack


def database_of(rack: Path) -> Database:
    with ExitStack() as ports:
        served = ServedRack(rack, ports)
        return Database(served.desk.listing, served.setup.writable)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Database:
    return database_of(write_rack(tmp_path_factory.mktemp("bench")))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Database:
    return database_of(write_rack(tmp_path_factory.mktemp("files"), files=True))


def listed(database: Database, table: ModbusTable | None = None) -> dict[str, TagRow]:
    return {each.name: each for each in tag_rows(database, table)}


@pytest.mark.parametrize("which", ["bench", "files"])
def test_every_address_means_the_value_of_its_row(which: str, request: pytest.FixtureRequest) -> None:
    database: Database = request.getfixturevalue(which)
    for row in listed(database).values():
        for each in row.elements() if row.in_files and ":" in row.name and row.dims else [row]:
            found, wanted = target_of(database, each.enip), database.resolve(steps_of(each.name))
            assert (found.symbol, found.offset, found.bit) == (wanted.symbol, wanted.offset, wanted.bit), each
            assert row.type_name in (found.kind.name, "STRING") or row.type == f"BOOL[{32 * found.count}]", (
                each
            )


def test_a_row_has_type_access_description_and_addresses(bench: Database, files: Database) -> None:
    rows = listed(bench)
    assert (rows["Grid"].type, rows["Grid"].access) == ("INT[3,4]", "read/write")
    assert (rows["Locked"].type, rows["Locked"].access) == ("DINT", "read only")
    assert rows["Many[3].Steps[2].Valve"].node == "ns=2;s=Many[3].Steps[2].Valve"
    assert rows["Program:Main.Step.Speed"].enip == "Program:Main.Step.Speed"
    in_files = listed(files)
    assert in_files["T4[1].PRE"].enip == "T4:1.PRE"
    assert [each.enip for each in in_files["I:1"].elements()][2] == "I:1.2"
    assert [each.enip for each in in_files["N7"].elements()][3] == "N7:3"


def test_comments_of_tags_and_aliases_are_descriptions(tmp_path: Path) -> None:
    text = "PROGRAM p\nTAG Run : BOOL // turns the pump\nALIAS Ready : Local:1:I.Data[0].3 // of the axis\n"
    text += "ROUTINE Main\nNOP();\nEND\n"
    (tmp_path / "p.rung").write_text(text, "utf-8")
    (tmp_path / "r.toml").write_text(
        'program = "p.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', "utf-8"
    )
    rows = listed(database_of(tmp_path / "r.toml"))
    assert (rows["Run"].description, rows["Ready"].description) == ("turns the pump", "of the axis")
    named = listed(database_of(write_aliases(tmp_path)))
    assert named["Third"].description == "alias of Row[2]"
    assert (named["Third"].enip, named["Third"].node) == ("Third", "")
    assert "Secret" not in named


def test_addresses_of_the_map_stand_in_its_rows(bench: Database) -> None:
    table = ModbusTable.model_validate(
        {
            "coils": [{"address": 7, "tag": "aBool"}],
            "holding_registers": [{"address": 0, "tag": "aDint"}, {"address": 40, "tag": "Grid"}],
            "input_registers": [{"address": 3, "tag": "Local:1:I.Data[2]"}, {"address": 9, "tag": "aDint"}],
        }
    )
    rows = listed(bench, table)
    assert rows["aBool"].modbus == ("coil 7",)
    assert set(rows["aDint"].modbus) == {"holding register 0", "input register 9"}
    assert rows["Grid"].modbus == ("holding register 40",)
    assert (rows["Local:1:I.Data[2]"].type, rows["Local:1:I.Data[2]"].modbus) == (
        "INT",
        ("input register 3",),
    )


@pytest.mark.parametrize("which", ["bench", "files"])
def test_the_first_map_has_a_place_for_all_but_texts(which: str, request: pytest.FixtureRequest) -> None:
    database: Database = request.getfixturevalue(which)
    rows = list(tag_rows(database))
    text, left_out = first_map(rows, ["aBool", "Grid"])
    server = tomllib.loads(text)["server"]
    assert server["writable"] == ["aBool", "Grid"]
    table = ModbusTable.model_validate(server["modbus"])
    assert RegisterMap(database, table).problems == []
    assert set(left_out) == {each.name for each in rows if each.type_name == "STRING"}
    names = [each.tag for name in ("coils", "holding_registers") for each in getattr(table, name)]
    assert names
    assert all(database.may_write((t := target_of(database, each)).tag, t.name, t.kind) for each in names)


def test_what_is_behind_the_last_address_is_left_out() -> None:
    rows = [TagRow(f"T{number}", "LREAL", (8000,), False, "", "", f"T{number}") for number in range(3)]
    text, left_out = first_map(rows, [])
    assert 'address = 32000, tag = "T1"' in text
    assert left_out == ["T2"]


@pytest.mark.parametrize(
    ("pattern", "problem"),
    [
        ("aBoool", "[server] writable: no tag 'aBoool': did you mean aBool?"),
        ("One.Stpes", "[server] writable: no tag 'One.Stpes': did you mean One.Steps"),
        ("Zq*", "[server] writable: no tag 'Zq*'"),
        ("a*", ""),
        ("One.Steps.Speed", ""),
        ("Program:Main.*", ""),
        ("Local:1:O.Data", ""),
    ],
)
def test_a_pattern_without_a_tag_is_refused_with_the_nearest_names(
    bench: Database, pattern: str, problem: str
) -> None:
    found = unknown_patterns(bench, [pattern])
    assert [each.startswith(problem) for each in found] == [True] * bool(problem)


def test_an_alias_is_refused_with_the_name_of_its_tag(tmp_path: Path) -> None:
    database = database_of(write_aliases(tmp_path))
    assert unknown_patterns(database, ["Own"]) == ["[server] writable: Own is an alias; list its tag, Open"]


# --- files that software imports


def made(which: str, rows: list[TagRow]) -> tuple[str, list[str]]:
    found = FORMATS[which](rows, "rack")
    return found.text, found.left_out


ROWS = [
    TagRow(
        "Recipe.Steps[2].Time",
        "DINT",
        (),
        True,
        'a "time"',
        "ns=2;s=Recipe.Steps[2].Time",
        "Recipe.Steps[2].Time",
    ),
    TagRow("Program:Main.Run", "BOOL", (), False, "", "ns=2;s=Program:Main.Run", "Program:Main.Run"),
    TagRow("Grid", "INT", (3, 4), True, "", "ns=2;s=Grid", "Grid"),
    TagRow("Level", "REAL", (2,), False, "", "ns=2;s=Level", "Level"),
    TagRow("Text", "STRING", (), True, "", "ns=2;s=Text", "Text"),
    TagRow("Long", "SINT", (ELEMENTS_MOST + 1,), False, "", "ns=2;s=Long", "Long"),
]


@pytest.mark.parametrize("which", ["kepware", "factorytalk"])
@pytest.mark.parametrize(
    ("said", "cell"),
    [
        ("=1+1", "'=1+1"),
        ("@SUM(1)", "'@SUM(1)"),
        ("- spare", "'- spare"),
        ("\t+1", "'+1"),
        ("of the\nbelt", "of the belt"),
        ("1 = on", "1 = on"),
    ],
)
def test_a_description_is_no_formula_and_no_line_of_its_own(which: str, said: str, cell: str) -> None:
    """Tables are opened in spreadsheets; a comment of an export is the text of a stranger."""
    text, _ = made(which, [replace(ROWS[1], description=said)])
    *_, line = csv.reader(text.splitlines())
    assert cell in line


def test_kepware_has_arrays_groups_and_texts() -> None:
    """Addresses as in the driver's help: `tag{rows}{columns}`, `tag.Data/length`; access RO and R/W."""
    text, left_out = made("kepware", ROWS)
    head, *lines = csv.reader(text.splitlines())
    assert head[:6] == ["Tag Name", "Address", "Data Type", "Respect Data Type", "Client Access", "Scan Rate"]
    assert all(len(each) == len(head) for each in lines)
    found = {line[1]: (line[0], line[2], line[4], line[head.index("Description")]) for line in lines}
    assert found["Recipe.Steps[2].Time"] == ("Recipe.Steps_2.Time", "Long", "R/W", 'a "time"')
    assert found["Program:Main.Run"] == ("Program_Main.Run", "Boolean", "RO", "")
    assert found["Grid{3}{4}"] == ("Grid", "Short Array", "R/W", "")
    assert found["Text.DATA/82"][1] == "String"
    assert found[f"Long{{{ELEMENTS_MOST + 1}}}"][1] == "Char Array"
    assert left_out == []


def test_factorytalk_has_folders_before_tags_and_a_line_for_each_element() -> None:
    """Columns as 2711E-6.12, page 6-23 has them, without H (Data Logged), which View's exports lack."""
    text, left_out = made("factorytalk", ROWS)
    lines = text.splitlines()
    assert lines[1].startswith(";###002")
    cells = list(csv.reader(line for line in lines if line[:1] == '"'))
    folders = [each[1] for each in cells if each[0] == "F"]
    assert folders == ["Recipe", "Recipe\\Steps_2", "Program_Main"]
    tags = {each[22]: each for each in cells if each[0] != "F"}
    assert all(len(each) == lines[0].count(",") + 1 for each in tags.values())
    time = tags["::[PLC]Recipe.Steps[2].Time"]
    assert time[:9] == ["A", "Recipe\\Steps_2\\Time", "a 'time'", "F", "D", "*", "F", "D", "L"]
    assert (time[9], time[10]) == (str(-(2**31)), str(2**31 - 1))
    assert tags["::[PLC]Program:Main.Run"][0] == "D"
    assert tags["::[PLC]Level[1]"][8] == "F"
    assert tags["::[PLC]Text"][0] == "S"
    assert "::[PLC]Grid[2,3]" in tags
    assert left_out == ["Long"]


GRID = [f"Grid_{row}_{column}" for row in range(3) for column in range(4)]


def test_ignition_has_folders_and_nodes() -> None:
    text, left_out = made("ignition", ROWS)
    tree: dict[str, Any] = json.loads(text)
    assert [each["name"] for each in tree["tags"]] == [
        "Recipe",
        "Program_Main",
        *GRID,
        "Level",
        "Text",
        "Long",
    ]
    time = tree["tags"][0]["tags"][0]["tags"][0]
    assert (time["opcItemPath"], time["dataType"], time["readOnly"]) == (
        "ns=2;s=Recipe.Steps[2].Time",
        "Int4",
        False,
    )
    assert time["documentation"] == 'a "time"'
    assert tree["tags"][2 + len(GRID)]["dataType"] == "Float4Array"
    assert tree["tags"][2]["opcItemPath"] == "ns=2;s=Grid[0,0]"
    assert left_out == []


def test_node_red_has_a_table_by_program_and_a_node_for_each_writable_tag() -> None:
    inside = TagRow("Hosts.Level", "DINT", (2, 3), True, "", "ns=2;s=Hosts.Level", "Hosts.Level")
    flags = TagRow("Flags", "BOOL", (32,), False, "", "ns=2;s=Flags", "Flags")
    text, left_out = made("node-red", [*ROWS, inside, flags])
    nodes = {each["id"]: each for each in json.loads(text)}
    table = nodes["rack-endpoint"]["vartable"]
    assert table["Main"] == {"Run": {"type": "BOOL"}}
    assert table[""]["Recipe.Steps[2].Time"] == {"type": "DINT"}
    assert table[""]["Flags[31]"] == {"type": "BIT_STRING"}  # an element of such an array is a bit of a DWORD
    outs = {each["variable"] for each in nodes.values() if each["type"] == "eth-ip out"}
    assert outs == {
        "Recipe.Steps[2].Time",
        *(f"Grid[{row},{column}]" for row in range(3) for column in range(4)),
    }
    assert all(each["z"] == "rack-flow" for each in nodes.values() if "wires" in each)
    assert left_out == ["Hosts.Level", "Text", "Long"]  # its nodes know grids of tags, not of members
