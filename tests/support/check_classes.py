"""Classes of mistakes for `scanrack check`: programs that have one, each beside one that does not.

A row is the name of a file, the text with the mistake, what replaces a part of it in the sound program, and
the line that the finding names.
"""

# ruff: noqa: E501 - one row is one rung

from __future__ import annotations

from typing import NamedTuple

import l5x_files as l5x
from check_programs import BLOCKS, SEQUENCE, USED


class Case(NamedTuple):
    """A program with a mistake; without it, once each pair of `mended` is replaced."""

    rule: str
    name: str
    text: str
    at: str
    mended: tuple[tuple[str, str], ...]

    @property
    def sound(self) -> str:
        """The program without the mistake."""
        text = self.text
        for old, new in self.mended:
            assert old in text, (self.rule, old)
            text = text.replace(old, new)
        return text


Row = tuple[str, str, str, tuple[tuple[str, str], ...]]
NAMES = """\
ALIAS Start : Local:2:I.Data.0
ALIAS Reset : Local:2:I.Data.1
ALIAS Part : Local:2:I.Data.2
ALIAS Lamp : Local:3:O.Data.0
"""


def rungs(tags: str, text: str, more: str = "", kind: str = "") -> str:
    """A program of rungs, or of structured text."""
    declared = "".join(f"TAG {each.strip()}\n" for each in tags.split(";"))
    return f"PROGRAM line\n{NAMES}{declared}ROUTINE Main{kind}\n{text}\nEND\n{more}"


def text(tags: str, body: str, more: str = "") -> str:
    """A program of structured text."""
    return rungs(tags, body, more, " ST")


def slc(*lines: str, data: str = "") -> str:
    """An SLC program."""
    body = "".join(f"SOR {each} EOR\n" for each in lines)
    slots = 'PROCESSOR "1764-LRP"\nSLOT 1 OTHER 3 2 2\nSLOT 2 OTHER 3 2 2\n'
    return f'PROJECT "LINE"\n{slots}LADDER 2 "MAIN"\n{body}{data}END\n'


def exported(*routines: str, tags: tuple[str, ...] = (), add_ons: tuple[str, ...] = ()) -> str:
    """An L5X with one program."""
    programs = (l5x.program("Main", *routines, tags=tags),)
    return l5x.document(programs=programs, tasks=(l5x.task("Cycle", "Main"),), add_ons=add_ons)


def function(body: str, fields: str = "") -> str:
    """A function of the scan, with an object that keeps its fields."""
    kept = "".join(f"    {each.strip()}\n" for each in (fields or "seen = False").split(";"))
    return f"class Line:\n{kept}\n\nline = Line()\n\n\ndef logic(scan):\n{body}"


BOTH_WAYS: list[Row] = [
    (
        "rungs.rung",
        rungs(
            "Seen : BOOL",
            "XIC(Start)OTE(Lamp);\nXIC(Part)OTE(Seen);\nJSR(Text,0);",
            "ROUTINE Text ST\nLamp := Seen;\nEND\n",
        ),
        "Lamp := Seen",
        (
            ("JSR(Text,0)", "XIO(Start)JSR(Text,0)"),
            ("XIC(Start)OTE(Lamp)", "XIC(Start)JSR(More,0)"),
            ("ROUTINE Text", "ROUTINE More\nXIC(Part)OTE(Lamp);\nEND\nROUTINE Text"),
        ),
    ),
    (
        "text.rung",
        text(
            "Seen : BOOL",
            "Seen := Part;\nIF Seen THEN Lamp := Start; END_IF;\nJSR(More,0);",
            "ROUTINE More\nXIC(Seen)OTE(Lamp);\nEND\n",
        ),
        "Lamp := Start",
        (("OTE(Lamp)", "OTE(Local:3:O.Data.1)"),),
    ),
    (
        "mixed.L5X",
        exported(
            l5x.ladder("Main", "XIC(Go)OTE(Lamp)JSR(Text,0);"),
            l5x.structured("Text", "Lamp := Other AND NOT Go;"),
            tags=tuple(l5x.tag(each, "BOOL") for each in ("Go", "Other", "Lamp", "Horn")),
        ),
        "Lamp := Other",
        (("OTE(Lamp)", "OTE(Horn)"),),
    ),
]

