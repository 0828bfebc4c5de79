"""A failure of a program with sequences says where they waited, and is known by that."""

from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.jobs.fuzz import Press, Scenario, TrialBench, never
from scanrack.jobs.fuzz.nondeterminism import NondeterminismSources
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.sequences import Input, Logic, sequence
from scanrack.runtime import RackSpec

MS = 1_000_000
USED = InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": "amci3601"}]})
HERE = Path(__file__).name


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    start = Input("slot1.status.IN_CAPTURE")

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        await self.start.rises
        await self.axis.move_to(4000, speed=5000, acceleration=10, deceleration=10)  # the move

    @sequence
    async def other(self) -> None:
        await self.start.falls
        if self.axis.moving:
            raise ValueError("released")  # the fault


class Elsewhere(Logic):
    axis = Axis3601(7, Configuration(inputs_used=USED, starting_speed=500))


def line_of(text):
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if line.endswith(f"# {text}"))


@never
def moves(now):
    """It does not move."""
    return now.slot[1].status.moving


def scenario(released_ns=400 * MS):
    return Scenario(presses=(Press(1, InputBit.CAPTURE, True, 99 * MS, released_ns),))


def test_a_failure_says_where_the_sequences_waited():
    broken = TrialBench(SPEC, Line, [moves], 100).run(scenario()).broken
    assert broken is not None
    # pressed at 99 ms, so the scan at 100 ms sees it and sends the move
    wait = f"cycle waits at line {line_of('the move')} of {HERE} for axis.move_to(4000) since 0.1 s"
    assert wait in broken.shows
    assert broken.cause.startswith(f"cycle at {HERE}:{line_of('the move')} other at {HERE}:")


def test_a_fault_says_where_the_others_waited():
    broken = TrialBench(SPEC, Line, [], 200).run(scenario(200 * MS)).broken
    assert broken is not None
    assert broken.cause == f"{HERE}:{line_of('the fault')}"
    assert any(each.startswith(f"cycle waits at line {line_of('the move')}") for each in broken.shows)


def test_a_program_that_finds_no_place_in_the_rack_is_refused():
    with pytest.raises(ValueError, match="7"):
        TrialBench(SPEC, Elsewhere, [], 10).run(Scenario())


def test_a_failure_is_known_by_the_same_when_it_is_confirmed():
    """The run that confirms a failure looks at what the program uses; the logic is inside of that."""
    bench = TrialBench(SPEC, Line, (moves,), 300)
    scenario = Scenario(presses=(Press(1, InputBit.CAPTURE, True, 100 * MS, 20 * MS),))
    first, second = (
        bench.run(scenario).broken,
        NondeterminismSources().recording_bench(bench).run(scenario).broken,
    )
    assert first is not None
    assert second is not None
    assert first.key == second.key
    assert "cycle at" in first.key
