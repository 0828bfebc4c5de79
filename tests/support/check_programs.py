"""Sound programs for `scanrack check`: rungs, structured text, Python, sequences; and a way to check one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scanrack.jobs.check import CheckReport, check_rack, load_any

SWITCHES = """
[slot.machine]
switches = [
    { input = "home", first = -1500, last = -1300 },
    { input = "ccw_limit", last = -4000 },
    { input = "cw_limit", first = 12000 },
]
"""

RACK = f"""\
program = "PROGRAM"
CONTROLLER
[[slot]]
number = 1
module = "amci3601"
{SWITCHES}
[[slot]]
number = 2
module = "1769-IQ16"

[[slot]]
number = 3
module = "1769-OB16"

[[slot]]
number = 4
module = "amci3601"
{SWITCHES}
"""

USED = "Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)"

BLOCKS = """\
PROGRAM line
USE axis3601

SLOT card : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Full : Local:2:I.Data.2
ALIAS Clear : Local:2:I.Data.3
ALIAS Lamp : Local:3:O.Data.0
ALIAS Horn : Local:3:O.Data.1
ALIAS Valve : Local:3:O.Data.2
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Configure : Configure3601
TAG Home : MC_Home
TAG Out : MC_MoveAbsolute
TAG Back : MC_MoveAbsolute
TAG Reset : MC_Reset
TAG Awake : BOOL
TAG Run : BOOL
TAG Homing : BOOL
TAG OutGo : BOOL
TAG BackGo : BOOL
TAG Alarm : BOOL
TAG Pressed : BOOL
TAG Quiet : TIMER
TAG Blink : TIMER
TAG Count : COUNTER
TAG Speed : DINT := 4000
TAG Fast : BOOL
TAG Rate : DINT
TAG Share : DINT

ROUTINE Main
XIO(S:FS)OTE(Awake);
[XIC(Start),XIC(Run)]XIC(Stop)XIO(Alarm)OTE(Run);
XIC(Run)OTE(Lamp);
XIC(card.status.INPUT_ERROR)OTL(Alarm);
XIC(Clear)ONS(Pressed)OTU(Alarm);
XIC(Alarm)OTE(Horn);
XIC(Alarm)XIO(Clear)TON(Quiet,1000,0);
Configure3601(Configure,Axis,Words,Awake);
MC_Reset(Reset,Axis,Quiet.DN);
XIC(Run)XIC(Configure.Done)XIC(card.status.POSITION_INVALID)OTE(Homing);
MC_Home(Home,Axis,Homing,-1,2000,10,10);
XIC(Full)MOV(6000,Speed);
XIO(Full)MOV(4000,Speed);
GRT(Speed,5000)OTE(Fast);
XIC(Fast)TON(Blink,250,0);
XIC(Blink.DN)OTE(Valve);
XIC(Run)XIO(Homing)XIO(Home.Busy)XIO(Out.Done)XIO(BackGo)OTE(OutGo);
XIC(Run)XIC(Out.Done)XIO(Back.Done)OTE(BackGo);
MC_MoveAbsolute(Out,Axis,OutGo,6000,Speed,10,10);
MC_MoveAbsolute(Back,Axis,BackGo,0,8000,10,10);
XIC(Back.Done)CTU(Count,0,0);
DIV(Count.ACC,10,Rate)MOD(Count.ACC,10,Share);
LES(Rate,3)GRT(Share,5)NOP();
MOV(card.I.Fault,Module.Fault)Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""
"""Rungs with motion blocks."""

