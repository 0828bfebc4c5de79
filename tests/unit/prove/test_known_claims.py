"""Claims of which a person knows that they are false: none is proved, all are refuted.

`.ci/lowest` runs this file, too: verdicts are the same with each version of the solver.
"""

from __future__ import annotations

import pytest
from scanrack.ladder.files import parse_program

pytestmark = [pytest.mark.extra("prove"), pytest.mark.slow]

BITS = """TAG A : BOOL
TAG B : BOOL
TAG C : BOOL
TAG X : BOOL
TAG Y : BOOL
TAG Z : BOOL
TAG S : BOOL
TAG N : DINT
TAG M : DINT
TAG I : INT
TAG R : REAL
TAG T : TIMER
TAG U : TIMER
TAG K : COUNTER
TAG Arr : DINT[4]
"""

CASES: tuple[tuple[str, str, str], ...] = (
    # rungs; claims that never hold; claims that some run makes true
    (
        "XIC(A)XIO(Y)OTE(X);\nXIC(B)XIO(X)OTE(Y);",
        "X AND Y|X AND NOT A|Y AND NOT B",
        "X|Y|NOT X AND NOT Y|old(X) AND Y",
    ),
    (
        "[XIC(A),XIC(X)]XIO(B)OTE(X);",
        "X AND B|X AND NOT A AND NOT old(X)",
        "X AND NOT A|old(X) AND NOT X|old(X) AND NOT B AND NOT X",
    ),
    (
        "XIC(A)OTL(X);\nXIC(B)OTU(X);",
        "X AND B|old(X) AND NOT X AND NOT B",
        "X AND NOT A|X AND old(X)|NOT X AND old(X)",
    ),
    (
        "XIC(A)TON(T,500,0);\nXIC(T.DN)OTE(X);",
        "X AND NOT A|X AND T.ACC < 500|T.TT AND T.DN|T.ACC < 0",
        "X|T.TT AND T.ACC > 300|A AND NOT X|T.ACC > 500",
    ),
    (
        "XIC(A)TOF(T,500,0);\nXIC(T.DN)OTE(X);",
        "A AND NOT X|T.TT AND NOT T.DN",
        "X AND NOT A|NOT X AND NOT A|T.TT",
    ),
    (
        "XIC(A)RTO(T,300,0);\nXIC(B)RES(T);\nXIC(T.DN)OTE(X);",
        "X AND B|X AND T.ACC < 300",
        "X AND NOT A|T.ACC > 100 AND NOT A|B AND A",
    ),
    (
        "XIC(A)CTU(K,3,0);\nXIC(K.DN)OTE(X);\nXIC(B)RES(K);",
        "K.DN AND K.ACC < 3|K.ACC < 0",
        "K.ACC = 3|X|K.ACC > 3|X AND NOT K.DN",
    ),
    (
        "XIC(A)ONS(S)ADD(N,1,N);\nGRT(N,4)CLR(N);",
        "N > 4|N < 0|N > old(N) + 1|N > old(N) AND NOT A",
        "N = 4|N = 0 AND old(N) = 4|N = old(N) AND A",
    ),
    (
        "LIM(0,I,3)MOV(I,N);\nXIC(A)MOV(N,M);",
        "N < 0|N > 3|M > 3",
        "N = 3|M = 2 AND N = 1|I > 3 AND N = 2",
    ),
    (
        "ADD(I,1,N);",
        "N > 32768|N < -32767",
        "N = 32768|N = 0|N = -32767",
    ),
    (
        "ADD(I,I,M);\nMUL(I,I,N);",
        "N < 0|M = 7|N = 3",
        "N = 4|M = -4|N > 1000000",
    ),
    (
        "XIC(A)JMP(Far);\nOTE(X);\nLBL(Far)OTE(Y);",
        "NOT Y",
        "X|NOT X|old(X) AND A AND X",
    ),
    (
        "XIC(A)JSR(Sub,1,3,N);\nXIC(B)JSR(Sub,1,5,N);",
        "N = 5|N = 4|N < 0|N > 10",
        "N = 6|N = 10|N = 0",
    ),
    (
        "[XIC(A),XIC(B)][XIC(C)OTE(X),XIO(C)OTE(Y)];",
        "X AND Y|X AND NOT C|Y AND C|X AND NOT A AND NOT B",
        "X|Y|X AND NOT A|Y AND NOT B",
    ),
    (
        "XIC(A)FLL(7,Arr[0],2);\nXIC(B)COP(Arr[0],Arr[2],2);",
        "Arr[3] = 6|Arr[2] = 7 AND Arr[0] = 0|Arr[3] = 7 AND Arr[2] = 0",
        "Arr[3] = 7|Arr[0] = 7 AND Arr[2] = 0",
    ),
    (
        "AND(I,15,N);\nXIC(N.3)OTE(X);\nOR(N,16,M);",
        "N > 15|N < 0|X AND N < 8|M < 16|M > 31",
        "X|N = 15|M = 31|NOT X AND N = 7",
    ),
    (
        "XIC(S:FS)OTE(X);\nXIC(X)MOV(9,N);",
        "N <> 9|X AND old(X)",
        "X|NOT X",
    ),
    (
        "XIC(A)OSR(S,X);\nXIC(X)OTL(Y);\nXIC(B)OTU(Y);",
        "X AND NOT A|X AND old(X)|Y AND B",
        "X|Y AND NOT A|A AND NOT X",
    ),
    (
        "XIC(A)TON(T,200,0);\nXIC(A)TON(U,400,0);",
        "U.DN AND NOT T.DN|U.DN AND NOT A",
        "T.DN AND NOT U.DN|U.DN AND T.DN",
    ),
    (
        "DIV(I,4,N);\nMOD(I,4,M);",
        "M > 3|M < -3|N > 8191|N < -8192|M = 1 AND I < 0",
        "M = 3|M = -3|N = -8192|N = 8191",
    ),
)

FALSE_ONES = [(rungs, each) for rungs, _, reached in CASES for each in reached.split("|")]


def program(rungs: str):
    sub = "ROUTINE Sub\nSBR(M)NOP();\nADD(M,M,M);\nRET(M);\nEND\n"
    text = f"PROGRAM known\nALLOW repeated coils\n{BITS}ROUTINE Main\n{rungs}\nEND\n"
    return parse_program(text + (sub if "JSR" in rungs else ""))


def test_no_false_claim_is_proved() -> None:
    assert len(FALSE_ONES) >= 60
    words = {each: program(each[0]).prove(never=each[1], free=["I"]).word for each in FALSE_ONES}
    assert [each for each, word in words.items() if word == "proved"] == []
    assert [each for each, word in words.items() if word == "unknown"] == []
