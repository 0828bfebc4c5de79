"""Recorded tags on a chart: curves of numbers, bands of steps and texts, lanes of BOOLs."""

from __future__ import annotations

import base64
import json
import math
import re
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from struct import pack
from typing import Any

import numpy as np
import pytest
from made_tags import MadeTags, no_texts
from made_traces import cut_blocks
from scanrack.commands import build
from scanrack.traces import ScanRecorder, SlotInfo, Tag, open_trace
from scanrack.traces.plot import Chart, Curve, Envelope, Panel, read_chart, save_figure, save_page
from scanrack.traces.signals import Selection
from scanrack.traces.signals.catalog import UnknownSignalError
from typer.testing import CliRunner

SCANS = 300
TOY = SlotInfo(5, "a toy")
A3601 = SlotInfo(1, "amci3601", "4.1")
TAGS = [
    Tag(r"\Main.Lamp", "BOOL"),
    Tag("Auto", "BOOL"),
    Tag("Fill.ACC", "DINT"),
    Tag("Fill.PRE", "DINT"),
    Tag("Step", "ENUM", 0, ("IDLE", "FILL", "HOLD")),
    Tag("Level", "REAL"),
    Tag("Big", "LINT"),
    Tag("Medium", "TEXT"),
]


def row(scan: int) -> bytes:
    """Return Big, Fill.ACC, Fill.PRE, Level, Step, Medium, Lamp and Auto in a scan."""
    level = math.nan if scan == 7 else scan / 2 + 0.25
    step, medium = scan // 100, int(scan >= 200)
    return pack("<qiifHH??", 2**40 + scan, -scan, 500, level, step, medium, scan % 20 == 5, True)


def texts(scan: int) -> Mapping[str, Sequence[tuple[int, str]]]:
    return {"Medium": [(0, ""), (1, "oil, hot")]} if scan == 0 else {}


def record(path: Path, slot: SlotInfo = A3601, tags: Sequence[Tag] = TAGS, values: Any = row) -> Path:
    memory = bytearray(32)
    made = MadeTags(memory, tags, values, texts if any(tag.type == "TEXT" for tag in tags) else no_texts)
    recorder = ScanRecorder(path, memory, [slot], scan_period_ns=2_000_000, chunk_scans=64, tags=made)
    for scan in range(SCANS):
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    return path


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("tags") / "made.mcap")


def chart(path: Path, *tags: str, slots: Sequence[int] = (), selection: Any = None) -> Chart[Curve]:
    with open_trace(path) as opened:
        return read_chart(opened, Envelope, selection or Selection(), tags=tags, slots=slots)


def program(path: Path, *tags: str, **more: Any) -> Panel[Curve]:
    panel = chart(path, *tags, **more).panels[-1]
    assert panel.slot is None
    return panel


@pytest.mark.parametrize("block", [1, 64, 1000])
def test_a_bool_is_a_lane_a_number_a_curve_a_step_a_band(
    trace: Path, block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_blocks(monkeypatch, block)
    panel = program(trace)
    (lamp,) = panel.lanes
    assert (lamp.name, lamp.group) == (r"\Main.Lamp", "tag")
    assert lamp.row.tolist()[:5] == [0, 5, 6, 25, 26]
    assert lamp.value.tolist()[:5] == [0, 1, 0, 1, 0]
    step, medium = panel.bands
    assert [step.text(value) for value in step.value.tolist()] == ["IDLE", "FILL", "HOLD"]
    assert step.row.tolist() == [0, 100, 200]
    assert [medium.text(value) for value in medium.value.tolist()] == ['""', "oil, hot"]
    curves = dict(panel.curves)
    assert list(curves) == ["Big", "Fill.ACC", "Level"]
    assert curves["Fill.ACC"].high.tolist() == [-scan for scan in range(SCANS)]
    assert curves["Level"].low[[0, 6, 8]].tolist() == [0.25, 3.25, 4.25]
    assert np.isnan(curves["Level"].low[7])
    assert panel.fractional == ["Level"]


def test_what_does_not_change_is_named_with_its_value(trace: Path) -> None:
    assert program(trace).unchanged == [("Auto", "on"), ("Fill.PRE", "500")]
    part = program(trace, selection=Selection(first=110, last=119))
    assert ("Step", "FILL") in part.unchanged
    assert not part.bands


def test_the_slots_come_first_and_are_as_without_tags(trace: Path) -> None:
    slot, tags = chart(trace).panels
    assert (slot.name, slot.about) == ("slot 1", "amci3601")
    assert (tags.name, tags.about, list(tags.marks)) == ("program", "8 tags", [])
    assert [panel.name for panel in chart(trace, slots=[1]).panels] == ["slot 1"]
    assert [panel.name for panel in chart(trace, "Step", slots=[1]).panels] == ["slot 1", "program"]


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("Step", ["Step"]),
        ("tags.step", ["Step"]),
        (r"\main.lamp", [r"\Main.Lamp"]),
        ("Lamp", [r"\Main.Lamp"]),
        ("main_lamp", [r"\Main.Lamp"]),
        ("fill.*", ["Fill.ACC", "Fill.PRE"]),
        ("Fill", ["Fill.ACC", "Fill.PRE"]),
        ("tags.fill_*", ["Fill.ACC", "Fill.PRE"]),
        ("*.PRE", ["Fill.PRE"]),
        ("Step.FILL", ["step.FILL"]),
        ("Fill.ACC.3", ["fill_acc.3"]),
    ],
)
def test_tags_are_chosen_as_in_a_query(trace: Path, pattern: str, names: list[str]) -> None:
    panel = program(trace, pattern)
    drawn = [name for name, _ in panel.curves] + [lane.name for lane in (*panel.bands, *panel.lanes)]
    steady = [name for name, _ in panel.unchanged]
    assert drawn + steady == names


