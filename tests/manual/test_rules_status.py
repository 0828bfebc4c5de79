"""The status words bit by bit: what sets a bit, what clears it, what does not [chapter 6, Status Bits]."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from bench3601 import (
    BACKPLANE_PROXIMITY,
    BLEND_CW,
    CAPTURE,
    CONFIGURATION,
    ENCODER,
    HOLD,
    HOME_CCW,
    HOME_CW,
    IMMEDIATE_STOP,
    MANUAL_CCW,
    MANUAL_CW,
    PRESET,
    RELATIVE,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import ENCODER_MOVE, FOLLOW, LONG, program_blend
from refusals3601 import PROFILE_ERRORS

EVERYTHING = configuration(add=CAPTURE | ENCODER | BACKPLANE_PROXIMITY)
COMPLETION = {"MOVE_COMPLETE", "STOPPED", "AT_HOME", "HOLD_STATE"}


Act = Callable[[Bench], object]


def ready(**kwargs) -> Bench:
    """Everything configured, a blend profile stored, the position valid, no status bit set."""
    bench = Bench.ready(config=EVERYTHING, **kwargs)
    program_blend(bench)
    return bench


# -- ways to end a motion -------------------------------------------------------------------------


def manual(bench: Bench, ms: float = 500) -> None:
    bench.manual(ms=300).idle(ms)


def immediate_stop(bench: Bench) -> None:
    bench.relative(LONG, ms=100).out(IMMEDIATE_STOP).run(1).idle()


def estop(bench: Bench) -> None:
    bench.relative(LONG, ms=100).inputs(estop=1).run(1).inputs(estop=0).idle()


def limit(bench: Bench) -> None:
    bench.relative(LONG, ms=100).inputs(cw_limit=1).run(1).inputs(cw_limit=0).idle()


def follow(bench: Bench) -> None:
    bench.out(0, FOLLOW, 1, 1).run(10).idle()


def move(bench: Bench) -> None:
    bench.relative(5, ms=50).idle()


def blend(bench: Bench) -> None:
    bench.out(BLEND_CW).until("MOVE_COMPLETE")
    bench.idle()


def encoder_move(bench: Bench) -> None:
    bench.relative(30, lsw=ENCODER_MOVE).turn_encoder(50, 100).run(500).idle()


def home(bench: Bench) -> None:
    """With backplane proximity: the bit, then the home switch."""
    bench.idle().command(HOME_CW, ms=500).command(HOME_CW, lsw=0x1000, ms=500).inputs(home=1).run(1)
    bench.inputs(home=0).idle()


def hold(bench: Bench) -> None:
    bench.relative(LONG, ms=100).out(HOLD).run(500).idle()


# -- bit by bit -----------------------------------------------------------------------------------


def words(*sent: int, ms: float = 1) -> Act:
    return lambda bench: bench.out(*sent).run(ms)


def command(msw: int, *target: int, ms: float = 1, **parameters: int) -> Act:
    return lambda bench: bench.command(msw, *target, **parameters).run(ms)


def run(ms: float) -> Act:
    return lambda bench: bench.run(ms)


def inputs(**levels: int) -> Act:
    return lambda bench: bench.inputs(**levels).run(1)


reset = Bench.reset_errors
release = Bench.idle
FOLLOWING = (0, FOLLOW, 1, 1)

# rule, bit, what sets it, what clears it
LIVES: list[tuple[str, str, Act, Act]] = [
    ("STS-M00", "MOVING_CW", command(RELATIVE, 500, ms=20), run(500)),
    ("STS-M00", "MOVING_CW", command(MANUAL_CW), words(0, ms=500)),
    ("STS-M01", "MOVING_CCW", command(RELATIVE, -500, ms=20), run(500)),
    ("STS-M01", "MOVING_CCW", command(MANUAL_CCW), words(0, ms=500)),
    ("STS-M02", "HOLD_STATE", hold, command(RESUME)),
    ("HLD-12", "HOLD_STATE", hold, command(MANUAL_CCW)),
    ("STS-M03", "STOPPED", manual, command(RELATIVE, 5)),
    ("STS-M04", "AT_HOME", home, command(RELATIVE, 5)),
    ("STS-M05", "ACCELERATING", command(RELATIVE, LONG, ms=199.75), run(0.25)),
    ("STS-M05", "ACCELERATING", command(RELATIVE, LONG, lsw=1, ms=399.75), run(0.25)),  # S-curve
    ("STS-M06", "DECELERATING", lambda bench: manual(bench, 399.75), run(0.25)),
    ("STS-M07", "MOVE_COMPLETE", move, command(MANUAL_CCW)),
    ("STS-M07", "MOVE_COMPLETE", blend, command(HOME_CW)),
    ("STS-M07", "MOVE_COMPLETE", encoder_move, words(*FOLLOWING)),
    ("STS-M08", "HOME_INVALID", command(HOME_CW, 5), reset),
    ("STS-M09", "INVALID_PROFILE", command(RELATIVE, 5, up=0), reset),
    ("STS-M09", "INVALID_PROFILE", words(0, 0x0300, 17), reset),  # a blend of 17 segments
    ("STS-M10", "POSITION_INVALID", immediate_stop, words(PRESET)),
    ("STS-M10", "POSITION_INVALID", estop, home),
    ("STS-M11", "INPUT_ERROR", estop, reset),
    ("STS-M11", "INPUT_ERROR", limit, command(RELATIVE, 5)),
    ("STS-M12", "COMMAND_ERROR", words(0x0003), reset),
    ("STS-M13", "CONFIG_ERROR", words(*configuration(drop=4)), words(*EVERYTHING)),
    ("STS-M15", "MODE_CONFIG", words(*EVERYTHING), release),
    ("STS-L00", "IN_CAPTURE", inputs(capture=1), inputs(capture=0)),
    ("STS-L01", "IN_EXTERNAL", inputs(external=1), inputs(external=0)),
    ("STS-L02", "IN_HOME", inputs(home=1), inputs(home=0)),
    ("STS-L03", "IN_ESTOP", inputs(estop=1), inputs(estop=0)),
    ("STS-L04", "IN_CW_LIMIT", inputs(cw_limit=1), inputs(cw_limit=0)),
    ("STS-L05", "IN_CCW_LIMIT", inputs(ccw_limit=1), inputs(ccw_limit=0)),
    ("STS-L07", "ENC_FOLLOWER", words(*FOLLOWING), release),
    # 600 steps in 200 ms, 19,400 at 5000/s; 1050 in 300 ms, 3800 at 2000/s, 150 in 100 ms: 6380 ms
    ("STS-L08", "BLEND_RUNNING", words(BLEND_CW, ms=6_379.75), run(0.25)),
    ("STS-L09", "BLEND_ACK", words(0, 0x0300, 2, 0, 0, 10), words(0, 0x0100)),
    ("STS-L10", "MIN_REG_NONZERO", words(0, 0x0400, 0, 1), lambda bench: bench.idle().out(0, 0x0400).run(1)),
    ("STS-L12", "HOME_PROX_ECHO", words(0, 0x1000), release),
]


@pytest.mark.parametrize(
    ("bit", "sets", "clears"),
    [
        pytest.param(bit, sets, clears, id=f"{bit}-{at}", marks=pytest.mark.rules(rule))
        for at, (rule, bit, sets, clears) in enumerate(LIVES)
    ],
)
def test_a_bit_is_set_and_cleared(bit, sets, clears):
    bench = ready()
    assert bit not in bench.bits
    sets(bench)
    assert bit in bench.bits
    clears(bench)
    assert bit not in bench.bits


# how a motion ended: its bits beside MODULE_OK
ENDINGS = [
    ("STOP-01", manual, {"STOPPED"}),
    ("STOP-02", estop, {"STOPPED", "POSITION_INVALID", "INPUT_ERROR"}),
    ("STOP-03", immediate_stop, {"STOPPED", "POSITION_INVALID"}),
    ("STOP-04", limit, {"STOPPED", "POSITION_INVALID", "INPUT_ERROR"}),
    ("STOP-05", follow, {"STOPPED"}),
    ("STOP-06", move, {"MOVE_COMPLETE"}),
    ("STOP-06", encoder_move, {"MOVE_COMPLETE"}),
    ("STOP-06", blend, {"MOVE_COMPLETE"}),
    ("STOP-06", home, {"AT_HOME"}),
    ("STOP-06", hold, {"HOLD_STATE"}),
]


@pytest.mark.parametrize(
    ("end", "bits"),
    [
        pytest.param(end, bits, id=end.__name__, marks=pytest.mark.rules("STS-M03", "MC-01", rule))
        for rule, end, bits in ENDINGS
    ],
)
@pytest.mark.parametrize("before", [end for _, end, _ in ENDINGS], ids=lambda end: f"after {end.__name__}")
def test_how_the_last_motion_ended(before, end, bits):
    """Exactly one of the four completion bits, whichever was set before."""
    bench = ready(scan_ms=5)
    before(bench)
    bench.reset_errors()
    lost = bench.bits & {"POSITION_INVALID"}
    end(bench)
    if end is home:
        lost = frozenset()
    assert bench.bits == {"MODULE_OK"} | lost | bits
    assert len(bench.bits & COMPLETION) == 1


@pytest.mark.rules("STS-M08", "STS-M12")
def test_home_invalid_of_a_search_goes_with_the_next_search():
    """A limit has ended it without a command error, so a move is possible and leaves the bit (A-19)."""
    bench = Bench.ready(config=EVERYTHING).command(HOME_CW, ms=300).inputs(ccw_limit=1).run(1)
    bench.inputs(ccw_limit=0).idle()
    assert bench.bits == {"MODULE_OK", "HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}
    bench.relative(5, ms=100)
    assert bench.bits == {"MODULE_OK", "HOME_INVALID", "POSITION_INVALID", "MOVE_COMPLETE"}
    bench.command(HOME_CCW, ms=1)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVING_CCW", "ACCELERATING"}


@pytest.mark.rules("STS-M05", "STS-M06")
def test_constant_speed_shows_no_ramp():
    """Neither at the programmed speed nor in a manual move at or below the starting speed (A-79)."""
    for speed in (1, 999, 1_000):
        bench = Bench.ready().manual(speed=speed, ms=1)
        assert bench.bits == {"MODULE_OK", "MOVING_CW"}
        bench.idle(0.25)
        assert bench.bits & {"ACCELERATING", "DECELERATING"} == set()


@pytest.mark.rules("STS-M05", "STS-M06", "MAN-11")
def test_ramps_of_a_change_of_speed_on_the_fly():
    """From 5000 to 6000/s at 20 steps/ms/s: 50 ms; to 500/s at 10: 550 ms."""
    bench = Bench.ready().manual(ms=500).manual(speed=6_000, ms=49.75)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}
    bench.run(0.25)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.manual(speed=500, ms=549.75)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING"}
    bench.run(0.25)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}


@pytest.mark.rules("MOK-01", "STS-M14")
def test_module_ok_stays_through_every_error():
    """Every error bit at once, in both modes, with and without a configuration."""
    assert "MODULE_OK" in Bench().run(1).bits
    bench = ready()
    estop(bench)
    bench.command(HOME_CW, speed=1, ms=1)
    errors = PROFILE_ERRORS | {"POSITION_INVALID", "INPUT_ERROR", "HOME_INVALID"}
    assert bench.bits == {"MODULE_OK", "STOPPED"} | errors
    bench.out(*configuration(drop=4)).run(1)
    assert bench.bits == {"MODULE_OK", "MODE_CONFIG", "CONFIG_ERROR"}
    bench.out(*CONFIGURATION).run(1).plc("program").run(10)
    assert bench.bits == {"MODULE_OK", "MODE_CONFIG"}


@pytest.mark.rules("STS-M12")
def test_command_error_is_bit_12_of_word_0():
    """The follower's section counts the words from 1 (reading A-68)."""
    bench = Bench.ready().out(0, FOLLOW, 1, 1).run(1)  # no encoder configured
    assert [word & 0xFFFF for word in bench.words[:2]] == [0x5000, 0]
    assert bench.fired == ["CMD-29"]
