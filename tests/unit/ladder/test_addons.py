"""Add-on instructions: what goes in and out, which routine runs, and what is refused [1756-PM010]."""

import pytest
from ladder_bench import Named
from scanrack.ladder import BOOL, DINT, OTE, BuildError, LadderError, Program, RungTextError, Structure
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.files.rungfile import instruction_text
from scanrack.ladder.files.rungreader import Reader, load_library

COUNTING = """\
INSTRUCTION Counting  // counts what its routines do
INPUT Step : DINT REQUIRED
INPUT Quick : BOOL REQUIRED
INPUT Extra : DINT
OUTPUT Total : DINT REQUIRED
OUTPUT Odd : BOOL
INOUT Log : DINT
LOCAL Timer : TIMER
ROUTINE Logic
ADD(Total,Step,Total)ADD(Total,Extra,Total);
XIC(Total.0)OTE(Odd);
XIC(Quick)ADD(Log,1,Log);
TON(Timer,20,0)XIO(Timer.DN)OTU(EnableOut);
END
ROUTINE EnableInFalse
// of the caller's tag
ADD(Log,100,Log);
END
ROUTINE Prescan
MOV(7,Total);
END
END INSTRUCTION
"""

TAGS = """\
TAG Run : BOOL
TAG Lamp : BOOL
TAG N : DINT := 2
TAG Result : DINT
TAG Noted : DINT[3]
TAG Count : Counting
"""


def engines(rung, tags=TAGS, definition=COUNTING):
    program = parse_program(f"PROGRAM p\n{definition}{tags}ROUTINE Main\n{rung}\nEND\n")
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


USUAL = "XIC(Run)Counting(Count,N*2,1,Result,Noted[1])OTE(Lamp);"


@pytest.mark.parametrize("engine", engines(USUAL), ids=str)
def test_what_a_call_does_scan_by_scan(engine):
    """Prescan leaves 7. N*2 = 4 is copied in on a false rung, too; Extra keeps what somebody wrote."""
    tags = engine.tags
    engine.step()
    assert (tags["Count.Step"], tags["Count.Total"], tags.Result) == (4, 7, 7)
    assert (tags["Noted[1]"], tags["Count.EnableIn"], tags.Lamp) == (100, False, False)
    tags.Run, tags["Count.Extra"] = True, 10
    engine.step()
    assert (tags.Result, tags["Count.Odd"], tags["Noted[1]"]) == (21, True, 101)
    assert (tags["Count.EnableIn"], tags["Count.EnableOut"], tags.Lamp) == (True, False, False)
    engine.step(20)
    assert (tags.Result, tags.Lamp) == (35, True)  # the timer is done: EnableOut follows the rung


MODES = """\
INSTRUCTION Modes
INPUT A : DINT REQUIRED
INPUT Extra : DINT
OUTPUT Z : DINT REQUIRED
LOCAL Bit : BOOL
ROUTINE Logic
ADD(A,10,Z);
AFI()OTE(Bit);
END
{}END INSTRUCTION
"""
OTHERWISE = "ROUTINE EnableInFalse\nADD(A,20,Z);\nEND\n"
PRESCAN = "ROUTINE Prescan\nADD(A,30,Z);\nEND\n"
CALL_MODES = "XIC(Run)Modes(M,N,Result)OTE(Lamp);"
MODE_TAGS = "TAG Run : BOOL\nTAG Lamp : BOOL\nTAG N : DINT := 2\nTAG Result : DINT := 5\nTAG M : Modes\n"


def modes(*routines, call=CALL_MODES, tags=MODE_TAGS):
    return engines(call, tags, MODES.format("".join(routines)))


def test_a_false_rung_without_enable_in_false_passes_inputs_and_writes_no_output():
    """What somebody writes to the argument of an output stays, until the rung is true [1756-PM010]."""
    for engine in modes():
        engine.step()
        engine.tags.Result, engine.tags["M.Z"], engine.tags.N = 77, 8, 3
        engine.step()
        assert (engine.tags["M.A"], engine.tags.Result, engine.tags["M.Z"]) == (3, 77, 8), engine
        assert (engine.tags["M.EnableIn"], engine.tags["M.EnableOut"], engine.tags.Lamp) == (0, 0, 0)
        engine.tags.Run = True
        engine.step()
        assert (engine.tags.Result, engine.tags.Lamp) == (13, True), engine


