"""Further sound programs for `scanrack check`, in the style of real machines: none of them has a finding."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

from check_machines import MACHINES
from check_programs import SOUND, USED
from check_stations import STATIONS

CONVEYOR = """\
PROGRAM conveyor
ALIAS Start : Local:2:I.Data.0
ALIAS StopOk : Local:2:I.Data.1
ALIAS Infeed : Local:2:I.Data.2
ALIAS Outfeed : Local:2:I.Data.3
ALIAS Overload : Local:2:I.Data.4
ALIAS Reset : Local:2:I.Data.5
ALIAS Motor : Local:3:O.Data.0
ALIAS Beacon : Local:3:O.Data.1
ALIAS Stack : Local:3:O.Data.2
TAG Run : BOOL
TAG Fault : BOOL
TAG Jam : TIMER
TAG Flash : TIMER
TAG Slow : TIMER
TAG Pieces : COUNTER
TAG Edge : BOOL
TAG Phase : BOOL

ROUTINE Main
JSR(Control,0);
JSR(Outputs,0);
END
ROUTINE Control
[XIC(Start),XIC(Run)]XIC(StopOk)XIO(Fault)OTE(Run);
XIC(Run)XIC(Infeed)XIO(Outfeed)TON(Jam,3000,0);
[XIC(Jam.DN),XIC(Overload)]OTL(Fault);
XIC(Reset)XIO(Overload)OTU(Fault);
XIC(Outfeed)ONS(Edge)CTU(Pieces,24,0);
XIC(Pieces.DN)TON(Slow,500,0);
XIC(Slow.DN)RES(Pieces);
XIO(Flash.DN)TON(Flash,400,0);
XIC(Flash.DN)XIO(Phase)OTE(Phase);
END
ROUTINE Outputs
XIC(Run)XIO(Pieces.DN)OTE(Motor);
XIC(Pieces.DN)OTE(Stack);
XIC(Fault)[XIC(Phase),XIC(Overload)]OTE(Beacon);
END
"""

TANK = """\
PROGRAM tank
ALIAS Auto : Local:2:I.Data.0
ALIAS Low : Local:2:I.Data.1
ALIAS High : Local:2:I.Data.2
ALIAS Pump : Local:3:O.Data.0
ALIAS Alarm : Local:3:O.Data.1
TAG Level : REAL
TAG Raw : DINT
TAG Mean : REAL[8]
TAG Sum : REAL
TAG At : DINT
TAG I : DINT
TAG Filling : BOOL
TAG Wait : FBD_TIMER := {"PRE": 2000}
TAG Limits : REAL[2] := [20.0, 80.0]

ROUTINE Main ST
Raw := Local:2:I.Data[0];
Level := Raw * 100.0 / 32767.0;
Mean[At] := Level;
At := (At + 1) MOD 8;
Sum := 0.0;
FOR I := 0 TO 7 DO
    Sum := Sum + Mean[I];
END_FOR;
Level := Sum / 8.0;
IF NOT Auto THEN
    Filling := 0;
ELSIF Level < Limits[0] OR Low THEN
    Filling := 1;
ELSIF Level > Limits[1] OR High THEN
    Filling := 0;
END_IF;
Wait.TimerEnable := Filling;
TONR(Wait);
Pump := Filling AND NOT High;
Alarm := Wait.DN AND Low;
END
"""

WORDS_ST = """\
PROGRAM move
SLOT axis : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Busy : Local:3:O.Data.0
TAG Step : DINT
TAG Target : DINT
TAG I : DINT
TAG Stations : DINT[3] := [0, 4000, 8000]
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Before : BOOL

ROUTINE Main ST
CASE Step OF
0:
    COP(Words[0], axis.O.Data[0], 8);
    IF axis.status.MODE_CONFIG AND NOT axis.status.CONFIG_ERROR THEN
        Step := 10;
    END_IF;
10:
    FOR I := 0 TO 7 DO
        axis.O.Data[I] := 0;
    END_FOR;
    IF NOT axis.status.MODE_CONFIG THEN Step := 20; END_IF;
20:
    axis.command.PRESET_POSITION := 1;
    IF NOT axis.status.POSITION_INVALID THEN
        axis.command.PRESET_POSITION := 0;
        Step := 30;
    END_IF;
30:
    IF Start AND NOT Before THEN
        Target := Target + 1;
        IF Target > 2 THEN Target := 0; END_IF;
        axis.O.Data[2] := Stations[Target] / 1000;
        axis.O.Data[3] := Stations[Target] MOD 1000;
        axis.O.Data[4] := 5;
        axis.O.Data[5] := 0;
        axis.O.Data[6] := 20;
        axis.O.Data[7] := 20;
        axis.O.Data[0] := 1;
        Step := 40;
    END_IF;
