"""Sound programs for `scanrack check` that go from step to step and write the words of a 3601 themselves."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

FEEDER = """\
PROGRAM stripfeeder
// A strip feeder: a relative move per press stroke, words written one by one
SLOT feed : 1
ALIAS CamTop : Local:2:I.Data.0
ALIAS AutoSel : Local:2:I.Data.1
ALIAS Lube : Local:2:I.Data.2
ALIAS FaultReset : Local:2:I.Data.3
ALIAS FeedOk : Local:3:O.Data.0
ALIAS LubeValve : Local:3:O.Data.1
ALIAS Beacon : Local:3:O.Data.2
TAG Config : INT[8] := [16#8434, 16#0034, 0, 200, 0, 0, 0, 0]
TAG Zero : INT[8] := [16#0200, 0, 0, 0, 0, 0, 0, 0]
TAG State : DINT
TAG Length : DINT := 1250
TAG FeedSpeed : DINT := 6000
TAG CamEdge : BOOL
TAG Strokes : COUNTER
TAG LubeTime : TIMER
TAG Late : TIMER
TAG Faulted : BOOL

ROUTINE Main
XIC(S:FS)MOV(0,State);
EQU(State,0)COP(Config,feed.O.Data,8);
EQU(State,0)XIC(feed.status.MODE_CONFIG)XIO(feed.status.CONFIG_ERROR)MOV(5,State);
EQU(State,5)FLL(0,feed.O.Data,8);
EQU(State,5)XIO(feed.status.MODE_CONFIG)MOV(7,State);
EQU(State,7)COP(Zero,feed.O.Data,8);
EQU(State,7)XIO(feed.status.POSITION_INVALID)MOV(10,State);
EQU(State,10)FLL(0,feed.O.Data,8);
EQU(State,10)XIC(AutoSel)XIO(Faulted)XIC(CamTop)ONS(CamEdge)MOV(20,State);
EQU(State,20)DIV(Length,1000,feed.O.Data[2])MOD(Length,1000,feed.O.Data[3]);
EQU(State,20)DIV(FeedSpeed,1000,feed.O.Data[4])MOD(FeedSpeed,1000,feed.O.Data[5])MOV(80,feed.O.Data[6])MOV(80,feed.O.Data[7]);
EQU(State,20)MOV(25,State);
EQU(State,25)MOV(2,feed.O.Data[0]);
EQU(State,25)[XIC(feed.status.MOVING_CW),XIC(feed.status.MOVING_CCW)]MOV(30,State);
EQU(State,30)MOV(0,feed.O.Data[0]);
EQU(State,30)XIC(feed.status.MOVE_COMPLETE)CTU(Strokes,50,0);
EQU(State,30)XIC(feed.status.MOVE_COMPLETE)MOV(10,State);
GEQ(State,25)TON(Late,3000,0);
[XIC(Late.DN),XIC(feed.status.COMMAND_ERROR)]OTL(Faulted);
XIC(FaultReset)OTU(Faulted);
XIC(Faulted)MOV(5,State);
XIC(Strokes.DN)XIC(Lube)TON(LubeTime,800,0);
XIC(LubeTime.TT)OTE(LubeValve);
XIC(LubeTime.DN)RES(Strokes);
XIO(Faulted)GEQ(State,10)OTE(FeedOk);
XIC(Faulted)OTE(Beacon);
END
"""
"""A strip feeder: a relative move per stroke of a press."""

PACKER = '''\
"""Rungs made in Python: a pusher with a counter and a traffic light."""

from scanrack import Configuration, InputBit, Move, MoveKind, PresetPosition
from scanrack.ladder import ADD, BOOL, CLR, COP, COUNTER, CTU, DINT, FLL, INT, MOV, ONS, OTE, OTL, OTU, RES, TIMER, TON, Program

SETUP = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT, step_and_direction=True, starting_speed=300
)

program = Program("packer")
axis = program.slot("axis", 1)
status, words = axis.status, axis.O.Data
setup = program.declare("Setup", INT, 8, initial=list(SETUP.to_image()))
zero = program.declare("Zero", INT, 8, initial=list(PresetPosition(0).to_image()))
out = program.declare("Out", INT, 8, initial=list(Move(MoveKind.ABSOLUTE, 3000, 4000, 20, 20).to_image()))
back = program.declare("Back", INT, 8, initial=list(Move(MoveKind.ABSOLUTE, 0, 6000, 20, 20).to_image()))
step = program.declare("Step", DINT)
boxes = program.declare("Boxes", COUNTER)
pause = program.declare("Pause", TIMER)
box_edge, full = program.declare("BoxEdge Full", BOOL)


@program.routine
def Main(rung):
    rung("S:FS", MOV(0, step))
    rung(step == 0, COP(setup, words, 8))
    rung(step == 0, status.MODE_CONFIG, ~status.CONFIG_ERROR, MOV(1, step))
    rung(step == 1, FLL(0, words, 8))
    rung(step == 1, ~status.MODE_CONFIG, MOV(2, step))
    rung(step == 2, COP(zero, words, 8))
    rung(step == 2, ~status.POSITION_INVALID, MOV(3, step))
    rung(step == 3, FLL(0, words, 8))
    rung(step == 3, "Local:2:I.Data.0", ONS(box_edge), CTU(boxes, 4, 0))
    rung(step == 3, boxes.DN, MOV(4, step))
    rung(step == 4, COP(out, words, 8))
    rung(step == 4, status.MOVING_CW, CLR(words[0]), MOV(5, step))
    rung(step == 5, status.MOVE_COMPLETE, TON(pause, 400, 0))
    rung(pause.DN, MOV(6, step), RES(boxes))
    rung(step == 6, COP(back, words, 8))
    rung(step == 6, status.MOVING_CCW, CLR(words[0]), MOV(7, step))
    rung(step == 7, status.MOVE_COMPLETE, MOV(3, step))
    rung(boxes.DN, OTL(full))
    rung(step == 7, OTU(full))
    rung(full, OTE("Local:3:O.Data.0"))
    rung(step == 3, OTE("Local:3:O.Data.1"))
'''
"""Rungs made in Python: a pusher that counts boxes."""
