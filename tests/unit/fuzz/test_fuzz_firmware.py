"""A program names the firmware that it needs: older versions are not tried, and not a failure."""

from __future__ import annotations

import pytest
from scanrack.commands import build
from scanrack.jobs import read_state
from typer.testing import CliRunner

REGISTERS = """
from scanrack.io_images.amci3601 import Configuration, Direction, Idle, Manual, StatusView

{needs}
WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()
JOG = Manual(Direction.CW, 2000, 100, 100, 300).to_image()

def logic(scan):
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    if scan.number < 3:
        out.load(WORDS)
    else:
        out.load(Idle().to_image() if status.MODE_CONFIG or scan.number < 6 else JOG)
"""
"""It jogs with a registration distance, which firmware 3.1 was the first to know (CMD table, chapter 4)."""

RACK = """program = "line.py"
run_for_s = 0.05
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def fuzz(tmp_path):
    def run(needs="", slot=""):
        (tmp_path / "line.py").write_text(REGISTERS.format(needs=needs), encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK + slot, encoding="utf-8")
        words = ["fuzz", str(tmp_path / "line.toml"), "--only", "firmware", "--runs", "15", "--jobs", "1"]
        return CliRunner().invoke(build(), [*words, "--out", str(tmp_path / "out")])

    return run


@pytest.mark.slow
def test_without_a_name_old_firmware_is_a_failure_and_with_one_it_is_left_out(fuzz, tmp_path):
    first = fuzz()
    assert first.exit_code == 1, first.output
    assert "slot 1 has firmware 2.2" in first.stdout  # 3.1 is the next, and knows the distance
    second = fuzz('NEEDS_FIRMWARE = "3.1"')
    assert second.exit_code == 0, second.output
    assert second.stdout.startswith("left out: ")
    state = read_state(tmp_path / "out" / "state.json", "../line.toml")
    assert {version for each in state.corpus.values() for _slot, version in each.firmware} <= {"3.1", "4.1"}


def test_the_slot_of_the_rack_file_says_it_for_any_program(fuzz):
    assert fuzz(slot='needs_firmware = "3.1"\n').exit_code == 0


@pytest.mark.parametrize(
    ("needs", "slot", "says"),
    [
        (
            'NEEDS_FIRMWARE = "3.1"',
            'firmware = "2.2"\n',
            "NEEDS_FIRMWARE is 3.1, but slot 1 has firmware 2.2",
        ),
        ('NEEDS_FIRMWARE = "9"', "", "NEEDS_FIRMWARE = '9': unknown 3601 firmware '9'"),
        ("", 'firmware = "2.2"\nneeds_firmware = "3.1"\n', "firmware 2.2: the program needs 3.1 or newer"),
        ("", 'needs_firmware = "x"\n', "unknown 3601 firmware 'x'"),
    ],
)
def test_a_module_that_is_too_old_is_refused(fuzz, needs, slot, says):
    result = fuzz(needs, slot)
    assert result.exit_code == 2
    assert says in result.stderr
