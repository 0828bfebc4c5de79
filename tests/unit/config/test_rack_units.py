"""Controllers beside a rack: a PCL601 with its program and the switches of its machine, recorded."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from mcap.reader import make_reader
from scanrack.commands import build
from typer.testing import CliRunner, Result

RACK = """
program = "logic.py"
scan_ms = 10
run_for_s = 20

[[slot]]
number = 1
module = "amci3601"

[[unit]]
program = "sample3.pclt"
start = true
pins = { home = "..-3000", soft_minus = "..-2000", in1 = "ground" }
"""

SAMPLE_3 = Path(__file__).parents[3] / "examples/pcl601/sample3.pclt"


def run(folder: Path, rack: str) -> Result:
    (folder / "logic.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (folder / "sample3.pclt").write_bytes(SAMPLE_3.read_bytes())
    (folder / "rack.toml").write_text(rack, encoding="utf-8")
    trace = str(folder / "run.mcap")
    return CliRunner().invoke(build(), ["run", str(folder / "rack.toml"), "--record", trace, "--quiet"])


@pytest.mark.slow
def test_a_unit_runs_its_program_beside_the_rack_and_is_recorded(tmp_path: Path) -> None:
    """Sample Program 3 homes at -3000, sets the position to 0 and indexes to 10000.

    Where it stands is looked at every scan of 10 ms: at base speed that is 5 steps.
    """
    result = run(tmp_path, RACK)
    assert result.exit_code == 0, result.stderr
    with (tmp_path / "run.line.mcap").open("rb") as stream:
        messages = [
            (message.log_time, json.loads(message.data))
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages()
            if channel.topic == "/unit1"
        ]
    positions = [fields["position"] for _, fields in messages]
    assert -3000 <= min(positions) < -2950
    assert 9950 < max(positions) <= 10_000
    assert messages[0][0] == 0
    assert {time % 10_000_000 for time, _ in messages} == {0}
    again = tmp_path / "again"
    again.mkdir()
    run(again, RACK)
    assert (again / "run.line.mcap").read_bytes() == (tmp_path / "run.line.mcap").read_bytes()


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ("sample3", "sample9", "sample9.pclt: No such file or directory"),
        ('"..-3000"', '"near"', "'near' is not a state of an input; choose from ground, open"),
        ("home =", "door =", "no input door; choose from in1, in2"),
        ("start =", "begin =", "unknown key"),
        ("[[unit]]", "[[unit]]\n[[unit]]", "address 1 is used twice"),
        ('program = "sample3.pclt"\n', "", "no program to start: add a key `program`"),
    ],
)
def test_a_unit_that_cannot_be_made_is_told(was: str, now: str, said: str, tmp_path: Path) -> None:
    result = run(tmp_path, RACK.replace(was, now))
    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.parametrize("name", ["sample3.pclt", "./sample3.pclt", ".//sample3.pclt"])
def test_a_trace_with_units_is_rerun_from_the_files_in_it(tmp_path: Path, name: str) -> None:
    rack = RACK.replace("run_for_s = 20", "run_for_s = 1").replace("sample3.pclt", name)
    assert run(tmp_path, rack).exit_code == 0
    result = CliRunner().invoke(
        build(), ["replay", "--into", "session", "--trust", str(tmp_path / "run.mcap")]
    )
    assert result.exit_code == 0, result.stderr
