"""The minimum registration distance: stored once, obeyed by every registration move [chapter 4].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up, so that the steps after t ms are 600 + 5*(t - 200).
"""

from __future__ import annotations

import pytest
from bench3601 import CONFIGURATION, HOLD, PRESET, RELATIVE, Bench, configuration
from registration3601 import EITHER_INPUT, STEPS, STORE, give_input, register, release, store

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])


# -- obeying it


@BOTH_PERIODS
@EITHER_WAY
@EITHER_INPUT
@pytest.mark.rules("REG-04", "REG-06", "LSW-10")
@pytest.mark.parametrize("after_ms", [2, 100, 480])
def test_before_the_minimum_distance_the_input_waits(after_ms, by, direction, scan_ms):
    """Step 2001 exceeds it: 480.2 ms after the start, seen at the tick 480.25 ms (reading A-53)."""
    bench = store(Bench.ready(scan_ms=scan_ms), 2000)
    register(bench, direction).run(after_ms)
    give_input(bench, by)
    took = bench.until("STOPPED")
    assert bench.position == direction * (2001 + STEPS)
    # From 2001.25 steps on 1799.75 at 5000/s, 359.95 ms: 480.25 + 359.95 + 400 ms
    assert 0 <= after_ms + took - 1_240.2 < scan_ms


@EITHER_INPUT
@pytest.mark.rules("REG-04", "REG-06")
def test_the_least_minimum_distance_is_exceeded_by_the_second_step(by):
    """The first step is made after 0.99 ms, the second after 1.96 ms; given before either."""
    bench = register(store(Bench.ready(), 1)).run(0.5)
    give_input(bench, by).until("STOPPED")
    assert bench.position == 2 + STEPS


@EITHER_INPUT
@pytest.mark.rules("REG-04")
@pytest.mark.parametrize("after_ms", [480.25, 600])
def test_beyond_the_minimum_distance_the_input_counts_at_once(after_ms, by):
    bench = register(store(Bench.ready(), 2000)).run(after_ms)
    made = bench.position
    give_input(bench, by).until("STOPPED")
    assert bench.position == made + STEPS


@pytest.mark.rules("REG-04", "REG-06")
def test_an_external_input_that_goes_away_within_it_is_lost():
    bench = register(store(Bench.ready(), 2000)).run(200)
    bench.inputs(external=1).run(250).inputs(external=0).run(500)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "MIN_REG_NONZERO"}
    bench.inputs(external=1).until("STOPPED")
    assert bench.position == 600 + 750 * 5 + STEPS


@EITHER_INPUT
@pytest.mark.rules("REG-04", "REG-15")
def test_a_lower_speed_counts_as_long_as_the_input_is_ignored(by):
    """Down to 3000/s from 850 steps on: 800 of them in 200 ms, 351 to step 2001 in 117 ms.

    Then 2600 in 866.67 ms, and 400 in the 200 ms of the stop.
    """
    bench = register(store(Bench.ready(), 2000)).run(200)
    give_input(bench, by).run(50)
    change_speed(bench, 3)
    took = bench.until("STOPPED")
    assert (bench.position, bench.fired) == (2001 + STEPS, [])
    assert 250 + took == pytest.approx(250 + 200 + 117 + 866.67 + 200, abs=1)


@EITHER_INPUT
@pytest.mark.rules("REG-04", "CMD-27")
def test_a_higher_speed_is_an_error_as_long_as_the_input_is_ignored(by):
    """The stop begins at once: 850 steps, and the 1200 of the ramp."""
    bench = register(store(Bench.ready(), 2000)).run(200)
    give_input(bench, by).run(50)
    change_speed(bench, 9).until("STOPPED")
    assert (bench.position, bench.fired) == (850 + 1200, ["CMD-27", "PRF-17"])


def change_speed(bench: Bench, thousands: int) -> Bench:
    """Change the speed words alone."""
    words = list(bench.outputs)
    words[4] = thousands
    return bench.out(*words)


@EITHER_WAY
@pytest.mark.rules("REG-05", "REG-07", "STS-L10")
def test_it_serves_every_move_from_where_that_starts(direction):
    bench = store(Bench.ready(position=-777), 2000)
    for number in range(1, 4):
        register(bench, direction).run(100)
        release(bench).until("STOPPED")
        assert bench.position == direction * number * (2001 + STEPS) - 777
        assert bench.bits == {"MODULE_OK", "STOPPED", "MIN_REG_NONZERO"}


@pytest.mark.rules("REG-12", "STS-L10")
def test_zero_turns_it_off():
    bench = store(Bench.ready(), 2000)
    assert bench.bits == {"MODULE_OK", "MIN_REG_NONZERO"}
    store(bench, 0)
    assert bench.bits == {"MODULE_OK"}
    register(bench).run(0.5)
    release(bench).until("STOPPED")
    assert bench.position == STEPS  # no step was made before the input


@pytest.mark.rules("REG-07", "REG-04")
@pytest.mark.parametrize("minimum", [1, 2, 8_388_607])
def test_from_one_step_to_all(minimum):
    bench = register(store(Bench.ready(scan_ms=2), minimum), speed=1000)
    bench.run(0.5)
    release(bench).run(5_000)
    if minimum > 4_000:
        assert "MOVING_CW" in bench.bits
    else:
        assert (bench.position, "STOPPED" in bench.bits) == (minimum + 1 + STEPS, True)


