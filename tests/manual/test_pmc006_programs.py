"""User programs of a PMC006x3s: their text and what they do [5]."""

from __future__ import annotations

import pytest
from bench006 import Bench006
from scanrack.io_images.pmc006.program import USER_OPS, assemble
from scanrack.io_images.pmc006.status import Status1, Status2
from scanrack.runtime.controllers.pmc006.interpreter import CMP_OPTIONS, EFFECTS, WAIT_OPTIONS
from scanrack.runtime.controllers.pmc006.pins import Pin

# 5.1.1, in the manual's order
MANUAL_OPS = (
    "ROT MIC DIR EXTEN FREE CLR2 CLR1 VSET ACC TRIG CNT1 CNTC JMP JNE JEQ WAIT OUT CMP RESET_EN PAUSE_EN"
)

EVERYTHING = """\
ROT 0 1
MIC 0 16
DIR 0 0
EXTEN 0 1
FREE 0 0
CLR2 0
CLR1 0
VSET 0 6000
ACC 0 3
TRIG 0 3
CNT1 0
CNTC 0
JMP 0 50
JNE 0 0
JEQ 0 0
WAIT 7 1
OUT 5 1
CMP 6 65536
RESET_EN 1 50
PAUSE_EN 1 0
"""


def running(program: str, **parameters: int) -> Bench006:
    """Return a bench on which a program has been started."""
    bench = Bench006(1, program)
    bench.set(start_speed=1000, stop_speed=1000, max_speed=1000, **parameters)
    assert bench.ask("Z") == 0
    return bench


def test_5_1_1_the_twenty_instructions() -> None:
    assert list(USER_OPS) == MANUAL_OPS.split() == [line.split()[0] for line in EVERYTHING.splitlines()]
    assert set(EFFECTS) == set(USER_OPS)
    assert (set(WAIT_OPTIONS), set(CMP_OPTIONS)) == (set(range(1, 8)), set(range(1, 7)))


def test_a_program_is_the_same_after_there_and_back() -> None:
    program = assemble(EVERYTHING)
    assert "".join(f"{line}\n" for line in program.lines) == EVERYTHING
    assert program.warnings == ()


def test_blanks_comments_case_and_the_manual_s_other_spelling() -> None:
    text = "# a comment\n\n  cnti  # counts\nclr1 0 0\nRot 0 0x10\n"
    assert list(map(str, assemble(text).lines)) == ["CNT1 0", "CLR1 0", "ROT 0 16"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("RIT 0 1", "RIT is not a user instruction; did you mean ROT"),
        ("ROT 0", "ROT takes an option and data"),
        ("ROT 0 1 2", "ROT takes an option and data"),
        ("ROT 0 0", "ROT data 0: must be 1 to 2147483647"),
        ("ROT 1 5", "ROT option 1: must be 0"),
        ("MIC 0 3", "MIC data 3: must be 0, 2, 4, 8"),
        ("VSET 0 6001", "VSET data 6001: must be 0 to 6000"),
        ("WAIT 8 1", "WAIT option 8: must be 1 to 7"),
        ("CMP 7 1", "CMP option 7: must be 1 to 6"),
        ("OUT 6 1", "OUT option 6: must be 1 to 5"),
        ("JMP 0 100", "JMP data 100: must be 0 to 99"),
        ("CNT1 0 5", "CNT1 data 5: must be none, or 0"),
        ("DIR 0 one", "DIR data one: must be a whole number"),
    ],
)
def test_a_line_that_says_nothing_allowed_is_refused_by_its_number(line: str, said: str) -> None:
    with pytest.raises(ValueError, match=f"line 2: .*{said}"):
        assemble(f"CNTC 0\n{line}\n")


def test_5_a_hundred_instructions_are_the_most() -> None:
    assert len(assemble("CNTC 0\n" * 100).lines) == 100
    with pytest.raises(ValueError, match="101 instructions: must be at most 100"):
        assemble("CNTC 0\n" * 101)


def test_what_the_manual_s_table_does_not_have_is_taken_with_a_warning() -> None:
    warned = assemble("JMP 0 51\nACC 0 8\nEXTEN 0 3\nROT 0 5\n").warnings
    assert [warning.partition(":")[0] for warning in warned] == ["line 1", "line 2", "line 3"]


