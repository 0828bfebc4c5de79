"""Initial values with a radix: the bits of the type that they stand in."""

import pytest
from scanrack.jobs import load_program
from scanrack.ladder import LadderError, Program
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.tags import Tag

TYPE = "TYPE S (A : INT, B : DINT[2])\n"


def starting(declaration):
    program = parse_program(f"PROGRAM p\n{declaration}\nROUTINE Main\nNOP();\nEND\n")
    again = parse_program(program_text(program))
    assert again.tags["T"] == program.tags["T"]
    return program.tags["T"]


@pytest.mark.parametrize(
    ("declaration", "value"),
    [
        ("TAG T : INT := 16#843C", -31684),  # 0x843C = 33,852, less 65,536
        ("TAG T : INT := 16#7FFF", 32767),
        ("TAG T : DINT := 16#843C", 33852),
        ("TAG T : DINT := 16#FFFF_FFFF", -1),
        ("TAG T : SINT := 2#1000_0001", -127),
        ("TAG T : INT[3] := [8#17, 16#ffff, -5]", [15, -1, -5]),
        (
            'TYPE S (A : INT, B : DINT[2])\nTAG T : S := {"a": 16#8000, "B": [16#8000]}',
            {"A": -32768, "B": [32768, 0]},
        ),
        ('TAG T : STRING := "16#FF // \\" 2#1"', '16#FF // " 2#1'),
    ],
)
def test_a_number_with_a_radix(declaration, value):
    assert starting(declaration) == value


@pytest.mark.parametrize("text", ["16#", "16#XY", "2#2", "16#1_0000_0000", "16#FF"])
def test_what_is_no_number_or_does_not_fit(text):
    kind = "DINT" if text == "16#1_0000_0000" else "BOOL"
    with pytest.raises(LadderError):
        starting(f"TAG T : {kind} := {text}")


@pytest.mark.parametrize("value", ['"N": true', '"L": [1, true]', '"X": true', '"B": 2', '"N": 1.0'])
@pytest.mark.parametrize("rung", ["NOP();", "MOV(T.N,T.L[0])MOV(T.X,T.L[1])XIC(T.B)OTE(T.B);", "COP(T,U,1);"])
def test_a_value_of_another_type_is_refused_wherever_its_tag_is_stored(value, rung):
    """A structure that no instruction takes apart is bytes, one whose members are used is variables."""
    tags = f"TYPE S (N : DINT, L : DINT[2], X : REAL, B : BOOL)\nTAG T : S := {{{value}}}\nTAG U : S\n"
    with pytest.raises(LadderError, match=r"T\.[NLXB]: .* is not (of type|a BOOL)"):
        parse_program(f"PROGRAM p\n{tags}ROUTINE Main\n{rung}\nEND\n").build()


def test_the_feeder_shows_its_configuration_in_hexadecimal():
    program = load_program("examples/feeder/feeder.rung")
    assert isinstance(program.function, Program)
    words = next(each for each in program.function.declarations if each.name == "Words")
    assert isinstance(words, Tag)
    assert words.initial == [-31684, 60, 0, 500, 0, 0, 0, 0]
    assert "16#843C" in program.source


def test_engines_of_one_program_share_no_values():
    program = parse_program(
        """PROGRAM many
TYPE PART (Name : STRING, Data : DINT[3], Delay : TIMER)
SLOT axis : 1
TAG One : PART
TAG Two : PART
TAG List : DINT[4] := [1, 2, 3, 4]
TAG Number : REAL := 2.5
ROUTINE Main
COP(One,Two,1);
ADD(Number,1,Number)MOV(9,List[2])MOV(7,One.Data[1])MOV(1,axis.O.Data[0]);
TON(One.Delay,100,0);
END
"""
    )
    first = program.compile()
    expected = first.memory.snapshot()
    others = [program.compile() for _ in range(2)]
    for each in (first, *others[:1]):
        each.step()
        each.step()
        assert each.memory.snapshot() != expected
    assert first.memory.snapshot() == others[0].memory.snapshot()
    assert others[1].memory.snapshot() == program.interpret().memory.snapshot() == expected
