"""More sound programs for `scanrack check`, of stations as machine builders have them."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

from check_steps import FEEDER, PACKER

PRESS_ST = """\
PROGRAM press
ALIAS LeftHand : Local:2:I.Data.0
ALIAS RightHand : Local:2:I.Data.1
ALIAS Top : Local:2:I.Data.2
ALIAS Bottom : Local:2:I.Data.3
ALIAS Guard : Local:2:I.Data.4
ALIAS Ack : Local:2:I.Data.5
ALIAS Down : Local:3:O.Data.0
ALIAS Up : Local:3:O.Data.1
ALIAS Red : Local:3:O.Data.2
ALIAS Green : Local:3:O.Data.3
TAG TwoHand : FBD_TIMER := {"PRE": 400}
TAG Holding : FBD_TIMER := {"PRE": 1500}
TAG Watch : FBD_TIMER := {"PRE": 8000}
TAG Counter1 : FBD_COUNTER := {"PRE": 500}
TAG State : DINT
TAG Tied : BOOL
TAG BothHands : BOOL
TAG Fault : BOOL
TAG FaultCode : INT
TAG Tonnage : REAL
TAG Peak : REAL
TAG Samples : INT[16]
TAG Head : DINT
TAG K : DINT
TAG Sum : DINT

ROUTINE Main ST
(* two hands within 400 ms, one stroke per press *)
TwoHand.TimerEnable := LeftHand XOR RightHand;
TONR(TwoHand);
IF TwoHand.DN THEN Tied := 1; END_IF;
IF NOT LeftHand AND NOT RightHand THEN Tied := 0; END_IF;
BothHands := LeftHand AND RightHand AND NOT Tied AND Guard;

CASE State OF
0:
    IF BothHands AND Top AND NOT Fault THEN State := 1; END_IF;
1:
    IF Bottom THEN
        State := 2;
    ELSIF NOT BothHands THEN
        State := 3;
    END_IF;
2:
    IF Holding.DN THEN State := 3; END_IF;
3:
    IF Top AND NOT BothHands THEN State := 0; END_IF;
END_CASE;
Holding.TimerEnable := State = 2;
TONR(Holding);
Watch.TimerEnable := State = 1 OR State = 3;
TONR(Watch);
Counter1.CUEnable := State = 2;
Counter1.Reset := Ack;
CTUD(Counter1);

(* tonnage *)
Samples[Head] := Local:2:I.Data[0];
Head := (Head + 1) MOD 16;
Sum := 0;
FOR K := 0 TO 15 DO
    Sum := Sum + Samples[K];
END_FOR;
Tonnage := Sum / 16.0;
IF Tonnage > Peak THEN Peak := Tonnage; END_IF;

IF Watch.DN THEN
    Fault := 1;
    FaultCode := 10;
ELSIF Peak > 25000.0 THEN
    Fault := 1;
    FaultCode := 20;
END_IF;
IF Ack AND NOT Watch.DN THEN
    Fault := 0;
    FaultCode := 0;
    Peak := 0.0;