def test_enable_in_false_runs_on_a_false_rung_and_its_outputs_are_written():
    for engine in modes(OTHERWISE):
        engine.step()
        engine.tags.Result = 77
        engine.step()
        assert (engine.tags.Result, engine.tags.Lamp) == (22, False), engine


def test_prescan_passes_inputs_prescans_logic_runs_prescan_and_passes_outputs():
    """2 goes in, Prescan adds 30, 32 comes out; a coil of Logic is cleared, and nothing of Logic runs."""
    for engine in modes(PRESCAN):
        engine.tags["M.Bit"] = True
        engine.interpreter.prescan()
        assert (engine.tags["M.A"], engine.tags.Result, engine.tags["M.Bit"]) == (2, 32, False), engine
    for engine in modes():
        engine.tags["M.Z"] = 6
        engine.interpreter.prescan()
        assert (engine.tags["M.A"], engine.tags.Result) == (2, 6), engine


def test_prescan_leaves_an_argument_whose_subscript_is_not_current_yet():
    tags = MODE_TAGS + "TAG At : DINT := 9\nTAG List : DINT[3]\n"
    for engine in modes(call="Modes(M,List[At],Result);", tags=tags):
        engine.interpreter.prescan()
        assert engine.tags["M.A"] == 0, engine


def test_the_debugger_tells_which_call_changed_a_tag_in_prescan():
    program = parse_program(f"PROGRAM p\n{MODES.format(PRESCAN)}{MODE_TAGS}ROUTINE Main\n{CALL_MODES}\nEND\n")
    debugger = Debugger(program)
    debugger.scan()
    assert debugger.why("Result").startswith("Result is 32 since scan 0 (0 s): prescan of")


def test_a_constant_bit_and_a_bit_of_the_caller():
    for operand, noted in (("0", 0), ("1", 1), ("N.1", 1), ("N.0", 0)):
        for engine in engines(f"Counting(Count,1,{operand},Result,Noted[0]);"):
            engine.step()
            assert engine.tags["Noted[0]"] == noted


def test_text_to_definition_to_text():
    program = parse_program(f"PROGRAM p\n{COUNTING}{TAGS}ROUTINE Main\n{USUAL}\nEND\n")
    text = program_text(program)
    assert program_text(parse_program(text)) == text
    assert instruction_text(program.add_ons["COUNTING"]) == COUNTING


HALT = """\
PROGRAM p
USE axis3601
TAG A : AXIS_3601
TAG H : MC_Halt
TAG Go : BOOL
ROUTINE Main
MC_Halt(H,A,Go);
END
"""


def test_a_library_is_used_by_name():
    text = program_text(parse_program(HALT))
    assert "USE axis3601" in text
    assert "INSTRUCTION" not in text
    assert program_text(parse_program(text)) == text


def test_every_block_of_the_library_reads_as_it_prints():
    library = load_library("axis3601")
    text = "LIBRARY axis3601\n" + "".join(
        f"TYPE {kind.name} ({', '.join(_member(each) for each in kind.members)})\n"
        for kind in library.types.values()
        if isinstance(kind, Structure) and kind.name.upper() not in library.add_ons
    )
    text += "".join(map(instruction_text, library.add_ons.values()))
    assert Reader(text, "").library().add_ons == library.add_ons


def _member(member):
    dims = f"[{','.join(map(str, member.dims))}]" if member.dims else ""
    return f"{member.name} : {member.type.name}{dims}"


def test_an_add_on_inside_another():
    outer = COUNTING + (
        "INSTRUCTION Outer\nINPUT By : DINT REQUIRED\nINOUT Log : DINT\nLOCAL Inner : Counting\n"
        "OUTPUT Sum : DINT\nROUTINE Logic\nCounting(Inner,By,1,Sum,Log);\nEND\nEND INSTRUCTION\n"
    )
    for engine in engines("Outer(Both,5,N);", "TAG N : DINT\nTAG Both : Outer\n", outer):
        engine.step()
        assert (engine.tags["Both.Sum"], engine.tags.N) == (12, 1)  # 7 of Prescan and 5


