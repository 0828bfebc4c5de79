"""`scanrack conform` on synthetic reads: a simulated module and controller, on a virtual clock."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path

import pytest
from conform_scenes import MOVE, STOPPED_MOVE, played
from scanrack.io_images.amci3601 import RULES
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.conform.branch import explained
from scanrack.jobs.conform.findings import ConformVerdict
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import (
    Moment,
    SeenImage,
    Timing,
    Transmission,
    Window,
    from_rows,
    to_rows,
)
from scanrack.jobs.conform.paths.captured import scenes_of
from scanrack.jobs.conform.plan import BUILT_IN, load_plan, parse_plan
from scanrack.jobs.conform.report import lines
from scanrack.jobs.conform.rules_apart.rivals import RIVALS
from scanrack.jobs.conform.rules_apart.without import STATEMENTS, without
from scanrack.jobs.conform.verdicts import Judge
from scanrack.runtime.modules.amci3601.altered import Alteration
from scanrack.runtime.modules.amci3601.module import Amci3601


def judged(steps: str, alteration: Alteration | None = None) -> Judge:
    scene, timing = played(steps, alteration)
    judge = Judge("4.1", timing)
    judge.judge(scene)
    return judge


@pytest.mark.parametrize("seed", range(5))
def test_an_unchanged_module_is_explained_under_every_jitter(seed: int) -> None:
    scene, timing = played(STOPPED_MOVE, seed=seed)
    found = search(scene.moments, Amci3601, timing)
    assert found.explains_all
    assert found.reads > 20
    assert "POS-02" in found.fired


def test_a_configuration_that_is_requested_during_a_move_is_explained() -> None:
    asked = f"RELATIVE_MOVE {MOVE} for 60 ms\nwords 843Ch 3Ch 0 500 until MODE_CONFIG\nsame for 40 ms"
    scene, timing = played(f"{asked}\nzero for 60 ms")
    assert search(scene.moments, Amci3601, timing).explains_all


def test_an_acceleration_of_4_for_5_is_told() -> None:
    weaker = Alteration("weaker", hears=lambda words: (*words[:6], min(words[6], 4), words[7]))
    move = "RELATIVE_MOVE target 300 speed 2500 acceleration 5 deceleration 5"
    scene, timing = played(f"{move} until MOVE_COMPLETE\nzero for 40 ms", weaker)
    found = search(scene.moments, Amci3601, timing)
    assert found.unexplained is not None


@pytest.mark.slow
def test_a_rule_is_as_the_manual_if_a_module_without_it_is_contradicted() -> None:
    judge = judged(STOPPED_MOVE)
    rules = judge.result.rules
    assert {rules[each].verdict for each in ("STOP-03", "IST-01", "STS-M03", "MOV-08")} == {
        ConformVerdict.AS_MANUAL
    }
    assert judge.result.readings["A-02"].verdict is ConformVerdict.AS_MANUAL
    assert rules["CMD-03"].verdict is ConformVerdict.NOT_IN_PLAN
    assert rules["CMD-03"].why == "it did not fire in any scene"
    assert rules["MOV-09"].verdict is ConformVerdict.NOT_IN_PLAN
    assert judge.result.readings["A-102"].verdict is ConformVerdict.OPEN


@pytest.mark.slow
def test_a_reading_that_the_module_takes_otherwise_is_named() -> None:
    rival = RIVALS["A-102"][0]
    again = "words 843Ch 3Ch 0 500 for 60 ms\nzero for 60 ms"
    judge = judged(f"{STOPPED_MOVE}\n{again}", rival)
    (scene,) = judge.result.scenes
    assert (scene.verdict, scene.readings) == (ConformVerdict.DIFFERS, ["A-102"])
    assert judge.result.readings["A-102"].verdict is ConformVerdict.DIFFERS


@pytest.mark.slow
def test_a_bit_that_is_never_set_differs_by_its_rules() -> None:
    judge = judged(STOPPED_MOVE, STATEMENTS["STS-M03"])
    (scene,) = judge.result.scenes
    assert scene.difference is not None
    assert scene.difference.sent[0] == 16
    assert "STS-M03" in scene.rules
    assert not [each for each in judge.result.rules.values() if each.verdict is ConformVerdict.AS_MANUAL]


@pytest.mark.slow
def test_rules_that_a_plan_does_not_touch_are_apart_from_open_ones() -> None:
    """STOP-03 fires when the move is stopped; a plan without a stop does not touch it."""
    still, timing = played("zero for 40 ms")
    judge = Judge("4.1", timing)
    judge.judge(still)
    rules = judge.result.rules
    assert rules["STOP-03"].verdict is ConformVerdict.NOT_IN_PLAN
    stopped, _ = played(STOPPED_MOVE, STATEMENTS["STS-M03"])
    judge.judge(stopped)
    assert judge.result.scenes[1].verdict is ConformVerdict.DIFFERS
    assert rules["STOP-03"].verdict is not ConformVerdict.NOT_IN_PLAN
    assert rules["CMD-03"].verdict is ConformVerdict.NOT_IN_PLAN
    said = list(lines(judge.result, 0))
    counts = [line for line in said if line.startswith("rules: ")]
    assert "not in this plan" in counts[0]


def test_a_trace_is_taken_in_scenes_from_configuration_to_configuration(tmp_path: Path) -> None:
    steps = f"words 843Ch 3Ch 0 500 for 20 ms\nzero for 20 ms\nRELATIVE_MOVE {MOVE} until MOVE_COMPLETE\n"
    (tmp_path / "twice.steps").write_text(steps + steps, "utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text('program = "twice.steps"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', "utf-8")
    job = load_job(str(rack))
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(trace=tmp_path / "run.mcap", handled=True))
        with run.cpu:
            run.cpu.run(400)
    firmware, scenes, notes, _ = scenes_of(tmp_path / "run.mcap", 1, Timing(scan_ns=0))
    assert (firmware, len(scenes), notes) == ("4.1", 2, [])
    found = [search(each.moments, Amci3601, Timing(scan_ns=0)) for each in scenes]
    assert [each.explains_all for each in found] == [True, True]
    assert sum(each.reads for each in found) > 300
    with pytest.raises(ValueError, match="slot 2 has no words of a 3601"):
        scenes_of(tmp_path / "run.mcap", 2, Timing())


def test_a_read_is_explained_by_pairs_of_words() -> None:
    early, late = (1, 0, 0, 998, 0, 0, 0, 0), (1, 0, 1, 4, 0, 0, 0, 0)
    assert explained([early, late], (1, 0, 1, 1, 0, 0, 0, 0))
    assert not explained([early, late], (1, 0, 1, 5, 0, 0, 0, 0))
    assert explained([early, late], (1, 0, 1, 5, 0, 0, 0, 0), play=1)
    assert not explained([early, late], (1, 1, 1, 1, 0, 0, 0, 0))


def test_parameters_go_out_before_their_command_bit() -> None:
    scene, timing = played(STOPPED_MOVE)
    sent = [each for each in scene.moments if isinstance(each, Transmission)]
    words = [each.words for each in sent]
    command = words.index((2, 0, 0, 300, 2, 500, 20, 20))
    assert words[command - 1] == (0, 0, 0, 300, 2, 500, 20, 20)
    assert sent[command].window.low_ns - sent[command - 1].window.high_ns >= 2 * timing.lag_ns


def test_moments_survive_a_file() -> None:
    moments: list[Moment] = [
        Transmission(Window(1, 2), (0,) * 8),
        Transmission(Window(3, 3), None, 5),
        SeenImage(Window(4, 9), (-1,) * 8),
    ]
    assert from_rows(json.loads(json.dumps(to_rows(moments)))) == moments
    for row in (["read", 2, 1, *[0] * 8], ["read", 1, 2, *[40_000] * 8], ["write", 1], 5, ["x", 1, 2]):
        with pytest.raises(ValueError, match="moment 0"):
            from_rows([row])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[[scene]]\nname = 'x'\nsteps = 'zero for 1 ms'",
            "the first words must be zero, and the second a configuration",
        ),
        ("[[scene]]\nname = 'x'\nsteps = 'HOLD for 1 ms'", "line 1: HOLD is not a command bit"),
        ("[[scene]]\nname = 'x'\nsteps = 'zero'", "has no end"),
        (
            "[[scene]]\nname = 'x'\nsteps = 'inputs STOP for 5 ms'",
            "invalid step 'inputs STOP for 5 ms'; must be inputs CAPTURE",
        ),
        ("[[scene]]\nname = 'x'\nneeds = ['luck']\nsteps = 'zero for 1 ms'", "needs 'luck'"),
        ("color = 'red'\n[[scene]]\nname = 'x'\nsteps = ''", "color"),
    ],
)
def test_a_plan_that_can_not_be_used_is_refused_by_scene_and_line(text: str, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        parse_plan(text, "p.toml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a." * 16 + "a = 1", "p.toml:1: a name of more than 16 parts"),
        ("\na = " + "[" * 33, "p.toml:2: brackets that are nested deeper than 32"),
        ("a = ", "p.toml: Invalid value"),
    ],
)
def test_a_plan_has_the_limits_of_other_texts(text: str, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        parse_plan(text, "p.toml")


def test_a_plan_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_bytes(b"\xff")
    with pytest.raises(ValueError, match=r"p\.toml: it is not text in UTF-8: invalid start byte"):
        load_plan(str(tmp_path / "p.toml"))


@pytest.mark.parametrize("name", BUILT_IN)
def test_readings_of_the_built_in_plans_are_there(name: str) -> None:
    page = (Path(__file__).parents[3] / "docs" / "readings.md").read_text("utf-8")
    for scene in load_plan(name).scenes:
        for number in scene.settles:
            assert f"**{number} " in page, (scene.name, number)


def test_tables_name_rules_and_readings_that_exist() -> None:
    page = (Path(__file__).parents[3] / "docs" / "readings.md").read_text("utf-8")
    unknown = [each for each in STATEMENTS if each not in RULES and not each.startswith("STS-")]
    assert unknown == []
    assert [number for number in RIVALS if f"**{number} " not in page] == []


def test_every_rival_reading_has_a_scene_that_settles_it() -> None:
    settled = {number for scene in load_plan("hour").scenes for number in scene.settles}
    assert set(RIVALS) - settled == {"A-13", "A-78"}  # wired inputs that are not used; program mode


def test_a_rule_is_left_out_with_the_others_of_its_cause() -> None:
    silent = without("CFG-06", {"CFG-06", "CER-02"})
    assert silent is not None
    assert silent.silent == {"CFG-06", "CER-02"}
    speed = without("CMD-05", {"CMD-05", "PRF-01"})
    assert speed is not None
    assert speed.silent == {"CMD-05"}