WORDS = """\
PROGRAM line
SLOT axis : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Lamp : Local:3:O.Data.0
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Preset : INT[8] := [16#0200, 0, 0, 0, 0, 0, 0, 0]
TAG Go : INT[8] := [1, 0, 4, 0, 5, 0, 10, 10]
TAG Pulse : BOOL

ROUTINE Main
XIC(S:FS)COP(Words,axis.O.Data,8);
XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)FLL(0,axis.O.Data,8);
XIO(axis.status.MODE_CONFIG)XIC(axis.status.POSITION_INVALID)COP(Preset,axis.O.Data,8);
XIC(axis.command.PRESET_POSITION)XIO(axis.status.POSITION_INVALID)FLL(0,axis.O.Data,8);
XIO(axis.status.MODE_CONFIG)XIO(axis.status.POSITION_INVALID)XIC(Start)ONS(Pulse)COP(Go,axis.O.Data,8);
[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVING_CCW)]CLR(axis.O.Data[0]);
XIC(axis.status.MOVE_COMPLETE)OTE(Lamp);
END
"""
"""Rungs that write the words of a module."""

TASKS = """\
CONTROLLER plant
INSTRUCTION Scaled
INPUT Raw : DINT REQUIRED
INPUT Gain : DINT REQUIRED
OUTPUT Value : DINT
LOCAL Wide : DINT
ROUTINE Logic
MUL(Raw,Gain,Wide);
DIV(Wide,100,Value);
END
END INSTRUCTION
TAG Level : DINT
TAG Wanted : DINT := 50
TAG Open : BOOL
TASK Cycle : CONTINUOUS RUNS Main
TASK Fast : PERIODIC 10 ms PRIORITY 3 RUNS Filter
PROGRAM Main MAIN Start
TAG Deep : DINT
TAG Gauge : Scaled
ROUTINE Start
JSR(Check,1,Level,Deep);
Scaled(Gauge,Deep,150);
GRT(Gauge.Value,Wanted)OTE(Open);
XIC(Open)OTE(Local:3:O.Data.0);
END
ROUTINE Check
SBR(Deep);
LES(Deep,0)MOV(0,Deep);
RET(Deep);
END
END PROGRAM
PROGRAM Filter MAIN Start
TAG Last : DINT
ROUTINE Start
MOV(Local:2:I.Data[0],Last);
CPT(Level,(Last+Level*3)/4);
END
END PROGRAM
"""
"""A controller with two tasks, a subroutine and an add-on instruction."""

TEXT = """\
PROGRAM line
SLOT axis : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
ALIAS Valve : Local:3:O.Data.1
ALIAS Horn : Local:3:O.Data.2
TAG Run : BOOL
TAG Seen : BOOL
TAG Step : DINT
TAG Parts : DINT
TAG Mean : REAL
TAG Small : INT
TAG Delay : FBD_TIMER := {"PRE": 500}
TAG Edge : FBD_ONESHOT
TAG I : DINT
TAG Levels : DINT[4]

ROUTINE Main ST
Run := (Start OR Run) AND NOT Stop;
Lamp := Run AND axis.status.MODULE_OK;
Edge.InputBit := Start;
OSRI(Edge);
IF Edge.OutputBit THEN
    Seen := 1;
ELSIF Stop THEN
    Seen := 0;
END_IF;
Horn := Seen;
Delay.TimerEnable := Run;
TONR(Delay);
CASE Step OF
0:
    IF Run THEN Step := 10; END_IF;
10:
    Valve := 1;
    IF Delay.DN THEN Step := 20; END_IF;
20:
    Valve := 0;
    Parts := Parts + 1;
    Step := 0;
END_CASE;
FOR I := 0 TO 3 DO
    Levels[I] := Parts MOD (I + 2);
    IF Levels[I] > 2 THEN EXIT; END_IF;
END_FOR;
Mean := Parts / 4;
Small := Parts MOD 100;
IF Small > 50 AND Mean > 2.5 THEN
    Parts := 0;
END_IF;
END
"""
"""Structured text."""

