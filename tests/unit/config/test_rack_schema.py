"""The schema of rack files: every key described, every rack of ours valid, planted mistakes found."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft4Validator, Draft202012Validator
from scanrack.commands import build
from scanrack.runtime import load_rack_file
from scanrack.runtime.config.rack_schema import HINT, rack_schema
from scanrack.runtime.modules.registry import MODULES
from typer.testing import CliRunner

HOUSE = Path(__file__).parents[3]
RACKS = sorted([*HOUSE.glob("examples/*/*.toml"), *HOUSE.glob("scanrack/jobs/start/templates/*/*.toml")])
DRAFTS = {False: Draft202012Validator, True: Draft4Validator}

RACK = """\
name = "feeder"
program = "feeder.rung"
mode = "run"
scan_ms = 2
run_for_s = 20
[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"
options = { input_scan_us = 300 }
[slot.machine]
switches = [{ input = "home", first = -1500, last = -1300 }]
timeline = [{ at_s = 8.0, input = "estop", for_ms = 500 }]
"""
MISTAKES = {
    '"4.1"': '"9.9"',
    '"home"': '"hme"',
    '"run"': '"runn"',
    '"amci3601"': '"amci3602"',
    "scan_ms = 2": "scan_ms = -2",
    "input_scan_us": "nope",
    "= 300": "= 10",
    "at_s": "at_h",
    "run_for_s": "run_for_sec",
    'firmware = "4.1"': 'wiring = "diag"',
    "number = 1": 'number = "one"',
    "[[slot]]": "[[slots]]",
    "for_ms = 500": "for_ms = true",
}
"""A mistake each: a key, a name, a number or a type that is not allowed."""


schema_of = cache(rack_schema)


def found(text: str, draft4: bool) -> list[Any]:
    """Return what a validator finds in the text of a rack file."""
    return list(DRAFTS[draft4](schema_of(draft4=draft4)).iter_errors(tomllib.loads(text)))


@pytest.mark.parametrize("draft4", DRAFTS)
def test_every_key_has_a_meaning(draft4: bool) -> None:
    schema = schema_of(draft4=draft4)
    DRAFTS[draft4].check_schema(schema)
    tables = {"rack": schema, **schema["definitions" if draft4 else "$defs"]}
    keys = {
        f"{name}.{key}": each for name, table in tables.items() for key, each in table["properties"].items()
    }
    assert len(keys) > 83
    assert [name for name, each in keys.items() if not each.get("description")] == []


@pytest.mark.parametrize("draft4", DRAFTS)
def test_our_racks_are_valid(draft4: bool) -> None:
    assert len(RACKS) > 20
    wrong = {path.name: str(each) for path in RACKS for each in found(path.read_text("utf-8"), draft4)}
    assert wrong == {}


@pytest.mark.parametrize("draft4", DRAFTS)
def test_each_planted_mistake_is_found_alone(draft4: bool) -> None:
    assert found(RACK, draft4) == []
    missed = [new for old, new in MISTAKES.items() if not found(RACK.replace(old, new, 1), draft4)]
    assert missed == []


def test_a_mistake_in_the_name_of_a_module_is_one_error() -> None:
    (only,) = found(RACK.replace('"amci3601"', '"amci3602"'), False)
    assert list(only.path) == ["slot", 0, "module"]


def test_each_module_has_its_options_in_a_branch_of_its_own() -> None:
    branches = schema_of()["$defs"]["SlotSpec"]["anyOf"]
    named = [name for each in branches for name in each["properties"]["module"].get("enum", ())]
    assert sorted(named) == sorted(MODULES)
    card = RACK.replace('"amci3601"', '"1762-IQ16"').replace("input_scan_us = 300", "inputs = { start = 0 }")
    assert found(card, False) == []
    assert found(card.replace("inputs", "input_scan_us"), False)


def test_times_and_limits_are_those_that_are_checked() -> None:
    tables = schema_of()
    assert tables["properties"]["scan_ms"] == {
        "default": 2,
        "description": "time from one scan to the next, 0.01 to 1000 ms.",
        "maximum": 1000.0,
        "minimum": 0.01,
        "type": "number",
    }
    times = tables["$defs"]["TimelineTable"]["properties"]
    assert times["at_s"]["description"] == "time since power-up, s; or `at_ms`."


def test_the_command_writes_it_beside_and_a_rack_file_may_name_it(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    rack = tmp_path / "rack.toml"
    rack.write_text(f"{HINT}\n{RACK}", encoding="utf-8")
    before = rack.read_bytes()
    done = CliRunner().invoke(build(), ["editor", "schema", "--write"])
    assert done.exit_code == 0
    assert HINT in done.output
    assert json.loads((tmp_path / "rack.schema.json").read_text("utf-8")) == rack_schema()
    assert rack.read_bytes() == before
    assert load_rack_file(rack).spec.name == "feeder"
    assert json.loads(CliRunner().invoke(build(), ["editor", "schema", "--draft4"]).output) == rack_schema(
        draft4=True
    )
