"""The PCL601's special functions: on-the-fly output and index, analog input, thumbwheel, encoder, program.

Set-up of most: B 500, M 2000, A 1000, so a ramp takes 1.5 s and 1875 steps.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from bench601 import MS, Bench601
from scanrack.io_images.pcl601 import Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime.controllers.pcl601.autocorrect import Autocorrect
from scanrack.runtime.controllers.pcl601.motor import EncoderModel
from scanrack.runtime.controllers.pcl601.program import ProgramMachine
from scanrack.runtime.controllers.pcl601.register_values import Values
from scanrack.runtime.controllers.pcl601.wiring import Wiring


def made(**options):
    bench = Bench601(**options)
    bench.set_up()
    return bench


def settle(bench):
    while bench.controller.busy:
        assert bench.bus.next_event_ns() is not None
        bench.bus.run_until(bench.bus.next_event_ns())


def on_fly(bench, first, spacing, count):
    for register, value in (
        (Register.OUTPUT_ON_FLY, 1),
        (Register.FIRST_OUTPUT_POSITION, first),
        (Register.STEPS_BETWEEN_OUTPUTS, spacing),
        (Register.NUMBER_OF_OUTPUTS, count),
    ):
        bench.write(register, value)


ON_FLY = {
    "the manual's example": ((2000, 1000, 5), 0, 10_000, [2000, 3000, 4000, 5000, 6000]),
    "single": ((2500, 0, 0), 0, 5000, [2500]),
    "count 1": ((2500, 100, 1), 0, 5000, [2500]),
    "count 0 with a spacing": ((2500, 100, 0), 0, 5000, [2500]),
    "the move ends first": ((2000, 1000, 5), 0, 3500, [2000, 3000]),
    "no spacing": ((2500, 0, 3), 0, 5000, [2500]),
    "going down": ((2000, 1000, 5), 5000, -2500, [2000, 1000, 0, -1000, -2000]),
    "behind the start": ((2000, 1000, 5), 2500, 6000, []),
    "at the end": ((2000, 0, 0), 0, 2000, [2000]),
}


@pytest.mark.parametrize(("settings", "start", "target", "positions"), ON_FLY.values(), ids=ON_FLY)
def test_output_on_the_fly(settings, start, target, positions):
    bench = made()
    on_fly(bench, *settings)
    bench.write(Register.POSITION, start)
    bench.go_to(target)
    settle(bench)
    assert list(bench.controller.axis.fly.positions) == positions


def test_output_1_is_on_for_50_us():
    bench = made()
    on_fly(bench, 100, 0, 0)
    bench.go(1000)
    controller = bench.controller
    while not controller.axis.fly.positions:
        bench.bus.run_until(bench.bus.next_event_ns())
    begun = bench.bus.now_ns
    assert (controller.output_pins, controller.values[Register.POSITION]) == (1, 100)
    bench.bus.run_until(begun + 49_999)
    assert controller.output_pins == 1
    bench.bus.run_until(begun + 50_000)
    assert controller.output_pins == 0


def test_output_on_the_fly_works_in_index_moves_only():
    bench = made()
    on_fly(bench, 100, 0, 0)
    bench.code(4)
    bench.wait(1000)
    bench.code(5)
    assert bench.position > 100
    assert list(bench.controller.axis.fly.positions) == []


def test_output_on_the_fly_must_be_enabled():
    bench = made()
    on_fly(bench, 100, 0, 0)
    bench.write(Register.OUTPUT_ON_FLY, 0)
    bench.go(1000)
    settle(bench)
    assert list(bench.controller.axis.fly.positions) == []


@pytest.mark.parametrize("steps", [2500, 1000, 1])
@pytest.mark.parametrize("direction", [1, 0])
def test_index_on_the_fly_ends_so_many_steps_after_the_mark(steps, direction):
    bench = made(wiring=None)
    bench.write(Register.DIRECTION, direction)
    bench.write(Register.STEPS, steps)
    bench.write(Register.INDEX_ON_FLY, 1)
    (bench.ge if direction else bench.le)("in2", 3000 if direction else -3000)
    bench.code(4)
    settle(bench)
    assert abs(bench.position) == 3000 + steps  # shorter than the ramp of 1875: cut short, still exact


def test_a_mark_in_the_acceleration_lets_it_go_on_accelerating():
    bench = made()
    bench.write(Register.STEPS, 5000)
    bench.write(Register.INDEX_ON_FLY, 1)
    bench.pin("in2")  # from the start: counts from the first step
    begun = bench.bus.now_ns
    bench.code(4)
    settle(bench)
    assert bench.position == 5001
    assert (bench.bus.now_ns - begun) / 1e9 == pytest.approx(3 + (5001 - 3750) / 2000, abs=0.03)


def test_index_on_the_fly_needs_its_enable_and_a_slew():
    bench = made()
    bench.write(Register.STEPS, 1000)
    bench.ge("in2", 100)
    bench.code(4)
    bench.wait(3000)
    assert bench.busy()
    bench.code(5)
    bench.write(Register.INDEX_ON_FLY, 1)
    bench.write(Register.POSITION, 0)
    bench.go(1000)
    settle(bench)
    assert bench.read(Register.POSITION) == 1000


ANALOG = [(0, 5000, "2.0", 2000), (1000, 5000, "3.2", 3560), (0, 100, "0", 0), (0, 100, "5", 100)]


@pytest.mark.parametrize(("low", "high", "volts", "result"), ANALOG)
def test_analog_calculations(low, high, volts, result):
    bench = made()
    bench.write(Register.ANALOG_ENABLE, 1)
    bench.write(Register.ANALOG_POS_LOWER, low)
    bench.write(Register.ANALOG_POS_UPPER, high)
    bench.controller.pins.apply_volts(Fraction(volts))
    bench.code(8)
    assert (bench.errors(), bench.busy()) == (0, False)
    assert bench.read(Register.ABS_TARGET) == bench.read(Register.ANALOG_INDEX) == result
    bench.code(1)
    settle(bench)
    assert bench.read(Register.POSITION) == result


def test_analog_speed():
    bench = made()
    bench.write(Register.ANALOG_ENABLE, 1)
    bench.write(Register.ANALOG_SPEED_LOWER, 1000)
    bench.write(Register.ANALOG_SPEED_UPPER, 5000)
    bench.controller.pins.apply_volts(Fraction("3.2"))
    bench.code(7)
    assert bench.read(Register.MAX_SPEED) == 3560


@pytest.mark.parametrize("code", [7, 8])
def test_analog_refused(code):
    bench = made()
    bench.code(code)
    assert bench.errors() == 512
    bench.code(10)
    bench.write(Register.ANALOG_ENABLE, 1)
    bench.write(Register.ANALOG_SPEED_LOWER, 50_000)
    bench.write(Register.ANALOG_POS_LOWER, 65_535)
    bench.code(code)
    assert bench.errors() == 64


def test_input_1_as_analog_input_reads_active_over_modbus():
    bench = made()
    bench.write(Register.ANALOG_ENABLE, 1)
    assert bench.ask("01 04 00 00 00 01") == "01 04 02 00 01"
    bench.to_ascii()
    assert bench.talk("@1IR") == "0\r\n"


@pytest.mark.parametrize(("volts", "active"), [("0", 1), ("1.99", 1), ("2", 0), ("5", 0)])
def test_input_1_as_a_level(volts, active):
    bench = made()
    bench.controller.pins.apply_volts(Fraction(volts))
    assert bench.ask("01 04 00 00 00 01") == f"01 04 02 00 0{active}"


def test_thumbwheel():
    bench = made(wiring=Wiring(True, 1234))
    bench.write(Register.THUMBWHEEL_ENABLE, 1)
    bench.write(Register.DIRECTION, 0)
    bench.code(9)
    assert bench.read(Register.STEPS) == 1234
    assert not bench.busy()
    bench.code(1)
    settle(bench)
    assert bench.position == -1234


@pytest.mark.parametrize(
    ("wiring", "enable", "error"),
    [
        (Wiring(True, None), 1, 8192),
        (Wiring(False, 1234), 1, 8192),
        (Wiring(True, 1234), 0, 512),
        (Wiring(True, 8_388_608), 1, 64),
    ],
)
def test_thumbwheel_refused(wiring, enable, error):
    bench = made(wiring=wiring)
    bench.write(Register.STEPS, 7)
    bench.write(Register.THUMBWHEEL_ENABLE, enable)
    bench.code(9)
    assert (bench.errors(), bench.read(Register.STEPS)) == (error, 7)


def test_inputs_5_and_6_are_not_connected_with_the_switch_at_tws():
    bench = made(wiring=Wiring(True))
    for name in ("in4", "in5", "in6"):
        bench.pin(name)
    assert bench.ask("01 04 00 00 00 01") == "01 04 02 00 08"


def corrected(model, *, window=10, retries=3, steps=1000, delay=100, direction=1):
    """Run one move with autocorrect; ratio 10."""
    bench = made(encoder=model)
    for register, value in (
        (Register.ENCODER_DELAY, delay),
        (Register.ENCODER_WINDOW, window),
        (Register.ENCODER_RATIO, 10),
        (Register.ENCODER_RETRIES, retries),
        (Register.ENCODER_AUTOCORRECT, 1),
        (Register.DIRECTION, direction),
    ):
        bench.write(register, value)
    bench.go(steps)
    begun = bench.bus.now_ns
    settle(bench)
    return bench, (bench.bus.now_ns - begun) / 1e9


def test_an_ideal_encoder_needs_no_correction():
    bench, seconds = corrected(EncoderModel(10))
    assert (bench.errors(), bench.position, bench.read(Register.ENCODER_POSITION)) == (0, 1000, 10_000)
    # the ramps meet at sqrt(500^2 + 1000*1000) = 1118/s: 1.236 s, then busy through the delay of 0.1 s
    assert seconds == pytest.approx(1.236 + 0.1, abs=0.01)


@pytest.mark.parametrize("direction", [1, 0])
def test_lost_steps_are_made_up_for(direction):
    bench, _ = corrected(EncoderModel(10, "lose_steps_once", 5), direction=direction)
    sign = 1 if direction else -1
    assert bench.errors() == 2
    assert bench.position == sign * 1000
    assert bench.read(Register.ENCODER_POSITION) == sign * 10_000
    assert bench.read(Register.POSITION) == sign * 1000  # correction steps are not counted
    assert bench.read(Register.STEPS) == 5  # the relative register is used for them
    assert bench.controller.outputs == 0


def test_lost_steps_within_the_window_stay_lost():
    bench, _ = corrected(EncoderModel(10, "lose_steps_once", 5), window=50)
    assert (bench.errors(), bench.position) == (0, 995)


def test_steps_are_lost_once():
    bench, _ = corrected(EncoderModel(10, "lose_steps_once", 5), window=255, steps=50)
    assert bench.position == 50  # none is lost before the 101st, and the first index is over
    bench.go(1000)
    settle(bench)
    assert (bench.errors(), bench.position) == (0, 1050)


def test_a_dead_encoder_exhausts_the_retries():
    bench, seconds = corrected(EncoderModel(10, "stuck"), steps=200)
    assert bench.errors() == 2 + 4
    assert bench.controller.outputs == 0b1000_0000
    assert bench.position == 200 + 3 * 200  # each time all 200 steps were missing
    assert seconds == pytest.approx(0.342 + 4 * 0.1 + 3 * 200 / 500, abs=0.01)
    bench.ask("01 05 00 07 00 00")
    assert bench.controller.outputs == 0


def test_no_retries():
    bench, _ = corrected(EncoderModel(10, "stuck"), steps=200, retries=0)
    assert (bench.errors(), bench.position) == (4, 200)


@pytest.mark.parametrize(
    ("pulses", "steps"), [(10, None), (-10, None), (11, 1), (14, 1), (15, 2), (-15, -2), (-14, -1), (30, 3)]
)
def test_what_is_missing_in_motor_steps(pulses, steps):
    values = Values()
    values[Register.ENCODER_WINDOW], values[Register.ENCODER_RATIO] = 10, 10
    values[Register.ENCODER_POSITION] = 7
    assert Autocorrect(values, -20).missing(7 - 200 - pulses) == steps


def test_a_stopped_index_is_not_corrected():
    bench = made(encoder=EncoderModel(1, "stuck"))
    bench.write(Register.ENCODER_AUTOCORRECT, 1)
    bench.write(Register.ENCODER_RETRIES, 3)
    bench.go(10_000)
    bench.wait(500)
    bench.code(5)
    assert not bench.busy()
    assert bench.errors() == 0


def test_encoder_reset():
    bench = made(encoder=EncoderModel(7))
    bench.go(10)
    settle(bench)
    assert bench.read(Register.ENCODER_POSITION) == 70
    bench.code(15)
    assert bench.read(Register.ENCODER_POSITION) == 0


def runs(text):
    bench = made(runner=ProgramMachine(parse_program(text)))
    bench.code(12)
    return bench


def test_writes_are_refused_while_a_program_runs_reads_and_code_5_are_not():
    bench = runs("SLEW\nWAIT 60000\nEND")
    assert bench.read(Register.BASE_SPEED) == 500
    assert bench.ask("01 11").startswith("01 11")
    assert bench.ask("01 05 00 00 ff 00") == "01 85 06"
    assert bench.ask("01 0f 00 00 00 01 01 01") == "01 8f 06"
    assert bench.ask("01 06 00 01 00 01") == "01 86 06"
    assert bench.ask("01 10 00 01 00 01 02 00 01") == "01 90 06"
    for code in (1, 6, 10, 12):
        assert bench.code(code) == 6
    assert bench.busy()
    assert bench.code(5) is None
    assert not bench.busy()
    assert not bench.controller.program_running
    assert bench.write(Register.STEPS, 1) is None


def test_a_program_that_waits_is_not_busy():
    bench = runs("WAIT 60000\nEND")
    assert not bench.busy()
    assert bench.controller.program_running


def test_run_without_a_program():
    bench = made()
    bench.code(12)
    assert bench.errors() == 4096


def test_autorun_survives_power_loss():
    bench = made(runner=ProgramMachine(parse_program("MOVE 50\nFINISH\nEND")))
    bench.code(14)
    bench.unit.power_cycle(bench.bus.now_ns)
    bench.wait(1000)
    assert bench.position == 50
    bench.code(13)
    bench.unit.power_cycle(bench.bus.now_ns)
    bench.wait(1000)
    assert bench.position == 50


def test_text_in_modbus_mode_is_the_mode_error():
    bench = runs('TEXT "@2G"\nMOVE 5\nEND')
    bench.wait(100)
    assert (bench.errors(), bench.position) == (256, 0)


def test_text_in_ascii_mode_is_sent_with_cr():
    bench = made(runner=ProgramMachine(parse_program('WAIT 5000\nTEXT "@2G"\nEND')))
    bench.code(12)
    bench.exchange(bytes.fromhex("00 06 00 00 00 0b c9 dc"))  # refused while it runs
    bench.code(5)
    bench.to_ascii()
    bench.controller.do(12)
    bench.controller.settle(bench.bus.now_ns)
    bench.bus.run_until(bench.bus.now_ns + 6000 * MS)
    assert bench.bus.take() == b"@2G\r"
