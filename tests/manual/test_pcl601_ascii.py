"""AA ASCII: the whole command summary, formats, verify replies, refusals, and who is spoken to."""

from __future__ import annotations

import pytest
from bench601 import Bench601
from scanrack.io_images.pcl601 import COMMANDS
from scanrack.io_images.pcl601.program import parse_program
from scanrack.io_images.pcl601.talk import Action
from scanrack.runtime import SerialBus
from scanrack.runtime.controllers.pcl601.program import ProgramMachine


@pytest.fixture
def bench():
    bench = Bench601()
    bench.to_ascii()
    return bench


# command, range, V's letters; from the command summary and the table of Verify
VALUES = [
    ("A", 100, 9_999_999),
    ("B", 1, 5000),
    ("C", 0, 65_535),
    ("D", 0, 65_535),
    ("EA", 0, 1),
    ("ED", 0, 65_535),
    ("EM", 1, 255),
    ("ER", 0, 255),
    ("EW", 0, 255),
    ("J", 1, 50_000),
    ("M", 1, 50_000),
    ("N", 0, 8_388_607),
    ("T", 0, 1),
    ("Z", -8_388_607, 8_388_607),
    ("'", 0, 1),
    ("(", 0, 1),
    ("/", 0, 1),
    (":", 0, 1),
    (";", 0, 1),
    ("[", 1, 50_000),
    ("]", 1, 50_000),
    ("^", 0, 255),
    ("{", 0, 65_535),
    ("}", 0, 65_535),
]


@pytest.mark.parametrize(("command", "low", "high"), VALUES, ids=[row[0] for row in VALUES])
def test_set_and_verify(bench, command, low, high):
    for value in (low, high):
        assert bench.talk(f"@1{command}{value}") is None  # setters say nothing
        assert bench.talk(f"@1V{command}") == f"{value}\r\n"
    for value in (low - 1, high + 1, "x", "1x", "1.5", " 1"):
        assert bench.talk(f"@1{command}{value}") is None
        assert bench.talk("@1!") == "64\r\n"
        assert bench.talk(f"@1V{command}") == f"{high}\r\n"


NEED_PARAMETERS = ["A", "B", "C", "D", "EA", "ED", "EM", "ER", "EW", "H", "I", "J", "M", "N", "O", "OR", "P"]
NEED_PARAMETERS += ["T", "V", "Z", "'", "(", "/", ":", ";", "[", "]", "^", "{", "}", "~"]


@pytest.mark.parametrize("command", NEED_PARAMETERS)
def test_without_parameters(bench, command):
    assert bench.talk(f"@1{command}") is None
    assert bench.talk("@1!") == "512\r\n"


TAKE_NONE = ["ET", "G", "S", "!", "$", "%", "+", ",", "-", ".", "|"]


@pytest.mark.parametrize("command", TAKE_NONE)
def test_with_parameters_that_it_does_not_take(bench, command):
    assert bench.talk(f"@1{command}5") is None
    assert bench.talk("@1!") == "64\r\n"
    assert bench.talk("@1VF") == "0\r\n"


def test_the_summary_has_41_commands():
    assert len(COMMANDS) == 41
    assert {command.name for command in COMMANDS} == (
        set(NEED_PARAMETERS) - {"OR"} | set(TAKE_NONE) | {row[0] for row in VALUES}
    )


NO_COMMANDS = ["@1Q", "@1E", "@1EX1", "@1a100", "@1", "@1VP", "@1VG", "@1VEA1", "@1 B5", "@100"]


@pytest.mark.parametrize("line", NO_COMMANDS)
def test_what_is_no_command(line):
    bench = Bench601(address=10 if line == "@100" else 1)
    bench.to_ascii()
    unit = line[1:3] if line == "@100" else "1"
    assert bench.talk(line) is None
    assert bench.talk(f"@{unit}!") == "8\r\n"


def test_verify_of_what_has_no_setter(bench):
    assert bench.talk("@1VEP") == "0\r\n"
    assert bench.talk("@1VF") == "0\r\n"
    assert bench.talk("@1VL") == "0\r\n"
    bench.pin("hard_minus")
    assert bench.talk("@1VL") == "1\r\n"
    bench.pin("soft_plus")
    assert bench.talk("@1VL") == "3\r\n"
    assert bench.talk("@1-", "@1V+") == "0\r\n"
    assert bench.talk("@1+", "@1V+") == "1\r\n"


