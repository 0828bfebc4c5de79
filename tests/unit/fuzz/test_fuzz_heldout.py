"""Programs with one planted mistake each, and one without: what is said of them must be so."""

from __future__ import annotations

from operator import attrgetter

import pytest
from scanrack.io_images.amci3601 import (
    Configuration,
    Direction,
    FindHome,
    Idle,
    InputBit,
    Manual,
    ResetErrors,
    StatusView,
)
from scanrack.jobs import Kind, LostSteps, SwitchOffset, possible_kinds
from scanrack.jobs.fuzz import STANDARD, Press, Scenario, TrialBench, eventually, never, search, undisturbed
from scanrack.runtime import FaultKind, InjectedFault, RackSpec

MS = 1_000_000
USED = InputBit.EXTERNAL | InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
IDLE, RESET = Idle().to_image(), ResetErrors().to_image()
JOG = Manual(Direction.CW, 400).to_image()
SEARCH = FindHome(Direction.CW, speed=4000, acceleration=50, deceleration=50).to_image()
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": "amci3601"}]})
SCANS = 250


class Careful:
    """It configures its module whenever that is needed, resets errors, and jogs while a button is pressed."""

    def __init__(self):
        self.pressed = False

    def __call__(self, scan):
        self.status, self.out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
        at = self.status
        if not at.MODULE_OK:
            self.out.load(IDLE)
        elif at.CONFIG_ERROR and not at.MODE_CONFIG:
            self.out.load(WORDS)
        elif at.MODE_CONFIG:
            self.out.load(WORDS if at.CONFIG_ERROR else IDLE)
        elif at.COMMAND_ERROR or at.INPUT_ERROR:
            self.out.load(RESET if not self.out[0] & 0x0400 else IDLE)
        else:
            self.work(scan)

    def work(self, scan):
        self.out.load(JOG if self.status.IN_EXTERNAL and not self.status.IN_CW_LIMIT else IDLE)


class CountsPresses(Careful):
    """It never forgets presses of one button, and fails when another is pressed after two of them."""

    def __init__(self):
        super().__init__()
        self.count = 0

    def work(self, scan):
        pressed = bool(self.status.IN_HOME)
        self.count += pressed and not self.pressed
        self.pressed = pressed
        assert self.count < 2 or not self.status.IN_EXTERNAL
        self.out.load(IDLE)


class GoesOnAfterTheKey(Careful):
    """It takes the first scan after program mode for one like any other, and divides by the scans since."""

    def __init__(self):
        super().__init__()
        self.last = -1

    def work(self, scan):
        assert self.last < 0 or scan.number - self.last < 5
        self.last = scan.number
        self.out.load(IDLE)


class HomesTwice(Careful):
    """A button pressed during the search starts a jog beside it."""

    def work(self, scan):
        self.out.load(SEARCH if self.status.IN_CCW_LIMIT else IDLE)
        if self.status.IN_EXTERNAL:
            self.out[0] |= 0x0080


@eventually("100 ms", after=lambda now: now.slot[1].status.IN_EXTERNAL and not now.slot[1].status.IN_CW_LIMIT)
def acts(now):
    """A press of the button is answered within 100 ms, or over."""
    at = now.slot[1].status
    free = not (at.IN_ESTOP or at.IN_CCW_LIMIT or at.INPUT_ERROR or at.COMMAND_ERROR) and at.MODULE_OK
    return not at.IN_EXTERNAL or at.IN_CW_LIMIT or not free or now.slot[1].motions or at.CONFIG_ERROR


@never
def jogs_while_the_logic_rests(now):
    """Nothing is commanded while the CPU is in program mode."""
    return now.mode == "program" and now.slot[1].motions


def reported(program, invariants, kinds, *, examples=30, start=0):
    bench = TrialBench(SPEC, program, invariants, SCANS)
    return search(bench, kinds, examples=examples, start=start).found


@pytest.mark.parametrize("kind", sorted(possible_kinds(SPEC) - {Kind.TORN}, key=attrgetter("value")))
def test_a_careful_program_raises_no_alarm(kind):
    assert not reported(Careful, [acts, jogs_while_the_logic_rests, STANDARD["one-motion"]], {kind})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "invariants", "kind", "parts"),
    [
        (CountsPresses, (), Kind.INPUTS, 3),  # two of one button, one of another
        (GoesOnAfterTheKey, (), Kind.MODE, 1),
        (HomesTwice, (STANDARD["one-motion"],), Kind.INPUTS, 2),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_planted_mistake_is_found_and_takes_no_more_than_it_takes(program, invariants, kind, parts):
    searches = (reported(program, invariants, {kind}, start=start) for start in range(20))
    found = next(filter(None, searches))
    assert {each.scenario.size for each in found} == {parts}


def button(bit, at_ms, for_ms=150):
    return Press(1, bit, True, at_ms * MS, for_ms * MS)


@pytest.mark.slow
def test_of_a_base_of_eleven_parts_two_are_left():
    """Whatever base is varied: two buttons held together are all that it takes."""
    base = Scenario(
        presses=(
            *(button(InputBit.HOME, 20 * n, 7) for n in range(5)),
            button(InputBit.EXTERNAL, 160),
            button(InputBit.CCW_LIMIT, 200),
        ),
        incidents=(
            InjectedFault(30 * MS, FaultKind.PROGRAM_MODE, 0, 10 * MS),
            InjectedFault(60 * MS, FaultKind.POWER_CYCLE, 1),
        ),
        shifts=(SwitchOffset(1, 10),),
        lost=(LostSteps(1, 500, 5),),
    )
    assert base.size == 11
    bench = TrialBench(SPEC, HomesTwice, [STANDARD["one-motion"]], SCANS)
    for found in (
        undisturbed(bench, base),
        search(bench, {Kind.FIRMWARE}, base=base, examples=40).found,
    ):
        assert found
        for each in found:
            assert {press.input for press in each.scenario.presses} == {InputBit.EXTERNAL, InputBit.CCW_LIMIT}
            assert each.scenario.size == 2


def test_seven_presses_of_a_recording_become_three():
    base = Scenario(
        presses=(
            *(button(InputBit.HOME, 40 + 60 * n, 20) for n in range(6)),
            button(InputBit.EXTERNAL, 390),
        )
    )
    (found,) = undisturbed(TrialBench(SPEC, CountsPresses, (), SCANS), base)
    assert sorted(press.input for press in found.scenario.presses) == [
        InputBit.EXTERNAL,
        InputBit.HOME,
        InputBit.HOME,
    ]
