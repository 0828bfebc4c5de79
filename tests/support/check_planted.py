"""Mistakes for `scanrack check`, planted in the sound programs of `check_programs`."""

# ruff: noqa: E501 - one row is one mistake

import re
from typing import NamedTuple

from check_programs import SOUND


class Planted(NamedTuple):
    """A mistake: what is replaced in a sound program by what, and the text of the line where it is found."""

    program: str
    rule: str
    old: str
    new: str
    at: str = ""  # the first line with this text; the new text itself without one
    controller: str = ""
    anywhere: bool = False  # whether the line is not told


RUNGS = [
    # bits and tags
    (
        "repeated-coil",
        "XIC(Alarm)OTE(Horn);",
        "XIC(Alarm)OTE(Horn);\nXIC(Full)OTE(Horn);",
        "XIC(Full)OTE(Horn)",
    ),
    (
        "coil-and-latch",
        "XIC(Alarm)OTE(Horn);",
        "XIC(Alarm)OTE(Horn);\nXIC(Full)OTL(Horn);",
        "XIC(Full)OTL(Horn)",
    ),
    ("coil-and-latch", "XIC(Clear)ONS(Pressed)OTU(Alarm);", "XIC(Clear)ONS(Pressed)OTU(Run);"),
    (
        "move-over-coil",
        "XIC(Alarm)OTE(Horn);",
        "XIC(Alarm)OTE(Horn);\nMOV(Rate,Local:3:O.Data[0]);",
        "MOV(Rate,Local:3",
    ),
    (
        "move-over-coil",
        "XIC(Alarm)OTE(Horn);",
        "XIC(Alarm)OTE(Horn);\nXIC(Full)CLR(Local:3:O.Data[0]);",
        "CLR(Local:3",
    ),
    ("never-written", "XIC(Run)OTE(Lamp);", "XIC(Run)XIC(Permit)OTE(Lamp);"),
    ("never-read", "XIC(Run)OTE(Lamp);", "XIC(Run)OTE(Lamp)OTE(Permit);"),
    ("unused-tag", "TAG Awake", "TAG Spare : DINT\nTAG Awake", "TAG Spare"),
    (
        "latch-never-cleared",
        "XIC(Clear)ONS(Pressed)OTU(Alarm);",
        "XIC(Clear)ONS(Pressed)RES(Count);",
        "OTL(Alarm)",
    ),
    ("input-written", "XIC(Alarm)OTE(Horn);", "XIC(Alarm)OTE(Full);"),
    ("input-written", "XIO(Full)MOV(4000,Speed);", "XIO(Full)MOV(4000,Speed)MOV(0,Local:2:I.Data[0]);"),
    # conditions
    ("shorted-branch", "[XIC(Start),XIC(Run)]", "[XIC(Start),XIC(Run),]"),
    ("contradiction", "XIC(Alarm)OTE(Horn);", "XIC(Alarm)XIO(Alarm)OTE(Horn);"),
    ("contradiction", "LES(Rate,3)GRT(Share,5)NOP();", "EQU(Rate,3)EQU(Rate,4)OTL(Alarm);"),
    ("constant-condition", "XIC(Run)OTE(Lamp);", "[XIC(Run),XIO(Run)]OTE(Lamp);"),
    ("constant-condition", "GRT(Speed,5000)OTE(Fast);", "GRT(card.I.Data[2],40000)OTE(Fast);"),
    ("constant-condition", "GRT(Speed,5000)OTE(Fast);", "CMP(3>2)OTE(Fast);"),
    ("unreachable", "XIC(Run)OTE(Lamp);", "TND();\nXIC(Run)OTE(Lamp);", "XIC(Run)OTE(Lamp)"),
    ("unreachable", "XIC(Run)OTE(Lamp);", "AFI()XIC(Run)OTE(Lamp);"),
    (
        "unreachable",
        "XIC(Run)OTE(Lamp);",
        "JMP(over);\nXIC(Run)OTE(Lamp);\nLBL(over)XIC(Run)NOP();",
        "XIC(Run)OTE(Lamp)",
    ),
    ("preset-zero", "TON(Blink,250,0)", "TON(Blink,0,0)"),
    ("preset-zero", "LES(Rate,3)", "XIC(Count.DN)LES(Rate,3)", "CTU(Count"),
    ("division-by-zero", "DIV(Count.ACC,10,Rate)", "DIV(Count.ACC,0,Rate)"),
    ("lossy-conversion", "MOD(Count.ACC,10,Share)", "MOD(Count.ACC,10,Share)MOV(Average,Share)"),
    # blocks
    ("block-twice", "XIC(Run)OTE(Lamp);", "XIC(Run)OTE(Lamp);\nMC_Reset(Reset,Axis,Clear);", None),
    (
        "block-order",
        "LES(Rate,3)GRT(Share,5)NOP();\n",
        "Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);\nMC_Halt(Halt,Axis,Full);\n",
        "Amci3601(Module",
    ),
    (
        "block-order",
        "MOV(card.I.Fault,Module.Fault)Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);\n",
        "",
        "Configure3601(Configure,",
    ),
    ("execute-never-falls", "MC_MoveAbsolute(Out,Axis,OutGo,", "MC_MoveAbsolute(Out,Axis,Awake,"),
    ("move-interrupted", "MC_MoveAbsolute(Back,Axis,BackGo,", "MC_MoveAbsolute(Back,Axis,OutGo,"),
    (
        "move-interrupted",
        "XIC(Out.Done)XIO(Back.Done)OTE(BackGo);",
        "XIC(Out.Busy)XIO(Back.Done)OTE(BackGo);",
        "MC_MoveAbsolute(Back",
    ),
    # the 3601
    ("no-place", "SLOT card : 1", "SLOT card : 2"),
    ("no-place", "SLOT card : 1", "SLOT card : 7"),
    ("out-of-range", "Out,Axis,OutGo,6000,Speed,10,10", "Out,Axis,OutGo,6000,400,10,10"),
    (
        "out-of-range",
        "XIC(Full)MOV(6000,Speed);\nXIO(Full)MOV(4000,Speed);",
        "XIC(Full)MOV(300,Speed);\nXIO(Full)MOV(400,Speed);",
        "MC_MoveAbsolute(Out",
    ),
    ("refused-command", "16#8434, 16#0034", "16#8414, 16#0014", "MC_Home("),
    ("motion-unconfigured", "Configure3601(Configure,Axis,Words,Awake);", "MOV(Words[0],Rate);", "MC_Home("),
    (
        "no-position",
        "MC_Home(Home,Axis,Homing,-1,2000,10,10);",
        "MC_Halt(Halt,Axis,Homing);",
        "MC_MoveAbsolute(Out",
    ),
    (
        "blend-profile",
        "MC_Reset(Reset,Axis,Quiet.DN);",
        "ProgramBlend3601(Blend,Axis,Lengths,Speeds,Rates,Quiet.DN,17,10);\nRunBlend3601(Curve,Axis,Full,1);",
        "ProgramBlend3601(Blend",
    ),
    (
        "blend-profile",
        "MC_Reset(Reset,Axis,Quiet.DN);",
        "ProgramBlend3601(Blend,Axis,Lengths,Speeds,Rates,Quiet.DN,3,10);\nRunBlend3601(Curve,Axis,Full,1);",
        "ProgramBlend3601(Blend",
    ),
    ("no-blend", "MC_Reset(Reset,Axis,Quiet.DN);", "RunBlend3601(Curve,Axis,Full,1);"),
]
"""Rule, old text, new text, and the line in the rungs with blocks."""

