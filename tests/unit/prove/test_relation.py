"""The terms of a scan give what the interpreter computes."""

from random import Random

from relation import Relation
from scanrack.ladder.files.rungfile import parse_program

HEAD = """PROGRAM small
TAG A : BOOL
TAG B : BOOL
TAG T : TIMER
TAG C : COUNTER
TAG X : DINT
TAG R : REAL
TAG Arr : DINT[5]
ROUTINE Main
"""


def relation(*rungs: str, more: str = "") -> Relation:
    return Relation(parse_program(f"{HEAD}{chr(10).join(rungs)}\nEND\n{more}"))


def test_a_program_of_common_instructions_equals_the_interpreter() -> None:
    found = relation(
        "XIC(A)XIO(B)OTE(B);",
        "XIC(A)TON(T,100,0)XIC(T.DN)CTU(C,5,0);",
        "GRT(X,2)ADD(X,1,X);",
        "MOV(X,Arr[X]);",
        "[XIC(T.TT),LIM(2,X,9)]MUL(R,2.5,R);",
        "JSR(Sub,1,X,X);",
        "XIC(A)CPT(X,X*3+Arr[2]/X);",
        more="ROUTINE Sub\nSBR(Arr[1])XIC(B)ADD(Arr[1],1,Arr[1]);\nRET(Arr[1]);\nEND\n",
    )
    assert found.differences(Random(1), 40) == []
    assert found.machine.cut == []
