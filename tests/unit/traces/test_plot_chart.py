"""What a timing chart shows: curves without lost peaks, lanes without lost pulses, labels, ticks."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_traces import A3601, PERIOD_NS, Event, idle, record
from scanrack.traces import SlotInfo, open_trace
from scanrack.traces.plot import Chart, Curve, Envelope, NothingToPlotError, read_chart, save_figure
from scanrack.traces.plot import envelope as envelope_module
from scanrack.traces.plot.labels import GAP, placed
from scanrack.traces.plot.lanes import RAMP_STATES, Lane, at_pixels
from scanrack.traces.plot.marks import Mark
from scanrack.traces.signals import Selection
from scanrack.traces.signals.stream import EmptySelectionError

MOVING_CW, ACCELERATING, DECELERATING, HOLD_STATE, COMMAND_ERROR = 1, 0x20, 0x40, 4, 0x1000
SCANS = 400


def story() -> np.ndarray:
    """A move of ten steps a scan from scan 100 to 200 with a ramp, and an error that lasts one scan."""
    words = idle(SCANS)
    words[99, 0] = 1  # ABSOLUTE_MOVE
    words[100:200, 8] |= MOVING_CW
    words[100:120, 8] |= ACCELERATING
    words[180:200, 8] |= DECELERATING
    words[200:210, 8] |= HOLD_STATE
    words[300, 8] |= COMMAND_ERROR
    position = np.clip(np.arange(SCANS) - 99, 0, 100) * 10
    position[350:] = 5  # a preset
    words[:, 10], words[:, 11] = position // 1000, position % 1000
    return words


EVENTS: dict[int, Event] = {
    99: ("/stimuli", {"slot": 1, "name": "capture", "energized": True, "text": "A button."}),
    300: ("/events", {"slot": 1, "kind": "rule", "name": "CMD-03", "text": "No.", "bits": ["COMMAND_ERROR"]}),
    301: ("/cpu", {"mode": "run"}),
    302: ("/indicators", {"slot": 1, "name": "lights", "text": "Off."}),
}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("plot") / "a.mcap", story(), events=EVENTS)


def chart(path: Path, selection: Selection = Selection()) -> Chart[Curve]:  # noqa: B008 - it is frozen
    with open_trace(path) as trace:
        return read_chart(trace, Envelope, selection)


def lane(chart: Chart[Curve], name: str) -> list[tuple[int, int]]:
    found = next(lane for lane in chart.panels[0].lanes if lane.name == name)
    return list(zip((found.time_ns // PERIOD_NS).tolist(), found.value.tolist(), strict=True))


def test_only_bits_that_change_have_a_lane_causes_first(path: Path) -> None:
    names = [lane.name for lane in chart(path).panels[0].lanes]
    moving = ["MOVING_CW", "HOLD_STATE", "ACCELERATING", "DECELERATING"]
    assert names == ["ABSOLUTE_MOVE", *moving, "COMMAND_ERROR"]


def test_a_lane_has_every_change(path: Path) -> None:
    assert lane(chart(path), "COMMAND_ERROR") == [(0, 0), (300, 1), (301, 0)]
    assert lane(chart(path), "ABSOLUTE_MOVE") == [(0, 0), (99, 1), (100, 0)]


def test_the_ramp_has_its_states_by_name(path: Path) -> None:
    ramp = chart(path).panels[0].ramp
    assert ramp is not None
    states = [RAMP_STATES[value] for value in ramp.value]
    expected = {0: "at rest", 100: "accelerating", 120: "constant speed", 180: "decelerating"}
    expected |= {200: "held", 210: "at rest"}
    assert dict(zip((ramp.time_ns // PERIOD_NS).tolist(), states, strict=True)) == expected


def test_the_speed_is_of_motion_only(path: Path) -> None:
    speed = chart(path).panels[0].curves[1][1].high
    assert speed[150] == 5000  # ten steps in 2 ms
    assert speed[105] == 5000  # from scan 100 to scan 110, 100 steps in 20 ms
    assert speed[99] == 2500  # 10 ms either way: the five scans from 100 on move, ten steps each
    assert not speed[215:].any()  # the preset in scan 350 is not a motion


def test_marks_are_of_what_no_lane_shows(path: Path) -> None:
    found = [(mark.time_ns // PERIOD_NS, mark.kind, mark.label) for mark in chart(path).panels[0].marks]
    assert found == [(99, "stimulus", "capture on"), (300, "rule", "CMD-03"), (301, "cpu", "run")]


def test_a_slice_knows_its_extent_and_its_marks(path: Path) -> None:
    part = chart(path, Selection(first=299, last=310))
    assert (part.first, part.last, part.scans) == (299, 310, 12)
    assert (part.start_ns, part.end_ns) == (299 * PERIOD_NS, 310 * PERIOD_NS)
    assert [mark.label for mark in part.panels[0].marks] == ["CMD-03", "run"]
    assert [lane.name for lane in part.panels[0].lanes] == ["COMMAND_ERROR"]


def test_an_empty_slice_says_what_there_is(path: Path) -> None:
    with pytest.raises(EmptySelectionError, match=r"scans from 400; it has scans 0 to 399, time 0 s"):
        chart(path, Selection(first=400))


def test_a_trace_without_scans_says_so(tmp_path: Path) -> None:
    with pytest.raises(EmptySelectionError, match=r"^the trace has no scans$"):
        chart(record(tmp_path / "empty.mcap", idle(0)))


def test_a_trace_without_a_3601_has_nothing_to_plot(tmp_path: Path) -> None:
    path = record(tmp_path / "toy.mcap", idle(3), [SlotInfo(5, "a toy")])
    with pytest.raises(
        NothingToPlotError, match=r"no card with names in the trace to plot \(slot 5: a toy\)"
    ):
        chart(path)


def test_a_slot_without_a_3601_is_refused(path: Path) -> None:
    refused = pytest.raises(NothingToPlotError, match="slot 2 has neither an amci3601")
    with open_trace(path) as trace, refused as error:
        read_chart(trace, Envelope, slots=[2])
    assert str(error.value).endswith("these slots do: 1")


# -- nothing is lost ----------------------------------------------------------------------------------


@given(
    st.lists(st.lists(st.integers(-9, 9) | st.none(), min_size=1, max_size=20), min_size=1, max_size=12),
    st.integers(1, 8),
)
def test_no_peak_is_lost_however_long_the_curve(blocks: list[list[int | None]], most: int) -> None:
    values = [np.nan if value is None else value for block in blocks for value in block]
    envelope = Envelope()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(envelope_module, "GROUPS_MAX", most)
        start = 0
        for block in blocks:
            column = np.array([np.nan if value is None else value for value in block], float)
            envelope.add(np.arange(start, start + len(block)), column)
            start += len(block)
    curve = envelope.curve()
    assert len(curve.time_ns) <= most + 1
    assert curve.time_ns[0] == 0
    ends = [*curve.time_ns[1:].tolist(), len(values)]
    for first, end, low, high in zip(curve.time_ns, ends, curve.low, curve.high, strict=True):
        have = [value for value in values[first:end] if not np.isnan(value)]
        assert (low, high) == (min(have), max(have)) if have else np.isnan(low)


@given(st.lists(st.integers(1, 300), max_size=60), st.integers(1, 40))
def test_no_pulse_is_lost_however_few_the_pixels(steps: list[int], pixels: int) -> None:
    times = np.cumsum([0, *steps])
    bit = Lane("A", "status", times, times, (np.arange(len(times)) % 2).astype(np.int8))
    end = int(times[-1]) + 1
    kept, values = at_pixels(bit, 0, end, pixels)
    full = set((times * pixels // end).tolist())
    assert set((kept * pixels // end).tolist()) == full  # every pixel with a change still has one
    for pixel in full:
        on = times[times * pixels // end == pixel]
        stay = kept[kept * pixels // end == pixel]
        assert (stay[0], stay[-1]) == (on[0], on[-1])  # and enters and leaves it as it did
    assert len(kept) <= 2 * pixels + 2
    assert values[0] == 0


# -- labels -------------------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.integers(0, 1000), st.sampled_from(["rule", "move"])), max_size=30))
def test_labels_do_not_overlap(given: list[tuple[int, str]]) -> None:
    marks = [Mark(time, 1, kind, "ABC", "") for time, kind in given]
    letter = 0.01
    spans: dict[int, list[float]] = {}
    for mark, row, before in placed(marks, 0, 1000, letter, 2):
        left = mark.time_ns / 1000 - 3 * letter * before
        assert 0 <= left <= 1 - 3 * letter + 1e-9
        spans.setdefault(row, []).append(left)
    for lefts in spans.values():
        distances = np.diff(sorted(lefts))
        assert (distances >= (3 + GAP) * letter - 1e-9).all()


def test_rules_get_their_label_before_moves() -> None:
    marks = [Mark(0, 1, "move", "m", ""), Mark(1, 1, "rule", "r", "")]
    assert [mark.label for mark, *_ in placed(marks, 0, 1000, 0.01, 1)] == ["r"]


def test_a_label_at_the_right_edge_is_before_its_mark() -> None:
    marks = [Mark(500, 1, "rule", "early", ""), Mark(1000, 1, "broken", "the failure", "")]
    assert [(mark.label, before) for mark, _, before in placed(marks, 0, 1000, 0.01, 1)] == [
        ("the failure", True),
        ("early", False),
    ]


# -- pictures -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.extra("plot")
def test_a_picture_names_what_it_shows_and_is_the_same_each_time(path: Path, tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        save_figure(chart(path), tmp_path / name)
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    for word in ("position, steps", "speed, steps/s", "ramp", "ABSOLUTE_MOVE", "COMMAND_ERROR", "CMD-03"):
        assert f">{word}<" in text
    assert "MODULE_OK" not in text  # it does not change
    assert re.search(r"machine time, s<", text)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.slow
@pytest.mark.extra("plot")
def test_two_slots_are_two_panels(tmp_path: Path) -> None:
    words = np.concatenate((story(), story()), axis=1)
    path = record(tmp_path / "two.mcap", words, [A3601, SlotInfo(3, "amci3601", "3.1")])
    both = chart(path)
    assert [panel.name for panel in both.panels] == ["slot 1", "slot 3"]
    save_figure(both, tmp_path / "two.png")
    assert (tmp_path / "two.png").read_bytes().startswith(b"\x89PNG")


def test_another_kind_of_picture_is_refused(path: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"a\.gif: the name must end in \.png or \.svg"):
        save_figure(chart(path), tmp_path / "a.gif")
