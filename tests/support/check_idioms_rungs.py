"""Correct rungs for `scanrack check`, one idiom of PLC programmers each: none of them has a finding."""

from __future__ import annotations

AXIS = """\
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Zero : INT[8] := [16#0200, 0, 0, 0, 0, 0, 0, 0]
"""
"""An axis whose words the program writes itself."""

READY = """\
XIC(S:FS)MOV(0,Step);
EQU(Step,0)COP(Setup,axis.O.Data,8);
EQU(Step,0)XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)MOV(1,Step);
EQU(Step,1)FLL(0,axis.O.Data,8);
EQU(Step,1)XIO(axis.status.MODE_CONFIG)MOV(2,Step);
EQU(Step,2)COP(Zero,axis.O.Data,8);
EQU(Step,2)XIO(axis.status.POSITION_INVALID)MOV(3,Step);
EQU(Step,3)FLL(0,axis.O.Data,8);
"""
"""Steps 0 to 3: configured, and the position set."""


DRILL = """\
PROGRAM drill
ALIAS Cycle : Local:2:I.Data.0
ALIAS Clamped : Local:2:I.Data.1
ALIAS AtDepth : Local:2:I.Data.2
ALIAS AtTop : Local:2:I.Data.3
ALIAS ClampValve : Local:3:O.Data.0
ALIAS Spindle : Local:3:O.Data.1
ALIAS FeedDown : Local:3:O.Data.2
ALIAS FeedUp : Local:3:O.Data.3
TAG Step : DINT
TAG Dwell : TIMER
ROUTINE Main
XIC(S:FS)CLR(Step);
EQU(Step,0)XIC(Cycle)XIC(AtTop)MOV(10,Step);
EQU(Step,10)XIC(Clamped)MOV(20,Step);
EQU(Step,20)XIC(AtDepth)MOV(30,Step);
EQU(Step,30)TON(Dwell,750,0);
XIC(Dwell.DN)MOV(40,Step);
EQU(Step,40)XIC(AtTop)MOV(50,Step);
EQU(Step,50)XIO(Clamped)MOV(0,Step);
LIM(10,Step,40)OTE(ClampValve);
LIM(20,Step,40)OTE(Spindle);
EQU(Step,20)OTE(FeedDown);
EQU(Step,40)OTE(FeedUp);
END
"""


JOG_BITS = """\
PROGRAM jogbits
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Rates : INT[4] := [2, 0, 50, 50]
ALIAS JogPlus : Local:2:I.Data.0
ALIAS JogMinus : Local:2:I.Data.1
ALIAS ManualKey : Local:2:I.Data.2
ALIAS Lamp : Local:3:O.Data.0
TAG Ready : BOOL
ROUTINE Main
XIC(S:FS)OTU(Ready);
XIO(Ready)COP(Setup,axis.O.Data,8);
XIO(Ready)XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)FLL(0,axis.O.Data,8)OTL(Ready);
XIC(Ready)XIC(ManualKey)COP(Rates,axis.O.Data[4],4);
XIC(Ready)XIC(ManualKey)XIC(JogPlus)XIO(JogMinus)OTE(axis.command.MANUAL_CW);
XIC(Ready)XIC(ManualKey)XIC(JogMinus)XIO(axis.command.MANUAL_CW)OTE(axis.command.MANUAL_CCW);
XIC(Ready)XIC(ManualKey)OTE(Lamp);
END
"""

