"""Claims of which a person knows that they are true: none is refuted, and nearly all are proved.

Each is a small machine and what never happens on it, derived by hand: through the key, which drops coils and
keeps latches and numbers, and with any input in any scan. `.ci/lowest` runs this file, too: verdicts are the
same with each version of the solver.
"""

from __future__ import annotations

import re

import pytest
from scanrack.ladder.files import parse_program

pytestmark = [pytest.mark.extra("prove"), pytest.mark.slow]

MOST_UNDECIDED = 3

RUNGS: tuple[tuple[str, str], ...] = (
    # what the rungs are; what never holds
    ("[XIC(Start),XIC(Run)]XIO(Stop)XIO(Trip)OTE(Run);", "Run AND Trip"),
    ("XIC(Left)XIC(Right)XIO(Door)OTE(Press);", "Press AND (NOT Left OR NOT Right OR Door)"),
    (
        "XIC(Fan)XIO(Flow)TON(T,3000,0);\nXIC(T.DN)OTL(Alarm);\nXIC(Reset)XIO(T.DN)OTU(Alarm);",
        "T.DN AND NOT Alarm",
    ),
    ("XIC(Low)OTL(Fill);\nXIC(High)OTU(Fill);", "Fill AND High"),
    (
        "XIC(Tick)ONS(S)ADD(N,1,N);\nGEQ(N,3)CLR(N);\n"
        "EQU(N,0)OTE(Red);\nEQU(N,1)OTE(Green);\nEQU(N,2)OTE(Amber);",
        "Red AND Green OR NOT Red AND NOT Green AND NOT Amber",
    ),
    ("XIC(Need)XIO(Second)OTE(One);\nXIC(Need)XIC(Second)OTE(Two);", "One AND Two"),
    ("XIC(Air)XIC(Oil)OTE(Ready);\nXIC(Ready)XIC(Go)OTE(Run);", "Run AND NOT Oil"),
    (
        # program mode drops Full and sets the storage of the one-shot: the next part does not count twice
        "XIO(Full)XIC(Part)ONS(S)ADD(N,1,N);\nXIC(Full)XIC(Ack)CLR(N);\nGEQ(N,12)OTE(Full);",
        "N > 12",
    ),
    (
        "LES(N,5)XIC(Enter)ONS(S)ADD(N,1,N);\nGRT(N,0)XIC(Leave)ONS(U)SUB(N,1,N);",
        "N < 0 OR N > 5",
    ),
    ("XIC(Test)TON(T,2000,0);\nXIC(T.TT)OTE(Lamp);", "Lamp AND NOT Test"),
    ("XIC(Run)RTO(T,1000,0);\nXIC(T.DN)ADD(N,1,N);\nXIC(T.DN)RES(T);", "T.DN"),
    ("XIC(Part)CTU(K,10,0);\nXIC(K.DN)RES(K);", "K.ACC >= 10"),
    ("XIC(Enter)CTU(K,5,0);\nXIC(Leave)CTD(K,5,0);", "K.DN AND NOT K.OV AND K.ACC < 5"),
    (
        "XIO(Estop)OTL(Tripped);\nXIC(Reset)XIC(Estop)OTU(Tripped);\nXIC(Go)XIO(Tripped)OTE(Power);",
        "Power AND NOT Estop",
    ),
    ("XIC(One)XIO(Two)OTE(Auto);\nXIC(Two)XIO(One)OTE(Hand);", "Auto AND Hand"),
    (
        "XIC(A)XIO(FirstB)OTL(FirstA);\nXIC(B)XIO(FirstA)OTL(FirstB);\n"
        "XIC(Reset)OTU(FirstA);\nXIC(Reset)OTU(FirstB);",
        "FirstA AND FirstB",
    ),
    ("MOV(Given,N);\nGRT(N,100)MOV(100,N);\nLES(N,0)CLR(N);", "N < 0 OR N > 100"),
    ("LES(N,Given)ADD(N,1,N);\nGRT(N,100)MOV(100,N);", "N > 100"),
    (
        "XIC(Eye)XIC(Run)TON(T,1000,0);\nXIC(T.DN)OTL(Jam);\nXIC(Ack)OTU(Jam);\nXIC(Go)XIO(Jam)OTE(Run);",
        "Run AND Jam",
    ),
    ("XIC(Go)OTE(Run);\nXIO(Guard)OTU(Run);", "Run AND NOT Guard"),
    ("XIC(Any)TON(T,1500,0)XIC(T.DN)OTE(Horn);", "Horn AND NOT Any"),
    ("XIC(Read)COP(In[0],Kept[0],3);\nXIO(Read)FLL(0,Kept[0],3);", "Kept[1] <> 0 AND NOT Read"),
    ("AND(Given,7,N);\nXIC(N.3)OTE(Lamp);", "Lamp"),
    ("MUL(Short,10,N);", "N > 327670 OR N < -327680"),
    ("MOD(Given,8,N);", "N > 7 OR N < -7"),
    ("LIM(10,Short,20)OTE(Lamp);", "Lamp AND (Short < 10 OR Short > 20)"),
    ("XIC(Guard)MCR();\nXIC(Go)OTE(Run);\nMCR();", "Run AND NOT Guard"),
    ("XIC(Skip)JMP(Far);\nXIC(A)OTL(Lamp);\nLBL(Far)XIC(Skip)OTU(Lamp);", "Lamp AND Skip"),
    ("XIC(Button)OSR(S,Pulse);\nXIC(Pulse)ADD(N,1,N);\nGRT(N,9)CLR(N);", "Pulse AND NOT Button OR N > 9"),
    ("XIO(T.DN)TON(T,1000,0);\nLES(T.ACC,400)XIC(Call)OTE(Heat);", "Heat AND T.ACC >= 400"),
    ("XIC(Go)TON(T,1000,0);\nXIC(T.DN)TON(W,1000,0);", "W.DN AND NOT T.DN"),
    ("XIC(Go)TON(T,1000,0);", "T.DN AND T.ACC < 1000"),
)