def test_in_python_it_is_called_like_any_instruction():
    program = Program("p")
    counting = parse_program(f"PROGRAM q\n{COUNTING}ROUTINE Main\nNOP();\nEND\n").add_ons["COUNTING"]
    count = program.declare("Count", counting)
    run, lamp = program.declare("Run Lamp", BOOL)
    log, total = program.declare("Log Total", DINT)

    @program.routine
    def Main(rung):  # noqa: N802
        rung(run, counting(count, 3, run, total, log), OTE(lamp))

    assert program.text("Main") == "XIC(Run)Counting(Count,3,Run,Total,Log)OTE(Lamp);"
    program.tags.Run = True
    program.step()
    assert program.tags.Total == 10
    message = r"Counting needs an instance and 4 operands \(Step, Quick, Total, Log\); the call has 1"
    with pytest.raises(LadderError, match=message):
        counting(count, 3)


@pytest.mark.parametrize(
    ("rung", "message"),
    [
        ("Counting(N,1,1,Result,Noted[0]);", "N is a DINT, an instance of Counting is needed"),
        ("Counting(Count,1,1,5,Noted[0]);", "Total of Counting needs a tag, not 5"),
        ("Counting(Count,1,2,Result,Noted[0]);", "Quick needs a bit, 0 or 1, not 2"),
        ("Counting(Count,1,N,Result,Noted[0]);", "XIC(N): N is a DINT, a bit is needed"),
        ("Counting(Count,1,1,Result,Noted[3]);", "index 3 is outside"),
        ("Counting(Count,1,1,Result,Lamp);", "Log of Counting is a DINT, Lamp is a BOOL; pass a tag"),
        ("Counting(Count,1,1,Result,S:FS);", "Log of Counting is a DINT, S:FS is a BOOL"),
        ("Counting(Nobody,1,1,Result,Noted[0]);", "no tag Nobody"),
    ],
)
def test_mistakes_in_calls(rung, message):
    with pytest.raises(BuildError) as refused:
        engines(rung)
    assert message in str(refused.value)


LOGIC = "ROUTINE Logic\n{}END\n"


@pytest.mark.parametrize(
    ("name", "body", "message"),
    [
        ("A", LOGIC.format("XIC(Other)OTE(Other);\n"), "no parameter or local tag Other"),
        ("A", LOGIC.format("JSR(Main,0);\n"), "JSR is not allowed in an add-on instruction"),
        ("A", "INPUT B : DINT\n", "add-on A has no routine Logic"),
        ("A", f"INPUT B : DINT\nLOCAL b : DINT\n{LOGIC.format('')}", "b is declared twice"),
        ("ADD", LOGIC.format(""), "ADD is a built-in instruction"),
    ],
)
def test_mistakes_in_definitions(name, body, message):
    text = f"PROGRAM p\nINSTRUCTION {name}\n{body}END INSTRUCTION\nROUTINE Main\nNOP();\nEND\n"
    with pytest.raises(LadderError) as refused:
        parse_program(text, file="f.rung")
    assert message in str(refused.value)
    assert "f.rung:2" in str(refused.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "INSTRUCTION A\nINPUT B\n",
            "f.rung:3: column 1: expected INPUT, OUTPUT, INOUT or LOCAL name : TYPE",
        ),
        (
            "INSTRUCTION A\nROUTINE Other\nEND\n",
            "f.rung:3: column 1: expected one of the routines Logic, EnableInFalse",
        ),
        ("INSTRUCTION A\nROUTINE Logic\nEND\n", "expected END INSTRUCTION"),
        ("USE nothing\n", "f.rung:2: column 1: expected a library (axis3601), found nothing"),
    ],
)
def test_errors_in_the_text_of_definitions(text, expected):
    with pytest.raises(RungTextError) as refused:
        parse_program(f"PROGRAM p\n{text}", file="f.rung")
    assert expected in str(refused.value)


def test_an_slc_program_has_its_own_instructions_after_an_add_on():
    twice = "INSTRUCTION Twice\nINPUT A : INT REQUIRED\nOUTPUT B : INT\nROUTINE Logic\nADD(A,A,B);\nEND\n"
    rung = "DDV(N7:0,N7:1)Twice(Two,N7:1)MOV(Two.B,N7:2);"
    text = f"PROGRAM p\nDIALECT slc\n{twice}END INSTRUCTION\nTAG N7 : INT[3]\nTAG Two : Twice\n"
    program = parse_program(f"{text}ROUTINE Main\n{rung}\nEND\n")
    program.build()
    assert program.text("Main") == rung