HOMING = """\
PROGRAM homing
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Search : INT[8] := [64, 0, 0, 0, 1, 0, 10, 10]
TAG Clear : INT[8] := [16#0800, 0, 0, 0, 0, 0, 0, 0]
ALIAS HomePB : Local:2:I.Data.0
ALIAS ResetPB : Local:2:I.Data.1
ALIAS Homed : Local:3:O.Data.0
ALIAS Failed : Local:3:O.Data.1
TAG Step : DINT
TAG Tries : COUNTER
TAG Wait : TIMER
ROUTINE Main
XIC(S:FS)MOV(0,Step)RES(Tries);
EQU(Step,0)COP(Setup,axis.O.Data,8);
EQU(Step,0)XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)MOV(5,Step);
EQU(Step,5)FLL(0,axis.O.Data,8);
EQU(Step,5)XIO(axis.status.MODE_CONFIG)MOV(10,Step);
EQU(Step,10)XIC(HomePB)RES(Tries)MOV(20,Step);
EQU(Step,20)CPS(Search,axis.O.Data,8);
EQU(Step,20)XIC(axis.status.AT_HOME)MOV(30,Step);
EQU(Step,20)[XIC(axis.status.HOME_INVALID),XIC(axis.status.COMMAND_ERROR)]MOV(40,Step);
EQU(Step,30)CLR(axis.O.Data[0]);
EQU(Step,30)XIC(HomePB)MOV(10,Step);
EQU(Step,40)FLL(0,axis.O.Data,8)CTU(Tries,3,0);
EQU(Step,40)XIC(Tries.DN)MOV(90,Step);
EQU(Step,40)TON(Wait,500,0);
XIC(Wait.DN)MOV(50,Step);
EQU(Step,50)CPS(Clear,axis.O.Data,8);
EQU(Step,50)XIO(axis.status.HOME_INVALID)XIO(axis.status.COMMAND_ERROR)MOV(55,Step);
EQU(Step,55)FLL(0,axis.O.Data,8);
EQU(Step,55)XIC(axis.status.MODULE_OK)MOV(20,Step);
EQU(Step,90)XIC(ResetPB)MOV(50,Step);
EQU(Step,90)XIC(ResetPB)RES(Tries);
EQU(Step,30)OTE(Homed);
EQU(Step,90)OTE(Failed);
END
"""


REVERSING = """\
PROGRAM reversing
ALIAS FwdPB : Local:2:I.Data.0
ALIAS RevPB : Local:2:I.Data.1
ALIAS StopPB : Local:2:I.Data.2
ALIAS Forward : Local:3:O.Data.0
ALIAS Reverse : Local:3:O.Data.1
TAG Coast : TIMER
TAG Ran : BOOL
ROUTINE Main
XIC(Ran)XIO(Forward)XIO(Reverse)TON(Coast,1500,0);
XIC(Coast.DN)OTU(Ran);
[XIC(FwdPB)XIO(Ran),XIC(Forward)]XIC(StopPB)XIO(Reverse)OTE(Forward);
[XIC(RevPB)XIO(Ran),XIC(Reverse)]XIC(StopPB)XIO(Forward)OTE(Reverse);
[XIC(Forward),XIC(Reverse)]OTL(Ran);
END
"""

DOOR = """\
PROGRAM door
ALIAS OpenPB : Local:2:I.Data.0
ALIAS ClosePB : Local:2:I.Data.1
ALIAS IsOpen : Local:2:I.Data.2
ALIAS IsClosed : Local:2:I.Data.3
ALIAS OpenDoor : Local:3:O.Data.0
ALIAS CloseDoor : Local:3:O.Data.1
TAG Opening : BOOL
TAG Closing : BOOL
ROUTINE Main
XIC(OpenPB)XIO(Closing)OTL(Opening);
[XIC(IsOpen),XIC(Closing)]OTU(Opening);
XIC(ClosePB)XIO(OpenPB)XIO(Opening)OTL(Closing);
[XIC(IsClosed),XIC(OpenPB)]OTU(Closing);
XIC(Opening)XIO(IsOpen)XIO(Closing)OTE(OpenDoor);
XIC(Closing)XIO(IsClosed)XIO(Opening)OTE(CloseDoor);
END
"""


