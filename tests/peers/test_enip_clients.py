"""Clients that others wrote, against a rack's tags: pycomm3 and pylogix of PyPI, two packages of npm.

In the environment of `.ci/run` all are there; elsewhere a test without its peer skips.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import pytest
from aliased_tags import write_aliases
from listed_layouts import CONTROLLERS, Listed, listed, of_pycomm3, of_pylogix, of_st, rack_at, rack_id
from logix_clients import pycomm3_client, pylogix_client
from peers import node
from scanrack.jobs.run.servers.tag_formats import FORMATS
from scanrack.runtime.tag_servers.tag_list import tag_rows
from served_tags import ServedRack, served, write_rack

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pycomm3 = pytest.importorskip("pycomm3", reason="pycomm3 is not installed")

WRITES: dict[str, Any] = {
    "aBool": True,
    "aSint": -7,
    "anInt": 770,
    "aDint": -9,
    "aLint": 2**40,
    "aReal": 0.25,
    "aLreal": 1e100,
    "Text": "written outside",
    "Grid[2,3]": 99,
    "Flags[35]": True,
    "anInt.3": False,
    "Fill.PRE": 1234,
    "One.Name": "abc",
    "Many[2].Steps[1].Speed": 8.5,
    "Hosts.Stop": True,
    "Program:Main.Step.Time": 42,
}
UNSIGNED = {"aUsint": 255, "aUint": 65_535, "aUdint": 2**32 - 1, "aUlint": 2**63 + 5}


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ServedRack, int]]:
    with served(write_rack(tmp_path_factory.mktemp("bench"))) as (rack, port):
        yield rack, port


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ServedRack, int]]:
    with served(write_rack(tmp_path_factory.mktemp("files"), files=True)) as (rack, port):
        yield rack, port


@pytest.fixture(scope="module", params=CONTROLLERS, ids=rack_id)
def controller(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Listed, int]]:
    """The layout of a rack, and the port at which it is served."""
    with served(rack_at(request.param, tmp_path_factory.mktemp("rack"))) as (rack, port):
        yield listed(rack.setup.database), port


def in_rack(rack: ServedRack, name: str) -> Any:
    """Return a value as the program has it."""
    return rack.debugger.tags[name.replace("Program:Main.", "\\Main.")]


@pytest.mark.peer("pycomm3", "pylogix")
def test_aliases_and_access_to_pycomm3_and_pylogix(tmp_path: Path) -> None:
    """Row[2] is 7 after the first scan; Seen is Read Only, Hid has no access."""
    with served(write_aliases(tmp_path)) as (rack, port):
        with pycomm3_client(pycomm3.LogixDriver, port, init_program_tags=True) as plc:
            assert {"Third", "Again", "Bit", "Whole", "Own", "Stopped", "Program:Main.Mine"} <= set(plc.tags)
            assert not {"Hid", "Secret"} & set(plc.tags)
            assert plc.tags["Seen"]["external_access"] == "Read Only"
            assert [plc.read(name).value for name in ("Third", "Again", "Bit")] == [7, 7, False]
            assert plc.read("Whole{4}").value == [0, 0, 7, 0]
            assert plc.write("Own", 9).error is None
            assert plc.write("Shown", 9).error is not None
        with pylogix_client(port) as plc:
            assert [plc.Read(name).Value for name in ("Third", "Open", "Bit")] == [7, 9, False]
            assert plc.Read("Hid").Status != "Success"
            names = [each.TagName for each in plc.GetTagList().Value]
            assert "Own" in names
            assert "Hid" not in names
        assert in_rack(rack, "Open") == 9


@pytest.mark.peer("pycomm3")
def test_pycomm3_lists_all_tags_and_templates(controller: tuple[Listed, int]) -> None:
    layout, port = controller
    with pycomm3_client(pycomm3.LogixDriver, port, init_program_tags=True) as plc:
        assert of_pycomm3(plc) == layout


@pytest.mark.peer("pylogix")
def test_pylogix_lists_all_tags_and_templates(controller: tuple[Listed, int]) -> None:
    layout, port = controller
    with pylogix_client(port) as plc:
        told = of_pylogix(plc)
    first = itemgetter(slice(1))
    assert told.without(sizes=False, dims=first) == layout.without(sizes=False, dims=first)


@pytest.mark.peer("st-ethernet-ip")
def test_st_ethernet_ip_lists_all_tags_and_templates(controller: tuple[Listed, int]) -> None:
    layout, port = controller
    told = of_st(node("st-ethernet-ip", "write_tags.cjs", port, "list"))
    assert told.without() == layout.without(dims=lambda dims: (len(dims),) * bool(dims))


@pytest.mark.peer("pycomm3")
def test_pycomm3_reads_structures(bench: tuple[ServedRack, int]) -> None:
    _, port = bench
    with pycomm3_client(pycomm3.LogixDriver, port, init_program_tags=True) as plc:
        recipe = plc.data_types["Recipe"]
        assert recipe["template"]["structure_size"] == 144
        assert recipe["attributes"] == ["Id", "Flag", "Steps", "Name", "Bits", "Total"]
        assert plc.read("Many{4}").value[3]["Steps"][2] == {
            "Time": 0,
            "Valve": False,
            "Ready": False,
            "Speed": 0.0,
        }


@pytest.mark.peer("pycomm3")
def test_pycomm3_writes_every_type_singly_in_batches_and_in_parts(bench: tuple[ServedRack, int]) -> None:
    rack, port = bench
    values = WRITES | UNSIGNED
    with pycomm3_client(pycomm3.LogixDriver, port, init_program_tags=True) as plc:
        assert [each.error for each in plc.write(*values.items())] == [None] * len(values)
        assert [each.value for each in plc.read(*values)] == list(values.values())
        assert plc.write("Dints{3000}", list(range(3000))).error is None
        assert plc.read("Dints{3000}").value == list(range(3000))
        step = {"Time": 5, "Valve": True, "Ready": False, "Speed": 2.5}
        assert plc.write("One.Steps[2]", step).error is None
        assert plc.read("One.Steps[2]").value == step
        assert plc.write("Locked", 5).error is not None
        assert len({each.value for each in plc.read("Scan", "C1", "C2")}) == 1
        assert plc.get_plc_time().value["microseconds"] > 0
    assert {name: in_rack(rack, name) for name in values} == values
    assert rack.debugger.tags["Locked"] == 7


@pytest.mark.peer("ciplink")
def test_ciplink_reads_and_writes_every_type(bench: tuple[ServedRack, int]) -> None:
    ciplink = pytest.importorskip("ciplink", reason="ciplink is not installed")
    rack, port = bench
    values = WRITES | UNSIGNED
    with ciplink.LogixDriver(f"127.0.0.1:{port}/0", init_program_tags=True) as plc:
        assert len(plc.tags) == len(rack.desk.listing.tags)
        assert [each.error for each in plc.write(*values.items())] == [None] * len(values)
        assert [each.value for each in plc.read(*values)] == list(values.values())
        assert plc.write("Dints{3000}", list(range(3000))).error is None
        assert plc.read("Dints{3000}").value == list(range(3000))
        assert plc.write("Locked", 5).error == "Permission denied"
        assert plc.generic_message(service=1, class_code=0xF6, instance=1).value[:4] == b"\xe8\3\0\0"
    assert {name: in_rack(rack, name) for name in values} == values
    assert rack.debugger.tags["Locked"] == 7


@pytest.mark.peer("pylogix")
@pytest.mark.parametrize("size", [4002, 504])
def test_pylogix_reads_and_writes_what_is_listed(bench: tuple[ServedRack, int], size: int) -> None:
    rack, port = bench
    with pylogix_client(port) as plc:
        plc.ConnectionSize = size
        names = {each.TagName for each in plc.GetTagList().Value}
        assert {f"{each.program and 'Program:Main.'}{each.name}" for each in rack.desk.listing.tags} <= names
        for name, value in WRITES.items():
            if name != "Many[2].Steps[1].Speed" or size == 4002:
                assert (plc.Write(name, value).Status, plc.Read(name).Value) == ("Success", value), name
        assert plc.Write("Dints[0]", list(range(3000))).Status == "Success"
        assert plc.Read("Dints[0]", 3000).Value == list(range(3000))
        assert plc.Write("Dints[1000]", list(range(2000))).Status == "Success"
        assert plc.Read("Dints[500]", 2500).Value == [*range(500, 1000), *range(2000)]
        assert plc.Write("Locked", 5).Status == "Privilege violation"
        assert [each.Status for each in plc.Read(["Scan", "C1"])] == ["Success"] * 2
    assert rack.debugger.tags["Locked"] == 7


@pytest.mark.peer("pycomm3")
def test_slcdriver_reads_and_writes_data_files(files: tuple[ServedRack, int]) -> None:
    _, port = files
    reads: dict[str, Any] = {
        "N7:3": -4,
        "B3:1": 5,
        "T4:1.PRE": 20,
        "C5:0.PRE": 10,
        "F8:1": -2.25,
        "L10:0": 100_000,
    }
    reads |= {"ST9:1": "hello world", "I:1.0/14": True, "O:1.0": 0, "N7:0{3}": [1, 2, 3]}
    writes: dict[str, Any] = {
        "N7:1": 55,
        "N7:10{3}": [1, 2, 3],
        "F8:3": 4.25,
        "L10:1": -100_000,
        "ST9:0": "new text",
    }
    writes |= {"B3:3": 0x55, "B3:0/5": True, "O:1.0": 3, "S:7": 3}
    with pycomm3_client(pycomm3.SLCDriver, port) as plc:
        assert plc.get_processor_type() == "1764-LRP"
        assert {name: plc.read(name).value for name in reads} == reads
        for name, value in writes.items():
            assert plc.write((name, value)).error is None
            assert plc.read(name).value == value
        assert plc.write(("T4:0.PRE", 777)).error is not None  # it names six bytes and sends two
        assert plc.read("T4:0.PRE").value == 500
        assert plc.write(("I:1.0", 3)).error == "Error code in EXT STS Byte"  # 0Bh, see test_data_files.py
        assert plc.read("I:1.0").value == 0x6400
        with pytest.raises(pycomm3.RequestError, match="parsing the tag"):
            plc.read("R6:0.LEN")  # it knows no control files
        directory = plc.get_file_directory()
        assert {name: each["elements"] for name, each in directory.items()} == {
            "O0": 8, "I1": 8, "S2": 84, "B3": 4, "T4": 2, "C5": 1, "R6": 1, "N7": 16, "F8": 4, "ST9": 2,
            "L10": 2,
        }  # fmt: skip


@pytest.mark.peer("nodepccc")
def test_nodepccc_reads_and_writes_data_files(files: tuple[ServedRack, int]) -> None:
    """For a word of a timer, counter or control it sends three: two land behind it, or do not fit."""
    rack, port = files
    rack.debugger.tags["T4:0.ACC"] = 9
    assert node("nodepccc", "write_files.cjs", port) == {
        "N7:4": [False, 444],
        "F8:2": [False, 3.5],
        "B3:2/5": [False, True],
        "L10:1": [False, 70_000],
        "ST9:1": [False, "from node"],
        "T4:0.PRE": [False, 321],
        "C5:0.PRE": [True, 10],
        "R6:0.LEN": [True, 4],
        "O:1": [False, 6],
        "I:1": [True, 0x6400],
        "S:7": [False, 3],
    }
    tags = rack.debugger.tags
    assert [tags[each] for each in ("T4:0.PRE", "T4:0.ACC", "C5:0.ACC", "R6:0.POS")] == [321, 0, 3, 1]


@pytest.mark.peer("st-ethernet-ip")
def test_st_ethernet_ip_reads_and_writes_tags(bench: tuple[ServedRack, int]) -> None:
    rack, port = bench
    rack.debugger.tags["Hosts.Go"] = True
    told = node("st-ethernet-ip", "write_tags.cjs", port)
    assert told == {
        "tags": len(rack.desk.listing.tags),
        "aDint": 777,
        "aReal": 1.25,
        "Text": "from node",
        "Go": True,
    }
    assert rack.debugger.tags["aDint"] == 777


def test_every_name_of_the_list_is_read(bench: tuple[ServedRack, int]) -> None:
    """`scanrack tags`: pycomm3 reads each row by its name, with its type."""
    rack, port = bench
    rows = list(tag_rows(rack.setup.database))
    with pycomm3_client(pycomm3.LogixDriver, port, init_program_tags=True) as plc:
        for row in rows:
            answer = plc.read(row.enip)
            assert answer.error is None, row
            assert answer.type.startswith(row.type_name), (row, answer)
    assert len(rows) > 100


def test_the_flow_for_node_red_is_read_by_its_library(bench: tuple[ServedRack, int], tmp_path: Path) -> None:
    rack, port = bench
    rack.debugger.tags["\\Main.Step.Time"] = 66
    rows = [each for each in tag_rows(rack.setup.database) if each.name.split(".")[0] in FLOW]
    (tmp_path / "flow.json").write_text(FORMATS["node-red"](rows, "bench").text, "utf-8")
    told = node("st-ethernet-ip", "read_flow.cjs", tmp_path / "flow.json", port)
    assert told["Main"]["Step.Time"] == 66
    for name in ("aSint", "anInt", "aDint", "aReal", "aBool", "Grid[1,2]", "Fill.PRE"):
        assert told[""][name] == rack.debugger.tags[name], name


FLOW = {"aSint", "anInt", "aDint", "aReal", "aBool", "Grid", "Fill", "Program:Main"}


def test_the_examples_of_exports_are_written_by_pycomm3() -> None:
    """Bits of B3 start the conveyor of an SLC program; an HMI changes a recipe of an L5X."""
    with (
        served(EXAMPLES / "slc/conveyor.toml") as (_, port),
        pycomm3_client(pycomm3.SLCDriver, port) as plc,
    ):
        assert not plc.read("B3:0/2").value
        assert plc.write(("B3:0/0", True)).error is None
        assert plc.write(("C5:0.PRE", 3)).error is not None  # it names the control word
        assert plc.read("B3:0/2").value
    with served(EXAMPLES / "l5x/mixer.toml") as (rack, port):
        with pycomm3_client(pycomm3.LogixDriver, port) as plc:
            assert plc.write("Recipes[1].Degrees", 42.5).error is None
            assert plc.write("ToLine.Number", 1).error is not None
        assert in_rack(rack, "Recipes[1].Degrees") == 42.5


def test_what_clients_make_of_what_they_can_not_have(bench: tuple[ServedRack, int]) -> None:
    """docs/hmi-clients.md: a bit that a DINT lacks, and 999 DINTs in one packet; neither gives wrong data."""
    rack, port = bench
    rack.debugger.tags["aDint"] = 5
    with pycomm3_client(pycomm3.LogixDriver, port) as plc:
        assert plc.read("Dints{998}").error is None
        assert plc.read("Dints{999}").error == "Insufficient Packet Space"
        assert len(plc.read("Dints{1001}").value) == 1001
        plc.write("aDint.32", True)
    assert rack.debugger.tags["aDint"] == 5


EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.peer("pycomm3", "pylogix")
def test_pycomm3_and_pylogix_ask_for_the_network_interface(bench: tuple[ServedRack, int]) -> None:
    _, port = bench
    with pycomm3_client(pycomm3.LogixDriver, port) as plc:
        link = plc.generic_message(service=1, class_code=0xF6, instance=1, connected=False)
        address = plc.generic_message(service=0x0E, class_code=0xF5, instance=1, attribute=5)
    assert (link.error, link.value[:8]) == (None, bytes.fromhex("e8030000 0f000000"))
    assert (address.error, address.value[:4]) == (None, bytes((1, 0, 0, 127)))
    with pylogix_client(port) as plc:
        link = plc.Message(0x01, 0xF6, 1)
        assert (link.Status, link.Value[-6:]) == ("Success", bytes.fromhex("02005ca99acc"))
        assert plc.Message(0x0E, 0xF5, 1, 7).Status != "Success"
