"""`missing_tags = "declare"`: tags without a declaration get the type that their uses ask for."""

import pytest
from scanrack.ladder import BuildError, Controller
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering.runnable import declared
from scanrack.ladder.model.stubs import Stubs

INFER = Stubs(missing_tags=True)
BLOCK = """INSTRUCTION Scale
INPUT Raw : INT REQUIRED
INOUT Table : REAL[8]
ROUTINE Logic
MOV(Raw,Table[0]);
END
END INSTRUCTION
"""


def found(*rungs, kind="", head=""):
    """Return the tags of rungs that declare none, as text, after a scan of both back ends."""
    text = "\n".join([f"PROGRAM p\n{head}ROUTINE Main{kind}", *rungs, "END\n"])
    program = parse_program(text, stubs=INFER)
    for engine in (program.compile(), program.interpret()):
        engine.step()
    return [declared(each) for each in program.declared_missing]


@pytest.mark.parametrize(
    ("rung", "tags"),
    [
        ("XIC(Run)OTE(Lamp);", ["Run : BOOL", "Lamp : BOOL"]),
        ("XIC(Go)TON(Fill,?,?);", ["Go : BOOL", "Fill : TIMER"]),
        ("XIC(Fill.DN)OTE(Lamp);", ["Fill : TIMER", "Lamp : BOOL"]),
        ("XIC(Parts.OV)OTE(Lamp);", ["Parts : COUNTER", "Lamp : BOOL"]),
        ("XIC(Word.3)MOV(5,Count);", ["Word : DINT", "Count : DINT"]),
        ("ADD(Level,2.5,Level);", ["Level : REAL"]),
        ("CPT(Level,(Raw*1.5)/Span);", ["Level : REAL", "Raw : REAL", "Span : REAL"]),
        ("CONCAT(Text,'a',Text);", ["Text : STRING"]),
        ("MOV(Data[7],Data[2]);", ["Data : DINT[8]"]),
        ("MOV(Grid[1,3],Data[Index]);", ["Grid : DINT[2,4]", "Index : DINT", "Data : DINT[100]"]),
        ("COP(From,To,5);", ["From : DINT[5]", "To : DINT[5]"]),
        ("XIC(Recipe[2].Ready)MOV(Recipe[2].Step,Now);", ["Recipe : Recipe_type[3]", "Now : DINT"]),
        ("MSO(Ax,M);", ["Ax : AXIS_CIP_DRIVE", "M : MOTION_INSTRUCTION"]),
        ("XIC(Ax.AxisHomedStatus)OTE(Lamp);", ["Ax : AXIS_CIP_DRIVE", "Lamp : BOOL"]),
        ("XIC(Local:1:I.Data[0].3)XIC(Rack:3:I.Ok)OTE(S);", ["Rack:3:I : Rack_3_I_type", "S : BOOL"]),
        ("XIC(N7:3/2)OTE(B3:0/1);", ["N7 : DINT[4]", "B3 : DINT[1]"]),
    ],
)
def test_a_use_asks_for_a_type(rung, tags):
    assert found(rung) == tags


@pytest.mark.parametrize(
    ("rung", "tags"),
    [
        ("TON(T4:1,1.0,5,0);", ["T4 : SLC_TIMER[2]"]),
        ("CTU(C5:0,5,0)RES(C5:0);", ["C5 : SLC_COUNTER[1]"]),
        ("RES(T4:0);", ["T4 : SLC_TIMER[1]"]),
        ("XIC(T4:2.DN)MOV(T4:2.ACC,N7:3);", ["T4 : SLC_TIMER[3]", "N7 : INT[4]"]),
        ("BSL(B3:0,R6:0,B3:2/0,8);", ["B3 : INT[3]", "R6 : SLC_CONTROL[1]"]),
        ("ADD(F8:0,1.5,F8:1);", ["F8 : REAL[2]"]),
        ("MOV(L[N7:2],L[0]);", ["N7 : INT[3]", "L : INT[100]"]),
        ("XIC(S:1/15)XIC(B3:0/3)OTE(Lamp);", ["B3 : INT[1]", "Lamp : BOOL"]),  # S is there
    ],
)
def test_a_use_in_an_slc_asks_for_the_type_of_a_data_file(rung, tags):
    assert found(rung, head="DIALECT slc\n") == tags


def test_a_call_asks_for_the_types_of_its_parameters():
    assert found("Scale(One,Raw,Table);", head=BLOCK) == ["One : Scale", "Raw : INT", "Table : REAL[8]"]


