"""What an invariant sees of a scan beside images: the program's state, tags of programs, the shaft, rules."""

from pathlib import Path
from typing import Any

import pytest
from scanrack.io_images.amci3601 import Configuration, InputBit, Move, MoveKind, StatusView
from scanrack.jobs import LostSteps
from scanrack.jobs.fuzz import Scenario, TrialBench, never
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.runtime import FaultKind, InjectedFault, RackSpec

EXAMPLE = Path(__file__).parents[3] / "examples/l5x/packer.toml"
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": "amci3601"}]})
USED = InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
MOVE = Move(MoveKind.RELATIVE, 300, speed=5000, acceleration=100, deceleration=100).to_image()
FORBIDDEN = Move(MoveKind.ABSOLUTE, 300, speed=5000, acceleration=100, deceleration=100).to_image()


NOTHING = Scenario()


class Moves:
    """It configures the module and makes one move."""

    def __init__(self, move=MOVE):
        self.step, self.move = "configure", move

    def __call__(self, scan):
        if self.step == "configure":
            scan.slot[1].outputs.load(WORDS)
            if (
                StatusView(scan.slot[1].inputs).MODE_CONFIG
                and not StatusView(scan.slot[1].inputs).CONFIG_ERROR
            ):
                self.step = "move"
        else:
            scan.slot[1].outputs.load(self.move)


def seen(ask, logic=Moves, scenario=NOTHING, scans=200):
    """Return what a condition sees at the ends of all scans."""
    answers = []

    @never
    def watched(now):
        answers.append(ask(now))

    assert TrialBench(SPEC, logic, (watched,), scans).run(scenario).broken is None
    return answers


def test_the_state_of_a_program_is_that_of_the_object_that_runs():
    steps = seen(lambda now: now.state.step)
    assert steps[0] == "configure"
    assert steps[-1] == "move"


def test_globals_of_the_file_are_there_and_other_names_are_not():
    assert seen(lambda now: now.state.EXAMPLE, scans=1) == [EXAMPLE]
    with pytest.raises(ValueError, match=r"the program has no speed, only .*step"):
        seen(lambda now: now.state.speed)


def test_the_shaft_is_where_the_motor_is_and_lacks_what_it_has_lost():
    assert seen(lambda now: now.slot[1].shaft)[-1] == 300
    lost = Scenario(lost=(LostSteps(1, 100, 5),))
    assert seen(lambda now: now.slot[1].shaft, scenario=lost)[-1] == 295
    cut = Scenario(incidents=(InjectedFault(10_000_000, FaultKind.TORN_UPDATE, 1, 0, (1,)),))
    assert seen(lambda now: now.slot[1].shaft, scenario=cut)[-1] == 300, "inside of what incidents happen to"


def test_rules_are_those_of_the_scan():
    rules = seen(lambda now: tuple(now.rules), lambda: Moves(FORBIDDEN))
    assert len([each for each in rules if "CMD-06" in each]) == 1


@pytest.mark.slow
def test_tags_of_a_controllers_programs_have_the_name_of_the_program():
    bench = bench_of(Setup(str(EXAMPLE), (), (), 5, frozenset()))
    program: Any = bench.fresh_logic()
    tags = program.tags
    scoped = next(name for name in tags if name.startswith("\\"))
    assert tags[scoped] is not None
