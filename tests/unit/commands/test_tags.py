"""`scanrack tags`: a list, files for other software, and a first `[server]` table that a server takes."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner, Result

ROOT = Path(__file__).parents[3]
HMI = str(ROOT / "examples/hmi/feeder.toml")


def tags(*words: str) -> Result:
    return CliRunner().invoke(build(), ["tags", *words])


def test_the_list_has_the_addresses_of_the_rack_file() -> None:
    """The map of examples/hmi: HmiLength is holding register 0, the counter's value input register 2."""
    done = tags(HMI, "HmiLength", "Strokes.ACC")
    assert done.exit_code == 0
    head, length, strokes = done.stdout.splitlines()
    assert head.split()[:4] == ["name", "type", "access", "Modbus"]
    assert length.split() == [
        "HmiLength",
        "DINT",
        "read/write",
        "holding",
        "register",
        "0",
        "ns=2;s=HmiLength",
        "HmiLength",
    ]
    assert strokes.split()[1:7] == ["DINT", "read", "only", "input", "register", "2"]


def test_csv_and_json_have_the_same_rows() -> None:
    rows = list(csv.DictReader(tags(HMI, "--csv").stdout.splitlines()))
    told = json.loads(tags(HMI, "--json").stdout)
    assert told["rack"] == "feeder with an HMI"
    assert [each["name"] for each in rows] == [each["name"] for each in told["tags"]]
    start = next(each for each in told["tags"] if each["name"] == "HmiStart")
    assert (start["writable"], start["modbus"], start["dimensions"]) == (True, ["coil 0"], [])


@pytest.mark.parametrize("software", ["ignition", "kepware", "factorytalk", "node-red"])
def test_a_file_for_software_is_all_that_is_printed(software: str) -> None:
    done = tags(HMI, "Hmi*", "--for", software)
    assert (done.exit_code, done.stderr) == (0, "")
    assert "HmiLength" in done.stdout
    if software in ("ignition", "node-red"):
        json.loads(done.stdout)
    all_of_it = tags(HMI, "--for", software)
    left_out = {"ignition": "ignition can't represent 2 of 247 tags: Start, Stop"}.get(software, "")
    assert (all_of_it.exit_code, left_out in all_of_it.stderr) == (1 if left_out else 0, True)


def test_a_server_takes_the_first_map(tmp_path: Path) -> None:
    for name in ("feeder.toml", "feeder.rung"):
        shutil.copy(ROOT / "examples/feeder" / name, tmp_path)
    rack = tmp_path / "feeder.toml"
    made = tags(str(rack), "--map")
    assert made.exit_code == 0
    rack.write_text(rack.read_text("utf-8") + "\n" + made.stdout, "utf-8")
    words = ["run", str(rack), "--server", "modbus-tcp:0", "--scans", "2", "--no-record", "--quiet"]
    done = CliRunner().invoke(build(), words)
    assert done.exit_code == 0, done.stderr
    listed = {each["name"]: each for each in json.loads(tags(str(rack), "--json").stdout)["tags"]}
    assert listed["Feeding"]["modbus"]


def test_mistakes_are_told() -> None:
    for words, told in (
        ((HMI, "HmiStrat"), "no tag 'HmiStrat': did you mean HmiStart"),
        ((HMI, "--csv", "--json"), "give only one of them"),
        (("missing.toml",), "missing.toml"),
    ):
        done = tags(*words)
        assert (done.exit_code, told in done.stderr) == (2, True), done.stderr
