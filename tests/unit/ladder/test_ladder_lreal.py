"""Computing with LREAL: double precision in both back ends, and conversions to and from other types.

Expected values are Python's own floats, which are IEEE 754 doubles; a REAL would round them.
"""

import math

import pytest
from ladder_bench import Named
from scanrack.ladder.files import parse_program

TAGS = """\
TYPE Pair (X : LREAL, Y : LREAL)
TAG L : LREAL
TAG M : LREAL
TAG R : REAL
TAG D : DINT
TAG E : LINT
TAG U : ULINT
TAG S : INT
TAG Bit : BOOL
TAG I : DINT
TAG Ls : LREAL[4]
TAG P : Pair
TAG Sorting : CONTROL
TAG Name : STRING
TAG N : BOOL
TAG Z : BOOL
TAG V : BOOL
"""

SINGLE_TENTH = 0.10000000149011612
"""0.1 rounded to a REAL: the nearest of 24 bits [IEEE 754]."""


def engines(rungs):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rungs}\nEND\n")
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


def check(rungs, before, after):
    for engine in engines(rungs):
        for name, value in before.items():
            engine.tags[name] = value
        engine.step()
        found = {name: engine.tags[name] for name in after}
        assert repr(found) == repr(after), engine


@pytest.mark.parametrize(
    ("rung", "before", "after"),
    [
        ("ADD(L,0.2,L);", {"L": 0.1}, {"L": 0.1 + 0.2}),
        ("SUB(L,1,L);", {"L": 1e15}, {"L": 999999999999999.0}),
        ("MUL(L,M,L);", {"L": 0.1, "M": 3.0}, {"L": 0.1 * 3.0}),
        ("DIV(L,3,L);", {"L": 1.0}, {"L": 1 / 3}),
        ("MOD(L,0.3,L);", {"L": 1.0}, {"L": math.fmod(1.0, 0.3)}),
        ("SQR(L,L);", {"L": 2.0}, {"L": math.sqrt(2.0)}),
        ("SQR(L,R);", {"L": 2.0}, {"R": 1.4142135381698608}),
        ("NEG(L,L);", {"L": 0.1}, {"L": -0.1}),
        ("ABS(L,L);", {"L": -0.1}, {"L": 0.1}),
        ("SIN(L,L);", {"L": 1.0}, {"L": math.sin(1.0)}),
        ("XPY(L,0.5,L);", {"L": 2.0}, {"L": 2.0**0.5}),
        ("DEG(L,L);", {"L": 1.0}, {"L": 180 / math.pi}),
        # the destination counts: 1/3 of two DINTs into an LREAL, a product of REALs beyond REAL
        ("DIV(D,3,L);", {"D": 1}, {"L": 1 / 3}),
        ("MUL(R,R,L);", {"R": 2.0**100}, {"L": 2.0**200, "S:MINOR": False}),
        ("CPT(L,R+0.1);", {"R": 0.5}, {"L": 0.6}),
        ("CPT(L,(D AND 6)*M);", {"D": 7, "M": 0.1}, {"L": 6 * 0.1}),
        ("CPT(D,L*10.0);", {"L": 0.25}, {"D": 2}),
        ("CPT(L,SQR(M)+ABS(D));", {"M": 2.0, "D": -1}, {"L": math.sqrt(2.0) + 1}),
        ("CPT(L,Ls[I]*Ls[I+1]);", {"Ls": [0.0, 0.1, 0.2, 0.0], "I": 1}, {"L": 0.1 * 0.2}),
        ("CPT(P.Y,P.X/3.0);", {"P.X": 1.0}, {"P.Y": 1 / 3}),
        # integers are raised in double precision: a REAL would give 129140160
        ("XPY(D,17,E);", {"D": 3}, {"E": 129140163}),
        # conversions: half to even, low bits stay, and what does not fit is a minor fault
        ("MOV(0.1,L);", {}, {"L": 0.1}),
        ("MOV(0.1,R)MOV(R,L);", {}, {"L": SINGLE_TENTH}),
        ("MOV(L,R);", {"L": 0.1}, {"R": SINGLE_TENTH, "S:MINOR": False}),
        ("MOV(L,R);", {"L": 16_777_217.0}, {"R": 16_777_216.0}),
        ("MOV(L,R);", {"L": 16_777_219.0}, {"R": 16_777_220.0}),
        ("MOV(L,R);", {"L": 1e39}, {"R": math.inf, "S:MINOR": True}),
        ("MOV(L,R);", {"L": math.inf}, {"R": math.inf, "S:MINOR": False}),
        ("MOV(D,L);", {"D": 2**31 - 1}, {"L": 2147483647.0}),
        ("MOV(E,L);", {"E": 2**53 + 1}, {"L": 2.0**53}),
        ("MOV(E,L);", {"E": 2**53 + 3}, {"L": 2.0**53 + 4}),
        ("MOV(U,L);", {"U": 2**64 - 1}, {"L": 2.0**64}),
        ("MOV(L,D);", {"L": 2.5}, {"D": 2}),
        ("MOV(L,D);", {"L": 3.5}, {"D": 4}),
        ("MOV(L,D);", {"L": -2.5}, {"D": -2}),
        ("MOV(L,D);", {"L": 2147483647.0}, {"D": 2**31 - 1, "S:MINOR": False}),
        ("MOV(L,S);", {"L": 65_665.0}, {"S": 129, "S:MINOR": True}),
        ("MOV(L,E);", {"L": 2.0**53 + 2}, {"E": 2**53 + 2}),
        ("MOV(L,D);", {"L": math.nan}, {"D": 0, "S:MINOR": True}),
        ("TRN(L,D);", {"L": -357.06}, {"D": -357}),
        ("TRN(L,D);", {"L": 1e300}, {"D": 0, "S:MINOR": True}),
        ("TRN(L,R);", {"L": 1e300}, {"R": math.inf, "S:MINOR": True}),
        ("TRN(L,M);", {"L": 1e300}, {"M": 1e300, "S:MINOR": False}),
        ("CLR(L);", {"L": 0.1}, {"L": 0.0}),
        # faults
        ("DIV(L,0,L);", {"L": 1.0}, {"L": math.inf, "S:MINOR": True}),
        ("MUL(L,L,L);", {"L": 1e200}, {"L": math.inf, "S:MINOR": True}),
        ("MUL(L,L,L);", {"L": 1e150}, {"L": 1e150 * 1e150, "S:MINOR": False}),
        ("XPY(L,3,L);", {"L": -1e200}, {"L": -math.inf, "S:MINOR": True}),
        ("LN(L,L);", {"L": -1.0}, {"L": math.nan, "S:MINOR": True}),
        # comparisons
        ("GRT(L,0.1)OTE(Bit);", {"L": 0.1 + 1e-12}, {"Bit": True}),
        ("EQU(L,R)OTE(Bit);", {"L": 0.1, "R": 0.1}, {"Bit": False}),
        ("EQU(L,0.1)OTE(Bit);", {"L": 0.1}, {"Bit": True}),
        ("EQU(L,E)OTE(Bit);", {"L": 2.0**53, "E": 2**53 + 1}, {"Bit": True}),
        ("LIM(0.1,L,0.2)OTE(Bit);", {"L": 0.1}, {"Bit": True}),
        ("CMP(L>M+0.1)OTE(Bit);", {"L": 0.30000000000000010, "M": 0.2}, {"Bit": True}),
        # arrays and strings
        ("FLL(0.1,Ls,2);", {}, {"Ls": [0.1, 0.1, 0.0, 0.0]}),
        ("AVE(Ls,0,L,Sorting,4,0);", {"Ls": [0.1, 0.2, 0.3, 0.4], "Sorting.LEN": 4}, {"L": 0.25}),
        ("SRT(Ls,0,Sorting,4,0);", {"Ls": [3.0, 0.1, 2.0], "Sorting.LEN": 4}, {"Ls": [0.0, 0.1, 2.0, 3.0]}),
        ("STOR(Name,L);", {"Name": "0.1"}, {"L": 0.1}),
        # the flags
        ("SUB(L,0.1,L)XIC(S:Z)OTE(Z);", {"L": 0.1}, {"Z": True}),
        ("SUB(L,0.2,L)XIC(S:N)OTE(N);", {"L": 0.1}, {"N": True}),
        ("MOV(L,D)XIC(S:V)OTE(V);", {"L": 1e10}, {"V": True, "D": 1410065408}),
        ("MOV(L,R)XIC(S:V)OTE(V);", {"L": 1e39}, {"V": True}),
    ],
)  # fmt: skip
def test_a_rung_on_lreal(rung, before, after):
    check(rung, before, after)


