"""Readings A-107 to A-109, A-111 and A-112.

A-106 is tested in test_rules_homing_limits, A-110 in test_rules_several_faults.
"""

from __future__ import annotations

from itertools import pairwise

import pytest
from bench3601 import BLEND_CW, ENCODER, HOLD, MANUAL_CCW, MANUAL_CW, RESET, RESUME, Bench, configuration
from blends3601 import C, T, Z, header, is_stored, program, transmit

FOLLOW, PROGRAM, TRANSMIT, STORE = 0x0080, 0x0100, 0x0200, 0x0400
WITH_ENCODER = configuration(add=ENCODER)


# -- bit 8 without bit 9 -------------------------------------------------------------------


@pytest.mark.rules("BLD-23", "LSW-08")
def test_the_program_bit_alone_is_no_error_during_a_blend_move():
    bench = program(Bench.ready()).out(BLEND_CW).run(100)
    bench.out(0, PROGRAM, 2).run(5)
    assert bench.fired == []
    bench.out().until("MOVE_COMPLETE")
    assert is_stored(bench)


@pytest.mark.rules("LSW-08")
def test_the_program_bit_alone_leaves_a_stored_profile():
    bench = program(Bench.ready()).out(0, PROGRAM, 2).run(5)
    assert bench.bits == {"MODULE_OK"}
    assert is_stored(bench.out().run(1))


# -- ramps of the follower -----------------------------------------------------------------


@pytest.mark.rules("FOL-10")
@pytest.mark.parametrize("start", [1, 1000, 100_000])
def test_a_follower_ramps_from_rest_whatever_the_starting_speed(start):
    """10 steps/ms/s from 0: after 50 ms 500 steps/s and, at half of that on average, 12.5 steps."""
    bench = Bench.ready(config=configuration(add=ENCODER, start=start))
    bench.out(MANUAL_CW, FOLLOW, 1, 1, 0, 0, 10, 10).run(1)
    bench.turn_encoder(1_000, 50)
    assert 11 <= bench.position <= 13
    assert "ACCELERATING" in bench.bits
    bench.run(2_000)
    assert bench.position == 1_000  # what it lagged behind is made up
    assert "ENC_FOLLOWER" in bench.bits


# -- program mode in a hold state ----------------------------------------------------------


@pytest.mark.rules("PRG-01", "RSM-01")
def test_a_held_move_survives_program_mode():
    bench = Bench.ready().relative(20_000, ms=400).out(HOLD).run(500)
    held = bench.bits
    assert held == {"MODULE_OK", "HOLD_STATE"}
    bench.plc("program").run(50)
    assert bench.bits == held
    bench.plc("run").run(5).idle(1)
    assert bench.bits == held
    bench.command(RESUME).until("MOVE_COMPLETE")
    assert (bench.position, bench.fired) == (20_000, [])


# -- a blend reprogrammed while it runs ----------------------------------------------------

SLOW_STOP = (10, C)
CASES = {
    "accelerating in the first segment": (((600, 5000, 20, C), (3000, 2000, 20, C)), SLOW_STOP, 100),
    "near the end of the last": (((600, 5000, 20, C), (1400, 5100, 20, C)), SLOW_STOP, 220),
    "before a rise that the rest would bring": (((400, 2000, 20, C), (1800, 5000, 20, C)), SLOW_STOP, 195),
    "braking between two segments": (((3000, 8000, 20, C), (3000, 2000, 20, C)), (1, C), 600),
    "an S-curve": (((2000, 5000, 20, T), (5000, 6000, 20, Z)), (10, T), 600),
}


@pytest.mark.rules("CMD-18", "BLD-23")
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("segments", "final", "ms"), CASES.values(), ids=CASES)
def test_a_blend_reprogrammed_on_the_way_only_brakes(segments, final, ms, direction):
    """From the fault on no step comes sooner after the one before it, down to the standstill."""
    bench = program(Bench.ready(), segments, final)
    bench.out(BLEND_CW if direction > 0 else BLEND_CW << 1).run(ms)
    transmit(bench, header((C, C)))
    assert bench.bits >= {"COMMAND_ERROR", "BLEND_RUNNING"}
    assert "ACCELERATING" not in bench.bits
    instants, position = [], bench.position
    while "BLEND_RUNNING" in bench.bits:
        bench.scan()
        assert "ACCELERATING" not in bench.bits
        instants += [bench.now_ns] * abs(bench.position - position)
        position = bench.position
    gaps = [later - sooner for sooner, later in pairwise(instants[::20])]
    assert all(later >= sooner - bench.scan_ns for sooner, later in pairwise(gaps))
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR", "STOPPED"}


