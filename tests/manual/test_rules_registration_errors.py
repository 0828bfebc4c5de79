"""Registration moves: what is refused at the start, what stops them on the way [chapters 4 and 6].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up; a stop from 5000/s takes 0.4 s and 1200 steps.
"""

from __future__ import annotations

import pytest
from bench3601 import HOLD, IMMEDIATE_STOP, MANUAL_CCW, MANUAL_CW, RELATIVE, RESET, Bench
from registration3601 import (
    EITHER_INPUT,
    SHAPES,
    STEPS,
    TO_STOP,
    change,
    give_input,
    register,
    release,
    store,
)

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])
EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES)

BOTH = {"COMMAND_ERROR", "INVALID_PROFILE"}
OUT_OF_RANGE = ["CMD-04", "PRF-02"]


def assert_clears(bench: Bench) -> None:
    """Only Reset Errors helps, and it leaves Stopped and the position alone."""
    before = bench.position
    bench.idle().relative(10, ms=5).idle(5)
    assert bench.bits >= {"COMMAND_ERROR"}
    bench.reset_errors()
    assert bench.bits.isdisjoint(BOTH | {"POSITION_INVALID"})
    bench.relative(10).until("MOVE_COMPLETE")
    assert bench.position == before + 10


# -- refused at the start


@EITHER_WAY
@pytest.mark.rules("CMD-23", "PRF-13", "REG-20", "CMD-24", "PRF-14", "REG-21", "CMD-04", "PRF-02")
@pytest.mark.parametrize(
    ("words", "fired"),
    [
        pytest.param((0, 1, 199, 5, 0, 20, 10), ["CMD-23", "PRF-13"], id="1199 steps, constant"),
        pytest.param((1, 2, 399, 5, 0, 20, 10), ["CMD-23", "PRF-13"], id="2399 steps, triangular S"),
        pytest.param((3, 1, 599, 5, 0, 20, 10), ["CMD-23", "PRF-13"], id="1599 steps, trapezoidal S"),
        pytest.param((0, 0, 1, 5, 0, 20, 10), ["CMD-23", "PRF-13"], id="1 step"),
        pytest.param((0, 0, 1, 1, 1, 1, 1), ["CMD-23", "PRF-13"], id="1 step at 1001: 1.0005 to stop"),
        pytest.param((0, 0, -1, 5, 0, 20, 10), ["CMD-24", "PRF-14"], id="-1 step"),
        pytest.param((0, -3, 0, 5, 0, 20, 10), ["CMD-24", "PRF-14"], id="-3000 steps"),
        pytest.param((0, -3, 0, 0, 500, 0, 0), ["CMD-24", "PRF-14"], id="-3000 steps, slow"),
        pytest.param((0, 3, -1, 5, 0, 20, 10), OUT_OF_RANGE, id="words that are no value"),
        pytest.param((0, 8388, 608, 5, 0, 20, 10), OUT_OF_RANGE, id="8,388,608 steps"),
        pytest.param((0, 3, 0, 0, 0, 20, 10), OUT_OF_RANGE, id="speed 0: no one-shot with a target"),
        pytest.param((0, 3, 0, 1000, 1, 20, 10), OUT_OF_RANGE, id="speed 1,000,001"),
        pytest.param((0, 3, 0, 5, 0, 0, 10), OUT_OF_RANGE, id="no acceleration"),
        pytest.param((0, 3, 0, 5, 0, 20, 2001), OUT_OF_RANGE, id="deceleration 2001"),
    ],
)
def test_refused(words, fired, direction):
    bench = Bench.ready(position=33)
    bench.out(MANUAL_CW if direction > 0 else MANUAL_CCW, *words).run(20)
    assert (bench.bits, bench.position) == ({"MODULE_OK", *BOTH}, 33)
    assert bench.fired == fired
    assert_clears(bench)


@pytest.mark.rules("CMD-23", "CMD-24", "REG-20", "REG-21")
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0, 1, 200, 5, 0, 20, 10), id="1200 steps, constant"),
        pytest.param((1, 2, 400, 5, 0, 20, 10), id="2400 steps, triangular S"),
        pytest.param((3, 1, 600, 5, 0, 20, 10), id="1600 steps, trapezoidal S"),
        pytest.param((0, 0, 2, 1, 1, 1, 1), id="2 steps at 1001"),
        pytest.param((0, 0, 1, 1, 0, 1, 1), id="1 step at the starting speed"),
        pytest.param((0, 8388, 607, 5, 0, 20, 10), id="8,388,607 steps"),
    ],
)
def test_accepted(words):
    bench = Bench.ready()
    bench.out(MANUAL_CW, *words).run(20)
    assert (bench.fired, "MOVING_CW" in bench.bits) == ([], True)