@pytest.mark.rules("REG-04")
def test_a_plain_manual_move_knows_no_minimum():
    bench = store(Bench.ready(), 2000).manual(ms=200)
    release(bench).run(400)
    assert (bench.position, "STOPPED" in bench.bits) == (1800, True)


@pytest.mark.rules("REG-14", "CFG-25", "IOM-04")
@pytest.mark.parametrize("how", ["the same configuration", "power off"])
def test_configuration_and_power_up_reset_it(how):
    bench = store(Bench.ready(), 2000)
    if how == "power off":
        bench.power_cycle()
    bench.out(*CONFIGURATION).run(5).idle(5)
    assert "MIN_REG_NONZERO" not in bench.bits
    register(bench).run(100)
    release(bench).until("STOPPED")
    assert bench.position == 200 + STEPS


KEPT = {
    "a move": lambda bench: bench.relative(5).until("MOVE_COMPLETE"),
    "a preset": lambda bench: bench.out(PRESET, 0, 5).run(1),
    "Reset Errors": lambda bench: bench.out(HOLD).run(1).reset_errors(),
    "program mode": lambda bench: bench.plc("program").run(5).plc("run").run(1),
    "a rejected configuration": lambda bench: bench.out(*configuration(start=0)).run(5),
}


@pytest.mark.rules("REG-05", "REG-14")
@pytest.mark.parametrize("between", KEPT.values(), ids=KEPT)
def test_nothing_else_resets_it(between):
    bench = store(Bench.ready(), 2000)
    between(bench)
    bench.out().run(1)
    assert "MIN_REG_NONZERO" in bench.bits


# -- storing it


@pytest.mark.rules("REG-10", "REG-11", "REG-12", "LSW-10")
@pytest.mark.parametrize("distance", [1, 999, 1000, 8_388_607])
def test_distances_that_are_stored(distance):
    bench = store(Bench.ready(), distance)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MIN_REG_NONZERO"}, [])


@pytest.mark.rules("REG-11", "REG-13", "CMD-20")
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0, -1), id="-1"),
        pytest.param((-2, 0), id="-2000"),
        pytest.param((8388, 608), id="8,388,608"),
        pytest.param((1, -1), id="words that are no value"),
        pytest.param((0, 1000), id="LSW 1000"),
    ],
)
def test_distances_that_are_refused(words):
    """Command Error alone; the old distance stays."""
    bench = store(Bench.ready(), 2000)
    bench.out(0, STORE, *words).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MIN_REG_NONZERO", "COMMAND_ERROR"}, ["CMD-20"])
    bench.idle().reset_errors()
    register(bench).run(100)
    release(bench).until("STOPPED")
    assert bench.position == 2001 + STEPS


@pytest.mark.rules("REG-10", "LSW-10")
@pytest.mark.parametrize("word", [0, 4, 5, 6, 7])
def test_words_that_must_be_zero(word):
    """Reading A-93: a command error, and neither the distance nor the command is taken."""
    bench = Bench.ready()
    words = [0, STORE, 0, 5, 0, 0, 0, 0]
    words[word] = RELATIVE if word == 0 else 1
    bench.out(*words).run(5)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["REG-10"])
    assert bench.position == 0


@pytest.mark.rules("REG-10", "CMD-02")
def test_too_many_command_bits_are_found_first():
    bench = Bench.ready()
    bench.command(0x0003, 5, lsw=STORE).run(5)
    assert bench.fired == ["CMD-02"]


@pytest.mark.rules("REG-10", "LSW-10")
def test_it_is_stored_when_the_bit_rises_and_not_later():
    bench = store(Bench.ready(), 0, idle=False)
    bench.out(0, STORE, 0, 5).run(5)
    assert bench.bits == {"MODULE_OK"}
    bench.out().scan()
    assert "MIN_REG_NONZERO" in store(bench, 5).bits


@pytest.mark.rules("REG-10")
@pytest.mark.parametrize("distance", [5, -5])
def test_it_cannot_be_stored_during_a_move(distance):
    """That the axis is busy is told before what is wrong with the distance."""
    bench = Bench.ready().relative(2000, ms=100)
    bench.out(0, STORE, 0, distance).run(1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING", "COMMAND_ERROR"}
    assert bench.fired == ["REG-10"]
    bench.until("MOVE_COMPLETE")
    assert bench.position == 2000


@pytest.mark.rules("REG-10", "STS-M12")
def test_it_is_not_stored_under_a_command_error():
    bench = Bench.ready()
    bench.out(HOLD).run(1)
    assert store(bench, 5).bits == {"MODULE_OK", "COMMAND_ERROR"}
    assert bench.fired == ["CMD-07"]


@pytest.mark.rules("REG-17", "LSW-10")
@pytest.mark.parametrize(("firmware", "known"), [("2.2", False), ("3.1", True)])
def test_firmware(firmware, known):
    """Before 3.1 bit 10 is reserved and ignored (A-94), and a manual move has no target (CMD-12)."""
    bench = store(Bench.ready(firmware), 2000)
    assert ("MIN_REG_NONZERO" in bench.bits, bench.fired) == (known, [])
    register(bench).run(100)
    assert bench.fired == ([] if known else ["CMD-12", "PRF-08"])
    assert ("MOVING_CW" in bench.bits) is known