def test_5_1_2_a_counted_loop_of_moves() -> None:
    bench = running("DIR 0 1\nVSET 0 2000\nCNTC 0\nROT 0 300\nWAIT 1 1\nCNT1 0\nCMP 1 3\nJNE 0 3\n")
    assert bench.status1 == Status1.BUSY  # the line is answered while the program runs
    bench.wait(3000)
    assert bench.position == 900
    assert not bench.controller.interpreter.running
    bench.ask("Z")
    bench.wait(3000)
    assert bench.position == 1800


def test_5_1_2_4_rot_does_not_wait_for_its_end() -> None:
    bench = running("ROT 0 500\nCNT1 0\nROT 0 500\n")  # the second one finds the motor busy
    bench.wait(2000)
    assert (bench.position, bench.controller.interpreter.counter) == (500, 1)


def test_an_instruction_takes_a_millisecond() -> None:
    bench = Bench006(1, "CNT1 0\n" * 100)
    bench.controller.execute(ord("Z"), 0)
    began = bench.bus.now_ns
    for ms in (0, 1, 50, 99):
        bench.bus.run_until(began + ms * 1_000_000)
        assert bench.controller.interpreter.counter == ms + 1
    assert bench.controller.interpreter.running
    bench.wait(1)
    assert not bench.controller.interpreter.running


def test_5_1_2_3_jumps() -> None:
    bench = running("CMP 1 1\nJEQ 0 4\nCNT1 0\nJMP 0 0\nCNT1 0\nCMP 1 2\nJNE 0 4\nOUT 1 0\n")
    bench.wait(100)
    assert (bench.controller.interpreter.counter, bench.controller.gpio8) == (2, False)


def test_a_jump_behind_the_last_line_ends_it() -> None:
    bench = running("JMP 0 50\nOUT 1 0\n")
    bench.wait(10)
    assert (bench.controller.interpreter.running, bench.controller.gpio8) == (False, True)


def test_settings_by_program() -> None:
    bench = running("MIC 0 64\nDIR 0 0\nEXTEN 0 3\nVSET 0 0\nACC 0 6\nTRIG 0 2\nOUT 2 0\nOUT 1 0\nFREE 0 1\n")
    bench.wait(20)
    assert [bench.ask(char) for char in "kvhK"] == [64, 1000, 6, 2]
    assert bench.controller.memory["accel_coefficient"] == 6
    assert bench.status2 == Status2.EXT1_EN | Status2.EXT2_EN | Status2.FREE_RUN
    assert not bench.controller.gpio8


@pytest.mark.parametrize(("option", "pin"), [(2, Pin.EXT1), (3, Pin.EXT2), (4, Pin.FSET), (5, Pin.GPI2)])
def test_5_1_2_4_wait_for_a_level(option: int, pin: Pin) -> None:
    bench = running(f"WAIT {option} 0\nOUT 1 0\nWAIT {option} 1\nOUT 1 1\n")
    bench.wait(20)
    assert bench.controller.gpio8
    bench.pin(pin, False)
    bench.wait(2)
    assert not bench.controller.gpio8
    bench.pin(pin, True)
    bench.wait(2)
    assert bench.controller.gpio8


def test_wait_looks_once_per_millisecond() -> None:
    bench = Bench006(1, "WAIT 4 0\nOUT 1 0\n")
    bench.controller.execute(ord("Z"), 0)
    seen = []
    for level in (False, True, False):  # low from 0.3 to 0.6 ms, too short to be seen, and from 0.9 ms on
        bench.wait(0.3)
        bench.pin(Pin.FSET, level)
    for _ in range(3):  # looked at 1 ms, so OUT is due at 2 ms
        bench.wait(0.6)
        seen.append((bench.bus.now_ns, bench.controller.gpio8))
    assert seen == [(1_500_000, True), (2_100_000, False), (2_700_000, False)]


@pytest.mark.parametrize(("option", "pin", "clear"), [(6, Pin.EXT1, "b"), (7, Pin.EXT2, "l")])
def test_5_1_2_4_wait_for_an_emergency_stop_and_its_end(option: int, pin: Pin, clear: str) -> None:
    bench = running(f"WAIT {option} 1\nOUT 1 0\nWAIT {option} 0\nOUT 1 1\n", ext_stop_enable=3)
    bench.pin(pin, False)
    bench.wait(5)
    assert not bench.controller.gpio8
    bench.ask(clear)
    bench.wait(5)
    assert bench.controller.gpio8