@EITHER_WAY
@pytest.mark.rules("CMD-22", "PRF-12", "REG-22", "EXT-05")
@pytest.mark.parametrize("minimum", [0, 2000])
@pytest.mark.parametrize("just_now", [True, False])
def test_external_input_at_the_start(just_now, minimum, direction):
    """With a minimum distance, too; a plain manual move makes its step."""
    bench = store(Bench.ready(), minimum)
    bench.inputs(external=1)
    if not just_now:
        bench.run(5)
    register(bench, direction).run(20)
    assert bench.bits - {"MIN_REG_NONZERO", "IN_EXTERNAL"} == {"MODULE_OK", *BOTH}
    assert (bench.position, bench.fired) == (0, ["CMD-22", "PRF-12"])
    bench.idle().reset_errors().manual(direction).until("STOPPED")
    assert (bench.position, bench.fired) == (direction, ["CMD-22", "PRF-12"])


@pytest.mark.rules("CMD-22")
def test_the_first_broken_rule_is_named():
    bench = Bench.ready()
    bench.inputs(external=1)
    register(bench, steps=-1).run(1)
    assert bench.fired == ["CMD-24", "PRF-14"]
    bench.idle().reset_errors()
    register(bench, steps=1199).run(1)
    assert bench.fired[2:] == ["CMD-23", "PRF-13"]


# -- stopped on the way

FAULTS = [
    pytest.param({"w2": 4}, ["CMD-26", "PRF-16"], id="more steps"),
    pytest.param({"w2": 2}, ["CMD-26", "PRF-16"], id="fewer steps"),
    pytest.param({"w3": 1}, ["CMD-26", "PRF-16"], id="LSW of the steps"),
    pytest.param({"w2": 0}, ["CMD-26", "PRF-16"], id="no steps"),
    pytest.param({"w2": -3}, ["CMD-26", "PRF-16"], id="negative steps"),
    pytest.param({"w5": 1}, ["CMD-27", "PRF-17"], id="a speed 1 higher"),
    pytest.param({"w4": 9, "w6": 30}, ["CMD-27", "PRF-17"], id="a higher speed and another rate"),
    pytest.param({"w4": 4, "w6": 21}, ["CMD-28", "PRF-18"], id="another acceleration and a lower speed"),
    pytest.param({"w4": 4, "w7": 9}, ["CMD-28", "PRF-18"], id="another deceleration and a lower speed"),
    pytest.param({"w4": 0}, ["CMD-15", "PRF-10"], id="speed 0"),
    pytest.param({"w5": -1}, ["CMD-15", "PRF-10"], id="speed words that are no value"),
    pytest.param({"w2": 4, "w4": 9}, ["CMD-26", "PRF-16"], id="target and speed"),
]


@EITHER_WAY
@pytest.mark.rules(
    "CMD-26", "PRF-16", "REG-24", "REG-19", "CMD-27", "PRF-17", "REG-25", "CMD-28", "PRF-18", "REG-26"
)
@pytest.mark.parametrize(("words", "fired"), FAULTS)
@pytest.mark.parametrize("scan_ms", [0.25, 2])
def test_changes_that_stop_it(words, fired, direction, scan_ms):
    """A stop with the accepted deceleration, which begins at once (A-56); the position stays valid."""
    bench = register(Bench.ready(scan_ms=scan_ms), direction).run(400)
    change(bench, direction=direction, **words).run(400 - scan_ms)
    moving = "MOVING_CW" if direction > 0 else "MOVING_CCW"
    assert bench.bits == {"MODULE_OK", moving, "DECELERATING", *BOTH}
    bench.scan()
    assert bench.bits == {"MODULE_OK", "STOPPED", *BOTH}
    assert (bench.position, bench.fired) == (direction * (1600 + 1200), fired)
    assert_clears(bench)


@pytest.mark.rules("CMD-26", "CMD-27")
@pytest.mark.parametrize("locked", [False, True])
def test_words_are_not_looked_at_again_while_it_stops(locked):
    """Nor under a command error (reading A-104), even one that Reset Errors has cleared meanwhile."""
    bench = register(Bench.ready()).run(400)
    change(bench, w2=4).run(10)
    if not locked:
        bench.out(RESET).run(1)
        assert "COMMAND_ERROR" not in bench.bits
    bench.out(0, 0, 5, 0, 9, 0, 20, 10).until("STOPPED")
    assert (bench.position, bench.fired) == (2800, ["CMD-26", "PRF-16"])