FUNCTION = f"""\
from scanrack import Idle, InputBit, Configuration, Move, MoveKind, PresetPosition, StatusView

SPEED = 5000
SETTINGS = {USED}


class Line:
    step = "configure"
    station = 0
    before = False


line = Line()


def logic(scan):
    axis = scan.slot[1]
    status = StatusView(axis.inputs)
    outputs = axis.outputs
    pulse = scan.slot[2].inputs.bit(0, 0)
    scan.slot[3].outputs.set_bit(0, 0, status.MOVE_COMPLETE)
    if line.step == "configure":
        outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            line.step = "preset"
    elif line.step == "preset":
        outputs.load(PresetPosition(0).to_image())
        if not status.POSITION_INVALID:
            outputs.load(Idle().to_image())
            line.step = "wait"
    elif line.step == "wait":
        if pulse and not line.before:
            line.station = next_station(line.station)
            move = Move(MoveKind.ABSOLUTE, 4000 * line.station, speed=SPEED, acceleration=10, deceleration=10)
            outputs.load(move.to_image())
            line.step = "move"
    elif status.MOVE_COMPLETE:
        outputs[0] = 0
        line.step = "wait"
    line.before = pulse


def next_station(station):
    return (station + 1) % 3
"""
"""A function of the scan."""

SEQUENCE = f"""\
from scanrack import (
    Axis3601, AxisError, BlendSegment, Configuration, Direction, Input, InputBit, Lock, Logic, OnDelay,
    Output, dwell, sequence, steady, until, within,
)

SETTINGS = {USED}
STATIONS = (0, 4000, 8000)
PATH = (BlendSegment(length=1000, speed=1000, rate=10), BlendSegment(length=4000, speed=8000, rate=50))


class Line(Logic):
    feeder = Axis3601(1, SETTINGS)
    pusher = Axis3601(4, SETTINGS)
    start = Input("Local:2:I.Data.0")
    stop = Input("Local:2:I.Data.1")
    full = Input("Local:2:I.Data.2")
    lamp: Output = Output("Local:3:O.Data.0")
    valve: Output = Output("Local:3:O.Data.1")
    late = OnDelay("2 s")
    zone = Lock()
    table = Lock()
    running = False
    homed = False
    speed = 3000
    parts = 0

    def every_scan(self) -> None:
        if self.stop:
            self.running = False
        elif self.start:
            self.running = True
        self.lamp = self.late(self.feeder.moving)

    @sequence
    async def feed(self) -> None:
        await self.feeder.configure()
        await self.feeder.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        self.homed = True
        while True:
            await until(lambda: self.running, "running")
            self.speed = 2000 if self.full else 3000
            for station in STATIONS:
                async with self.zone:
                    await self.stroke(station, self.speed)
            self.parts += 1

    async def stroke(self, target: int, speed: int) -> None:
        try:
            await within("5 s", self.feeder.move_to(target, speed=speed, acceleration=20, deceleration=20))
        except AxisError:
            await self.feeder.reset()
        await dwell("100 ms")

    @sequence
    async def push(self) -> None:
        await self.pusher.configure()
        await self.pusher.set_position(0)
        await self.pusher.program_blend(PATH, final_deceleration=20)
        while True:
            await until(lambda: self.running and self.homed)
            async with self.zone:
                async with self.table:
                    self.valve = True
                    await self.pusher.run_blend(Direction.CW)
                    await self.pusher.run_blend(Direction.CCW)
                    self.valve = False
            await steady(lambda: not self.full, "200 ms")
"""
"""A class with sequences, two axes and locks."""

SOUND = {
    "blocks.rung": BLOCKS,
    "words.rung": WORDS,
    "tasks.rung": TASKS,
    "text.rung": TEXT,
    "function.py": FUNCTION,
    "sequence.py": SEQUENCE,
}
"""Sound programs by name."""


def check(
    folder: Path, name: str, text: str, *, controller: str = "", rack: str = RACK, **options: Any
) -> CheckReport:
    """Check a program in the rack."""
    (folder / name.partition(":")[0]).write_text(text, encoding="utf-8")
    file = folder / "rack.toml"
    given = f'controller = "{controller}"' if controller else ""
    file.write_text(rack.replace("PROGRAM", name).replace("CONTROLLER", given), encoding="utf-8")
    return check_rack(load_any(str(file))[0], **options)
