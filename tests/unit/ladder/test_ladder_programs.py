"""Tags, front ends, program files, Python routines, and a program in a rack's scan."""

from types import SimpleNamespace

import pytest
from scanrack.io_images.image import Image
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder import (
    ADD,
    BOOL,
    COUNTER,
    CPT,
    CTU,
    DINT,
    INT,
    JSR,
    MOV,
    ONS,
    OTE,
    REAL,
    STRING,
    TIMER,
    TON,
    LadderFault,
    Member,
    Program,
    Structure,
)
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.files.rungfile import read_program, write_program
from scanrack.ladder.model.routine import Routine


def test_python_and_text_make_the_same_rungs():
    program = Program("p")
    start, stop, run, once = program.declare("Start Stop Run Once", BOOL)
    fill = program.declare("Fill", TIMER)
    parts = program.declare("Parts", COUNTER)
    total, index = program.declare("Total Index", DINT)
    data = program.declare("Data", INT, 10)

    @program.routine
    def Main(rung):  # noqa: N802
        rung([start, run], ~stop, OTE(run))
        rung(run, TON(fill, 5000, 0))
        rung([(fill.DN, ~stop), start], ONS(once), CTU(parts))
        rung(parts.ACC >= 10, MOV(parts.ACC, total), data[0] != total, OTE(data[index + 1].bit(3)))
        rung(total * 2 > index + 1, CPT(total, (total + index) / 2 - abs(index)))
        rung("XIC(Start)MOV(Local:1:I.Data[2],Total);")

    assert program.text("main").splitlines() == [
        "[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);",
        "XIC(Run)TON(Fill,5000,0);",
        "[XIC(Fill.DN)XIO(Stop),XIC(Start)]ONS(Once)CTU(Parts,?,?);",
        "GEQ(Parts.ACC,10)MOV(Parts.ACC,Total)NEQ(Data[0],Total)OTE(Data[Index+1].3);",
        "CMP(Total*2>Index+1)CPT(Total,(Total+Index)/2-ABS(Index));",
        "XIC(Start)MOV(Local:1:I.Data[2],Total);",
    ]
    program.build()


def test_a_seal_in():
    program = parse_program(
        "PROGRAM m\nTAG Start : BOOL\nTAG Stop : BOOL\nTAG Run : BOOL\n"
        "ROUTINE Main\n[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);\nEND\n"
    )
    seen = []
    for start, stop in ((0, 0), (1, 0), (0, 0), (0, 1), (0, 0)):
        program.tags.Start, program.tags["stop"] = start, stop
        program.step()
        seen.append(program.tags.RUN)
    assert seen == [False, True, True, False, False]


STEP = Structure("Step", (Member("Time", DINT), Member("On", BOOL), Member("Marks", INT, (2,))))


def test_tags_as_people_see_them():
    program = Program("p")
    program.declare("Recipe", STEP, 2, initial=[{"Time": 5}, {"Marks": [1, 2]}])
    program.declare("Grid", DINT, 2, 2)
    program.declare("Name", STRING, initial="Zürich")
    program.declare("Ratio", REAL)
    program.declare("N", DINT)
    program.alias("Second", "Recipe[1].Marks")
    program.add_routine(Routine("Main", ()))
    tags = program.tags
    assert tags.Recipe == [
        {"Time": 5, "On": False, "Marks": [0, 0]},
        {"Time": 0, "On": False, "Marks": [1, 2]},
    ]
    assert tags.Name == "Zürich"
    tags["Grid[1,0]"] = 7
    tags["Recipe[1]"] = {"On": True}
    tags["N.31"] = 1
    tags["Second[0]"] = -3
    tags.Ratio = 0.1
    assert tags.Grid == [[0, 0], [7, 0]]
    assert (tags["Recipe[1].On"], tags["recipe[1].time"], tags.N, tags.Second) == (True, 0, -(2**31), [-3, 2])
    assert tags.Ratio == 13_421_773 / 2**27  # the single nearest to 0.1
    for name, value in (
        ("N", 2**31),
        ("N", 1.5),
        ("Ratio", "1"),
        ("N.3", 2),
        ("Grid[2,0]", 1),
        ("Nobody", 1),
    ):
        with pytest.raises(ValueError, match=name.split("[")[0].split(".")[0]):
            tags[name] = value


def rack_scan(inputs, outputs, *, first=False, now_ns=0):
    slot = SimpleNamespace(inputs=inputs, outputs=outputs)
    return SimpleNamespace(slot={1: slot}, now_ns=now_ns, first=first, number=0, period_ns=2_000_000)


