"""FBC, DDT, DTR, TOD, FRD, serial port and phases [1756-RM003N]; both back ends."""

import pytest
from ladder_bench import both
from scanrack.ladder import BuildError
from scanrack.ladder.files import parse_program

FILES = """TAG Go : BOOL
TAG Source : DINT[2] := [5, 1]
TAG Ref : DINT[2]
TAG Found : DINT[3]
TAG Cmp : CONTROL := {"LEN": 40}
TAG Res : CONTROL := {"LEN": 3}
"""


def run(tags, *rungs, scans):
    """Return an engine after scans with these values of Go; the back ends must agree."""
    engines = both(tags, *rungs)
    for go in scans:
        for engine in engines:
            engine.tags.Go = go
            engine.step()
    first, second = (engine.memory.snapshot() for engine in engines)
    assert first == second
    return engines[0].tags


RUNG = "XIC(Go){0}(Source[0],Ref[0],Found[0],Cmp,?,?,Res,?,?);"


def test_fbc_finds_all_mismatches_at_once():
    """Bits 0, 2 and 32 of 5 and 1 differ from zeros; the search is over at LEN."""
    tags = run(FILES, RUNG.format("FBC"), scans=[1])
    assert tags.Found == [0, 2, 32]
    assert (tags["Cmp.FD"], tags["Cmp.DN"], tags["Cmp.POS"], tags["Res.POS"]) == (True, True, 40, 3)
    assert tags.Ref == [0, 0]


def test_fbc_with_in_stops_at_each_mismatch():
    tags = run(FILES.replace('"LEN": 40', '"LEN": 40, "IN": true'), RUNG.format("FBC"), scans=[1, 0, 1])
    assert (tags.Found, tags["Cmp.POS"], tags["Cmp.DN"]) == ([0, 2, 0], 3, False)


def test_a_search_that_is_done_begins_again_behind_a_false_rung():
    tags = run(FILES, RUNG.format("FBC"), scans=[1, 0])
    assert (tags["Cmp.POS"], tags["Cmp.DN"], tags["Cmp.EN"], tags["Cmp.FD"]) == (0, False, False, False)


def test_ddt_makes_the_reference_the_source():
    tags = run(FILES, RUNG.format("DDT"), scans=[1])
    assert (tags.Found, tags.Ref) == ([0, 2, 32], [5, 1])
    tags = run(FILES, RUNG.format("DDT"), scans=[1, 0, 1])
    assert (tags["Cmp.FD"], tags["Cmp.DN"]) == (False, True)


def test_no_length_is_an_error():
    assert run(FILES.replace('"LEN": 40', '"LEN": 0'), RUNG.format("FBC"), scans=[1])["Cmp.ER"] is True


def test_dtr_is_true_for_the_scan_of_a_change():
    """The manual's example: 16#1 changes under the mask 16#FFF, the digit above it does not count."""
    tags = "TAG Go : BOOL\nTAG Source : DINT\nTAG Ref : DINT\nTAG Out : BOOL\n"
    for engine in both(tags, "DTR(Source,16#0FFF,Ref)OTE(Out);"):
        seen = []
        for value in (0x183, 0x183, 0x187, 0xF187, 0x187):
            engine.tags.Source = value
            engine.step()
            seen.append(engine.tags.Out)
        # prescan takes the reference from the tag as it is at power-up, 0 before the first value
        assert seen[1:] == [False, True, False, False]
        assert engine.tags.Ref == 0x187


@pytest.mark.parametrize(("value", "digits"), [(1254, 0x1254), (0, 0), (99_999_999, 0x9999_9999 - (1 << 32))])
def test_tod_writes_a_digit_per_four_bits_and_frd_reads_them(value, digits):
    tags = "TAG Go : BOOL\nTAG A : DINT\nTAG B : DINT\nTAG C : DINT\n"
    for engine in both(tags, "TOD(A,B)FRD(B,C);"):
        engine.tags.A = value
        engine.step()
        assert (engine.tags.B, engine.tags.C, engine.minor_faults) == (digits, value, ())


@pytest.mark.parametrize("value", [-1, 100_000_000])
def test_tod_of_what_does_not_fit_is_a_minor_fault(value):
    for engine in both("TAG A : DINT\nTAG B : DINT\n", "TOD(A,B);"):
        engine.tags.A = value
        engine.step()
        assert [(each.type, each.code) for each in engine.minor_faults] == [(4, 4)]


def test_the_serial_port_is_in_system_mode():
    tags = "TAG Go : BOOL\nTAG C : SERIAL_PORT_CONTROL\nTAG S : STRING\nTAG N : DINT\n"
    for rung in ("ARL(0,S,C,82,?);", "AWT(0,S,C,?,?);", "ABL(0,C,N);", "ACB(0,C,?);", "AHL(0,0,1,C,?);"):
        seen = run(tags, f"XIC(Go){rung}", scans=[1])
        assert (seen["C.EN"], seen["C.ER"], seen["C.DN"], seen["C.ERROR"]) == (True, True, False, 4)


