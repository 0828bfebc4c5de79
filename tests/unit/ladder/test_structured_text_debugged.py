"""Structured text under the debugger: why and cross reference by line, breakpoints, pictures."""

import pytest
from scanrack.jobs import build_cpu, build_rack, load_job
from scanrack.ladder import LadderError, LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.crossref import cross_reference
from scanrack.ladder.draw import routines_svg
from scanrack.ladder.files import parse_structured

TEXT = """TAG Auto : BOOL
TAG Start : BOOL
TAG Run : BOOL
TAG N : DINT
TAG Sum : DINT
TAG D : DINT[4]
TAG I : DINT

IF Auto THEN
    // the motor
    Run := Start OR Run;
ELSE
    Run := 0;
END_IF;
CASE N OF
    1, 2:
        FOR I := 0 TO 3 DO
            D[I] := N + I;
        END_FOR;
ELSE
    Sum := Sum - 1;
END_CASE;
"""


@pytest.fixture
def debugger():
    return Debugger(parse_structured(TEXT, "line"))


def test_why_names_the_statement_what_it_read_and_what_it_stands_in(debugger):
    debugger.scan(2)
    debugger.tags.Auto = debugger.tags.Start = True
    debugger.scan(2)
    assert debugger.why("Run") == (
        "Run is 1 since scan 2 (0.02 s): Run := Start OR Run; in routine Main, line 11, "
        "with Start = 1, Run = 0\n"
        "  inside of IF Auto THEN in line 9 [Auto = 1]"
    )
    debugger.tags.N = 2
    debugger.scan()
    assert debugger.why("D[1]") == (
        "D[1] is 3 since scan 4 (0.04 s): D[I] := N+I; in routine Main, line 18, with N = 2, I = 1\n"
        "  inside of FOR I := 0 TO 3 DO in line 17 [I = 1]\n"
        "  inside of CASE N OF in line 15 [N = 2]"
    )
    assert debugger.why("Start").startswith("Start is 1 since scan 2")


def test_a_tag_that_never_changed_lists_the_lines_that_write_it(debugger):
    debugger.scan()
    assert debugger.why("I") == (
        "I is 0 and has not changed while watched. Its writers:\n"
        "    Main, line 17: FOR I := 0 TO 3 DO writes I"
    )


def test_the_cross_reference_names_lines():
    found = cross_reference(parse_structured(TEXT, "line").build())
    assert [str(each) for each in found.of("Run")] == [
        "Main, line 11: Run := Start OR Run; writes Run",
        "Main, line 11: Run := Start OR Run; reads Run",
        "Main, line 13: Run := 0; writes Run",
    ]
    assert [f"{each.site.place} {each.way}" for each in found.of("I")] == [
        "line 17 writes",
        "line 17 reads",
        "line 18 reads",
    ]


def test_a_breakpoint_on_a_line_is_met_when_it_begins_to_run(debugger):
    debugger.break_at("Main", 11)
    assert debugger.scan(3) == ()
    debugger.tags.Auto = True
    (stop,) = debugger.scan()
    assert stop.text == "Main, line 11 runs: Run := Start OR Run;"
    assert debugger.scan(3) == ()
    with pytest.raises(LadderError, match=r"routine Main has no line 10; must be 9, 11, 13, 15, 17, 18, 21"):
        debugger.break_at("Main", 10)


def test_the_picture_shows_what_ran(debugger):
    debugger.tags.Auto = True
    debugger.scan()
    assert debugger.picture("Main") == (
        "   9 ┃ IF Auto THEN\n"
        "     │     // the motor\n"
        "  11 ┃     Run := Start OR Run;\n"
        "     │ ELSE\n"
        "  13 │     Run := 0;\n"
        "     │ END_IF;\n"
        "  15 ┃ CASE N OF\n"
        "     │     1, 2:\n"
        "  17 │         FOR I := 0 TO 3 DO\n"
        "  18 │             D[I] := N+I;\n"
        "     │         END_FOR;\n"
        "     │ ELSE\n"
        "  21 ┃     Sum := Sum-1;\n"
        "     │ END_CASE;\n"
    )
    assert debugger.picture("Main", [11]) == "  11 ┃     Run := Start OR Run;\n"
    assert '<text class="live"' in debugger.svg()
    routine = debugger.program.routines[0]
    assert "Run := Start OR Run;" in routines_svg([(routine, [11])])


def test_forces_hold_against_statements(debugger):
    debugger.force("Run", True)
    debugger.scan(2)
    assert debugger.tags.Run is True
    debugger.unforce()
    debugger.scan()
    assert debugger.tags.Run is False


PULSES = """// a pulse every 100 ms
SLOT axis : 1
TAG Pause : FBD_TIMER := {"PRE": 100}
TAG Pulses : DINT

Pause.TimerEnable := NOT Pause.DN;
TONR(Pause);
axis.command.RESET_ERRORS := Pause.DN;
IF Pause.DN THEN
    Pulses := Pulses + 1;
END_IF;
"""

RACK = """program = "line.st"
scan_ms = 2

[[slot]]
number = 1
module = "amci3601"
"""


def test_a_rack_runs_a_file_of_structured_text(tmp_path):
    (tmp_path / "line.st").write_text(PULSES, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    job = load_job(str(tmp_path / "line.toml"))
    rack = build_rack(job.spec)
    with build_cpu(job.spec, job.logic, rack) as cpu:
        cpu.run(501)
    # done in scan 50, off in 51, timing from 52: one pulse per 52 scans
    assert isinstance(job.logic, LadderLogic)
    assert job.logic.tags.Pulses == 9
