"""The feeder with an HMI as a story, and the tags of its panel and its flow. Run it with pytest."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from scanrack import open_bench
from scanrack.jobs.bench import Bench

HERE = Path(__file__).parent
RACK = HERE / "feeder.toml"


@pytest.fixture
def feeder() -> Iterator[Bench]:
    """The feeder, started by the HMI before anybody presses a button of the panel."""
    with open_bench(RACK) as bench:
        bench.run_for("20 ms")
        bench["HmiStart"] = True
        bench.run_for("4 ms")
        yield bench


def test_an_hmi_starts_and_stops_as_the_panel_does(feeder: Bench) -> None:
    assert feeder["Running"]
    assert not feeder["HmiStart"]  # the program takes the button back
    feeder.run_until("Out.Active", within="5 s")
    feeder["HmiStop"] = True
    feeder.run_for("4 ms")
    assert not feeder["Running"]
    feeder.run_until("Out.Done", within="3 s")  # Stop lets the stroke end
    assert feeder["Position"] == 6000


@pytest.mark.parametrize(("asked", "taken"), [(3000, 3000), (0, 1000), (50_000, 10_000)])
def test_a_stroke_is_as_long_as_the_machine_allows(feeder: Bench, asked: int, taken: int) -> None:
    feeder["HmiLength"] = asked
    feeder.run_until("Out.Done", within="8 s")
    assert feeder["Position"] == taken


def test_panel_flow_and_rack_name_the_same_tags(feeder: Bench) -> None:
    writable = set(tomllib.loads(RACK.read_text("utf-8"))["server"]["writable"])
    panel = (HERE / "panel.py").read_text("utf-8")
    shown = set(re.findall(r'"([\w.]+)"', re.search(r"SHOWN = \((.*?)\)", panel, re.DOTALL)[1]))  # type: ignore[index]
    assert set(re.findall(r'"(Hmi\w+)": ua', panel)) == writable
    flow = json.loads((HERE / "flow.json").read_text("utf-8"))
    read = {name for each in flow for name in each.get("vartable", {}).get("", {})}
    assert {each["variable"] for each in flow if each["type"] == "eth-ip out"} <= writable
    for name in shown | read | writable:
        assert feeder[name] is not None