@pytest.mark.parametrize("words", ["Yes,Yes", "No,Yes", "Yes,No", "1,0"])
def test_acl_says_in_words_which_buffers_it_clears(words):
    """As exports have it; it has no control, so nothing says that the port is in system mode."""
    assert run("TAG Go : BOOL\nTAG N : DINT\n", f"XIC(Go)[ACL(0,{words}),MOV(7,N)];", scans=[1]).N == 7


def test_acl_takes_its_words_in_structured_text_and_refuses_a_name_that_is_neither():
    head = "PROGRAM bench\nTAG N : DINT\nROUTINE Main ST\n"
    program = parse_program(f"{head}ACL(0,Yes,No); N := 7;\nEND\n")
    for engine in (program.compile(), program.interpret()):
        engine.step()
        assert engine.tags.N == 7
    with pytest.raises(BuildError, match="Maybe is neither a tag nor a word of a list"):
        parse_program(f"{head}ACL(0,Maybe,No);\nEND\n").compile()


def test_a_phase_is_not_scheduled():
    tags = "TAG Go : BOOL\nTAG R : DINT\n"
    assert run(tags, "PATT(Fill,R);", scans=[1]).R == 24594
    assert run(tags, "PCMD(Fill,Start,R);", "PSC();", scans=[1]).R == 24594
    assert run(tags, "POVR(Fill,Abort,0);", scans=[1]).R == 0


def test_a_button_of_a_panel_passes_the_rung():
    for engine in both("TAG Go : BOOL\nTAG B : HMIBC\nTAG Out : BOOL\n", "XIC(Go)HMIBC(B,0)OTE(Out);"):
        engine.tags.Go = True
        engine.step()
        assert engine.tags.Out is False
        engine.tags["B.ButtonState"] = True
        engine.step()
        assert (engine.tags.Out, engine.tags["B.EnableOut"]) == (True, True)


def test_iot_and_the_interrupt_instructions_are_read():
    assert run("TAG Go : BOOL\nTAG N : DINT\n", "UID()IOT(N)UIE();", "XIC(Go)UID;", scans=[1]).N == 0


ATTRIBUTES = """TAG Now : DINT[7]
TAG Then : DINT[7] := [2026, 11, 22, 3, 0, 0, 0]
TAG Status : INT
TAG Watchdog : DINT
TAG Ax : AXIS_CIP_DRIVE
TAG Limit : REAL := 1.5
TAG Set : BOOL
"""


def test_attributes_of_modules_clock_tasks_and_axes():
    rungs = (
        "GSV(Module,Rack_1,EntryStatus,Status);",
        "XIC(Set)SSV(WallClockTime,,DateTime,Then[0])SSV(Task,MainTask,Watchdog,Then[0]);",
        "GSV(WallClockTime,,LocalDateTime,Now[0])GSV(Task,MainTask,Watchdog,Watchdog);",
        "SSV(Axis,Ax,TorqueLimitPositive,Limit);",
    )
    for engine in both(ATTRIBUTES, *rungs):
        engine.step()
        assert engine.tags.Status == 0x4000
        assert engine.tags.Now == [1970, 1, 1, 0, 0, 0, 0]
        assert engine.tags.Watchdog == 500_000
        assert engine.tags["Ax.TorqueLimitPositive"] == 1.5
        engine.tags.Set = True
        engine.step()
        engine.tags.Set = False
        engine.step(1500)
        assert engine.tags.Now == [2026, 11, 22, 3, 0, 1, 500_000]
        assert engine.tags.Watchdog == 2026


def test_attributes_of_the_controller_log_and_of_a_coordinate_system():
    """DINT with GSV and SSV [1756-RM003N], REAL with GSV and SSV [MOTION-UM002]."""
    tags = """TAG Two : COORDINATE_SYSTEM
TAG Count : DINT := 5
TAG Unsaved : DINT := 3
TAG Set : REAL := 0.25
TAG Got : REAL[2]
"""
    rungs = (
        "GSV(Controller,,ControllerLogUnsavedEntryCount,Count);",
        "SSV(Controller,,ControllerLogUnsavedEntryCount,Unsaved);",
        "GSV(CoordinateSystem,Two,CommandPositionTolerance,Got[0]);",
        "SSV(CoordinateSystem,Two,CommandPositionTolerance,Set);",
        "SSV(CoordinateSystem,Two,ActualPositionTolerance,Set);",
        "GSV(CoordinateSystem,Two,ActualPositionTolerance,Got[1]);",
    )
    for engine in both(tags, *rungs):
        engine.step()
        assert (engine.tags.Count, engine.tags.Got) == (0, [0.0, 0.25])
        engine.step()
        assert (engine.tags.Count, engine.tags.Got) == (3, [0.25, 0.25])
