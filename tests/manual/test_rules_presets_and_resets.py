"""Presets and Reset Errors [chapter 4; chapter 5, Command Word MSW bits 9 to 11]."""

from __future__ import annotations

import pytest
from bench3601 import (
    DIAGNOSTIC,
    ENCODER,
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
from motions3601 import LONG, MOTIONS, STEPS, program_blend
from refusals3601 import COMMAND_ERRORS, MOTION, PROFILE_ERRORS, after_a_move, goes, refused

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
UNDER_WAY = [motion for motion in MOTIONS if not motion.follows]
LEFT_ALONE = [motion for motion in UNDER_WAY if not motion.name.startswith(("manual", "registration"))]
WITH_ENCODER = configuration(add=ENCODER)
VALUES = [
    ((0, 0), 0),
    ((0, 1), 1),
    ((-12, -345), -12_345),
    ((-12, 0), -12_000),
    ((0, -345), -345),
    ((8_388, 607), 8_388_607),
    ((-8_388, -608), -8_388_608),
]

# -- Preset Position ------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("PST-01", "PST-02", "POS-01", "STS-M10", "IOM-03")
@pytest.mark.parametrize(("words", "value"), VALUES)
def test_preset_position(words, value, scan_ms):
    """The position is the target and valid in the next image; the encoder value is left alone."""
    bench = Bench.configured(scan_ms=scan_ms, config=WITH_ENCODER)
    bench.turn_encoder(11, 10)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.out(PRESET, 0, *words).run(scan_ms)
    assert (bench.position, bench.bits) == (value, {"MODULE_OK"})
    assert (bench.words[2:4], bench.encoder, bench.fired) == (list(words), 11, [])
    bench.idle().absolute(value, ms=1)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


@pytest.mark.rules("PST-04", "PST-01", "MC-03", "HLD-12")
@pytest.mark.parametrize("command", [PRESET, PRESET_ENCODER], ids=["position", "encoder"])
def test_a_preset_leaves_every_other_bit(command):
    """Move Complete, Stopped, At Home, Hold, Input Error [chapter 5, bit 9; reading A-03]."""
    bench = after_a_move(config=WITH_ENCODER)
    for reach in (None, stop, go_home, press_estop, hold):
        if reach is not None:
            reach(bench)
        bits = bench.bits - {"POSITION_INVALID"}
        bench.out(PRESET, 0, 0, 7).run(1).out(command, 0, 0, 7).run(1).idle()
        assert bench.bits == bits


def stop(bench: Bench) -> None:
    bench.relative(LONG, ms=100).out(IMMEDIATE_STOP).run(1).idle()
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}


def go_home(bench: Bench) -> None:
    bench.command(HOME_CW, ms=10).inputs(home=1).run(500).inputs(home=0).run(1_000).inputs(home=1).run(1_000)
    bench.inputs(home=0).idle()
    assert bench.bits == {"MODULE_OK", "AT_HOME"}


def press_estop(bench: Bench) -> None:
    bench.inputs(estop=1).run(1).inputs(estop=0).run(1)
    assert bench.bits == {"MODULE_OK", "AT_HOME", "INPUT_ERROR"}


def hold(bench: Bench) -> None:
    bench.relative(LONG, ms=300).out(HOLD).run(500).idle()
    assert bench.bits == {"MODULE_OK", "HOLD_STATE"}


@pytest.mark.rules("PST-02")
def test_a_preset_makes_an_absolute_move_possible_again():
    bench = Bench.ready()
    stop(bench)
    bench.absolute(0).run(1)
    assert bench.fired[-1] == "CMD-06"
    bench.reset_errors()
    bench.out(PRESET, 0, 0, 500).run(1).absolute(600).run(200)
    assert (bench.position, bench.bits) == (600, {"MODULE_OK", "MOVE_COMPLETE"})


@pytest.mark.rules("PST-05", "DFB-02")
def test_preset_position_sets_the_diagnostic_count_too():
    """Wired or not; the count then goes on with the steps from there."""
    for wired in (True, False):
        bench = Bench.configured(config=configuration(add=DIAGNOSTIC), diagnostic_wiring=wired)
        bench.relative(250, ms=200).idle()
        assert (bench.position, bench.encoder) == (250, 250 if wired else 0)
        bench.out(PRESET, 0, -12, -345).run(1).idle()
        assert (bench.position, bench.encoder) == (-12_345, -12_345)
        bench.relative(250, ms=200)
        assert (bench.position, bench.encoder) == (-12_095, -12_095 if wired else -12_345)


# -- Preset Encoder -------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("PST-06", "IOM-13")
@pytest.mark.parametrize(("words", "value"), VALUES)
def test_preset_encoder(words, value, scan_ms):
    """The position and its validity stay as they are; the count goes on from the new value."""
    bench = Bench.configured(scan_ms=scan_ms, config=WITH_ENCODER).relative(5, ms=50).idle()
    bench.out(PRESET_ENCODER, 0, *words).run(scan_ms)
    assert bench.words[4:6] == list(words)
    bench.turn_encoder(-40, 10)
    assert (bench.encoder, bench.position) == (value - 40, 5)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVE_COMPLETE"}
    assert bench.fired == []