TAGS = {
    "Permit": "BOOL",
    "Border": "DINT",
    "Other": "TIMER",
    "Narrow": "INT",
    "Average": "REAL",
    "Halt": "MC_Halt",
    "On": "BOOL",
    "OutC": "CONTROL",
    "Blend": "ProgramBlend3601",
    "Curve": "RunBlend3601",
    "Lengths": "DINT[17] := [1000, 1000, 1000]",
    "Speeds": "DINT[17] := [1000, 2000, 2000]",
    "Rates": "INT[17] := [100, 100, 100]",
}
"""Tags that a mistake needs."""

WORDS = [
    ("command-held", "CLR(axis.O.Data[0])", "OTE(Local:3:O.Data.1)", "COP(Go,"),
    ("out-of-range", "0, 500, 0, 0, 0, 0]", "0, 500, 0, 0, 7, 0]", "COP(Words,"),
    ("no-position", "COP(Preset,axis", "NOP()COP(Go,axis", None),
    ("no-place", "COP(Preset,axis.O", "COP(Preset,Local:2:O", None),
    (
        "motion-unconfigured",
        "XIC(S:FS)COP(Words,axis.O.Data,8);",
        "XIC(S:FS)MOV(Words[3],Pulse2);",
        "COP(Go,",
    ),
    ("no-blend", "[1, 0, 4, 0, 5, 0, 10, 10]", "[16#1000, 0, 0, 0, 0, 0, 0, 0]", "COP(Go,"),
    ("torn-command", "XIC(Start)ONS", "XIC(Start)ONS", "COP(Words,", "compactlogix"),
]
"""The same in rungs that write words, with the controller."""