40:
    IF axis.status.MOVING_CW OR axis.status.MOVING_CCW THEN
        axis.O.Data[0] := 0;
        Step := 50;
    END_IF;
50:
    IF axis.status.MOVE_COMPLETE THEN Step := 30; END_IF;
END_CASE;
Before := Start;
Busy := Step >= 40;
END
"""

JOG = """\
PROGRAM jog
USE axis3601
SLOT card : 1
ALIAS Right : Local:2:I.Data.0
ALIAS Left : Local:2:I.Data.1
ALIAS Fast : Local:2:I.Data.2
ALIAS Clear : Local:2:I.Data.3
ALIAS Moving : Local:3:O.Data.0
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Configure : Configure3601
TAG Jog : MC_MoveVelocity
TAG Halt : MC_Halt
TAG Reset : MC_Reset
TAG Awake : BOOL
TAG Any : BOOL
TAG Speed : DINT
TAG Released : BOOL

ROUTINE Main
XIO(S:FS)OTE(Awake);
Configure3601(Configure,Axis,Words,Awake);
MC_Reset(Reset,Axis,Clear);
XIC(Configure.Done)[XIC(Right)XIO(Left),XIC(Left)XIO(Right)]OTE(Any);
[XIC(Fast)MOV(3000,Speed),XIO(Fast)MOV(200,Speed)];
XIC(Left)NEG(Speed,Speed);
MC_MoveVelocity(Jog,Axis,Any,Speed,10,10);
XIO(Any)OTE(Released);
MC_Halt(Halt,Axis,Released);
XIC(Axis.Moving)OTE(Moving);
MOV(card.I.Fault,Module.Fault)Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""

TWO_AXES = """\
PROGRAM pair
USE axis3601
SLOT one : 1
SLOT two : 4
ALIAS Go : Local:2:I.Data.0
ALIAS Lamp : Local:3:O.Data.0
TAG AxisA : AXIS_3601
TAG AxisB : AXIS_3601
TAG ModuleA : Amci3601
TAG ModuleB : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG SetA : Configure3601
TAG SetB : Configure3601
TAG HomeA : MC_Home
TAG HomeB : MC_Home
TAG MoveA : MC_MoveRelative
TAG MoveB : MC_MoveAbsolute
TAG Awake : BOOL
TAG Both : BOOL
TAG GoA : BOOL
TAG GoB : BOOL

ROUTINE Main
XIO(S:FS)OTE(Awake);
Configure3601(SetA,AxisA,Words,Awake)Configure3601(SetB,AxisB,Words,Awake);
MC_Home(HomeA,AxisA,SetA.Done,-1,1000,10,10);
MC_Home(HomeB,AxisB,SetB.Done,-1,1000,10,10);
XIC(HomeA.Done)XIC(HomeB.Done)OTE(Both);
XIC(Both)XIC(Go)XIO(MoveB.Busy)OTE(GoA);
MC_MoveRelative(MoveA,AxisA,GoA,1000,2000,10,10);
XIC(MoveA.Done)OTE(GoB);
MC_MoveAbsolute(MoveB,AxisB,GoB,4000,2000,10,10);
XIC(MoveB.Done)OTE(Lamp);
Amci3601(ModuleA,AxisA,one.I.Data[0],one.O.Data[0]);
Amci3601(ModuleB,AxisB,two.I.Data[0],two.O.Data[0]);
END
"""

BLOCKS_ST = """\
PROGRAM blocks_st
USE axis3601
SLOT card : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Moving : Local:3:O.Data.0
ALIAS Lamp : Local:3:O.Data.1
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Configure : Configure3601
TAG Home : MC_Home
TAG Go : MC_MoveAbsolute
TAG Reset : MC_Reset
TAG Awake : BOOL
TAG Seek : BOOL
TAG Going : BOOL
TAG Clear : BOOL
TAG Run : BOOL
TAG State : DINT
TAG Target : DINT

ROUTINE Main ST
Awake := NOT S:FS;
Configure3601(Configure,Axis,Words,Awake);
Clear := Start;
MC_Reset(Reset,Axis,Clear);
IF Start AND NOT Stop THEN
    Run := 1;
ELSIF Stop THEN
    Run := 0;
END_IF;
Seek := Run AND Configure.Done;
MC_Home(Home,Axis,Seek,-1,2000,10,10);
Going := Run AND Home.Done AND NOT Go.Done;
MC_MoveAbsolute(Go,Axis,Going,Target,4000,10,10);
CASE State OF
    0: IF Going THEN State := 1; END_IF;
    1: IF Go.Done THEN State := 2; END_IF;
    2: Target := 6000 - Target; State := 0;
ELSE
    State := 0;
END_CASE;
IF State = 0 THEN
    Lamp := 0;
ELSIF State = 1 OR State = 2 THEN
    Lamp := 1;
ELSE
    Lamp := Stop;
END_IF;
Moving := Axis.Moving;
Module.Fault := card.I.Fault;
Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""
"""Blocks in structured text, whose Execute falls with its value, and a CASE with an ELSE for states there are not."""

BLEND = """\
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
TAG Program : ProgramBlend3601
TAG Run : RunBlend3601
TAG Awake : BOOL
TAG Pressed : BOOL

