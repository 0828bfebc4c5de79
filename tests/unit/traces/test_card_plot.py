"""Cards on a timing chart: lanes of the names in the rack file, curves of analog channels."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace
from scanrack.traces.plot import Chart, Curve, Envelope, read_chart
from scanrack.traces.signals import Catalog
from scanrack.traces.signals.catalog import UnknownSignalError
from typer.testing import CliRunner

RACK = """
program = "lamp.py"
scan_ms = 2
run_for_s = 0.1

[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { start = 0, spare = 1 }
timeline = [{ at_ms = 10, input = "start", for_ms = 20 }]

[[slot]]
number = 3
module = "1769-OB16"
[slot.options]
outputs = { lamp = 4 }

[[slot]]
number = 4
module = "1769-IF4"
[slot.options]
inputs = { level = 1 }
timeline = [{ at_ms = 20, input = "level", value = 6240 }]
"""
PROGRAM = """
def logic(scan):
    scan.slot[3].outputs.set_bit(0, 4, scan.slot[2].inputs.bit(0, 0))
"""


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cards")
    (folder / "lamp.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "rack.toml").write_text(RACK, encoding="utf-8")
    target = folder / "a.mcap"
    scanrack("run", folder / "rack.toml", "--record", target, "--quiet")
    return target


def scanrack(*words: object) -> None:
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == 0, result.output


def chart(path: Path, *slots: int) -> Chart[Curve]:
    with open_trace(path) as trace:
        return read_chart(trace, Envelope, slots=slots)


def test_a_card_has_a_lane_for_every_name_that_changes(trace: Path) -> None:
    """Start is pressed from 10 to 30 ms, scans 5 to 14; the lamp follows in the same scan."""
    buttons, lamps, _ = chart(trace).panels
    for panel, name, group in ((buttons, "start", "input"), (lamps, "lamp", "output")):
        (lane,) = panel.lanes
        assert (lane.name, lane.group, panel.ramp, panel.curves) == (name, group, None, [])
        assert lane.row.tolist() == [0, 5, 15]
        assert lane.value.tolist() == [0, 1, 0]
    assert [lane.name for lane in buttons.steady] == ["spare"]


def test_an_analog_channel_that_is_named_is_a_curve(trace: Path) -> None:
    (panel,) = chart(trace, 4).panels
    ((name, curve),) = panel.curves
    assert (name, curve.low.min(), curve.high.max()) == ("level", 0, 6240)


PICTURE = pytest.mark.extra("plot")


@pytest.mark.slow
@pytest.mark.parametrize(
    "suffix", [pytest.param("svg", marks=PICTURE), pytest.param("png", marks=PICTURE), "html"]
)
def test_plot_draws_a_rack_without_a_stepper(trace: Path, suffix: str) -> None:
    picture = trace.with_suffix(f".{suffix}")
    scanrack("plot", trace, "--out", picture)
    if suffix == "html":
        data = re.search(
            r'<script id="data"[^>]*>(.*?)</script>', picture.read_text(encoding="utf-8"), re.DOTALL
        )
        assert data is not None
        panels = json.loads(data[1])["panels"]
        assert [panel["ramp"] for panel in panels] == [None] * 3
        assert json.loads(data[1])["groups"] == ["input", "output"]
    else:
        assert picture.stat().st_size > 1000


def test_a_query_takes_a_terminal_by_its_name(trace: Path) -> None:
    """The lamp is on from 10 to 30 ms; a name that two terminals have means neither."""
    result = CliRunner().invoke(build(), ["query", str(trace), "count(rose(Lamp))"])
    assert (result.exit_code, result.stdout) == (0, "1\n")
    with open_trace(trace) as opened:
        slots = [replace(slot, words=opened.head.slots[1].words) for slot in opened.head.slots[:2]]
    assert Catalog(slots[1:])["LAMP"].name == "slot3.out.lamp"
    with pytest.raises(UnknownSignalError, match=r"lamp is ambiguous: it is slot2.out.lamp or slot3"):
        Catalog(slots)["lamp"]
