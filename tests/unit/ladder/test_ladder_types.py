"""Types beside the common ones: without a sign, LREAL, strings of other lengths, in both back ends."""

import pytest
from ladder_bench import Named
from scanrack.ladder.files import parse_program, program_text

TAGS = """\
TYPE STRING20 (LEN : DINT, DATA : SINT[20])
TAG A : USINT
TAG B : UINT
TAG C : UDINT
TAG D : ULINT
TAG Signed : DINT
TAG Small : SINT
TAG R : REAL
TAG L : LREAL := 0.1
TAG Ls : LREAL[2]
TAG Name : STRING20 := "abc"
TAG Long : STRING
TAG Bit : BOOL
TAG I : DINT
TAG Bytes : SINT[8]
"""


def engines(rungs):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rungs}\nEND\n")
    assert program_text(parse_program(program_text(program))) == program_text(program)
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


@pytest.mark.parametrize(
    ("rung", "before", "after"),
    [
        # the low bits stay, and what did not fit is a minor fault
        ("ADD(A,1,A);", {"A": 255}, {"A": 0, "S:MINOR": True}),
        ("SUB(B,1,B);", {"B": 0}, {"B": 65535, "S:MINOR": True}),
        ("MOV(-1,C);", {}, {"C": 4_294_967_295, "S:MINOR": True}),
        ("MOV(A,Small);", {"A": 200}, {"Small": -56, "S:MINOR": True}),
        # values beyond the sign of a DINT and of a LINT are exact
        ("ADD(C,1,C);", {"C": 2_147_483_647}, {"C": 2_147_483_648, "S:MINOR": False}),
        ("ADD(D,D,D);", {"D": 2**62}, {"D": 2**63, "S:MINOR": False}),
        ("ADD(D,D,D);", {"D": 2**63}, {"D": 0, "S:MINOR": True}),
        ("MOV(D,D);", {"D": 2**64 - 1}, {"D": 2**64 - 1, "S:MINOR": False}),
        ("GRT(C,Signed)OTE(Bit);", {"C": 4_000_000_000, "Signed": 5}, {"Bit": True}),
        ("LES(Signed,C)OTE(Bit);", {"C": 1, "Signed": -1}, {"Bit": True}),
        ("MOV(C,R);", {"C": 4_294_967_295}, {"R": 4294967296.0}),
        ("MOV(R,A);", {"R": 254.6}, {"A": 255}),
        # bits and patterns
        ("XIC(B.15)OTE(Bit);", {"B": 32768}, {"Bit": True}),
        ("OTE(B.15);", {"B": 1}, {"B": 32769}),
        ("OTU(C.31);", {"C": 2**32 - 1}, {"C": 2**31 - 1}),
        ("OTE(A.[I]);", {"I": 7}, {"A": 128}),
        ("NOT(A,A);", {"A": 1}, {"A": 254, "S:MINOR": False}),
        ("XOR(B,Small,B);", {"B": 0, "Small": -1}, {"B": 255}),
        ("MVM(Signed,16#FF,A);", {"Signed": -1, "A": 0}, {"A": 255}),
        ("BTD(Signed,0,C,28,4);", {"Signed": 15}, {"C": 0xF0000000}),
        ("COP(C,Bytes,1);", {"C": 0xFF000080}, {"Bytes": [-128, 0, 0, 0, 0, 0, 0, 0]}),
        ("COP(Bytes,B,1);", {"Bytes": [-1, -2]}, {"B": 0xFEFF}),
        ("FLL(-1,A,1);", {}, {"A": 255}),
        # LREAL keeps double precision when copied; REAL would give 0.10000000149
        ("COP(L,Ls[1],1);", {}, {"Ls": [0.0, 0.1]}),
        # strings of any length
        ("EQU(Name,'abc')OTE(Bit);", {}, {"Bit": True}),
        ("CONCAT(Name,'def',Long);", {}, {"Long": "abcdef"}),
        ("UPPER(Name,Name);", {}, {"Name": "ABC"}),
        ("COP(Name,Long,1);", {}, {"Long": "abc"}),
    ],
)
def test_a_rung_on_these_types(rung, before, after):
    for engine in engines(rung):
        for name, value in before.items():
            engine.tags[name] = value
        engine.step()
        assert {name: engine.tags[name] for name in after} == after, engine


def test_a_string_of_its_own_length_is_cut_at_that():
    for engine in engines("CONCAT(Long,Long,Name);"):
        engine.tags.Long = "0123456789ABC"
        engine.step()
        assert engine.tags.Name == "0123456789ABC0123456", engine
        with pytest.raises(ValueError, match="21 characters are too long; must be at most 20"):
            engine.tags.Name = "x" * 21


@pytest.mark.parametrize(("name", "value"), [("A", 256), ("A", -1), ("D", 2**64)])
def test_what_does_not_fit_is_refused(name, value):
    with pytest.raises(ValueError, match="is out of range"):
        engines("NOP();")[0].tags[name] = value
