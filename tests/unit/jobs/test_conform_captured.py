"""Scenes that `scanrack conform --judge` finds in a recording with several configurations, or none.

Broken on purpose: levels by the configuration before, the configuration kept at a rest that shows its error,
a refused configuration taken for a beginning, a change of inputs dated by the read before it: each turns one
red.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import InputBit, StatusMsw
from scanrack.io_images.image import WORDS
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import KnownState, PlayedScene, Timing, Transmission
from scanrack.jobs.conform.paths.captured import scenes_in
from scanrack.jobs.replay.resumed import words_of
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

TIMING = Timing(scan_ns=0)
ACTIVE_HIGH = "words 843Fh 3Fh 0 500 for 20 ms\nzero for 20 ms\n"
ACTIVE_LOW = "words 843Fh 0 0 500 for 20 ms\nzero for 20 ms\n"
REFUSED = "words 843Fh 3Fh 0 0 for 20 ms\nzero for 40 ms\n"
MOVE = "RELATIVE_MOVE target 100 speed 2500 acceleration 20 deceleration 20 for 60 ms\nzero for 20 ms\n"
CONFIGURED = 12
"""A scan behind the first configuration; the words of that have the bits of inputs, too."""

ESTOP_AT_NS = 60_000_000
PRESSED = f"""
[slot.machine]
timeline = [{{ at_s = {ESTOP_AT_NS / 1e9}, input = "estop", for_ms = 20 }}]
"""


def recorded(folder: Path, steps: str, scans: int, machine: str = "") -> PackedTrace:
    (folder / "line.steps").write_text(steps, "utf-8")
    rack = folder / "rack.toml"
    slot = 'program = "line.steps"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    rack.write_text(slot + machine, "utf-8")
    with ExitStack() as ports:
        run = JobRun(load_job(str(rack)), ports, RunOptions(trace=folder / "run.mcap", handled=True))
        with run.cpu:
            run.cpu.run(scans)
    with open_trace(folder / "run.mcap") as trace:
        return PackedTrace.of(trace)


def explained(scenes: list[PlayedScene]) -> list[bool]:
    return [search(each.moments, Amci3601, TIMING).explains_all for each in scenes]


def operated(scenes: list[PlayedScene]) -> list[Transmission]:
    sent = [each for scene in scenes for each in scene.moments if isinstance(each, Transmission)]
    return [each for each in sent if each.words is None]


def later_images(recording: PackedTrace, rows: int) -> PackedTrace:
    """Return a recording whose input images are read some rows later."""
    columns = recording.columns
    words = columns.words.copy()
    words[rows:, WORDS:] = columns.words[: len(words) - rows, WORDS:]
    return PackedTrace(recording.slots, PackedScans.of(16, [columns._replace(words=words)]), ())


@pytest.mark.parametrize("late", [0, 1])
def test_a_second_configuration_replaces_the_levels_of_the_first(tmp_path: Path, late: int) -> None:
    """Open inputs show their bits if they are active low; no input is operated."""
    recording = later_images(recorded(tmp_path, ACTIVE_HIGH + ACTIVE_LOW, 60), late)
    found = scenes_in(recording, {}, 1, TIMING)
    assert len(found.scenes) == 2
    assert explained(found.scenes) == [True, True]
    assert operated(found.scenes) == []


def test_a_refused_configuration_begins_no_scene(tmp_path: Path) -> None:
    """Its images show the configuration before it, which a scene that begins there does not know."""
    for first in (ACTIVE_HIGH, ACTIVE_LOW):
        found = scenes_in(recorded(tmp_path, first + REFUSED + MOVE + ACTIVE_HIGH, 120), {}, 1, TIMING)
        assert explained(found.scenes) == [True, True]
        assert found.scenes[0].reads > 80
        assert operated(found.scenes) == []


def test_a_rest_that_shows_the_error_of_a_configuration_has_none(tmp_path: Path) -> None:
    """The recording begins with the last image of the refused configuration."""
    whole = recorded(tmp_path, ACTIVE_HIGH + REFUSED + MOVE, 120)
    images = [words_of(each) for each in whole.images((1, "in"))]
    refused = StatusMsw.CONFIG_ERROR | StatusMsw.MODE_CONFIG
    first = max(row for row, image in enumerate(images) if image[0] & refused == refused)
    columns = whole.columns.rows(first, len(images))
    late = PackedTrace(whole.slots, PackedScans.of(16, [columns]), ())
    found = scenes_in(late, {}, 1, TIMING, [0x843F, 0x3F, 0, 500, 0, 0, 0, 0])
    state = found.scenes[0].moments[0]
    assert isinstance(state, KnownState)
    assert state.configuration == (0,) * WORDS
    assert explained(found.scenes) == [True]


def test_an_input_may_have_changed_before_the_image_of_the_read_before(tmp_path: Path) -> None:
    """That image may be as old as the path's lag; the input did change in the window of each read."""
    recording = recorded(tmp_path, ACTIVE_HIGH, 60, PRESSED)
    late = Timing(rpi_ns=4_000_000, scan_ns=3_000_000)
    (scene,) = scenes_in(recording, {}, 1, late).scenes
    pressed, released = operated([scene])
    assert (pressed.inputs, released.inputs) == (InputBit.ESTOP, 0)
    times = recording.times
    images = [words_of(each) for each in recording.images((1, "in"))]
    shown = next(row for row in range(CONFIGURED, len(images)) if images[row][1] & InputBit.ESTOP)
    assert pressed.window.low_ns == times[shown - 1] - late.lag_ns
    assert pressed.window.low_ns + late.lag_ns <= ESTOP_AT_NS <= pressed.window.high_ns == times[shown]
