"""Find Home and the end limits: the two seconds, the reversal, both limits, the wrong one [chapter 4].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up, 0.4 s and 1200 steps down. What lies 3000 steps away is
reached 0.2 s + 2400 steps at 5000/s = 680 ms after the start.
"""

from __future__ import annotations

from collections.abc import Set
from fractions import Fraction

import pytest
from homing3601 import (
    HOME_SWITCH,
    HOME_SWITCH_PROXIMITY,
    KINDS,
    MARKER_HOME_SWITCH,
    MARKER_PROXIMITY,
    PROXIMITY,
    USE_LIMIT,
    Search,
)
from scanrack.runtime.machine import EncoderSpec

EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])
BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])

BOTH_LIMITS = ["HOM-04", "POS-05", "INP-04"]
WRONG_LIMIT = ["HOM-05", "POS-06", "INP-05"]
NO_HOME = {"MODULE_OK", "HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}
"""What is shown after either: no Command Error, no Invalid Profile, and Stopped is not for homing."""


def told(bits: Set[str]) -> set[str]:
    """The bits without those that echo inputs and the proximity bit."""
    return {name for name in bits if not name.startswith(("IN_", "HOME_PROX"))}


# -- the limit ahead


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HMG-07", "HMG-08")
def test_limit_ahead_cuts_the_motion_and_turns_it_round_after_two_seconds(direction, scan_ms):
    search = Search(direction, home=(-1500, -500), ahead=(3000, None), scan_ms=scan_ms)
    search.command(ms=680)
    assert (search.position, search.motion) == (3000, "ahead")
    search.bench.scan()
    assert told(search.bench.bits) == {"MODULE_OK", "POSITION_INVALID"}
    search.bench.run(2000 - scan_ms)
    assert (search.position, search.motion) == (3000, "still")  # 2680 ms: the tick that turns it round
    search.bench.scan()
    assert search.motion == "back up"
    # 2400 at 2880 ms; the switch is passed from -500 to -1501 at 3660.2 ms, seen at 3660.25 ms; down to
    # the whole step -2702 at 4060.4 ms; from the tick 4060.5 ms on 1202 steps at 1000/s: 5262.5 ms.
    start_ms = search.bench.now_ns / 1e6 - 2680 - scan_ms
    assert search.course(4_000) == ["back up", "back", "back down", "ahead", "still"]
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}
    assert (search.shaft, search.bench.fired) == (-1500, [])
    assert 0 < search.bench.now_ns / 1e6 - start_ms - 5_262.5 <= scan_ms


@pytest.mark.rules("HMG-07")
def test_nothing_shortens_the_two_seconds():
    """Words and inputs that change meanwhile, the limit itself among them."""
    search = Search()
    search.command(ms=400)
    search.bench.inputs(cw_limit=1).run(100)
    position = search.position
    for level in (1, 0):
        search.bench.idle(100).inputs(home=level, external=level, cw_limit=level).run(100)
        search.proximity(bool(level)).run(100)
    search.bench.run(1_300)  # 2000 ms in all
    assert (search.position, search.motion) == (position, "still")
    search.bench.run(0.25)
    assert search.motion == "back up"


@EITHER_WAY
@pytest.mark.rules("HMG-07", "HMG-09", "HMG-10", "HMG-11")
@pytest.mark.parametrize("kind", KINDS)
def test_after_the_limit_each_kind_searches_its_signal_again(direction, kind):
    """On and then off on the way back, on again at the starting speed: reading A-74."""
    spec = EncoderSpec(Fraction(1), marker_every=4000, marker_at=-1000 * direction)
    switch = (-1500, -500) if kind != MARKER_PROXIMITY else None
    search = Search(direction, kind, home=switch, ahead=(3000, None), encoder=spec)
    search.command(ms=2_680 + 900)
    assert (search.motion, search.position) == ("back", -1100)  # 600 steps in 200 ms, 3500 at 5000/s
    with_bit = kind in (HOME_SWITCH_PROXIMITY, MARKER_PROXIMITY)
    if with_bit:
        search.proximity(True).run(20)
        search.proximity(False)
    search.bench.run(500)
    assert search.motion == "ahead"  # from -2400 with the bit, from -2702 with the switch
    if with_bit:
        search.proximity(True)
    search.course(9_000)
    assert told(search.bench.bits) == {"MODULE_OK", "AT_HOME"}
    # The switch comes on at -1500; the Z pulses are at -5000 and -1000, the switch ahead of the latter.
    assert search.shaft == (-1000 if kind in (MARKER_HOME_SWITCH, MARKER_PROXIMITY) else -1500)


