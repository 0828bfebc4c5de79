"""Find Home: which words are refused, and what comes between a search and its end [chapters 4 and 6]."""

from __future__ import annotations

import pytest
from bench3601 import HOLD, HOME_CCW, HOME_CW, IMMEDIATE_STOP, RELATIVE, RESUME, configuration
from homing3601 import HOME_SWITCH, HOME_SWITCH_PROXIMITY, USE_LIMIT, Search

EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])

TARGET_GIVEN = {"COMMAND_ERROR", "HOME_INVALID"}, ["HOM-02", "HMG-04"]
NO_TARGET = {*TARGET_GIVEN[0], "INVALID_PROFILE"}, [*TARGET_GIVEN[1], "CMD-04", "PRF-02"]
NO_LIMIT = {"COMMAND_ERROR", "HOME_INVALID"}, ["HOM-03", "HMG-05"]
TOO_SLOW = {"COMMAND_ERROR", "HOME_INVALID", "INVALID_PROFILE"}, ["HOM-01", "CMD-05", "PRF-01"]
OUT_OF_RANGE = {"COMMAND_ERROR", "INVALID_PROFILE"}, ["CMD-04", "PRF-02"]
S_CURVE = {"COMMAND_ERROR"}, ["CMD-10"]

ALL_ERRORS = {
    "HOME_INVALID",
    "INVALID_PROFILE",
    "POSITION_INVALID",
    "INPUT_ERROR",
    "COMMAND_ERROR",
    "CONFIG_ERROR",
}

# Words 1 to 7 of a Find Home that is accepted, at a starting speed of 1000.
GOOD = (0, 0, 0, 5, 0, 20, 10)


def changed(**words: int) -> tuple[int, ...]:
    """The good words with some of them changed: w1 is the command LSW, w2 and w3 the target, ..."""
    return tuple(words.get(f"w{number}", word) for number, word in enumerate(GOOD, start=1))


@EITHER_WAY
@pytest.mark.rules("HOM-01", "HOM-02", "HMG-04", "HMG-06", "CMD-10", "CMD-04", "PRF-02", "PRO-12")
@pytest.mark.parametrize(
    ("words", "refusal"),
    [
        pytest.param(changed(w3=1), TARGET_GIVEN, id="target 1"),
        pytest.param(changed(w3=-1), TARGET_GIVEN, id="target -1"),
        pytest.param(changed(w2=1), TARGET_GIVEN, id="target 1000"),
        pytest.param(changed(w2=1, w3=-1), NO_TARGET, id="target words that are no value"),
        pytest.param(changed(w4=0, w5=999), TOO_SLOW, id="speed 999"),
        pytest.param(changed(w4=0, w5=1), TOO_SLOW, id="speed 1"),
        pytest.param(changed(w4=0, w5=0), TOO_SLOW, id="speed 0"),
        pytest.param(changed(w4=-5, w5=0), TOO_SLOW, id="speed -5000"),
        pytest.param(changed(w4=0, w5=999, w6=0), TOO_SLOW, id="speed 999 and no acceleration"),
        pytest.param(changed(w4=1000, w5=1), OUT_OF_RANGE, id="speed 1,000,001"),
        pytest.param(changed(w4=5, w5=-1), OUT_OF_RANGE, id="speed words that are no value"),
        pytest.param(changed(w4=5, w5=1000), OUT_OF_RANGE, id="speed LSW 1000"),
        pytest.param(changed(w6=0), OUT_OF_RANGE, id="no acceleration"),
        pytest.param(changed(w6=2001), OUT_OF_RANGE, id="acceleration 2001"),
        pytest.param(changed(w7=0), OUT_OF_RANGE, id="no deceleration"),
        pytest.param(changed(w7=2001), OUT_OF_RANGE, id="deceleration 2001"),
        pytest.param(changed(w1=1), S_CURVE, id="triangular S"),
        pytest.param(changed(w1=3), S_CURVE, id="trapezoidal S"),
    ],
)
def test_refused_find_home(direction, words, refusal):
    """Nothing moves, what the last move left stays, and only Reset Errors helps."""
    search = Search(direction, valid=True)
    bench = search.bench
    bench.relative(30).until("MOVE_COMPLETE")
    bench.idle()
    bits, fired = refusal
    bench.out(HOME_CW if direction > 0 else HOME_CCW, *words).run(10)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", *bits}
    assert (bench.fired, bench.position) == (fired, 30)
    bench.idle().out(HOME_CW, *GOOD).run(10)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", *bits}
    bench.reset_errors()
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


