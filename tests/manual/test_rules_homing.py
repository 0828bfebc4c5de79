"""Find Home: the four kinds, from every start, to the end where everything is zero [chapter 4].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up, 0.4 s and 1200 steps down. A home switch 3000 steps
away is reached 0.2 s + 2400 steps at 5000/s = 680 ms after the start.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from bench3601 import ABSOLUTE, CAPTURE, DIAGNOSTIC, ENCODER
from homing3601 import (
    HOME_SWITCH,
    HOME_SWITCH_PROXIMITY,
    MARKER_HOME_SWITCH,
    MARKER_PROXIMITY,
    PROXIMITY,
    ROUND_THE_SWITCH,
    Search,
)
from scanrack.runtime.machine import EncoderSpec

EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])
BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])


def markers(direction: int, *at: int) -> EncoderSpec:
    """An encoder of one count a step with a Z pulse at `at` steps ahead, and then every 4000."""
    return EncoderSpec(Fraction(1), marker_every=4000, marker_at=direction * at[0])


# -- home switch alone


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HMG-01", "HMG-03", "HMG-08", "STS-M04")
def test_home_switch_alone_to_the_step_and_the_tick(direction, scan_ms):
    search = Search(direction, home=(3000, 3500), scan_ms=scan_ms)
    search.command()
    start_ms = search.bench.now_ns / 1e6
    assert search.course(4_000) == ROUND_THE_SWITCH
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}
    # Found at 680 ms, stopped at 4200 and 1080 ms. Back: 600 steps in 200 ms, then 601 steps at
    # 5000/s to 2999, where the switch is off again: 1400.2 ms, seen at the tick 1400.25 ms, a
    # quarter of a step further. Three quarters on to a whole step, 0.15 ms, and 1200 steps down:
    # 1798 at 1800.4 ms; from the tick 1800.5 ms on 1202 steps at 1000/s to 3000: 3002.5 ms.
    assert search.shaft == 3000
    assert 0 < search.bench.now_ns / 1e6 - start_ms - 3_002.5 <= scan_ms


@EITHER_WAY
@pytest.mark.rules("HMG-08")
@pytest.mark.parametrize("last", [3000, 3009, 3700, 4199, 4200, 4201, 6000])
def test_home_is_the_edge_met_at_starting_speed_however_wide_the_switch(direction, last):
    """The first stop ends at 4200: behind a narrow switch, or still on a wide one."""
    search = Search(direction, home=(3000, last))
    search.command()
    assert search.course(9_000) == ROUND_THE_SWITCH
    assert (search.shaft, search.bench.position) == (3000, 0)


@EITHER_WAY
@pytest.mark.rules("HMG-08", "HMG-04")
def test_the_whole_search_at_the_starting_speed_needs_no_ramps(direction):
    """A step a ms, the switch after 100 of them: its tick is that of a whole step, the stop takes no time."""
    search = Search(direction, home=(100, 150))
    search.command(speed=1000)
    assert search.course(1_000) == ["ahead", "back", "ahead", "still"]
    assert search.shaft == 100


@EITHER_WAY
@pytest.mark.rules("HMG-12")
@pytest.mark.parametrize("kind", [HOME_SWITCH, MARKER_HOME_SWITCH])
def test_a_search_that_starts_on_the_switch_first_leaves_it_backwards(direction, kind):
    search = Search(direction, kind, home=(-100, 50), encoder=markers(direction, 30))
    search.command()
    assert search.turns(9_000) == ["back", "ahead", "still"]
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}
    assert search.shaft == {HOME_SWITCH: -100, MARKER_HOME_SWITCH: 30}[kind]


@pytest.mark.rules("HMG-01")
@pytest.mark.parametrize(("pause_ms", "still"), [(0, 0), (2000, 2), (1, 2)])
def test_a_pause_at_each_reversal_can_be_chosen(pause_ms, still):
    """Reading A-72b: none as a rule; the two reversals are at 1080 ms and, without pauses, 1800.4 ms."""
    search = Search(home=(3000, 3500), home_reversal_dwell_ms=pause_ms)
    search.command()
    start_ms = search.bench.now_ns / 1e6
    course = search.course(9_000)
    assert (course.count("still") - 1, [each for each in course if each != "still"]) == (
        still,
        ROUND_THE_SWITCH[:-1],
    )
    # Found at 3002.5 ms without pauses; each begins with the tick after a stop.
    assert search.bench.now_ns / 1e6 - start_ms == 3_002.75 + still * pause_ms
    assert search.shaft == 3000


# -- backplane proximity with the home switch


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HMG-01", "HMG-09", "HMG-16", "HMG-18", "CFG-31", "LSW-12")
def test_proximity_bit_slows_down_and_the_next_home_edge_is_home(direction, scan_ms):
    search = Search(direction, HOME_SWITCH_PROXIMITY, home=(6000, 6500), scan_ms=scan_ms)
    search.command(ms=1_000)
    assert search.position == 600 + 4000
    search.proximity(True).run(400)  # 1200 steps down to 1000/s
    assert search.position == 5800
    assert search.course(1_000) == ["ahead", "still"]
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}
    assert search.shaft == 6000  # 200 steps at 1000/s later, without a ramp


@EITHER_WAY
@pytest.mark.rules("HMG-02", "HMG-18", "CFG-31")
def test_home_edges_before_the_proximity_bit_are_ignored(direction):
    search = Search(direction, HOME_SWITCH_PROXIMITY)
    search.command(ms=400)
    for level in (1, 0, 1):
        search.bench.inputs(home=level).run(50)
    assert search.motion == "ahead"
    search.proximity(True).run(1_000)  # the switch is on, but does not come on
    assert search.motion == "ahead"
    search.bench.inputs(home=0).run(5)
    assert search.motion == "ahead"
    search.bench.inputs(home=1).run(0.5)
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}


@pytest.mark.rules("HMG-18")
def test_a_home_edge_in_the_tick_of_the_proximity_bit_came_before_it():
    search = Search(kind=HOME_SWITCH_PROXIMITY)
    search.command(ms=400)
    search.proximity(True).inputs(home=1).run(1_000)
    assert search.motion == "ahead"


@pytest.mark.rules("HMG-18")
def test_a_home_edge_in_the_ramp_counts_and_the_proximity_bit_may_go_off():
    """Reading A-75."""
    search = Search(kind=HOME_SWITCH_PROXIMITY)
    search.command(ms=400)
    search.proximity(True).run(10)
    search.proximity(False).run(50)
    assert search.motion == "ahead down"
    position = search.position
    search.bench.inputs(home=1).run(0.25)
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}
    assert search.bench.position == 0
    assert search.shaft == position


@EITHER_WAY
@pytest.mark.rules("HMG-12", "HMG-18")
@pytest.mark.parametrize("kind", [HOME_SWITCH_PROXIMITY, MARKER_PROXIMITY])
def test_a_proximity_bit_that_is_set_at_the_start_is_left_backwards(direction, kind):
    """Only its next change from 0 to 1 lets home be found [chapter 3, bit 6; reading A-75]."""
    search = Search(direction, kind)
    search.command(lsw=PROXIMITY, ms=400)
    assert search.motion == "back"
    search.bench.inputs(home=1).run(5).inputs(home=0).run(5).marker_in(1).run(5)
    assert search.motion == "back"
    search.proximity(False).run(500)
    assert search.motion == "ahead"
    search.bench.inputs(home=1).run(5).inputs(home=0).run(5).marker_in(1).run(5)
    assert search.motion == "ahead"
    search.proximity(True).run(5)
    search.bench.inputs(home=1).marker_in(1).run(2)
    assert "AT_HOME" in search.bench.bits


@EITHER_WAY
@pytest.mark.rules("HMG-12", "HMG-18")
def test_backplane_homing_that_starts_on_the_home_switch(direction):
    """Reading A-76: back until the bit, not the switch, has been on and off again."""
    search = Search(direction, HOME_SWITCH_PROXIMITY, home=(-50, 100))
    search.command(ms=1_000)
    assert (search.motion, search.position) == ("back", -4600)
    search.proximity(True).run(10)
    assert search.motion == "back"
    search.proximity(False).run(500)
    assert search.motion == "ahead"
    search.proximity(True)
    search.course(9_000)
    assert search.shaft == -50


# -- marker


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("HMG-01", "HMG-02", "HMG-10")
def test_home_switch_slows_down_and_the_next_marker_of_the_shaft_is_home(direction, scan_ms):
    """Z pulses at 700, 4700, ... steps, the switch at 3000: down to 1000/s at 4200, home at 4700."""
    spec = markers(direction, 700)
    search = Search(direction, MARKER_HOME_SWITCH, home=(3000, 3500), encoder=spec, scan_ms=scan_ms)
    search.command()
    start_ms = search.bench.now_ns / 1e6
    assert search.course(4_000) == ["ahead up", "ahead", "ahead down", "ahead", "still"]
    assert search.bench.bits == {"MODULE_OK", "AT_HOME"}
    assert search.shaft == 4700
    assert 0 < search.bench.now_ns / 1e6 - start_ms - (680 + 400 + 500) <= scan_ms


@EITHER_WAY
@pytest.mark.rules("HMG-10", "HMG-12")
def test_a_switch_that_is_on_when_the_axis_creeps_is_the_proximity(direction):
    """On at the start, left going back, and on again in the ramp: the next marker is home."""
    search = Search(direction, MARKER_HOME_SWITCH)
    search.bench.inputs(home=1).run(1)
    search.command(ms=400)
    search.bench.inputs(home=0).marker_in(460).run(200)
    search.bench.inputs(home=1).run(250)  # 400 ms down from 5000/s
    assert search.motion == "ahead"
    search.bench.run(15)
    assert (search.motion, search.bench.bits) == ("still", {"MODULE_OK", "AT_HOME", "IN_HOME"})


@EITHER_WAY
@pytest.mark.rules("HMG-10")
def test_a_marker_in_the_ramp_counts(direction):
    """Z pulse at 3300, 300 steps after the switch: v*v = 25e6 - 2*10,000*300, 4359/s; a tick is 1.1 steps."""
    search = Search(direction, MARKER_HOME_SWITCH, home=(3000, 3500), encoder=markers(direction, 3300))
    search.command()
    assert search.course(4_000) == ["ahead up", "ahead", "ahead down", "still"]
    assert search.shaft in (3300, 3301)


@EITHER_WAY
@pytest.mark.rules("HMG-01", "HMG-02", "HMG-11", "HMG-16")
def test_proximity_bit_slows_down_and_the_next_marker_is_home(direction):
    search = Search(direction, MARKER_PROXIMITY)
    search.command(ms=400)
    search.bench.inputs(home=1).run(1).marker_in(5).run(10)  # no input, and too early
    assert search.motion == "ahead"
    search.proximity(True).run(500)  # 0.4 s down
    assert (search.motion, search.bench.bits & {"AT_HOME", "IN_HOME"}) == ("ahead", set())
    search.bench.marker_in(1.1).run(1.25)
    assert (
        search.motion == "ahead"
    )  # the pulse is noticed at the tick 1.25 ms, whose effect is the next image's
    position = search.position
    search.bench.run(0.25)
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "HOME_PROX_ECHO"}
    assert (search.bench.position, search.shaft) == (0, position)


@pytest.mark.rules("HMG-11")
def test_a_marker_in_the_tick_of_the_proximity_bit_came_before_it():
    search = Search(kind=MARKER_PROXIMITY)
    search.command(ms=400)
    search.bench.marker_in(0.25).run(0.25)
    search.proximity(True).run(500)
    assert search.motion == "ahead"


# -- the end of it


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("HMG-03", "HMG-19", "CAP-04", "STS-M10", "STOP-06")
def test_position_encoder_and_capture_are_zero_with_at_home_in_one_update(direction, scan_ms):
    """Reading A-77. The position counts up to 3000 or more, so no word is 0 before."""
    spec = EncoderSpec(Fraction(5, 2))
    search = Search(
        direction, home=(3000, 3500), add=CAPTURE | ENCODER, encoder=spec, start=1000, scan_ms=scan_ms
    )
    bench = search.bench
    search.command(ms=500)
    bench.inputs(capture=1).run(5).inputs(capture=0).run(5)
    while "AT_HOME" not in bench.bits:
        assert "POSITION_INVALID" in bench.bits
        assert bench.bits & {"MOVING_CW", "MOVING_CCW"}
        assert 0 not in (bench.position, bench.encoder, bench.captured)
        bench.scan()
    assert bench.words[2:] == [0] * 6
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}
    bench.idle(5).command(ABSOLUTE, 500).until("MOVE_COMPLETE")
    assert (bench.position, bench.encoder) == (500, _counts(spec, search.shaft, direction))
    assert "AT_HOME" not in bench.bits


def _counts(spec: EncoderSpec, shaft: int, direction: int) -> int:
    """Counts since home at 3000 steps ahead: whole counts of the shaft there are taken away."""
    del shaft
    home = 3000 * direction
    return int((home + 500) * spec.counts_per_step // 1) - int(home * spec.counts_per_step // 1)


@pytest.mark.rules("HMG-03")
@pytest.mark.parametrize("wired", [False, True])
def test_the_diagnostic_count_is_zero_too(wired):
    """Reading A-71."""
    search = Search(home=(3000, 3500), add=DIAGNOSTIC, diagnostic_wiring=wired)
    search.command().until("AT_HOME")
    assert search.bench.words[2:6] == [0] * 4
    search.bench.idle().relative(-70).until("MOVE_COMPLETE")
    assert search.bench.encoder == (-70 if wired else 0)


@pytest.mark.rules("HMG-19", "MOV-01")
def test_home_makes_absolute_moves_possible():
    search = Search(home=(3000, 3500))
    search.bench.command(ABSOLUTE, 100, ms=1)
    assert search.bench.fired == ["CMD-06"]
    search.bench.reset_errors()
    search.command().until("AT_HOME")
    search.bench.idle().command(ABSOLUTE, 100).until("MOVE_COMPLETE")
    assert (search.bench.position, search.shaft) == (100, 3100)