IMAGES = """PROGRAM p
TAG Copy : INT[3]
SLOT axis : 1
ROUTINE Main
XIC(Local:1:I.Data[0].14)XIC(I:1.0/14)XIC(I:1/14)XIC(axis.status.MODULE_OK)XIC(axis.I.Data[0].14)OTE(axis.command.RESET_ERRORS);
XIC(O:1.0/11)MOV(I:1.2,Copy[0])MOV(Local:1:O.Data[0],Copy[1])MOV(O:1.0,Copy[2])MOV(-5,O:1.3);
END
"""


def test_images_under_all_their_names():
    inputs, outputs = Image([0x4000, 0, 77]), Image()
    for engine in (parse_program(IMAGES).compile(), parse_program(IMAGES).interpret()):
        outputs.clear()
        scan = rack_scan(inputs, outputs, first=True)
        engine(scan)
        assert outputs.words.tolist() == [0x0800, 0, 0, -5, 0, 0, 0, 0]
        assert engine.tags.Copy == [77, 0x0800, 0x0800]
        assert engine.tags["axis.command.RESET_ERRORS"] is True
        assert engine.tags["Local:1:I.Data"] == [0x4000, 0, 77, 0, 0, 0, 0, 0]


def test_a_slot_that_the_rack_does_not_have():
    scan = rack_scan(Image(), Image())
    scan.slot[2] = scan.slot.pop(1)
    with pytest.raises(ValueError, match=r"uses slot 1 .*, the rack has 2"):
        parse_program(IMAGES)(scan)


def test_the_first_scan_is_prescanned_anew():
    program = parse_program(
        "PROGRAM p\nTAG N : DINT\nTAG S : BOOL\nTAG X : BOOL := true\n"
        "ROUTINE Main\nXIC(X)ONS(S)ADD(N,1,N);\nXIC(S:FS)ADD(N,100,N);\nEND\n"
    )
    scan = rack_scan(Image(), Image())
    for scan.first in (True, False, False, True):
        program(scan)
    assert program.tags.N == 200


def test_python_routines_and_rungs_call_each_other():
    program = Program("p")
    raw, scaled, calls = program.declare("Raw Scaled Calls", DINT)

    @program.routine
    def Main(rung):  # noqa: N802
        rung(JSR("scale", 1, raw, scaled))

    @program.routine
    def Count(rung):  # noqa: N802
        rung(ADD(calls, 1, calls))

    @program.function
    def scale(tags, value, *, jsr):
        jsr("Count")
        tags.Raw = value + 1
        return value * 10

    for engine in (program.compile(), program.interpret()):
        for _ in range(3):
            engine.step()
        assert (engine.tags.Raw, engine.tags.Scaled, engine.tags.Calls) == (3, 20, 3)


@pytest.mark.parametrize(
    ("given", "kept", "overflows"),
    [
        (2**31 - 1, 2**31 - 1, False),
        (2**31, -(2**31), True),
        (-(2**31), -(2**31), False),
        (-(2**31) - 1, 2**31 - 1, True),
        (2.0**31 - 256, 2**31 - 256, False),
        (2.0**31, -(2**31), True),
    ],
)
@pytest.mark.parametrize("compiled", [True, False])
def test_what_python_answers_overflows_a_dint_as_an_instruction_does(given, kept, overflows, compiled):
    """A DINT keeps the low 32 bits, S:V is set and a minor fault, type 4 code 4, recorded [1756-RM003N]."""
    program = parse_program(
        "PROGRAM p\nTAG D : DINT\nTAG Late : BOOL\nROUTINE Main\nJSR(answer,0,D);\nXIC(S:V)OTE(Late);\nEND\n"
    )
    assert isinstance(program, Program)

    @program.function
    def answer(tags):
        return given

    engine = program.compile() if compiled else program.interpret()
    engine.step()
    assert (engine.tags.D, engine.tags.Late) == (kept, overflows)
    assert [(fault.type, fault.code) for fault in engine.minor_faults] == [(4, 4)] * overflows


@pytest.mark.parametrize(("kind", "bits"), [("SINT", 8), ("INT", 16), ("DINT", 32)])
def test_python_writes_what_fits_a_tag_and_nothing_else(kind, bits):
    tags = parse_program(f"PROGRAM p\nTAG Value : {kind}\nROUTINE Main\nNOP();\nEND\n").compile().tags
    for value in (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1):
        tags.Value = value
        assert tags.Value == value
    for value in (-(2 ** (bits - 1)) - 1, 2 ** (bits - 1)):
        with pytest.raises(ValueError, match=f"Value: {value} is out of range"):
            tags.Value = value
    assert tags.Value == 2 ** (bits - 1) - 1


