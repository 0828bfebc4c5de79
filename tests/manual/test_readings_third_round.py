"""Readings A-111 in all ramps, A-107 with bit 9 first, and A-113 to A-116."""

from __future__ import annotations

import json

import oracle_motion
import pytest
from bench3601 import BLEND_CW, ENCODER, HOLD, MANUAL_CW, RELATIVE, Bench, configuration
from blends3601 import C, T, Z, block, header, program, transmit
from lockstep3601 import Lockstep
from scanrack.commands import build
from stories3601 import Setting
from typer.testing import CliRunner

FOLLOW, PROGRAM, TRANSMIT, STORE = 0x0080, 0x0100, 0x0200, 0x0400
SHAPES = {C: oracle_motion.CONSTANT, T: oracle_motion.TRIANGULAR, Z: oracle_motion.TRAPEZOIDAL}


# -- the sooner of two ends, in all ramps --------------------------------------------------


@pytest.mark.rules("CMD-18")
@pytest.mark.parametrize("shape", [C, T, Z], ids=["constant", "triangular", "trapezoidal"])
@pytest.mark.parametrize("ms", range(80, 134, 6))
def test_on_the_final_ramp_the_sooner_of_both_ends_counts(shape, ms):
    """6000 to 1000/s at 84 steps/ms/s: 60, 119 or 79 ms. Chapter 2's arithmetic, in floats, has both ends."""
    segments = [(7, 3000, 2000, C), (640, 6000, 2000, C)]
    bench = program(Bench.ready(), segments, (84, shape)).out(BLEND_CW).run(ms)
    assert "DECELERATING" in bench.bits
    as_it_is = oracle_motion.blend(
        0, 1000, [(*leg[:3], oracle_motion.CONSTANT) for leg in segments], 84, SHAPES[shape]
    )
    anew = oracle_motion.stop(as_it_is, ms * 1_000_000, 1000, 84, SHAPES[shape])
    transmit(bench, header((C, C))).until("STOPPED")
    assert bench.position == round(min(as_it_is.last_step, anew.last_step))


CASE = [
    ([-31425, 63, 1, 0, 0, 0, 0, 0], 1),
    ([0] * 8, 1),
    ([0, 768, 2, 0, 0, 16468, 0, 0], 1),
    ([0, 256, 0, 0, 0, 0, 0, 0], 1),
    ([0, 768, 0, 7, 3, 0, 2000, 0], 1),
    ([0, 256, 0, 0, 0, 0, 0, 0], 1),
    ([0, 768, 0, 428, 6, 0, 2000, 0], 1),
    ([0] * 8, 1),
    ([4096, 0, 0, 0, 0, 0, 0, 0], 98),
    ([0, 768, 2, 0, 0, 0, 0, 0], 50),
]


@pytest.mark.rules("CMD-18")
def test_late_in_a_triangular_ramp_braking_anew_ends_sooner():
    """A profile of 435 steps, 26 ms before its end, at 404.9 steps and 1476/s.

    The ramp as it is has 30.1 steps left. A triangular one from 1476/s down at 84 steps/ms/s takes
    2 * 476 / 84,000 s = 11.3 ms and, at 1238/s on average, 14.0 steps: 418.9, so 419.
    """
    lines = [json.dumps({"new": {"scan_ms": 0.25}})]
    lines += [json.dumps({"out": words, "for_ms": ms}) for words, ms in CASE]
    said = CliRunner().invoke(build(), ["drive", "amci3601"], input="\n".join(lines) + "\n")
    before, last = (json.loads(line) for line in said.stdout.splitlines()[-2:])
    assert (before["position"], "DECELERATING" in before["bits"]) == (404, True)
    assert (last["position"], last["rules"], "STOPPED" in last["bits"]) == (419, ["CMD-18"], True)


# -- bits 8 and 9 may come one after the other ----------------------------------------------


@pytest.mark.rules("BLD-23")
def test_the_first_block_is_read_when_both_bits_are_set_whichever_came_first():
    bench = Bench.ready().out(0, TRANSMIT, *header((C, C))).run(2)
    assert bench.bits == {"MODULE_OK"}
    bench.out(0, PROGRAM | TRANSMIT, *header((C, C))).run(2)
    assert bench.bits == {"MODULE_OK", "BLEND_ACK"}


# -- bit 7 after a refused entry ------------------------------------------------------------


@pytest.mark.rules("CMD-34", "INP-02")
def test_bit_7_of_a_refused_entry_is_no_follower_mode():
    """Refused on an end limit, which is no command error: the module is in command mode, and goes on so."""
    bench = Bench.ready(config=configuration(add=ENCODER)).inputs(cw_limit=1)
    bench.out(0, FOLLOW, 1, 1).run(2)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_CW_LIMIT"}
    bench.inputs(cw_limit=0).run(2)
    bench.command(RELATIVE, 500, lsw=FOLLOW).until("MOVE_COMPLETE")
    assert (bench.position, bench.bits, bench.fired[1:]) == (500, {"MODULE_OK", "MOVE_COMPLETE"}, [])
    bench.out(0, FOLLOW).run(2)
    bench.out(MANUAL_CW, FOLLOW, 0, 0, 0, 500).run(100)
    assert (bench.bits, bench.position) == ({"MODULE_OK", "MOVING_CW"}, 550)
    bench.out(0, FOLLOW).until("STOPPED")
    bench.out(0, 0).run(2)
    bench.out(0, FOLLOW, 1, 1).run(2)
    assert "ENC_FOLLOWER" in bench.bits
    bench.out(HOLD, FOLLOW, 1, 1).run(2)
    assert bench.fired[-1] == "CMD-34"