def test_5_1_2_clr1_and_clr2_clear_the_flags() -> None:
    bench = running("WAIT 6 1\nWAIT 7 1\nCLR1 0\nCLR2 0\n", ext_stop_enable=3)
    bench.pin(Pin.EXT1, False)
    bench.wait(5)
    assert bench.status1 == Status1.EXT1
    bench.pin(Pin.EXT2, False)
    bench.wait(5)
    assert bench.status1 == Status1(0)


@pytest.mark.parametrize(
    ("compare", "prepared"),
    [
        ("2 0", {Pin.EXT1}),
        ("3 0", {Pin.EXT2}),
        ("4 1", {Pin.EXT1}),
        ("5 1", {Pin.EXT2}),
        ("6 10", {Pin.EXT1, Pin.EXT2}),
    ],
)
def test_5_1_2_6_compare(compare: str, prepared: set[Pin]) -> None:
    program = f"CMP {compare}\nJNE 0 0\nOUT 1 0\n"
    bench = running(program, ext_stop_enable=3)
    bench.wait(20)
    assert bench.controller.gpio8
    for pin in prepared:
        bench.pin(pin, False)
    bench.wait(5)
    assert not bench.controller.gpio8


@pytest.mark.parametrize(
    ("lines", "running_yet"),
    [
        pytest.param("WAIT 1 1\nOUT 1 0\nWAIT 4 1\n", True, id="while the program runs"),
        pytest.param("JMP 0 9\nOUT 1 0\n", False, id="when it is over"),
    ],
)
def test_5_1_2_7_the_reset_key_stops_the_move_and_goes_to_its_line(lines: str, running_yet: bool) -> None:
    bench = running("RESET_EN 1 3\nROT 0 5000\n" + lines)
    bench.wait(1000)
    assert bench.controller.interpreter.running is running_yet
    bench.pin(Pin.FSET, False)
    stopped = bench.controller.axis.physical
    assert 900 < stopped < 1100
    bench.wait(20)
    assert (bench.position, bench.controller.gpio8) == (stopped, False)


def test_5_1_2_7_a_program_started_anew_has_no_key_bound() -> None:
    bench = running("WAIT 2 0\nROT 0 500\nWAIT 2 1\nRESET_EN 1 0\n")
    bench.pin(Pin.EXT1, False)
    bench.wait(1000)
    bench.pin(Pin.EXT1, True)
    bench.wait(20)
    bench.ask("Z")
    bench.pin(Pin.EXT1, False)
    bench.wait(100)
    bench.pin(Pin.FSET, False)
    bench.wait(1000)
    assert bench.position == 1000


def test_5_1_2_7_the_pause_key_holds_the_program_and_not_the_move() -> None:
    bench = running("PAUSE_EN 1 0\nROT 0 500\nWAIT 1 1\nROT 0 500\n")
    bench.pin(Pin.GPI2, False)
    bench.pin(Pin.GPI2, True)
    bench.wait(3000)
    assert bench.position == 500
    bench.pin(Pin.GPI2, False)
    bench.wait(3000)
    assert bench.position == 1000


@pytest.mark.parametrize("enable", ["RESET_EN 0 0", "PAUSE_EN 0 0", "CNTC 0"])
def test_5_1_2_7_keys_that_are_not_bound_do_nothing(enable: str) -> None:
    bench = running(f"{enable}\nROT 0 500\nWAIT 1 1\nROT 0 500\n")
    for pin in (Pin.FSET, Pin.GPI2):
        bench.pin(pin, False)
        bench.pin(pin, True)
    bench.wait(3000)
    assert bench.position == 1000


def test_5_offline_execution_starts_the_program_with_the_power() -> None:
    bench = Bench006(1, "ROT 0 500\n")
    bench.wait(1000)
    assert bench.position == 0  # it does not start by being there
    bench.set(offline_execution=1)
    bench.power_cycle()
    assert bench.position == 0  # F was not saved
    bench.set(offline_execution=1)
    bench.ask("t")
    bench.power_cycle()
    bench.wait(1000)
    assert (bench.position, bench.status2) == (500, Status2.DIR | Status2.OFFLINE_AUTO)


def test_without_a_program_a_test_run_is_refused() -> None:
    assert Bench006().ask("Z") == 6
