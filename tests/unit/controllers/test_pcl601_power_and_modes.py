"""What a PCL601 forgets when its power goes, and when a change of its mode counts: at once."""

from __future__ import annotations

import pytest
from bench601 import Bench601
from scanrack.io_images.pcl601 import Error, Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.io_images.pcl601.terminals import ON_FLY_OUTPUT, ON_FLY_PULSE_NS
from scanrack.runtime.controllers.pcl601.controller import Protocol
from scanrack.runtime.controllers.pcl601.line import FORMATS, Pcl601
from scanrack.runtime.controllers.pcl601.program import ProgramMachine
from scanrack.runtime.line.rtu import frame

TO_ASCII = bytes.fromhex("06 00 00 00 0b")  # Appendix 1: command code 11
MODBUS, ASCII = FORMATS[Protocol.MODBUS], FORMATS[Protocol.ASCII]


def in_a_pulse() -> Bench601:
    """Return a bench in the midst of an on-the-fly pulse of output 1 at 100."""
    bench = Bench601()
    bench.write(Register.OUTPUT_ON_FLY, 1)
    bench.write(Register.FIRST_OUTPUT_POSITION, 100)
    bench.write(Register.STEPS_BETWEEN_OUTPUTS, 50)
    bench.write(Register.NUMBER_OF_OUTPUTS, 2)
    bench.go(1000)
    while not bench.controller.axis.fly.positions:
        due_ns = bench.bus.next_event_ns()
        assert due_ns is not None
        bench.bus.run_until(due_ns)
    assert bench.controller.output_pins == ON_FLY_OUTPUT
    return bench


def test_a_pulse_on_the_fly_ends_with_the_power() -> None:
    bench = in_a_pulse()
    bench.unit.power_cycle(bench.bus.now_ns)
    assert bench.controller.output_pins == 0
    assert bench.controller.next_wake_ns is None


def test_a_pulse_on_the_fly_outlasts_a_stop_and_no_other_follows() -> None:
    bench = in_a_pulse()
    now_ns = bench.bus.now_ns
    bench.controller.do(5)
    bench.controller.settle(now_ns)
    assert bench.controller.output_pins == ON_FLY_OUTPUT
    bench.controller.advance(now_ns + ON_FLY_PULSE_NS)
    assert bench.controller.output_pins == 0
    bench.write(Register.OUTPUT_ON_FLY, 0)
    bench.go(1000)
    bench.wait(5000)
    assert list(bench.controller.axis.fly.positions) == [100]


def test_code_11_by_broadcast_counts_at_once() -> None:
    bench = Bench601()
    assert bench.exchange(frame(0, TO_ASCII)) == b""
    assert bench.unit.line_format == ASCII
    assert bench.unit.quiet_ns == 0
    assert bench.talk("@1VB") == "500\r\n"


def test_code_11_by_broadcast_counts_in_the_instant_in_which_it_is_carried_out() -> None:
    unit = Pcl601()
    unit.receive(10_000_000, frame(0, TO_ASCII))
    assert unit.next_wake_ns is not None
    assert unit.advance(unit.next_wake_ns) == b""
    assert unit.line_format == ASCII


def test_code_11_over_tcp_counts_for_the_next_character() -> None:
    unit = Pcl601()
    assert unit.answer(TO_ASCII) == TO_ASCII
    assert unit.answer(TO_ASCII) is None
    unit.receive(10_000_000, b"@%\r")
    assert unit.line_format == ASCII
    assert unit.advance(10_000_000) == b"1\r\n"


def test_a_reset_in_ascii_counts_at_once() -> None:
    bench = Bench601()
    bench.to_ascii()
    bench.unit.power_cycle(bench.bus.now_ns)
    assert bench.unit.line_format == MODBUS
    assert bench.unit.quiet_ns > 0


