"""Motion instructions as exports print them: read with their operands, printed again, refused where wrong."""

import pytest
from ladder_bench import both
from scanrack.ladder import BuildError, RungTextError
from scanrack.ladder.files import parse_program, program_text

TAGS = """TAG Go : BOOL
TAG Ax : AXIS_CIP_DRIVE
TAG Master : AXIS_VIRTUAL
TAG Axes : AXIS_SERVO[2]
TAG M : MOTION_INSTRUCTION
TAG G : MOTION_GROUP
TAG C : COORDINATE_SYSTEM
TAG P : REAL[6]
TAG Speed : REAL
TAG Cam : CAM[4]
TAG Profile : CAM_PROFILE[5]
"""

RATES = "Units per sec,100,Units per sec2,100,Units per sec2,S-Curve,100,100,% of Time"
RUNGS = [
    # the operands of each, MOTION-RM002: 2 of MSO, 20 of MAM, 17 of MAJ and MCD, 9 of MAS, 5 of MRP
    "MSO(Ax,M);",
    "MAFR(Axes[1],M);",
    f"MAM(Ax,M,0,P[1],Speed,{RATES},Disabled,Programmed,0,None,0,0);",
    "MAM(Ax,M,1,10.5,50,% of Maximum,5,% of Maximum,5,% of Maximum,0,100,100,0,1,Current,0,None,P[0],P[1]);",
    f"MAJ(Ax,M,1,Speed,{RATES},Disabled,Programmed,0,Immediate Forward Only);",
    "MAS(Ax,M,Jog,Yes,100,Units per sec2,No,100,% of Time);",
    "MAS(Ax,M,0,0,100,0,0,100,0);",
    "MAH(Ax,M);",
    "MRP(Ax,M,Absolute,Actual,Speed);",
    "MCD(Ax,M,Move,Yes,Speed,Yes,100,Yes,100,No,0,No,0,Units per sec,Units per sec2,Units per sec2,"
    "Units per sec3);",
    "MAG(Ax,Master,M,0,1,1,1,Actual,Real,Enabled,50,% of Maximum);",
    "MAPC(Ax,Master,M,0,Profile[0],1,1,Once,Immediate,0,0,Command,Bi-directional);",
    "MATC(Ax,M,0,Profile[0],1,1,Continuous,Immediate);",
    "MCCP(M,Cam[0],4,0,0,Profile[0]);",
    "MAR(Ax,M,Positive_Edge,Disabled,0,0,1);",
    "MDR(Ax,M);",
    "MAW(Ax,M,Forward,Speed);",
    "MGS(G,M,Fast Stop);",
    f"MCLM(C,M,0,P[0],Speed,{RATES},0,Disabled,Programmed,0,0,None,0,0);",
    f"MCCM(C,M,0,P[0],1,P[3],CW,Speed,{RATES},0,Disabled,Programmed);",
    "MCS(C,M,Coordinated Move,Yes,100,Units per sec2,Yes,100,% of Time);",
]


@pytest.mark.parametrize("rung", RUNGS, ids=lambda rung: rung.split("(")[0])
def test_an_exported_rung_is_read_printed_and_run(rung):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\nXIC(Go){rung}\nEND\n")
    (routine,) = program.routines
    assert str(routine.rungs[0]) == f"XIC(Go){rung}"
    assert parse_program(program_text(program)).routines == program.routines
    for engine in (program.compile(), program.interpret()):
        engine.tags.Go = True
        engine.step()
        assert engine.tags["M.EN"] is True
        assert engine.tags["M.DN"] is not engine.tags["M.ER"]


def test_an_ideal_axis_is_named_among_the_stubs():
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\nXIC(Go)MSO(Ax,M);\nEND\n")
    assert (program.warnings, program.stubs_in_use) == (
        (),
        ("ideal axes = Ax, Master, Axes[0], Axes[1], C",),
    )


def test_what_an_ideal_axis_cannot_do_is_warned_of():
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\nXIC(Go)MDF(Ax,M);\nEND\n")
    (warning,) = program.warnings
    assert "an ideal axis can't do MDF: it ends with ER, and ERR 25" in str(warning)


def test_en_falls_with_the_rung_and_rises_again():
    """MOTION-RM002, MSO, "Rung-condition-in is false": EN is cleared if DN or ER is set."""
    seen = []
    for engine in both(TAGS, "XIC(Go)MDF(Ax,M);"):
        for go in (0, 1, 1, 0, 1):
            engine.tags.Go = go
            engine.step()
            seen.append((int(engine.tags["M.EN"]), int(engine.tags["M.ER"])))
    assert seen == [(0, 0), (1, 1), (1, 1), (0, 1), (1, 1)] * 2


def test_the_bits_lie_in_flags():
    """EN is bit 31, ER bit 28 of FLAGS."""
    for engine in both(TAGS, "XIC(Go)MDF(Ax,M);"):
        engine.tags.Go = True
        engine.step()
        assert engine.tags["M.FLAGS"] & 0xFFFF_FFFF == 1 << 31 | 1 << 28


@pytest.mark.parametrize(
    ("rung", "says"),
    [
        ("MSO(Ax);", "2 operands of MSO"),
        ("MAM(Ax,M,0,1,1,Units per sec);", "16 to 20 operands of MAM"),
    ],
)
def test_another_number_of_operands_is_refused(rung, says):
    with pytest.raises(RungTextError, match=says):
        parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rung}\nEND\n")


@pytest.mark.parametrize(
    ("rung", "says"),
    [
        ("MSO(Speed,M);", "Speed is a REAL, an axis is needed"),
        ("MSO(Ax,Go);", "Go is a BOOL, a MOTION_INSTRUCTION is needed"),
        ("MAS(Ax,M,Jogg,Yes,1,0,0,1,0);", "Jogg is neither a tag nor a word of a list"),
        ("MGS(Ax,M,Programmed);", "Ax is a AXIS_CIP_DRIVE, a MOTION_GROUP is needed"),
    ],
)
def test_operands_of_another_type_are_refused(rung, says):
    with pytest.raises(BuildError, match=says):
        parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rung}\nEND\n").build()


def test_structured_text_writes_words_without_spaces():
    """MOTION-RM002, structured text: each call is a new execution."""
    jog = "MAJ(Ax,M,Forward,5,%ofmaximum,5,Unitspersec2,5,0,SCurve,1,1,%oftime,Disabled,Programmed,0,None);"
    text = f"PROGRAM p\n{TAGS}ROUTINE Main ST\nMAS(Ax,M,All,Yes,100,Unitspersec2,No,100,0);\n{jog}\nEND\n"
    for engine in (parse_program(text).compile(), parse_program(text).interpret()):
        engine.step()
        engine.tags["M.ER"] = False
        engine.step()
        assert engine.tags["M.ER"] is True