@EITHER_WAY
@pytest.mark.rules("HMG-07")
def test_limit_in_the_ramp_after_the_home_switch(direction):
    """The switch at 3000 asks for a stop at 4200, but the limit is at 3600."""
    search = Search(direction, home=(3000, 3500), ahead=(3600, None))
    search.command()
    course = search.course(9_000)
    assert course[:5] == ["ahead up", "ahead", "ahead down", "still", "back up"]
    assert search.shaft == 3000


@pytest.mark.rules("HMG-07")
def test_limit_while_the_signal_is_awaited_at_the_starting_speed():
    """With a proximity bit, before the home switch came; the bit has to come anew."""
    search = Search(kind=HOME_SWITCH_PROXIMITY, ahead=(6000, None))
    search.command(ms=1_000)
    search.proximity(True)
    assert search.course(1_000) == ["ahead down", "ahead", "still"]
    search.bench.run(1_900)  # turned round 1600 + 2000 ms after the start
    assert search.motion == "back"
    search.proximity(False).run(402)
    assert search.motion == "ahead"
    search.proximity(True).run(5)
    search.bench.inputs(home=1).run(1)
    assert "AT_HOME" in search.bench.bits


@pytest.mark.rules("HMG-07")
def test_limit_on_the_way_back_to_a_switch_that_comes_no_more():
    search = Search(ahead=(6000, None))
    search.command(ms=400)
    search.bench.inputs(home=1).run(900)
    search.bench.inputs(home=0).run(500)
    assert search.motion == "ahead"
    assert search.course(9_000)[:3] == ["ahead", "still", "back up"]
    assert search.bench.fired == []


@pytest.mark.rules("HMG-07")
def test_a_limit_that_is_not_configured_is_not_seen():
    search = Search(1, drop=USE_LIMIT[-1])
    search.command(ms=400)
    search.bench.inputs(ccw_limit=1).run(10)
    assert (search.motion, search.bench.fired) == ("ahead", [])
    search.bench.inputs(cw_limit=1).run(2_000.5)
    assert (search.motion, search.bench.fired) == ("back up", [])


# -- starting on a limit


@EITHER_WAY
@pytest.mark.rules("HMG-13", "HMG-15", "GEN-05")
@pytest.mark.parametrize("home", [(-1500, -500), (-1500, 100)], ids=["off the switch", "on the switch"])
def test_start_on_the_limit_ahead(direction, home):
    """Reading A-73: as if the limit had been reached, so no step is made for two seconds."""
    search = Search(direction, home=home, ahead=(-50, None))
    search.command(ms=2_000)
    assert (search.motion, search.position) == ("still", 0)
    assert search.course(9_000) == ["back up", "back", "back down", "ahead", "still"]
    assert told(search.bench.bits) == {"MODULE_OK", "AT_HOME"}
    assert (search.shaft, search.bench.fired) == (-1500, [])


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HMG-15", "GEN-05", "HMG-07")
@pytest.mark.parametrize("there", [3000, 0], ids=["ahead", "on it at the start"])
def test_an_end_limit_can_be_the_home_switch(direction, there, scan_ms):
    """One switch feeds both inputs: met as a limit, left, and met again as home and limit in one tick."""
    search = Search(direction, home=(there, None), ahead=(there, None), scan_ms=scan_ms)
    search.command(ms=500)
    course = search.course(9_000)
    assert (course[0] in ("ahead", "still"), course[-2:]) == (True, ["ahead", "still"])
    assert told(search.bench.bits) == {"MODULE_OK", "AT_HOME"}
    assert (search.shaft, search.bench.fired) == (there, [])