BOTH_WAYS.append(
    (
        "latch.L5X",
        exported(
            l5x.ladder("Main", "XIC(Go)OTE(Lamp)JSR(Text,0);"),
            l5x.structured("Text", "IF Other THEN Lamp := 1; END_IF;"),
            tags=tuple(l5x.tag(each, "BOOL") for each in ("Go", "Other", "Lamp", "Horn")),
        ),
        "Lamp := 1",
        (("Lamp := 1", "Horn := 1"), ("END_IF", "ELSE Horn := 0; END_IF")),
    )
)

EQUAL: list[Row] = [
    (
        "rungs.rung",
        rungs("Level : REAL", "MUL(Local:2:I.Data[0],0.1,Level);\nEQU(Level,10.5)OTE(Lamp);"),
        "EQU(Level,10.5)",
        (("EQU(Level", "GEQ(Level"),),
    ),
    (
        "sum.rung",
        text(
            "Sum : REAL; Want : REAL := 1.5",
            "Sum := Sum + 0.1;\nIF Sum = Want THEN\n    Sum := 0.0;\nEND_IF;\nIF Start THEN Want := 2.5; END_IF;\nLamp := Want = 2.5;",
        ),
        "IF Sum = Want",
        (("Sum = Want", "ABS(Sum - Want) < 0.05"),),
    ),
    (
        "share.rung",
        rungs(
            "Span : REAL; Share : REAL; Last : REAL",
            "SUB(Local:2:I.Data[0],0.5,Span);\nNEQ(Span,0.0)DIV(1.0,Span,Share);\nNEQ(Share,0.25)OTE(Lamp);\nMOV(Share,Last);",
        ),
        "NEQ(Share,0.25)",
        (("NEQ(Share,0.25)", "NEQ(Share,Last)"),),
    ),
    (
        "tank.SLC",
        slc("MUL I:1.0 0.1 F8:0", "EQU F8:0 12.5 OTE O:2.0/0", data="DATA F8:0 0.0\n"),
        "EQU F8:0",
        (("EQU F8:0 12.5", "GRT F8:0 12.5"),),
    ),
    (
        "tank.L5X",
        exported(
            l5x.ladder(
                "Main", "CPT(Level,Raw/3.0)EQU(Level,7.5)OTE(Full);", "NEQ(Wanted,Seen)MOV(Wanted,Seen);"
            ),
            tags=(
                l5x.tag("Level", "REAL"),
                l5x.tag("Raw", "DINT"),
                l5x.tag("Full", "BOOL"),
                l5x.tag("Wanted", "REAL"),
                l5x.tag("Seen", "REAL"),
            ),
        ),
        "EQU(Level,7.5)",
        (("EQU(Level,7.5)", "LIM(7.4,Level,7.6)"),),
    ),
    (
        "function.py",
        function(
            "    line.sum += 0.1\n    scan.slot[3].outputs.set_bit(0, 0, line.sum == 1.0)\n", "sum = 0.0"
        ),
        "line.sum == 1.0",
        (("line.sum == 1.0", "line.sum >= 1.0"),),
    ),
]

