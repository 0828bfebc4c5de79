"""Sound programs for `scanrack check` with idioms of real machines: none of them has a finding."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

from check_programs import USED

ZONES = """\
PROGRAM zones
ALIAS Auto : Local:2:I.Data.0
ALIAS Manual : Local:2:I.Data.1
ALIAS Up : Local:2:I.Data.2
ALIAS Down : Local:2:I.Data.3
ALIAS Lift : Local:3:O.Data.0
ALIAS Sink : Local:3:O.Data.1
ALIAS Lamp : Local:3:O.Data.2
TAG Mode : DINT
TAG Goes : BOOL
TAG Dir : BOOL
TAG Turns : COUNTER
TAG Scale : DINT
TAG Out : DINT

ROUTINE Main
XIC(Auto)XIO(Manual)MOV(1,Mode);
XIC(Manual)XIO(Auto)MOV(2,Mode);
XIO(Auto)XIO(Manual)MOV(0,Mode);
EQU(Mode,1)JSR(Automatic,0);
EQU(Mode,2)JSR(ByHand,0);
EQU(Mode,0)CLR(Scale)OTU(Goes);
NEQ(Mode,0)JMP(on);
XIO(Auto)NOP();
LBL(on)XIC(Goes)XIC(Dir)OTE(Lift);
XIC(Goes)XIO(Dir)OTE(Sink);
EQU(Mode,1)XIC(Goes)OTE(Lamp);
END
ROUTINE Automatic
XIC(Up)CTU(Turns,5,0);
XIC(Turns.DN)RES(Turns);
XIC(Down)CTD(Turns,?,?);
JSR(Scaling,2,Turns.ACC,10,Scale);
GRT(Scale,20)OTL(Goes);
LEQ(Scale,20)OTU(Goes);
XIC(Up)OTL(Dir);
XIC(Down)OTU(Dir);
END
ROUTINE ByHand
XIC(Up)XIO(Down)OTL(Goes)OTL(Dir);
XIC(Down)XIO(Up)OTL(Goes)OTU(Dir);
XIO(Up)XIO(Down)OTU(Goes);
END
ROUTINE Scaling
SBR(Out,Scale);
MUL(Out,Scale,Out);
RET(Out);
END
"""


ENUM = f"""\
from enum import IntEnum

from scanrack import Configuration, Idle, InputBit, Move, MoveKind, PresetPosition, ResetErrors, StatusView

SETTINGS = {USED}
STATIONS = [0, 2000, 4000, 6000]


class Step(IntEnum):
    CONFIGURE = 0
    PRESET = 1
    WAIT = 2
    GO = 3
    TROUBLE = 9


class Machine:
    def __init__(self):
        self.step = Step.CONFIGURE
        self.next = 0
        self.pressed = False

    def scan(self, axis, button):
        status = StatusView(axis.inputs)
        if status.COMMAND_ERROR or status.INPUT_ERROR:
            self.step = Step.TROUBLE
        match self.step:
            case Step.CONFIGURE:
                self.configure(axis, status)
            case Step.PRESET:
                axis.outputs.load(PresetPosition(0).to_image())
                if not status.POSITION_INVALID:
                    axis.outputs.load(Idle().to_image())
                    self.step = Step.WAIT
            case Step.WAIT if button and not self.pressed:
                self.next = (self.next + 1) % len(STATIONS)
                axis.outputs.load(Move(MoveKind.ABSOLUTE, STATIONS[self.next], 3000, 10, 10).to_image())
                self.step = Step.GO
            case Step.GO if status.MOVE_COMPLETE:
                axis.outputs.load(Idle().to_image())
                self.step = Step.WAIT
            case Step.TROUBLE:
                axis.outputs.load(ResetErrors().to_image())
                if not status.COMMAND_ERROR and not status.INPUT_ERROR:
                    axis.outputs.load(Idle().to_image())
                    self.step = Step.WAIT
        self.pressed = button

    def configure(self, axis, status):
        axis.outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            axis.outputs.load(Idle().to_image())
            self.step = Step.PRESET


machine = Machine()


def logic(scan):
    machine.scan(scan.slot[1], scan.slot[2].inputs.bit(0, 0))
    scan.slot[3].outputs.set_bit(0, 0, machine.step == Step.GO)
"""

PLAIN = """\
counts = [0] * 4
total = 0


def logic(scan):
    global total
    inputs = scan.slot[2].inputs
    lamp = scan.slot[3].outputs
    for bit in range(4):
        if inputs.bit(0, bit):
            counts[bit] += 1
            total += 1
    if scan.first:
        lamp[0] = 0
    elif total % 2:
        lamp[0] = lamp[0] | 1
    else:
        lamp[0] = lamp[0] & ~1
    lamp.set_bit(0, 1, any(count > 10 for count in counts))
"""

ABORT = f"""\
from scanrack import (
    Abort, Axis3601, Configuration, Direction, Input, InputBit, Logic, Output, Rise, dwell, sequence, until,
)

HOME_SPEED = 1000
BASE = {USED}


