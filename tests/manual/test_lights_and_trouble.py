"""The lights on the front panel [chapter 1], and a module that stops answering."""

from __future__ import annotations

import pytest
from bench3601 import CONFIGURATION, HOLD, IMMEDIATE_STOP, MANUAL_CW, Bench
from scanrack.runtime import ModuleFault
from scanrack.runtime.modules.amci3601 import Indicators, Light

OFF, SOLID, BLINKING, ALTERNATING = Light.OFF, Light.SOLID, Light.BLINKING, Light.ALTERNATING


def lights(bench):
    shown = bench.module.indicators
    return shown.axis_ok, shown.axis_error


@pytest.mark.rules("LED-01", "LED-06", "LED-08")
def test_not_configured_shows_axis_error_blinking_and_axis_ok_off():
    bench = Bench().run(1)
    assert bench.module.indicators == Indicators(SOLID, OFF, BLINKING)


@pytest.mark.rules("LED-04")
def test_idle_shows_axis_ok_solid():
    assert lights(Bench.ready()) == (SOLID, OFF)


@pytest.mark.rules("LED-05")
def test_motion_follower_and_a_held_one_shot_bit_blink():
    bench = Bench.ready().relative(100).run(1)
    assert lights(bench) == (BLINKING, OFF)
    bench.until("MOVE_COMPLETE")
    assert lights(bench) == (SOLID, OFF)
    bench.idle().command(MANUAL_CW, speed=0).run(50)
    assert lights(bench) == (BLINKING, OFF)
    bench.idle()
    assert lights(bench) == (SOLID, OFF)
    follower = Bench.ready(config=(0x853E, *CONFIGURATION[1:]))
    follower.out(0, 0x80, 1, 1).run(1)
    assert lights(follower) == (BLINKING, OFF)


@pytest.mark.rules("LED-06", "LED-08")
@pytest.mark.parametrize(
    ("provoke", "bit"),
    [
        (lambda bench: bench.out(HOLD).run(1), "COMMAND_ERROR"),
        (lambda bench: bench.inputs(estop=1).run(1), "INPUT_ERROR"),
        (lambda bench: bench.out(0x20, 0, 0, 5, 5, 0, 20, 10).run(1), "HOME_INVALID"),
        (lambda bench: bench.out(0, 0x300, 1, 0, 0, 10).run(1), "INVALID_PROFILE"),
    ],
    ids=["COMMAND_ERROR", "INPUT_ERROR", "HOME_INVALID", "INVALID_PROFILE"],
)
def test_each_error_blinks_red_and_puts_green_out(provoke, bit):
    bench = provoke(Bench.ready())
    assert bit in bench.bits
    assert lights(bench) == (OFF, BLINKING)


def test_position_invalid_is_no_error_of_the_lights():
    bench = Bench.ready().relative(10_000).run(100).out(IMMEDIATE_STOP).run(1)
    assert "POSITION_INVALID" in bench.bits
    assert lights(bench) == (SOLID, OFF)


def test_lights_are_told_as_events_when_they_change():
    bench = Bench()
    bench.module.events.clear()
    for words in (CONFIGURATION, (0,)):
        bench.out(*words)
        bench.module.update(bench.now_ns + 1_000_000, bench.outputs)
        bench.now_ns += 1_000_000
    told = [event for event in bench.module.events if event.kind == "indicator"]
    assert [(event.fields["axis_ok"], event.fields["axis_error"]) for event in told] == [("solid", "off")]


@pytest.mark.rules("LED-07")
def test_a_lost_link_freezes_the_image_and_stops_the_motion():
    bench = Bench.ready().relative(10_000).run(500)
    before = bench.words
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.run(100)
    assert bench.words == before
    assert lights(bench) == (SOLID, SOLID)
    bench.module.inject(None)
    bench.run(1)
    # as if the PLC had left run mode (reading A-78): cut at 0.5 s, 600 steps and 0.3 s at 5,000/s
    assert bench.position == 2_100
    assert {"STOPPED", "POSITION_INVALID"} < bench.bits
    bench.run(100)
    assert bench.position == 2_100  # the command bit is still set, which is not a new edge


def test_a_removed_module_reads_zeros_and_powers_up_when_it_is_put_back():
    bench = Bench.ready().relative(10_000).run(500)
    bench.module.inject(ModuleFault.REMOVED)
    bench.run(100)
    assert bench.words == [0] * 8
    assert bench.module.indicators == Indicators(OFF, OFF, OFF)
    bench.module.inject(None)
    bench.run(1)
    assert bench.words == [0x6400, 0, 0, 0, 0, 0, 0, 0]
    assert bench.module.machine.shaft == 2_100


@pytest.mark.rules("MOK-01", "STS-M14", "LED-02")
def test_a_fatal_error_clears_module_ok_until_power_is_cycled():
    bench = Bench.ready().relative(10_000).run(500)
    bench.module.inject(ModuleFault.FATAL_ERROR)
    bench.run(100)
    assert bench.bits == set()
    assert bench.position == 2_100
    assert lights(bench) == (ALTERNATING, ALTERNATING)
    bench.out(0x0800).run(10).out(*CONFIGURATION).run(10)
    assert bench.bits == set()
    with pytest.raises(ValueError, match="power cycle"):
        bench.module.inject(None)
    bench.power_cycle().out().run(1)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}


@pytest.mark.rules("LED-03")
def test_a_lost_backplane_chip_blinks_both_lights():
    bench = Bench.ready()
    bench.module.inject(ModuleFault.ASIC_LOST)
    bench.run(1)
    assert lights(bench) == (BLINKING, BLINKING)
    bench.module.inject(None)
    bench.run(1)
    assert lights(bench) == (SOLID, OFF)