NEVER_COUNTED: list[Row] = [
    (
        "rungs.rung",
        rungs(
            "Parts : COUNTER; Other : COUNTER",
            "XIC(Part)CTU(Other,5,0);\nXIC(Parts.DN)OTE(Lamp);\nXIC(Reset)RES(Parts)RES(Other);",
        ),
        "XIC(Parts.DN)",
        (("CTU(Other,5,0)", "CTU(Parts,5,0)CTU(Other,5,0)"),),
    ),
    (
        "acc.rung",
        text("Parts : COUNTER", "Lamp := Parts.ACC >= 5;\nIF Reset THEN Parts.ACC := 0; END_IF;"),
        "Parts.ACC >= 5",
        (("IF Reset", "IF Part THEN Parts.ACC := Parts.ACC + 1; END_IF;\nIF Reset"),),
    ),
    (
        "boxes.SLC",
        slc(
            "XIC I:1.0/2 CTU C5:1 10 0",
            "XIC C5:0/DN OTE O:2.0/1",
            "XIC I:1.0/3 RES C5:0 RES C5:1",
            data="DATA C5:0 0 10 0\nDATA C5:1 0 10 0\n",
        ),
        "C5:0/DN",
        (("CTU C5:1", "CTU C5:0"),),
    ),
    (
        "boxes.L5X",
        exported(
            l5x.ladder("Main", "XIC(Photo)CTU(Boxes,?,?);", "GEQ(Rejects.ACC,3)OTE(Stop);"),
            tags=(
                l5x.tag("Photo", "BOOL"),
                l5x.tag("Stop", "BOOL"),
                l5x.tag("Boxes", "COUNTER"),
                l5x.tag("Rejects", "COUNTER"),
            ),
        ),
        "GEQ(Rejects.ACC,3)",
        (("CTU(Boxes,?,?)", "CTU(Boxes,?,?)CTU(Rejects,?,?)"),),
    ),
    (
        "function.py",
        function(
            "    if scan.slot[2].inputs.bit(0, 1):\n        line.parts = 0\n    scan.slot[3].outputs.set_bit(0, 0, line.parts >= 5)\n",
            "parts = 0",
        ),
        "line.parts >= 5",
        (
            (
                "    if scan.slot[2].inputs.bit(0, 1)",
                "    if scan.slot[2].inputs.bit(0, 0):\n        line.parts += 1\n    if scan.slot[2].inputs.bit(0, 1)",
            ),
        ),
    ),
    (
        "sequence.py",
        SEQUENCE.replace("OnDelay,", "OnDelay, Counter,")
        .replace("    parts = 0\n", "    parts = 0\n    full_box = Counter(12)\n")
        .replace(
            "self.lamp = self.late(self.feeder.moving)",
            "self.lamp = self.late(self.feeder.moving) and not self.full_box",
        ),
        "not self.full_box",
        (("        self.lamp =", "        self.full_box(self.full)\n        self.lamp ="),),
    ),
]

STEPS = "0: IF Start THEN Step := 10; END_IF;\n10: Lamp := 1;\n    IF Part THEN Step := 20; END_IF;\n20: Lamp := 0;\n"
HAND = """\
    start, part = scan.slot[2].inputs.bit(0, 0), scan.slot[2].inputs.bit(0, 1)
    if line.step == "wait":
        if start:
            line.step = "fill"
    elif line.step == "fill":
        scan.slot[3].outputs.set_bit(0, 0, True)
        if part:
            line.step = "drain"
    elif line.step == "drain":
        scan.slot[3].outputs.set_bit(0, 0, False)
"""

