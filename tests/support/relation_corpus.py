"""A corpus of rungs in the manner of real machines, for the comparison of relation and interpreter.

Stations with their structures, recipes copied by subscript, strings of labels, faults in a log, an add-on
instruction for each valve, sequences of steps, averages over a ring. Sizes and details differ from program to
program; `corpus` has more than a thousand rungs.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random
from typing import Any

from scanrack.ladder.files import parse_program

STATIONS = 4

HEAD = """PROGRAM machine
ALLOW repeated coils
ALLOW repeated timers
TYPE Recipe (Name : STRING, Length : DINT, Speed : REAL, Holes : INT[4], Glue : BOOL, Check : BOOL)
TYPE Station (Step : DINT, Run : BOOL, Done : BOOL, Fault : BOOL, Count : DINT, Rate : REAL, Dwell : TIMER)
TYPE Entry (Code : INT, At : DINT, Text : STRING, Open : BOOL)
INSTRUCTION Valve
INPUT Open : BOOL REQUIRED
INPUT Feedback : BOOL REQUIRED
OUTPUT Coil : BOOL
OUTPUT Late : BOOL
INOUT Log : Entry
LOCAL Watch : TIMER
LOCAL Faults : DINT
ROUTINE Logic
XIC(Open)XIO(Late)OTE(Coil);
XIC(Coil)XIO(Feedback)TON(Watch,{watch},0)XIC(Watch.DN)OTL(Late);
XIC(Late)ONS(Log.Open)ADD(Faults,1,Faults);
XIC(Late)[MOV({code},Log.Code),MOV(Faults,Log.At)];
XIO(Open)OTU(Late);
END
ROUTINE EnableInFalse
OTU(Coil);
END
ROUTINE Prescan
OTU(Late);
END
END INSTRUCTION
TAG Recipes : Recipe[5]
TAG Now : Recipe
TAG St : Station[{stations}]
TAG Log : Entry[6]
TAG Valves : Valve[{stations}]
TAG Raw : SINT[64]
TAG Ring : REAL[8]
TAG Fifo : DINT[8]
TAG Q : CONTROL
TAG Ix : DINT
TAG Slot : DINT
TAG Sum : REAL
TAG Mean : REAL
TAG Label : STRING
TAG Part : STRING
TAG Number : DINT
TAG Word : INT
TAG Mode : DINT
TAG Auto : BOOL
TAG Stop : BOOL
TAG Ack : BOOL
TAG Sensor : BOOL[16]
TAG Lamp : BOOL[16]
TAG Edge : BOOL[16]
TAG Shift : TIMER
TAG Pieces : COUNTER
ROUTINE Main
[LES(Ix,0),GRT(Ix,3)]MOV(0,Ix);
[LES(Slot,0),GRT(Slot,5)]MOV(0,Slot);
"""


def _station(draw: Random, n: int) -> Iterator[str]:
    """Yield the rungs of a station: a sequence of steps, its dwell, its faults, its numbers."""
    at, step, sensor, lamp = f"St[{n}]", f"St[{n}].Step", draw.randrange(16), draw.randrange(16)
    dwell, feedback, entry = draw.choice((20, 100, 500)), draw.randrange(16), draw.randrange(6)
    low, high = sorted(draw.sample(range(1, 40), 2))
    yield f"XIC(Auto)XIO(Stop)XIO(St[{n}].Fault)OTE(St[{n}].Run);"
    yield f"XIO(St[{n}].Run)[MOV(0,{step}),OTU(St[{n}].Done)];"
    yield f"XIC(St[{n}].Run)EQU({step},0)XIC(Sensor[{sensor}])MOV(10,{step});"
    yield f"EQU({step},10)TON({at}.Dwell,{dwell},0)XIC({at}.Dwell.DN)MOV(20,{step});"
    yield f"EQU({step},20)[XIC(Sensor[{(sensor + 1) % 16}])MOV(30,{step}),XIC({at}.Dwell.TT)OTL({at}.Fault)];"
    yield f"EQU({step},30)ONS(Edge[{n}])[ADD(St[{n}].Count,1,St[{n}].Count),OTL(St[{n}].Done),MOV(0,{step})];"
    yield f"LIM({low},St[{n}].Count,{high})XIC(St[{n}].Run)OTE(Lamp[{lamp}]);"
    yield f"XIC(St[{n}].Done)CPT(St[{n}].Rate,St[{n}].Count*Now.Speed/(Now.Length+1));"
    yield f"XIC(Ack)[OTU(St[{n}].Fault),OTU(St[{n}].Done)];"
    yield f"XIC(St[{n}].Run)Valve(Valves[{n}],{at}.Done,Sensor[{feedback}],Log[{entry}]);"
    yield f"XIC(Valves[{n}].Late)[OTL(St[{n}].Fault),COP(Log[{draw.randrange(5)}],Log[5],1)];"


_ELSEWHERE = (
    "XIC(Ack)ONS(Edge[15])COP(Recipes[Ix],Now,1);",
    "XIC(Ack)COP(Now,Recipes[Ix],1);",
    "COP(St[Ix].Step,Raw[8],1);",
    "XIC(Auto)COP(Now.Holes[0],Raw[0],8);",
    "XIC(Stop)COP(Raw[0],Now.Holes[0],4);",
    "XIC(Stop)FLL(0,Ring[0],8);",
    "MOV(St[Ix].Rate,Ring[Slot]);",
    "CPT(Sum,Ring[0]+Ring[1]+Ring[2]+Ring[3]);",
    "DIV(Sum,4.0,Mean);",
    "GRT(Mean,Now.Speed)OTE(Lamp[3]);",
    "XIC(Sensor[2])ONS(Edge[14])FFL(Number,Fifo[0],Q,?,?);",
    "XIC(Sensor[3])FFU(Fifo[0],Number,Q,?,?);",
    "XIC(Sensor[4])BSL(Fifo[0],Q,Sensor[5],?);",
    "DTOS(Number,Part);",
    "CONCAT(Now.Name,Part,Label);",
    "EQU(Label,Part)OTE(Lamp[4]);",
    "FIND(Label,'-',1,Slot);",
    "XIC(Ack)STOD(Part,Number);",
    "UPPER(Now.Name,Label);",
    "MID(Label,3,Slot,Part);",
    "BTD(Word,4,Number,0,6);",
    "MVM(Word,255,Mode);",
    "AND(Word,15,Mode);",
    "XIC(Word.3)OTE(Word.7);",
    "XIC(Mode.[Ix])OTL(Number.[Slot]);",
    "XIC(Sensor[Ix])OTE(Lamp[Slot]);",
    "SWPB(Word,REVERSE,Number);",
    "XIC(Auto)RTO(Shift,28800000,0);",
    "XIC(Ack)RES(Shift);",
    "XIC(Sensor[6])CTU(Pieces,100,0);",
    "XIC(Pieces.DN)RES(Pieces);",
    "CMP(Now.Length*2>Number+Now.Holes[Ix])OTE(Lamp[5]);",
    "XIC(Now.Glue)XIO(Now.Check)OTE(Lamp[6]);",
    "SIN(Mean,Sum);",
    "XIC(Ack)SQO(Fifo[0],255,Mode,Q,?,?);",
    "XIC(Stop)RTOS(Mean,Part);",
    "MEQ(Word,240,Mode)OTE(Lamp[7]);",
    "SUB(Now.Length,St[Ix].Count,Number);",
    "JSR(Report,1,Number,Mode);",
)

_REPORT = (
    *("ROUTINE Report", "SBR(Number)NOP();", "GRT(Number,1000)RET(3);", "ADD(Mode,1,Mode);", "RET(Mode);"),
    "END",
)


def machine_text(seed: int) -> str:
    """Return the program of a seed."""
    draw = Random(seed)
    head = HEAD.format(watch=draw.choice((50, 200)), code=draw.randrange(1, 900), stations=STATIONS)
    rungs = [rung for n in range(STATIONS) for rung in _station(draw, n)]
    rungs += draw.sample(_ELSEWHERE, 24)
    kept = draw.sample(range(len(rungs)), 30)
    return head + "\n".join([*(rungs[at] for at in sorted(kept)), "END", *_REPORT, ""])


def corpus(programs: int = 40) -> Iterator[Any]:
    """Yield programs: forty of them have more than a thousand rungs."""
    for seed in range(programs):
        yield parse_program(machine_text(seed))