def test_a_plain_function_of_the_tags_as_main():
    program = Program("p")
    program.declare("N", DINT)

    @program.function
    def main(tags):
        tags.N += 1

    for _ in range(4):
        program.step()
    assert program.tags.N == 4


FILE = """PROGRAM line MAIN Start
ALLOW repeated coils
TYPE Step (Time : DINT, On : BOOL, Marks : INT[2])
TAG Run : BOOL  // the motor
TAG Recipe : Step[2] := [{"Time": 5}]
TAG Name : STRING := "a // b"
SLOT axis : 1
ALIAS Go : Local:1:I.Data[1].2

ROUTINE Sub
XIC(Go)OTE(Run);
END

ROUTINE Start
// two lines
// of comment
JSR(Sub,0);
END
"""


def test_program_files_both_ways(tmp_path):
    program = parse_program(FILE)
    assert program.routines[1].rungs[0].comment == "two lines\nof comment"
    assert program.declarations[0].comment == "the motor"
    text = program_text(program)
    assert program_text(parse_program(text)) == text
    write_program(program, tmp_path / "line.rung")
    again = read_program(tmp_path / "line.rung")
    assert again.declarations == program.declarations
    assert again.routines == program.routines
    assert again.tags.Name == "a // b"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("TAG Run : BOOL\n", r"f.rung:1: column 1: expected PROGRAM name"),
        ("PROGRAM p\nTAG Run : BOLL\n", r"expected a type \(did you mean BOOL\?\), found BOLL"),
        ("PROGRAM p\nTAG Run : Xyzzy\n", r"f.rung:2: column 1: expected a type \(BOOL, SINT, .*found Xyzzy"),
        (
            "PROGRAM p\nTAG Axis : AXIS_3601\n",
            r"a type \(AXIS_3601 is in library axis3601: write USE axis3601 above\), found AXIS_3601",
        ),
        (
            "PROGRAM p\n\n  TAGG Run\n",
            r"f.rung:3: column 3: expected USE, TYPE, INSTRUCTION, TAG, SLOT, ALIAS, STUB or ROUTINE",
        ),
        ("PROGRAM p\nROUTINE Main\nNOP();\n", r"f.rung:4: column 1: expected END of the routine"),
        (
            "PROGRAM p\nROUTINE Main\nNOP();\nNOP()\nEND\n",
            r"f.rung:4: rung 1, column 6: expected ; at the end",
        ),
        ("PROGRAM p\nROUTINE Main\nNOP(;\nEND\n", r"f.rung:3: rung 0, column 5: expected"),
        ("PROGRAM p\nTAG N : DINT := x\n", r"f.rung:2: column 1: expected an initial value in JSON"),
    ],
)
def test_errors_in_program_files(text, message):
    with pytest.raises(ValueError, match=message):
        parse_program(text, file="f.rung")


def test_a_rung_file_is_a_program_for_a_rack(tmp_path):
    (tmp_path / "line.rung").write_text(IMAGES, encoding="utf-8")
    loaded = load_program("line.rung", tmp_path)
    outputs = Image()
    loaded.function(rack_scan(Image([0x4000]), outputs, first=True))
    assert outputs[3] == -5
    (tmp_path / "bad.rung").write_text("PROGRAM p\nROUTINE Main\nXIC(A)OTE(B);\nEND\n", encoding="utf-8")
    with pytest.raises(ProgramError, match=r"bad.rung:3: routine Main, rung 0: XIC\(A\): no tag A"):
        load_program("bad.rung", tmp_path)


def test_a_fault_points_at_the_line_of_the_rung(tmp_path):
    (tmp_path / "line.rung").write_text(
        "PROGRAM p\nTAG D : INT[2]\nTAG N : DINT := 5\nROUTINE Main\nNOP();\nMOV(1,D[N]);\nEND\n",
        encoding="utf-8",
    )
    program = read_program(tmp_path / "line.rung")
    with pytest.raises(LadderFault) as caught:
        program.step()
    places = [(str(each.path), each.lineno + 1) for each in caught.traceback]
    assert (str(tmp_path / "line.rung"), 6) in places
    assert str(caught.value) == (
        "program p, routine Main, rung 1, MOV(1,D[N]): D[N]: subscript 5 is out of range; "
        "must be 0 to 1 (major fault, type 4 code 20)"
    )


def test_the_source_can_be_read():
    program = parse_program(
        "PROGRAM m\nTAG Start : BOOL\nTAG Stop : BOOL\nTAG Run : BOOL\n"
        "ROUTINE Main\n[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);\nEND\n"
    )
    assert "        Run = (Start or Run) and not Stop\n" in program.source()