END_IF;
Down := (State = 1 OR State = 2) AND Guard;
Up := State = 3;
Red := Fault AND FaultCode <> 0;
Green := State = 0 AND NOT Fault AND NOT Counter1.DN;
END
"""
"""A press with two-hand control."""

STATION_ST = """\
PROGRAM drillstation
USE axis3601
SLOT card : 1
ALIAS Go : Local:2:I.Data.0
ALIAS Clamped : Local:2:I.Data.1
ALIAS Abort : Local:2:I.Data.2
ALIAS Clamp : Local:3:O.Data.0
ALIAS Spindle : Local:3:O.Data.1
ALIAS Trouble : Local:3:O.Data.2
TAG Z : AXIS_3601
TAG ZModule : Amci3601
TAG Words : INT[8] := [16#8434, 16#0034, 0, 400, 0, 0, 0, 0]
TAG Cfg : Configure3601
TAG Zero : MC_Home
TAG Approach : MC_MoveAbsolute
TAG Drill : MC_MoveAbsolute
TAG Retract : MC_MoveAbsolute
TAG Clear : MC_Reset
TAG Depth : DINT := 4500
TAG Feed : DINT := 900
TAG Chip : DINT
TAG Step : DINT
TAG Started : BOOL

ROUTINE Main ST
IF NOT S:FS THEN Started := 1; END_IF;

Configure3601(Cfg, Z, Words, Started);
CASE Step OF
0:
    IF Cfg.Done THEN Step := 5; END_IF;
5:
    IF Zero.Done THEN Step := 10; END_IF;
10:
    Chip := 0;
    IF Go AND NOT Abort THEN Step := 15; END_IF;
15:
    IF Clamped THEN Step := 20; END_IF;
20:
    IF Approach.Done THEN Step := 30; END_IF;
30:
    IF Drill.Done THEN Step := 40; END_IF;
40:
    IF Retract.Done THEN
        Chip := Chip + 1;
        IF Chip < 3 THEN Step := 20; ELSE Step := 10; END_IF;
    END_IF;
90:
    IF Clear.Done THEN Step := 5; END_IF;
END_CASE;
IF Z.ErrorStop AND Step > 5 THEN Step := 90; END_IF;
MC_Home(Zero, Z, Step = 5, -1, 1000, 10, 10);
MC_MoveAbsolute(Approach, Z, Step = 20, 3000, 5000, 30, 30);
MC_MoveAbsolute(Drill, Z, Step = 30, Depth, Feed, 5, 5);
MC_MoveAbsolute(Retract, Z, Step = 40, 0, 8000, 30, 30);
MC_Reset(Clear, Z, Step = 90);
Clamp := Step >= 15 AND Step < 90;
Spindle := Step >= 20 AND Step <= 40;
Trouble := Z.ErrorStop;
ZModule.Fault := card.I.Fault;
Amci3601(ZModule, Z, card.I.Data[0], card.O.Data[0]);
END
"""
"""A drill that pecks three times."""

CUTTER = """\
'''Cut to length: jog, home, then a cut per piece.'''

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, Move, MoveKind, ResetErrors, StatusView

LENGTHS = {0: 1500, 1: 2400, 2: 3600}
FEED = 4500
RAMP = 25
KNIFE_NS = 250_000_000

CONFIG = Configuration(
    inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=300
)


class Cutter:
    def __init__(self):
        self.mode = "boot"
        self.until_ns = 0
        self.pieces = 0
        self.last_start = False

    def run(self, scan):
        axis = scan.slot[1]
        buttons = scan.slot[2].inputs
        status = StatusView(axis.inputs)
        start = buttons.bit(0, 0)
        select = 2 if buttons.bit(0, 2) else 1 if buttons.bit(0, 1) else 0
        knife = False
        if status.COMMAND_ERROR:
            self.mode = "reset"
        if self.mode == "boot":
            axis.outputs.load(CONFIG.to_image())
            if status.MODE_CONFIG and not status.CONFIG_ERROR:
                self.mode = "leave"
        elif self.mode == "leave":
            axis.outputs.load(Idle().to_image())
            if not status.MODE_CONFIG:
                self.mode = "home"
        elif self.mode == "home":
            axis.outputs.load(FindHome(Direction.CCW, 800, 10, 10).to_image())
            if status.AT_HOME and not status.POSITION_INVALID:
                axis.outputs.load(Idle().to_image())
                self.mode = "ready"
        elif self.mode == "ready":
            if start and not self.last_start:
                length = LENGTHS[select]
                axis.outputs.load(Move(MoveKind.RELATIVE, length, FEED, RAMP, RAMP).to_image())
                self.mode = "feed"
        elif self.mode == "feed":
            if status.MOVE_COMPLETE:
                axis.outputs.load(Idle().to_image())
                self.until_ns = scan.now_ns + KNIFE_NS
                self.mode = "cut"
        elif self.mode == "cut":
            knife = True
            if scan.now_ns >= self.until_ns:
                self.pieces += 1
                self.mode = "ready"
        elif self.mode == "reset":
            axis.outputs.load(ResetErrors().to_image())
            if not status.COMMAND_ERROR:
                axis.outputs.load(Idle().to_image())
                self.mode = "ready"
        self.last_start = start
        scan.slot[3].outputs.set_bit(0, 0, knife)
        scan.slot[3].outputs.set_bit(0, 1, self.mode == "ready")


cutter = Cutter()


def logic(scan):
    cutter.run(scan)
"""
"""Cut to length, in Python."""

GANTRY = """\
'''A gantry: x carries z; parts go from the belt to a tray of twelve places.'''

from scanrack import (
    Axis3601, AxisError, Configuration, Direction, Input, InputBit, Lock, Logic, OnDelay, Output, Rise, State,
    WaitTimeout, all_of, dwell, first_of, sequence, steady, until, within,
)

SWITCHES = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
RAPID = 9000
CAREFUL = 1200
ROWS, COLUMNS = 3, 4
PITCH_X, PITCH_Z = 700, 350
BELT = -1200


class Gantry(Logic):
    x = Axis3601(1, Configuration(inputs_used=SWITCHES, starting_speed=600))
    z = Axis3601(4, Configuration(inputs_used=SWITCHES, starting_speed=200))
    part = Input("Local:2:I.Data.0")
    vacuum_ok = Input("Local:2:I.Data.1")
    tray_new = Input("Local:2:I.Data.2")
    estop = Input("Local:2:I.Data.3")
    vacuum: Output = Output("Local:3:O.Data.0")
    belt: Output = Output("Local:3:O.Data.1")
    call_operator: Output = Output("Local:3:O.Data.2")
    blower: Output = Output("Local:3:O.Data.3")
    jam = OnDelay("6 s")
    new_tray = Rise()
    motion = Lock()
    place_number = 0
    lost = 0
    ready = False
    tray_full = False

    def every_scan(self) -> None:
        if self.new_tray(self.tray_new):
            self.place_number = 0
            self.tray_full = False
        self.belt = self.ready and not self.part
        self.call_operator = self.tray_full or self.jam(self.ready and not self.part)

    @sequence
    async def transfer(self) -> None:
        while True:
            try:
                await self.prepare()
                while True:
                    await until(lambda: bool(self.part) and not self.tray_full, "part and place")
                    async with self.motion:
                        await self.pick()
                        await self.drop()
            except AxisError:
                self.ready = False
                self.vacuum = False
                await steady(lambda: not self.estop, "1 s")

    async def prepare(self) -> None:
        for axis in (self.z, self.x):
            if axis.state == State.DISABLED:
                await axis.configure()
            if axis.state == State.ERROR_STOP:
                await axis.reset()
            await axis.home(Direction.CCW, speed=CAREFUL, acceleration=10, deceleration=10)
        self.ready = True

    async def pick(self) -> None:
        await self.x.move_to(BELT, speed=RAPID, acceleration=40, deceleration=40)
        await self.z.move_to(1800, speed=RAPID // 2, acceleration=30, deceleration=30)
        self.vacuum = True
        try:
            await within("800 ms", self.vacuum_ok.on)
        except WaitTimeout:
            self.lost += 1
        await self.z.move_to(0, speed=RAPID // 2, acceleration=30, deceleration=30)

    async def drop(self) -> None:
        row, column = divmod(self.place_number, COLUMNS)
        await all_of(
            self.x.move_to(column * PITCH_X, speed=RAPID, acceleration=40, deceleration=40),
            self.z.move_to(200, speed=CAREFUL, acceleration=10, deceleration=10),
        )
        await self.z.move_to(1000 + row * PITCH_Z, speed=CAREFUL, acceleration=10, deceleration=10)
        self.vacuum = False
        await dwell("120 ms")
        await self.z.move_to(0, speed=RAPID // 2, acceleration=30, deceleration=30)
        self.place_number += 1
        if self.place_number == ROWS * COLUMNS:
            self.tray_full = True

    @sequence
    async def clean(self) -> None:
        while True:
            await self.vacuum_ok.falls
            self.blower = True
            await first_of(dwell("300 ms"), self.estop.rises)
            self.blower = False
"""
"""A gantry with two axes and two sequences."""

WASHER = """\
CONTROLLER washer
TYPE Valve (Cmd : BOOL, Open : BOOL, Closed : BOOL, Travel : TIMER, Fault : BOOL)
INSTRUCTION ValveCtl
INOUT V : Valve REQUIRED
INPUT Open : BOOL REQUIRED
INPUT Time : DINT REQUIRED
OUTPUT Coil : BOOL REQUIRED
ROUTINE Logic
XIC(Open)XIO(V.Fault)OTE(V.Cmd);
MOV(Time,V.Travel.PRE);
[XIC(V.Cmd)XIO(V.Open),XIO(V.Cmd)XIO(V.Closed)]TON(V.Travel,?,?);
XIC(V.Travel.DN)OTL(V.Fault);
XIC(V.Cmd)OTE(Coil);
END
END INSTRUCTION
TAG Fill : Valve
TAG Drain : Valve
TAG CtlFill : ValveCtl
TAG CtlDrain : ValveCtl
TAG Temperature : REAL
TAG Raw : INT
TAG Wash : BOOL
TAG Rinse : BOOL
TAG Heat : BOOL
TAG PhaseNo : DINT
TAG AckFaults : BOOL
TASK Main : CONTINUOUS RUNS Sequence, Io
TASK Slow : PERIODIC 50 ms PRIORITY 9 RUNS Analog
PROGRAM Sequence MAIN Start
TAG WashTime : TIMER
TAG RinseTime : TIMER
TAG StartEdge : BOOL
ROUTINE Start
XIC(Local:2:I.Data.0)ONS(StartEdge)EQU(PhaseNo,0)MOV(1,PhaseNo);
EQU(PhaseNo,1)OTE(Wash);
EQU(PhaseNo,2)OTE(Rinse);
XIC(Wash)GRT(Temperature,45.0)TON(WashTime,60000,0);
XIC(WashTime.DN)MOV(2,PhaseNo);
XIC(Rinse)TON(RinseTime,30000,0);
XIC(RinseTime.DN)MOV(0,PhaseNo);
XIC(Wash)LES(Temperature,60.0)OTE(Heat);
XIC(Local:2:I.Data.7)OTE(AckFaults);
END
END PROGRAM
PROGRAM Io MAIN Start
ROUTINE Start
XIC(Local:2:I.Data.1)OTE(Fill.Open);
XIC(Local:2:I.Data.2)OTE(Fill.Closed);
XIC(Local:2:I.Data.3)OTE(Drain.Open);
XIC(Local:2:I.Data.4)OTE(Drain.Closed);
ValveCtl(CtlFill,Fill,Wash,4000,Local:3:O.Data.0);
ValveCtl(CtlDrain,Drain,Rinse,5000,Local:3:O.Data.1);
XIC(Heat)XIO(Drain.Cmd)OTE(Local:3:O.Data.2);
[XIC(Fill.Fault),XIC(Drain.Fault)]OTE(Local:3:O.Data.3);
XIC(AckFaults)OTU(Fill.Fault)OTU(Drain.Fault);
END
END PROGRAM
PROGRAM Analog MAIN Start
TAG Filtered : REAL
ROUTINE Start
MOV(Local:2:I.Data[0],Raw);
CPT(Filtered,Filtered*0.9+Raw*0.1);
CPT(Temperature,Filtered/327.67);
END
END PROGRAM
"""
"""A controller with an add-on instruction that takes a structure."""

DEBURR = """\
'''A deburring spindle on a slide: sequences with helpers and a blend.'''

from scanrack import (
    Axis3601, AxisError, BlendSegment, CommandAborted, Configuration, Counter, Direction, Input, InputBit, Logic,
    OffDelay, Output, Pulse, dwell, sequence, until,
)

IN = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
PROFILE = [
    BlendSegment(length=800, speed=1500, rate=20),
    BlendSegment(length=3000, speed=4000, rate=20),
    BlendSegment(length=900, speed=1200, rate=20),
]


class Deburr(Logic):
    slide = Axis3601(1, Configuration(inputs_used=IN, step_and_direction=True, starting_speed=400))
    cycle_start = Input("Local:2:I.Data.0")
    door_closed = Input("Local:2:I.Data.1")
    part_clamped = Input("Local:2:I.Data.2")
    spindle: Output = Output("Local:3:O.Data.0")
    clamp: Output = Output("Local:3:O.Data.1")
    coolant: Output = Output("Local:3:O.Data.2")
    door_lamp: Output = Output("Local:3:O.Data.3")
    run_on = OffDelay("5 s")
    grease = Pulse("2 s")
    strokes = Counter(250)
    passes = 3
    cutting = False
    dull = False

    def every_scan(self) -> None:
        self.coolant = self.run_on(self.cutting) and not self.dull
        self.dull = self.strokes(self.cutting)
        self.door_lamp = self.grease(not self.door_closed)

    @sequence
    async def work(self) -> None:
        await self.slide.configure()
        await self.slide.home(Direction.CCW, speed=900, acceleration=10, deceleration=10)
        await self.slide.program_blend(PROFILE, final_deceleration=20)
        while True:
            await self.cycle_start.rises
            await until(lambda: bool(self.door_closed))
            self.clamp = True
            await self.part_clamped.on
            try:
                await self.machine()
            except (AxisError, CommandAborted):
                await self.slide.reset()
            finally:
                self.spindle = False
                self.cutting = False
            self.clamp = False

    async def machine(self) -> None:
        self.spindle = True
        await dwell("700 ms")
        for count in range(self.passes):
            self.cutting = True
            await self.slide.run_blend(Direction.CW)
            self.cutting = False
            await self.slide.move_to(0, speed=6000, acceleration=30, deceleration=30)
            if count == 0:
                await dwell("200 ms")
"""
"""Sequences with a blend."""

TRACKING = """\
PROGRAM tracking
// Reject tracking: a FIFO of weights and a shift register, SLC style arrays
ALIAS Photo : Local:2:I.Data.0
ALIAS Encoder : Local:2:I.Data.1
ALIAS Bad : Local:2:I.Data.2
ALIAS Clear : Local:2:I.Data.3
ALIAS Kicker : Local:3:O.Data.0
ALIAS JamLamp : Local:3:O.Data.1
TAG Line : DINT[4]
TAG LineC : CONTROL
TAG Weights : DINT[20]
TAG WeightC : CONTROL
TAG WeightOut : DINT
TAG Average : REAL
TAG AveC : CONTROL
TAG Recent : REAL[10]
TAG RecentAt : DINT
TAG Edge1 : BOOL
TAG Edge2 : BOOL
TAG Rejects : COUNTER
TAG Jam : TIMER
TAG Reads : DINT

ROUTINE Main
XIC(Encoder)ONS(Edge1)BSL(Line[0],LineC,Bad,96);
XIC(Line[2].11)XIC(Photo)OTE(Kicker);
XIC(Kicker)CTU(Rejects,0,0);
XIC(Clear)RES(Rejects)RES(WeightC);
XIC(Photo)FFL(Local:2:I.Data[0],Weights[0],WeightC,20,0);
XIC(WeightC.DN)FFU(Weights[0],WeightOut,WeightC,20,0);
XIC(Photo)ONS(Edge2)ADD(RecentAt,1,RecentAt)MOD(RecentAt,10,RecentAt)MOV(WeightOut,Recent[RecentAt]);
EQU(RecentAt,9)AVE(Recent[0],0,Average,AveC,10,0);
XIC(Photo)TON(Jam,2500,0);
[XIC(Jam.DN),GRT(Average,900.0),GRT(Rejects.ACC,30)]OTE(JamLamp);
XIC(Photo)XIO(Edge1)ADD(Reads,1,Reads);
GRT(Reads,30000)MOV(0,Reads);
END
"""
"""Queues, a shift register, an average."""

BOOLSTEPS = """\
PROGRAM boolsteps
// Steps as bits: each one is latched by the one before
USE axis3601
SLOT card : 1
ALIAS Go : Local:2:I.Data.0
ALIAS GripClosed : Local:2:I.Data.1
ALIAS GripOpen : Local:2:I.Data.2
ALIAS Halt_PB : Local:2:I.Data.3
ALIAS Grip : Local:3:O.Data.0
ALIAS StepLamp : Local:3:O.Data.1
TAG Axis : AXIS_3601
TAG Io : Amci3601
TAG Cfg : INT[8] := [16#8434, 16#0034, 0, 300, 0, 0, 0, 0]
TAG Conf : Configure3601
TAG Home : MC_Home
TAG ToPick : MC_MoveAbsolute
TAG ToDrop : MC_MoveAbsolute
TAG Stop : MC_Stop
TAG Clear : MC_Reset
TAG S : BOOL[6]
TAG Awake : BOOL
TAG HomeGo : BOOL
TAG PickGo : BOOL
TAG DropGo : BOOL
TAG StartEdge : BOOL
TAG Settle : TIMER
TAG PickPos : DINT := 1000
TAG DropPos : DINT := 7000

ROUTINE Main
XIO(S:FS)OTE(Awake);
XIC(S:FS)OTL(S[0]);
Configure3601(Conf,Axis,Cfg,Awake);
XIC(S[0])XIC(Conf.Done)OTE(HomeGo);
MC_Home(Home,Axis,HomeGo,-1,800,10,10);
XIC(S[0])XIC(Home.Done)OTU(S[0])OTL(S[1]);
XIC(S[1])XIC(Go)ONS(StartEdge)OTU(S[1])OTL(S[2]);
XIC(S[2])OTE(PickGo);
MC_MoveAbsolute(ToPick,Axis,PickGo,PickPos,3000,20,20);
XIC(S[2])XIC(ToPick.Done)OTU(S[2])OTL(S[3]);
XIC(S[3])XIC(GripClosed)TON(Settle,200,0);
XIC(Settle.DN)OTU(S[3])OTL(S[4]);
XIC(S[4])OTE(DropGo);
MC_MoveAbsolute(ToDrop,Axis,DropGo,DropPos,3000,20,20);
XIC(S[4])XIC(ToDrop.Done)OTU(S[4])OTL(S[5]);
XIC(S[5])XIC(GripOpen)OTU(S[5])OTL(S[1]);
[XIC(S[3]),XIC(S[4])]OTE(Grip);
[XIC(S[2]),XIC(S[3]),XIC(S[4]),XIC(S[5])]OTE(StepLamp);
MC_Stop(Stop,Axis,Halt_PB);
XIC(Axis.ErrorStop)XIO(Halt_PB)OTU(S[1])OTU(S[2])OTU(S[3])OTU(S[4])OTU(S[5])OTL(S[0]);
MC_Reset(Clear,Axis,Axis.ErrorStop);
MOV(card.I.Fault,Io.Fault)Amci3601(Io,Axis,card.I.Data[0],card.O.Data[0]);
END
"""
"""Steps as bits."""

MISC = """\
CONTROLLER misc
TYPE Motor (Cmd : BOOL, Fb : BOOL, Trip : BOOL, Hours : DINT, Speed : REAL)
TAG Pumps : Motor[3]
TAG Duty : DINT
TAG HMI_DutySelect : DINT
TAG LevelRaw : INT
TAG LevelPct : REAL
TAG SP_Low : REAL := 20.0
TAG SP_High : REAL := 80.0
TAG Alternate : BOOL
TAG Pattern : DINT[4] := [1, 2, 4, 1]
TAG SqoC : CONTROL
TAG Outputs : DINT
TAG HourTimer : TIMER
TAG AnyTrip : BOOL
TAG Seconds : DINT
TAG Clock : DINT[7]
TAG Text : STRING
TAG Msg : STRING[4]
TAG Number : DINT
TASK Main : CONTINUOUS RUNS Pumps_, Hmi
PROGRAM Pumps_ MAIN Go
TAG Idx : DINT
TAG Starts : COUNTER
TAG Flip : BOOL
ROUTINE Go
MOV(Local:2:I.Data[0],LevelRaw);
CPT(LevelPct,LevelRaw*0.003);
GRT(LevelPct,SP_High)XIO(AnyTrip)OTL(Alternate);
LES(LevelPct,SP_Low)OTU(Alternate);
XIC(Alternate)SQO(Pattern[0],7,Outputs,SqoC,3,0);
[EQU(HMI_DutySelect,0)MOV(Outputs,Duty),NEQ(HMI_DutySelect,0)MOV(HMI_DutySelect,Duty)];
JSR(Each,0);
XIC(Alternate)ONS(Flip)CTU(Starts,1000,0);
XIC(Starts.DN)RES(Starts);
[XIC(Pumps[0].Trip),XIC(Pumps[1].Trip),XIC(Pumps[2].Trip)]OTE(AnyTrip);
XIO(HourTimer.DN)XIC(Alternate)TON(HourTimer,3600000,0);
END
ROUTINE Each ST
FOR Idx := 0 TO 2 DO
    Pumps[Idx].Cmd := Duty.[Idx] AND NOT Pumps[Idx].Trip;
    Pumps[Idx].Fb := Local:2:I.Data[0].[Idx + 8];
    IF Pumps[Idx].Cmd AND HourTimer.DN THEN
        Pumps[Idx].Hours := Pumps[Idx].Hours + 1;
    END_IF;
    IF Pumps[Idx].Cmd AND NOT Pumps[Idx].Fb THEN
        Pumps[Idx].Speed := Pumps[Idx].Speed + 0.5;
    ELSE
        Pumps[Idx].Speed := 0.0;
    END_IF;
    Pumps[Idx].Trip := Pumps[Idx].Speed > 100.0 OR Pumps[Idx].Hours > 20000;
END_FOR;
END
END PROGRAM
PROGRAM Hmi MAIN Go
ROUTINE Go
XIC(Pumps[0].Cmd)OTE(Local:3:O.Data.0);
XIC(Pumps[1].Cmd)OTE(Local:3:O.Data.1);
XIC(Pumps[2].Cmd)OTE(Local:3:O.Data.2);
XIC(AnyTrip)OTE(Local:3:O.Data.3);
GSV(WallClockTime,,DateTime,Clock[0]);
MOV(Clock[5],Seconds);
DTOS(Seconds,Text);
LIM(0,Duty,3)MOV(Duty,Number);
GRT(Number,3)CLR(Number);
COP(Text,Msg[0],1);
GRT(Msg[0].LEN,0)MOV(Msg[0].LEN,Number);
END
END PROGRAM
"""
"""Pumps in an array, a sequencer, strings, the clock."""

PYCLASS = """\
'''A dispenser: three heads, one function of the scan, helpers and a table.'''

from collections import deque
from dataclasses import dataclass
from enum import Enum, auto
from math import ceil

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, Manual, Move, MoveKind, ResetErrors, StatusView

CONFIG = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT, step_and_direction=True, starting_speed=250
)
DOSES = (("small", 600), ("medium", 1200), ("large", 2400))
SLOW, FAST = 800, 5200


class Phase(Enum):
    START = auto()
    CONFIGURED = auto()
    HOMING = auto()
    IDLE = auto()
    DOSING = auto()
    JOGGING = auto()
    ERROR = auto()


@dataclass
class Request:
    name: str
    steps: int


class Dispenser:
    def __init__(self, axis_slot, button_slot):
        self.axis_slot, self.button_slot = axis_slot, button_slot
        self.phase = Phase.START
        self.queue: deque[Request] = deque(maxlen=8)
        self.before = [False] * 4
        self.history = {}

    def edges(self, word):
        now = [bool(word >> bit & 1) for bit in range(4)]
        rising = [a and not b for a, b in zip(now, self.before)]
        self.before = now
        return rising

    def __call__(self, scan):
        axis = scan.slot[self.axis_slot]
        status = StatusView(axis.inputs)
        pressed = self.edges(scan.slot[self.button_slot].inputs[0])
        for index, (name, steps) in enumerate(DOSES):
            if pressed[index]:
                self.queue.append(Request(name, steps))
        handler = getattr(self, f"on_{self.phase.name.lower()}")
        handler(axis.outputs, status, jog=self.before[3])
        lamps = sum(1 << bit for bit, on in enumerate((self.queue, self.phase is Phase.ERROR)) if on)
        scan.slot[3].outputs[0] = lamps

    def on_start(self, outputs, status, jog):
        outputs.load(CONFIG.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.CONFIGURED

    def on_configured(self, outputs, status, jog):
        if not status.MODE_CONFIG and not jog:
            outputs.load(FindHome(Direction.CCW, SLOW, 10, 10).to_image())
            self.phase = Phase.HOMING

    def on_homing(self, outputs, status, jog):
        if status.AT_HOME and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE

    def on_idle(self, outputs, status, jog):
        if status.COMMAND_ERROR or status.INPUT_ERROR:
            self.phase = Phase.ERROR
        elif jog:
            outputs.load(Manual(Direction.CW, SLOW, 10, 10).to_image())
            self.phase = Phase.JOGGING
        elif self.queue:
            request = self.queue.popleft()
            self.history[request.name] = self.history.get(request.name, 0) + 1
            speed = FAST if request.steps > 1000 else SLOW
            ramp = max(10, ceil(speed / 100))
            outputs.load(Move(MoveKind.RELATIVE, request.steps, speed, ramp, ramp).to_image())
            self.phase = Phase.DOSING

    def on_dosing(self, outputs, status, jog):
        if status.MOVE_COMPLETE and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE

    def on_jogging(self, outputs, status, jog):
        if not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE if not status.MOVING_CW else Phase.JOGGING

    def on_error(self, outputs, status, jog):
        outputs.load(ResetErrors().to_image())
        if not (status.COMMAND_ERROR or status.INPUT_ERROR or jog):
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE


logic = Dispenser(axis_slot=1, button_slot=2)
"""
"""An object that is called in every scan."""

SEQ2 = """\
'''A winder with inheritance, match, a timeline of recipes and a watchdog.'''

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

from scanrack import (
    Axis3601, AxisError, CommandAborted, Configuration, Direction, Fall, Input, InputBit, InputWord, Lock, Logic,
    OnDelay, Output, Rise, WaitTimeout, dwell, first_of, sequence, steady, until, within,
)

LIMITS = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT


@dataclass(frozen=True)
class Recipe:
    turns: int
    speed: int
    pause: str = "200 ms"


RECIPES = {"thin": Recipe(40, 6000), "thick": Recipe(25, 3000, "500 ms")}
STEPS_PER_TURN = 200


class Base(Logic):
    drum = Axis3601(1, Configuration(inputs_used=LIMITS, step_and_direction=True, starting_speed=300))
    stop = Input("Local:2:I.Data.0")
    fault: Output = Output("Local:3:O.Data.0")
    error = ""

    async def prepare(self) -> None:
        await self.drum.configure()
        await self.drum.home(Direction.CCW, speed=700, acceleration=10, deceleration=10)

    async def recover(self) -> None:
        self.fault = True
        await steady(lambda: not self.stop, "2 s")
        await self.drum.reset()
        self.fault = False


class Winder(Base):
    traverse = Axis3601(4, Configuration(inputs_used=LIMITS, step_and_direction=True, starting_speed=200))
    start = Input("Local:2:I.Data.1")
    thick = Input("Local:2:I.Data.2")
    tension = InputWord("Local:2:I.Data[0]")
    clamp: Output = Output("Local:3:O.Data.1")
    lamps: Output = Output("Local:3:O.Data.2")
    slack = OnDelay("800 ms")
    started = Rise()
    released = Fall()
    guard = Lock()
    wanted = False
    layer = 0

    def every_scan(self) -> None:
        if self.started(self.start):
            self.wanted = True
        if self.released(self.start) and self.stop:
            self.wanted = False
        self.lamps = self.slack(self.tension < 100 and self.wanted)

    @sequence
    async def wind(self) -> None:
        for attempt in count(1):
            try:
                await self.prepare()
                await self.traverse.configure()
                await self.traverse.set_position(0)
                while True:
                    await until(lambda: self.wanted, "wanted")
                    await self.coil(RECIPES["thick" if self.thick else "thin"])
                    self.wanted = False
            except (AxisError, CommandAborted, WaitTimeout) as problem:
                self.error = f"{attempt}: {problem}"
        await self.recover()

    async def coil(self, recipe: Recipe) -> None:
        self.clamp = True
        try:
            for turn in range(recipe.turns):
                self.layer, side = divmod(turn, 10)
                async with self.guard:
                    move = self.drum.move_by(STEPS_PER_TURN * 4, speed=recipe.speed, acceleration=30, deceleration=30)
                    await self.traverse.move_to(side * 50, speed=400, acceleration=10, deceleration=10)
                    await within("10 s", move)
                if self.stop:
                    break
            await dwell(recipe.pause)
        finally:
            self.clamp = False

    @sequence
    async def watch(self) -> None:
        while True:
            done = await first_of(self.stop.rises, until(lambda: self.error != ""))
            match done:
                case None:
                    self.wanted = False
                case _:
                    await dwell("100 ms")
"""
"""Sequences with a base class."""

REGULATOR = """\
PROGRAM regulator
ALIAS Enable : Local:2:I.Data.15
TAG Setpoint : REAL := 55.5
TAG Kp : REAL := 1.2
TAG Ki : REAL := 0.05
TAG Error : REAL
TAG Integral : REAL
TAG Output : REAL
TAG Pwm : DINT
TAG Tick : DINT
TAG Table : REAL[11] := [0.0, 5.0, 12.0, 20.0, 30.0, 41.0, 53.0, 66.0, 80.0, 95.0, 100.0]
TAG Index : DINT
TAG Low : REAL
TAG High : REAL
TAG Measured : REAL
TAG Filter : REAL[4]
TAG J : DINT
TAG Mode : SINT
TAG State : INT
TAG Best : REAL
TAG BestAt : DINT

ROUTINE Main ST
// moving average
FOR J := 3 TO 1 BY -1 DO
    Filter[J] := Filter[J - 1];
END_FOR;
Filter[0] := Local:2:I.Data[0] * 0.01;
Measured := (Filter[0] + Filter[1] + Filter[2] + Filter[3]) / 4.0;
IF NOT Enable THEN
    Integral := 0.0;
    Output := 0.0;
    Mode := 0;
ELSE
    Error := Setpoint - Measured;
    Integral := Integral + Error * Ki;
    IF Integral > 100.0 THEN Integral := 100.0; ELSIF Integral < -100.0 THEN Integral := -100.0; END_IF;
    Output := Kp * Error + Integral;
    IF Output < 0.0 THEN
        Output := 0.0;
    END_IF;
    IF Output > 100.0 THEN
        Output := 100.0;
    END_IF;
    Mode := 1;
END_IF;
Index := TRUNC(Output / 10.0);
IF Index >= 10 THEN
    Low := Table[10];
    High := Table[10];
ELSE
    Low := Table[Index];
    High := Table[Index + 1];
END_IF;
Pwm := TRUNC(Low + (High - Low) * (Output - Index * 10) / 10.0);
Tick := Tick + 1;
IF Tick >= 100 THEN Tick := 0; END_IF;
Local:3:O.Data[0].0 := Tick < Pwm AND Mode = 1;
Best := -1.0;
J := 0;
WHILE J <= 3 DO
    IF Filter[J] > Best THEN
        Best := Filter[J];
        BestAt := J;
    END_IF;
    J := J + 1;
END_WHILE;
CASE State OF
    0: IF Enable THEN State := 1; END_IF;
    1, 2: IF BestAt = 0 AND Best > 90.0 THEN State := State + 1; END_IF;
    3..5: IF NOT Enable THEN State := 0; END_IF;
ELSE
    State := 0;
END_CASE;
Local:3:O.Data[0].1 := State >= 3;
END
"""
"""A regulator with a table and a moving average."""

PALLETIZER = """\
'''Palletizer layers: two axes, one operator button per side, an andon light and statistics.'''

import math
from collections import Counter as Tally
from itertools import cycle, product

from scanrack import (
    Axis3601, AxisError, Configuration, Direction, Input, InputBit, Lock, Logic, OffDelay, OnDelay, Output, Pulse,
    Rise, State, WaitTimeout, all_of, dwell, first_of, sequence, steady, until, within,
)

SENSORS = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
GRID = tuple(product(range(3), range(2)))
PITCH = {"x": 1100, "y": 900}
HIGH_SPEED = 7000
RAMPS = dict(acceleration=25, deceleration=25)


def steps(millimetres: float) -> int:
    return math.floor(millimetres * 20 + 0.5)


class Palletizer(Logic):
    x = Axis3601(1, Configuration(inputs_used=SENSORS, step_and_direction=True, starting_speed=500))
    y = Axis3601(4, Configuration(inputs_used=SENSORS, step_and_direction=True, starting_speed=500))
    left = Input("Local:2:I.Data.0")
    right = Input("Local:2:I.Data.1")
    box = Input("Local:2:I.Data.2")
    e_stop = Input("Local:2:I.Data.3")
    gripper: Output = Output("Local:3:O.Data.0")
    green: Output = Output("Local:3:O.Data.1")
    red: Output = Output("Local:3:O.Data.2")
    horn: Output = Output("Local:3:O.Data.3")
    idle = OnDelay("30 s")
    glow = OffDelay("1 s")
    beep = Pulse("300 ms")
    pressed = Rise()
    area = Lock()
    auto = False
    side = "left"
    layers = 0

    def __init__(self) -> None:
        self.tally: Tally[str] = Tally()
        self.places = cycle(GRID)

    def every_scan(self) -> None:
        if self.pressed(self.left or self.right):
            self.auto = not self.auto
            self.side = "left" if self.left else "right"
        moving = self.x.moving or self.y.moving
        self.green = self.glow(self.auto)
        self.red = not self.auto and moving
        self.horn = self.beep(self.idle(self.auto and not moving))

    @sequence
    async def main(self) -> None:
        while True:
            try:
                await self.home_all()
                while self.auto or not self.e_stop:
                    await until(lambda: self.auto and bool(self.box), "a box")
                    column, row = next(self.places)
                    await self.carry(column, row)
                    self.tally[self.side] += 1
                    if sum(self.tally.values()) % len(GRID) == 0:
                        self.layers += 1
                        await dwell("2 s")
            except AxisError as error:
                self.gripper = False
                self.auto = False
                await steady(lambda: not self.e_stop, "500 ms", f"after {error}")
            except WaitTimeout:
                await self.stop_all()

    async def home_all(self) -> None:
        for axis in (self.x, self.y):
            if axis.state == State.DISABLED:
                await axis.configure()
            elif axis.state == State.ERROR_STOP:
                await axis.reset()
            if axis.status.POSITION_INVALID:
                await axis.home(Direction.CCW, speed=1500, **RAMPS)

    async def carry(self, column: int, row: int) -> None:
        async with self.area:
            await within("20 s", self.go(0, 0))
            self.gripper = True
            await dwell("150 ms")
            await self.go(column * PITCH["x"] + steps(1.5), row * PITCH["y"])
            self.gripper = False
            await dwell("150 ms")

    async def go(self, x: int, y: int) -> None:
        await all_of(
            self.x.move_to(x, speed=HIGH_SPEED, **RAMPS),
            self.y.move_to(y, speed=HIGH_SPEED // 2, **RAMPS),
        )

    async def stop_all(self) -> None:
        if self.x.moving:
            await self.x.halt()
        if self.y.moving:
            await self.y.halt()
        await first_of(self.left.rises, self.right.rises)
"""
"""Two axes, boxes and an andon light."""

RAW = """\
'''A function with module state and helper functions, raw words only.'''

from scanrack import Idle

PARAMETERS = [0, 0, 2, 500, 4, 0, 50, 50]
CONFIGURE = [0x8434, 0x0034, 0, 500, 0, 0, 0, 0]
state = {"step": 0, "count": 0, "since": 0}


def send(outputs, words):
    for index, word in enumerate(words):
        outputs[index] = word


def elapsed_ms(scan):
    return (scan.now_ns - state["since"]) // 1_000_000


def go(scan, step):
    state["step"], state["since"] = step, scan.now_ns


def logic(scan):
    card = scan.slot[1]
    flags = card.inputs[0]
    button = scan.slot[2].inputs.bit(0, 3)
    if scan.first or state["step"] == 0:
        send(card.outputs, CONFIGURE)
        if flags & 0x8000 and not flags & 0x2000:
            go(scan, 1)
    elif state["step"] == 1:
        card.outputs.load(Idle().to_image())
        if not flags & 0x8000 and elapsed_ms(scan) > 20:
            go(scan, 2)
    elif state["step"] == 2 and button:
        send(card.outputs, PARAMETERS)
        card.outputs.set_bit(0, 1, True)
        go(scan, 3)
    elif state["step"] == 3 and flags & 0x0003:
        card.outputs.clear()
        go(scan, 4)
    elif state["step"] == 4 and flags & 0x0080:
        state["count"] += 1
        go(scan, 2)
    scan.slot[3].outputs[0] = state["count"] & 0xFF
"""
"""A function with the state of its module, and raw words."""

STATIONS = {
    "feeder.rung": FEEDER,
    "packer.py": PACKER,
    "press_st.rung": PRESS_ST,
    "drill.rung": STATION_ST,
    "cutter.py": CUTTER,
    "gantry.py": GANTRY,
    "washer.rung": WASHER,
    "deburr.py": DEBURR,
    "tracking.rung": TRACKING,
    "boolsteps.rung": BOOLSTEPS,
    "pumps.rung": MISC,
    "dispenser.py": PYCLASS,
    "winder.py:Winder": SEQ2,
    "regulator.rung": REGULATOR,
    "palletizer.py": PALLETIZER,
    "raw.py": RAW,
}
"""The programs by name."""
