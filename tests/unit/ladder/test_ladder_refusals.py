"""What a program is refused for, with the rung and a remedy."""

import pytest
from ladder_bench import program_of
from scanrack.ladder import (
    BOOL,
    DINT,
    OTE,
    REAL,
    TIMER,
    TON,
    BuildError,
    LadderError,
    Program,
    RungTextError,
    parse_rung,
)
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering.python_rungs import make

TAGS = """TAG Run : BOOL
TAG Go : BOOL
TAG Level : REAL
TAG N : DINT
TAG D : INT[10]
TAG G : DINT[2,3]
TAG T : TIMER
TAG C : COUNTER
SLOT axis : 1"""


@pytest.mark.parametrize(
    ("rung", "text", "remedy"),
    [
        ("XIC(Rum)OTE(Run);", "no tag Rum", "did you mean Run"),
        ("XIC(Level)OTE(Run);", "Level is a REAL, a bit is needed", "compare the number"),
        ("XIC(N)OTE(Run);", "N is a DINT, a bit is needed", "tag.3"),
        ("XIC(Level.3)OTE(Run);", "Level is REAL and has no bits", "bit of an integer"),
        ("MOV(Run,N);", "Run is a BOOL, a number or a STRING is needed", "numeric tag"),
        ("MOV(1,5);", "5 is the number 5, a numeric tag or a STRING to write is needed", "numeric tag"),
        ("MOV(D[10],N);", "index 10 is outside D[10]", "0 to 9"),
        ("MOV(G[1],N);", "G has 2 dimensions, but the address has 1 subscripts", "one per dimension"),
        ("XIC(N.32)OTE(Run);", "N has no bit 32", "0 to 31"),
        ("TON(C,?,?);", "C is a COUNTER, a TIMER is needed", "declare the tag as TIMER"),
        ("XIC(T.XX)OTE(Run);", "TIMER has no member XX", "members are EN, TT, DN, PRE, ACC"),
        ("XIC(axis.status.MOVING)OTE(Run);", "not a bit of axis.status", "did you mean MOVING_CW"),
        ("XIC(Go);", "the rung has no output", "coil"),
        ("JMP(Nowhere);", "no label NOWHERE", "add LBL"),
        ("JSR(Nowhere,0);", "no routine NOWHERE", "routines are Main"),
        ("XIC(Go)LBL(Here)OTE(Run);", "LBL(HERE) is not first", "put it first"),
        ("MCR()OTE(Run);", "MCR is not last", "another rung"),
        ("AND(Level,1,N);", "Level is a REAL, an integer is needed", "DINT"),
        ("BTD(N,0,N,32,1);", "destination bit 32 is out of range", "0 to 31"),
        ("CMP(N+1)OTE(Run);", "a comparison is needed", "a>b"),
        ("TON(T,1.5,0);", "PRE 1.5 is not a whole number", "MOV to .PRE"),
        ("MOV(?,N);", "? is not a value", "write the tag"),
    ],
)
def test_operands_that_do_not_fit(rung, text, remedy):
    with pytest.raises(BuildError) as caught:
        program_of(TAGS, "NOP();", rung).build()
    message = str(caught.value)
    assert text in message
    assert remedy in message
    assert "routine Main, rung 1" in message


@pytest.mark.parametrize(
    ("rungs", "text", "allowed"),
    [
        (
            ("OTE(Run);", "XIC(Go)OTE(run);"),
            "run is written by a coil in line.rung:5: routine Main, rung 0",
            "repeated coils",
        ),
        (
            ("TON(T,?,?);", "XIC(Go)TON(T,?,?);"),
            "T is timed in line.rung:5: routine Main, rung 0",
            "repeated timers",
        ),
        (("ONS(Run)MOV(1,N);", "ONS(Run)MOV(2,N);"), "Run remembers a rung", "repeated coils"),
    ],
)
def test_written_twice_is_a_warning(rungs, text, allowed):
    body = "TAG Run : BOOL\nTAG Go : BOOL\nTAG T : TIMER\n"
    if "ONS" in rungs[0]:
        body = "TAG Run : BOOL\nTAG Go : BOOL\nTAG N : DINT\n"
    source = f"{body}ROUTINE Main\n{rungs[0]}\n{rungs[1]}\nEND\n"
    (warning,) = parse_program(f"PROGRAM line\n{source}", file="line.rung").warnings
    assert text in str(warning).replace(
        "line.rung:6: routine Main, rung 0", "line.rung:5: routine Main, rung 0"
    )
    assert rungs[1] in str(warning)
    assert not parse_program(f"PROGRAM line\nALLOW {allowed}\n{source}").warnings


def test_all_problems_are_told_at_once():
    with pytest.raises(BuildError) as caught:
        program_of(TAGS, "XIC(A)OTE(Run);", "XIC(Go)TON(N);").build()
    assert len(caught.value.problems) == 2