def test_a_line_begun_before_a_reset_is_forgotten() -> None:
    bench = Bench601()
    bench.to_ascii()
    bench.talk("@1B4")
    bench.exchange(b"@1B77")  # no CR yet
    bench.unit.power_cycle(bench.bus.now_ns)
    bench.to_ascii()
    bench.exchange(b"8\r")
    assert bench.talk("@1VB") == "500\r\n"
    assert bench.controller.errors == Error(0)


def test_a_line_begun_before_a_reset_is_forgotten_when_tcp_leads_back_to_ascii() -> None:
    bench = Bench601()
    bench.to_ascii()
    bench.exchange(b"@1B77")
    bench.unit.power_cycle(bench.bus.now_ns)
    assert bench.unit.answer(TO_ASCII) == TO_ASCII
    bench.exchange(b"8\r")
    assert bench.talk("@1VB") == "500\r\n"


def test_a_line_begun_before_modbus_is_forgotten_when_ascii_comes_back() -> None:
    bench = Bench601()
    bench.to_ascii()
    bench.exchange(b"@1M77")
    bench.controller.speak(Protocol.MODBUS)
    bench.wait(10)
    bench.to_ascii()
    bench.exchange(b"8\r")
    assert bench.talk("@1VM") == "5000\r\n"


def ran(text: str, **options: object) -> Bench601:
    """Return a bench whose stored program has run for half a second."""
    bench = Bench601(runner=ProgramMachine(parse_program(text)), **options)
    bench.code(12)
    bench.wait(500)
    return bench


@pytest.mark.parametrize(
    ("instruction", "register", "value"),
    [
        ("ACCEL 4321", Register.ACCEL, 4321),
        ("BASE 321", Register.BASE_SPEED, 321),
        ("MAX 4321", Register.MAX_SPEED, 4321),
        ("JOG 321", Register.JOG_SPEED, 321),
        ("SETPOS -321", Register.POSITION, -321),
        ("DIR CCW", Register.DIRECTION, 0),
        ("CURRENT OFF", Register.MOTOR_CURRENT, 0),
        ("ENCDELAY 321", Register.ENCODER_DELAY, 321),
        ("ASPEEDLO 321", Register.ANALOG_SPEED_LOWER, 321),
        ("ASPEED ON", Register.ANALOG_ENABLE, 1),
        ("APOS ON", Register.ANALOG_ENABLE, 1),
        ("REGINDEX 321", Register.STEPS, 321),
    ],
)
def test_a_stored_program_sets_registers(instruction: str, register: Register, value: int) -> None:
    bench = ran(f"{instruction}\nEND")
    assert bench.controller.errors == Error(0)
    assert bench.read(register) == value


def test_a_stored_program_moves_at_the_speed_that_it_has_set() -> None:
    # base 999, max 1000: 250 steps in 0.25 s; at the default of 500 and 5000 they would take 0.39 s
    bench = ran("BASE 999\nMAX 1000\nACCEL 9999999\nMOVE 250\nFINISH\nOUTPUTS 10000000\nEND")
    assert bench.position == 250
    bench = Bench601(
        runner=ProgramMachine(parse_program("BASE 999\nMAX 1000\nACCEL 9999999\nMOVE 2500\nEND"))
    )
    bench.code(12)
    began_ns = bench.bus.now_ns
    bench.bus.run_until(began_ns + 1_003_000_000)
    assert 995 <= bench.position <= 1005


def test_the_analog_speed_of_a_stored_program_is_its_own() -> None:
    bench = Bench601(
        runner=ProgramMachine(
            parse_program("ASPEEDLO 1000\nASPEEDHI 5000\nASPEED ON\nSETASPEED\nAPOS OFF\nSETASPEED\nEND")
        )
    )
    bench.controller.pins.apply_volts(3)  # 1000 + 4000 * 3 / 5
    bench.code(12)
    bench.wait(50)
    assert bench.read(Register.MAX_SPEED) == 3400
    assert bench.controller.errors == Error(0)