class Station(Logic):
    axis = Axis3601(1, BASE)
    start = Input("Local:2:I.Data.0")
    estop = Input("Local:2:I.Data.1")
    door = Input("Local:2:I.Data.2")
    lamp: Output = Output("Local:3:O.Data.0")
    tool: Output = Output("Local:3:O.Data.1")
    estopped = Rise()
    rounds = 0
    offset = 0
    homed = False

    def __init__(self, far: int = 6000) -> None:
        self.far = far
        self.seen: list[int] = []

    def every_scan(self) -> None:
        if self.estopped(self.estop):
            self.cycle.restart()
            self.homed = False
        self.lamp = bool(self.door) and self.axis.moving

    @sequence
    async def cycle(self) -> None:
        if self.axis.status.CONFIG_ERROR:
            await self.axis.configure()
        if not self.homed:
            await self.axis.reset()
            await self.axis.home(Direction.CCW, speed=HOME_SPEED, acceleration=10, deceleration=10)
            self.homed = True
        try:
            while not self.estop:
                if not self.door:
                    await self.door.on
                await self.start.rises
                for target in (self.far, self.far // 2, self.offset):
                    await self.axis.move_to(target, speed=3 * HOME_SPEED, acceleration=20, deceleration=20)
                    await self.press(0.5)
                self.rounds += 1
                self.seen.append(self.axis.position)
        except Abort:
            with self.axis.stop():
                await dwell("500 ms")
            raise
        finally:
            self.tool = False

    async def press(self, seconds: float) -> None:
        self.tool = True
        await dwell(f"{{seconds}} s")
        self.tool = False
        await until(lambda: not self.axis.moving)


class Special(Station):
    offset = 250
"""

PROBE = f"""\
from scanrack import Axis3601, AxisError, Configuration, Input, InputBit, Logic, Output, dwell, first_of, sequence

SETTINGS = {USED}


class Probe(Logic):
    axis = Axis3601(1, SETTINGS, parameters_first=True)
    go = Input("Local:2:I.Data.0")
    good: Output = Output("Local:3:O.Data.0")
    found = 0
    tries = 0

    @sequence
    async def search(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        while True:
            await self.go.rises
            self.good = False
            touch = self.axis.captured()
            run = self.axis.run(800, acceleration=10, deceleration=10)
            done = await first_of(touch, self.go.falls)
            await self.axis.halt()
            if self.found > 100 and not run.error:
                self.good = done is not None
            self.tries += 1
            await self.back()

    async def back(self) -> None:
        for attempt in range(3):
            try:
                await self.axis.move_to(0, speed=2000 + 500 * attempt, acceleration=10, deceleration=10)
            except AxisError:
                await self.axis.reset()
                await dwell("100 ms")
            else:
                break
        self.found = self.axis.position
"""

EVENTS = """\
CONTROLLER plant
TAG Order : DINT[10]
TAG Count : DINT
TAG Speed : REAL := 12.5
TAG Pressed : BOOL
TASK Cycle : CONTINUOUS RUNS Main
TASK Slow : PERIODIC 100 ms PRIORITY 8 RUNS Report
TASK Bell : EVENT PRIORITY 2 RUNS Ring
PROGRAM Main MAIN Start
TAG I : DINT
TAG Sum : DINT
TAG Mean : REAL
ROUTINE Start
CLR(Sum);
FOR(Collect,I,0,9,1);
CPT(Mean,Sum/10.0*Speed);
GRT(Mean,50.0)OTE(Local:3:O.Data.0);
XIC(Local:2:I.Data.0)ONS(Pressed)EVENT(Bell);
END
ROUTINE Collect
ADD(Sum,Order[I],Sum);
END
END PROGRAM
PROGRAM Report MAIN Start
TAG Last : DINT
ROUTINE Start
MOV(Count,Last);
GRT(Last,100)OTE(Local:3:O.Data.1);
END
END PROGRAM
PROGRAM Ring MAIN Start
ROUTINE Start
ADD(Count,1,Count);
MOV(Count,Order[0]);
END
END PROGRAM
"""

LABEL = """\
PROGRAM label
USE axis3601
SLOT card : 1
ALIAS Run : Local:2:I.Data.0
ALIAS Press : Local:3:O.Data.0
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [16#8436, 16#0036, 0, 500, 0, 0, 0, 0]
TAG Set : Configure3601
TAG Minimum : StoreMinimum3601
TAG Feed : MoveRegistration3601
TAG Clear : MC_Reset
TAG Awake : BOOL
TAG Go : BOOL
TAG Again : TIMER
TAG Errors : COUNTER

ROUTINE Main
XIO(S:FS)OTE(Awake);
Configure3601(Set,Axis,Words,Awake);
StoreMinimum3601(Minimum,Axis,Set.Done,2000);
XIC(Run)XIC(Minimum.Done)XIO(Again.TT)XIO(Axis.ErrorStop)OTE(Go);
MoveRegistration3601(Feed,Axis,Go,1500,3000,20,20);
XIC(Feed.Done)TON(Again,150,0);
XIC(Again.TT)OTE(Press);
XIC(Feed.Error)CTU(Errors,0,0);
MC_Reset(Clear,Axis,Feed.Error);
MOV(card.I.Fault,Module.Fault)Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""


MACHINES = {
    "zones.rung": ZONES,
    "enum.py": ENUM,
    "plain.py": PLAIN,
    "abort.py:Special": ABORT,
    "probe.py": PROBE,
    "events.rung": EVENTS,
    "label.rung": LABEL,
}
"""The programs by name."""
