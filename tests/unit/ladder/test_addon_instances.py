"""Instances of add-on instructions wherever a tag may be, and InOuts: what is handed over [1756-PM010]."""

import pytest
from ladder_bench import Named
from scanrack.ladder import BuildError, LadderFault
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program, program_text

ADDER = """\
INSTRUCTION Adder
INPUT By : DINT REQUIRED
OUTPUT Sum : DINT REQUIRED
LOCAL Own : DINT
ROUTINE Logic
ADD(Own,By,Own);
MOV(Own,Sum);
END
END INSTRUCTION
"""
TAGS = "TAG N : DINT := 3\nTAG R : DINT\nTAG I : DINT\nTAG Go : BOOL\n"


def engines(rungs, definitions=ADDER, tags=""):
    program = parse_program(f"PROGRAM p\n{definitions}{TAGS}{tags}ROUTINE Main\n{rungs}\nEND\n")
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


def warnings(rungs, definitions, tags):
    program = parse_program(f"PROGRAM p\n{definitions}{TAGS}{tags}ROUTINE Main\n{rungs}\nEND\n")
    program.build()
    return "\n".join(map(str, program.warnings))


def test_an_instance_called_from_two_rungs_keeps_one_state():
    for engine in engines("Adder(A,N,R);\nAdder(A,10,R);", tags="TAG A : Adder\n"):
        engine.step()
        assert (engine.tags.R, engine.tags["A.Own"]) == (13, 13), engine


def test_instances_in_an_array_are_chosen_by_a_computed_subscript():
    for engine in engines("Adder(A[I+1],N,R);", tags="TAG A : Adder[4]\n"):
        for number in (0, 2, 2):
            engine.tags.I = number
            engine.step()
        assert [engine.tags[f"A[{each}].Own"] for each in range(4)] == [0, 3, 0, 6], engine
        assert (engine.tags.R, engine.tags["A[3].By"]) == (6, 3), engine


def test_a_subscript_stays_for_the_time_of_the_call():
    """Logic moves on the index that chose the instance; the result still comes out of that instance."""
    mover = ADDER.replace("LOCAL Own", "INOUT At : DINT\nLOCAL Own").replace(
        "MOV(Own,Sum)", "MOV(Own,Sum)ADD(At,1,At)"
    )
    for engine in engines("Adder(A[I],N,R,I);", mover, "TAG A : Adder[2]\n"):
        engine.step()
        assert (engine.tags.R, engine.tags.I, engine.tags["A[0].Own"], engine.tags["A[1].Own"]) == (
            3,
            1,
            3,
            0,
        )


def test_a_subscript_out_of_range_is_a_major_fault_of_the_call():
    for engine in engines("Adder(A[I],N,R);", tags="TAG A : Adder[2]\n"):
        engine.tags.I = 2
        with pytest.raises(LadderFault, match=r"subscript 2 is out of range.*type 4 code 20"):
            engine.step()


def test_instances_in_structures_and_in_arrays_of_them():
    tags = "TYPE Station (Name : DINT, Left : Adder, Both : Adder[2])\nTAG S : Station[3]\n"
    for engine in engines("Adder(S[1].Left,N,R);\nAdder(S[I].Both[1],S[1].Left.Sum,R);", tags=tags):
        engine.tags.I = 2
        engine.step()
        assert (engine.tags["S[1].Left.Own"], engine.tags["S[2].Both[1].Own"], engine.tags.R) == (3, 3, 3)
        assert engine.tags["S[2].Both[0].Own"] == 0, engine


OUTER = """\
INSTRUCTION Outer
INPUT By : DINT REQUIRED
INOUT Log : DINT
LOCAL First : Adder
LOCAL More : Adder[2]
LOCAL At : DINT := 1
OUTPUT Sum : DINT REQUIRED
ROUTINE Logic
Adder(First,By,Sum);
Adder(More[At],Sum,Log);
END
END INSTRUCTION
"""


def test_instances_in_instances():
    for engine in engines(
        "Outer(O[1],N,List[I],R);", ADDER + OUTER, "TAG O : Outer[2]\nTAG List : DINT[4]\n"
    ):
        engine.tags.I = 2
        engine.step()
        engine.step()
        assert (engine.tags.R, engine.tags["List[2]"]) == (6, 9), engine
        assert (engine.tags["O[1].More[1].Own"], engine.tags["O[0].At"]) == (9, 1), engine


# --- by reference

HANDED = """\
TYPE Pair (A : DINT, B : INT[3], T : TIMER)
INSTRUCTION Worker
INOUT Bit : BOOL
INOUT Count : DINT
INOUT List : INT[3]
INOUT Any : INT
INOUT Two : Pair
INOUT Time : TIMER
INOUT Text : STRING
LOCAL Copy : INT[4]
ROUTINE Logic
XIC(Bit)ADD(Count,1,Count);
XIO(Bit)OTE(Bit);
ADD(List[Count],List[2],List[0]);
MOV(Any[Count],Two.A);
COP(Two.B,Copy,4);
COP(List,Two.B[1],2);
TON(Time,?,?)XIC(Time.DN)MOV(7,Count);
EQU(Text,'go')MOV(65,Text.DATA[0]);
END
END INSTRUCTION
"""
HANDED_TAGS = """\
TAG W : Worker
TAG Word : INT := 4
TAG Words : INT[5] := [1,2,3,4,5]
TAG Pairs : Pair[2]
TAG Name : STRING := "go"
TAG Times : TIMER[2] := [{"PRE": 30},{"PRE": 10}]
"""


