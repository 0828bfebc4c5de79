"""The command LSW bit by bit, and what firmware knows which bit [chapter 5, Command Word LSW].

A relative move of 10,000 steps at 5000/s from 1000/s, rates 20 and 10: constant acceleration takes
0.2 s and 600 steps up, 0.4 s and 1200 down; an S-curve k times as long for k times as many.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    BACKPLANE_PROXIMITY,
    BLEND_CW,
    ENCODER,
    HOLD,
    HOME_CW,
    IMMEDIATE_STOP,
    MANUAL_CW,
    RELATIVE,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import program_blend
from refusals3601 import COMMAND_ERRORS, after_a_move, goes, refused

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
WITH_ENCODER = configuration(add=ENCODER)
FOLLOW, STORE, PROXIMITY = 0x0080, 0x0400, 0x1000
RESERVED = (3, 4, 5, 6, 11, 13, 14, 15)

# -- bits 0 and 1: acceleration types -------------------------------------------------------------

CONSTANT_MS = 600 + (10_000 - 1_800) / 5
TRIANGULAR_MS = 1_200 + (10_000 - 3_600) / 5  # k = 2: 400 + 800 ms, 1200 + 2400 steps
TRAPEZOIDAL_MS = 800 + (10_000 - 2_400) / 5  # k = 4/3: 266.7 + 533.3 ms, 800 + 1600 steps


@EVERY_SCAN
@pytest.mark.rules("LSW-00", "LSW-01")
@pytest.mark.parametrize(
    ("lsw", "total_ms", "ramp_ms"),
    [
        (0b00, CONSTANT_MS, 200),
        (0b10, CONSTANT_MS, 200),  # bit 1 counts only with bit 0
        (0b01, TRIANGULAR_MS, 400),
        (0b11, TRAPEZOIDAL_MS, 800 / 3),
    ],
    ids=["constant", "bit 1 alone", "triangular", "trapezoidal"],
)
@pytest.mark.parametrize("move", ["relative", "absolute", "resumed"])
def test_bits_0_and_1_select_the_acceleration(move, lsw, total_ms, ramp_ms, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms)
    if move == "resumed":  # 2000 of 12,000 steps are made; the type comes with Resume
        bench.relative(12_000, speed=1_000).run(2_000).out(HOLD)
        bench.until("HOLD_STATE")
        bench.idle(scan_ms).command(RESUME, lsw=lsw)
    else:
        bench.command(ABSOLUTE if move == "absolute" else RELATIVE, 10_000, lsw=lsw)
    up_ms = bench.until("MOVING_CW", clear=["ACCELERATING"])
    assert 0 <= up_ms - ramp_ms < scan_ms + 0.001
    rest_ms = bench.until("MOVE_COMPLETE")
    assert 0 <= up_ms + rest_ms - total_ms < scan_ms + 0.001


@pytest.mark.rules("LSW-00", "LSW-01")
def test_the_type_is_taken_with_the_command():
    """Bits that change while the move runs change nothing."""
    bench = Bench.ready().relative(10_000).run(100).relative(10_000, lsw=0b11)
    assert 100 + bench.until("MOVE_COMPLETE") == CONSTANT_MS


# -- which commands look at the rest --------------------------------------------------------------


@pytest.mark.rules("IOM-21")
@pytest.mark.parametrize("bit", [0, 1, 2, *RESERVED, 12])
@pytest.mark.parametrize("command", [RELATIVE, ABSOLUTE, MANUAL_CW], ids=["relative", "absolute", "manual"])
def test_moves_do_not_need_an_lsw_of_zero(command, bit):
    """Reserved bits (reading A-32) and the proximity bit are ignored.

    After 200 ms 600 steps, or half of the triangular ramp: the acceleration has grown from 0,
    1000 * 0.2 + 2000 * 0.2 / 3.
    """
    bench = Bench.ready(config=WITH_ENCODER)
    bench.command(command, 0 if command == MANUAL_CW else 10_000, lsw=1 << bit, ms=200)
    assert bench.bits - {"HOME_PROX_ECHO", "ACCELERATING"} == {"MODULE_OK", "MOVING_CW"}
    assert (bench.position, bench.fired) == (333 if bit == 0 else 600, [])


@pytest.mark.parametrize("bit", [0, 1, 2, *RESERVED, 12])
def test_stops_do_not_look_at_the_lsw(bit):
    """A stop must not fail on a stray bit (reading A-30); nor does Resume, which takes bits 0 and 1."""
    bench = Bench.ready().relative(10_000, ms=300).out(HOLD, 1 << bit).run(500)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "HOLD_STATE"}
    bench.command(RESUME, lsw=1 << bit, ms=100).out(IMMEDIATE_STOP, 1 << bit).run(1)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    assert bench.fired == ["POS-02"]


@pytest.mark.rules("HLD-05")
@pytest.mark.parametrize("lsw", [0x0080, 0x0300, 0x0400, 0xFFFF], ids=["follower", "blend", "minimum", "all"])
def test_no_function_of_the_lsw_comes_before_a_stop(lsw):
    """Output words 1 to 7 may hold anything when Hold is issued; it is the LSW of a stop until it changes."""
    bench = Bench.ready(config=WITH_ENCODER).relative(10_000, ms=300)
    bench.out(HOLD, lsw, -9999, 9999, -1, 1000, 3000, -1).run(500)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "HOLD_STATE"}
    bench.command(RESUME, ms=100).out(IMMEDIATE_STOP, lsw, -9999, 9999, -1, 1000, 3000, -1).run(100)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    assert bench.fired == ["POS-02"]


@pytest.mark.parametrize("bit", range(16))
def test_run_blend_needs_an_lsw_of_zero(bit):
    """The manual says so without a consequence; it is a command error (reading A-31)."""
    bench = Bench.ready("2.2")
    program_blend(bench)
    bench.out(BLEND_CW, 1 << bit).run(1)
    assert bench.bits - {"HOME_PROX_ECHO"} == {"MODULE_OK", "COMMAND_ERROR"}
    assert bench.fired == ["IOM-20"]


def test_the_reserved_bit_of_the_msw():
    """Bit 14 is a command error when it comes on (reading A-32)."""
    bench = after_a_move()
    bench.out(0x4000)
    refused(bench, "LSW-03", errors=COMMAND_ERRORS)


# -- bit 7: follower, bit 10: minimum registration distance ---------------------------------------


@EVERY_SCAN
@pytest.mark.rules("LSW-07", "STS-L07")
@pytest.mark.parametrize("firmware", ["3.1", "4.1"])
def test_bit_7_is_the_follower_from_4_1_on(firmware, scan_ms):
    """Before, it is reserved and ignored (reading A-94): a manual bit is a manual move."""
    bench = Bench.ready(firmware, config=WITH_ENCODER, scan_ms=scan_ms)
    bench.out(0, FOLLOW, 1, 1).run(scan_ms)
    assert bench.bits == {"MODULE_OK"} | ({"ENC_FOLLOWER"} if firmware == "4.1" else set())
    bench.idle(10).out(MANUAL_CW, FOLLOW, 0, 0, 5, 0, 20, 10).run(scan_ms)
    if firmware == "4.1":
        assert (bench.bits, bench.fired) == ({"MODULE_OK", "STOPPED", "COMMAND_ERROR"}, ["CMD-31"])
    else:
        assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "ACCELERATING"}, [])


@EVERY_SCAN
@pytest.mark.rules("LSW-10", "STS-L10")
@pytest.mark.parametrize("firmware", ["2.2", "3.1"])
def test_bit_10_stores_the_minimum_distance_from_3_1_on(firmware, scan_ms):
    """On its change to 1 (reading A-93); before 3.1 it is reserved and ignored, whatever the words."""
    knows = firmware == "3.1"
    bench = Bench.ready(firmware, scan_ms=scan_ms)
    bench.out(0, STORE, 0, 1).run(scan_ms)
    assert bench.bits == {"MODULE_OK"} | ({"MIN_REG_NONZERO"} if knows else set())
    bench.out(0, STORE, 0, 0).run(scan_ms)  # no change of the bit
    assert ("MIN_REG_NONZERO" in bench.bits) == knows
    bench.idle(scan_ms)
    assert ("MIN_REG_NONZERO" in bench.bits) == knows
    bench.out(0, STORE, 0, 0).run(scan_ms)
    assert bench.bits == {"MODULE_OK"}
    bench.idle(scan_ms).out(0, STORE, 8_388, 608).run(scan_ms)
    assert (bench.bits, bench.fired) == (
        ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-20"]) if knows else ({"MODULE_OK"}, [])
    )


@pytest.mark.rules("LSW-10")
@pytest.mark.parametrize("minimum", [0, 400])
def test_the_stored_distance_is_the_minimum_of_a_registration_move(minimum):
    """Released at once: 1 step is under way at 0, or 401 are made, before its 3000 steps begin."""
    bench = Bench.ready().out(0, STORE, 0, minimum).run(1).idle()
    bench.manual(1, 3_000, speed=1_000).run(1).idle(1)
    bench.until("STOPPED")
    assert bench.position == 3_000 + (minimum + 1 if minimum else 1)


# -- bit 12: backplane home proximity -------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("LSW-12", "STS-L12")
@pytest.mark.parametrize("add", [0, BACKPLANE_PROXIMITY], ids=["not configured", "configured"])
def test_the_proximity_bit_is_echoed_and_else_ignored_at_rest(add, scan_ms):
    bench = Bench.ready(config=configuration(add=add), scan_ms=scan_ms)
    bench.out(0, PROXIMITY).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "HOME_PROX_ECHO"}
    bench.out(0, 0).run(scan_ms)
    assert bench.bits == {"MODULE_OK"}
    goes(bench)


@EVERY_SCAN
@pytest.mark.rules("LSW-12")
def test_the_proximity_bit_is_ignored_in_a_move(scan_ms):
    """10,000 steps take 2240 ms with the bit as without."""
    bench = Bench.ready(config=configuration(add=BACKPLANE_PROXIMITY), scan_ms=scan_ms)
    bench.relative(10_000).run(500).relative(10_000, lsw=PROXIMITY).run(2)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "HOME_PROX_ECHO"}
    assert 502 + bench.until("MOVE_COMPLETE") == CONSTANT_MS


@EVERY_SCAN
@pytest.mark.rules("LSW-12")
def test_the_proximity_bit_is_ignored_in_homing_unless_configured(scan_ms):
    """With the home switch alone the search neither slows down nor arms anything."""
    bench = Bench.ready(scan_ms=scan_ms).command(HOME_CW).run(500).command(HOME_CW, lsw=PROXIMITY).run(1_000)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "HOME_PROX_ECHO"}
    assert bench.position == 600 + 1_300 * 5
