"""A program that writes its input tags: a value stays until the module's next update, and is not on record.

Broken on purpose: no copies (the scan ends in a TypeError), copies taken in every scan (the scans between two
exchanges of a CompactLogix go red), a replay that takes them in every scan (so does its comparison).
"""

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from typer.testing import CliRunner

RACK = """scan_ms = 1
controller = "{controller}"
program = "line.rung"
[[slot]]
number = 1
module = "amci3601"
"""

PROGRAM = """PROGRAM line
ROUTINE Main
MOV(Local:1:I.Data[6],Local:1:O.Data[7]);
ADD(Local:1:I.Data[6],1,Local:1:I.Data[6]);
OTE(Local:1:I.Data[5].3);
XIC(Local:1:I.Data[5].3)MOV(Local:1:I.Data[6],Local:1:O.Data[6]);
END
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "line.rung").write_text(PROGRAM, encoding="utf-8")
    return tmp_path


def scanrack(*words):
    return CliRunner().invoke(build(), [*map(str, words)])


@pytest.mark.parametrize(
    ("controller", "seen"),
    [
        ("micrologix", [0, 0, 0, 0, 0, 0]),
        ("compactlogix", [0, 1, 0, 1, 0, 1]),  # an RPI of 2 ms: exchanges at 0, 2 and 4
    ],
)
def test_what_is_written_stays_until_the_next_update_and_is_not_on_record(folder, controller, seen):
    rack, trace = folder / "line.toml", folder / "line.mcap"
    rack.write_text(RACK.format(controller=controller), encoding="utf-8")
    assert scanrack("run", rack, "--scans", 6, "--record", trace, "-q").exit_code == 0
    with open_trace(trace) as opened:
        scans = list(opened.scans())
    assert [each.outputs(1)[7] for each in scans] == seen
    assert [each.outputs(1)[6] for each in scans] == [each + 1 for each in seen]
    assert {each.inputs(1)[6] for each in scans} == {0}
    for words in (
        (
            "replay",
            "--into",
            "session",
        ),
        ("replay", "--into", "module"),
        ("replay", "--into", "program"),
    ):
        result = scanrack(words[0], trace, *words[1:])
        assert result.exit_code == 0, (words, result.output)


def test_an_input_force_reaches_the_program_at_once(folder):
    rack = folder / "line.toml"
    rack.write_text(RACK.format(controller="compactlogix"), encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan()
        bench.force("I:1.6", 40)
        bench.scan()
        assert bench["Local:1:O.Data[7]"] == 40


def test_why_names_the_rung_that_wrote_an_input(folder):
    rack = folder / "line.toml"
    rack.write_text(RACK.format(controller="micrologix"), encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan(3)
        assert "Main rung " in bench.why("Local:1:I.Data[5].3")
        assert "slot 1: it waits for a configuration" in bench.why("Local:1:I.Data[0].0")


def test_without_a_rack_it_stays_for_good():
    program = parse_program(PROGRAM)
    debugger = Debugger(parse_program(PROGRAM))
    for _ in range(3):
        program.step()
        debugger.scan()
    assert program.tags["Local:1:I.Data[6]"] == debugger.tags["Local:1:I.Data[6]"] == 3
