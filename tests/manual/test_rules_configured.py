"""What a configuration means, what it clears, and what is lost without power [chapter 3].

The usual configuration is 843Eh 003Fh 1 0: external, home, emergency stop and both limits used, all
active high, step and direction (bit 10), starting speed 1000.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    BACKPLANE_PROXIMITY,
    CAPTURE,
    CONFIGURATION,
    ENCODER,
    HOME_CW,
    MARKER,
    PRESET,
    Bench,
    configuration,
)
from motions3601 import program_blend
from refusals3601 import goes

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])

HOME, CW_ONLY, CCW_ONLY = 0x0004, 0x0020, 0x0010  # the last two: what to drop
PULSES = 0x0400  # step and direction; without it CW and CCW pulses
ACCEPTED = {"MODULE_OK", "MODE_CONFIG"}

INPUTS = ("capture", "external", "home", "estop", "cw_limit", "ccw_limit")


@pytest.mark.rules("CFG-19")
@pytest.mark.parametrize("energized", [0, 1])
@pytest.mark.parametrize("level", [0, 1])
@pytest.mark.parametrize("at", range(6), ids=INPUTS)
def test_the_level_bit_decides_when_an_input_is_active(at, level, energized):
    """Active high (1): a normally open contact; active low (0): a normally closed one."""
    levels = 0x3F & ~(1 << at) | level << at
    bench = Bench.configured(config=configuration(add=CAPTURE, levels=levels))
    bench.inputs(**{INPUTS[at]: energized}).run(1)
    assert ("IN_" + INPUTS[at].upper() in bench.bits) == (level == energized)
    assert len(bench.bits - {"MODULE_OK", "POSITION_INVALID", "INPUT_ERROR"}) == (level == energized)


@pytest.mark.rules("CFG-20")
@pytest.mark.parametrize("level", [0, 1])
@pytest.mark.parametrize("at", range(6), ids=INPUTS)
def test_the_level_of_an_unused_input_does_not_count(at, level):
    """Whatever its level bit and its voltage, it blocks and shows nothing (readings A-13, A-14)."""
    extra = MARKER | ENCODER | BACKPLANE_PROXIMITY if INPUTS[at] == "home" else 0
    levels = 0x3F & ~(1 << at) | level << at
    bench = Bench.ready(config=configuration(add=CAPTURE | extra, drop=1 << at, levels=levels))
    for energized in (0, 1):
        bench.inputs(**{INPUTS[at]: energized}).run(1)
        assert bench.bits <= {"MODULE_OK", "MOVE_COMPLETE"}
        goes(bench)
    assert bench.captured == 0


def test_switch_unused_inputs_show_their_voltage():
    """Option `report_unused_inputs` (reading A-13); used ones show whether they are active."""
    bench = Bench.ready(config=configuration(levels=0x3B), report_unused_inputs=True)  # home active low
    assert bench.bits == {"MODULE_OK", "IN_HOME"}
    bench.inputs(home=1, capture=1).run(1)
    assert bench.bits == {"MODULE_OK", "IN_CAPTURE"}
    bench.inputs(capture=0).run(1)
    assert (bench.bits, bench.captured) == ({"MODULE_OK"}, 0)


@pytest.mark.rules("CFG-18")
@pytest.mark.parametrize("drop", [CW_ONLY, CCW_ONLY], ids=["CW limit only", "CCW limit only"])
def test_home_switch_and_limit_need_not_be_wired(drop):
    """Nothing is connected: with active high inputs that is the same as inactive."""
    bench = Bench.ready(config=configuration(drop=drop))
    goes(bench, 100)
    goes(bench, -200)


@pytest.mark.rules("CFG-22")
def test_both_kinds_of_pulses_make_the_same_steps():
    words = []
    for drop in (0, PULSES):
        bench = Bench.configured(config=configuration(drop=drop))
        bench.out(*configuration(drop=drop)).run(1)
        assert bench.words[0] & 0x1FFF == 0x043E & ~drop
        bench.idle().relative(-700, ms=100)
        words.append(bench.words)
    assert words[0] == words[1]


@pytest.mark.rules("CFG-26")
@pytest.mark.parametrize(("start", "ms", "steps"), [(1, 1000, 1), (1000, 1, 1), (1_000_000, 1, 1000)])
def test_every_move_begins_and_ends_at_the_starting_speed(start, ms, steps):
    """At a programmed speed equal to it there is no ramp: steps = speed * time from the first."""
    bench = Bench.ready(config=configuration(start=start))
    bench.relative(3 * steps, speed=start).run(ms)
    assert bench.position == steps
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.run(2 * ms - 0.25)
    assert bench.position < 3 * steps
    bench.run(0.25)
    assert (bench.position, bench.bits) == (3 * steps, {"MODULE_OK", "MOVE_COMPLETE"})


# four ways to home: bits to add and drop; what happens after the start (home switch, proximity bit,
# marker pulse), and whether the axis is home then
WAYS_TO_HOME = {
    "10.1 home switch": (0, 0, [("home on, off, on", True)]),
    "10.2 home switch and backplane": (
        BACKPLANE_PROXIMITY,
        0,
        [("home", False), ("marker", False), ("proximity", False), ("marker", False), ("home", True)],
    ),
    "10.3 marker and home switch": (
        MARKER | ENCODER,
        0,
        [("marker", False), ("proximity", False), ("home", False), ("marker", True)],
    ),
    "10.4 marker and backplane": (
        MARKER | ENCODER | BACKPLANE_PROXIMITY,
        HOME,
        [("marker", False), ("home", False), ("proximity", False), ("home", False), ("marker", True)],
    ),
}


@pytest.mark.rules("CFG-23")
@pytest.mark.parametrize("way", WAYS_TO_HOME)
def test_the_configuration_selects_one_of_four_ways_to_home(way):
    add, drop, story = WAYS_TO_HOME[way]
    bench = Bench.configured(config=configuration(add=add, drop=drop))
    bench.command(HOME_CW, ms=500)
    for happening, home in story:
        if happening == "home on, off, on":
            bench.inputs(home=1).run(500).inputs(home=0).run(1000)
            assert "AT_HOME" not in bench.bits
            bench.inputs(home=1).run(500)
        elif happening == "home":
            bench.inputs(home=1).run(50).inputs(home=0).run(50)
        elif happening == "proximity":
            bench.command(HOME_CW, lsw=0x1000, ms=50)
        else:
            bench.marker_in(20).run(50)
        assert ("AT_HOME" in bench.bits) == home, happening
    assert (bench.position, "POSITION_INVALID" in bench.bits) == (0, False)


@EVERY_SCAN
@pytest.mark.rules("CFG-31", "LSW-12")
def test_homing_ignores_the_home_input_until_the_proximity_bit_rises(scan_ms):
    """At 5000/s after 0.2 s; the ramp down to 1000 takes 0.4 s from the rise on, then home counts."""
    bench = Bench.configured(config=configuration(add=BACKPLANE_PROXIMITY), scan_ms=scan_ms)
    bench.command(HOME_CW, ms=500)
    bench.inputs(home=1).run(2).inputs(home=0).run(2)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVING_CW"}
    bench.command(HOME_CW, lsw=0x1000, ms=400 - scan_ms)
    assert {"MOVING_CW", "DECELERATING", "HOME_PROX_ECHO"} < bench.bits
    bench.run(scan_ms)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVING_CW", "HOME_PROX_ECHO"}
    bench.inputs(home=1).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}


# -- what is lost, what stays ---------------------------------------------------------------------


@pytest.mark.rules("IOM-04")
def test_nothing_survives_a_power_cycle():
    bench = Bench.ready(position=500, config=configuration(add=ENCODER | CAPTURE))
    bench.turn_encoder(250, 10).inputs(capture=1).run(1).inputs(capture=0)
    program_blend(bench)
    bench.out(0, 0x0400, 0, 100).run(1)
    assert (bench.position, bench.encoder, bench.captured) == (500, 250, 250)
    assert bench.bits == {"MODULE_OK", "MIN_REG_NONZERO"}
    bench.out().power_cycle().run(1)
    assert bench.words == [0x6400, 0, 0, 0, 0, 0, 0, 0]
    bench.out(*configuration(add=ENCODER | CAPTURE)).run(1).idle()
    assert (bench.bits, bench.words[2:]) == ({"MODULE_OK", "POSITION_INVALID"}, [0] * 6)
    bench.fired.clear()
    bench.out(0x1000).run(1)  # Run Blend
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "POSITION_INVALID", "COMMAND_ERROR"}, ["CMD-16"])


@pytest.mark.rules("IOM-04", "CER-01")
def test_power_fails_during_a_move():
    """The shaft stays where it was; the command bit that is still set is an edge to the new module."""
    bench = Bench.ready()
    bench.relative(10_000, ms=400).power_cycle().run(100)
    assert (bench.words, bench.module.machine.shaft) == ([0x6400, 0, 0, 0, 0, 0, 0, 0], 1_600)
    bench.out(*CONFIGURATION).run(2).idle().relative(10_000, ms=200)
    assert (bench.position, bench.module.machine.shaft) == (600, 2_200)


@pytest.mark.rules("CFG-24", "CFG-25", "STS-L10")
@pytest.mark.parametrize("firmware", ["3.1", "4.1"])
def test_a_configuration_erases_blend_profile_and_minimum_distance(firmware):
    """Even the same one as before."""
    bench = Bench.ready(firmware)
    program_blend(bench)
    bench.out(0, 0x0400, 0, 500).run(1).idle()
    assert bench.bits == {"MODULE_OK", "MIN_REG_NONZERO"}
    bench.out(*CONFIGURATION).run(1).idle()
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.out(0x1000).run(1)
    assert bench.fired == ["POS-01", "CMD-16"]
    bench.reset_errors()
    bench.manual(1, 3_000, speed=1_000).run(1).idle(1)  # released after 1 step, with 3000 to come
    bench.until("STOPPED")
    assert bench.position == 3_001


@pytest.mark.rules("CFG-24")
def test_a_configuration_ends_blend_programming():
    """All blocks are sent, but bit 8 of the LSW falls by way of configuration mode: nothing is stored."""
    bench = Bench.ready()
    for block in [(2, 0, 0, 10), (20, 0, 5, 0, 20), (5, 0, 2, 0, 10)]:
        bench.out(0, 0x0100).run(1).out(0, 0x0300, *block).run(1)
    assert bench.bits == {"MODULE_OK", "BLEND_ACK"}
    bench.out(*CONFIGURATION).run(1).out(0x1000).run(1)
    assert (bench.bits, bench.fired[-1]) == ({"MODULE_OK", "POSITION_INVALID", "COMMAND_ERROR"}, "CMD-16")


LEFT_OVER = {"HOLD_STATE", "INPUT_ERROR", "COMMAND_ERROR", "HOME_INVALID", "INVALID_PROFILE"}


def in_all_sorts_of_trouble(**options) -> Bench:
    """Held, the emergency stop pressed, a Find Home refused for its speed."""
    bench = Bench.ready(**options)
    bench.relative(10_000, ms=300).out(0x0004).run(500)
    bench.inputs(estop=1).run(1).inputs(estop=0).run(1)
    bench.command(HOME_CW, speed=1).run(1)
    assert bench.bits == {"MODULE_OK", *LEFT_OVER}
    return bench


@pytest.mark.rules("CFG-14", "POS-01")
def test_a_configuration_clears_what_command_mode_left():
    """Even under a command error it is accepted (reading A-101); all but Position Invalid (A-102)."""
    bench = in_all_sorts_of_trouble().out(*CONFIGURATION).run(1)
    assert bench.bits == ACCEPTED
    bench.idle()
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.fired.clear()
    bench.command(0x0008).run(1)  # Resume
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "POSITION_INVALID", "COMMAND_ERROR"}, ["CMD-08"])


def test_switch_a_configuration_leaves_the_status_bits():
    """Option `clear_status_after_config` (A-102); the command error goes off on entry (A-101)."""
    bench = in_all_sorts_of_trouble(clear_status_after_config=False).out(*CONFIGURATION).run(1)
    assert bench.bits == ACCEPTED
    bench.idle()
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", *LEFT_OVER} - {"COMMAND_ERROR"}


def test_switch_stopped_after_configuration():
    """Option `stopped_after_config` (reading A-02); the next move clears it as ever."""
    bench = Bench(stopped_after_config=True).run(1)
    assert "STOPPED" not in bench.bits
    bench.out(*CONFIGURATION).run(1).idle()
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    bench.out(PRESET).run(1).idle()
    goes(bench)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