ROUTINE Main
XIO(S:FS)OTE(Awake);
Configure3601(Configure,Axis,Words,Awake);
ProgramBlend3601(Program,Axis,Lengths,Speeds,Rates,Configure.Done,3,20);
XIC(Program.Done)XIC(Go)OTE(Pressed);
RunBlend3601(Run,Axis,Pressed,1);
Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""

BITS = """\
PROGRAM bits
TYPE Recipe (Speed : DINT, Time : DINT, Name : STRING)
ALIAS Select : Local:2:I.Data.0
ALIAS Start : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
ALIAS Horn : Local:3:O.Data.1
TAG Book : Recipe[4] := [{"Speed": 100, "Time": 500}, {"Speed": 200, "Time": 800}]
TAG Now : Recipe
TAG Index : DINT
TAG Rise : BOOL
TAG Out : BOOL
TAG Word : DINT
TAG Run : TIMER
TAG Queue : DINT[16]
TAG Store : CONTROL
TAG Taken : DINT

ROUTINE Main
XIC(Select)OSR(Rise,Out);
XIC(Out)ADD(Index,1,Index)MOD(Index,4,Index)COP(Book[Index],Now,1);
MOV(Now.Time,Run.PRE);
XIC(Start)TON(Run,?,?);
XIC(Run.DN)OTE(Lamp);
MOV(Local:2:I.Data[0],Word);
XIC(Word.3)XIO(Word.4)GRT(Now.Speed,150)OTE(Horn);
XIC(Out)FFL(Now.Speed,Queue[0],Store,16,0);
XIC(Start)FFU(Queue[0],Taken,Store,16,0);
GRT(Taken,250)CLR(Taken);
END
"""

CLASS = f"""\
from dataclasses import dataclass, field

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, Move, MoveKind, StatusView

SETTINGS = {USED}


@dataclass
class State:
    step: int = 0
    queue: list = field(default_factory=list)
    since_ns: int = 0

    def go(self, step, now_ns):
        self.step = step
        self.since_ns = now_ns


state = State()


def logic(scan):
    axis, status = scan.slot[1], StatusView(scan.slot[1].inputs)
    start = scan.slot[2].inputs.bit(0, 0)
    if state.step == 0:
        axis.outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG:
            axis.outputs.load(Idle().to_image())
            state.go(1, scan.now_ns)
    elif state.step == 1 and not status.MODE_CONFIG:
        axis.outputs.load(FindHome(Direction.CCW, 1000, 10, 10).to_image())
        state.go(2, scan.now_ns)
    elif state.step == 2 and status.AT_HOME:
        axis.outputs[0] = 0
        state.queue = [4000, 0]
        state.go(3, scan.now_ns)
    elif state.step == 3 and start and state.queue:
        target = state.queue.pop(0)
        axis.outputs.load(Move(MoveKind.ABSOLUTE, target, 5000, 20, 20).to_image())
        state.go(4, scan.now_ns)
    elif state.step == 4 and status.MOVE_COMPLETE and scan.now_ns - state.since_ns > 50_000_000:
        axis.outputs.load(Idle().to_image())
        state.go(3, scan.now_ns)
    scan.slot[3].outputs.set_bit(0, 0, state.step == 4)
"""

LIGHTS = """\
from scanrack import Counter, Fall, Input, InputWord, Logic, OffDelay, OnDelay, Output, OutputWord, Pulse, Rise


class Lights(Logic):
    start = Input("Local:2:I.Data.0")
    stop = Input("Local:2:I.Data.1")
    sensor = Input("Local:2:I.Data.2")
    raw = InputWord("Local:2:I.Data[0]")
    lamp: Output = Output("Local:3:O.Data.0")
    horn: Output = Output("Local:3:O.Data.1")
    fan: Output = Output("Local:3:O.Data.2")
    full: Output = Output("Local:3:O.Data.3")
    late = OnDelay("2 s")
    cooling = OffDelay("30 s")
    beep = Pulse("500 ms")
    pieces = Counter(12)
    pressed = Rise()
    released = Fall()
    run = False
    bits = 0
    message = ""

    def every_scan(self) -> None:
        if self.pressed(self.start) and not self.stop:
            self.run = True
        if self.stop:
            self.run = False
        self.lamp = self.run
        self.horn = self.beep(self.late(self.run and not self.sensor))
        self.fan = self.cooling(self.run)
        self.full = self.pieces(self.sensor, reset=self.released(self.start))
        self.bits = self.raw & 0xFF
        self.message = "running" if self.run else "stopped"
"""