@EITHER_WAY
@pytest.mark.rules("HOM-01", "HMG-04", "HMG-06", "CMD-10", "ENC-08", "LSW-12")
@pytest.mark.parametrize(
    "words",
    [
        pytest.param(changed(w4=1, w5=0), id="speed 1000"),
        pytest.param(changed(w4=1000, w5=0), id="speed 1,000,000"),
        pytest.param(changed(w6=1, w7=1), id="rates 1"),
        pytest.param(changed(w6=2000, w7=2000), id="rates 2000"),
        pytest.param(changed(w1=2), id="LSW bit 1 alone is not an S-curve"),
        pytest.param(changed(w1=4), id="the encoder bit has no effect"),
        pytest.param(changed(w1=0x1000), id="the proximity bit, if it is not configured, has none either"),
    ],
)
def test_accepted_find_home(direction, words):
    search = Search(direction)
    search.bench.out(HOME_CW if direction > 0 else HOME_CCW, *words).run(300)
    assert search.motion.startswith("ahead")
    search.bench.inputs(home=1).run(1)
    assert not search.bench.bits & (ALL_ERRORS - {"POSITION_INVALID"})


@EITHER_WAY
@pytest.mark.rules("HOM-03", "HMG-05", "CFG-18")
def test_direction_without_an_end_limit(direction):
    """The other direction has one, and one is enough."""
    search = Search(direction, drop=USE_LIMIT[direction])
    search.command(ms=5)
    assert search.bench.bits == {"MODULE_OK", "POSITION_INVALID", *NO_LIMIT[0]}
    assert (search.bench.fired, search.motion) == (NO_LIMIT[1], "still")
    search.bench.reset_errors()
    other = Search(direction, drop=USE_LIMIT[-direction])
    other.command(ms=5)
    assert (other.bench.fired, other.motion) == ([], "ahead up")


@pytest.mark.rules("HOM-02", "HOM-03")
@pytest.mark.parametrize(("target", "refusal"), [(1, TARGET_GIVEN), (0, NO_LIMIT)])
def test_the_event_log_names_one_rule_for_each_bit(target, refusal):
    """Every broken row sets its bit (reading A-110): the speed is out of range, and too low."""
    search = Search(1, drop=USE_LIMIT[1])
    search.command(target=target, speed=1, up=0, lsw=1, ms=5)
    assert search.bench.fired == [*refusal[1], "HOM-01", "CMD-05", "PRF-01"]
    assert search.bench.bits >= {"COMMAND_ERROR", "HOME_INVALID", "INVALID_PROFILE"}


@pytest.mark.rules("HMG-03", "STS-M04")
def test_at_home_stays_until_the_next_move():
    search = Search(home=(100, 200))
    search.command(speed=1000).until("AT_HOME")
    search.bench.idle(50).reset_errors()
    search.command(speed=999, ms=5)
    assert "AT_HOME" in search.bench.bits
    search.bench.idle().reset_errors().manual(-1, ms=1)
    assert "AT_HOME" not in search.bench.bits


@pytest.mark.rules("HMG-01", "HLD-12")
def test_it_takes_the_place_of_a_held_move():
    search = Search()
    bench = search.bench.relative(9000, ms=400)
    bench.out(HOLD).until("HOLD_STATE")
    search.command(ms=1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING", "POSITION_INVALID"}
    bench.out(IMMEDIATE_STOP).run(1).command(RESUME, ms=1)
    assert bench.fired[-1] == "CMD-08"


# -- while it searches


@pytest.mark.rules("HMG-01")
@pytest.mark.parametrize("kind", [HOME_SWITCH, HOME_SWITCH_PROXIMITY])
def test_the_bit_may_be_reset(kind):
    search = Search(kind=kind)
    search.command(ms=10)
    search.bench.idle(400)
    assert search.motion == "ahead"


@pytest.mark.rules("HLD-06", "CMD-07")
def test_hold_is_an_error_that_stays_while_home_is_found():
    search = Search(home=(3000, 3500))
    search.command(ms=500)
    search.bench.out(HOLD).run(10)
    assert search.bench.bits == {"MODULE_OK", "COMMAND_ERROR", "POSITION_INVALID", "MOVING_CW"}
    assert search.bench.fired == ["CMD-07"]
    search.course(9_000)
    assert search.bench.bits == {"MODULE_OK", "COMMAND_ERROR", "AT_HOME", "IN_HOME"}
    assert search.shaft == 3000
    search.bench.reset_errors()
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}