@pytest.mark.parametrize("bit", ["Word.3", "Word.15", "Word.[I]", "Go", "Bits[1]"])
def test_what_is_handed_over_is_the_callers_own_tag(bit):
    tags = f"{HANDED_TAGS}TAG Bits : BOOL[2]\n"
    rung = f"Worker(W,{bit},N,Words,Words,Pairs[I],Times[1],Name);"
    for engine in engines(rung, HANDED, tags):
        engine.tags.I, engine.tags.N = 1, 0
        engine.step()
        assert (engine.tags[bit.replace("[I]", "1")], engine.tags.N) == (True, 0), engine
        assert engine.tags["Words[0]"] == 1 + 3, "List[0] + List[2]"
        assert (engine.tags["Pairs[1].A"], engine.tags["Pairs[1].B"]) == (4, [0, 4, 2]), engine
        assert engine.tags.Name == "Ao", engine
        engine.step(10)
        assert engine.tags["W.Copy"] == [0, 4, 2, 0], "a member array ends where it ends"
        assert (engine.tags["Times[1].DN"], engine.tags.N) == (True, 7), engine
        with pytest.raises(
            LadderFault,
            match=r"subscript 7 is out of range.*type 4 code 20.* called by routine Main, rung 0, Worker",
        ):
            engine.step()


def test_a_copy_from_an_element_that_is_handed_over_goes_on_in_its_array():
    text = (
        "INSTRUCTION C\nINOUT From : INT\nINOUT To : INT\n"
        "ROUTINE Logic\nCOP(From,To,9);\nEND\nEND INSTRUCTION\n"
    )
    tags = "TAG X : C\nTAG Words : INT[5] := [1,2,3,4,5]\nTAG Into : INT[4]\nTAG Single : INT := 9\n"
    for engine in engines("C(X,Words[2],Into[1]);", text, tags):
        engine.step()
        assert engine.tags.Into == [0, 3, 4, 5], engine
    for engine in engines("C(X,Single,Into[I]);", text, tags):
        engine.tags.I = 3
        engine.step()
        assert engine.tags.Into == [0, 0, 0, 9], engine
    for engine in engines("C(X,Words[I],Local:1:O.Data[6]);", text, tags):
        engine.tags.I = 3
        engine.step()
        assert engine.tags["Local:1:O.Data"] == [0] * 6 + [4, 5], engine


def test_an_input_of_a_module_that_is_written_by_reference_is_a_warning():
    text = (
        "INSTRUCTION C\nINOUT Word : INT\nOUTPUT Out : INT REQUIRED\n"
        "ROUTINE Logic\n{}\nEND\nEND INSTRUCTION\n"
    )
    tags = "TAG X : C\nTAG W : INT\n"
    for engine in engines("C(X,Local:1:I.Data[2],W);", text.format("ADD(Word,1,Out);"), tags):
        engine.step()
        assert engine.tags.W == 1
    warned = warnings("C(X,Local:1:I.Data[2],W);", text.format("ADD(Word,1,Word);"), tags)
    assert "Local:1:I.Data[2] is an input, and C writes it as WORD: its module writes over it" in warned
    for engine in engines("C(X,Local:1:I.Data[2],W);", text.format("ADD(Word,1,Word)MOV(Word,Out);"), tags):
        engine.step()
        assert (engine.tags.W, engine.tags["Local:1:I.Data[2]"]) == (1, 1), engine


def test_so_is_one_that_is_written_by_what_is_called_inside():
    inner = "INSTRUCTION C\nINOUT Word : INT\nROUTINE Logic\nCLR(Word);\nEND\nEND INSTRUCTION\n"
    outer = "INSTRUCTION D\nINOUT Word : INT\nLOCAL C : C\nROUTINE Logic\nC(C,Word);\nEND\nEND INSTRUCTION\n"
    assert "I:1.2 is an input, and D writes it as WORD" in warnings(
        "D(X,I:1.2);", inner + outer, "TAG X : D\n"
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("Worker(W,Go,N,Word,Words,Pairs[0],Times[0],Name);", r"List of Worker is INT[3], Word is an INT"),
        (
            "Worker(W,Go,N,Two,Words,Pairs[0],Times[0],Name);",
            r"List of Worker is INT[3], Two is an array of INT",
        ),
        ("Worker(W,Go,N,Words,Word,Pairs[0],Times[0],Name);", r"Any of Worker is INT[any], Word is an INT"),
        (
            "Worker(W,Go,N,Words,Words,Times[0],Times[0],Name);",
            "Two of Worker is a Pair, Times[0] is a TIMER",
        ),
    ],
)
def test_what_is_handed_over_has_to_be_of_the_type(call, message):
    with pytest.raises(BuildError) as refused:
        engines(call, HANDED, f"{HANDED_TAGS}TAG Two : INT[2]\n")
    assert message in str(refused.value)


