"""A string that an instruction has just stored is read from a variable, where the memory has the same."""

import pytest
from ladder_lockstep import differences, outcome
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program

HEAD = """PROGRAM p
TYPE Name (LEN : DINT, DATA : SINT[7])
TAG Go : BOOL := true
TAG I : DINT
TAG Number : DINT
TAG A : Name := "old"
TAG B : Name := "abc"
TAG Names : Name[3] := ["x", "yy", "zzz"]
TAG Text : STRING
ROUTINE Main
{}
END
"""


def after(line, **values):
    """Do a scan on both back ends, which must agree; return the tags."""
    program = parse_program(HEAD.format(line))
    found = []
    for engine in (program.compile(), program.interpret()):
        found.append((outcome(engine, 1, values), engine.tags))
    (ours, tags), (theirs, _) = found
    assert ours[0] == theirs[0]
    assert ours[2] == theirs[2]
    assert differences(ours[1], theirs[1]) == {}
    return tags


def test_the_memory_is_not_read_again():
    source = parse_program(HEAD.format("DTOS(I,A)CONCAT('n',A,Text);")).source()
    assert "if __2 is not None else (A.bits" in source
    assert after("DTOS(I,A)CONCAT('n',A,Text)STOD(A,Number);", I=42)["Text"] == "n42"
    assert after("DTOS(I,A)CONCAT('n',A,Text)STOD(A,Number);", I=42)["Number"] == 42


@pytest.mark.parametrize(
    ("line", "i", "expected"),
    [
        # "abc" has no ninth character, so that A stays [1756-RM003, MID]
        ("MID(B,1,I,A)CONCAT(A,'!',Text);", 9, {"A": "old", "Text": "old!"}),
        ("MID(B,1,I,A)CONCAT(A,'!',Text);", 2, {"A": "b", "Text": "b!"}),
        # a result of eight characters is cut off at the seven of A
        ("CONCAT('12345',B,A)CONCAT(A,'!',Text);", 0, {"A": "12345ab", "Text": "12345ab!"}),
        # the number of eight digits does not fit, and A stays
        ("DTOS(I,A)CONCAT(A,'!',Text);", 12345678, {"A": "old", "Text": "old!"}),
        # what else writes to the string
        ("DTOS(I,A)MOV(1,A.LEN)CONCAT(A,'!',Text);", 42, {"Text": "4!"}),
        ("DTOS(I,A)FIND(A,'2',1,A.LEN)CONCAT(A,'!',Text);", 421, {"Text": "42!"}),
        ("DTOS(I,A)STOD(A,A.LEN)UPPER(A,Text);", 3, {"Text": "3$00$00".replace("$00", chr(0))}),
        ("DTOS(I,Names[1])MID(B,2,1,Names[I])CONCAT(Names[1],'!',Text);", 1, {"Text": "ab!"}),
        ("DTOS(I,A)COP(B,A,1)CONCAT(A,'!',Text);", 42, {"Text": "abc!"}),
        # a leg that does not run
        ("[XIO(Go)DTOS(I,A),XIC(Go)NOP()]CONCAT(A,'!',Text);", 42, {"A": "old", "Text": "old!"}),
        # the second one needs the first one's LEN, which is out of range, and has no result
        ("MOV(99,B.LEN)CONCAT(B,'x',A)CONCAT(A,'!',Text);", 0, {"A": "old", "Text": "old!"}),
    ],
)
def test_a_string_is_what_the_memory_has(line, i, expected):
    tags = after(line, I=i)
    assert {name: tags[name] for name in expected} == expected


@pytest.mark.parametrize(
    ("text", "number"),
    [("42", 42), ("007", 7), ("a-7b", -7), ("", 5), ("-3", -3), ("1234567", 1234567), ("1.5", 1)],
)
def test_a_number_in_a_string(text, number):
    assert after("STOD(B,Number);", B=text, Number=5)["Number"] == number


def test_a_number_of_more_than_32_bits():
    digits = "9999999999"  # ten: above 2147483647, so that it does not fit a DINT
    program = parse_program(HEAD.format("STOD(Text,Number);"))
    for engine in (program.compile(), program.interpret()):
        engine.tags["Text"] = digits
        engine.step(1)
        assert [each.code for each in engine.minor_faults] == [53]


@pytest.mark.parametrize("interpreted", [False, True])
def test_a_forced_character_is_in_the_next_string(interpreted):
    debugger = Debugger(parse_program(HEAD.format("DTOS(I,A)CONCAT(A,'!',Text);")))
    debugger.interpreted = interpreted
    debugger.tags["I"] = 42
    debugger.force("A.DATA[0]", ord("X"))
    debugger.scan(1, 1)
    assert debugger.tags["Text"] == "X2!"
