"""Configuration mode requested during a motion [chapter 3, note 2; chapter 6, Command Error 1].

The figures are those of `motions3601`: 600 steps and 200 ms up, 1200 steps and 400 ms down.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    BACKPLANE_PROXIMITY,
    CONFIGURATION,
    ENCODER,
    HOLD,
    HOME_CW,
    IMMEDIATE_STOP,
    MANUAL_CW,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import LONG, REGISTERED, STEPS, TO_STOP, Motion

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
RULES = pytest.mark.rules("CMD-01", "CFG-14")
CONFIGURED = {"MODULE_OK", "MODE_CONFIG"}
AFTERWARDS = {"MODULE_OK", "POSITION_INVALID"}
WITH_ENCODER = configuration(add=ENCODER)


@EVERY_SCAN
@RULES
def test_requested_at_300_ms_of_a_move_of_5000_steps(scan_ms):
    """0.2 s and 0.4 s of ramps, 3200 steps at 5000/s: it ends at 1240 ms, and the next scan enters."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(300)
    bench.out(*CONFIGURATION).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    bench.run(540 - scan_ms)
    assert (bench.position, bench.bits) == (
        3_800,
        {"MODULE_OK", "MOVING_CW", "DECELERATING", "COMMAND_ERROR"},
    )
    bench.run(400)
    assert (bench.position, bench.bits) == (5_000, {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"})
    bench.run(scan_ms)
    assert (bench.bits, bench.words[:4]) == (CONFIGURED, [0xC43E - 0x10000, 0x3F, 1, 0])
    assert bench.fired == ["CMD-01"]
    bench.idle(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (0, AFTERWARDS, ["CMD-01", "POS-01"])


# kind of motion, requested at 100 ms with 200 steps made: its steps, and when it ends
HOW_IT_ENDS = {
    # 600 + 1200 steps and 600 ms of ramps, the rest of 20,000 at 5000/s
    "absolute": (LONG, 600 + (LONG - 1_800) / 5),
    "relative": (LONG, 600 + (LONG - 1_800) / 5),
    # the bit counts as released (reading A-10): a controlled stop
    "manual": (STEPS[100] + TO_STOP[100][0], 100 + TO_STOP[100][1]),
    # likewise: 3000 steps more, at 3000/s but for the last 400 steps and 200 ms
    "registration": (STEPS[100] + REGISTERED, 100 + (REGISTERED - 400) / 3 + 200),
}


@EVERY_SCAN
@RULES
@pytest.mark.parametrize("name", HOW_IT_ENDS)
@pytest.mark.parametrize("sense", ["cw", "ccw"])
def test_the_motion_runs_to_its_end(name, sense, scan_ms):
    motion = Motion.of(f"{name} {sense}")
    steps, ends_ms = HOW_IT_ENDS[name]
    bench = motion.started(100, scan_ms=scan_ms)
    bench.out(*WITH_ENCODER).run(scan_ms)
    assert bench.fired == ["CMD-01"]
    assert bench.bits >= {"MODULE_OK", "COMMAND_ERROR", motion.moving}
    took = bench.until("MODE_CONFIG")
    assert 0 <= 100 + scan_ms + took - ends_ms <= 2 * scan_ms
    assert bench.bits == CONFIGURED
    assert bench.module.machine.shaft == motion.direction * steps
    bench.idle()
    assert (bench.bits, bench.fired) == (AFTERWARDS, ["CMD-01", "POS-01"])


@EVERY_SCAN
@RULES
@pytest.mark.parametrize("motion", [Motion.of("blend cw"), Motion.of("blend ccw")], ids=["cw", "ccw"])
def test_a_blend_move_runs_to_its_end(motion, scan_ms):
    bench = motion.started(100, scan_ms=scan_ms)
    bench.out(*WITH_ENCODER).run(scan_ms)
    assert bench.bits >= {"COMMAND_ERROR", "BLEND_RUNNING"}
    bench.until("MOVE_COMPLETE", "COMMAND_ERROR", clear=["BLEND_RUNNING"])
    bench.run(scan_ms)
    assert bench.bits == CONFIGURED
    assert bench.module.machine.shaft == motion.direction * 25_000  # both segments
    assert bench.fired == ["CMD-01"]


@EVERY_SCAN
@RULES
@pytest.mark.parametrize("levels", [0x3F, 0x3B], ids=["bit 2 set", "bit 2 clear"])
def test_an_encoder_move_runs_to_its_end(levels, scan_ms):
    """Bit 2 of the level word is that of the home switch, not of the encoder move."""
    motion = Motion.of("relative encoder cw")
    bench = motion.started(400, scan_ms=scan_ms)
    bench.out(*configuration(add=ENCODER, levels=levels)).run(scan_ms)
    bench.turn_encoder(LONG, 100).run(500)
    assert (bench.bits, bench.fired) == (CONFIGURED, ["CMD-01"])


@EVERY_SCAN
@RULES
def test_homing_runs_to_its_end(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms, machine={"home": (3_000, 9_000)})
    bench.command(HOME_CW).run(200).out(*CONFIGURATION)
    bench.until("COMMAND_ERROR", "IN_HOME", "MOVING_CCW")
    bench.until("MODE_CONFIG")
    assert (bench.bits, bench.fired) == (CONFIGURED, ["CMD-01"])
    assert bench.module.machine.shaft in (3_000, 3_001)  # a tick after the edge of the switch


@EVERY_SCAN
@pytest.mark.rules("CMD-01")
@pytest.mark.parametrize("what", ["idle", "held", "one-shot", "follower"])
def test_where_there_is_no_move_the_mode_is_entered_at_once(what, scan_ms):
    """A held move is abandoned; a one-shot and the follower end, their bits count as 0 (A-10)."""
    bench = Bench.ready(scan_ms=scan_ms, config=WITH_ENCODER)
    if what == "held":
        bench.relative(LONG).run(400).out(HOLD).run(500).idle()
    elif what == "one-shot":
        bench.command(MANUAL_CW, speed=0).run(10)
    elif what == "follower":
        bench.out(MANUAL_CW, 0x0080, 1, 1).run(10)
    bench.out(*WITH_ENCODER).run(scan_ms)
    assert (bench.bits, bench.fired) == (CONFIGURED, [])
    bench.idle().command(RESUME).run(scan_ms)
    assert (bench.bits, bench.fired) == (AFTERWARDS | {"COMMAND_ERROR"}, ["POS-01", "CMD-08"])


@EVERY_SCAN
@RULES
@pytest.mark.parametrize("cause", ["estop", "cw_limit", "program mode", "hold ramp"])
def test_something_else_ends_the_move_meanwhile(cause, scan_ms):
    """The mode is entered as soon as the axis is at rest, whatever brought it there."""
    bench = Bench.ready(scan_ms=scan_ms).relative(LONG).run(400)
    if cause == "hold ramp":
        bench.out(HOLD).run(200).out(*CONFIGURATION).run(200 - scan_ms)
        assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING", "COMMAND_ERROR"}
    else:
        bench.out(*CONFIGURATION).run(20)
        assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    if cause == "program mode":
        bench.plc("program").run(10)
        assert bench.bits == {"MODULE_OK", "COMMAND_ERROR", "STOPPED", "POSITION_INVALID"}
        bench.plc("run")
    elif cause != "hold ramp":
        bench.inputs(**{cause: 1})
    bench.run(2 * scan_ms)
    assert bench.bits == CONFIGURED


@EVERY_SCAN
@RULES
@pytest.mark.rules("CFG-30", "CFG-16")
@pytest.mark.parametrize("valid", [True, False], ids=["valid", "invalid"])
def test_words_that_waited_are_judged_on_entry(valid, scan_ms):
    """They have not changed since the request; with the mode they become a configuration."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(300)
    bench.out(*configuration(start=777 if valid else 0))
    bench.until("MODE_CONFIG")
    assert bench.bits == CONFIGURED | (set() if valid else {"CONFIG_ERROR"})
    assert bench.words[2:4] == ([0, 777] if valid else [1, 0])
    assert bench.fired == ["CMD-01"] + ([] if valid else ["CFG-06", "CER-02"])
    if valid:
        bench.idle().relative(777, speed=777)
        assert 0 <= bench.until("MOVE_COMPLETE") - 1_000 < scan_ms


@EVERY_SCAN
@RULES
def test_a_request_that_is_withdrawn(scan_ms):
    """The move goes on, the error stays until Reset Errors (reading A-09); Immediate Stop is locked out."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(300)
    bench.out(*CONFIGURATION).run(20).out(IMMEDIATE_STOP).run(20)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    bench.idle()
    bench.until("MOVE_COMPLETE")
    bench.run(100)
    assert (bench.position, bench.bits) == (5_000, {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"})
    bench.reset_errors()
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVE_COMPLETE"}, ["CMD-01"])


@EVERY_SCAN
@RULES
def test_requested_under_another_command_error(scan_ms):
    """It is accepted (reading A-101), and entering clears either error."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(300).idle().relative(1).run(20)
    bench.out(*CONFIGURATION).run(20)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    bench.until("MODE_CONFIG")
    assert (bench.bits, bench.module.machine.shaft) == (CONFIGURED, 5_000)
    bench.idle()
    assert (bench.bits, bench.fired) == (AFTERWARDS, ["CMD-03", "CMD-01", "POS-01"])


@EVERY_SCAN
@RULES
def test_requested_just_before_and_just_after_the_end(scan_ms):
    """5000 steps end at 1240 ms: the scan that begins then finds the axis at rest."""
    for ms, errors in ((1_240 - scan_ms, ["CMD-01"]), (1_240, [])):
        bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(ms).out(*CONFIGURATION).run(scan_ms)
        assert bench.fired == errors
        assert ("MODE_CONFIG" in bench.bits) == (not errors)
        bench.run(scan_ms)
        assert (bench.bits, bench.module.machine.shaft) == (CONFIGURED, 5_000)


@EVERY_SCAN
@pytest.mark.rules("CFG-15", "IOM-19", "LSW-12")
def test_a_configuration_word_is_never_a_command(scan_ms):
    """843Eh has the bits of Hold, Resume, Immediate Stop and Find Home; bit 12 of word 1 is no proximity."""
    bench = Bench.configured(scan_ms=scan_ms, config=configuration(add=BACKPLANE_PROXIMITY))
    bench.command(HOME_CW).run(300).out(*configuration(levels=0x103F)).run(100)
    assert bench.position == 600 + 200 * 5
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "POSITION_INVALID", "COMMAND_ERROR"}