BY_STEPS = """\
from scanrack import Input, Logic, Output


class Line(Logic):
    start = Input("Local:2:I.Data.0")
    part = Input("Local:2:I.Data.1")
    lamp: Output = Output("Local:3:O.Data.0")
    step = "wait"

    def every_scan(self) -> None:
        match self.step:
            case "wait":
                if self.start:
                    self.step = "fill"
            case "fill":
                self.lamp = True
                if self.part:
                    self.step = "drain"
            case "drain":
                self.lamp = False
"""
NO_EXIT: list[Row] = [
    (
        "class.py",
        BY_STEPS,
        'self.step = "drain"',
        (("self.lamp = False\n", 'self.lamp = False\n                self.step = "wait"\n'),),
    ),
    (
        "last.rung",
        text("Step : DINT", f"CASE Step OF\n{STEPS}END_CASE;"),
        "Step := 20",
        (("20: Lamp := 0;", "20: Lamp := 0;\n    Step := 0;"),),
    ),
    (
        "fault.rung",
        text(
            "Step : DINT",
            f"CASE Step OF\n{STEPS}    Step := 0;\n99: Lamp := 0;\nEND_CASE;\nIF Reset THEN Step := 99; END_IF;",
        ),
        "Step := 99",
        (("99: Lamp := 0;", "99: Lamp := 0;\n    IF Start THEN Step := 0; END_IF;"),),
    ),
    (
        "middle.rung",
        text(
            "Step : DINT; Count : DINT",
            "CASE Step OF\n0: IF Start THEN Step := 10; END_IF;\n10: IF Part THEN Count := Count + 1; END_IF;\n    Lamp := Count > 3;\n    IF Reset THEN Step := 20; END_IF;\n20: Count := 0;\n30: Lamp := 0;\n    Step := 0;\nEND_CASE;",
        ),
        "Step := 20",
        (("20: Count := 0;", "20: Count := 0;\n    Step := 30;"),),
    ),
    (
        "rungs.rung",
        rungs(
            "Step : DINT",
            "EQU(Step,0)XIC(Start)MOV(10,Step);\nEQU(Step,10)XIC(Part)MOV(20,Step);\nEQU(Step,20)OTE(Lamp);",
        ),
        "MOV(20,Step)",
        (("EQU(Step,20)OTE(Lamp);", "EQU(Step,20)OTE(Lamp);\nEQU(Step,20)XIO(Part)MOV(0,Step);"),),
    ),
    (
        "hand.py",
        function(HAND, 'step = "wait"'),
        'line.step = "drain"',
        (("False)\n", 'False)\n        line.step = "wait"\n'),),
    ),
    (
        "steps.SLC",
        slc(
            "EQU N7:0 0 XIC I:1.0/0 MOV 10 N7:0",
            "EQU N7:0 10 XIC I:1.0/1 MOV 20 N7:0",
            "EQU N7:0 20 OTE O:2.0/0",
            data="DATA N7:0 0\n",
        ),
        "MOV 20 N7:0",
        (
            (
                "SOR EQU N7:0 20 OTE O:2.0/0",
                "SOR EQU N7:0 20 XIC I:1.0/2 MOV 0 N7:0 EOR\nSOR EQU N7:0 20 OTE O:2.0/0",
            ),
        ),
    ),
]

GAUGE = """\
CONTROLLER plant
INSTRUCTION Scaler
INPUT Raw : DINT REQUIRED
OUTPUT Value : DINT
LOCAL Gain : DINT
LOCAL Wait : TIMER
ROUTINE Logic
MUL(Raw,Gain,Value);
TON(Wait,500,0);
XIC(Wait.DN)ADD(Value,1,Value);
END
END INSTRUCTION
TAG Gauge : Scaler
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Main MAIN Start
ROUTINE Start
Scaler(Gauge,Local:2:I.Data[0]);
GRT(Gauge.Value,50)OTE(Local:3:O.Data.0);
END
END PROGRAM
"""
LOCAL = "LOCAL Gain : DINT\n"

NEVER_WRITTEN: list[Row] = [
    ("rungs.rung", GAUGE, "MUL(Raw,Gain", ((LOCAL, "LOCAL Gain : DINT := 3\n"),)),
    (
        "text.rung",
        GAUGE.replace(
            "ROUTINE Logic\nMUL(Raw,Gain,Value);\nTON(Wait,500,0);\nXIC(Wait.DN)ADD(Value,1,Value);\n",
            "ROUTINE Logic ST\nIF Raw > Gain THEN\n    Value := Raw;\nEND_IF;\n",
        ).replace("LOCAL Wait : TIMER\n", ""),
        "Raw > Gain",
        (("    Value := Raw;", "    Gain := Raw - 5;\n    Value := Raw;"),),
    ),
    (
        "gauge.L5X",
        exported(
            l5x.ladder("Main", "Scaler(Gauge,Raw);"),
            tags=(l5x.tag("Raw", "DINT"), l5x.tag("Gauge", "Scaler")),
            add_ons=(
                l5x.add_on(
                    "Scaler",
                    [
                        l5x.parameter("Raw", "DINT", "Input"),
                        l5x.parameter("Value", "DINT", "Output", required=False),
                    ],
                    ['<LocalTag Name="Gain" DataType="DINT"/>\n'],
                    l5x.ladder("Logic", "MUL(Raw,Gain,Value);", "NOP();"),
                ),
            ),
        ),
        "MUL(Raw,Gain",
        (("NOP();", "MOV(3,Gain);"),),
    ),
]

