"""Over a line: an axis of a PCL601 goes between two stations and rests at each."""

from scanrack import StatusView
from scanrack.io_images.amci3601 import (
    Configuration,
    Idle,
    InputBit,
    Move,
    MoveKind,
    PresetPosition,
    ResetErrors,
)

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
IDLE, RESET, ZERO = Idle().to_image(), ResetErrors().to_image(), PresetPosition(0).to_image()
MOVES = [
    Move(MoveKind.ABSOLUTE, at, speed=6000, acceleration=50, deceleration=50).to_image() for at in (900, 0)
]


class Line:
    step, since, station, homed = "wait", 0, 0, False


line = Line()


def go(step, scan):
    line.step, line.since = step, scan.number


def logic(scan):
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    age = scan.number - line.since
    if not status.MODULE_OK or status.MODE_CONFIG or status.CONFIG_ERROR:
        out.load(WORDS if status.MODULE_OK and status.CONFIG_ERROR else IDLE)
        line.homed = False
        go("wait", scan)
    elif status.INPUT_ERROR or status.COMMAND_ERROR or status.INVALID_PROFILE:
        out.load(RESET if age % 60 > 30 and not status.IN_ESTOP else IDLE)
        if line.step != "trouble":
            line.homed = False
            go("trouble", scan)
    elif status.POSITION_INVALID and line.step not in ("zero", "trouble", "wait", "move"):
        out.load(IDLE)
        line.homed = False
        go("zero", scan)
    elif line.step == "zero":
        out.load(ZERO if age > 40 and not status.moving else IDLE)
        if not status.POSITION_INVALID and age > 80:
            line.homed = True
            go("wait", scan)
    elif line.step in ("wait", "trouble"):
        out.load(IDLE)
        if age > 60 and not status.moving:
            go("move" if line.homed else "zero", scan)
    elif line.step == "move":
        out.load(MOVES[line.station])
        if age > 40 and not status.moving and status.MOVE_COMPLETE:
            line.station = 1 - line.station
            go("rest", scan)
        elif age > 400:
            line.homed = not status.POSITION_INVALID
            go("wait", scan)
    elif line.step == "rest":
        out.load(IDLE)
        if age > 100:
            go("move", scan)