@pytest.mark.rules("PST-07", "CMD-11")
@pytest.mark.parametrize("add", [0, DIAGNOSTIC], ids=["no encoder", "diagnostic feedback"])
def test_preset_encoder_needs_an_encoder(add):
    """Diagnostic feedback is none (reading A-70)."""
    bench = after_a_move(config=configuration(add=add), diagnostic_wiring=True)
    bench.out(PRESET_ENCODER, 0, 0, 7)
    refused(bench, "CMD-11", errors=COMMAND_ERRORS)


# -- what neither takes ---------------------------------------------------------------------------

BOTH = pytest.mark.parametrize("command", [PRESET, PRESET_ENCODER], ids=["position", "encoder"])


@BOTH
@pytest.mark.rules("PST-03", "CMD-09")
@pytest.mark.parametrize("at", [4, 5, 6, 7])
@pytest.mark.parametrize("data", [1, -1])
def test_a_preset_with_speed_or_rates(command, at, data):
    """Command Error only, and the value stays; with zeros in words 4 to 7 it is accepted."""
    bench = after_a_move(config=WITH_ENCODER)
    words = [command, 0, 1, 234, 0, 0, 0, 0]
    bench.out(*words[:at], data, *words[at + 1 :])
    refused(bench, "CMD-09", errors=COMMAND_ERRORS)
    bench.out(*words).run(1)
    assert (bench.position if command == PRESET else bench.encoder) == 1_234


@BOTH
@pytest.mark.rules("CMD-04", "IOM-10")
@pytest.mark.parametrize(
    ("bad", "good"),
    [
        ((8_388, 608), (8_388, 607)),
        ((-8_388, -609), (-8_388, -608)),
        ((0, 1_000), (0, 999)),
        ((0, -1_000), (0, -999)),
        ((-12, 345), (-12, 0)),
    ],
)
def test_a_preset_to_no_value(command, bad, good):
    """Command Error only: a preset is not a move, and has no profile that could be invalid."""
    bench = after_a_move(config=WITH_ENCODER)
    bench.out(command, 0, *bad)
    refused(bench, "CMD-04", errors=COMMAND_ERRORS)
    bench.out(command, 0, *good).run(1)
    assert bench.words[2:4] == list(good) or bench.words[4:6] == list(good)


@BOTH
@pytest.mark.parametrize("bit", range(16))
def test_a_preset_with_a_command_lsw(command, bit):
    """The manual wants it zero and says no more; it is refused (reading A-31)."""
    bench = after_a_move("2.2", config=WITH_ENCODER)
    bench.out(command, 1 << bit, 1, 234).run(1)
    assert (bench.fired, bench.position, bench.encoder) == (["PST-08"], 0, 0)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}


@EVERY_SCAN
@pytest.mark.rules("PST-01", "PST-06")
@pytest.mark.parametrize(("command", "rule"), [(PRESET, "PST-01"), (PRESET_ENCODER, "PST-06")])
@pytest.mark.parametrize("motion", UNDER_WAY, ids=lambda motion: motion.name)
def test_no_preset_during_a_motion(motion, command, rule, scan_ms):
    """Command Error (reading A-82); the motion goes on, a manual one ends as its bit is off."""
    bench = motion.started(200, scan_ms=scan_ms)
    bench.out(command, 0, *list(bench.outputs)[2:4]).run(scan_ms)
    assert bench.fired == [rule]
    assert bench.bits >= {"MODULE_OK", "COMMAND_ERROR", motion.moving}
    assert abs(bench.position - motion.direction * STEPS[200]) <= 5 * scan_ms
    assert bench.encoder == 0
    assert ("DECELERATING" in bench.bits) == motion.name.startswith("manual")


@pytest.mark.rules("PST-01", "PST-06")
@pytest.mark.parametrize(("command", "rule"), [(PRESET, "PST-01"), (PRESET_ENCODER, "PST-06")])
def test_that_a_motion_runs_is_told_before_what_is_wrong_with_a_preset(command, rule):
    bench = Bench.ready().relative(LONG, ms=200)
    bench.out(command, 1, 0, 0, 1).run(1)
    assert bench.fired == [rule]


@pytest.mark.rules("PST-01")
def test_a_preset_while_a_one_shot_bit_was_held():
    """Its step is over: the preset is accepted in the image that releases the bit."""
    bench = Bench.ready().manual(speed=0, ms=5).out(PRESET, 0, 0, 9).run(1)
    assert (bench.position, bench.bits, bench.fired) == (9, {"MODULE_OK"}, [])


# -- Reset Errors ---------------------------------------------------------------------------------


def with_every_error() -> Bench:
    """Homing too slow: three bits; emergency stop: Input Error; an Immediate Stop before that."""
    bench = Bench.ready(config=WITH_ENCODER)
    stop(bench)
    bench.inputs(estop=1).run(1)
    bench.command(HOME_CW, speed=999).run(1)
    bench.fired.clear()
    return bench