BUFFER = "XIC(Part)MOV(Local:2:I.Data[0],Buffer[Next])ADD(Next,1,Next);\nGRT(Buffer[0],5)OTE(Lamp);"

IN_A_LOOP = (
    SEQUENCE.replace("            for station in STATIONS:\n", "            if STATIONS:\n")
    .replace("self.stroke(station,", "self.stroke(STATIONS[at],")
    .replace("        self.homed = True\n", "        self.homed = True\n        at = 0\n")
    .replace("            self.parts += 1\n", "            self.parts += 1\n            at += 1\n")
)
UNBOUNDED: list[Row] = [
    ("loop.py", IN_A_LOOP, "STATIONS[at]", (("at += 1", "at = (at + 1) % 3"),)),
    (
        "rungs.rung",
        rungs("Next : DINT; Buffer : DINT[10]", BUFFER),
        "Buffer[Next]",
        ((BUFFER, f"{BUFFER}\nGEQ(Next,10)MOV(0,Next);"),),
    ),
    (
        "by_hand.rung",
        rungs("Next : DINT; Buffer : DINT[10]", f"{BUFFER}\nXIC(Reset)CLR(Next);"),
        "Buffer[Next]",
        (("XIC(Reset)CLR(Next)", "[XIC(Reset),GRT(Next,9)]CLR(Next)"),),
    ),
    (
        "text.rung",
        text(
            "Next : DINT; Buffer : DINT[10]",
            "IF Part THEN\n    Buffer[Next] := 1;\n    Next := Next + 1;\nEND_IF;\nLamp := Buffer[0] > 0;",
        ),
        "Buffer[Next] := 1",
        (("Next := Next + 1", "Next := (Next + 1) MOD 10"),),
    ),
    (
        "queue.SLC",
        slc(
            "XIC I:1.0/2 MOV I:1.0 N7:[N10:0]",
            "XIC I:1.0/2 ADD N10:0 1 N10:0",
            "GRT N7:3 5 OTE O:2.0/0",
            data="DATA N7:0 0 0 0 0\nDATA N10:0 0\n",
        ),
        "N7:[N10:0]",
        (("SOR GRT N7:3", "SOR GEQ N10:0 4 CLR N10:0 EOR\nSOR GRT N7:3"),),
    ),
    (
        "queue.L5X",
        exported(
            l5x.ladder("Main", "XIC(Photo)MOV(Weight,Weights[Next])ADD(Next,1,Next);", "NOP();"),
            tags=(
                l5x.tag("Photo", "BOOL"),
                l5x.tag("Weight", "DINT"),
                l5x.tag("Weights", "DINT", "20"),
                l5x.tag("Next", "DINT"),
            ),
        ),
        "Weights[Next]",
        (("NOP();", "EQU(Next,20)CLR(Next);"),),
    ),
    (
        "table.py",
        "STOPS = (0, 4000, 8000)\n\n\n"
        + function(
            "    if scan.slot[2].inputs.bit(0, 0):\n        scan.slot[3].outputs[0] = STOPS[line.next] // 1000\n        line.next += 1\n",
            "next = 0",
        ),
        "STOPS[line.next]",
        (("line.next += 1", "line.next = (line.next + 1) % 3"),),
    ),
]

