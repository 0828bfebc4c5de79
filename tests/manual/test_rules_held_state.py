"""What ends a hold state, and what takes from it that it can be resumed [chapter 4, Resume Move].

The held move is the one of `held`: relative 20,000 at 5000/s, deceleration 10, held after 400 ms at
1600 steps. It stops 1200 steps later at 2800.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    BLEND_CW,
    HOLD,
    HOME_CW,
    IMMEDIATE_STOP,
    PRESET,
    PRESET_ENCODER,
    RELATIVE,
    RESET,
    RESUME,
    Bench,
    configuration,
)
from blends3601 import header, transmit
from motions3601 import FOLLOW, MOTIONS, Motion, held

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
HELD = {"MODULE_OK", "HOLD_STATE"}
REFUSED = {"COMMAND_ERROR", "INVALID_PROFILE"}


@EVERY_SCAN
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
@pytest.mark.rules("HLD-04", "HLD-12", "RSM-05")
def test_any_move_may_follow_a_hold_and_ends_it(motion, scan_ms):
    """From then on there is nothing to resume, even if the new move is ended."""
    bench = held(scan_ms=scan_ms)
    motion.start(bench).scan()
    assert "HOLD_STATE" not in bench.bits
    assert bench.fired == []
    bench.run(100).idle(1_000).command(RESUME).run(scan_ms)
    assert bench.fired == ["CMD-08"]


@EVERY_SCAN
@pytest.mark.rules("HLD-04", "CMD-08", "EXT-02")
def test_an_error_from_before_the_hold_leaves_nothing_to_resume(scan_ms):
    """Only Reset Errors is accepted then, and that is a command between Hold and Resume (reading A-83)."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400).idle(scan_ms)
    bench.relative(5, ms=scan_ms).idle(scan_ms).inputs(external=1)
    bench.until("HOLD_STATE")
    bench.inputs(external=0).reset_errors(scan_ms)
    assert bench.bits == HELD
    position = bench.position
    bench.command(RESUME).run(100)
    assert (bench.position, bench.fired) == (position, ["CMD-03", "CMD-08"])


@EVERY_SCAN
@pytest.mark.rules("RSM-01", "CMD-08", "LSW-08")
def test_programming_a_blend_leaves_nothing_to_resume(scan_ms):
    """It is a command, too (reading A-83), even if it is given up after the first block."""
    bench = transmit(held(scan_ms=scan_ms), header())
    assert bench.bits == HELD | {"BLEND_ACK"}
    bench.idle(scan_ms).command(RESUME).run(100)
    assert (bench.position, bench.fired) == (2_800, ["CMD-08"])


# words, bits that they add to those of the hold state
FORFEITS = [
    pytest.param((PRESET, 0, 1, 0), set(), id="Preset Position", marks=pytest.mark.rules("HLD-04")),
    pytest.param((PRESET_ENCODER, 0, 1, 0), set(), id="Preset Encoder", marks=pytest.mark.rules("HLD-04")),
    pytest.param((RESET,), set(), id="Reset Errors", marks=pytest.mark.rules("HLD-04")),
    pytest.param((IMMEDIATE_STOP,), set(), id="Immediate Stop", marks=pytest.mark.rules("IST-04")),
    pytest.param((HOLD,), {"COMMAND_ERROR"}, id="Hold again", marks=pytest.mark.rules("CMD-07")),
    pytest.param((ABSOLUTE | RELATIVE, 0, 0, 0, 5, 0, 20, 10), {"COMMAND_ERROR"}, id="two bits"),
    pytest.param((RELATIVE, 0, 1, 0, 0, 999, 20, 10), REFUSED, id="a move, refused"),
    pytest.param((BLEND_CW, 0, 1), {"COMMAND_ERROR"}, id="a blend move, refused"),
    pytest.param((HOME_CW, 0, 1, 0, 5, 0, 20, 10), {"COMMAND_ERROR", "HOME_INVALID"}, id="home, refused"),
    pytest.param((RESUME, 0, 0, 0, 0, 999, 20, 10), REFUSED, id="Resume, too slow"),
    pytest.param((RESUME, 0, 0, 0, 5, 0, 0, 10), REFUSED, id="Resume, no rate"),
    pytest.param((RESUME, 0, 0, 0, 5, 1_000, 20, 10), REFUSED, id="Resume, no speed"),
    pytest.param((0, FOLLOW, 0, 1), {"COMMAND_ERROR"}, id="follower, refused"),
    pytest.param((0, 0x0300, 1, 0, 0, 10), {"INVALID_PROFILE", "BLEND_ACK"}, id="a blend of one segment"),
    pytest.param((0, 0x0400), set(), id="no minimum registration distance"),
]


@EVERY_SCAN
@pytest.mark.parametrize(("words", "added"), FORFEITS)
@pytest.mark.rules("RSM-01", "CMD-08")
def test_resume_has_to_be_the_first_command_after_a_hold(words, added, scan_ms):
    """Readings A-28, A-83, A-84: the hold state stays to be seen, but cannot be resumed."""
    bench = held(scan_ms=scan_ms)
    bench.out(*words).run(scan_ms)
    assert bench.bits == HELD | added
    bench.idle(scan_ms)
    if added:
        bench.reset_errors(scan_ms)
    here = bench.position
    bench.fired.clear()
    bench.command(RESUME).run(100)
    assert (bench.position, bench.fired) == (here, ["CMD-08"])
    assert bench.bits == HELD | {"COMMAND_ERROR"}


