"""Parameters that a move does not take [chapter 6, Command Errors 4 to 6 and 10, Invalid Profile 1 and 2].

The parameters of `command` are legal: speed 5000, acceleration 20, deceleration 10; starting speed
1000. Each row breaks one thing and names the nearest words that do not.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    BLEND_CW,
    ENCODER,
    HOLD,
    HOME_CCW,
    HOME_CW,
    MANUAL_CW,
    PRESET,
    PRESET_ENCODER,
    RELATIVE,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import ENCODER_MOVE, LONG
from refusals3601 import COMMAND_ERRORS, MOTION, PROFILE_ERRORS, after_a_move, refused

TARGET, SPEED, UP, DOWN = 2, 4, 6, 7
WITH_TARGET = {"absolute": (ABSOLUTE, 0), "relative": (RELATIVE, 0), "encoder": (RELATIVE, ENCODER_MOVE)}
MOVES = {**WITH_TARGET, "home": (HOME_CW, 0), "manual": (MANUAL_CW, 0)}


# what, rule, first word, illegal words, the nearest legal ones
BROKEN = [
    ("target", "IOM-10", TARGET, (8_388, 608), (8_388, 607)),
    ("target", "IOM-10", TARGET, (-8_388, -609), (-8_388, -608)),
    ("target", "IOM-10", TARGET, (0, 1_000), (0, 999)),
    ("target", "IOM-10", TARGET, (0, -1_000), (0, -999)),
    ("target", "IOM-10", TARGET, (8, 1_000), (8, 999)),
    ("target", "IOM-10", TARGET, (-12, 345), (-12, 0)),  # -12,000 is the manual's own example
    ("target", "IOM-10", TARGET, (12, -345), (12, 0)),
    ("target", "IOM-10", TARGET, (1, -1), (1, 1)),
    ("speed", "IOM-15", SPEED, (1_000, 1), (1_000, 0)),
    ("speed", "IOM-15", SPEED, (999, 1_000), (999, 999)),
    ("speed", "IOM-15", SPEED, (1, 1_000), (1, 999)),
    ("speed", "IOM-15", SPEED, (2, -1), (2, 0)),
    ("speed", "IOM-15", SPEED, (-5, 0), (5, 0)),
    ("speed", "IOM-15", SPEED, (-5, -1), (5, 1)),
    *(("acceleration", "IOM-16", UP, (bad,), (good,)) for bad, good in [(0, 1), (-1, 1), (2_001, 2_000)]),
    *(("deceleration", "IOM-16", DOWN, (bad,), (good,)) for bad, good in [(0, 1), (-1, 1), (2_001, 2_000)]),
]
ROWS = [
    pytest.param(
        move, at, bad, good, id=f"{move}-{what} {bad}", marks=pytest.mark.rules("CMD-04", "PRF-02", rule)
    )
    for what, rule, at, bad, good in BROKEN
    for move in (WITH_TARGET if at == TARGET else MOVES)
    if move != "home" or at != SPEED or bad[0] >= 0  # below the starting speed: Home Invalid, too
]


def with_words(msw: int, lsw: int, at: int, words: tuple[int, ...]) -> list[int]:
    """A command with a legal target of 7 where it needs one, and these words from word `at` on."""
    command = [msw, lsw, 0, 0 if msw in (HOME_CW, HOME_CCW, MANUAL_CW) else 7, 5, 0, 20, 10]
    command[at : at + len(words)] = words
    return command


@pytest.mark.parametrize(("move", "at", "bad", "good"), ROWS)
def test_parameters_out_of_range(move, at, bad, good):
    """Both bits, for the cause stands in both lists (reading A-20)."""
    msw, lsw = MOVES[move]
    bench = after_a_move(config=configuration(add=ENCODER))
    bench.out(*with_words(msw, lsw, at, bad))
    refused(bench, "CMD-04", "PRF-02", errors=PROFILE_ERRORS)
    bench.out(*with_words(msw, lsw, at, good)).run(1)
    assert bench.bits & MOTION
    assert "COMMAND_ERROR" not in bench.bits


@pytest.mark.rules("CMD-04", "PRF-02", "IOM-15", "IOM-16")
@pytest.mark.parametrize(("at", "bad"), [(SPEED, (1_000, 1)), (SPEED, (2, -1)), (UP, (0,)), (DOWN, (2_001,))])
def test_resume_out_of_range(at, bad):
    """The hold bit stays (reading A-84), but nothing can be resumed after the error."""
    bench = Bench.ready().relative(LONG, ms=400).out(HOLD).run(500).idle()
    bench.out(*with_words(RESUME, 0, at, bad)).run(1)
    assert bench.bits == {"MODULE_OK", "HOLD_STATE"} | PROFILE_ERRORS
    assert bench.fired == ["CMD-04", "PRF-02"]
    bench.reset_errors()
    bench.out(*with_words(RESUME, 0, SPEED, (5, 0)))
    refused(bench, "CMD-08", errors=COMMAND_ERRORS)


@pytest.mark.rules("CMD-05", "PRF-01", "IOM-15")
@pytest.mark.parametrize("start", [1_000, 12_345])
@pytest.mark.parametrize("move", WITH_TARGET)
def test_slower_than_the_starting_speed(move, start):
    msw, lsw = WITH_TARGET[move]
    config = configuration(add=ENCODER, start=start)
    bench = after_a_move_at(start, config=config)
    bench.command(msw, 7, lsw=lsw, speed=start - 1).run(1)
    assert (bench.fired, bench.bits) == (
        ["CMD-05", "PRF-01"],
        {"MODULE_OK", "MOVE_COMPLETE"} | PROFILE_ERRORS,
    )
    bench.reset_errors()
    bench.command(msw, 7, lsw=lsw, speed=start).run(0.25)
    assert bench.bits & MOTION == {"MOVING_CW"}


def after_a_move_at(speed: int, **kwargs) -> Bench:
    bench = Bench.ready(**kwargs).relative(0, speed=speed).run(1)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    return bench.idle()


@pytest.mark.rules("CMD-05", "PRF-01", "HOM-01")
@pytest.mark.parametrize("command", [HOME_CW, HOME_CCW], ids=["CW", "CCW"])
@pytest.mark.parametrize("words", [(0, 999), (0, 1), (0, 0), (-5, 0), (-5, -1)])
def test_homing_slower_than_the_starting_speed(command, words):
    """Home Invalid, too: the cause stands in three lists, and the one of Home Invalid knows no range."""
    bench = after_a_move()
    bench.out(*with_words(command, 0, SPEED, words))
    refused(bench, "HOM-01", "CMD-05", "PRF-01", errors=PROFILE_ERRORS | {"HOME_INVALID"})
    bench.command(command, speed=1_000).run(1)
    assert bench.bits & MOTION
    assert "HOME_INVALID" not in bench.bits


@pytest.mark.rules("CMD-05", "PRF-01")
def test_resume_slower_than_the_starting_speed():
    for speed, errors in ((1_000, set()), (999, PROFILE_ERRORS)):
        bench = Bench.ready().relative(LONG, ms=400).out(HOLD).run(500).idle()
        bench.command(RESUME, speed=speed).run(1)
        assert bench.bits - MOTION == {"MODULE_OK"} | errors | ({"HOLD_STATE"} if errors else set())
        assert bench.fired == (["CMD-05", "PRF-01"] if errors else [])


@pytest.mark.rules("CMD-06")
@pytest.mark.parametrize("lsw", [0, ENCODER_MOVE], ids=["steps", "encoder"])
def test_absolute_move_with_an_invalid_position(lsw):
    """For encoder moves, too (reading A-51); a preset position makes it possible."""
    bench = Bench.configured(config=configuration(add=ENCODER))
    bench.command(ABSOLUTE, 7, lsw=lsw)
    refused(bench, "CMD-06", errors=COMMAND_ERRORS)
    bench.out(PRESET).run(1).idle()
    bench.command(ABSOLUTE, 7, lsw=lsw).run(1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}


@pytest.mark.rules("CMD-04", "CMD-06")
def test_every_broken_rule_sets_its_bit():
    """A range, the position, and an input that would prevent the motion (A-16, A-110)."""
    bench = Bench.configured().inputs(estop=1).run(1)
    bench.reset_errors().command(ABSOLUTE, 7, up=0).run(1)
    assert bench.fired[-3:] == ["CMD-04", "PRF-02", "INP-01"]
    assert bench.bits >= {"COMMAND_ERROR", "INVALID_PROFILE", "INPUT_ERROR"}
    bench.reset_errors()
    bench.command(ABSOLUTE, 7).run(1)
    assert bench.fired[-2:] == ["CMD-06", "INP-01"]
    assert "INVALID_PROFILE" not in bench.bits
    bench.reset_errors()
    bench.out(PRESET).run(1).command(ABSOLUTE, 7).run(1)
    assert (bench.fired[-1], bench.bits) == ("INP-01", {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"})


@pytest.mark.rules("CMD-04", "CMD-05", "CMD-08", "CMD-16", "CMD-17", "CMD-23", "CMD-24", "ENC-05")
@pytest.mark.rules("HOM-01", "HOM-02")
@pytest.mark.parametrize(
    ("command", "parameters", "rule"),
    [
        pytest.param(RELATIVE, {"target": 7, "speed": 999}, "CMD-05", id="relative, too slow"),
        pytest.param(RELATIVE, {"target": 7, "lsw": ENCODER_MOVE}, "ENC-05", id="relative, no encoder"),
        pytest.param(ABSOLUTE, {"target": 7, "lsw": ENCODER_MOVE}, "ENC-05", id="absolute, no encoder"),
        pytest.param(RELATIVE, {"target": 7, "lsw": ENCODER_MOVE, "up": 0}, "CMD-04", id="range, no encoder"),
        pytest.param(HOME_CW, {"target": 7}, "HOM-02", id="home with a target"),
        pytest.param(HOME_CW, {"speed": 999}, "HOM-01", id="home, too slow"),
        pytest.param(MANUAL_CW, {"speed": 1_000_001}, "CMD-04", id="manual, too fast"),
        pytest.param(MANUAL_CW, {"target": -7}, "CMD-24", id="registration backward"),
        pytest.param(MANUAL_CW, {"target": 7}, "CMD-23", id="registration, too short"),
        pytest.param(RESUME, {}, "CMD-08", id="resume without a hold"),
        pytest.param(BLEND_CW, {}, "CMD-17", id="blend with data"),
        pytest.param(BLEND_CW, {"speed": 0, "up": 0, "down": 0}, "CMD-16", id="blend, none stored"),
    ],
)
def test_what_is_wrong_with_the_words_does_not_hide_the_emergency_stop(command, parameters, rule):
    """Each prevents the motion by itself (readings A-16, A-110)."""
    bench = Bench.configured().inputs(estop=1).run(1)
    bench.fired.clear()
    bench.reset_errors().command(command, **parameters).run(1)
    assert bench.fired[0] == rule
    assert bench.fired[-1] == "INP-01"
    assert bench.bits >= {"COMMAND_ERROR", "INPUT_ERROR"}


@pytest.mark.rules("CMD-11")
def test_an_encoder_preset_moves_nothing_so_that_the_emergency_stop_is_no_matter():
    bench = Bench.configured().inputs(estop=1).run(1)
    bench.reset_errors().command(PRESET_ENCODER, 7).run(1)
    assert (bench.fired[-1], "INPUT_ERROR" in bench.bits) == ("CMD-11", False)


@pytest.mark.rules("CMD-05", "INP-01")
@pytest.mark.parametrize(("speed", "rule"), [(999, "CMD-05"), (1000, "INP-01")])
def test_resume_in_the_scan_in_which_the_emergency_stop_comes(speed, rule):
    bench = Bench.ready().relative(10_000, ms=300).out(HOLD)
    bench.until("HOLD_STATE")
    bench.fired.clear()
    bench.inputs(estop=1).command(RESUME, speed=speed).scan()
    assert bench.fired[0] == rule
    assert bench.bits.isdisjoint(MOTION)


@pytest.mark.rules("CMD-06")
def test_an_encoder_move_to_an_unknown_place_under_the_emergency_stop():
    bench = Bench.configured(config=configuration(add=ENCODER)).inputs(estop=1).run(1)
    bench.reset_errors().command(ABSOLUTE, 7, lsw=ENCODER_MOVE).run(1)
    assert bench.fired[-2:] == ["CMD-06", "INP-01"]


@pytest.mark.rules("CMD-04", "CMD-10", "HOM-01", "HOM-02")
@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        pytest.param({"target": 7, "lsw": 1, "speed": 0}, "HOM-02", id="target"),
        pytest.param({"lsw": 1, "speed": 0}, "CMD-10", id="S-curve"),
        pytest.param({"speed": 0, "up": 0}, "HOM-01", id="starting speed"),
        pytest.param({"up": 0}, "CMD-04", id="range"),
    ],
)
def test_of_several_mistakes_of_a_find_home_one_is_named_first(wrong, rule):
    """The manual names no order; a speed of 0 is below the starting speed like any other [Home Invalid 1]."""
    bench = Bench.ready().command(HOME_CW, **wrong).run(1)
    assert bench.fired[0] == rule


@pytest.mark.rules("CMD-22", "CMD-23", "CMD-24")
def test_the_distance_of_a_registration_move_comes_before_the_external_input():
    """A distance that is negative or too short is told whether the input is active or not."""
    for target, rule in ((-7, "CMD-24"), (7, "CMD-23"), (5000, "CMD-22")):
        bench = Bench.ready().inputs(external=1).run(1)
        bench.command(MANUAL_CW, target).run(1)
        assert bench.fired[0] == rule


@pytest.mark.rules("CMD-03")
@pytest.mark.parametrize("command", [ABSOLUTE, RELATIVE, HOME_CW, MANUAL_CW, RESUME, BLEND_CW])
def test_a_running_move_goes_on_whatever_else_is_wrong(command):
    """What is wrong with the words shows all the same (reading A-110)."""
    bench = Bench.ready()
    bench.relative(10_000).run(300).idle(1)
    bench.command(command, 8_388_608, speed=0, up=0, down=0, lsw=0b11).run(1)
    assert bench.fired[0] == ("CMD-08" if command == RESUME else "CMD-03")
    profile = {"INVALID_PROFILE"} if command != BLEND_CW else set()
    home = {"HOME_INVALID"} if command == HOME_CW else set()
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"} | profile | home


@pytest.mark.rules("CMD-10", "HMG-07")
@pytest.mark.parametrize("command", [HOME_CW, HOME_CCW], ids=["CW", "CCW"])
@pytest.mark.parametrize("lsw", [0b01, 0b11], ids=["triangular", "trapezoidal"])
def test_homing_with_an_s_curve(lsw, command):
    """Command Error only; bit 1 without bit 0 selects nothing [chapter 5, Command Word LSW]."""
    bench = after_a_move()
    bench.command(command, lsw=lsw)
    refused(bench, "CMD-10", errors=COMMAND_ERRORS)
    bench.command(command, lsw=0b10).run(1)
    assert bench.bits & MOTION