CURVE = """\
PROGRAM curve
USE axis3601
SLOT card : 1
ALIAS Go : Local:2:I.Data.0
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Lengths : DINT[3] := [1000, 4000, 2000]
TAG Speeds : DINT[3] := [1000, 8000, 2000]
TAG Rates : INT[3] := [10, 50, 50]
TAG Configure : Configure3601
TAG Prog : ProgramBlend3601
TAG Run : RunBlend3601
TAG Awake : BOOL
TAG Pressed : BOOL
TAG Step : DINT
"""
LADDER = f"""\
{CURVE}
ROUTINE Main
XIO(S:FS)OTE(Awake);
Configure3601(Configure,Axis,Words,Awake);
ProgramBlend3601(Prog,Axis,Lengths,Speeds,Rates,Configure.Done,3,20);
GEQ(Step,0)XIC(Configure.Done)XIO(Run.Done)OTE(Pressed);
RunBlend3601(Run,Axis,Pressed,1);
Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
""".replace("GEQ(Step,0)", "").replace("TAG Step : DINT\n", "")
CASES = f"""\
{CURVE}
ROUTINE Main ST
Awake := NOT S:FS;
Pressed := Go;
Configure3601(Configure, Axis, Words, Awake);
CASE Step OF
0: IF Configure.Done THEN Step := 10; END_IF;
10: IF Run.Done THEN Step := 20; END_IF;
20: IF Prog.Done THEN Step := 30; END_IF;
30: IF Pressed THEN Step := 10; END_IF;
END_CASE;
ProgramBlend3601(Prog, Axis, Lengths, Speeds, Rates, Step = 20, 3, 20);
RunBlend3601(Run, Axis, Step = 10, 1);
Amci3601(Module, Axis, card.I.Data[0], card.O.Data[0]);
END
"""
PROGRAMMED = "        await self.pusher.program_blend(PATH, final_deceleration=20)\n"
RUNS = "                    await self.pusher.run_blend(Direction.CCW)\n"

TOO_EARLY: list[Row] = [
    (
        "sequence.py",
        SEQUENCE.replace(PROGRAMMED, "").replace(RUNS, f"{RUNS}            {PROGRAMMED}"),
        "run_blend(Direction.CW)",
        (
            (f"            {PROGRAMMED}", ""),
            (
                "        await self.pusher.set_position(0)\n",
                f"        await self.pusher.set_position(0)\n{PROGRAMMED}",
            ),
        ),
    ),
    ("blocks.rung", LADDER, "RunBlend3601(", (("XIC(Configure.Done)XIO(Run", "XIC(Prog.Done)XIO(Run"),)),
    (
        "done.rung",
        LADDER.replace("Rates,Configure.Done", "Rates,Run.Done").replace(
            "XIC(Configure.Done)XIO(Run.Done)OTE", "XIC(Go)OTE"
        ),
        "RunBlend3601(",
        (("Rates,Run.Done", "Rates,Configure.Done"),),
    ),
    (
        "case.rung",
        CASES,
        "RunBlend3601(",
        (
            ("IF Run.Done THEN Step := 20", "IF Prog.Done THEN Step := 20"),
            ("IF Prog.Done THEN Step := 30", "IF Run.Done THEN Step := 30"),
            ("Step = 20", "Step = 25"),
            ("Step = 10", "Step = 20"),
            ("Step = 25", "Step = 10"),
        ),
    ),
    (
        "curve.steps",
        """\
words 8434h 0034h 0 500    until MODE_CONFIG -CONFIG_ERROR
zero                       until -MODE_CONFIG
PRESET_POSITION            until -POSITION_INVALID
RUN_BLEND_CW               until MOVE_COMPLETE
zero                       for 10 ms
words 0 0100h 0 2 10       for 10 ms
zero                       for 10 ms
""",
        "RUN_BLEND_CW",
        (
            ("RUN_BLEND_CW               until MOVE_COMPLETE\n", ""),
            (
                "words 0 0100h 0 2 10       for 10 ms\n",
                "words 0 0100h 0 2 10       for 10 ms\nRUN_BLEND_CW               until MOVE_COMPLETE\n",
            ),
        ),
    ),
]