# -- bit 10 beside a command bit ------------------------------------------------------------


@pytest.mark.rules("REG-10")
@pytest.mark.parametrize("speed", [0, 5000])
def test_bit_10_beside_a_move_bars_the_move(speed):
    """Nothing of the move is looked at: its speed of 0 adds no Invalid Profile."""
    bench = Bench.ready().command(RELATIVE, 500, speed=speed, lsw=STORE, ms=5)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["REG-10"])
    assert bench.position == 0


# -- a rate of 0 in a blend block -----------------------------------------------------------


@pytest.mark.rules("BLD-18")
@pytest.mark.parametrize("rate", [0, -1, 2001])
def test_the_rate_of_a_segment_is_no_parameter_of_a_command(rate):
    bench = transmit(Bench.ready(), header((C, C)))
    bench.out(0, PROGRAM).run(1)
    transmit(bench, block(3000, 5000, rate))
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "INVALID_PROFILE", "BLEND_ACK"}, ["BLD-18"])


# -- words that are a block and a move's at once ----------------------------------------------

REGISTRATION = (MANUAL_CW, PROGRAM, 0, 300, 3, 0, 2000, 2000)
"""300 steps from the input on, at 3000/s; begun while a profile is programmed."""


def registering(*, minimum=0):
    """Return a bench on which a registration move has begun after the first block of a profile."""
    bench = Bench.ready()
    if minimum:
        bench.out(0, STORE, 0, minimum).run(2)
        bench.out().run(2)
    transmit(bench, header((C, C)))
    bench.out(0, PROGRAM).run(1)
    return bench.out(*REGISTRATION).run(5)


@pytest.mark.rules("BLD-18", "REG-24")
def test_a_faulty_block_bars_the_comparison_of_the_words():
    """Other speed, rate 2001: the block is at fault, and Invalid Profile bars all but the stop inputs."""
    bench = registering(minimum=100)
    bench.out(0, PROGRAM | TRANSMIT, 0, 300, 1, 500, 2001, 2000).run(2)
    assert bench.fired == ["BLD-18"]
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "INVALID_PROFILE", "BLEND_ACK", "MIN_REG_NONZERO"}
    bench.out(0, PROGRAM, 0, 301, 1, 500, 2001, 2000).run(1)
    assert bench.fired == ["BLD-18"]
    bench.until("STOPPED")
    assert 400 < bench.position < 420  # the minimum distance, and 300 more


@pytest.mark.rules("REG-27")
def test_a_good_block_is_compared_like_any_words():
    """The same target, 1500/s instead of 3000/s: a block of a profile and a lower speed."""
    bench = registering(minimum=100)
    bench.out(0, PROGRAM | TRANSMIT, 0, 300, 1, 500, 2000, 2000).run(1)
    assert bench.fired == []
    assert bench.bits >= {"BLEND_ACK", "MOVING_CW"}
    before = bench.position
    bench.run(20)
    assert 29 <= bench.position - before <= 31


FOUND = {
    "below the minimum, a block at fault": (
        (0, STORE, 0, 100, 0, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0),
        (0, PROGRAM | TRANSMIT, 3, 0, 0, 100, 0, 0),
        REGISTRATION,
        (0, PROGRAM | TRANSMIT, 0, 300, 1, 500, 2001, 2000),
        (0, PROGRAM | TRANSMIT, 0, 301, 3, 0, 2000, 2000),
    ),
    "a block of speed 0 under a manual bit": (
        (0, PROGRAM | TRANSMIT, 3, 0, 0, 100, 0, 0),
        (MANUAL_CW, PROGRAM, 2, 2, 0, 800, 2000, 20),
        (MANUAL_CW, PROGRAM | TRANSMIT, 2, 2, 0, 0, 0, 0),
    ),
    "a header at fault beside both manual bits": (
        (0, PROGRAM | TRANSMIT, 3, 0, 0, 100, 0, 0),
        (0x0100, PROGRAM, 0, 300, 5, 0, 20, 100),
        (0x0180, PROGRAM | TRANSMIT, 0, 0, 5, 0, 20, 100),
    ),
    "bit 9 first, then bit 8": (
        (0x0100, TRANSMIT, 2, 2, 1, 0, 100, 20),
        (0x0180, PROGRAM | TRANSMIT, 2, 3, 1, 1, 100, 0),
    ),
}


@pytest.mark.parametrize("scan_ticks", [1, 8])
@pytest.mark.parametrize("images", FOUND.values(), ids=FOUND)
def test_module_and_oracle_agree_on_scripts_that_a_search_has_found(images, scan_ticks):
    bench = Lockstep(Setting(scan_ticks=scan_ticks))
    for words in ((0x853F, 63, 1, 0, 0, 0, 0, 0), (0,) * 8, *images):
        bench.out([(word ^ 0x8000) - 0x8000 for word in words])
        bench.run(8)
    bench.run(400)
