"""Blend moves: the profile as it runs, what may come between, what keeps and what erases it [chapter 4].

Starting speed 1000. `TWO`: 200 ms up over 600 steps, 480 ms at 5000/s; 300 ms
down over 1050 steps, 500 ms at 2000/s; 100 ms and 150 steps to the end.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    BLEND_CCW,
    BLEND_CW,
    CONFIGURATION,
    HOLD,
    HOME_CW,
    IMMEDIATE_STOP,
    PRESET,
    RELATIVE,
    Bench,
    configuration,
)
from blends3601 import PROGRAM, TWO, TWO_MS, TWO_STEPS, C, T, Z, header, legs, program, transmit

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])


def run_blend(bench: Bench, direction: int = 1) -> Bench:
    return bench.out(BLEND_CW if direction > 0 else BLEND_CCW)


def moving(direction: int) -> str:
    return "MOVING_CW" if direction > 0 else "MOVING_CCW"


# -- running it


@pytest.mark.rules("CMD-16")
@pytest.mark.parametrize("msw", [BLEND_CW, BLEND_CCW])
def test_nothing_to_run(msw):
    bench = Bench.ready()
    bench.out(msw).run(10)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-16"])
    bench.idle().reset_errors()
    assert (bench.bits, bench.position) == ({"MODULE_OK"}, 0)


@pytest.mark.rules("CMD-17")
@pytest.mark.parametrize("msw", [BLEND_CW, BLEND_CCW])
@pytest.mark.parametrize("word", range(2, 8))
def test_data_in_any_word_is_an_error(word, msw):
    bench = program(Bench.ready())
    bench.out(msw, *(int(number == word) for number in range(1, 8))).run(10)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-17"])
    bench.idle().reset_errors().out(msw).run(1)
    assert "BLEND_RUNNING" in bench.bits


@pytest.mark.rules("BLD-06", "BLD-07")
def test_again_and_again_from_any_position_valid_or_not():
    bench = program(Bench.configured())
    assert "POSITION_INVALID" in bench.bits
    where = 0
    for direction in (1, 1, -1, 1, -1, -1):
        run_blend(bench, direction).until("MOVE_COMPLETE")
        where += direction * TWO_STEPS
        assert bench.position == where
        bench.idle()
    bench.relative(123).until("MOVE_COMPLETE")
    assert run_blend(bench.idle()).until("MOVE_COMPLETE") == TWO_MS
    assert bench.position == where + 123 + TWO_STEPS
    assert "POSITION_INVALID" in bench.bits


@pytest.mark.rules("BLD-20")
def test_the_bit_has_to_rise_for_every_run():
    bench = program(Bench.ready())
    run_blend(bench).until("MOVE_COMPLETE")
    bench.run(TWO_MS)
    assert (bench.position, bench.bits) == (TWO_STEPS, {"MODULE_OK", "MOVE_COMPLETE"})


@EITHER_WAY
@pytest.mark.rules("BLD-20", "CMD-03")
def test_other_moves_have_to_wait(direction):
    """The error is not one that goes off by itself."""
    bench = program(Bench.ready())
    run_blend(bench, direction).run(400)
    bench.command(RELATIVE, 100, ms=1)
    assert bench.bits == {"MODULE_OK", "BLEND_RUNNING", "COMMAND_ERROR", moving(direction)}
    bench.until("MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (direction * TWO_STEPS, ["CMD-03"])


@pytest.mark.rules("EXT-04")
def test_the_external_input_has_no_effect():
    bench = program(Bench.ready())
    bench.inputs(external=1)
    assert run_blend(bench).until("MOVE_COMPLETE") == TWO_MS


@pytest.mark.rules("LIM-01", "STOP-02", "STOP-03", "STOP-04", "BLD-20")
@pytest.mark.parametrize("cause", ["cw_limit", "ccw_limit", "estop", "stop"])
def test_what_cuts_it(cause):
    bench = program(Bench.ready())
    run_blend(bench).run(400)
    if cause == "stop":
        bench.out(IMMEDIATE_STOP)
    else:
        bench.inputs(**{cause: 1})
    bench.scan()
    assert {name for name in bench.bits if not name.startswith("IN_")} == {
        "MODULE_OK",
        "STOPPED",
        "POSITION_INVALID",
    } | ({"INPUT_ERROR"} if cause != "stop" else set())
    assert bench.position == 600 + 5 * 200
    bench.inputs(cw_limit=0, ccw_limit=0, estop=0).idle()
    assert run_blend(bench).until("MOVE_COMPLETE") == TWO_MS  # the profile is still there


@pytest.mark.rules("BLD-24", "INP-01", "INP-02")
@pytest.mark.parametrize("name", ["cw_limit", "ccw_limit", "estop"])
def test_it_is_not_started_on_a_limit_or_under_the_emergency_stop(name):
    """Readings A-16 and A-17: Input Error alone."""
    bench = program(Bench.ready())
    bench.inputs(**{name: 1}).run(1).reset_errors()
    run_blend(bench).run(10)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_" + name.upper()}
    bench.inputs(**{name: 0}).idle()
    assert run_blend(bench).until("MOVE_COMPLETE") == TWO_MS


@pytest.mark.rules("BLD-05")
def test_the_image_that_ends_programming_may_start_it():
    bench = run_blend(program(Bench.ready(), end=False))
    assert bench.until("MOVE_COMPLETE") == TWO_MS
    assert (bench.position, bench.fired) == (TWO_STEPS, [])


@pytest.mark.rules("CMD-02")
def test_both_directions_at_once_are_an_error():
    bench = program(Bench.ready())
    bench.out(BLEND_CW | BLEND_CCW).run(5)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-02"])


@pytest.mark.rules("BLD-09", "HLD-12")
def test_it_takes_the_place_of_a_held_move():
    bench = program(Bench.ready()).relative(9000, ms=400)
    bench.out(HOLD).until("HOLD_STATE")
    held = bench.position
    run_blend(bench.idle()).run(1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING", "BLEND_RUNNING"}
    bench.until("MOVE_COMPLETE")
    assert bench.position == held + TWO_STEPS


# -- Hold


@BOTH_PERIODS
@pytest.mark.rules("CMD-19", "HLD-07", "STS-M07")
@pytest.mark.parametrize("after_ms", [100, 400, 800, 1_200, 1_550])
def test_hold_is_an_error_until_the_profile_is_complete(after_ms, scan_ms):
    bench = program(Bench.ready(scan_ms=scan_ms))
    run_blend(bench).run(after_ms)
    bench.out(HOLD).scan()
    assert {"COMMAND_ERROR", "BLEND_RUNNING", "MOVING_CW"} <= bench.bits
    left = bench.until(clear=["COMMAND_ERROR"])
    assert after_ms + scan_ms + left == TWO_MS
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert (bench.position, bench.fired) == (TWO_STEPS, ["CMD-19"])


@pytest.mark.rules("CMD-19")
def test_the_error_of_a_hold_goes_off_only_with_a_complete_profile():
    bench = program(Bench.ready())
    run_blend(bench).run(400)
    bench.out(HOLD).run(10).inputs(estop=1).run(1)
    assert {"COMMAND_ERROR", "STOPPED", "INPUT_ERROR"} <= bench.bits
    bench.inputs(estop=0).reset_errors()
    run_blend(bench).run(400)
    bench.out(HOLD).run(10).reset_errors()
    assert bench.bits == {"MODULE_OK", "BLEND_RUNNING", "MOVING_CW", "POSITION_INVALID"}
    bench.until("MOVE_COMPLETE")


@pytest.mark.rules("CMD-19")
def test_a_forgiven_hold_does_not_cost_move_complete():
    """Not even if errors do (reading A-27)."""
    bench = program(Bench.ready(complete_after_error=False))
    run_blend(bench).run(400)
    bench.out(HOLD).run(2_000)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


# -- what keeps the profile, and what erases it


def keeps(bench: Bench) -> bool:
    bench.idle().inputs(estop=0, cw_limit=0).reset_errors()
    run_blend(bench).run(1)
    return "BLEND_RUNNING" in bench.bits


KEPT = {
    "moves": lambda bench: bench.relative(50, ms=100).idle().command(ABSOLUTE, 0, ms=100),
    "a manual move": lambda bench: bench.manual(ms=100).idle(500),
    "homing": lambda bench: bench.inputs(cw_limit=1).command(HOME_CW, ms=2_500).out(IMMEDIATE_STOP).run(1),
    "a preset": lambda bench: bench.out(PRESET, 0, 5).run(1),
    "a stop": lambda bench: run_blend(bench).run(100).out(IMMEDIATE_STOP).run(1),
    "an input error": lambda bench: run_blend(bench).run(100).inputs(estop=1).run(1),
    "a command error": lambda bench: bench.out(HOLD).run(1),
    "program mode": lambda bench: bench.plc("program").run(100).plc("run").run(1),
    "a minimum registration distance": lambda bench: bench.out(0, 0x0400, 5).run(1),
    "a rejected command": lambda bench: bench.out(BLEND_CW, 0, 0, 1).run(1),
    "a transmit bit alone": lambda bench: bench.out(0, 0x0200).run(1),
    "a program bit alone": lambda bench: bench.out(0, PROGRAM).run(1),
}


@pytest.mark.rules("BLD-07", "BLD-09", "BLD-24")
@pytest.mark.parametrize("between", KEPT.values(), ids=KEPT)
def test_what_does_not_erase_the_profile(between):
    bench = program(Bench.ready())
    between(bench)
    assert keeps(bench)


@pytest.mark.rules("BLD-09")
def test_homing_between_two_runs():
    bench = program(Bench.configured(machine={"home": (6000, 6500)}))
    run_blend(bench).until("MOVE_COMPLETE")
    bench.idle().command(HOME_CW).until("AT_HOME")
    run_blend(bench.idle()).until("MOVE_COMPLETE")
    assert bench.position == TWO_STEPS


ERASED = {
    "the same configuration": lambda bench: bench.out(*CONFIGURATION).run(5),
    "another configuration": lambda bench: bench.out(*configuration(start=900)).run(5),
    "a first block": lambda bench: transmit(bench, header()),
    "a faulty first block": lambda bench: transmit(bench, header(count=1)),
}


@pytest.mark.rules("BLD-24", "CFG-24")
@pytest.mark.parametrize("between", ERASED.values(), ids=ERASED)
def test_what_erases_the_profile(between):
    bench = program(Bench.ready())
    between(bench)
    assert not keeps(bench)
    assert bench.fired[-1] == "CMD-16"


@pytest.mark.rules("BLD-24", "IOM-04")
def test_power_off_erases_the_profile():
    bench = program(Bench.ready())
    bench.power_cycle().out(*CONFIGURATION).run(5)
    assert not keeps(bench)


@pytest.mark.rules("BLD-24")
def test_a_new_profile_takes_the_place_of_the_old_one():
    bench = program(program(Bench.ready()), [(100, 1000, 1, C), (100, 1001, 1000, C)])
    run_blend(bench).until("MOVE_COMPLETE")
    assert bench.position == 200


# -- programming while it runs


@EITHER_WAY
@pytest.mark.rules("CMD-18", "BLD-23", "BLD-24", "LSW-08")
@pytest.mark.parametrize(
    ("final", "ms", "steps"),
    [
        # From 5000 to 1000/s: 4000/10 = 400 ms, mean 3000/s; the rate of the segment is 20.
        ((10, C), 400, 1200),
        ((10, T), 800, 2400),
        ((5, C), 800, 2400),
    ],
)
def test_programming_meanwhile_stops_it_with_the_final_deceleration(final, ms, steps, direction):
    bench = program(Bench.ready(), [(9000, 5000, 20, C), (9000, 2000, 10, C)], final)
    run_blend(bench, direction).run(400)
    transmit(bench, header()).run(ms - 0.25)
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (direction * (600 + 5 * 200 + steps), ["CMD-18"])
    assert not keeps(bench)


@pytest.mark.rules("CMD-18", "BLD-23")
@pytest.mark.parametrize("before_ms", range(20, 600, 60))
@pytest.mark.parametrize("final_type", [C, T, Z])
def test_in_the_final_ramp_it_stops_no_later_than_by_itself(final_type, before_ms):
    """4000 to 1000/s at 10 take 300, 600 or 400 ms; a new S begun in it may be longer than its rest."""
    segments = [(3000, 5000, 20, C), (9000, 4000, 10, C)]
    bench = program(Bench.ready(), segments, (10, final_type))
    end_ms = legs(1000, segments, (10, final_type))[-1][0]
    run_blend(bench).run(float(end_ms) - before_ms)
    transmit(bench, header()).run(before_ms)
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
    assert bench.position <= 12_000
    assert bench.fired == ["CMD-18"]


@pytest.mark.rules("CMD-18", "CMD-19")
def test_programming_under_the_error_of_a_hold_is_not_seen():
    bench = program(Bench.ready())
    run_blend(bench).run(400)
    bench.out(HOLD).run(10)
    transmit(bench, header()).run(10)
    assert {"BLEND_RUNNING", "MOVING_CW", "COMMAND_ERROR"} <= bench.bits
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.fired) == (TWO_STEPS, ["CMD-19"])


@pytest.mark.rules("CMD-18")
def test_the_program_bit_alone_stops_nothing():
    bench = program(Bench.ready())
    run_blend(bench).run(400)
    bench.out(0, PROGRAM).run(10)
    assert bench.bits == {"MODULE_OK", "BLEND_RUNNING", "MOVING_CW"}


assert sum(length for length, *_ in TWO) == TWO_STEPS
