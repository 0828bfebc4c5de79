"""Absolute and relative moves, when a move may start, Move Complete [chapters 4 and 6]."""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    HOLD,
    HOME_CW,
    IMMEDIATE_STOP,
    MANUAL_CW,
    PRESET,
    PRESET_ENCODER,
    RELATIVE,
    RESET,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import ENCODER_MOVE, FOLLOW, MOTIONS, Motion

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
AT_REST = {"MODULE_OK"}
COMPLETE = {"MODULE_OK", "MOVE_COMPLETE"}
REFUSED = {"COMMAND_ERROR", "INVALID_PROFILE"}

# -- direction and distance -----------------------------------------------------------------------

# from, command, target, to
MOVES = [
    pytest.param(5_000, ABSOLUTE, 7_500, 7_500, id="absolute 5000 to 7500, the manual's example"),
    pytest.param(5_000, ABSOLUTE, 2_500, 2_500, id="absolute 5000 to 2500"),
    pytest.param(-300, ABSOLUTE, -100, -100, id="absolute -300 to -100, up"),
    pytest.param(-300, ABSOLUTE, -1_000, -1_000, id="absolute -300 to -1000, down"),
    pytest.param(300, ABSOLUTE, 0, 0, id="absolute 300 to 0"),
    pytest.param(5_000, RELATIVE, 7_500, 12_500, id="relative 7500 from 5000, the manual's example"),
    pytest.param(5_000, RELATIVE, -7_500, -2_500, id="relative -7500 from 5000"),
    pytest.param(-5_000, RELATIVE, 1, -4_999, id="relative 1 from -5000"),
    pytest.param(-5_000, RELATIVE, -1, -5_001, id="relative -1 from -5000"),
]


@EVERY_SCAN
@pytest.mark.parametrize(("start", "command", "target", "end"), MOVES)
@pytest.mark.rules("MOV-02", "MOV-03", "MOV-04", "MOV-05", "MOV-07", "MOV-08", "MOV-09", "MC-01", "STOP-06")
def test_direction_and_end_of_a_move(start, command, target, end, scan_ms):
    bench = Bench.ready(position=start, scan_ms=scan_ms).command(command, target).scan()
    way = {"MOVING_CW"} if end > start else {"MOVING_CCW"}
    if abs(end - start) > 1:  # a single step at 1000/s is over before a 2 ms scan is
        assert bench.bits - {"ACCELERATING", "DECELERATING"} == AT_REST | way
    while "MOVE_COMPLETE" not in bench.bits:  # the motion bits go off in the image that shows the end
        assert bench.bits.isdisjoint({"STOPPED", "HOLD_STATE"})
        assert way <= bench.bits
        bench.scan()
    assert (bench.position, bench.bits, bench.fired) == (end, COMPLETE, [])


@EVERY_SCAN
@pytest.mark.parametrize("command", [ABSOLUTE, RELATIVE])
@pytest.mark.rules("MOV-02", "MOV-07")
def test_a_move_without_distance_is_complete_at_once(command, scan_ms):
    """Reading A-35."""
    bench = Bench.ready(position=700, scan_ms=scan_ms)
    bench.command(command, 700 if command == ABSOLUTE else 0).scan()
    assert (bench.position, bench.bits, bench.fired) == (700, COMPLETE, [])


# -- what needs a valid position ------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("MOV-01", "CMD-06")
def test_an_absolute_move_needs_a_valid_position(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms).absolute(500, ms=20)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (0, ["CMD-06"])
    bench.idle().reset_errors()
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.out(PRESET, 0, 0, 100).run(scan_ms)
    bench.idle().absolute(500)
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (500, COMPLETE)


@EVERY_SCAN
@pytest.mark.rules("MOV-06", "MOV-07")
def test_a_relative_move_neither_needs_nor_makes_a_valid_position(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms).relative(-500)
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits, bench.fired) == (-500, COMPLETE | {"POSITION_INVALID"}, [])


# -- when a move may start ------------------------------------------------------------------------

NEW_MOVES = [
    pytest.param(ABSOLUTE, 0, id="absolute"),
    pytest.param(RELATIVE, 0, id="relative"),
    pytest.param(RELATIVE, ENCODER_MOVE, id="encoder"),
    pytest.param(MANUAL_CW, 0, id="manual"),
    pytest.param(HOME_CW, 0, id="home"),
    pytest.param(0x1000, 0, id="blend"),
]
GOES_ON = [
    motion for motion in MOTIONS if motion.name.split()[0] not in ("follower", "manual", "registration")
]


@EVERY_SCAN
@pytest.mark.parametrize("motion", GOES_ON, ids=lambda motion: motion.name)
@pytest.mark.parametrize(("msw", "lsw"), NEW_MOVES)
@pytest.mark.rules("MOV-10", "CMD-03")
def test_a_move_before_the_previous_one_is_complete(motion, msw, lsw, scan_ms):
    """The error, and no other; the move in progress goes on as if nothing had been said."""
    bench = motion.started(400, scan_ms=scan_ms)
    bench.idle(scan_ms).command(msw, lsw=lsw).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"} | motion.shown
    assert bench.fired == ["CMD-03"]
    here = bench.position
    assert bench.run(100).position == here + 500 * motion.direction