@pytest.mark.parametrize(
    ("statement", "before", "after"),
    [
        ("L := L / 3;", {"L": 1.0}, {"L": 1 / 3}),
        ("P.X := R; P.Y := P.X + 0.1;", {"R": 0.5}, {"P.X": 0.5, "P.Y": 0.6}),
        ("IF L > 0.1 THEN D := L * 10.0; END_IF;", {"L": 0.35}, {"D": 4}),
        ("CASE D OF 1: L := 0.1; END_CASE;", {"D": 1}, {"L": 0.1}),
    ],
)
def test_structured_text(statement, before, after):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main ST\n{statement}\nEND\n")
    for engine in (Named("compiled", program.compile()), Named("interpreted", program.interpret())):
        for name, value in before.items():
            engine.tags[name] = value
        engine.step()
        assert {name: engine.tags[name] for name in after} == after, engine


@pytest.mark.parametrize(
    ("rungs", "before", "after"),
    [
        ("JSR(Half,1,L,M);\nEND\nROUTINE Half\nSBR(P.X)DIV(P.X,2,P.Y)RET(P.Y);", {"L": 0.1}, {"M": 0.05}),
        ("JSR(Half,1,0.1,M);\nEND\nROUTINE Half\nSBR(P.X)RET(P.X);", {}, {"M": 0.1}),
        (
            "JSR(Half,1,L,R);\nEND\nROUTINE Half\nSBR(P.X)RET(P.X);",
            {"L": 1e39},
            {"R": math.inf, "S:MINOR": True},
        ),
    ],
)
def test_a_parameter(rungs, before, after):
    check(rungs, before, after)
