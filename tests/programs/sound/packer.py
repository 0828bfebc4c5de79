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
