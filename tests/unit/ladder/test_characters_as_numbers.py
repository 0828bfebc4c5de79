"""Characters where a number is needed are that number in ASCII, the first one its highest byte."""

import pytest
from scanrack.ladder import BuildError
from scanrack.ladder.files import parse_program

TAGS = """PROGRAM p
TAG Code : DINT
TAG Long : LINT
TAG Text : STRING := "A-"
TAG Same : BOOL
"""


def both(routine):
    """Return the engines of a program after a scan, compiled and interpreted."""
    program = parse_program(TAGS + routine)
    engines = program.compile(), program.interpret()
    for engine in engines:
        engine.step()
    return engines


@pytest.mark.parametrize(
    ("rung", "tag", "value"),
    [
        ("MOV('A',Code);", "Code", 65),
        ("MOV('AB',Code);", "Code", 0x4142),
        ("MOV('$0D',Code);", "Code", 13),
        ("MOV('ABCDEFGH',Long);", "Long", 0x4142434445464748),
        ("EQU(Text.DATA[0],'A')OTE(Same);", "Same", True),
        ("EQU(Text,'A-')OTE(Same);", "Same", True),
        ("LIM('0',Text.DATA[0],'Z')OTE(Same);", "Same", True),
    ],
)
def test_in_rungs(rung, tag, value):
    for engine in both(f"ROUTINE Main\n{rung}\nEND\n"):
        assert engine.tags[tag] == value


def test_in_structured_text():
    text = "Text.DATA[1] := '.';\nSame := Text.DATA[0] = 'A' AND Text = 'A.';\nCode := Text.DATA[0] - '0';"
    for engine in both(f"ROUTINE Main ST\n{text}\nEND\n"):
        assert (engine.tags["Text"], engine.tags["Same"], engine.tags["Code"]) == ("A.", True, 65 - 48)


def test_more_characters_than_an_integer_has():
    with pytest.raises(BuildError, match="a string can't be moved to a LINT"):
        parse_program(f"{TAGS}ROUTINE Main\nMOV('ABCDEFGHI',Long);\nEND\n").build()


def test_words_of_motion_instructions_in_structured_text():
    text = "MAS(Ax,Stop,All,Yes,100,Unitspersec2,No,100,%ofTime);"
    head = "TAG Ax : AXIS_CIP_DRIVE\nTAG Stop : MOTION_INSTRUCTION\n"
    program = parse_program(f"{TAGS}{head}ROUTINE Main ST\n{text}\nEND\n")
    program.build()
    assert program.text("Main") == text