FRESH: dict[str, list[Row]] = {
    "never-written": [
        (
            "edge.py",
            function(
                "    start = scan.slot[2].inputs.bit(0, 0)\n    scan.slot[3].outputs.set_bit(0, 0, start and not line.before)\n",
                "before = False",
            ),
            "line.before",
            (("line.before)\n", "line.before)\n    line.before = start\n"),),
        ),
    ],
    "never-run": [
        (
            "pulse.rung",
            rungs("Seen : BOOL; Wait : TIMER", "XIC(Start)ONS(Seen)TON(Wait,500,0);\nXIC(Wait.DN)OTE(Lamp);"),
            "TON(Wait",
            (("ONS(Seen)TON", "TON"), ("TAG Seen : BOOL\n", "")),
        ),
        (
            "enable.rung",
            text('Wait : FBD_TIMER := {"PRE": 500}', "TONR(Wait);\nLamp := Wait.DN;"),
            "TONR(Wait)",
            (("TONR(Wait)", "Wait.TimerEnable := Start;\nTONR(Wait)"),),
        ),
        (
            "pulse.SLC",
            slc(
                "XIC I:1.0/2 ONS B3:0/0 TON T4:0 0.01 50 0",
                "XIC T4:0/DN OTE O:2.0/1",
                data="DATA T4:0 0 50 0\nDATA B3:0 0\n",
            ),
            "TON T4:0",
            (("ONS B3:0/0 TON", "TON"),),
        ),
    ],
    "real-equality": [
        (
            "time.rung",
            rungs("Wait : TIMER", "XIC(Start)TON(Wait,1000,0);\nEQU(Wait.ACC,500)OTE(Lamp);"),
            "EQU(Wait.ACC",
            (("EQU(Wait", "GEQ(Wait"),),
        ),
        (
            "zero.rung",
            rungs(
                "Wait : TIMER",
                "XIC(Start)RTO(Wait,1000,0);\nXIC(Reset)RES(Wait);\nEQU(Wait.ACC,700)OTE(Lamp);",
            ),
            "EQU(Wait.ACC",
            (("EQU(Wait.ACC,700)", "EQU(Wait.ACC,0)"),),
        ),
        (
            "time.SLC",
            slc("XIC I:1.0/2 TON T4:0 0.01 50 0", "EQU T4:0.ACC 25 OTE O:2.0/1", data="DATA T4:0 0 50 0\n"),
            "EQU T4:0",
            (("EQU T4", "GEQ T4"),),
        ),
    ],
    "negative-preset": [
        (
            "rungs.rung",
            rungs("Wait : TIMER", "XIC(Start)TON(Wait,-500,0);\nXIC(Wait.DN)OTE(Lamp);"),
            "TON(Wait",
            (("-500", "500"),),
        ),
        (
            "moved.rung",
            rungs(
                "Wait : TIMER",
                "XIC(Start)MOV(-1,Wait.PRE);\nXIO(Start)MOV(-20,Wait.PRE);\nXIC(Part)TOF(Wait,-20,0);\nXIC(Wait.DN)OTE(Lamp);",
            ),
            "TOF(Wait",
            (("MOV(-1,", "MOV(100,"), ("MOV(-20,", "MOV(200,"), ("Wait,-20,0", "Wait,200,0")),
        ),
        (
            "tag.rung",
            rungs(
                'Wait : TIMER := {"PRE": -5}',
                "XIC(Start)RTO(Wait,?,?);\nXIC(Reset)RES(Wait);\nXIC(Wait.DN)OTE(Lamp);",
            ),
            "RTO(Wait",
            (("-5", "500"),),
        ),
    ],
    "latch-never-cleared": [
        (
            "case.rung",
            text(
                'Step : DINT; Wait : FBD_TIMER := {"PRE": 500}',
                "CASE Step OF\n0: IF Start THEN Step := 10; END_IF;\n10: Wait.TimerEnable := 1;\n    TONR(Wait);\n    IF Wait.DN THEN Step := 0; END_IF;\nEND_CASE;\nLamp := Step = 10;",
            ),
            "TONR(Wait)",
            (
                ("    Wait.TimerEnable", "Wait.TimerEnable"),
                ("10: Wait.TimerEnable := 1;\n    TONR(Wait);\n", "10: "),
                ("CASE Step OF", "Wait.TimerEnable := Step = 10;\nTONR(Wait);\nCASE Step OF"),
            )[1:],
        ),
        (
            "seal.rung",
            rungs("Run : BOOL", "[XIC(Start),XIC(Run)]OTE(Run);\nXIC(Run)OTE(Lamp);"),
            "OTE(Run)",
            (("OTE(Run)", "XIC(Reset)OTE(Run)"),),
        ),
        (
            "seal_st.rung",
            text("Run : BOOL", "Run := Start OR Run;\nLamp := Run;"),
            "Run := Start",
            (("Start OR Run", "(Start OR Run) AND NOT Reset"),),
        ),
    ],
    "subscript": [
        (
            "one.rung",
            rungs("Next : DINT; Buffer : DINT[10]", f"{BUFFER}\nGRT(Next,10)CLR(Next);"),
            "Buffer[Next]",
            (("GRT(Next,10)", "GRT(Next,9)"),),
        ),
        (
            "copy.rung",
            rungs(
                "Full : DINT[10]; Half : DINT[5]",
                "MOV(Local:2:I.Data[0],Full[9]);\nCOP(Full[5],Half[0],6);\nGRT(Half[4],5)OTE(Lamp);",
            ),
            "COP(Full[5]",
            (("Half[0],6", "Half[0],5"),),
        ),
        (
            "fill.rung",
            rungs(
                "Half : DINT[5]",
                "XIC(Reset)FLL(0,Half[0],6);\nXIC(Part)MOV(9,Half[4]);\nGRT(Half[4],5)OTE(Lamp);",
            ),
            "FLL(0",
            (("Half[0],6", "Half[0],5"),),
        ),
    ],
    "beyond-limit": [
        (
            "sequence.py",
            SEQUENCE.replace("STATIONS = (0, 4000, 8000)", "STATIONS = (0, 4000, 18000)"),
            "self.feeder.move_to",
            (("18000", "8000"),),
        ),
        (
            "left.py",
            SEQUENCE.replace("STATIONS = (0, 4000, 8000)", "STATIONS = (0, -4000, 8000)"),
            "self.feeder.move_to",
            (("-4000", "-2000"),),
        ),
        (
            "blocks.rung",
            BLOCKS.replace("OutGo,6000", "OutGo,14000"),
            "OutGo,14000",
            (("OutGo,14000", "OutGo,13000"),),
        ),
    ],
    "out-of-range": [
        (
            "blocks.rung",
            BLOCKS.replace("Homing,-1,", "Homing,0,"),
            "Homing,0,",
            (("Homing,0,", "Homing,-1,"),),
        ),
    ],
    "bad-call": [
        (
            "until.py",
            SEQUENCE.replace('until(lambda: self.running, "running")', 'until(self.running, "running")'),
            "until(self.running",
            (("until(self.running", "until(lambda: self.running"),),
        ),
    ],
    "step-without-exit": [
        (
            "typo.rung",
            text(
                "Step : DINT",
                "CASE Step OF\n0: IF Start THEN Step := 10; END_IF;\n10: IF Part THEN Step := 25; END_IF;\n20: Lamp := Start; IF Reset THEN Step := 0; END_IF;\nEND_CASE;",
            ),
            "Step := 25",
            (("25", "20"),),
        ),
    ],
}
"""Mistakes of programmers that the rules found when they were written, of other kinds than the classes."""


CLASSES: dict[str, list[Row]] = {
    "repeated-coil": BOTH_WAYS,
    "real-equality": EQUAL,
    "never-run": NEVER_COUNTED,
    "step-without-exit": NO_EXIT,
    "never-written": NEVER_WRITTEN,
    "subscript": UNBOUNDED,
    "no-blend": TOO_EARLY,
}

CASES_BY_RULE = [
    Case(rule, *row) for table in (CLASSES, FRESH) for rule, rows in table.items() for row in rows
]

ALWAYS_ON = f"""\
from scanrack import Axis3601, Configuration, Direction, InputBit, Logic, sequence

SETTINGS = {USED[:-1]}ACTIVE)


class Line(Logic):
    axis = Axis3601(1, SETTINGS)

    @sequence
    async def home(self) -> None:
        await self.axis.configure()
        await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
"""
"""A home search, with a place for the active levels."""