TASKS = [
    (
        "several-tasks",
        "LES(Deep,0)MOV(0,Deep);",
        "LES(Deep,0)MOV(0,Deep)MOV(1,Level);",
        "CPT(Level",
    ),
    (
        "recursion",
        "LES(Deep,0)MOV(0,Deep);",
        "LES(Deep,0)MOV(0,Deep);\nGRT(Deep,9)JSR(Check,1,Wanted,Deep);",
        "JSR(Check,1,Wanted",
    ),
    ("unused-parameter", "LOCAL Wide : DINT", "INPUT Offset : DINT\nLOCAL Wide : DINT", "INPUT Offset"),
    ("unused-parameter", "LOCAL Wide : DINT", "LOCAL Wide : DINT\nLOCAL Spare : DINT", "LOCAL Spare"),
    ("unused-parameter", "SBR(Deep);", "SBR(Extra);", None),
    ("shadowed-name", "TAG Last : DINT", "TAG Last : DINT\nTAG Wanted : DINT", None),
    ("division-by-zero", "DIV(Wide,100,Value);", "DIV(Wide,0,Value);"),
    ("unreachable", "TASK Fast : PERIODIC 10 ms PRIORITY 3 RUNS Filter\n", "", None),
]
"""The same in the controller."""

TEXT = [
    (
        "repeated-coil",
        "Lamp := Run AND axis.status.MODULE_OK;",
        "Lamp := Run;\nLamp := Seen;",
        "Lamp := Seen;",
    ),
    ("latch-never-cleared", "    Seen := 0;", "    Parts := 0;", "Seen := 1;"),
    ("never-written", "Lamp := Run AND axis.status.MODULE_OK;", "Lamp := Run AND Permit;"),
    ("never-read", "Horn := Seen;", "Permit := Seen;"),
    ("input-written", "Horn := Seen;", "Horn := Seen; Stop := 0;"),
    ("contradiction", "IF Edge.OutputBit THEN", "IF Run AND NOT Run THEN"),
    ("constant-condition", "IF Small > 50 AND Mean > 2.5 THEN", "IF Small > 40000 THEN"),
    ("constant-condition", "IF Small > 50 AND Mean > 2.5 THEN", "IF Step = 30 THEN"),
    ("unreachable", "Horn := Seen;", "RETURN;\nHorn := Seen;", "Horn := Seen;"),
    ("preset-zero", '{"PRE": 500}', '{"PRE": 0}', "TONR(Delay)"),
    ("division-by-zero", "Mean := Parts / 4;", "Mean := Parts / 0;"),
    ("lossy-conversion", "Small := Parts MOD 100;", "Small := Parts;"),
    ("block-twice", "TONR(Delay);", "TONR(Delay);\nDelay.TimerEnable := Stop;\nTONR(Delay);", None),
    ("command-held", "Horn := Seen;", "Horn := Seen; IF Seen THEN axis.command.HOLD_MOVE := 1; END_IF;"),
    ("no-place", "SLOT axis : 1", "SLOT axis : 3", None),
]
"""The same in structured text."""