@pytest.mark.rules("CMD-03", "EXT-04")
@pytest.mark.parametrize("after_ms", [500, 690, 900, 1_250, 1_500, 2_000])
def test_second_move_and_external_input_leave_every_phase_alone(after_ms):
    """The search of 3002.5 ms, with its reversals at 1080 and 1800 ms."""
    search = Search(home=(3000, 3500))
    start_ns = search.bench.now_ns
    search.command(ms=after_ms)
    search.bench.inputs(external=1).out(RELATIVE, 0, 1, 0, 5, 0, 20, 10).run(10)
    assert (search.bench.fired, "COMMAND_ERROR" in search.bench.bits) == (["CMD-03"], True)
    search.course(9_000)
    assert search.bench.bits == {"MODULE_OK", "AT_HOME", "COMMAND_ERROR", "IN_HOME", "IN_EXTERNAL"}
    assert (search.shaft, search.bench.now_ns - start_ns) == (3000, 3_002_750_000)


PHASES = [
    pytest.param(500, id="searching"),
    pytest.param(690, id="in the ramp after the switch"),
    pytest.param(1_200, id="going back"),
    pytest.param(1_500, id="in the ramp after going back"),
    pytest.param(2_000, id="approaching"),
]


@pytest.mark.rules("STOP-02", "STOP-03", "POS-02", "POS-03", "INP-01")
@pytest.mark.parametrize("estop", [False, True])
@pytest.mark.parametrize("after_ms", PHASES)
def test_immediate_stop_and_emergency_stop_end_every_phase(after_ms, estop):
    """Reading A-99: Stopped is set."""
    search = Search(home=(3000, 3500), valid=True)
    search.command(ms=after_ms)
    if estop:
        search.bench.inputs(estop=1)
    else:
        search.bench.out(IMMEDIATE_STOP)
    search.bench.scan()
    position, bits = search.position, search.bench.bits
    assert bits - {"IN_HOME", "IN_ESTOP", "INPUT_ERROR"} == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    assert ("INPUT_ERROR" in bits) is estop
    search.bench.inputs(estop=0).idle(3_000)
    assert (search.position, search.motion) == (position, "still")


@pytest.mark.rules("STOP-02", "STOP-03", "POS-02", "POS-03")
@pytest.mark.parametrize("estop", [False, True])
def test_immediate_stop_and_emergency_stop_in_the_two_seconds(estop):
    """Reading A-29: the axis stands, and yet it is a motion that is stopped."""
    search = Search(valid=True)
    search.bench.inputs(cw_limit=1)
    search.command(ms=1_000)
    if estop:
        search.bench.inputs(estop=1)
    else:
        search.bench.out(IMMEDIATE_STOP)
    search.bench.scan()
    assert {"STOPPED", "POSITION_INVALID"} <= search.bench.bits
    search.bench.inputs(estop=0).idle(3_000)
    assert (search.motion, search.position) == ("still", 0)


@pytest.mark.rules("CMD-01", "CFG-14")
def test_configuration_is_entered_when_home_is_found():
    search = Search(home=(3000, 3500))
    search.command(ms=1_500)
    search.bench.out(*configuration()).run(10)
    assert (search.bench.fired, "COMMAND_ERROR" in search.bench.bits) == (["CMD-01"], True)
    search.bench.until("MODE_CONFIG")
    assert (search.bench.bits, search.shaft) == ({"MODULE_OK", "MODE_CONFIG"}, 3000)


@pytest.mark.rules("PRG-01")
@pytest.mark.parametrize("after_ms", [500, 1_500])
def test_program_mode_ends_a_search(after_ms):
    search = Search(home=(3000, 3500), valid=True)
    search.command(ms=after_ms)
    search.bench.plc("program").run(5)
    position = search.position
    assert search.bench.bits - {"IN_HOME"} == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    search.bench.plc("run").run(3_000)
    assert (search.position, search.motion) == (position, "still")


@pytest.mark.rules("INP-01")
def test_find_home_under_the_emergency_stop_is_refused():
    """Reading A-16: Input Error alone."""
    search = Search(valid=True)
    search.bench.inputs(estop=1).run(5).reset_errors()
    search.bench.fired.clear()
    search.command(ms=5)
    assert search.bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"}
    assert search.bench.fired == ["INP-01"]