STATEMENTS: tuple[tuple[str, str], ...] = (
    ("IF Start AND NOT Stop THEN Run := 1; ELSIF Stop THEN Run := 0; END_IF;", "Run AND Stop"),
    ("N := Given; IF N > 100 THEN N := 100; END_IF; IF N < 0 THEN N := 0; END_IF;", "N < 0 OR N > 100"),
    (
        "N := 0; FOR At := 0 TO 3 DO IF In[At] > 0 THEN N := N + 1; END_IF; END_FOR;",
        "N < 0 OR N > 4",
    ),
    (
        "N := In[0]; FOR At := 1 TO 3 DO IF In[At] > N THEN N := In[At]; END_IF; END_FOR;",
        "N < In[2]",
    ),
    ("IF In[0] > In[1] THEN N := In[1]; M := In[0]; ELSE N := In[0]; M := In[1]; END_IF;", "N > M"),
    (
        "IF Pulse AND NOT Was THEN N := N + 1; END_IF; IF N >= 6 THEN N := 0; END_IF; Was := Pulse;",
        "N < 0 OR N > 5",
    ),
    ("Lamp := A XOR B; Horn := A AND B;", "Lamp AND Horn"),
    ("N := ABS(Short);", "N < 0 OR N > 32768"),
    (
        "IF Given > 80 THEN Cool := 1; ELSIF Given < 70 THEN Cool := 0; END_IF;",
        "Cool AND Given < 70 OR NOT Cool AND Given > 80",
    ),
    ("One := A AND NOT B; Two := B;", "One AND Two"),
    ("IF N < Given THEN N := N + 2; END_IF; IF N > Given THEN N := Given; END_IF;", "N > Given"),
    ("N := Given; One := N.0; Two := NOT N.0;", "One AND Two OR NOT One AND NOT Two"),
    (
        "IF Push AND N < 8 THEN N := N + 1; END_IF; IF Pop AND N > 0 THEN N := N - 1; END_IF;",
        "N < 0 OR N > 8",
    ),
    ("Rate := Raw * 0.5; IF Rate > 50.0 THEN Rate := 50.0; END_IF;", "Rate > 50.0"),
    ("N := Short + Short;", "N > 65534 OR N < -65536"),
    ("IF A THEN Lamp := 1; END_IF; IF Reset THEN Lamp := 0; END_IF;", "Lamp AND Reset"),
    ("One := Given = 1; Two := Given = 2; Lamp := One OR Two;", "One AND Two OR Lamp AND Given > 2"),
)

ROUND = (
    "0: IF Go THEN Step := 1; END_IF; 1: IF Done THEN Step := 2; END_IF; 2: IF Ack THEN Step := 0; END_IF;"
)

DRILL = """EQU(Step,0)XIC(Start)MOV(10,Step);
EQU(Step,10)XIC(Clamped)MOV(20,Step);
EQU(Step,20)XIC(Deep)MOV(30,Step);
EQU(Step,30)XIC(Top)MOV(0,Step);
GEQ(Step,10)OTE(Clamp);
EQU(Step,20)OTE(Down);"""

RING = """XIC(S:FS)[OTL(First),OTU(Second),OTU(Third)];
XIC(First)XIC(A)[OTU(First),OTL(Second)];
XIC(Second)XIC(B)[OTU(Second),OTL(Third)];
XIC(Third)XIC(C)[OTU(Third),OTL(First)];"""