SHARED = [
    (
        "tracking.rung",
        "control-mixed",
        "FFU(Weights[0],WeightOut,WeightC,20,0)",
        "FFU(Weights[0],WeightOut,OutC,20,0)",
    ),
    ("tracking.rung", "control-mixed", "BSL(Line[0],LineC,Bad,96)", "BSL(Line[0],AveC,Bad,10)"),
    (
        "tracking.rung",
        "repeated-coil",
        "XIC(Kicker)CTU(Rejects,0,0);",
        "XIC(Kicker)CTU(Rejects,0,0);\nXIC(Bad)CTU(Rejects,0,0);",
    ),
    (
        "tracking.rung",
        "contradiction",
        "[XIC(Jam.DN),",
        "[XIC(Jam.TT)XIC(Jam.DN),",
    ),
    ("tracking.rung", "never-waits", "XIC(Kicker)CTU", "LBL(up)XIC(Photo)NOP();\nJMP(up);\nXIC(Kicker)CTU"),
    (
        "washer.rung",
        "repeated-coil",
        "Drain,Rinse,5000,Local:3:O.Data.1",
        "Drain,Rinse,5000,Local:3:O.Data.0",
    ),
    ("regulator.rung", "lossy-conversion", "Index := TRUNC(Output / 10.0);", "Index := Output / 10.0;"),
    ("regulator.rung", "lossy-conversion", "Mode := 1;", "Mode := 200;"),
    ("regulator.rung", "never-waits", "    J := J + 1;\nEND_WHILE", "END_WHILE"),
    ("regulator.rung", "subscript", "FOR J := 3 TO 1 BY -1 DO", "FOR J := 4 TO 1 BY -1 DO"),
    ("regulator.rung", "contradiction", "ELSIF Integral < -100.0", "ELSIF Integral > 200.0"),
    ("boolsteps.rung", "preset-zero", "TON(Settle,200,0)", "TON(Settle,0,0)"),
    ("boolsteps.rung", "move-interrupted", "XIC(S[4])OTE(DropGo);", "XIC(S[2])OTE(DropGo);"),
    ("pumps.rung", "subscript", "FOR Idx := 0 TO 2 DO", "FOR Idx := 1 TO 3 DO"),
    ("pumps.rung", "division-by-zero", "Speed + 0.5", "Speed + 1.0 / 0.0"),
    ("press_st.rung", "never-waits", "FOR K := 0 TO 15 DO", "FOR K := 0 TO 15 BY 0 DO"),
    (
        "drill.rung",
        "move-interrupted",
        "MC_MoveAbsolute(Drill, Z, Step = 30",
        "MC_MoveAbsolute(Drill, Z, Step = 20",
    ),
    ("feeder.rung", "out-of-range", "TAG FeedSpeed : DINT := 6000", "TAG FeedSpeed : DINT := 150"),
    (
        "words_st.rung",
        "command-held",
        "        axis.O.Data[0] := 0;\n        Step := 50",
        "        FOR I := 1 TO 7 DO axis.O.Data[I] := 0; END_FOR;\n        Step := 50",
    ),
]
"""Program, rule, old text and new text, in programs of rungs and of structured text."""

FUNCTION = [
    ("constant-condition", "if status.MODE_CONFIG and not status.CONFIG_ERROR:", "if 0 > 1:"),
    (
        "contradiction",
        "if status.MODE_CONFIG and not status.CONFIG_ERROR:",
        "if status.MODE_CONFIG and not status.MODE_CONFIG:",
    ),
    ("contradiction", "if pulse and not line.before:", 'if line.step == "wait" and line.step == "move":'),
    (
        "unreachable",
        "    return (station + 1) % 3",
        "    return 0\n    return (station + 1) % 3",
        "(station + 1) % 3",
    ),
    ("recursion", "(station + 1) % 3", "next_station(station + 1) % 3", "def next_station"),
    ("unused-parameter", "def next_station(station):", "def next_station(station, way=1):"),
    (
        "shadowed-name",
        "    outputs = axis.outputs\n",
        "    outputs = axis.outputs\n    SPEED = 3\n    outputs[1] = SPEED * 0\n",
        "SPEED = 3",
    ),
    ("shadowed-name", "pulse = scan.slot[2]", "max = scan.slot[2]", None),
    ("division-by-zero", "% 3", "% 0"),
    ("unknown-attribute", "    line.before = pulse", "    line.befor = pulse"),
    ("unknown-attribute", "status.MOVE_COMPLETE:", "status.MOVE_COMPLET:"),
    ("not-deterministic", "4000 * line.station,", "random.choice((0, 4000)),"),
    ("not-deterministic", "pulse = scan", "pulse = time.time() > 3 or scan"),
    ("input-written", "        outputs[0] = 0", "        outputs[0] = 0; scan.slot[2].inputs[0] = 0"),
    ("no-place", "scan.slot[3].outputs", "scan.slot[6].outputs"),
    ("out-of-range", "SPEED = 5000", "SPEED = 300", "Move(MoveKind"),
    ("out-of-range", "acceleration=10,", "acceleration=3000,"),
    ("lossy-conversion", "        outputs[0] = 0", "        outputs[0] = 0; outputs[3] = 70000"),
    (
        "never-read",
        "    outputs = axis.outputs\n",
        "    outputs = axis.outputs\n    spare = axis.inputs\n",
        "spare =",
    ),
    ("no-position", "PresetPosition(0)", "Idle()", "Move(MoveKind"),
    ("motion-unconfigured", "SETTINGS.to_image()", "Idle().to_image()", None),
]
"""The same in a function of the scan."""

