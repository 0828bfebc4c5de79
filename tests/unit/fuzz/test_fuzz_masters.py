"""A master encoder that a scenario turns: a follower follows it, and the rack of a failure has it."""

from random import Random

import pytest
from scanrack.io_images.amci3601 import Configuration, Direction, Follower, InputBit, StatusView
from scanrack.jobs import Kind
from scanrack.jobs.fuzz import Scenario, TrialBench
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.invariants.invariants import never
from scanrack.jobs.fuzz.scenarios.rackdoc import rack_text
from scanrack.jobs.fuzz.scenarios.scenario import Turn
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.runtime import load_rack_file
from scanrack.runtime.machine import MasterTurn

MS = 1_000_000
RACK = """program = "none.py"
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
master_speed = 20000
turns = [{ at_ms = 500, counts = -1000, for_ms = 100 }]
"""
READY = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT,
    step_and_direction=True,
    quadrature_encoder=True,
    starting_speed=500,
).to_image()
FOLLOWS = Follower(Direction.CW, 1, 2).to_image()


def logic(scan):
    status = StatusView(scan.slot[1].inputs)
    scan.slot[1].outputs.load(READY if status.CONFIG_ERROR else FOLLOWS)


@never
def too_far(now):
    """The follower never makes 300 steps."""
    return now.slot[1].shaft >= 300


@pytest.fixture
def rack(tmp_path):
    file = tmp_path / "rack.toml"
    file.write_text(RACK, encoding="utf-8")
    return file


def trial(spec, scenario):
    return TrialBench(spec, lambda: logic, [too_far], 300).run(scenario)


def test_a_follower_makes_half_of_the_masters_counts(rack):
    spec = load_rack_file(rack).spec
    turn = Turn(1, 598, 100 * MS, 200 * MS)
    assert trial(spec, Scenario(turns=(turn,))).broken is None
    broken = trial(spec, Scenario(turns=(Turn(1, 600, 100 * MS, 200 * MS),))).broken
    assert 300 <= broken.now_ns // MS <= 304  # the last count comes at 300 ms
    assert described(Scenario(turns=(turn,))) == [
        "0.1 s: the master encoder of slot 1 counts up by 598 for 200 ms"
    ]


def test_the_rack_of_a_failure_has_the_turns_one_after_the_other(rack):
    spec, scenario = load_rack_file(rack).spec, Scenario(turns=(Turn(1, 600, 550 * MS, 200 * MS),))
    again = rack.with_name("again.toml")
    again.write_text(rack_text(rack, spec, scenario, 300, rack.parent), encoding="utf-8")
    expected = (MasterTurn(500 * MS, -1000, 100 * MS), MasterTurn(600 * MS, 600, 200 * MS))
    assert load_rack_file(again).spec.slot[0].machine.turns == expected
    assert scenario.laid_over(spec).slot[0].machine.turns == expected
    assert Scenario.from_json(scenario.to_json()) == scenario


def test_a_search_turns_a_master_as_fast_as_it_may(rack):
    spec = load_rack_file(rack).spec
    draws = Draws(spec, 300, [Kind.MACHINE], Random(1))
    drawn = [turn for _ in range(200) for turn in draws.scenario().turns]
    assert {turn.counts > 0 for turn in drawn} == {True, False}
    speeds = [abs(turn.counts) * 10**9 / turn.for_ns for turn in drawn]
    assert 19_000 < max(speeds) <= 20_000
    assert any(trial(spec, Scenario(turns=(turn,))).broken for turn in drawn[:20])


def test_without_a_master_none_turns(rack):
    spec = load_rack_file(rack).spec
    bare = spec.model_copy(
        update={"slot": (spec.slot[0].model_copy(update={"machine": type(spec.slot[0].machine)()}),)}
    )
    draws = Draws(bare, 300, list(Kind), Random(1))
    assert not any(draws.scenario().turns for _ in range(200))


def test_turns_at_once_are_refused(rack):
    rack.write_text(
        RACK.replace("turns = [", "turns = [{ at_ms = 450, counts = 1, for_ms = 51 }, "), encoding="utf-8"
    )
    with pytest.raises(ValueError, match="at_ns of 501000000 or more, the end of the last turn"):
        load_rack_file(rack)