@EITHER_WAY
@pytest.mark.rules("HMG-14", "HMG-15", "GEN-05")
@pytest.mark.parametrize("ms_before", [0, 5])
def test_start_on_the_limit_behind_is_as_if_it_were_not_active(direction, ms_before):
    """Even if it became active in the tick of the command."""
    search = Search(direction)
    search.bench.inputs(**{search.behind: 1}).run(ms_before)
    search.command(ms=0.25)
    assert search.motion == "ahead up"
    search.bench.run(399.75).inputs(home=1).run(1_000)
    assert search.motion == "back"
    search.bench.inputs(home=0).run(500)
    assert search.motion == "ahead"
    search.bench.inputs(home=1).run(1)
    assert (told(search.bench.bits), search.bench.fired) == ({"MODULE_OK", "AT_HOME"}, [])


@EITHER_WAY
@pytest.mark.rules("HMG-12", "HMG-14")
def test_start_on_limit_behind_and_home_switch(direction):
    """The way off the switch leads into the limit: no step is made, the search has failed (reading A-106)."""
    search = Search(direction, home=(-10, 100), behind=(None, 50), valid=True)
    search.command(ms=500)
    assert search.bench.fired == ["HOM-05", "POS-06", "INP-05"]
    assert told(search.bench.bits) == {"MODULE_OK", "HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}
    assert search.shaft == 0


@EITHER_WAY
@pytest.mark.rules("HMG-14", "HOM-05", "POS-06", "INP-05")
def test_limit_behind_that_was_left_and_is_met_again_is_the_wrong_one(direction):
    search = Search(direction, home=(20, 80), behind=(None, 50))
    search.command()
    assert search.turns(9_000) == ["ahead", "back", "still"]
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, WRONG_LIMIT)


# -- both limits


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HOM-04", "POS-05", "INP-04")
def test_both_limits(direction, scan_ms):
    search = Search(direction, ahead=(3000, None), behind=(None, -2000), valid=True, scan_ms=scan_ms)
    search.command(ms=2_880)
    assert (search.position, told(search.bench.bits) & NO_HOME) == (2400, {"MODULE_OK"})
    search.bench.run(880)  # 4400 steps at 5000/s
    assert (search.motion, search.position, search.bench.fired) == ("back", -2000, [])
    search.bench.scan()
    assert told(search.bench.bits) == NO_HOME
    assert search.bench.fired == BOTH_LIMITS
    assert (search.position, search.shaft) == (-2000, -2000)
    search.bench.run(3_000)
    assert (search.motion, search.shaft) == ("still", -2000)


@pytest.mark.rules("HOM-04")
def test_the_limit_ahead_a_second_time():
    """After the reversal any limit ends the search, which would go back and forth for ever."""
    search = Search(ahead=(3000, None))
    search.command(ms=2_800)
    search.bench.inputs(home=1).run(10).inputs(home=0).run(402)
    assert search.motion == "ahead"
    search.course(9_000)
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, BOTH_LIMITS)
    assert search.shaft == 3000


@pytest.mark.rules("HOM-04")
def test_the_limit_ahead_while_it_is_being_left_may_bounce():
    search = Search()
    search.command(ms=400)
    search.bench.inputs(cw_limit=1).run(2_010)
    assert search.motion == "back up"
    search.bench.inputs(cw_limit=0).run(1).inputs(cw_limit=1).run(1).inputs(cw_limit=0).run(1)
    assert (search.motion, search.bench.fired) == ("back up", [])


@EITHER_WAY
@pytest.mark.rules("HMG-07", "HOM-04")
def test_both_limits_in_one_tick(direction):
    """The one ahead comes first: two seconds, and then the other one forbids the reversal."""
    search = Search(direction)
    search.command(ms=400)
    search.bench.inputs(cw_limit=1, ccw_limit=1).run(2_000)
    assert (search.motion, search.bench.fired) == ("still", [])
    search.bench.run(1)
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, BOTH_LIMITS)


@EITHER_WAY
@pytest.mark.rules("HOM-04")
@pytest.mark.parametrize("still_active", [False, True])
def test_limit_behind_during_the_two_seconds(direction, still_active):
    """It counts when the axis turns round, and then no step is made toward it."""
    search = Search(direction)
    search.bench.inputs(**{search.ahead: 1})
    search.command(ms=1_000)
    search.bench.inputs(**{search.behind: 1}).run(500)
    search.bench.inputs(**{search.behind: int(still_active)}).run(500)
    assert (search.motion, search.bench.fired) == ("still", [])
    search.bench.run(10)
    if still_active:
        assert (told(search.bench.bits), search.bench.fired, search.shaft) == (NO_HOME, BOTH_LIMITS, 0)
    else:
        assert (search.motion, search.bench.fired) == ("back up", [])