def test_read_inputs(bench):
    assert bench.talk("@1IR") == "0\r\n"
    assert bench.talk("@1I1") == "1\r\n"
    for name in ("in1", "in2", "in3", "in4", "in5", "in6"):
        bench.pin(name)
    assert bench.talk("@1IR") == "63\r\n"  # the manual's own number for all grounded
    assert bench.talk("@1I6") == "0\r\n"
    for line in ("@1I0", "@1I7", "@1IX", "@1IR1"):
        assert bench.talk(line, "@1!") == "64\r\n"


def test_set_outputs(bench):
    assert bench.talk("@1OR5", "@1VO") == "5\r\n"
    assert bench.talk("@1O2=1", "@1VO") == "7\r\n"
    assert bench.talk("@1O1=0", "@1VO") == "6\r\n"
    assert bench.talk("@1O8=1", "@1VO") == "134\r\n"
    for line in ("@1O9=1", "@1O0=1", "@1O1=2", "@1O1", "@1O=1", "@1OR256", "@1OR-1", "@1ORx"):
        assert bench.talk(line, "@1!") == "64\r\n"
        assert bench.talk("@1VO") == "134\r\n"


def test_absolute_position_sets_steps_and_direction(bench):
    bench.talk("@1Z500", "@1P-1500")
    assert bench.talk("@1VN") == "2000\r\n"
    assert bench.talk("@1V+") == "0\r\n"
    bench.talk("@1G")
    bench.wait(3000)
    assert bench.talk("@1VZ") == "-1500\r\n"


@pytest.mark.parametrize("line", ["@1P8388608", "@1P-8388608"])
def test_absolute_position_out_of_range(bench, line):
    assert bench.talk(line, "@1!") == "32\r\n"


def test_absolute_position_too_far_away(bench):
    assert bench.talk("@1Z-8000000", "@1P8000000", "@1!") == "32\r\n"
    bench.talk("@1G")
    assert bench.talk("@1VF") == "0\r\n"


def test_absolute_position_given_in_motion_holds_for_the_next_go(bench):
    bench.talk("@1N2000", "@1G", "@1P100")
    assert bench.talk("@1!") == "0\r\n"
    bench.wait(5000)
    bench.talk("@1G")
    bench.wait(5000)
    assert bench.talk("@1VZ") == "100\r\n"


def test_go_repeats(bench):
    bench.talk("@1N40", "@1G")
    bench.wait(500)
    bench.talk("@1G")
    bench.wait(500)
    assert bench.talk("@1VZ") == "80\r\n"


def test_go_after_an_absolute_position_goes_as_far_again(bench):
    bench.talk("@1P40", "@1G")
    bench.wait(500)
    bench.talk("@1G")
    bench.wait(500)
    assert bench.talk("@1VZ") == "80\r\n"  # P has set N, once


def test_home_and_slew_and_stops(bench):
    bench.ge("home", 1000)
    bench.talk("@1H0")
    bench.wait(3000)
    assert bench.talk("@1VZ") == "1000\r\n"
    bench.talk("@1-", "@1S")
    assert bench.talk("@1VF") == "1\r\n"
    bench.talk("@1.")
    assert bench.talk("@1VF") == "0\r\n"
    bench.talk("@1S", "@1,")
    bench.wait(200)
    assert bench.talk("@1VF") == "0\r\n"
    assert bench.talk("@1H2", "@1!") == "64\r\n"


def test_in_motion(bench):
    bench.talk("@1S")
    for line in ("A1000", "B500", "J600", "M5000", "Z0", "+", "-", "G", "H0", "H1", "S"):
        assert bench.talk("@1" + line, "@1!") == "1024\r\n", line
    for line in (
        "C1",
        "D1",
        "N5",
        "P5",
        "EM5",
        "T1",
        "'1",
        "(0",
        "/0",
        ":0",
        ";0",
        "[5",
        "^1",
        "OR1",
        "VA",
        "IR",
    ):
        bench.talk("@1" + line)
        assert bench.talk("@1!") == "0\r\n", line