OF_PYTHON = [
    ("cutter.py", "unknown-attribute", "buttons.bit(0, 0)", "buttons.bits(0, 0)"),
    ("cutter.py", "unknown-attribute", "Direction.CCW", "Direction.LEFT"),
    ("cutter.py", "bad-call", "FindHome(Direction.CCW, 800, 10, 10)", "FindHome(Direction.CCW, 800, 10)"),
    ("cutter.py", "no-place", "outputs.set_bit(0, 1,", "outputs.set_bit(0, 17,"),
    ("cutter.py", "no-place", "buttons.bit(0, 2)", "buttons.bit(1, 2)"),
    (
        "cutter.py",
        "command-held",
        "                axis.outputs.load(Idle().to_image())\n                self.until_ns",
        "                self.until_ns",
    ),
    (
        "function.py",
        "move-interrupted",
        "    elif status.MOVE_COMPLETE:",
        "    elif status.MOVING_CW:",
    ),
    (
        "enum.py",
        "command-held",
        "            case Step.GO if status.MOVE_COMPLETE:\n                axis.outputs.load(Idle().to_image())\n",
        "            case Step.GO if status.MOVE_COMPLETE:\n",
    ),
    (
        "enum.py",
        "move-interrupted",
        "case Step.GO if status.MOVE_COMPLETE:",
        "case Step.GO if not status.MOVE_COMPLETE:",
    ),
    ("gantry.py", "not-deterministic", "for axis in (self.z, self.x):", "for axis in {self.z, self.x}:"),
    ("gantry.py", "unused-tag", "    lost = 0\n", "    lost = 0\n    rejected = 0\n"),
    ("gantry.py", "never-written", "        self.ready = True\n", "        pass\n"),
    ("gantry.py", "bad-call", "column * PITCH_X,", "column * PITCH_X / 2,"),
    (
        "gantry.py",
        "contradiction",
        "if axis.state == State.ERROR_STOP:",
        "if axis.state == State.ERROR_STOP and axis.state == State.DISABLED:",
    ),
    (
        "gantry.py",
        "lock-order",
        "    def every_scan",
        "    a = Lock()\n    b = Lock()\n    c = Lock()\n\n"
        + "".join(
            f"    @sequence\n    async def {one}{two}(self) -> None:\n        async with self.{one}, self.{two}:\n"
            "            await dwell('1 s')\n\n"
            for one, two in ("ab", "bc", "ca")
        )
        + "    def every_scan",
    ),
    ("raw.py", "subscript", 'state["count"] += 1', 'state["counts"] += 1'),
    ("raw.py", "unknown-attribute", "elapsed_ms(scan) > 20", "elapsed(scan) > 20"),
    ("raw.py", "bad-call", "go(scan, 3)", "go(3)"),
    ("palletizer.py", "subscript", 'PITCH["x"]', 'PITCH["z"]'),
    ("palletizer.py", "bad-call", "self.carry(column, row)", "self.carry(column)"),
    ("palletizer.py", "out-of-range", "HIGH_SPEED = 7000", "HIGH_SPEED = 700"),
    ("dispenser.py", "out-of-range", "SLOW, FAST = 800", "SLOW, FAST = 80"),
    ("dispenser.py", "unknown-attribute", "self.history.get", "self.histroy.get"),
    ("winder.py:Winder", "unknown-attribute", "recipe.pause", "recipe.paus"),
    ("winder.py:Winder", "subscript", '"thick" if self.thick', '"thck" if self.thick'),
    (
        "winder.py:Winder",
        "never-waits",
        "        while True:\n            done",
        "        while True:\n            if self.wanted: continue\n            done",
    ),
    ("winder.py:Winder", "motion-unconfigured", "await self.traverse.configure()\n", "pass\n"),
    ("winder.py:Winder", "two-sequences", 'await dwell("100 ms")', "self.clamp = True"),
    ("deburr.py", "blend-profile", "speed=1500, rate=20", "speed=150, rate=20"),
]
"""Program, rule, old text and new text, in Python."""