@pytest.mark.parametrize(
    ("text", "column", "expected", "found"),
    [
        ("XIC(Start", 10, ", or ) in XIC", "the end of the text"),
        ("XIC(Go)FOO(a)OTE(Run)", 8, "an instruction; FOO is unknown", "FOO"),
        ("XIC(Go)[XIC(Run)OTE(X)", 23, "an instruction, , or ] of the branch", "the end of the text"),
        ("XIC()OTE(Run)", 1, "1 operands of XIC", "0"),
        ("MOV(1,2,3)", 1, "2 operands of MOV", "3"),
        ("XIC(Data[1)OTE(X)", 11, "an operator or ] of the subscript", ")"),
        ("OTE(Run.)", 9, "a member or a bit after .", ")"),
        ("MOV(2#12,N)", 5, "digits of radix 2 after 2#", "2"),
        ("XIC(a) XIC b", 12, "( after XIC", "b"),
    ],
)
def test_errors_in_rung_text(text, column, expected, found):
    with pytest.raises(RungTextError) as caught:
        parse_rung(text, file="line.rung", line=7, rung=3)
    assert str(caught.value) == f"line.rung:7: rung 3, column {column}: expected {expected}, found {found}"


def test_the_line_is_counted_inside_of_a_rung():
    with pytest.raises(RungTextError, match=r"line.rung:9: rung 0, column 3: expected an instruction"):
        parse_rung("XIC(Go)\nOTE(\nX)]", file="line.rung", line=7)


def test_python_or_and_not_are_refused_with_a_remedy():
    program = Program("p")
    start, run = program.declare("Start Run", BOOL)
    with pytest.raises(LadderError, match=r"write \[a, b\] for parallel"):
        program.routine(lambda rung: rung(start or run, OTE(run)))


def test_the_file_and_line_of_a_rung_in_python():
    program = Program("p")
    level = program.declare("Level", REAL)
    run = program.declare("Run", BOOL)

    @program.routine
    def Main(rung):  # noqa: N802
        rung(level, OTE(run))

    line = Main.__code__.co_firstlineno + 2
    with pytest.raises(BuildError) as caught:
        program.step()
    assert f"test_ladder_refusals.py:{line}: routine Main, rung 0: XIC(Level): Level is a REAL" in str(
        caught.value
    )


def test_names_and_initial_values():
    program = Program("p")
    program.declare("Run", BOOL)
    with pytest.raises(LadderError, match="declared twice"):
        program.declare("RUN", DINT)
    with pytest.raises(LadderError, match="not a tag name"):
        program.declare("2nd", DINT)
    with pytest.raises(LadderError, match="dimensions"):
        program.declare("Cube", DINT, 2, 2, 2, 2)
    program.declare("Small", DINT, initial=2**31)
    program.add_routine(parse_program("PROGRAM q\nROUTINE Main\nNOP();\nEND\n").routines[0])
    with pytest.raises(BuildError, match="Small: 2147483648 is out of range"):
        program.build()


def test_two_presets_of_one_timer():
    program = Program("p", allow=["repeated timers"])
    timer = program.declare("T", TIMER)

    @program.routine
    def Main(rung):  # noqa: N802
        rung(TON(timer, 5, 0))
        rung(TON(timer, 6, 0))

    with pytest.raises(BuildError, match=r"T.PRE is 5 in another rung"):
        program.build()


def test_nothing_can_be_added_to_a_built_program():
    program = program_of("TAG Run : BOOL", "OTE(Run);")
    program.step()
    with pytest.raises(LadderError, match="has been built"):
        program.declare("More", BOOL)


BYTES = "TAG Small : SINT[3]\nTAG Lone : SINT\nTAG I : DINT\nSLOT axis : 1"


@pytest.mark.parametrize(
    ("rung", "may"),
    [
        ("COP(Lone,axis.O.Data[0],1);", False),  # 1 byte of 2
        ("COP(Small[0],axis.O.Data[0],1);", True),  # 2 of 2
        ("COP(Small[0],axis.O.Data[0],2);", False),  # 3 of 4
        ("CPS(Small[1],axis.O.Data[0],8);", True),  # 2 of 16: the first word whole, the rest as it was
        ("COP(Small[0],axis.O.Data[7],5);", True),  # the image ends after 2 bytes
        ("COP(Small[0],axis.O.Data[0],I);", False),  # 3 bytes if I is 2
        ("COP(Small[I],axis.O.Data[0],1);", False),  # 1 byte if I is 2
        ("COP(I,axis.O.Data[0],8);", True),  # 4 of 16
    ],
)
def test_no_copy_ends_in_the_middle_of_a_command_word(rung, may):
    program = program_of(BYTES, rung)
    if may:
        program.build()
        return
    with pytest.raises(BuildError, match="half of a new and half of an old command"):
        program.build()


@pytest.mark.parametrize(
    "text",
    ["CPT(N,(O:1.5)/3);", "CPT(N,(N+I:1.0)/D[2]);", "CPT(N,O:1.5/3);", "CPT(N,N/O:1.5);", "CPT(N,N/3);"],
)
def test_a_slash_behind_a_data_file_means_a_bit_unless_it_divides(text):
    assert str(parse_rung(text)) == text


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: make("MOV", 1), "MOV: 1 operands; must be 2"),
        (lambda: make("MOV", 1, "N", 2), "MOV: 3 operands; must be 2"),
        (lambda: make("XIC"), "XIC: 0 operands; must be 1"),
        (lambda: make("MOV", True, "N"), "True is not an operand"),
        (lambda: make("MOV", None, "N"), "None is not an operand"),
        (lambda: make("MVO", 1, "N"), "no instruction MVO"),
    ],
)
def test_instructions_made_in_python_are_refused_like_those_of_text(made, said):
    with pytest.raises(LadderError, match=said):
        made()
