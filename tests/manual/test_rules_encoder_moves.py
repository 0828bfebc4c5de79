"""Encoder moves: absolute and relative moves that end at an encoder count [chapter 4, Encoder Move].

With an encoder of two counts a step on the shaft, a relative move of 4000 counts at 5000/s from
1000/s, acceleration 20, deceleration 10: 2000 steps are made after 200 + 280 ms, and the stop takes
1200 steps and 400 ms more. It ends at 3200 steps and 6400 counts.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from bench3601 import ABSOLUTE, DIAGNOSTIC, ENCODER, HOME_CW, IMMEDIATE_STOP, PRESET_ENCODER, RELATIVE, Bench
from bench3601 import configuration as configured
from motions3601 import ENCODER_MOVE
from scanrack.io_images.thousands import split_thousands
from scanrack.runtime.machine import EncoderSpec

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("sign", [1, -1], ids=["cw", "ccw"])
COMPLETE = {"MODULE_OK", "MOVE_COMPLETE"}
TWO_COUNTS_A_STEP = EncoderSpec(Fraction(2))


def bench_with_encoder(counts: int = 0, *, spec: EncoderSpec | None = TWO_COUNTS_A_STEP, **kwargs) -> Bench:
    """Position 0, encoder at `counts`."""
    bench = Bench.ready(config=configured(add=ENCODER), encoder=spec, **kwargs)
    bench.out(PRESET_ENCODER, 0, *split_thousands(counts)).run(2)
    bench.idle(2)
    assert (bench.position, bench.encoder, bench.bits) == (0, counts, {"MODULE_OK"})
    return bench


def encoder_move(bench: Bench, target: int, msw: int = RELATIVE, **parameters) -> Bench:
    return bench.command(msw, target, lsw=ENCODER_MOVE, **parameters)


# -- the count is the distance --------------------------------------------------------------------


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.parametrize("start", [0, 1_000, -5_000])
@pytest.mark.rules("ENC-01", "ENC-02", "ENC-04", "MC-01", "STS-M07")
def test_a_relative_encoder_move(start, sign, scan_ms):
    bench = encoder_move(bench_with_encoder(start, scan_ms=scan_ms), sign * 4_000)
    way = {"MODULE_OK", "MOVING_CW" if sign > 0 else "MOVING_CCW"}
    assert bench.run(100).bits == way | {"ACCELERATING"}
    bench.run(380)
    assert (bench.position, bench.encoder) == (sign * 2_000, start + sign * 4_000)
    assert bench.scan().bits == way | {"DECELERATING"}
    bench.run(400 - scan_ms)
    assert (bench.position, bench.encoder) == (sign * 3_200, start + sign * 6_400)
    assert (bench.bits, bench.fired) == (COMPLETE, [])


# encoder before, target; where the target is met, in counts from the start
@EVERY_SCAN
@pytest.mark.parametrize(
    ("start", "target", "direction"),
    [
        pytest.param(1_000, 5_000, 1, id="above the encoder value"),
        pytest.param(-6_000, -2_000, 1, id="negative and above it"),
        pytest.param(1_000, -3_000, -1, id="below it"),
        pytest.param(6_000, 2_000, -1, id="positive and below it"),
    ],
)
@pytest.mark.rules("ENC-01", "ENC-02", "ENC-03", "MC-01")
def test_an_absolute_encoder_move(start, target, direction, scan_ms):
    """The direction is that of the encoder value; the position of 0 has no say in it."""
    bench = encoder_move(bench_with_encoder(start, scan_ms=scan_ms), target, ABSOLUTE, ms=480)
    assert (bench.position, bench.encoder) == (direction * 2_000, target)
    bench.run(400)
    assert (bench.position, bench.bits) == (direction * 3_200, COMPLETE)


@EVERY_SCAN
@pytest.mark.rules("ENC-03", "ENC-04")
def test_a_relative_encoder_move_is_not_absolute(scan_ms):
    """Target 4000 with the encoder at 9000: relative up, absolute down."""
    assert encoder_move(bench_with_encoder(9_000, scan_ms=scan_ms), 4_000, ms=400).position == 1_600
    assert (
        encoder_move(bench_with_encoder(9_000, scan_ms=scan_ms), 4_000, ABSOLUTE, ms=400).position == -1_600
    )


@EVERY_SCAN
@pytest.mark.parametrize(
    ("counts", "steps"),
    [
        # the first step comes after 0.99 ms and is seen at 1 ms: 1.01 steps, 1020/s; (1020^2 - 1000^2)/
        # 20,000 = 2.02 steps to stop: 3.03, and on to a whole step
        pytest.param(2, 4, id="after one step"),
        # 200 steps after 100 ms, at 3000/s: 400 more
        pytest.param(400, 600, id="while accelerating"),
    ],
)
@pytest.mark.rules("ENC-02")
def test_a_count_reached_while_accelerating(counts, steps, scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), counts)
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (steps, COMPLETE)


@EVERY_SCAN
@pytest.mark.rules("ENC-01", "ENC-02")
def test_a_count_that_is_reached_already(scan_ms):
    """No distance, complete at once, as for any move."""
    bench = encoder_move(bench_with_encoder(700, scan_ms=scan_ms), 700, ABSOLUTE, ms=scan_ms)
    assert (bench.position, bench.bits) == (0, COMPLETE)
    bench = encoder_move(bench_with_encoder(700, scan_ms=scan_ms), 0, ms=scan_ms)
    assert (bench.position, bench.bits) == (0, COMPLETE)


@EVERY_SCAN
@pytest.mark.parametrize("lsw", [ENCODER_MOVE | 1, ENCODER_MOVE | 3])
@pytest.mark.rules("ENC-02", "PRO-10")
def test_encoder_moves_may_use_s_curves(lsw, scan_ms):
    """Longer ramps both ways: twice and 4/3 of 1200 steps down, from the whole step at 4000 counts."""
    bench = bench_with_encoder(scan_ms=scan_ms).command(RELATIVE, 8_000, lsw=lsw)
    bench.until("MOVE_COMPLETE")
    assert bench.position in ((6_400, 6_401) if lsw & 2 == 0 else (5_600, 5_601))


# -- what the encoder does ------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("ENC-12", "IOM-17")
def test_the_encoder_counts_without_a_profile(scan_ms):
    """At rest, during a move, and in configuration mode, where the words show something else."""
    bench = bench_with_encoder(scan_ms=scan_ms, spec=None).turn_encoder(1_234, ms=50)
    assert (bench.position, bench.encoder) == (0, 1_234)
    bench.turn_encoder(-2_000, ms=50)
    assert bench.encoder == -766
    bench.relative(100).turn_encoder(66, ms=150)
    assert (bench.position, bench.encoder, bench.bits) == (100, -700, COMPLETE)
    bench.out(*configured(add=ENCODER)).turn_encoder(1_000, ms=20)
    bench.out(0).run(2)
    assert (bench.position, bench.encoder) == (0, 300)


@EVERY_SCAN
@pytest.mark.rules("ENC-01", "ENC-02")
def test_an_encoder_that_somebody_turns(scan_ms):
    """The count decides, wherever it comes from: 4000 counts by hand within 100 ms, 200 steps."""
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms, spec=None), 4_000).turn_encoder(4_000, ms=100)
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.encoder) == (600, 4_000)


@EVERY_SCAN
@pytest.mark.rules("ENC-02", "ENC-11")
def test_a_count_acts_in_the_scan_that_it_falls_into(scan_ms):
    """The 4000th falls into the last one under these words, so the next words come too late."""
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms, spec=None), 4_000).turn_encoder(3_999, ms=398)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.turn_encoder(1, ms=2)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING"}
    bench.out().until("MOVE_COMPLETE")
    assert bench.position == 1_600 + 1_200


@EVERY_SCAN
@pytest.mark.rules("ENC-02", "ENC-11", "MC-01")
def test_without_a_ramp_the_scan_of_the_last_count_shows_the_end(scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms, spec=None), 4_000, speed=1_000)
    assert bench.turn_encoder(3_999, ms=398).bits == {"MODULE_OK", "MOVING_CW"}
    assert bench.turn_encoder(1, ms=2).bits == COMPLETE
    assert bench.position == 400


@EVERY_SCAN
@pytest.mark.parametrize(
    ("spec", "turned"),
    [
        pytest.param(None, 0, id="no encoder attached"),
        pytest.param(EncoderSpec(Fraction(2), direction=-1), 0, id="counts the other way"),
        pytest.param(None, 3_999, id="stalled a count short"),
    ],
)
@pytest.mark.rules("ENC-10")
def test_without_the_count_the_move_never_ends(spec, turned, scan_ms):
    """Ten minutes: 600 s * 5000/s less the 400 steps that the ramp costs."""
    bench = bench_with_encoder(scan_ms=scan_ms, spec=spec)
    encoder_move(bench, 4_000).turn_encoder(turned, ms=100)
    bench.scan_ns = 100_000_000
    bench.run(599_900)
    assert (bench.position, bench.bits) == (2_999_600, {"MODULE_OK", "MOVING_CW"})
    bench.out(IMMEDIATE_STOP).scan()
    assert (bench.position, bench.bits) == (2_999_600, {"MODULE_OK", "STOPPED", "POSITION_INVALID"})


# -- bit 2 of the LSW -----------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("ENC-11")
def test_resetting_the_command_word_alone_does_no_harm(scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), 4_000, ms=100)
    bench.out(0, ENCODER_MOVE).until("MOVE_COMPLETE")
    assert (bench.position, bench.encoder) == (3_200, 6_400)


@EVERY_SCAN
@pytest.mark.rules("ENC-11")
def test_resetting_the_lsw_too_makes_it_run_past_its_count(scan_ms):
    """Reading A-52: until bit 2 is set again, or for ever."""
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), 4_000, ms=100).out(0).run(900)
    assert (bench.position, bench.bits) == (4_600, {"MODULE_OK", "MOVING_CW"})
    bench.out(0, ENCODER_MOVE).run(400)
    assert (bench.position, bench.bits, bench.fired) == (5_800, COMPLETE, [])


@EVERY_SCAN
@pytest.mark.rules("ENC-11", "ENC-02")
def test_resetting_the_lsw_once_the_axis_decelerates_changes_nothing(scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), 4_000, ms=600).out(0).run(280)
    assert (bench.position, bench.bits) == (3_200, COMPLETE)


@EVERY_SCAN
@pytest.mark.parametrize("msw", [ABSOLUTE, RELATIVE])
@pytest.mark.rules("ENC-09", "LSW-02")
def test_bit_2_decides_between_counts_and_steps(msw, scan_ms):
    """The same words with and without it; the LSW of the move before has no effect."""
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), 4_000, msw)
    bench.until("MOVE_COMPLETE")
    assert bench.position == 3_200
    bench.idle().command(msw, 4_000).until("MOVE_COMPLETE")
    assert bench.position == (4_000 if msw == ABSOLUTE else 7_200)
    encoder_move(bench.idle(), 1_000).until("MOVE_COMPLETE")
    assert bench.encoder - 1_000 > 2 * (4_000 if msw == ABSOLUTE else 7_200)


@EVERY_SCAN
@pytest.mark.parametrize("encoder", [ENCODER, 0], ids=["encoder", "no encoder"])
@pytest.mark.rules("ENC-08", "LSW-02")
def test_homing_ignores_bit_2(encoder, scan_ms):
    bench = Bench.ready(config=configured(add=encoder), scan_ms=scan_ms, machine={"home": (3_000, 3_500)})
    bench.command(HOME_CW, lsw=ENCODER_MOVE, ms=400)
    assert (bench.position, bench.bits, bench.fired) == (1_600, {"MODULE_OK", "MOVING_CW"}, [])
    bench.until("AT_HOME")
    plain = Bench.ready(config=configured(add=encoder), scan_ms=scan_ms, machine={"home": (3_000, 3_500)})
    plain.command(HOME_CW).until("AT_HOME")
    assert bench.now_ns == plain.now_ns


# -- refusals -------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize("msw", [ABSOLUTE, RELATIVE])
@pytest.mark.parametrize("config", [configured(), configured(add=DIAGNOSTIC)], ids=["none", "diagnostic"])
@pytest.mark.rules("ENC-05", "PRF-11")
def test_an_encoder_move_needs_an_encoder(config, msw, scan_ms):
    """Diagnostic feedback is none."""
    bench = encoder_move(Bench.ready(config=config, scan_ms=scan_ms), 4_000, msw, ms=50)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "COMMAND_ERROR", "INVALID_PROFILE"})
    assert set(bench.fired) == {"ENC-05", "PRF-11"}
    assert bench.reset_errors().bits == {"MODULE_OK"}
    bench.command(msw, 4_000, ms=50)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}


@EVERY_SCAN
@pytest.mark.rules("CMD-06", "MOV-01", "ENC-04")
def test_an_absolute_encoder_move_needs_a_valid_position_and_a_relative_one_does_not(scan_ms):
    """Reading A-51."""
    bench = Bench.configured(config=configured(add=ENCODER), scan_ms=scan_ms)
    encoder_move(bench, 4_000, ABSOLUTE, ms=50)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (0, ["CMD-06"])
    encoder_move(bench.reset_errors(), 4_000, ms=100)
    assert (bench.position, bench.fired) == (200, ["CMD-06"])


@EVERY_SCAN
@pytest.mark.parametrize(
    ("parameters", "rules"),
    [
        ({"target": 8_388_608}, {"CMD-04", "PRF-02"}),
        ({"target": 100, "speed": 999}, {"CMD-05", "PRF-01"}),
        ({"target": 100, "down": 0}, {"CMD-04", "PRF-02"}),
    ],
)
@pytest.mark.rules("CMD-04", "CMD-05")
def test_an_encoder_move_has_the_ranges_of_any_move(parameters, rules, scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), ms=50, **parameters)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "COMMAND_ERROR", "INVALID_PROFILE"})
    assert set(bench.fired) == rules


# -- the external input, once the count is reached ------------------------------------------------


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.rules("ENC-07", "EXT-06", "ENC-02")
def test_the_external_input_after_the_count_changes_nothing(sign, scan_ms):
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), sign * 4_000, ms=600)
    bench.inputs(external=1).run(280)
    assert (bench.position, bench.bits) == (sign * 3_200, COMPLETE | {"IN_EXTERNAL"})


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.rules("ENC-07", "EXT-06")
def test_the_count_after_the_external_input_changes_nothing(sign, scan_ms):
    """Stopped from 440 ms on, 1800 + 1200 steps; the count of 4000 comes on the way."""
    bench = encoder_move(bench_with_encoder(scan_ms=scan_ms), sign * 4_000, ms=440)
    bench.inputs(external=1).run(400)
    assert (bench.position, bench.encoder) == (sign * 3_000, sign * 6_000)
    assert bench.bits == {"MODULE_OK", "STOPPED", "IN_EXTERNAL"}