SEQUENCE = [
    ("latch-never-cleared", "self.valve = False\n", "pass\n", "self.valve = True"),
    (
        "never-written",
        "until(lambda: self.running and self.homed)",
        "until(lambda: self.running and self.permit)",
    ),
    ("never-read", "self.running and self.homed", "self.running", "self.homed = True"),
    ("contradiction", "elif self.start:", "elif self.stop:"),
    ("constant-condition", "elif self.start:", "elif 1 == 2:"),
    (
        "unreachable",
        "    async def stroke(",
        "    async def unused(self) -> None:\n        await dwell('1 s')\n\n    async def stroke(",
        "async def unused",
    ),
    (
        "unreachable",
        '        await dwell("100 ms")\n',
        '        return\n        await dwell("100 ms")\n',
        'await dwell("100 ms")',
    ),
    (
        "recursion",
        '        await dwell("100 ms")\n',
        "        await self.stroke(target, speed)\n",
        "async def stroke",
    ),
    (
        "unused-parameter",
        "def stroke(self, target: int, speed: int)",
        "def stroke(self, target: int, speed: int, pause: int = 1)",
    ),
    ("shadowed-name", "for station in STATIONS:", "for PATH in STATIONS:", None),
    ("division-by-zero", "self.parts += 1", "self.parts = self.parts // 0"),
    ("preset-zero", 'OnDelay("2 s")', 'OnDelay("0 s")'),
    ("preset-zero", 'dwell("100 ms")', 'dwell("0 ms")'),
    (
        "block-twice",
        "        self.lamp = self.late(self.feeder.moving)",
        "        self.late(self.stop)\n        self.lamp = self.late(self.feeder.moving)",
        "self.lamp = self.late",
    ),
    (
        "repeated-coil",
        "        self.lamp = self.late(self.feeder.moving)",
        "        self.lamp = self.running\n        self.lamp = self.late(self.feeder.moving)",
        "self.lamp = self.late",
    ),
    (
        "two-sequences",
        "            self.parts += 1",
        "            self.parts += 1\n            self.valve = False",
        None,
    ),
    ("two-sequences", "self.valve = True", "self.lamp = True", None),
    (
        "two-sequences",
        "            self.parts += 1",
        "            await self.pusher.move_by(10, speed=3000, acceleration=20, deceleration=20)",
        None,
    ),
    (
        "lock-order",
        "            for station in STATIONS:\n                async with self.zone:",
        "            for station in STATIONS:\n                async with self.table, self.zone:",
        None,
    ),
    ("unknown-attribute", "if self.stop:", "if self.stopp:"),
    ("unknown-attribute", "self.late(self.feeder.moving)", "self.late(self.feeder.status.IN_ESTP)"),
    (
        "not-deterministic",
        "self.speed = 2000 if self.full else 3000",
        "self.speed = random.randint(2000, 3000)",
    ),
    ("not-deterministic", 'await dwell("100 ms")', "time.sleep(0.1)"),
    ("out-of-range", "speed=speed, acceleration=20", "speed=min(speed, 300), acceleration=20"),
    ("out-of-range", "speed=1000, acceleration=10", "speed=100, acceleration=10"),
    ("refused-command", "InputBit.CCW_LIMIT | ", "", "self.feeder.home("),
    ("blend-profile", "program_blend(PATH,", "program_blend(PATH * 9,"),
    (
        "no-blend",
        "        await self.pusher.program_blend(PATH, final_deceleration=20)\n",
        "",
        "run_blend(Direction.CW)",
    ),
    (
        "motion-unconfigured",
        "        await self.feeder.configure()\n        await self.feeder.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)\n",
        "        await self.feeder.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)\n        await self.feeder.configure()\n",
        "self.feeder.home(",
    ),
    (
        "no-position",
        "        await self.feeder.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)\n",
        "",
        "self.feeder.move_to(",
    ),
    (
        "move-interrupted",
        "await self.pusher.run_blend(Direction.CW)\n",
        "self.pusher.run_blend(Direction.CW)\n",
        "run_blend(Direction.CCW)",
    ),
    ("torn-command", "", "", "feeder = Axis3601", "compactlogix"),
    ("no-place", '"Local:2:I.Data.2"', '"Local:2:I.Data.20"', None),
    ("bad-call", "self.feeder.reset()", "self.feeder.rest()"),
    ("never-waits", 'await until(lambda: self.running, "running")', "while not self.start: pass"),
]
"""The same in sequences."""


def _planted(program, rows):
    for rule, old, new, *more in rows:
        at = more[0] if more else new
        yield Planted(program, rule, old, new, at or "", more[1] if len(more) > 1 else "")