def test_errors_add_up_and_are_cleared_by_being_read(bench):
    assert bench.talk("@1Q", "@1B", "@1!") == "520\r\n"
    assert bench.talk("@1!") == "0\r\n"


def test_version(bench):
    assert "1.00" in bench.talk("@1$")


def test_address(bench):
    assert bench.talk("@%") == "1\r\n"
    assert bench.talk("@1%") == "1\r\n"
    assert bench.talk("@2%") is None
    bench.talk("@~13")
    assert bench.talk("@%") == "13\r\n"
    assert bench.talk("@1$") is None
    assert bench.talk("@13$") is not None
    assert bench.talk("@13~0", "@0%") == "0\r\n"  # 0 is an address in AA ASCII
    assert bench.talk("@~100", "@0!") == "64\r\n"
    bench.talk("@~07")
    assert bench.talk("@07VF") == "0\r\n"


def test_address_is_kept_through_power_loss(bench):
    bench.talk("@~5")
    bench.unit.power_cycle(bench.bus.now_ns)
    bench.to_ascii()
    assert bench.talk("@%") == "5\r\n"


def test_only_what_is_said_to_this_unit_is_heard(bench):
    for line in ("@2B321", "B321", "1B321", "@B321", "2000", "@@2B321", "@3@2B321"):
        assert bench.talk(line) is None
    assert bench.talk("@1VB") == "500\r\n"
    assert bench.talk("@1!") == "0\r\n"
    assert bench.talk("noise@2@1B321", "@1VB") == "321\r\n"


def test_lines_of_others_may_come_in_pieces_and_with_line_feeds(bench):
    bench.bus.send(b"\n@1B3", bench.unit.line_format)
    bench.wait(1000)
    bench.bus.send(b"21\r\n", bench.unit.line_format)
    bench.wait(10)
    assert bench.talk("@1VB") == "321\r\n"


def test_a_line_too_long_for_the_buffer_is_the_receive_overflow(bench):
    assert bench.talk("@1N" + "0" * 30, "@1!") == "1\r\n"
    assert bench.talk("@1N000001234", "@1!") == "64\r\n"  # nine characters of parameters
    assert bench.talk("@1N00001234", "@1VN") == "1234\r\n"


def test_back_to_modbus(bench):
    assert bench.talk("@1|") is None
    assert bench.ask("01 11") == "01 11 05 01 31 2e 30 30"
    bench.to_ascii()
    bench.unit.power_cycle(bench.bus.now_ns)
    assert bench.ask("01 11") == "01 11 05 01 31 2e 30 30"


def test_while_a_program_runs():
    bench = Bench601(runner=ProgramMachine(parse_program("WAIT 60000\nEND")))
    bench.to_ascii()
    bench.controller.do(12)
    bench.controller.settle(bench.bus.now_ns)
    for command in COMMANDS:
        parameters = {Action.VERIFY: "A", Action.INPUTS: "R"}.get(command.action, "")
        if command.name in (".", "!"):
            continue
        bench.talk(f"@1{command.name}{parameters}")
        allowed = command.name in ("V", "I", "$", "%")
        assert bench.talk("@1!") == ("0\r\n" if allowed else "256\r\n"), command.name
    assert bench.talk("@1Q", "@1!") == "8\r\n"
    bench.talk("@1.")
    assert not bench.controller.program_running


def test_registers_are_the_same_in_both_protocols(bench):
    bench.talk("@1M4321", "@1P-77", "@1;1", "@1|")
    assert bench.ask("01 03 00 06 00 01") == "01 03 02 10 e1"
    assert bench.ask("01 03 00 0e 00 02") == "01 03 04 ff b3 ff ff"
    assert bench.ask("01 03 00 0a 00 01") == "01 03 02 00 01"


def test_several_units_on_one_line():
    units = [Bench601(address=n).unit for n in (1, 2, 3)]
    bus = SerialBus(*units)
    bus.send(bytes.fromhex("00 06 00 00 00 0b c9 dc"), units[0].line_format)
    bus.run_until(20_000_000)
    bus.send(b"@2B321\r@2VB\r", units[0].line_format)
    bus.run_until(60_000_000)
    assert bus.take() == b"321\r\n"
    assert [unit.controller.errors for unit in units] == [0, 0, 0]
