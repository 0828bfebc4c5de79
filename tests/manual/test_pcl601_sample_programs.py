"""The manual's sample programs, running [Section 6]; where they stop follows from their descriptions."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt

import pytest
from programs601 import MS, Bench, sample
from scanrack.io_images.pcl601 import Code, Error, Register
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pcl601.motor import EncoderModel
from scanrack.runtime.machine.contacts import GROUND, OPEN


@pytest.mark.slow
def test_sample_1_stops_at_4000_8000_and_0_for_ever() -> None:
    """At 1000 steps/s² from 500 steps/s, 4000 steps do not reach 5000 steps/s: v² = B² + A N.

    The seven instructions up to MOVE take 6 ms; the move takes 2 (v - B) / A.
    """
    bench = Bench(sample(1))
    bench.start()
    bench.run(16_000)
    assert bench.positions == [4000, 8000, 0, 4000]
    move_ms = 2 * (sqrt(500**2 + 1000 * 4000) - 500)
    assert bench.stops[0].at_ms == pytest.approx(6 + move_ms, abs=2)
    assert bench.controller.program_running


@pytest.mark.slow
def test_sample_1_waits_half_a_second_at_0() -> None:
    """FINISH looks within 1 ms; then WAIT 500, and GOTO, LABEL, DIR, MOVE, 1 ms each."""
    bench = Bench(sample(1))
    bench.start()
    bench.run_until_stop(3)
    start_ms = bench.stops[2].at_ms
    bench.run(start_ms + 500)
    assert not bench.controller.busy
    bench.run(start_ms + 506)
    assert bench.controller.busy


def test_sample_1_is_stopped_by_code_5() -> None:
    """The drawing's "Quit": the operator's stop ends program and motion."""
    bench = Bench(sample(1))
    bench.start()
    bench.run(1000)
    bench.controller.do(Code.STOP_MOTION)
    bench.controller.settle(1000 * MS)
    stopped_at = bench.position
    bench.run(60_000)
    assert (bench.position, bench.controller.program_running, bench.positions) == (stopped_at, False, [])
    assert 0 < stopped_at < 4000


@pytest.mark.slow
def test_sample_2_homes_and_serves_three_stations_again_and_again() -> None:
    """Home at -4000, its soft limit 2000 steps earlier: more than the 1596 steps of the ramp.

    Three rounds instead of the ten of the file.
    """
    bench = Bench(sample(2).replace("LOOP OUTER 10", "LOOP OUTER 3"), encoder=EncoderModel(10))
    bench.connect(soft_minus=Contact(high=-2000), home=Contact(high=-4000))
    bench.start()
    bench.run(100_000)
    assert bench.positions == [-4000] + [2000, 4000, 6000, 0] * 3
    assert not bench.controller.program_running
    assert bench.controller.errors == Error(0)
    assert bench.controller.motor.position == -4000


def test_sample_2_corrects_what_the_shaft_has_missed() -> None:
    """5 steps are 50 counts, more than the window of 20: one correction, and the encoder is right.

    The first move takes 2 (v - B) / A = 1.2 s with v² = B² + A N; at 2 s the station works.
    """
    bench = Bench(sample(2), encoder=EncoderModel(10, "lose_steps_once", 5))
    bench.connect(home=GROUND)
    bench.start()
    bench.run(2000)
    assert bench.controller.read()[Register.ENCODER_POSITION] == 20_000
    assert bench.controller.errors == Error(2)


@pytest.mark.slow
def test_sample_3_pulses_on_the_way_out_only() -> None:
    """Output 1 at 2000, 3000, ... 6000, once more for WAIT 1 at the end, and not on the way back."""
    bench = Bench(sample(3))
    bench.connect(soft_minus=Contact(high=-2000), home=Contact(high=-3000))
    bench.start()
    bench.run(12_000)
    assert (bench.position, bench.controller.busy) == (0, False)
    bench.connect(in1=GROUND)
    bench.run(12_300)
    bench.connect(in1=OPEN)
    bench.run(21_000)
    assert bench.positions == [-3000, 10_000, 0]
    assert list(bench.controller.axis.fly.positions) == [2000, 3000, 4000, 5000, 6000]
    assert bench.controller.program_running


def test_sample_3_turns_output_1_on_for_the_time_of_wait_1() -> None:
    """OUTPUTS, WAIT 1, OUTPUTS: two instructions of 1 ms between on and off."""
    bench = Bench(sample(3))
    bench.connect(home=GROUND, in1=GROUND)
    bench.start()
    on = []
    for at_ms in range(6000):
        bench.run(at_ms)
        on += [at_ms] if bench.controller.outputs & 1 else []
    assert len(on) == 2
    assert bench.positions[0] == 10_000


@pytest.mark.slow
def test_sample_4_ends_2500_steps_after_its_mark() -> None:
    """2 V of 5 between 5000 and 10000 are 7000 steps/s.

    Home (from -3000 on) is released at -2999, which becomes 0; the mark at 5000 is then 7999.
    """
    bench = Bench(sample(4))
    bench.connect(home=Contact(high=-3000))
    bench.controller.pins.apply_volts(Fraction(2))
    bench.start()
    bench.run(20_000)
    assert bench.controller.motor.position == -2999
    bench.connect(in2=Contact(low=5000), in3=GROUND)
    bench.run(22_000)
    assert bench.controller.read()[Register.MAX_SPEED] == 7000
    bench.connect(in3=OPEN)
    bench.run(40_000)
    assert bench.positions[-2:] == [7999 + 2500, 0]
    assert bench.controller.errors == Error(0)
    assert bench.controller.program_running


def test_sample_4_has_output_1_on_for_100_ms_before_it_goes_back() -> None:
    """OUTPUTS on, WAIT 100, OUTPUTS off: 1 + 100 ms."""
    bench = Bench(sample(4))
    bench.connect(home=Contact(high=-3000), in2=Contact(low=5000), in3=GROUND)
    bench.start()
    bench.run_until_stop(2)
    on = 0
    for _ in range(200):
        bench.run(bench.controller.now_ns / MS + 1)
        on += bench.controller.outputs & 1
    assert on == 101


@pytest.mark.parametrize("number", range(1, 6))
def test_autorun_starts_a_program_at_every_power_up(number: int) -> None:
    bench = Bench(sample(number))
    bench.controller.do(Code.AUTORUN_ON)
    for _ in range(2):
        bench.controller.power_up(bench.controller.now_ns)
        assert bench.controller.program_running
    bench.controller.do(Code.STOP_MOTION)
    bench.controller.do(Code.AUTORUN_OFF)
    bench.controller.power_up(bench.controller.now_ns)
    assert not bench.controller.program_running


def test_text_in_modbus_mode_is_a_mode_error_and_ends_the_program() -> None:
    """Sample 5 is "intended to run with the device configured to use the AA ASCII protocol"."""
    bench = Bench(sample(5))
    bench.start()
    bench.run(1000)
    assert (bench.controller.errors, bench.controller.program_running) == (Error.MODE, False)