@EVERY_SCAN
@pytest.mark.rules("RST-01", "RST-04", "STS-M08", "STS-M09", "STS-M11", "STS-M12")
def test_reset_errors_clears_four_bits_at_once(scan_ms):
    """Also with the emergency stop still on (reading A-87); Position Invalid and Stopped stay."""
    bench = with_every_error()
    stays = {"MODULE_OK", "STOPPED", "POSITION_INVALID", "IN_ESTOP"}
    assert bench.bits == stays | PROFILE_ERRORS | {"HOME_INVALID", "INPUT_ERROR"}
    bench.out(RESET).run(scan_ms)
    assert (bench.bits, bench.fired) == (stays, [])
    bench.idle(50)
    assert bench.bits == stays
    bench.relative(5, ms=1)
    assert bench.bits == stays | {"INPUT_ERROR"}


@pytest.mark.rules("RST-05", "MC-03", "RST-01")
def test_reset_errors_leaves_how_the_last_motion_ended():
    for reach in (None, stop, go_home, hold):
        bench = after_a_move()
        if reach is not None:
            reach(bench)
        bits = bench.bits
        bench.reset_errors()
        assert bench.bits == bits
        bench.out(0x0003).run(1).reset_errors()
        assert bench.bits == bits


@pytest.mark.rules("RST-01", "CFG-13")
def test_reset_errors_does_not_clear_a_configuration_error():
    bench = Bench().out(RESET).run(2)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}


@pytest.mark.rules("RST-01")
def test_words_2_to_7_of_reset_errors_are_ignored():
    """Only the lower command word has to be zero (reading A-92)."""
    bench = with_every_error().out(RESET, 0, -1, 1, 9_999, -9_999, 2_001, -1).run(1)
    assert "COMMAND_ERROR" not in bench.bits


@pytest.mark.parametrize("bit", range(16))
def test_reset_errors_with_a_command_lsw(bit):
    """Not executed (reading A-31): it is a command error itself, or under one it is ignored."""
    bench = after_a_move("2.2").out(RESET, 1 << bit).run(1)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}
    assert bench.fired[-1] == "RST-02"
    bench = with_every_error()
    bits = bench.bits
    bench.out(RESET, 1 << bit).run(1)
    assert (bench.bits - {"HOME_PROX_ECHO"}, bench.fired) == (bits, [])


OTHERS = [(1 << bit, 0) for bit in range(15) if 1 << bit != RESET]
OTHERS += [(RESET | RELATIVE, 0), (0, 0x0080), (0x0080, 0x0080), (0, 0x0300), (0, 0x0400), (0, 0x1000)]


@EVERY_SCAN
@pytest.mark.rules("RST-03", "STS-M12", "IST-06")
@pytest.mark.parametrize(("msw", "lsw"), OTHERS, ids=[f"{msw:04X}h-{lsw:04X}h" for msw, lsw in OTHERS])
def test_nothing_else_is_accepted_under_a_command_error(msw, lsw, scan_ms):
    """No command, no follower, no blend block, no minimum distance: neither effect nor further error."""
    bench = Bench.ready(scan_ms=scan_ms, config=WITH_ENCODER)
    program_blend(bench)
    bench.command(RESUME).run(scan_ms).idle(scan_ms)
    words, fired = bench.words, bench.fired
    assert (bench.bits, fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-08"])
    bench.out(msw, lsw, 0, 7, *((5, 0, 20, 10) if msw & 0x01FF else ())).run(50)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "COMMAND_ERROR"}
    assert (bench.words[2:], bench.fired) == (words[2:], ["CMD-08"])
    bench.idle().reset_errors()
    assert bench.bits == {"MODULE_OK"}
    bench.out(0x1000).run(1)  # the blend profile is still there
    assert "BLEND_RUNNING" in bench.bits


@EVERY_SCAN
@pytest.mark.rules("RST-03", "RST-01")
@pytest.mark.parametrize("motion", LEFT_ALONE, ids=lambda motion: motion.name)
def test_a_running_motion_does_not_mind_error_and_reset(motion, scan_ms):
    """Reset Errors is accepted during it (reading A-85); then Immediate Stop is, too."""
    bench = motion.started(200, scan_ms=scan_ms)
    bench.command(RESUME).run(scan_ms)
    assert (bench.fired, bench.bits) == (["CMD-08"], {"MODULE_OK", "COMMAND_ERROR"} | motion.shown)
    bench.out(IMMEDIATE_STOP).run(scan_ms).out(RESET).run(scan_ms)
    assert bench.bits == {"MODULE_OK"} | motion.shown
    bench.run(200 - 3 * scan_ms)
    assert (bench.position, bench.fired) == (motion.direction * STEPS[400], ["CMD-08"])
    bench.out(IMMEDIATE_STOP).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}


@pytest.mark.rules("RST-01", "RST-03")
def test_the_error_of_a_refused_command_is_reset_in_the_very_next_image():
    """Each image acts on its own scan: error, reset, move, a scan each."""
    bench = Bench.ready().out(HOLD).scan()
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"}
    bench.out(RESET).scan()
    assert bench.bits == {"MODULE_OK"}
    bench.relative(5).scan()
    assert bench.bits & MOTION
    bench.until("MOVE_COMPLETE")
    goes(bench)