@EVERY_SCAN
@pytest.mark.parametrize("name", ["manual cw", "manual ccw"])
@pytest.mark.parametrize(("msw", "lsw"), NEW_MOVES)
@pytest.mark.rules("MOV-10", "CMD-03")
def test_a_move_while_a_manual_move_still_decelerates(name, msw, lsw, scan_ms):
    """Reading A-45: 2800 = 1600 + 1200 all the same."""
    motion = Motion.of(name)
    bench = motion.started(400, scan_ms=scan_ms).idle(50)
    bench.command(msw, lsw=lsw).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR", "DECELERATING", motion.moving}
    assert bench.fired == ["CMD-03"]
    bench.until("STOPPED")
    assert (bench.position, bench.bits) == (
        motion.direction * 2_800,
        {"MODULE_OK", "COMMAND_ERROR", "STOPPED"},
    )


@EVERY_SCAN
@pytest.mark.rules("CMD-03", "RST-03", "MC-01")
def test_the_move_in_progress_completes_and_says_so(scan_ms):
    """Reading A-27: 2.24 s in all, the error latched, Move Complete set."""
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, ms=400)
    bench.idle(scan_ms).relative(-500, ms=1_840 - 2 * scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING", "COMMAND_ERROR"}
    bench.run(2 * scan_ms)
    assert (bench.position, bench.bits) == (10_000, COMPLETE | {"COMMAND_ERROR"})
    assert bench.reset_errors(scan_ms).bits == COMPLETE


@EVERY_SCAN
@pytest.mark.rules("MOV-05")
def test_switch_for_no_move_complete_after_a_command_error(scan_ms):
    """Reading A-27 the other way; the next move is not tainted by it."""
    bench = Bench.ready(scan_ms=scan_ms, complete_after_error=False).relative(10_000, ms=400)
    bench.idle(scan_ms).relative(-500).until(clear=["MOVING_CW"])
    assert (bench.position, bench.bits) == (10_000, {"MODULE_OK", "COMMAND_ERROR"})
    bench.reset_errors().relative(-500).until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (9_500, COMPLETE)


@EVERY_SCAN
@pytest.mark.rules("CMD-03")
def test_the_very_end_of_a_move_is_soon_enough_for_the_next_one(scan_ms):
    """100 steps at 1000/s: a word that comes with the image of 100 ms is in time, 2 ms earlier it is not."""
    early = Bench.ready(scan_ms=scan_ms).relative(100, speed=1_000, ms=100 - 2 * scan_ms)
    early.idle(scan_ms).relative(100).scan()
    assert early.fired == ["CMD-03"]
    bench = Bench.ready(scan_ms=scan_ms).relative(100, speed=1_000, ms=100 - scan_ms)
    bench.idle(scan_ms).relative(100).scan()
    assert (bench.fired, "MOVING_CW" in bench.bits) == ([], True)


# -- Move Complete --------------------------------------------------------------------------------


def completed(**kwargs) -> Bench:
    """A bench with every kind of motion ready, and a relative move of 100 steps behind it."""
    bench = Motion.of("blend cw").bench(**kwargs).relative(100)
    bench.until("MOVE_COMPLETE")
    bench.idle()
    bench.fired.clear()
    return bench


def run_to_end(name: str, scan_ms: float) -> Bench:
    """Let a motion of this kind come to its natural end."""
    motion = Motion.of(name)
    bench = motion.bench(scan_ms=scan_ms, machine={"home": (3_000, 3_500)})
    motion.start(bench).run(400)
    if motion.follows or motion.msw == MANUAL_CW:
        bench.idle(scan_ms)
    if motion.lsw & ENCODER_MOVE:
        bench.turn_encoder(20_000, ms=1)
    bench.until(clear=[motion.moving, "ENC_FOLLOWER"])
    if name == "home cw":
        bench.until("AT_HOME")
    return bench


@EVERY_SCAN
@pytest.mark.parametrize(
    ("name", "bit"),
    [
        ("absolute cw", "MOVE_COMPLETE"),
        ("relative cw", "MOVE_COMPLETE"),
        ("absolute encoder cw", "MOVE_COMPLETE"),
        ("relative encoder cw", "MOVE_COMPLETE"),
        ("blend cw", "MOVE_COMPLETE"),
        ("manual cw", "STOPPED"),
        ("home cw", "AT_HOME"),
        ("follower cw", "STOPPED"),
    ],
)
@pytest.mark.rules(
    "MC-01", "STOP-01", "STOP-05", "STOP-06", "STS-M03", "STS-M04", "STS-M07", "MOV-05", "FOL-06"
)
def test_how_each_motion_shows_its_natural_end(name, bit, scan_ms):
    bench = run_to_end(name, scan_ms)
    assert bench.bits - {"IN_HOME"} == {"MODULE_OK", bit}
    assert bench.fired == []


@EVERY_SCAN
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
@pytest.mark.rules("MC-02", "HLD-12")
def test_the_next_move_resets_move_complete(motion, scan_ms):
    bench = completed(scan_ms=scan_ms)
    motion.start(bench).scan()
    assert "MOVE_COMPLETE" not in bench.bits
    assert "HOLD_STATE" not in bench.bits
    assert bench.fired == []


@EVERY_SCAN
@pytest.mark.parametrize("name", ["relative ccw", "manual ccw", "home ccw", "follower ccw"])
@pytest.mark.rules("STS-M03", "STS-M04")
def test_the_next_move_resets_at_home_and_stopped(name, scan_ms):
    """Reading A-03."""
    motion = Motion.of(name)
    bench = motion.bench(scan_ms=scan_ms, machine={"home": (100, 600)}).command(HOME_CW)
    bench.until("AT_HOME")
    motion.start(bench.idle(scan_ms)).scan()
    assert "AT_HOME" not in bench.bits
    bench.out(0 if motion.follows else IMMEDIATE_STOP).run(20)
    assert "STOPPED" in bench.bits
    bench.idle(scan_ms)
    motion.start(bench).scan()
    assert "STOPPED" not in bench.bits


@EVERY_SCAN
@pytest.mark.rules("MC-02", "MC-01")
def test_move_complete_goes_off_and_comes_again(scan_ms):
    bench = completed(scan_ms=scan_ms).relative(100).scan()
    assert "MOVE_COMPLETE" not in bench.bits
    bench.until("MOVE_COMPLETE")
    assert bench.position == 200


NO_MOVES = [
    pytest.param((RESET,), set(), id="Reset Errors", marks=pytest.mark.rules("RST-05")),
    pytest.param((PRESET, 0, 1, 0), set(), id="Preset Position", marks=pytest.mark.rules("PST-04")),
    pytest.param((PRESET_ENCODER, 0, 1, 0), set(), id="Preset Encoder"),
    pytest.param((IMMEDIATE_STOP,), set(), id="Immediate Stop", marks=pytest.mark.rules("IST-04")),
    pytest.param((HOLD,), {"COMMAND_ERROR"}, id="Hold, refused"),
    pytest.param((RESUME, 0, 0, 0, 5, 0, 20, 10), {"COMMAND_ERROR"}, id="Resume, refused"),
    pytest.param((RELATIVE, 0, 1, 0, 0, 999, 20, 10), REFUSED, id="a move, refused"),
    pytest.param((MANUAL_CW, 0, 0, 0, 5, 0, 0, 10), REFUSED, id="manual, refused"),
    pytest.param((HOME_CW, 0, 1, 0, 5, 0, 20, 10), {"COMMAND_ERROR", "HOME_INVALID"}, id="home, refused"),
    pytest.param((MANUAL_CW, FOLLOW, 0, 1), {"COMMAND_ERROR"}, id="follower, refused"),
    pytest.param((0,), set(), id="no command"),
]


@EVERY_SCAN
@pytest.mark.parametrize(("words", "added"), NO_MOVES)
@pytest.mark.rules("MC-03")
def test_nothing_but_a_move_resets_move_complete(words, added, scan_ms):
    bench = completed(scan_ms=scan_ms).out(*words).run(20)
    assert bench.bits == COMPLETE | added
    assert bench.reset_errors(scan_ms).bits == COMPLETE


@EVERY_SCAN
@pytest.mark.rules("MC-03", "EST-02")
def test_inputs_at_rest_do_not_reset_move_complete(scan_ms):
    bench = completed(scan_ms=scan_ms).inputs(estop=1, external=1, cw_limit=1).run(scan_ms)
    assert bench.bits == COMPLETE | {"INPUT_ERROR", "IN_ESTOP", "IN_EXTERNAL", "IN_CW_LIMIT"}


@EVERY_SCAN
@pytest.mark.rules("MC-01", "STOP-02", "STOP-03", "STOP-04", "STS-M03")
def test_at_most_one_of_the_four_ends_is_shown(scan_ms):
    """A move complete, then one cut short, then one held, then one complete again."""
    ends = {"MOVE_COMPLETE", "STOPPED", "HOLD_STATE", "AT_HOME"}
    bench = completed(scan_ms=scan_ms)
    assert bench.bits & ends == {"MOVE_COMPLETE"}
    bench.relative(5_000, ms=100).out(IMMEDIATE_STOP).run(scan_ms)
    assert bench.bits & ends == {"STOPPED"}
    bench.relative(5_000, ms=100).out(HOLD).run(500)
    assert bench.bits & ends == {"HOLD_STATE"}
    bench.relative(5_000).until("MOVE_COMPLETE")
    assert bench.bits & ends == {"MOVE_COMPLETE"}


@EVERY_SCAN
@pytest.mark.rules("POS-01", "MOV-01")
def test_configuring_makes_a_valid_position_invalid(scan_ms):
    bench = Bench.ready(position=1_234, scan_ms=scan_ms)
    assert "POSITION_INVALID" not in bench.bits
    bench.out(*configuration()).run(2)
    bench.out(0).run(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (0, {"MODULE_OK", "POSITION_INVALID"}, ["POS-01"])
    bench.absolute(500, ms=scan_ms)
    assert bench.fired == ["POS-01", "CMD-06"]