PICK = f"""\
from scanrack import (
    Axis3601, AxisError, CommandAborted, Configuration, Direction, Input, InputBit, Logic, Output, State, WaitTimeout,
    all_of, dwell, first_of, sequence, until, within,
)

X_SETTINGS = {USED}
SPEED = 4000
RATES = {{"acceleration": 20, "deceleration": 20}}


class Picker(Logic):
    x = Axis3601(1, X_SETTINGS)
    z = Axis3601(4, X_SETTINGS)
    part = Input("Local:2:I.Data.0")
    estop = Input("Local:2:I.Data.1")
    gripped = Input("Local:2:I.Data.2")
    grip: Output = Output("Local:3:O.Data.0")
    alarm: Output = Output("Local:3:O.Data.1")
    picked = 0
    state_text = "idle"
    ready = False

    @sequence
    async def work(self) -> None:
        while True:
            try:
                await self.prepare()
                while True:
                    await self.pick()
                    await self.place()
            except (AxisError, CommandAborted) as error:
                self.state_text = str(error)
                self.grip = False
                self.alarm = True
                await until(lambda: not self.estop)
                await dwell("1 s")
                self.alarm = False

    async def prepare(self) -> None:
        self.ready = False
        for axis in (self.x, self.z):
            if axis.state == State.DISABLED:
                await axis.configure()
            if axis.state == State.ERROR_STOP:
                await axis.reset()
            await axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        self.ready = True

    async def pick(self) -> None:
        await until(lambda: self.ready and bool(self.part))
        await all_of(
            self.x.move_to(0, speed=SPEED, **RATES),
            self.z.move_to(500, speed=SPEED // 2, **RATES),
        )
        self.grip = True
        try:
            await within("500 ms", self.gripped.on)
        except WaitTimeout:
            self.grip = False
            return
        self.picked += 1

    async def place(self) -> None:
        stop = self.estop.rises
        move = self.x.move_by(6000 if self.picked % 2 else 3000, speed=SPEED, **RATES)
        if await first_of(move, stop) is stop:
            await self.x.halt()
        await self.z.move_to(0, speed=SPEED, **RATES)
        self.grip = False
"""

FOLLOW = """\
from scanrack import Axis3601, Configuration, Input, InputBit, Lock, Logic, Output, dwell, sequence, until

USED = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
GEARED = Configuration(inputs_used=USED, quadrature_encoder=True, starting_speed=500)


class Follow(Logic):
    belt = Axis3601(1, GEARED)
    go = Input("Local:2:I.Data.0")
    busy: Output = Output("Local:3:O.Data.0")
    ready: Output = Output("Local:3:O.Data.1")
    lock = Lock()
    shift = 0

    @sequence
    async def follow(self) -> None:
        await self.belt.configure()
        while True:
            await self.go.rises
            async with self.lock:
                self.busy = True
                self.belt.gear(2, 1)
                await self.go.falls
                await self.belt.gear_out()
                self.busy = False

    @sequence
    async def correct(self) -> None:
        while True:
            self.ready = bool(self.belt.state)
            await until(lambda: self.shift != 0 and not self.belt.moving)
            async with self.lock:
                await self.belt.move_by(max(-100, min(self.shift, 100)), speed=800, acceleration=10, deceleration=10)
                self.shift = 0
            await dwell("20 ms")

    def every_scan(self) -> None:
        if self.belt.captured and self.belt.encoder > 1000:
            self.shift = 10
"""

SOUND = {
    **SOUND,
    **MACHINES,
    **STATIONS,
    "conveyor.rung": CONVEYOR,
    "tank.rung": TANK,
    "words_st.rung": WORDS_ST,
    "jog.rung": JOG,
    "two_axes.rung": TWO_AXES,
    "blocks_st.rung": BLOCKS_ST,
    "blend.rung": BLEND,
    "bits.rung": BITS,
    "state.py": CLASS,
    "lights.py": LIGHTS,
    "pick.py": PICK,
    "follow.py": FOLLOW,
}
"""All sound programs by name."""