STEPS: tuple[tuple[str, str], ...] = (
    (f"CASE Step OF {ROUND} ELSE Step := 0; END_CASE;", "Step < 0 OR Step > 2"),
    (
        f"CASE Step OF {ROUND} END_CASE; Clamp := Step >= 1; Down := Step = 2;",
        "Down AND NOT Clamp",
    ),
    (DRILL, "Step <> 0 AND Step <> 10 AND Step <> 20 AND Step <> 30"),
    (DRILL, "Down AND NOT Clamp"),
    (RING, "First AND Second OR Second AND Third OR Third AND First"),
    (RING, "NOT First AND NOT Second AND NOT Third"),
    (
        "EQU(Step,2)XIC(Ack)MOV(0,Step);\nEQU(Step,0)XIC(Go)MOV(1,Step);\nEQU(Step,1)TON(T,2000,0);\n"
        "EQU(Step,1)XIC(T.DN)MOV(2,Step);\nEQU(Step,2)OTE(Done);",
        "Step = 2 AND NOT Done OR Step > 2",
    ),
    (
        "EQU(Step,99)XIC(Reset)XIO(Stop)MOV(0,Step);\nEQU(Step,0)XIC(Go)MOV(1,Step);\n"
        "EQU(Step,1)XIC(A)MOV(2,Step);\nGRT(Step,0)XIC(Stop)MOV(99,Step);",
        "Stop AND Step > 0 AND Step < 99",
    ),
    ("XIC(Part)XIO(Full)OTL(Full);\nXIC(Take)XIC(Full)OTU(Full);", "Full AND Take"),
    (
        "CASE Step OF 0: IF Go THEN Step := 1; N := 0; END_IF;"
        "1: N := N + 1; IF N >= 20 THEN Step := 2; END_IF; 2: IF Door THEN Step := 0; END_IF; END_CASE;",
        "Step = 1 AND N >= 20",
    ),
    (
        "XIC(OpenA)XIO(Outer)OTL(Inner);\nXIC(CloseA)OTU(Inner);\n"
        "XIC(OpenB)XIO(Inner)OTL(Outer);\nXIC(CloseB)OTU(Outer);",
        "Inner AND Outer",
    ),
    (
        "EQU(Step,0)XIC(Go)MOV(1,Step);\nEQU(Step,1)XIC(Hot)MOV(2,Step);\nEQU(Step,2)XIC(Cold)MOV(0,Step);\n"
        "EQU(Step,1)OTE(Heat);\nEQU(Step,2)OTE(Cool);",
        "Heat AND Cool",
    ),
    (
        "EQU(Step,90)XIC(Ack)MOV(0,Step);\nEQU(Step,0)XIC(Go)MOV(1,Step);\nEQU(Step,1)TON(T,5000,0);\n"
        "EQU(Step,1)XIC(T.DN)MOV(90,Step);\nEQU(Step,90)OTE(Alarm);",
        "Alarm AND Step <> 90",
    ),
)

CASES = (*RUNGS, *STATEMENTS, *STEPS)

NUMBERS = {
    **dict.fromkeys(("N", "M", "Step", "At", "Given"), "DINT"),
    **dict.fromkeys(("T", "W"), "TIMER"),
    **dict.fromkeys(("Rate", "Raw"), "REAL"),
    **dict.fromkeys(("In", "Kept"), "DINT[4]"),
    "Short": "INT",
    "K": "COUNTER",
}
"""Types of the names that are no bits; `FREE` come from outside."""

FREE = ("Given", "Short", "In", "Raw")

TAG = re.compile(r"(?<![\w.:])[A-Z]\w*[a-z]\w*|\b[A-Z]\b(?![\w:])")


def program(text: str):
    statements = ":=" in text
    names = sorted(set(TAG.findall(text)) - {"Far"})
    tags = "".join(f"TAG {each} : {NUMBERS.get(each, 'BOOL')}\n" for each in names)
    kind = " ST" if statements else ""
    return parse_program(
        f"PROGRAM true\nALLOW repeated coils\n{tags}ROUTINE Main{kind}\n{text}\nEND\n"
    ), names


def test_no_true_claim_is_refuted_and_nearly_all_are_proved() -> None:
    assert len(CASES) >= 60
    words = {}
    for each in CASES:
        checked, names = program(each[0])
        free = [name for name in FREE if name in names]
        words[each] = checked.prove(never=each[1], free=free).word
    assert [each for each, word in words.items() if word == "refuted"] == []
    assert sum(word != "proved" for word in words.values()) <= MOST_UNDECIDED, words