def test_a_condition_is_a_lane(trace: Path) -> None:
    (lane,) = program(trace, "Step.FILL").lanes
    assert (lane.row.tolist(), lane.value.tolist()) == ([0, 100, 200], [0, 1, 0])


@pytest.mark.parametrize(
    ("pattern", "error", "says"),
    [
        ("Stap", UnknownSignalError, "no signal 'Stap'"),
        ("slot1.in.position", ValueError, "position is not a recorded tag; recorded tags: Big, Fill"),
    ],
)
def test_what_is_no_tag_is_refused(trace: Path, pattern: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=re.escape(says)):
        chart(trace, pattern)


MANY = [*(Tag(f"N{number}", "DINT") for number in range(30)), *(Tag(f"B{n}", "BOOL") for n in range(220))]


def many(scan: int) -> bytes:
    """Return thirty numbers of which every other changes, and 220 BOOLs of which the last hundred do."""
    numbers = [scan if number % 2 else 7 for number in range(30)]
    bools = [number >= 120 and scan > number for number in range(220)]
    return pack("<30i220?", *numbers, *bools)


def test_of_many_tags_those_that_change_are_drawn_as_far_as_there_is_room(tmp_path: Path) -> None:
    path = record(tmp_path / "many.mcap", tags=MANY, values=many)
    made = chart(path)
    panel = made.panels[-1]
    assert [name for name, _ in panel.curves] == [f"N{number}" for number in range(1, 16, 2)]
    assert [lane.name for lane in panel.lanes] == [f"B{number}" for number in range(120, 144)]
    assert (made.left_out, panel.about, panel.unchanged) == (250 - 32, "32 of 250 tags", [])
    with pytest.raises(ValueError, match=r"\*: 250 tags; a chart shows 200 at most"):
        chart(path, "*")
    result = CliRunner().invoke(build(), ["plot", str(path), "--out", str(tmp_path / "a.html")])
    assert result.stderr == "218 recorded tags are not drawn; choose with --tag\n"
    chosen = CliRunner().invoke(
        build(), ["plot", str(path), "--tag", "B20?", "--out", str(tmp_path / "b.html")]
    )
    assert chosen.stderr == "240 recorded tags are not drawn; choose with --tag\n"


def test_a_rack_of_nothing_but_tags_is_drawn(tmp_path: Path) -> None:
    path = record(tmp_path / "toy.mcap", TOY)
    assert [panel.name for panel in chart(path).panels] == ["program"]


def page_data(path: Path, target: Path) -> Any:
    with open_trace(path) as opened:
        save_page(opened, target)
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', target.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def unpacked(curve: Any) -> np.ndarray:
    values = np.frombuffer(
        zlib.decompress(base64.b64decode(curve["curve"])), curve["kind"].lower().removeprefix("big")
    )
    return np.cumsum(values) if curve["differences"] else values


def test_the_page_has_every_value_exactly(trace: Path, tmp_path: Path) -> None:
    panel = page_data(trace, tmp_path / "a.html")["panels"][1]
    curves = {each["name"]: each for each in panel["curves"]}
    kinds = {name: (curve["kind"], curve["differences"]) for name, curve in curves.items()}
    assert kinds == {"Big": ("BigInt64", True), "Fill.ACC": ("Float64", True), "Level": ("Float32", False)}
    assert unpacked(curves["Big"]).tolist() == [2**40 + scan for scan in range(SCANS)]
    assert unpacked(curves["Fill.ACC"]).tolist() == [-scan for scan in range(SCANS)]
    assert unpacked(curves["Level"])[[0, 1, 8]].tolist() == [0.25, 0.75, 4.25]
    assert panel["bands"][0] == {
        "name": "Step",
        "rows": [0, 100, 200],
        "values": [0, 1, 2],
        "texts": ["IDLE", "FILL", "HOLD"],
    }
    assert panel["unchanged"] == [["Auto", "on"], ["Fill.PRE", "500"]]


@pytest.mark.slow
@pytest.mark.extra("plot")
def test_a_picture_names_steps_and_what_does_not_change(trace: Path, tmp_path: Path) -> None:
    save_figure(chart(trace), tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    for says in ("IDLE", "FILL", "HOLD", "oil, hot", "Fill.ACC", "program  8 tags", "Auto on   Fill.PRE 500"):
        assert f">{says}<" in text