@pytest.mark.parametrize("target", ["Local:1:O.Data[2]", "Words[0]"])
def test_half_a_word_of_an_output_is_refused_by_reference_too(target):
    inner = (
        "INSTRUCTION C\nINOUT To : INT\nLOCAL Bytes : SINT[3]\n"
        "ROUTINE Logic\nCOP(Bytes,To,2);\nEND\nEND INSTRUCTION\n"
    )
    outer = "INSTRUCTION D\nINOUT To : INT\nLOCAL C : C\nROUTINE Logic\nC(C,To);\nEND\nEND INSTRUCTION\n"
    tags = "TAG X : D\nTAG Words : INT[4]\n"
    if target.startswith("Words"):
        assert engines(f"D(X,{target});", inner + outer, tags)
        return
    with pytest.raises(BuildError, match="Bytes may end in the middle of a word of To"):
        engines(f"D(X,{target});", inner + outer, tags)


# --- what instances start with


def test_parameters_and_locals_start_with_their_defaults_in_every_instance():
    text = (
        "INSTRUCTION D\nINPUT Limit : DINT := 5\nLOCAL Table : INT[3] := [1, 2]\nLOCAL On : BOOL := true\n"
        "LOCAL T : TIMER\nOUTPUT Out : DINT\n"
        "ROUTINE Logic\nTON(T,40,0);\nMOV(Limit,Out);\nEND\nEND INSTRUCTION\n"
    )
    tags = 'TYPE Box (Inner : D)\nTAG A : D\nTAG B : D[2] := [{}, {"Limit": 9}]\nTAG C : Box[2]\n'
    program = parse_program(f"PROGRAM p\n{text}{tags}ROUTINE Main\nD(A);\nD(B[1]);\nEND\n")
    assert program_text(parse_program(program_text(program))) == program_text(program)
    for engine in (program.compile(), program.interpret()):
        engine.step()
        seen = [engine.tags[f"{name}.Limit"] for name in ("A", "B[0]", "B[1]", "C[1].Inner")]
        assert seen == [5, 5, 9, 5]
        assert (engine.tags["A.Out"], engine.tags["B[1].Out"]) == (5, 9)
        assert (engine.tags["B[0].Table"], engine.tags["C[0].Inner.On"]) == ([1, 2, 0], True)
        assert engine.tags["C[1].Inner.T.PRE"] == 40, "a number in a rung is a default as well"


# --- people


def test_why_and_the_cross_reference_tell_of_one_instance():
    program = parse_program(
        f"PROGRAM p\n{ADDER}{TAGS}TAG A : Adder\nTAG B : Adder[2]\nROUTINE Main\n"
        "XIC(Go)Adder(A,N,R);\nXIO(Go)Adder(B[1],N,R);\nEND\n"
    )
    debugger = Debugger(program)
    debugger.scan()
    assert debugger.why("A.Own").startswith("A.Own is 0 and has not changed")
    assert "ADD(Own,By,Own)" in debugger.why("B[1].Own")
    assert "of B[1]" in debugger.why("B[1].Own")
    found = [each for each in debugger.cross_reference.of("A.Own") if each.site.routine == "Adder.Logic"]
    assert [(each.site.rung, each.text, each.way) for each in found] == [
        (0, "A.Own", "reads"),
        (0, "A.Own", "writes"),
        (1, "A.Own", "reads"),
    ]
    assert not [
        each for each in debugger.cross_reference.of("B[0].Own") if each.site.routine == "Adder.Logic"
    ]


def test_logic_in_structured_text():
    text = """\
INSTRUCTION Sums
INPUT Amount : DINT REQUIRED
INOUT List : DINT[3]
INOUT Label : STRING
LOCAL Inner : Adder
LOCAL I : DINT
LOCAL Own : STRING := "sum"
OUTPUT Sum : DINT REQUIRED
ROUTINE Logic ST
Sum := 0;
FOR I := 0 TO 2 DO
    Sum := Sum + List[I];
    List[I] := List[I] + Amount;
END_FOR;
Adder(Inner, Amount, Sum);
IF Sum > 3 THEN
    Label := Own;
END_IF;
END
END INSTRUCTION
"""
    tags = "TAG S : Sums[2]\nTAG Lists : DINT[4] := [1, 2, 3, 4]\nTAG Name : STRING\n"
    for engine in engines("Sums(S[I],N,Lists,Name,R);", ADDER + text, tags):
        engine.tags.I = 1
        engine.step()
        assert (engine.tags.Lists, engine.tags.R, engine.tags.Name) == ([4, 5, 6, 4], 3, ""), engine
        engine.step()
        assert (engine.tags.R, engine.tags.Name, engine.tags["S[1].Inner.Own"]) == (6, "sum", 6), engine
