"""The flow of a stored program, against an axis that writes down what it is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime.controllers.pcl601.program import ProgramMachine

MS = 1_000_000


@dataclass
class Notes:
    """An axis that does at once what it is asked for, or refuses it."""

    now_ns: int = 0
    busy: bool = False
    levels: int = 0b111111
    refused: str = ""
    errors: int = 0
    asked: list[tuple[int, str]] = field(default_factory=list)

    def __getattr__(self, name: str) -> Any:
        return lambda *values, **named: self._note(name, *values, *named.values())

    def _note(self, name: str, *values: Any) -> bool:
        words = [getattr(value, "name", str(value)) for value in values]
        self.asked.append((self.now_ns // MS, " ".join([name, *words])))
        return name != self.refused

    def inputs_raw(self) -> int:
        return self.levels

    def report(self, error: int) -> None:
        self.errors |= error


def run(text: str, axis: Notes, until_ms: int = 10_000) -> ProgramMachine:
    machine = ProgramMachine(parse_program(text))
    machine.start(axis.now_ns)
    go_on(machine, axis, until_ms)
    return machine


def go_on(machine: ProgramMachine, axis: Notes, until_ms: int) -> None:
    while machine.next_wake_ns is not None and machine.next_wake_ns <= until_ms * MS:
        axis.now_ns = machine.next_wake_ns
        machine.advance(axis.now_ns, axis)


def moves(text: str, **options: Any) -> list[str]:
    axis = Notes(**options)
    assert not run(text, axis).running
    return [asked for _, asked in axis.asked]


def test_a_program_that_has_not_been_started_stands_at_its_first_line() -> None:
    machine = ProgramMachine(parse_program("OUTPUTS 10000000\nEND"))
    assert (machine.line, machine.running) == (0, False)


def test_one_instruction_a_millisecond_and_a_wait_of_its_own_length() -> None:
    axis = Notes()
    run("LABEL A\nOUTPUTS 10000000\nWAIT 100\nOUTPUTS 00000001\nEND", axis)
    assert axis.asked == [(1, "set_outputs 1"), (102, "set_outputs 128")]


@pytest.mark.parametrize(
    ("instruction", "asked"),
    [
        ("ACCEL 1000", "write ACCEL 1000"),
        ("BASE 500", "write BASE_SPEED 500"),
        ("MAX 5000", "write MAX_SPEED 5000"),
        ("JOG 700", "write JOG_SPEED 700"),
        ("SETPOS -5", "write POSITION -5"),
        ("DIR CW", "write DIRECTION 1"),
        ("DIR CCW", "write DIRECTION 0"),
        ("CURRENT OFF", "write MOTOR_CURRENT 0"),
        ("MOVE 4000", "move 4000"),
        ("MOVETO -4000", "move_to -4000"),
        ("REPEAT", "repeat"),
        ("HOME0", "command 2"),
        ("HOME1", "command 3"),
        ("SLEW", "command 4"),
        ("STOPSOFT", "command 6"),
        ("STOPHARD", "command 5"),
        ("OUTPUTS 11000001", "set_outputs 131"),
        ("THUMB ON", "write THUMBWHEEL_ENABLE 1"),
        ("MOVETHUMB", "move_thumbwheel"),
        ("ENC ON", "write ENCODER_AUTOCORRECT 1"),
        ("ENCDELAY 100", "write ENCODER_DELAY 100"),
        ("ENCRATIO 10", "write ENCODER_RATIO 10"),
        ("ENCRETRIES 3", "write ENCODER_RETRIES 3"),
        ("ENCWINDOW 20", "write ENCODER_WINDOW 20"),
        ("ENCRESET", "command 15"),
        ("ASPEED ON", "set_analog True"),
        ("SETASPEED", "command 7"),
        ("ASPEEDLO 5000", "write ANALOG_SPEED_LOWER 5000"),
        ("ASPEEDHI 10000", "write ANALOG_SPEED_UPPER 10000"),
        ("APOS OFF", "set_analog False"),
        ("GOTOAPOS", "move_to_analog"),
        ("APOSLO 0", "write ANALOG_POS_LOWER 0"),
        ("APOSHI 65535", "write ANALOG_POS_UPPER 65535"),
        ("OOTF ON", "write OUTPUT_ON_FLY 1"),
        ("OOTFPOS 2000", "write FIRST_OUTPUT_POSITION 2000"),
        ("OOTFSTEP 1000", "write STEPS_BETWEEN_OUTPUTS 1000"),
        ("OOTFCOUNT 5", "write NUMBER_OF_OUTPUTS 5"),
        ("IOTF ON", "write INDEX_ON_FLY 1"),
        ("REGINDEX 2500", "write STEPS 2500"),
        ('TEXT "@1G"', "send_text @1G"),
    ],
)
def test_what_an_instruction_asks_the_axis_for(instruction: str, asked: str) -> None:
    """Outputs 1, 2 and 8 are bits 0, 1 and 7: 1 + 2 + 128."""
    assert moves(f"{instruction}\nEND") == [asked]


@pytest.mark.parametrize(("levels", "taken"), [(0b111111, ["move 2"]), (0b111011, ["move 1", "move 2"])])
@pytest.mark.parametrize("test", ["IF INPUT 3 = 0", "IF INPUTS 110111"])
def test_if_skips_exactly_the_next_line(test: str, levels: int, taken: list[str]) -> None:
    """110111 is input 3 low [Sample Program 4]; input 3 is bit 2."""
    assert moves(f"{test}\nMOVE 1\nMOVE 2\nEND", levels=levels) == taken


def test_if_may_skip_the_end() -> None:
    assert moves("MOVE 1\nIF INPUT 1 = 0\nEND") == ["move 1"]


def test_a_loop_passes_its_body_the_given_number_of_times() -> None:
    assert moves("LABEL A\nMOVE 1\nLOOP OUTER 3 A\nMOVE 2\nEND") == ["move 1"] * 3 + ["move 2"]


def test_inner_loops_begin_anew_in_each_pass_of_the_outer_one() -> None:
    text = "LABEL A\nLABEL B\nMOVE 1\nLOOP INNER 2 B\nLABEL C\nMOVE 2\nLOOP INNER 3 C\nLOOP OUTER 2 A\nEND"
    assert moves(text) == (["move 1"] * 2 + ["move 2"] * 3) * 2


def test_a_loop_left_by_goto_begins_anew_when_it_is_entered_again() -> None:
    """Input 1 leads out of the loop in its second pass; afterwards all three are passed."""
    text = "LABEL A\nMOVE 1\nIF INPUT 1 = 0\nGOTO OUT\nLOOP INNER 3 A\nEND\nLABEL OUT\nMOVE 2\nGOTO A\nEND"
    axis = Notes()
    machine = run(text, axis, until_ms=5)
    axis.levels = 0b111110
    go_on(machine, axis, 8)
    axis.levels = 0b111111
    go_on(machine, axis, 1000)
    assert [asked for _, asked in axis.asked] == ["move 1"] * 2 + ["move 2"] + ["move 1"] * 3


def test_a_subroutine_inside_a_loop_does_not_disturb_it() -> None:
    text = "LABEL A\nGOTO SUB\nLOOP INNER 2 A\nMOVE 9\nEND\nLABEL SUB\nMOVE 1\nRETURN\nEND"
    assert moves(text) == ["move 1", "move 1", "move 9"]


def test_return_without_goto_is_a_memory_error() -> None:
    axis = Notes()
    assert not run("RETURN\nMOVE 1\nEND", axis).running
    assert (axis.errors, axis.asked) == (4096, [])


def test_finish_holds_until_the_axis_is_idle() -> None:
    axis = Notes()
    machine = run("FINISH\nMOVE 1\nEND", axis, until_ms=-1)
    axis.busy = True
    go_on(machine, axis, 500)
    axis.busy = False
    go_on(machine, axis, 1000)
    assert axis.asked == [(502, "move 1")]


def test_what_needs_an_idle_axis_ends_the_program_while_it_moves() -> None:
    """Also REGINDEX, whose register may otherwise be written during motion."""
    for instruction in ("MOVE 1", "DIR CW", "REGINDEX 5", "SLEW"):
        axis = Notes(busy=True)
        assert not run(f"{instruction}\nEND", axis).running
        assert (axis.errors, axis.asked) == (1024, [])


def test_a_refused_instruction_ends_the_program() -> None:
    assert moves('TEXT "@1G"\nMOVE 1\nEND', refused="send_text") == ["send_text @1G"]


def test_starting_begins_anew() -> None:
    axis = Notes()
    machine = run("LABEL A\nMOVE 1\nLOOP INNER 2 A\nEND", axis, until_ms=3)
    machine.stop()
    assert not machine.running
    machine.start(10 * MS)
    go_on(machine, axis, 1000)
    assert [asked for _, asked in axis.asked] == ["move 1"] + ["move 1"] * 2
