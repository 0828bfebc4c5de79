"""`scanrack conform` fits factors of acceleration, deceleration and speed.

The deviation is planted in the planner of moves, which the fitted models do not use.
Broken on purpose: the bound at the last factor that explains, the scaled axis without a factor, a fit of one
read fewer: each turns it red.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import replace
from fractions import Fraction
from typing import Any
from unittest import mock

import pytest
from conform_scenes import MS, plan_of
from scanrack.jobs.conform.findings import ConformVerdict, SceneVerdict
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import PlayedScene, Timing
from scanrack.jobs.conform.playing import play
from scanrack.jobs.conform.report import factor_sentences, lines
from scanrack.jobs.conform.rules_apart.scales import SCALED, FittedScale, fitted, without_lesser
from scanrack.jobs.conform.rules_apart.without import STATEMENTS
from scanrack.jobs.conform.verdicts import Judge
from scanrack.runtime.modules.amci3601 import step_generator
from scanrack.runtime.modules.amci3601.altered import Altered3601
from scanrack.runtime.modules.amci3601.module import Amci3601
from simulated_path import SimulatedPath

STEPS = """
RELATIVE_MOVE target 1500 speed 2500 acceleration 5 deceleration 4 until MOVE_COMPLETE
zero for 60 ms
"""
PLANTED = [
    ("acceleration", "1.05"),
    ("deceleration", "0.93"),
    ("speed", "0.98"),
]


def planted(what: str, factor: str) -> AbstractContextManager[Any]:
    """Return a planner of moves that is off by a factor."""
    right = step_generator.plan_move

    def plan(now_ns: int, origin: int, distance: int, profile: Any) -> Any:
        names = {
            "acceleration": ["acceleration_spmss"],
            "deceleration": ["deceleration_spmss"],
            "speed": ["speed_sps"],
        }[what]
        off = {name: getattr(profile, name) * Fraction(factor) for name in names}
        off = {name: int(each) if name == "speed_sps" else each for name, each in off.items()}
        return right(now_ns, origin, distance, replace(profile, **off))

    return mock.patch.object(step_generator, "plan_move", plan)


def moved(module: Amci3601, seed: int = 0) -> tuple[PlayedScene, Timing]:
    plan = plan_of(STEPS)
    return play(plan.scenes[0], SimulatedPath(module, plan.timing, seed, (MS, 3 * MS)), plan), plan.timing


def fitted_to(scene: PlayedScene, timing: Timing) -> list[FittedScale]:
    return list(fitted(lambda each: search(scene.moments, lambda: Altered3601(each), timing)))


@pytest.mark.slow
@pytest.mark.parametrize(("what", "factor"), PLANTED)
def test_a_factor_is_told_within_its_uncertainty(what: str, factor: str) -> None:
    with planted(what, factor):
        scene, timing = moved(Amci3601())
    (found,) = fitted_to(scene, timing)
    assert found.what == what
    assert found.low < float(factor) < found.high
    assert found.high - found.low < 0.06


@pytest.mark.slow
def test_a_scene_that_a_factor_explains_differs_by_the_rule_of_the_factor() -> None:
    with planted("acceleration", "0.93"):
        scene, timing = moved(Amci3601())
    judge = Judge("4.1", timing)
    verdict = judge.judge(scene)
    assert verdict.verdict is ConformVerdict.DIFFERS
    assert [each.what for each in verdict.scales] == ["acceleration"]
    assert verdict.scales[0].low < 0.93 < verdict.scales[0].high
    rule = judge.conclude().rules[SCALED["acceleration"].rule]
    assert (rule.verdict, rule.why) == (ConformVerdict.DIFFERS, verdict.scales[0].sentence)
    assert f"    explained by another scale: {verdict.scales[0].sentence}" in lines(judge.result, 0)


@pytest.mark.slow
def test_a_module_that_is_off_otherwise_has_no_factor() -> None:
    """Its S-curves are ramps of constant acceleration."""
    plan = plan_of(STEPS.replace("RELATIVE_MOVE", "RELATIVE_MOVE S_CURVE"))
    module = Altered3601(STATEMENTS["PRO-05"])
    scene = play(plan.scenes[0], SimulatedPath(module, plan.timing), plan)
    assert search(scene.moments, Amci3601, plan.timing).unexplained is not None
    assert fitted_to(scene, plan.timing) == []


def test_factors_of_two_scenes_leave_what_both_allow() -> None:
    wide, narrow = FittedScale("speed", 0.9, 0.95), FittedScale("speed", 0.94, 0.99)
    assert wide.within(narrow) == FittedScale("speed", 0.94, 0.95)
    assert wide.within(FittedScale("speed", 0.96, 0.99)) is None
    assert wide.within(FittedScale("rates", 0.94, 0.99)) is None


ACCELERATION, SPEED = FittedScale("acceleration", 0.92, 0.94), FittedScale("speed", 0.94, 0.96)
DECELERATION = FittedScale("deceleration", 0.9, 0.95)
EITHER = (
    "It accelerates at 0.930 ± 0.010 of the programmed rate, "
    "or it runs at 0.950 ± 0.010 of the programmed speed."
)


def concluded(*scenes: list[FittedScale]) -> Judge:
    judge = Judge("4.1", Timing())
    judge.result.scenes += [
        SceneVerdict(str(number), ConformVerdict.DIFFERS, 5, 9, scales=scales)
        for number, scales in enumerate(scenes)
    ]
    judge.conclude()
    return judge


def test_a_kind_that_explains_fewer_scenes_than_another_is_no_fact() -> None:
    result = concluded([ACCELERATION], [ACCELERATION, SPEED], []).result
    assert [each.scales for each in result.scenes] == [[ACCELERATION], [ACCELERATION], []]
    assert result.rules["PRO-03"].why == ACCELERATION.sentence
    assert result.rules["PRO-01"].verdict is ConformVerdict.NOT_IN_PLAN
    assert factor_sentences(result) == [ACCELERATION.sentence]


def test_kinds_that_no_scene_tells_apart_are_joined() -> None:
    result = concluded([ACCELERATION, SPEED], [ACCELERATION, SPEED]).result
    assert {result.rules[each].why for each in ("PRO-01", "PRO-03")} == {EITHER}
    assert f"    explained by another scale: {EITHER}" in lines(result, 0)
    assert factor_sentences(result) == [EITHER]


def test_kinds_with_a_scene_of_their_own_are_both_left() -> None:
    scenes = [[ACCELERATION], [DECELERATION], [ACCELERATION, DECELERATION]]
    assert without_lesser(scenes) == scenes