def test_structured_text_asks_for_types():
    text = "IF Go AND NOT Stop THEN Level := Level * 1.5; END_IF;\nOver := Level > 3.0;"
    assert found(text, kind=" ST") == ["Go : BOOL", "Stop : BOOL", "Level : REAL", "Over : BOOL"]


def test_the_tags_are_listed_with_the_stubs_in_use():
    program = parse_program("PROGRAM p\nROUTINE Main\nXIC(A)OTE(B[2]);\nEND\n", stubs=INFER)
    assert program.stubs_in_use == ("missing_tags = declare: A : BOOL, B : BOOL[3]",)


def test_a_tag_of_a_program_is_its_own_and_a_missing_one_the_controllers():
    plant = Controller("plant")
    plant.take_stubs(INFER)
    for name in ("One", "Two"):
        program = plant.program(name)

        @program.routine
        def Main(rung):  # noqa: N802
            rung("XIC(Shared)OTE(Own);")

    plant.step()
    assert [declared(each) for each in plant.declared_missing] == ["Shared : BOOL", "Own : BOOL"]


def test_without_it_a_missing_tag_is_refused():
    with pytest.raises(BuildError, match="no tag A"):
        parse_program("PROGRAM p\nROUTINE Main\nXIC(A)OTE(B);\nEND\n").build()


@pytest.mark.parametrize(
    ("rungs", "tags"),
    [
        # a queue has the type of what is loaded into it or unloaded from it, however that is known
        (
            ("FFL(Part,Queue[0],Ctl,20,0);", "FFU(Queue[0],Next,Ctl,20,0)MOV(Next.Id,X)XIC(Part.Ok)OTE(L);"),
            {"Part": "Part_type", "Queue": "Part_type[20]", "Next": "Part_type"},
        ),
        (
            ("LFL(Name,Stack[0],Ctl,5,0)CONCAT(Name,'a',Name);",),
            {"Name": "STRING", "Stack": "STRING[5]"},
        ),
        (("FFL(Cell,Queue[0],Ctl,9,0);",), {"Queue": "Cell[9]"}),
        # a copy tells the type if nothing else does, and the length if no other use takes the tag whole
        (("COP(Rec[3],Cur,1);", "MOV(Cur.Speed,V);"), {"Rec": "Rec_type[4]", "Cur": "Rec_type"}),
        (("COP(Word,Bits[0],4);", "MOV(Word,X);"), {"Word": "DINT", "Bits": "DINT[4]"}),
        (("COP(Whole,Other[0],8);", "XIC(Whole.Ok)OTE(L);"), {"Whole": "Whole_type"}),
        # a subscript is an integer, whatever it is beside
        (("MUL(Ix,1.5,Y)MOV(Table[Ix],Y);",), {"Ix": "DINT", "Table": "DINT[100]"}),
        # parameters of a routine
        (("JSR(Sub,1,Unit,Back);",), dict.fromkeys(("Taken", "Unit", "Back"), "Unit_type")),
    ],
)
def test_tags_that_are_of_one_type(rungs, tags):
    sub = "END\nROUTINE Sub\nSBR(Taken);\nXIC(Taken.Ok)OTE(Taken.Lamp);\nRET(Taken);\n" * ("JSR" in rungs[0])
    head = "TYPE Cell (Mark : DINT)\nTAG Cell : Cell\n"
    text = "\n".join([f"PROGRAM p\n{head}ROUTINE Main", *rungs, f"{sub}END\n"])
    program = parse_program(text, stubs=INFER)
    for engine in (program.compile(), program.interpret()):
        engine.step()
    found = dict(declared(each).split(" : ") for each in program.declared_missing)
    assert {name: found.get(name) for name in tags} == tags


def test_and_not_of_bits_is_a_bit():
    text = "Run := Go AND NOT Stop;\nMask := Word AND 16#FF;"
    assert found(text, kind=" ST") == [
        *("Run : BOOL", "Go : BOOL", "Stop : BOOL"),
        *("Mask : DINT", "Word : DINT"),
    ]


def test_a_module_without_a_name_has_a_number():
    """`&4DA5D0F8:I` is how exports print its tag; & alone is AND."""
    said = found("XIC(&4DA5D0F8:I.Data.3)CPT(A,B&C)OTE(L);", "MOV(&4DA5D0F8:3:O,X);")
    assert "&4DA5D0F8:I : _4DA5D0F8_I_type" in said
    assert "&4DA5D0F8:3:O : DINT" in said
    assert "A : DINT" in said
    assert "&4DA5D0F8:I : DINT" in found("X := A & &4DA5D0F8:I;", kind=" ST")