SHUTTLE = f"""\
PROGRAM shuttle
{AXIS}ALIAS Go : Local:2:I.Data.0
ALIAS Busy : Local:3:O.Data.0
TAG Step : DINT
TAG Out : INT[6] := [12, 500, 4, 0, 50, 50]
TAG Home : INT[6] := [-2, -250, 4, 0, 50, 50]
TAG Rest : TIMER
ROUTINE Main
{READY}EQU(Step,3)XIC(Go)MOV(10,Step);
EQU(Step,10)COP(Out,axis.O.Data[2],6);
EQU(Step,10)OTL(axis.command.ABSOLUTE_MOVE)MOV(15,Step);
EQU(Step,15)[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVING_CCW)]OTU(axis.command.ABSOLUTE_MOVE)MOV(20,Step);
EQU(Step,20)XIC(axis.status.MOVE_COMPLETE)TON(Rest,800,0);
XIC(Rest.DN)MOV(30,Step);
EQU(Step,30)COP(Home,axis.O.Data[2],6);
EQU(Step,30)OTL(axis.command.ABSOLUTE_MOVE)MOV(35,Step);
EQU(Step,35)[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVING_CCW)]OTU(axis.command.ABSOLUTE_MOVE)MOV(40,Step);
EQU(Step,40)XIC(axis.status.MOVE_COMPLETE)MOV(3,Step);
GEQ(Step,10)OTE(Busy);
END
"""


STATIONS = f"""\
PROGRAM stations
{AXIS}ALIAS Next : Local:2:I.Data.0
ALIAS There : Local:3:O.Data.0
TAG Step : DINT
TAG At : DINT
TAG Stops : DINT[4] := [0, -2500, 4000, 8250]
TAG Target : DINT
TAG Edge : BOOL
ROUTINE Main
{READY}EQU(Step,3)XIC(Next)ONS(Edge)ADD(At,1,At)MOV(10,Step);
GRT(At,3)CLR(At);
EQU(Step,10)MOV(Stops[At],Target);
EQU(Step,10)DIV(Target,1000,axis.O.Data[2])MOD(Target,1000,axis.O.Data[3]);
EQU(Step,10)MOV(3,axis.O.Data[4])MOV(500,axis.O.Data[5])MOV(40,axis.O.Data[6])MOV(40,axis.O.Data[7]);
EQU(Step,10)MOV(20,Step);
EQU(Step,20)OTL(axis.command.ABSOLUTE_MOVE);
EQU(Step,20)[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVING_CCW),XIC(axis.status.MOVE_COMPLETE)]MOV(30,Step);
EQU(Step,30)OTU(axis.command.ABSOLUTE_MOVE);
EQU(Step,30)XIC(axis.status.MOVE_COMPLETE)MOV(3,Step);
EQU(Step,3)OTE(There);
END
"""

DEBOUNCE = """\
PROGRAM debounce
ALIAS Sensor : Local:2:I.Data.0
ALIAS Manual : Local:2:I.Data.1
ALIAS Kicker : Local:3:O.Data.0
TAG Bounce : TIMER
TAG Kick : TIMER
TAG Seen : BOOL
TAG Parts : COUNTER
ROUTINE Main
XIC(Sensor)TON(Bounce,30,0);
XIC(Manual)JSR(ByHand,0);
XIO(Manual)JSR(Automatic,0);
XIC(Parts.DN)RES(Parts);
END
ROUTINE ByHand
XIC(Sensor)OTE(Kicker);
JSR(Counting,0);
END
ROUTINE Automatic
[XIC(Bounce.DN),XIC(Kick.EN)]XIO(Kick.DN)TON(Kick,250,0);
XIC(Kick.TT)OTE(Kicker);
JSR(Counting,0);
END
ROUTINE Counting
XIC(Bounce.DN)ONS(Seen)CTU(Parts,500,0);
END
"""

RUNGS = {
    "drillunit.rung": DRILL,
    "jogbits.rung": JOG_BITS,
    "homing.rung": HOMING,
    "reversing.rung": REVERSING,
    "door.rung": DOOR,
    "shuttle.rung": SHUTTLE,
    "stations.rung": STATIONS,
    "debounce.rung": DEBOUNCE,
}
"""The programs by name."""