@EVERY_SCAN
@pytest.mark.parametrize("name", ["estop", "cw_limit", "ccw_limit"])
@pytest.mark.rules("RSM-01", "CMD-08")
def test_a_stop_input_ends_what_could_be_resumed(name, scan_ms):
    """Reading A-28; the input is off again when Resume comes."""
    bench = held(scan_ms=scan_ms).inputs(**{name: 1}).run(5)
    bench.inputs(**{name: 0}).run(5).command(RESUME).run(50)
    assert (bench.position, "HOLD_STATE" in bench.bits, bench.fired[-1]) == (2_800, True, "CMD-08")


@EVERY_SCAN
@pytest.mark.parametrize("name", ["capture", "external"])
@pytest.mark.rules("RSM-01")
def test_other_inputs_do_not_end_it(name, scan_ms):
    bench = held(scan_ms=scan_ms).inputs(**{name: 1}).run(5)
    bench.inputs(**{name: 0}).run(5).command(RESUME).until("MOVE_COMPLETE")
    assert bench.position == 20_000


@EVERY_SCAN
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((RELATIVE, 0, 1, 0, 5, 0, 20, 10), id="a move, refused"),
        pytest.param((PRESET,), id="a preset, refused"),
        pytest.param((HOLD | RELATIVE,), id="two bits"),
        pytest.param((RESUME, 0, 0, 0, 5, 0, 20, 10), id="Resume, too early"),
        pytest.param((0, FOLLOW, 1, 1), id="follower, refused"),
    ],
)
@pytest.mark.rules("RSM-01", "CMD-08")
def test_an_error_while_the_axis_is_stopping_ends_it_too(words, scan_ms):
    """Resume needs to be the first command after the Hold, and no error since [chapter 4, Resume Move]."""
    bench = Motion.of("relative cw").started(400, scan_ms=scan_ms).out(HOLD).run(100)
    bench.out(*words).run(20)
    assert "COMMAND_ERROR" in bench.bits
    bench.idle(20).reset_errors(20)
    bench.until("HOLD_STATE")
    assert (bench.position, bench.bits) == (2_800, HELD)
    bench.fired.clear()
    bench.command(RESUME).run(50)
    assert (bench.position, bench.fired) == (2_800, ["CMD-08"])


@EVERY_SCAN
@pytest.mark.rules("RSM-01", "CMD-08")
def test_reset_errors_while_the_axis_is_stopping_is_a_command_too(scan_ms):
    bench = Motion.of("relative cw").started(400, scan_ms=scan_ms).out(HOLD).run(100)
    bench.out(RESET).run(20)
    bench.idle().until("HOLD_STATE")
    bench.command(RESUME).run(50)
    assert (bench.position, bench.fired) == (2_800, ["CMD-08"])


@EVERY_SCAN
@pytest.mark.rules("CMD-08")
def test_resume_during_a_move_is_refused_and_the_move_goes_on(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, ms=400)
    bench.command(RESUME).run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}, ["CMD-08"])
    assert bench.until("MOVE_COMPLETE") == 1_840 - scan_ms
    assert bench.position == 10_000


@EVERY_SCAN
@pytest.mark.rules("CMD-08")
def test_resume_before_the_axis_has_come_to_rest(scan_ms):
    """It is not in a hold state yet: refused, and the stop goes on."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400).out(HOLD).run(200)
    bench.command(RESUME).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING", "COMMAND_ERROR"}
    bench.run(200 - scan_ms)
    assert (bench.position, bench.bits) == (2_800, HELD | {"COMMAND_ERROR"})


@EVERY_SCAN
@pytest.mark.rules("CMD-08")
def test_resume_without_a_hold_is_refused(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).command(RESUME, ms=50)
    assert (bench.position, bench.bits, bench.fired) == (0, {"MODULE_OK", "COMMAND_ERROR"}, ["CMD-08"])


# -- across modes ---------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("HLD-12", "CMD-08")
def test_configuration_mode_abandons_a_hold(scan_ms):
    bench = held(scan_ms=scan_ms)
    bench.out(*configuration()).run(4)
    bench.out(0).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.command(RESUME).run(50)
    assert (bench.position, bench.fired[-1]) == (0, "CMD-08")


@EVERY_SCAN
@pytest.mark.rules("RSM-01")
def test_program_mode_leaves_a_hold_alone(scan_ms):
    """Nothing moved, so nothing is stopped and nothing lost (reading A-78)."""
    bench = held(scan_ms=scan_ms).plc("program").run(20)
    assert bench.bits == HELD
    bench.plc("run").run(4).command(RESUME).until("MOVE_COMPLETE")
    assert bench.position == 20_000


@EVERY_SCAN
@pytest.mark.rules("HLD-01")
def test_program_mode_cuts_the_stop_of_a_hold(scan_ms):
    """From 5000/s, 100 ms of 400: 450 steps of 1200."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400).out(HOLD).run(100)
    bench.plc("program").run(scan_ms)
    assert (bench.position, bench.bits) == (2_050, {"MODULE_OK", "STOPPED", "POSITION_INVALID"})


@EVERY_SCAN
@pytest.mark.rules("MAN-01", "HLD-12")
def test_a_manual_move_replaces_a_hold(scan_ms):
    bench = held(scan_ms=scan_ms).manual(ms=200)
    assert (bench.position, bench.bits) == (3_400, {"MODULE_OK", "MOVING_CW"})
    bench.idle(400)
    assert (bench.position, bench.bits) == (4_600, {"MODULE_OK", "STOPPED"})
