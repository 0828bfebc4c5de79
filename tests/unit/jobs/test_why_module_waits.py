"""What a 3601 waits for, as the bench tells it: the manual's states, one after the other."""

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.traces import ScanRecorder, SlotInfo
from typer.testing import CliRunner

PROGRAM = """from scanrack import (
    Configuration, Direction, Hold, Idle, InputBit, Manual, Move, MoveKind, PresetPosition, ResetErrors
)

CONFIGURATION = Configuration(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, starting_speed=100)
ABSOLUTE = Move(MoveKind.ABSOLUTE, 1000, speed=1000, acceleration=100, deceleration=100)
RELATIVE = Move(MoveKind.RELATIVE, 300, speed=1000, acceleration=100, deceleration=100)
JOG = Manual(Direction.CCW, speed=1000, acceleration=100, deceleration=100)
SENT = {"now": CONFIGURATION.to_image()}


def logic(scan):
    scan.slot[1].outputs.load(SENT["now"])
"""
RACK = """program = "line.py"
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return open_bench(tmp_path / "rack.toml")


def send(bench, command, scans=1):
    names = bench.logic.__globals__
    names["SENT"]["now"] = eval(command, names).to_image()
    bench.scan(scans)


def state(bench):
    """What is said of slot 1, less the lines of its output words: this program obeys the test."""
    lines = bench.why().splitlines()
    said = [each.removeprefix("slot 1: ").strip() for each in lines]
    end = next((row for row, each in enumerate(said) if each.startswith("output word")), len(said))
    return said[:end]


def ready(bench):
    """Configured and preset to 0; scan 4 is the next."""
    bench.scan(2)
    send(bench, "Idle()", 1)
    send(bench, "PresetPosition(0)", 1)


def test_from_power_up_to_configured(bench):
    bench.scan()  # the configuration is out; its answer is of the next scan
    assert state(bench)[0].startswith(
        "bit 15 of output word 0 is 1 since scan 0 (0 s): it enters configuration"
    )
    bench.scan()
    assert state(bench) == [
        "in configuration mode since scan 1 (0.002 s), configured: it accepts no command until "
        "bit 15 of output word 0 goes back to 0"
    ]


def test_a_configuration_that_is_refused_names_its_rules(bench):
    names = bench.logic.__globals__
    names["SENT"]["now"] = names["CONFIGURATION"].to_image()
    names["SENT"]["now"][0] = 0x8004  # a home switch and no end limit
    bench.scan(2)
    (said,) = state(bench)
    assert said == (
        "in configuration mode since scan 1 (0.002 s): it waits for a valid configuration: the configuration "
        "has neither a CW nor a CCW end limit switch [CFG-02, chapter 3]"
    )


def test_at_rest_it_waits_for_a_command_and_says_what_is_not_valid(bench):
    bench.scan(2)
    send(bench, "Idle()", 2)
    assert state(bench) == [
        "at rest at 0: it waits for a command bit to go from 0 to 1",
        "POSITION_INVALID since scan 3 (0.006 s): the module was configured, which always makes the position "
        "invalid [POS-01, chapter 6, Position Invalid 1]; a home or a preset clears it; until then it "
        "refuses absolute moves",
    ]


def test_a_move_its_target_and_the_bit_that_stays_on(bench):
    ready(bench)
    send(bench, "ABSOLUTE")  # scan 4
    assert state(bench) == ["ABSOLUTE_MOVE with this scan: it accepts the command with its next update"]
    bench.scan(2)
    (said,) = state(bench)
    assert said.startswith("moving CW, accelerating, at ")
    assert said.endswith(": ABSOLUTE_MOVE since scan 4 (0.008 s); MOVE_COMPLETE not yet, its target is 1,000")
    bench.run_until("slot1.status.MOVE_COMPLETE")
    ended = bench.scans - 1
    bench.scan(2)
    assert state(bench) == [
        f"at rest at 1,000, MOVE_COMPLETE since scan {ended:,} ({ended * 0.002:g} s); ABSOLUTE_MOVE is still "
        "on since scan 4 (0.008 s): the next command needs a bit that goes from 0 to 1"
    ]


def test_a_relative_move_has_its_target_from_where_it_began(bench):
    ready(bench)
    send(bench, "Idle()")
    send(bench, "PresetPosition(500)")
    send(bench, "Idle()")
    send(bench, "RELATIVE", 4)
    assert state(bench)[0].endswith("MOVE_COMPLETE not yet, its target is 800")  # 500 and 300


def test_hold_and_manual_moves(bench):
    ready(bench)
    send(bench, "ABSOLUTE", 40)
    send(bench, "Hold()", 300)
    assert state(bench)[0].startswith("held since scan ")
    assert (
        "it waits for RESUME_MOVE, or for another move; HOLD_MOVE is still on since scan 44"
        in state(bench)[0]
    )
    send(bench, "Idle()")
    send(bench, "JOG", 20)
    assert state(bench)[0].endswith("; it runs until MANUAL_CCW goes back to 0")


def test_an_error_names_its_rule_and_what_clears_it(bench):
    ready(bench)
    send(bench, "ABSOLUTE", 5)
    send(bench, "Idle()")
    send(bench, "RELATIVE", 2)  # during the move: command error 3 of chapter 6
    said = state(bench)
    assert said[0].startswith("moving CW")
    assert said[1].endswith(
        ": a move was started before the previous one was complete; the previous one goes on [CMD-03, "
        "chapter 6, Command Error 3]; RESET_ERRORS clears it [RST-01, chapter 4, Reset Errors]"
    )
    assert said[1].startswith("COMMAND_ERROR since scan 11 (0.022 s)")


def test_a_trace_that_does_not_say_what_made_it_answers_from_its_images(tmp_path):
    path = tmp_path / "hardware.mcap"
    memory = bytearray(32)
    recorder = ScanRecorder(path, memory, [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=2_000_000)
    for scan in range(5):
        memory[:2] = (scan >= 2).to_bytes(2, "little")  # ABSOLUTE_MOVE from scan 2 on
        memory[16:18] = (0x4001 if scan >= 3 else 0x4000).to_bytes(2, "little")  # MOVING_CW, MODULE_OK
        recorder.scan(scan, scan * 2_000_000, 1)
    recorder.close()
    result = CliRunner().invoke(build(), ["why", str(path)])
    assert result.exit_code == 0, result.output
    assert "slot 1: moving CW, at 0: ABSOLUTE_MOVE since scan 2 (0.004 s)" in result.stdout
    bit = CliRunner().invoke(build(), ["why", str(path), "slot1.command.ABSOLUTE_MOVE"])
    assert "slot1.command.ABSOLUTE_MOVE is on since 0.004 s (scan 2)" in bit.stdout


def test_a_lost_link_is_named_with_its_instant(bench):
    """Its inputs are frozen, so they say nothing of the present."""
    ready(bench)
    send(bench, "ABSOLUTE", 10)  # scans 4 to 13
    bench.slot[1].inject("link-lost")
    bench.scan(3)
    assert state(bench)[0] == (
        "the link to it is lost since scan 14 (0.028 s): its inputs keep their last state; "
        "no command reaches it"
    )
    bench.slot[1].inject(None)
    bench.scan(3)
    assert state(bench)[0].startswith("at rest at ")
