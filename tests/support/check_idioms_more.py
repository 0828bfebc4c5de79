"""Further correct programs for `scanrack check`, in which a rule could see a mistake."""

from __future__ import annotations

from check_idioms_python import HEAD, USED
from check_idioms_rungs import AXIS, READY

MORE = {
    "fastslow.rung": f"""\
PROGRAM fastslow
{AXIS}ALIAS Go : Local:2:I.Data.0
ALIAS Fast : Local:2:I.Data.1
ALIAS Busy : Local:3:O.Data.0
TAG Step : DINT
ROUTINE Main
{READY}EQU(Step,3)XIC(Go)MOV(10,Step);
EQU(Step,10)XIC(Fast)MOV(9,axis.O.Data[4]);
EQU(Step,10)XIO(Fast)MOV(1,axis.O.Data[4]);
EQU(Step,10)MOV(0,axis.O.Data[5])MOV(20,axis.O.Data[6])MOV(20,axis.O.Data[7])MOV(4,axis.O.Data[2])MOV(0,axis.O.Data[3])MOV(20,Step);
EQU(Step,20)MOV(2,axis.O.Data[0]);
EQU(Step,20)XIC(axis.status.MOVING_CW)MOV(30,Step);
EQU(Step,30)MOV(0,axis.O.Data[0]);
EQU(Step,30)XIC(axis.status.MOVE_COMPLETE)MOV(40,Step);
EQU(Step,40)MOV(-4,axis.O.Data[2])MOV(0,axis.O.Data[3])MOV(50,Step);
EQU(Step,50)MOV(2,axis.O.Data[0]);
EQU(Step,50)XIC(axis.status.MOVING_CCW)MOV(60,Step);
EQU(Step,60)MOV(0,axis.O.Data[0]);
EQU(Step,60)XIC(axis.status.MOVE_COMPLETE)MOV(3,Step);
GEQ(Step,10)OTE(Busy);
END
""",
    "modes.rung": f"""\
PROGRAM modes
{AXIS}ALIAS AutoKey : Local:2:I.Data.0
ALIAS JogR : Local:2:I.Data.1
ALIAS JogL : Local:2:I.Data.2
ALIAS Start : Local:2:I.Data.3
ALIAS Lamp : Local:3:O.Data.0
TAG Step : DINT
ROUTINE Main
{READY}EQU(Step,3)XIC(AutoKey)XIC(Start)MOV(100,Step);
EQU(Step,3)XIO(AutoKey)MOV(50,Step);
EQU(Step,50)MOV(0,axis.O.Data[2])MOV(0,axis.O.Data[3])MOV(0,axis.O.Data[4])MOV(250,axis.O.Data[5])MOV(10,axis.O.Data[6])MOV(10,axis.O.Data[7]);
EQU(Step,50)XIC(JogR)XIO(JogL)OTL(axis.command.MANUAL_CW)MOV(51,Step);
EQU(Step,50)XIC(JogL)XIO(JogR)OTL(axis.command.MANUAL_CCW)MOV(52,Step);
EQU(Step,50)XIC(AutoKey)MOV(3,Step);
EQU(Step,51)XIO(JogR)OTU(axis.command.MANUAL_CW)MOV(53,Step);
EQU(Step,52)XIO(JogL)OTU(axis.command.MANUAL_CCW)MOV(53,Step);
EQU(Step,53)XIC(axis.status.STOPPED)MOV(50,Step);
EQU(Step,100)MOV(3,axis.O.Data[2])MOV(500,axis.O.Data[3])MOV(4,axis.O.Data[4])MOV(0,axis.O.Data[5])MOV(30,axis.O.Data[6])MOV(30,axis.O.Data[7])MOV(110,Step);
EQU(Step,110)OTL(axis.command.RELATIVE_MOVE);
EQU(Step,110)[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVE_COMPLETE)]MOV(120,Step);
EQU(Step,120)OTU(axis.command.RELATIVE_MOVE);
EQU(Step,120)XIC(axis.status.MOVE_COMPLETE)MOV(3,Step);
NEQ(Step,3)OTE(Lamp);
END
""",
    "jogsel.rung": """\
PROGRAM jogsel
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
ALIAS Plus : Local:2:I.Data.0
ALIAS Minus : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
TAG Ready : BOOL
TAG Right : BOOL
TAG Left : BOOL
TAG Word : INT
ROUTINE Main
XIC(S:FS)OTU(Ready);
XIO(Ready)COP(Setup,axis.O.Data,8);
XIO(Ready)XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)FLL(0,axis.O.Data,8)OTL(Ready);
XIC(Plus)XIO(Left)OTE(Right);
XIC(Minus)XIO(Right)OTE(Left);
CLR(Word);
XIC(Right)MOV(128,Word);
XIC(Left)MOV(256,Word);
XIC(Ready)MOV(2,axis.O.Data[4])MOV(50,axis.O.Data[6])MOV(50,axis.O.Data[7])MOV(Word,axis.O.Data[0]);
XIC(Ready)OTE(Lamp);
END
""",
    "valve.rung": """\
PROGRAM valve
ALIAS OpenPB : Local:2:I.Data.0
ALIAS ClosePB : Local:2:I.Data.1
ALIAS UpPB : Local:2:I.Data.2
ALIAS DownPB : Local:2:I.Data.3
ALIAS ValveOpen : Local:3:O.Data.0
ALIAS ValveClose : Local:3:O.Data.1
ALIAS HoistUp : Local:3:O.Data.2
ALIAS HoistDown : Local:3:O.Data.3
ALIAS LampUp : Local:3:O.Data.4
TAG OpenCmd : BOOL
ROUTINE Main
XIC(OpenPB)OTL(OpenCmd);
XIC(ClosePB)OTU(OpenCmd);
XIC(OpenCmd)OTE(ValveOpen);
XIO(OpenCmd)OTE(ValveClose);
XIC(UpPB)XIO(DownPB)OTE(HoistUp);
XIC(DownPB)XIO(UpPB)OTE(HoistDown);
XIC(HoistUp)OTE(LampUp);
END
""",
    "param.rung": """\
PROGRAM param
ALIAS A : Local:2:I.Data.0
ALIAS B : Local:2:I.Data.1
ALIAS Out : Local:3:O.Data.0
TAG X : DINT
TAG Y : DINT
TAG R : DINT
TAG S : DINT
TAG In : DINT
ROUTINE Main
XIC(A)MOV(Local:2:I.Data[0],X);
XIC(B)MOV(Local:2:I.Data[0],Y);
JSR(Scale,1,X,R);
JSR(Scale,1,Y,S);
GRT(R,S)OTE(Out);
END
ROUTINE Scale
SBR(In);
MUL(In,100,In);
DIV(In,16384,In);
RET(In);
END
""",
    "speedcalc.rung": f"""\
PROGRAM speedcalc
{AXIS}ALIAS Go : Local:2:I.Data.0
ALIAS Busy : Local:3:O.Data.0
TAG Step : DINT
TAG Speed : DINT := 800
TAG Dist : DINT := -250
ROUTINE Main
{READY}EQU(Step,3)XIC(Go)MOV(10,Step);
EQU(Step,10)DIV(Speed,1000,axis.O.Data[4])MOD(Speed,1000,axis.O.Data[5])DIV(Dist,1000,axis.O.Data[2])MOD(Dist,1000,axis.O.Data[3])MOV(10,axis.O.Data[6])MOV(10,axis.O.Data[7])MOV(20,Step);
EQU(Step,20)OTL(axis.command.RELATIVE_MOVE);
EQU(Step,20)XIC(axis.status.MOVING_CCW)MOV(30,Step);
EQU(Step,30)OTU(axis.command.RELATIVE_MOVE);
EQU(Step,30)XIC(axis.status.MOVE_COMPLETE)MOV(3,Step);
GEQ(Step,10)OTE(Busy);
END
""",
    "hand_speeds.py": f"""\
from scanrack import Configuration, Idle, InputBit, PresetPosition, StatusView

SPEEDS = {{"slow": 650, "fast": 12500}}
SETTINGS = {USED}
SPEED_NS = 2_000_000


class Feed:
    step = 0
    name = "slow"
    since = 0
    length = 1500


feed = Feed()


def put(image, word, value):
    sign = -1 if value < 0 else 1
    image[word], image[word + 1] = sign * (abs(value) // 1000), sign * (abs(value) % 1000)


def logic(scan):
    axis, buttons = scan.slot[1], scan.slot[2].inputs
    outputs, status = axis.outputs, StatusView(axis.inputs)
    if feed.step == 0:
        outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            feed.step = 1
    elif feed.step == 1:
        if not status.MODE_CONFIG:
            outputs.load(PresetPosition(0).to_image())
            feed.step = 2
    elif feed.step == 2:
        if not status.POSITION_INVALID:
            outputs.load(Idle().to_image())
            feed.step = 3
    elif feed.step == 3:
        feed.name = "fast" if buttons.bit(0, 1) else "slow"
        feed.length = -1500 if buttons.bit(0, 2) else 2500
        if buttons.bit(0, 0):
            put(outputs, 2, feed.length)
            put(outputs, 4, SPEEDS[feed.name])
            outputs[6], outputs[7] = 25, 25
            outputs[0] |= 2
            feed.step = 4
    elif feed.step == 4:
        if status.MOVING_CW or status.MOVING_CCW:
            outputs[0] &= ~2
            feed.since = scan.now_ns
            feed.step = 5
    elif feed.step == 5 and status.MOVE_COMPLETE and scan.now_ns - feed.since > 10 * SPEED_NS:
        feed.step = 3
""",
    "hand_retry.py": """\
state = {"tries": 0, "on": False, "since": 0}
QUEUE = []


def logic(scan):
    card, out = scan.slot[2].inputs, scan.slot[3].outputs
    tries = 0
    while tries < 3 and not card.bit(0, tries):
        tries += 1
    state["tries"] = tries
    while QUEUE and QUEUE[0] < scan.number:
        QUEUE.pop(0)
    if card.bit(0, 5) and scan.now_ns - state["since"] > scan.period_ns * 5:
        QUEUE.append(scan.number + 20)
        state["since"] = scan.now_ns
    out[0] = min(state["tries"], 3) | (len(QUEUE) > 0) << 4
""",
    "wait_lift.py": f"""\
{HEAD}

class Lift(Logic):
    up_button = Input("Local:2:I.Data.0")
    down_button = Input("Local:2:I.Data.1")
    top = Input("Local:2:I.Data.2")
    bottom = Input("Local:2:I.Data.3")
    up: Output = Output("Local:3:O.Data.0")
    down: Output = Output("Local:3:O.Data.1")

    def every_scan(self) -> None:
        self.up = self.up_button and not self.down_button and not self.top
        if self.down_button and not self.up:
            self.down = not self.bottom
        else:
            self.down = False
""",
    "wait_loop.py": f"""\
{HEAD}
TABLE = ((0, 1000), (2500, 4000), (-1000, 600))


class Loop(Logic):
    axis = Axis3601(1, SETTINGS)
    go = Input("Local:2:I.Data.0")
    count = 0

    @sequence
    async def run(self) -> None:
        await self.axis.configure()
        await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        while True:
            await self.go.rises
            for place, speed in TABLE:
                await self.axis.move_to(place, speed=speed, acceleration=10, deceleration=10)
            left = 10
            while left:
                left = self.less(left)
            while self.count > 5:
                self.count -= 5
            await dwell("2 ms")
            self.count += 1

    def less(self, value: int) -> int:
        return value - 1
""",
    "sm.rung": """\
PROGRAM sm
ALIAS Go : Local:2:I.Data.0
ALIAS Lamp : Local:3:O.Data.0
TAG Idx : DINT
TAG Vals : DINT[4] := [100, 200, 300, 400]
TAG Sum : DINT
TAG Share : DINT
TAG Pct : REAL
ROUTINE Main ST
IF Go THEN Idx := (Idx + 1) MOD 4; END_IF;
Sum := Sum + Vals[Idx] / 100;
IF Sum > 5000 THEN Sum := 0; END_IF;
Share := Sum * 100 / 5000;
Pct := Share / 100.0;
Lamp := Pct > 0.5;
END
""",
    "two.steps": """\
SLOT 4
words 8434h 0034h 1 0      until MODE_CONFIG -CONFIG_ERROR
idle                       until -MODE_CONFIG
MANUAL_CW                  for 20 ms
zero                       for 20 ms
MANUAL_CCW target 2000 speed 2000 acceleration 10 deceleration 10   for 1 s
idle                       until MOVE_COMPLETE
RESET_ERRORS               for 20 ms
zero
""",
}
"""The programs by name; none of them has a finding."""