FURTHER = [
    ("conveyor.rung", "unreachable", "JSR(Outputs,0);\n", ""),
    ("conveyor.rung", "recursion", "JSR(Control,0);", "JSR(Control,0);\nJSR(Main,0);"),
    (
        "conveyor.rung",
        "shorted-branch",
        "XIC(Pieces.DN)OTE(Stack);",
        "XIC(Pieces.DN)[NOP(),XIC(Run)]OTE(Stack);",
    ),
    (
        "tank.rung",
        "coil-and-latch",
        "ELSIF Level > Limits[1] OR High THEN\n    Filling := 0;",
        "ELSIF Level > Limits[1] OR High THEN\n    Alarm := 1;",
    ),
    ("tank.rung", "constant-condition", "IF NOT Auto THEN", "IF FALSE THEN"),
    (
        "words_st.rung",
        "out-of-range",
        "axis.O.Data[4] := 5;\n        axis.O.Data[5] := 0;",
        "axis.O.Data[4] := 0;\n        axis.O.Data[5] := 300;",
    ),
    ("words_st.rung", "motion-unconfigured", "    COP(Words[0], axis.O.Data[0], 8);\n", ""),
    ("jog.rung", "no-place", "SLOT card : 1", "SLOT card : 3"),
    ("two_axes.rung", "no-place", "two.I.Data[0],two.O.Data[0]", "one.I.Data[0],one.O.Data[0]"),
    ("blend.rung", "out-of-range", "Configure.Done,3,20", "Configure.Done,3,0"),
    ("blend.rung", "blend-profile", "[1000, 4000, 2000]", "[1000, 1, 2000]"),
    ("blend.rung", "execute-never-falls", "Axis,Pressed,1", "Axis,Program.Done,1"),
    ("bits.rung", "lossy-conversion", "MOV(Now.Time,Run.PRE);", "MOV(2.75,Run.PRE);"),
    (
        "state.py",
        "unknown-attribute",
        "def go(self, step, now_ns):\n        self.step = step",
        "def go(self, step, now_ns):\n        self.stepp = step",
    ),
    (
        "state.py",
        "input-written",
        "start = scan.slot[2].inputs.bit(0, 0)",
        "start = scan.slot[2].inputs.bit(0, 0)\n    scan.slot[2].inputs.set_bit(0, 1, True)",
    ),
    ("lights.py", "latch-never-cleared", "self.run = False\n        self.lamp", "pass\n        self.lamp"),
    ("lights.py", "contradiction", "self.lamp = self.run", "self.lamp = self.run and not self.run"),
    ("lights.py", "preset-zero", "Counter(12)", "Counter(0)"),
    ("lights.py", "not-deterministic", "if self.stop:", "if datetime.now().second > 3:"),
    (
        "lights.py",
        "block-twice",
        "self.fan = self.cooling(self.run)",
        "self.fan = self.cooling(self.run)\n        self.cooling(self.stop)",
    ),
    (
        "lights.py",
        "repeated-coil",
        "self.fan = self.cooling(self.run)",
        "self.fan = self.cooling(self.run)\n        self.fan = self.run",
    ),
    (
        "pick.py",
        "move-interrupted",
        "self.z.move_to(500, speed=SPEED // 2, **RATES)",
        "self.x.move_to(500, speed=SPEED // 2, **RATES)",
    ),
    ("follow.py", "refused-command", "quadrature_encoder=True, ", ""),
    (
        "follow.py",
        "two-sequences",
        "async with self.lock:\n                await self.belt",
        "if True:\n                await self.belt",
    ),
    (
        "follow.py",
        "lock-order",
        "async with self.lock:\n                self.busy",
        "async with self.lock, self.lock:\n                self.busy",
    ),
]
"""Further ones, in other programs."""

