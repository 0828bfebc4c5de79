"""The PLC leaves run mode [chapter 5, Programming Information 9; reading A-78].

Any motion is cut, the position is lost; the module keeps its mode and the last word 0, so that
nothing starts by itself when the PLC runs again. The figures are those of `motions3601`.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    CONFIGURATION,
    ENCODER,
    HOLD,
    HOME_CW,
    PRESET,
    RELATIVE,
    RESET,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import AT_REST, FOLLOW, LONG, MOTIONS, STEPS, Motion, program_blend
from refusals3601 import goes

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
CUT = {"MODULE_OK", "STOPPED", "POSITION_INVALID"}


@EVERY_SCAN
@pytest.mark.rules("PRG-01")
@pytest.mark.parametrize("ms", [100, 400], ids=["accelerating", "at speed"])
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_any_motion_is_cut(motion, ms, scan_ms):
    """In the scan that sees it, without deceleration; running again starts nothing."""
    bench = motion.started(ms, scan_ms=scan_ms).plc("program").run(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (motion.steps(ms), CUT, ["PRG-01"])
    bench.run(200).plc("run").run(200)
    assert (bench.position, bench.bits, bench.fired) == (motion.steps(ms), CUT, ["PRG-01"])
    bench.idle(200)
    assert (bench.position, bench.bits) == (motion.steps(ms), CUT)
    goes(bench)


@EVERY_SCAN
@pytest.mark.rules("PRG-01")
@pytest.mark.parametrize("what", ["hold ramp", "stop ramp", "homing waits at a limit"])
def test_a_motion_that_is_ending_is_cut_too(what, scan_ms):
    """No hold is left; the two seconds of homing on a limit are part of its motion."""
    bench = Bench.ready(scan_ms=scan_ms)
    if what == "hold ramp":
        bench.relative(LONG).run(400).out(HOLD).run(100)
    elif what == "stop ramp":
        bench.manual().run(400).idle(100)
    else:
        bench.command(HOME_CW).run(400).inputs(cw_limit=1).run(100).inputs(cw_limit=0).run(2)
    position = bench.position
    bench.plc("program").run(scan_ms)
    assert (bench.bits, bench.fired, bench.position) == (CUT, ["PRG-01"], position)
    bench.run(3_000).plc("run").run(10).idle().command(RESUME).run(10)
    assert (bench.position, bench.fired) == (position, ["PRG-01", "CMD-08"])


@EVERY_SCAN
@pytest.mark.rules("PRG-01")
@pytest.mark.parametrize("rest", [each.name for each in AT_REST])
def test_an_axis_at_rest_keeps_position_and_bits(rest, scan_ms):
    """A hold can still be resumed afterwards."""
    bench = Motion.of(rest).bench(scan_ms=scan_ms)
    image = bench.words
    bench.plc("program").run(100).plc("run").run(10)
    assert (bench.words, bench.fired) == (image, [])
    if rest == "held":
        bench.command(RESUME).run(1)
        assert "MOVING_CW" in bench.bits
    else:
        goes(bench)


@pytest.mark.rules("PRG-01")
def test_a_one_shot_is_over_though_its_bit_is_held():
    """Its step is made, so the position stays valid; only the direction bit goes off."""
    bench = Bench.ready().manual(speed=0, ms=5)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.plc("program").run(1)
    assert (bench.position, bench.bits, bench.fired) == (1, {"MODULE_OK"}, [])
    bench.plc("run").run(5).idle()
    assert (bench.position, bench.bits) == (1, {"MODULE_OK"})


@EVERY_SCAN
@pytest.mark.parametrize(
    ("switches", "bits"),
    [
        ({"invalid_after_program_mode": False}, {"MODULE_OK", "STOPPED"}),
        ({"stopped_after_program_mode": False}, {"MODULE_OK", "POSITION_INVALID"}),
        ({"invalid_after_program_mode": False, "stopped_after_program_mode": False}, {"MODULE_OK"}),
    ],
)
def test_switches_of_what_is_shown(switches, bits, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms, **switches).relative(LONG).run(400).plc("program").run(100)
    assert (bench.position, bench.bits, bench.fired) == (STEPS[400], bits, ["PRG-01"])


# -- words in program mode ------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("PRG-01", "IOM-19")
def test_no_word_is_acted_on(scan_ms):
    """Neither commands nor the mode bit; they are edges once the PLC runs."""
    bench = Bench.ready(scan_ms=scan_ms, position=3).plc("program")
    for words in (
        (PRESET, 0, 0, 9),
        (RELATIVE, 0, 0, 9, 5, 0, 20, 10),
        CONFIGURATION,
        (0, 0x0400, 0, 9),
        (3,),
    ):
        bench.out(*words).run(20)
        assert (bench.position, bench.bits, bench.fired) == (3, {"MODULE_OK"}, [])
    bench.out(PRESET, 0, 0, 9).plc("run").run(scan_ms)
    assert bench.position == 9


@EVERY_SCAN
@pytest.mark.rules("PRG-01", "IOM-19")
def test_word_0_is_remembered_from_run_mode(scan_ms):
    """A bit that was set when the PLC stopped is not an edge when it runs, even if it was 0 meanwhile."""
    bench = Bench.ready(scan_ms=scan_ms).relative(7, ms=100)
    bench.plc("program").idle(20).relative(7, ms=20).plc("run").run(20)
    assert (bench.position, bench.bits) == (7, {"MODULE_OK", "MOVE_COMPLETE"})
    bench.idle().relative(7, ms=100)
    assert bench.position == 14
    bench.plc("program").run(20).absolute(0, ms=20).plc("run").run(100)
    assert bench.position == 0


@EVERY_SCAN
@pytest.mark.rules("PRG-01")
def test_the_follower_needs_a_new_edge_of_its_bit(scan_ms):
    motion = Motion.of("follower cw")
    bench = motion.started(100, scan_ms=scan_ms)
    bench.plc("program").run(20).plc("run").run(100)
    assert bench.bits == CUT
    bench.out(0).run(scan_ms).out(0, FOLLOW, 1, 1).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "ENC_FOLLOWER"}


@EVERY_SCAN
@pytest.mark.rules("PRG-01", "CFG-15")
def test_the_module_stays_in_configuration_mode(scan_ms):
    """Words 0 to 3 stay mirrored, others are not judged; then the mode is left as ever."""
    bench = Bench.ready(scan_ms=scan_ms).out(*CONFIGURATION).run(10).plc("program")
    image = bench.words
    bench.out(*configuration(drop=4)).run(20).out(0).run(20)
    assert (bench.words, bench.fired) == (image, [])
    bench.plc("run").run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "POSITION_INVALID"}, ["POS-01"])


@pytest.mark.rules("PRG-01", "RST-03")
def test_a_command_error_stays_through_program_mode():
    bench = Bench.ready().out(HOLD).run(1).plc("program").run(10).out(RESET).run(10)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"}
    bench.plc("run").run(1)
    assert bench.bits == {"MODULE_OK"}


@pytest.mark.rules("PRG-01", "INP-01", "STS-L03")
def test_inputs_are_looked_at_in_program_mode():
    """An emergency stop of the resting axis is an input error as ever (reading A-15)."""
    bench = Bench.ready().plc("program").run(10).inputs(estop=1, cw_limit=1).run(1)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP", "IN_CW_LIMIT"}
    bench.inputs(estop=0, cw_limit=0).plc("run").run(1)
    goes(bench)


@pytest.mark.rules("PRG-01")
def test_two_causes_in_one_scan():
    """Program mode and the emergency stop: the motion is cut once, the input error comes with its edge."""
    bench = Bench.ready().relative(LONG, ms=400).plc("program").inputs(estop=1).run(1)
    assert (bench.position, bench.bits) == (STEPS[400], CUT | {"INPUT_ERROR", "IN_ESTOP"})
    bench = Bench.ready().relative(2_000, speed=1_000, ms=2_000)
    assert (bench.position, "MOVE_COMPLETE" in bench.bits) == (2_000, True)
    bench.plc("program").run(1)  # in the very scan in which the move has ended
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVE_COMPLETE"}, [])


@pytest.mark.rules("PRG-01")
def test_a_stop_shorter_than_a_scan_of_the_module_is_none():
    bench = Bench.ready().relative(LONG, ms=400).plc("program").plc("run").run(1)
    assert (bench.position, bench.fired) == (STEPS[400] + 5, [])


@pytest.mark.rules("PRG-01", "IOM-04")
def test_power_comes_back_while_the_plc_is_in_program_mode():
    bench = Bench.ready().plc("program").run(1).out(*CONFIGURATION).power_cycle().run(50)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    bench.plc("run").run(1)
    assert bench.bits == {"MODULE_OK", "MODE_CONFIG"}


@pytest.mark.rules("PRG-01")
def test_what_is_stored_stays():
    """A blend profile and the minimum registration distance are no motion."""
    bench = Bench.ready(config=configuration(add=ENCODER))
    program_blend(bench)
    bench.out(0, 0x0400, 0, 50).run(1).idle().plc("program").run(50).plc("run").run(1)
    assert bench.bits == {"MODULE_OK", "MIN_REG_NONZERO"}
    bench.out(0x1000).run(1)
    assert "BLEND_RUNNING" in bench.bits
