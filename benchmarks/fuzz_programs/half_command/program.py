"""An axis goes from station to station. Between moves the parameters stay and the command bits are zero."""

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
STATIONS = [1300, 2700, 0]
MOVES = [
    Move(MoveKind.ABSOLUTE, station, speed=9000, acceleration=100, deceleration=100).to_image()
    for station in STATIONS
]


class Line:
    step, since, next_station = "ready", 0, 0


line = Line()


def go(step, scan):
    line.step, line.since = step, scan.number


def logic(scan):
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    age = scan.number - line.since
    if not status.MODULE_OK or status.CONFIG_ERROR or status.MODE_CONFIG:
        out.load(WORDS if status.MODULE_OK and status.CONFIG_ERROR else IDLE)
        go("ready", scan)
    elif status.INPUT_ERROR or status.COMMAND_ERROR or status.INVALID_PROFILE:
        out.load(RESET if age % 20 > 10 and not status.IN_ESTOP else IDLE)
        if line.step != "trouble":
            go("trouble", scan)
    elif status.POSITION_INVALID:
        out.load(ZERO if age % 20 > 10 and not status.moving else IDLE)
        if line.step != "unknown":
            go("unknown", scan)
    elif line.step in ("ready", "trouble", "unknown"):
        out.load(IDLE)
        if age > 10 and not status.moving:
            go("parameters", scan)
    elif line.step == "parameters":
        out.load(MOVES[line.next_station])
        out[0] = 0
        if age > 20:
            go("move", scan)
    elif line.step == "move":
        out.load(MOVES[line.next_station])
        if age > 10 and not status.moving:
            out[0] = 0
            line.next_station = (line.next_station + 1) % len(MOVES)
            go("rest", scan)
    elif line.step == "rest" and age > 20:
        go("parameters", scan)