@pytest.mark.rules("HOM-04")
def test_limit_ahead_that_is_still_active_when_the_axis_returns():
    """The switch lies within the limit's range: no step is made toward the limit again."""
    search = Search(home=(-10, 100), ahead=(-3000, None))
    search.command(speed=1000, ms=2_000)
    assert search.course(9_000) == ["back", "still"]
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, BOTH_LIMITS)
    assert search.shaft == -11


# -- the wrong limit


@EITHER_WAY
@pytest.mark.rules("HOM-05", "POS-06", "INP-05")
@pytest.mark.parametrize(
    ("kind", "signals", "motion"),
    [
        pytest.param(HOME_SWITCH, [], "ahead", id="searching"),
        pytest.param(HOME_SWITCH, [(1, 100)], "ahead down", id="in the ramp after the switch"),
        pytest.param(HOME_SWITCH, [(1, 900)], "back", id="going back"),
        pytest.param(HOME_SWITCH, [(1, 900), (0, 100)], "back down", id="in the ramp after going back"),
        pytest.param(HOME_SWITCH, [(1, 900), (0, 500)], "ahead", id="approaching"),
        pytest.param(MARKER_HOME_SWITCH, [(1, 100)], "ahead down", id="slowing down"),
        pytest.param(MARKER_HOME_SWITCH, [(1, 900)], "ahead", id="waiting for the marker"),
    ],
)
def test_wrong_limit_first(direction, kind, signals, motion):
    search = Search(direction, kind, valid=True)
    search.command(ms=400)
    for level, ms in signals:
        search.bench.inputs(home=level).run(ms)
    assert (search.motion, search.bench.fired, search.bench.bits & NO_HOME) == (motion, [], {"MODULE_OK"})
    position = search.position
    search.bench.inputs(**{search.behind: 1}).run(0.25)
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, WRONG_LIMIT)
    search.bench.run(3_000)
    assert (search.motion, search.position) == ("still", position)


@pytest.mark.rules("HOM-05")
def test_wrong_limit_during_a_chosen_pause():
    search = Search(home_reversal_dwell_ms=500)
    search.command(ms=400)
    search.bench.inputs(home=1).run(500)
    assert search.motion == "still"
    search.bench.inputs(ccw_limit=1).run(0.25)
    assert (told(search.bench.bits), search.bench.fired) == (NO_HOME, WRONG_LIMIT)


# -- how the errors go off


@pytest.mark.rules("HOM-04", "HOM-05", "STS-M08", "STS-M11")
@pytest.mark.parametrize(
    ("msw", "left"),
    [
        pytest.param("reset", {"POSITION_INVALID"}, id="Reset Errors"),
        pytest.param("home", {"POSITION_INVALID"}, id="the next Find Home"),
        pytest.param("manual", {"POSITION_INVALID", "HOME_INVALID"}, id="another move"),
    ],
)
def test_a_failed_search_blocks_nothing(msw, left):
    """No Command Error is set; Input Error goes off with any move, Home Invalid with the next Find Home."""
    search = Search()
    search.command(ms=400)
    search.bench.inputs(ccw_limit=1).run(10).idle()
    assert told(search.bench.bits) == NO_HOME
    if msw == "reset":
        search.bench.reset_errors()
    elif msw == "home":
        search.command(ms=1)
    else:
        search.bench.manual(1, ms=1)
    assert told(search.bench.bits) - {"MODULE_OK", "MOVING_CW", "ACCELERATING"} == left


@pytest.mark.rules("HOM-04")
def test_the_proximity_bit_held_through_a_limit_is_left_backwards():
    search = Search(kind=MARKER_PROXIMITY)
    search.bench.inputs(cw_limit=1)
    search.command(lsw=PROXIMITY, ms=2_500)
    assert search.motion == "back"
    search.proximity(False).inputs(cw_limit=0).run(500)
    assert search.motion == "ahead"