@pytest.mark.rules("STS-M12")
@pytest.mark.parametrize("words", [{"w2": 4}, {"w4": 9}, {"w4": 4}], ids=str)
def test_words_are_not_looked_at_under_a_command_error(words):
    """Reading A-104; here the error is a second move, and the registration goes on."""
    bench = register(Bench.ready()).run(400)
    bench.out(RELATIVE, *list(bench.outputs)[1:]).run(0.25)
    assert bench.fired == ["CMD-03"]
    change(bench, **words)
    release(bench).until("STOPPED")
    assert (bench.position, bench.fired) == (1600 + STEPS, ["CMD-03"])


@EVERY_SHAPE
@pytest.mark.rules("CMD-26", "REG-24")
def test_the_stop_has_the_shape_of_the_move(shape):
    bench = register(Bench.ready(), lsw=SHAPES[shape]).run(1_000)
    made = bench.position
    change(bench, w2=9).until("STOPPED")
    assert 0 <= bench.position - made - TO_STOP[shape] <= 1


@BOTH_PERIODS
@pytest.mark.rules("CMD-26", "PRF-16", "REG-24")
@pytest.mark.parametrize("zeroed", ["the target", "everything"])
def test_the_target_counts_even_in_the_image_that_releases_the_bit(zeroed, scan_ms):
    bench = register(Bench.ready(scan_ms=scan_ms)).run(400)
    bench.out(*([0] * 8 if zeroed == "everything" else [0, 0, 0, 0, 5, 0, 20, 10])).run(400)
    assert (bench.position, bench.fired) == (2800, ["CMD-26", "PRF-16"])


@EITHER_INPUT
@pytest.mark.rules("CMD-26", "PRF-16", "REG-24")
@pytest.mark.parametrize("after_ms", [100, 300])
def test_the_target_counts_after_the_input(after_ms, by):
    """While the steps are made at constant speed."""
    bench = register(Bench.ready()).run(400)
    give_input(bench, by).run(after_ms)
    made = bench.position
    msw, lsw, *rest = bench.outputs
    bench.out(msw, lsw, rest[0] + 1, *rest[1:]).until("STOPPED")
    assert (bench.position, bench.fired) == (made + 1200, ["CMD-26", "PRF-16"])


@EVERY_SHAPE
@pytest.mark.rules("CMD-26", "REG-02")
@pytest.mark.parametrize("before_ms", range(20, 780, 80))
def test_a_fault_in_the_last_ramp_makes_no_more_steps_than_the_move_had_left(before_ms, shape):
    """A new S begun in the last one could be longer than what is left of it."""
    ramp_ms = {"constant": 400, "triangular S": 800, "trapezoidal S": 534}[shape]
    bench = register(Bench.ready(), lsw=SHAPES[shape]).run(1_000)
    made = bench.position
    release(bench).until("DECELERATING")
    bench.run(max(1, ramp_ms - before_ms))
    bench.out(0, SHAPES[shape], 9, 0, 5, 0, 20, 10).until("STOPPED")
    assert bench.fired == ["CMD-26", "PRF-16"]
    assert bench.position <= made + STEPS


@pytest.mark.rules("CMD-26", "REG-24")
def test_the_target_no_longer_counts_when_the_move_is_over():
    bench = register(Bench.ready()).run(400)
    release(bench).until("STOPPED")
    bench.out(0, 0, 9).run(5)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "STOPPED"}, [])


@pytest.mark.rules("CMD-13", "PRF-09")
@pytest.mark.parametrize(("speed", "fired"), [(799, ["CMD-13", "PRF-09"]), (801, ["CMD-27", "PRF-17"])])
def test_speed_change_in_constant_speed_mode(speed, fired):
    """At or below the starting speed the axis stops at once."""
    bench = register(Bench.ready(), speed=800).run(500)
    change(bench, w5=speed).run(0.25)
    assert (bench.position, bench.bits, bench.fired) == (400, {"MODULE_OK", "STOPPED", *BOTH}, fired)


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("CMD-25", "PRF-15", "REG-23")
@pytest.mark.parametrize("words", [{"w2": 3}, {"w3": 1}, {"w3": -1}], ids=str)
def test_a_plain_manual_move_that_is_given_a_target(words, scan_ms, direction):
    bench = Bench.ready(scan_ms=scan_ms).manual(direction, ms=400)
    change(bench, direction=direction, **words).run(400)
    assert (bench.position, bench.fired) == (direction * 2800, ["CMD-25", "PRF-15"])
    assert bench.bits == {"MODULE_OK", "STOPPED", *BOTH}
    assert_clears(bench)


