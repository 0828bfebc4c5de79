"""Scenes of `scanrack conform` that stay open, and the reason of each."""

from __future__ import annotations

from dataclasses import replace

import pytest
from conform_scenes import MOVE, MS, STOPPED_MOVE, plan_of, played
from scanrack.jobs.conform.findings import ConformVerdict, SceneVerdict
from scanrack.jobs.conform.moments import Moment, PlayedScene, SeenImage, Timing, Transmission, Window
from scanrack.jobs.conform.playing import play
from scanrack.jobs.conform.verdicts import Judge
from scanrack.runtime.modules.amci3601.module import Amci3601
from simulated_path import SimulatedPath

CONFIGURATION = (-31684, 60, 0, 500, 0, 0, 0, 0)
MOVING = (2, 0, 0, 300, 2, 500, 20, 20)
STOPPING = (16, 0, 0, 300, 2, 500, 20, 20)


def judged(scene: PlayedScene, timing: Timing, most: int = 4000) -> SceneVerdict:
    return Judge("4.1", timing, most).judge(scene)


@pytest.mark.parametrize(
    ("scan_ms", "advice"),
    [
        (2, "use a counter of scans, see --print-counter"),
        (0, "wait longer at rest before"),
    ],
)
def test_too_many_hypotheses_are_told_with_their_words(scan_ms: int, advice: str) -> None:
    """The limit is such that the move alone passes, and Immediate Stop while it moves does not."""
    plan = plan_of(STOPPED_MOVE)
    timing = replace(plan.timing, scan_ns=scan_ms * MS)
    scene = play(plan.scenes[0], SimulatedPath(Amci3601(), timing), plan)
    sent = [each for each in scene.moments if isinstance(each, Transmission)]
    stop = next(each for each in sent if each.words == STOPPING)
    width_ns = max(each.window.high_ns - each.window.low_ns + timing.lag_ns for each in sent)
    found = judged(scene, timing, most=width_ns // (MS // 2) + 1)
    at_ns = stop.window.low_ns - scene.moments[0].window.low_ns
    assert found.verdict is ConformVerdict.OPEN
    assert f"after {at_ns / 1e9:.3f} s, with the words 0010h 0000h 0 300 2 500 20 20, which" in found.why
    assert "it is change 2 since the axis was at rest" in found.why
    assert advice in found.why


@pytest.mark.slow
def test_a_step_that_never_ends_stops_the_axis_and_leaves_the_scene_open() -> None:
    plan = plan_of("MANUAL_CW speed 1000 acceleration 5 deceleration 5 until AT_HOME")
    module = Amci3601()
    scene = play(plan.scenes[0], SimulatedPath(module, plan.timing), replace(plan, limit_ns=100 * MS))
    assert module.under_way is None
    found = judged(scene, plan.timing)
    assert (found.verdict, found.why) == (ConformVerdict.OPEN, "a step took longer than 100 ms (line 1)")
    assert found.reads > 20


def test_a_scene_without_a_read_is_open() -> None:
    moments: list[Moment] = [
        Transmission(Window(0, MS), (0,) * 8),
        SeenImage(Window(MS, 2 * MS), (0,) * 8),
        Transmission(Window(2 * MS, 3 * MS), CONFIGURATION),
    ]
    found = judged(PlayedScene("short", moments), Timing())
    assert (found.verdict, found.why) == (ConformVerdict.OPEN, "no read after its configuration")


def test_words_that_go_back_in_time_leave_the_scene_open() -> None:
    scene, timing = played(f"RELATIVE_MOVE {MOVE} for 80 ms")
    place = next(
        at for at, each in enumerate(scene.moments) if isinstance(each, Transmission) and each.words == MOVING
    )
    scene.moments[place] = Transmission(Window(0, MS), MOVING)
    found = judged(scene, timing)
    assert found.verdict is ConformVerdict.OPEN
    assert found.why.startswith("the words 0002h 0000h 0 300 2 500 20 20 can't have acted after")