@pytest.mark.rules("CMD-18", "BLD-23")
def test_the_stop_may_end_beyond_the_profile():
    """From 8000/s down to 1000/s at 1 step/ms/s: 63 * 10^6 / 2000 = 31,500 steps, of a profile of 6000."""
    bench = program(Bench.ready(), ((3000, 8000, 20, C), (3000, 2000, 20, C)), (1, C)).out(BLEND_CW)
    while bench.position < 2_000:
        bench.scan()
    here = bench.position
    transmit(bench, header((C, C))).until("STOPPED", ms=20_000)
    assert here + 31_500 <= bench.position <= here + 31_503


@pytest.mark.rules("CMD-18")
def test_on_the_final_ramp_the_move_ends_where_it_would_have_ended():
    bench = program(Bench.ready(), ((2000, 5000, 20, C), (3000, 3000, 20, C)), (10, T)).out(BLEND_CW)
    bench.until("DECELERATING", "BLEND_RUNNING")
    while bench.position < 4_700:
        bench.scan()
    transmit(bench, header((C, C))).until("STOPPED")
    assert bench.position == 5_000


# -- blend and minimum distance bits in follower mode --------------------------------------


@pytest.mark.rules("CMD-34", "LSW-08", "LSW-10", "REG-10")
@pytest.mark.parametrize("msw", [0, MANUAL_CW], ids=["no direction", "CW"])
@pytest.mark.parametrize("extra", [PROGRAM, TRANSMIT, STORE, 0x0750], ids="{:04X}h".format)
def test_blend_and_distance_bits_mean_nothing_in_follower_mode(msw, extra):
    """07D0h with the follower bit, an encoder that turns: no error, no block, no distance."""
    bench = Bench.ready(config=WITH_ENCODER)
    bench.out(msw, FOLLOW, 1, 1).run(1)
    bench.out(msw, FOLLOW | extra, 1, 1).turn_encoder(100, 20).run(1)
    assert bench.bits == {"MODULE_OK", "ENC_FOLLOWER"}
    assert (bench.position, bench.fired) == (100 if msw else 0, [])
    bench.out(0, extra, 1, 1).run(1)  # left with the bits still set: they have not risen
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "STOPPED"}, [])


@pytest.mark.rules("LSW-08", "LSW-10")
@pytest.mark.parametrize("extra", [PROGRAM | TRANSMIT, STORE], ids=["block", "distance"])
def test_the_words_that_enter_and_leave_the_mode_are_the_followers(extra):
    bench = Bench.ready(config=WITH_ENCODER).out(0, FOLLOW | extra, 1, 1).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "ENC_FOLLOWER"}, [])
    bench.out(0, FOLLOW, 1, 1).run(1).out(0, extra, 1, 1).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "STOPPED"}, [])
    bench.out(RESET).run(1)


@pytest.mark.rules("LSW-08")
def test_a_session_under_way_ends_in_follower_mode_as_elsewhere():
    """All blocks have come; bit 9 falls, then bit 8, while the mode is on: the profile is stored."""
    bench = program(Bench.ready(config=WITH_ENCODER), end=False)
    bench.out(0, FOLLOW | PROGRAM, 1, 1).run(1)
    bench.out(0, FOLLOW, 1, 1).run(1).out().run(1)
    assert is_stored(bench)


@pytest.mark.rules("CMD-34")
@pytest.mark.parametrize("bit", [HOLD, MANUAL_CW | MANUAL_CCW])
def test_a_bit_of_the_command_msw_is_an_error_whatever_the_lsw_says(bit):
    bench = Bench.ready(config=WITH_ENCODER).out(0, FOLLOW, 1, 1).run(1)
    bench.out(bit, FOLLOW | PROGRAM | TRANSMIT | STORE, 1, 1).run(1)
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