@pytest.mark.rules("CMD-25", "REG-17")
def test_before_firmware_3_1_the_target_of_a_running_manual_move_is_not_looked_at():
    """Reading A-105."""
    bench = Bench.ready("2.2").manual(ms=400)
    change(bench, w2=3).run(10)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW"}, [])


# -- Hold


@EITHER_WAY
@BOTH_PERIODS
@pytest.mark.rules("CMD-21", "REG-27")
def test_hold_before_the_input(scan_ms, direction):
    """The deceleration value stops the axis; the bit that Hold takes the place of counts no more."""
    bench = register(Bench.ready(scan_ms=scan_ms), direction).run(400)
    bench.out(HOLD, *list(bench.outputs)[1:]).run(400)
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (direction * 2800, ["CMD-21"])
    assert_clears(bench)


@pytest.mark.rules("CMD-21", "REG-04")
def test_hold_before_the_minimum_distance_is_before_the_input():
    bench = register(store(Bench.ready(), 5000)).run(400)
    release(bench).run(10)
    bench.out(HOLD, *list(bench.outputs)[1:]).until("STOPPED")
    assert (bench.position, bench.fired) == (1650 + 1200, ["CMD-21"])


@EITHER_INPUT
@pytest.mark.rules("CMD-21", "CMD-07")
@pytest.mark.parametrize("after_ms", [100, 500])
def test_hold_after_the_input(after_ms, by):
    """Reading A-54: a command error, and the steps are completed."""
    bench = register(Bench.ready()).run(400)
    give_input(bench, by).run(after_ms)
    bench.out(HOLD, *list(bench.outputs)[1:]).run(1)
    assert "COMMAND_ERROR" in bench.bits
    bench.until("STOPPED")
    assert (bench.position, bench.fired) == (1600 + STEPS, ["CMD-07"])


# -- what else ends it


@EITHER_WAY
@pytest.mark.rules("REG-16", "LIM-02")
@pytest.mark.parametrize("registered", [False, True])
def test_only_the_limit_ahead_stops_it(registered, direction):
    ahead, behind = ("cw_limit", "ccw_limit")[::direction]
    bench = register(Bench.ready(), direction).run(400)
    if registered:
        release(bench).run(100)
    bench.inputs(**{behind: 1}).run(100)
    assert bench.fired == []
    made = bench.position
    assert abs(made) == 600 + 5 * (400 if registered else 300)
    bench.inputs(**{behind: 0, ahead: 1}).run(10)
    assert {"STOPPED", "POSITION_INVALID", "INPUT_ERROR"} <= bench.bits
    assert (bench.position, bench.fired) == (made, ["INP-02", "POS-04"])


@pytest.mark.rules("INP-03")
@pytest.mark.parametrize("limit", ["cw_limit", "ccw_limit"])
def test_start_on_a_limit(limit):
    bench = Bench.ready()
    bench.inputs(**{limit: 1}).run(5)
    register(bench).run(20)
    refused = limit == "cw_limit"
    assert ("INPUT_ERROR" in bench.bits, bench.fired) == (refused, ["INP-03"] if refused else [])
    assert ("MOVING_CW" in bench.bits) is not refused


@pytest.mark.rules("CMD-02")
@pytest.mark.parametrize("registered", [False, True])
def test_two_command_bits_make_a_controlled_stop(registered):
    """Reading A-33."""
    bench = register(Bench.ready()).run(400)
    if registered:
        bench.inputs(external=1).run(100)
    made = bench.position
    bench.out(MANUAL_CW | HOLD, *list(bench.outputs)[1:]).until("STOPPED")
    assert (bench.position, bench.fired) == (made + 1200, ["CMD-02"])


@pytest.mark.rules("STOP-02", "STOP-03", "PRG-01")
@pytest.mark.parametrize("cause", ["stop", "estop", "program mode"])
@pytest.mark.parametrize("registered", [False, True])
def test_cut(registered, cause):
    bench = register(Bench.ready()).run(400)
    if registered:
        release(bench).run(100)
    made = bench.position
    if cause == "stop":
        bench.out(IMMEDIATE_STOP, *list(bench.outputs)[1:])
    elif cause == "estop":
        bench.inputs(estop=1)
    else:
        bench.plc("program")
    bench.run(1)
    assert {"STOPPED", "POSITION_INVALID"} <= bench.bits
    assert bench.position == made
