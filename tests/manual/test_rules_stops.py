"""Immediate Stop, emergency stop and end limits on the way [chapters 4 and 6].

What each of them does to each kind of motion stands in `test_stop_matrix`; here is the rest: when in
a motion it comes, what it needs to go on, and what happens together.
"""

from __future__ import annotations

import pytest
from bench3601 import HOLD, HOME_CW, IMMEDIATE_STOP, PRESET, RELATIVE, RESUME, Bench, configuration

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
CUT = {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
LIMITS = [("cw_limit", "IN_CW_LIMIT"), ("ccw_limit", "IN_CCW_LIMIT")]
CUTS = [
    pytest.param("immediate stop", set(), marks=pytest.mark.rules("IST-01")),
    pytest.param("estop", {"INPUT_ERROR", "IN_ESTOP"}, marks=pytest.mark.rules("EST-01")),
    pytest.param("cw_limit", {"INPUT_ERROR", "IN_CW_LIMIT"}, marks=pytest.mark.rules("LIM-01", "GEN-04")),
    pytest.param("ccw_limit", {"INPUT_ERROR", "IN_CCW_LIMIT"}, marks=pytest.mark.rules("LIM-01", "GEN-04")),
]


def strike(bench: Bench, cause: str) -> Bench:
    return bench.out(IMMEDIATE_STOP) if cause == "immediate stop" else bench.inputs(**{cause: 1})


def let_go(bench: Bench, cause: str) -> Bench:
    """The cause is over; its bits stay."""
    return bench.idle(2) if cause == "immediate stop" else bench.inputs(**{cause: 0}).idle(2)


def cut_at_1600(cause: str, **kwargs) -> Bench:
    """A relative move cut short by something that is over again."""
    bench = strike(Bench.ready(**kwargs).relative(10_000, ms=400), cause).scan()
    return let_go(bench, cause)


# -- at any point of a motion ---------------------------------------------------------------------

# a relative move of 10,000, of which the constant speed ends after 1840 ms at 8800
ON_THE_WAY = [
    pytest.param(2, 2, id="just started"),
    pytest.param(150, 375, id="accelerating"),  # 1000 t + 10,000 t^2
    pytest.param(1_840, 8_800, id="about to decelerate"),
    pytest.param(2_040, 9_600, id="decelerating"),  # 8800 + 5000 t - 5000 t^2
    pytest.param(2_238, 9_997, id="almost there"),  # 10,000 - (1000 t + 5000 t^2) for the last 2 ms
]


@EVERY_SCAN
@pytest.mark.parametrize(("ms", "position"), ON_THE_WAY)
@pytest.mark.parametrize(("cause", "added"), CUTS)
def test_a_cut_is_a_cut_wherever_the_move_is(cause, added, ms, position, scan_ms):
    bench = strike(Bench.ready(scan_ms=scan_ms).relative(10_000, ms=ms), cause).scan()
    assert (bench.position, bench.bits) == (position, CUT | added)
    assert bench.run(100).position == position


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS)
@pytest.mark.parametrize("by", ["hold", "external"])
def test_a_cut_ends_a_controlled_stop(by, cause, added, scan_ms):
    """Held at 1600 and 5000/s, cut 100 ms later: 450 of 1200 steps; nothing is left to resume."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400)
    bench.out(HOLD).run(100) if by == "hold" else bench.inputs(external=1).run(100)
    bench.inputs(external=0)
    strike(bench, cause).scan()
    assert (bench.position, bench.bits) == (2_050, CUT | added)
    let_go(bench, cause).command(RESUME).run(50)
    assert (bench.position, bench.fired[-1]) == (2_050, "CMD-08")


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS[:3])
@pytest.mark.rules("MAN-07", "MAN-08", "MAN-09")
def test_a_cut_ends_the_stop_of_a_manual_move(cause, added, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=400).idle(100)
    strike(bench, cause).scan()
    assert (bench.position, bench.bits) == (2_050, CUT | added)


# a switch closes at a step count; the module sees it at its next tick, 1.25 steps at most later
@EVERY_SCAN
@pytest.mark.parametrize(
    ("at", "position"),
    [
        pytest.param(3_000, 3_000, id="on a tick"),  # 600 + 480 ms * 5
        pytest.param(3_001, 3_001, id="0.05 ms before a tick"),  # 680.2 ms
        pytest.param(3_003, 3_003, id="0.15 ms before a tick"),  # 680.6 ms
        pytest.param(3_006, 3_006, id="0.05 ms before the next"),  # 681.2 ms
        pytest.param(3_009, 3_010, id="0.2 ms before a tick"),  # 681.8 ms, seen at 682 ms: 3010
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.rules("LIM-01", "GEN-04", "INP-02", "POS-04", "STOP-04")
def test_an_end_limit_switch_on_the_way(at, position, sign, scan_ms):
    name, bit = LIMITS[0 if sign > 0 else 1]
    machine = {name: (at, None) if sign > 0 else (None, -at)}
    bench = Bench.ready(scan_ms=scan_ms, machine=machine).relative(sign * 10_000)
    bench.until("STOPPED")
    assert (bench.position, bench.bits) == (sign * position, CUT | {"INPUT_ERROR", bit})
    assert bench.fired == ["INP-02", "POS-04"]


# -- what is possible afterwards ------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS)
@pytest.mark.rules("IST-03", "EST-03", "STS-M10")
def test_after_a_cut_an_absolute_move_needs_a_preset(cause, added, scan_ms):
    bench = cut_at_1600(cause, scan_ms=scan_ms)
    bench.fired.clear()
    bench.absolute(0, ms=20)
    assert (bench.position, bench.fired) == (1_600, ["CMD-06"])
    bench.idle().reset_errors()
    assert bench.bits == CUT
    bench.out(PRESET, 0, 1, 600).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "STOPPED"}
    bench.absolute(0).until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "MOVE_COMPLETE"})


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS)
@pytest.mark.rules("IST-03", "EST-03", "STS-M10")
def test_after_a_cut_homing_makes_the_position_valid(cause, added, scan_ms):
    bench = cut_at_1600(cause, scan_ms=scan_ms, machine={"home": (3_000, 3_500)})
    bench.command(HOME_CW).until("AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS)
@pytest.mark.rules("IST-03", "EST-03", "MOV-06", "STS-M11")
def test_after_a_cut_relative_and_manual_moves_are_possible(cause, added, scan_ms):
    """They clear Stopped and Input Error, and leave the position invalid."""
    bench = cut_at_1600(cause, scan_ms=scan_ms)
    bench.relative(-600).scan()
    assert bench.bits == {"MODULE_OK", "MOVING_CCW", "ACCELERATING", "POSITION_INVALID"}
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (1_000, {"MODULE_OK", "MOVE_COMPLETE", "POSITION_INVALID"})
    bench.manual(ms=200).idle(400)
    assert (bench.position, bench.bits) == (2_800, CUT)


@EVERY_SCAN
@pytest.mark.parametrize("words", [(0x0800,), (RELATIVE, 0, 0, 5, 5, 0, 20, 10), (0x0400, 0, 1)])
@pytest.mark.rules("POS-02", "STS-M10")
def test_only_preset_and_homing_make_the_position_valid(words, scan_ms):
    bench = Bench.ready(config=configuration(add=0x0100), scan_ms=scan_ms).relative(10_000, ms=400)
    bench.out(IMMEDIATE_STOP).run(20).out(*words).run(50)
    assert "POSITION_INVALID" in bench.bits
    assert "COMMAND_ERROR" not in bench.bits


# -- Immediate Stop and errors --------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("IST-06", "STS-M12", "RST-01")
def test_immediate_stop_is_not_accepted_under_a_command_error(scan_ms):
    """It works again after Reset Errors, which leaves the move alone (reading A-85)."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400)
    bench.idle(scan_ms).relative(1, ms=scan_ms)
    bench.fired.clear()
    bench.out(IMMEDIATE_STOP).run(100)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}, [])
    bench.out(0x0800).run(20)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    here = bench.position
    bench.out(IMMEDIATE_STOP).run(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (here, CUT, ["POS-02"])


@EVERY_SCAN
@pytest.mark.parametrize(
    ("name", "added", "fired"),
    [
        pytest.param("estop", CUT | {"INPUT_ERROR", "IN_ESTOP"}, ["INP-01", "POS-03"], id="estop"),
        pytest.param("cw_limit", CUT | {"INPUT_ERROR", "IN_CW_LIMIT"}, ["INP-02", "POS-04"], id="cw limit"),
        pytest.param("external", {"MODULE_OK", "HOLD_STATE", "IN_EXTERNAL"}, [], id="external"),
    ],
)
@pytest.mark.rules("EST-01", "LIM-01", "EXT-02", "RST-03")
def test_inputs_stop_a_move_under_a_command_error(name, added, fired, scan_ms):
    """And the error stays."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400)
    bench.idle(scan_ms).relative(1, ms=scan_ms)
    bench.fired.clear()
    bench.inputs(**{name: 1}).run(500)
    assert (bench.bits, bench.fired) == (added | {"COMMAND_ERROR"}, fired)
    before = bench.position
    bench.idle(20).relative(100, ms=100)  # not accepted
    assert (bench.position, bench.bits, bench.fired) == (before, added | {"COMMAND_ERROR"}, fired)


# -- two things at once ---------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("EST-01", "INP-01", "POS-03")
def test_the_emergency_stop_comes_before_an_end_limit(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, ms=400).inputs(estop=1, cw_limit=1).scan()
    assert bench.fired == ["INP-01", "POS-03"]
    assert bench.bits == CUT | {"INPUT_ERROR", "IN_ESTOP", "IN_CW_LIMIT"}


@EVERY_SCAN
@pytest.mark.parametrize("cause", ["immediate stop", "estop", "cw_limit"])
@pytest.mark.rules("IST-01", "EST-01", "LIM-01")
def test_a_cut_comes_before_the_external_input(cause, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, ms=400).inputs(external=1)
    strike(bench, cause).run(500)
    assert bench.position == 1_600
    assert {"STOPPED", "POSITION_INVALID"} <= bench.bits
    assert "HOLD_STATE" not in bench.bits


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "added"), CUTS)
def test_a_cause_that_comes_as_the_move_ends_is_too_late(cause, added, scan_ms):
    """2240 ms: the move is complete; a scan earlier it is not."""
    bench = strike(Bench.ready(scan_ms=scan_ms).relative(10_000, ms=2_240), cause).scan()
    late = {"MODULE_OK", "MOVE_COMPLETE"} | (added if cause == "estop" else added - {"INPUT_ERROR"})
    assert (bench.position, bench.bits) == (10_000, late)
    bench = strike(Bench.ready(scan_ms=scan_ms).relative(10_000, ms=2_240 - scan_ms), cause).scan()
    assert bench.bits == CUT | added


@pytest.mark.parametrize("scan_ms", [0.25, 2, 100])
@pytest.mark.parametrize(
    ("name", "late"), [("cw_limit", {"IN_CW_LIMIT"}), ("estop", {"IN_ESTOP", "INPUT_ERROR"})]
)
@pytest.mark.rules("MC-01", "EST-02", "POS-03", "POS-04")
def test_a_switch_at_the_target_is_too_late_one_before_it_is_not(name, late, scan_ms):
    """The last step, at 2240 ms, is a tick, too: the move is complete when the switch is looked at."""
    bench = Bench.ready(scan_ms=scan_ms, machine={name: (10_000, None)}).relative(10_000)
    bench.until("MOVE_COMPLETE")
    assert (bench.scan().position, bench.bits) == (10_000, {"MODULE_OK", "MOVE_COMPLETE"} | late)
    bench = Bench.ready(scan_ms=scan_ms, machine={name: (9_999, None)}).relative(10_000)
    bench.until("STOPPED")
    assert (bench.position, bench.bits) == (9_999, CUT | late | {"INPUT_ERROR"})


@EVERY_SCAN
@pytest.mark.parametrize("name", ["estop", "cw_limit", "ccw_limit", "external"])
@pytest.mark.rules("CFG-20")
def test_an_input_that_is_not_configured_stops_nothing(name, scan_ms):
    unused = {"estop": 0x08, "cw_limit": 0x10, "ccw_limit": 0x20, "external": 0x02}[name]
    bench = Bench.ready(config=configuration(drop=unused), scan_ms=scan_ms).relative(10_000, ms=400)
    bench.inputs(**{name: 1}).run(100)
    assert (bench.position, bench.bits) == (2_100, {"MODULE_OK", "MOVING_CW"})
