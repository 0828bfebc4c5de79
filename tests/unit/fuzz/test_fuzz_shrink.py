"""Delta debugging: no part can go, and no number can be rounder; whatever the failure was found in."""

from __future__ import annotations

import pytest
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import LostSteps, SwitchOffset
from scanrack.jobs.fuzz import BrokenInvariant, Counterexample, Press, Scenario
from scanrack.jobs.fuzz.shrink import digits, parts_of, rounder, scenario_of, simpler_parts, smallest
from scanrack.runtime import FaultKind, InjectedFault

MS = 1_000_000
SCAN_NS = 2 * MS
BROKEN = BrokenInvariant("it", "It holds.", 1, SCAN_NS, "it does not")
BUTTONS = {1: tuple(InputBit)}


def press(bit, at_ms, for_ms=100):
    return Press(1, bit, True, at_ms * MS, for_ms * MS)


def shrunk(scenario, condition):
    return smallest(scenario, BROKEN, lambda each: BROKEN if condition(each) else None, BUTTONS)[0]


def at(scenario, bit):
    return next((each.at_ns for each in scenario.presses if each.input is bit), None)


def test_of_eleven_parts_the_two_that_suffice_are_left():
    base = Scenario(
        firmware=((1, "3.1"),),
        presses=tuple(press(bit, 100 * n) for n, bit in enumerate(InputBit)),
        incidents=(
            InjectedFault(300 * MS, FaultKind.POWER_CYCLE, 1),
            InjectedFault(500 * MS, FaultKind.LINK_LOST, 1),
        ),
        shifts=(SwitchOffset(1, 200),),
        lost=(LostSteps(1, 4000, 5),),
    )
    assert base.size == 11
    left = shrunk(base, lambda each: each.lost and any(one.input is InputBit.ESTOP for one in each.presses))
    assert left == Scenario(presses=(Press(1, InputBit.ESTOP, True, 0, SCAN_NS),), lost=(LostSteps(1, 0, 1),))


def test_of_seven_presses_of_a_recording_the_second_and_the_sixth_are_left_in_their_order():
    base = Scenario(presses=tuple(press(InputBit.HOME, 173 + 101 * n, 37) for n in range(7)))
    wanted = base.presses[1].at_ns, base.presses[5].at_ns

    def breaks(scenario):
        times = [each.at_ns for each in scenario.presses]
        return any(abs(time_ns - wanted[0]) < 20 * MS for time_ns in times) and any(
            time_ns >= wanted[1] for time_ns in times
        )

    left = shrunk(base, breaks)
    # 274 ms: of the round times within 20 ms (260 to 290) the least; 678 ms or later: 700 ms
    assert sorted(each.at_ns // MS for each in left.presses) == [260, 700]


@pytest.mark.parametrize(
    ("least_ms", "becomes_ms"), [(0, 0), (150, 200), (160, 200), (1234, 2000), (2, 2), (44, 50)]
)
def test_a_time_becomes_round(least_ms, becomes_ms):
    base = Scenario(presses=(press(InputBit.HOME, 1766),))
    left = shrunk(base, lambda each: each.presses and each.presses[0].at_ns >= least_ms * MS)
    assert left.presses[0].at_ns == becomes_ms * MS


def test_what_is_left_can_not_be_made_simpler():
    base = Scenario(
        firmware=((1, "2.1"),),
        presses=(press(InputBit.CW_LIMIT, 1766, 2000), press(InputBit.ESTOP, 862, 500)),
        incidents=(InjectedFault(318 * MS, FaultKind.TORN_UPDATE, 1, 0, (1, 3, 6)),),
    )

    def breaks(scenario):
        """Whether a limit comes at least 700 ms after the torn update of word 3, on old firmware."""
        torn = [each.at_ns for each in scenario.incidents if 3 in each.late_words]
        late = [each.at_ns for each in scenario.presses if each.input >= InputBit.ESTOP]
        return (
            dict(scenario.firmware).get(1, "4.1") < "3.1" and torn and max(late, default=0) > min(torn) + 7e8
        )

    left = shrunk(base, breaks)
    parts = parts_of(left)
    for place, (field, part) in enumerate(parts):
        assert not breaks(scenario_of([*parts[:place], *parts[place + 1 :]]))
        for simpler in simpler_parts(part, BUTTONS, SCAN_NS):
            assert not breaks(scenario_of([*parts[:place], (field, simpler), *parts[place + 1 :]]))
    assert left.firmware == ((1, "2.2"),)  # the newest that does
    assert [each.input for each in left.presses] == [InputBit.ESTOP]  # the simplest that does
    assert [each.late_words for each in left.incidents] == [(3,)]


def test_numbers_that_are_tried_are_rounder():
    for number in (*range(-300, 300), 1_766_000_000, 12_345):
        for each in rounder(number):
            assert (digits(each), abs(each)) < (digits(number), abs(number))
            assert each * number >= 0


def test_the_same_failure_is_meant_by_its_key():
    """A scenario that breaks something else does not count."""
    found = Counterexample(Scenario(presses=(press(InputBit.HOME, 100),)), BROKEN, 1)
    assert smallest(found.scenario, BROKEN, lambda _scenario: None) == (found.scenario, BROKEN)