PLANTED = [
    *_planted("blocks.rung", RUNGS),
    *_planted("words.rung", WORDS),
    *_planted("tasks.rung", TASKS),
    *_planted("text.rung", TEXT),
    *_planted("function.py", FUNCTION),
    *_planted("sequence.py", SEQUENCE),
    *(Planted(*each, anywhere=True) for each in (*SHARED, *OF_PYTHON, *FURTHER)),
    # a value that stays on after a value that falls, and a state that is there nowhere before the ELSE
    Planted("blocks_st.rung", "execute-never-falls", "Clear := Start;", "Clear := 1;", "MC_Reset(Reset"),
    Planted(
        "blocks_st.rung",
        "unreachable",
        "Moving := Axis.Moving;",
        "IF Stop THEN Moving := 1; ELSIF NOT Stop THEN Moving := 0; ELSE Target := 9; END_IF;",
        "IF Stop THEN Moving",
    ),
    Planted("blocks.rung", "preset-unit", "TON(Blink,250,0)", "TON(Blink,2,0)"),
    Planted("text.rung", "preset-unit", '{"PRE": 500}', '{"PRE": 5}'),
    Planted("sequence.py", "preset-unit", 'dwell("100 ms")', 'dwell("1 ms")'),
    Planted("blocks.rung", "integer-zero", "DIV(Count.ACC,10,Rate)", "DIV(1,10,Rate)"),
    Planted("text.rung", "integer-zero", "Mean := Parts / 4;", "Mean := Parts * (1 / 4);"),
    Planted("function.py", "integer-zero", "(station + 1) % 3", "(station + 1) % 3 // 3"),
    Planted(
        *("zones.rung", "no-interlock"),
        "LBL(on)XIC(Goes)XIC(Dir)OTE(Lift);\nXIC(Goes)XIO(Dir)OTE(Sink);",
        "LBL(on)XIC(Up)OTE(Lift);\nXIC(Down)OTE(Sink);",
    ),
    Planted(
        "blocks.rung", "never-run", "XIC(Back.Done)CTU(Count,0,0);", "XIC(Back.Done)NOP();", "DIV(Count.ACC"
    ),
    Planted(
        *("sequence.py", "never-run"),
        "self.lamp = self.late(self.feeder.moving)",
        "self.lamp = self.feeder.moving and not self.late",
    ),
    Planted("blocks.rung", "beyond-limit", "OutGo,6000", "OutGo,16000"),
    Planted("sequence.py", "beyond-limit", "(0, 4000, 8000)", "(0, 4000, 18000)", "self.feeder.move_to"),
    Planted("blocks.rung", "negative-preset", "TON(Blink,250,0)", "TON(Blink,-250,0)"),
    Planted("text.rung", "real-equality", "Mean > 2.5", "Mean = 2.5", "Mean = 2.5"),
    Planted(
        "blocks.rung", "real-equality", "LES(Rate,3)", "DIV(Rate,7.0,Average)EQU(Average,2.5)LES(Rate,3)"
    ),
    Planted(
        *("text.rung", "step-without-exit"),
        "    Parts := Parts + 1;\n    Step := 0;",
        "    Parts := Parts + 1;",
        "Step := 20",
    ),
    Planted(
        *("blocks.rung", "subscript"),
        "LES(Rate,3)",
        "XIC(Full)ADD(Border,1,Border)MOV(1,Lengths[Border]);\nLES(Rate,3)",
        "MOV(1,Lengths[Border])",
    ),
]


OF_THE_RACK = {
    "drive-differs": ("a motion block", "`XIC(axis.status.STOPPED)`, checked with `--for smd23e2`"),
    "not-configured": ("a wired CW limit, and 16#8434 in word 0", "a wired CW limit, and 16#8424 in word 0"),
    "wrong-level": (
        "a normally closed home switch, and 16#003B in word 1",
        "a normally closed home switch, and 16#003F in word 1",
    ),
    "search-without-switch": ("a home switch in [slot.machine]", "a home search without one"),
    "unused-terminal": ("inputs = { start = 0 } and XIC(Local:2:I.Data.0)", "inputs = { start = 0 } alone"),
    "unreached-step": ("TRANSITION T FROM A TO B", "a step B without a transition to it"),
    "refused": ("self.lamp = True", "self.lmap = True, a field that the class does not declare"),
    "unknown-tag": ('tags = ["Pulse"]', 'tags = ["Pluse"]'),
}
"""Rules about the rack file, which test_check.py plants: what is right, and what is wrong."""


def text_of(planted):
    """Return the program with the mistake."""
    text = SOUND[planted.program]
    assert planted.old in text, planted
    text = text.replace(planted.old, planted.new, 1 if planted.anywhere else -1)
    for name, kind in TAGS.items():
        if name == "OutC" and re.search(rf"\b{name}\b", planted.new):
            text = text.replace("TAG ", f"TAG {name} : {kind}\nTAG ", 1)
        elif planted.program.endswith(".rung") and re.search(rf"\b{name}\b", planted.new):
            text = text.replace("TAG Run : BOOL", f"TAG Run : BOOL\nTAG {name} : {kind}", 1)
    if "datetime" in planted.new:
        text = f"from datetime import datetime\n{text}"
    for module in ("random", "time"):
        if re.search(rf"\b{module}\.", planted.new):
            text = f"import {module}\n{text}"
    if "Pulse2" in planted.new:
        text = text.replace("TAG Pulse", "TAG Pulse2 : INT\nTAG Pulse", 1)
    if "Extra" in planted.new and "SBR" in planted.new:
        text = text.replace("TAG Deep : DINT", "TAG Deep : DINT\nTAG Extra : DINT")
    if "self.permit" in planted.new:
        text = text.replace("    running = False", "    running = False\n    permit = False")
    return text
