"""Logic of the three-station line: configure the 3601, then continue at every pulse.

Acceleration 1000 steps/s/s, starting speed 500 and maximum speed 5000 steps/s,
as in the tutorial. `logic` is called once per scan; what it has to remember
between scans is in `line`.
"""

from scanrack import Configuration, Idle, InputBit, LogicScan, Move, MoveKind, PresetPosition, StatusView

STATIONS = (0, 4000, 8000)

CONFIGURATION = Configuration(
    inputs_used=InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT,
    step_and_direction=True,
    starting_speed=500,
)


class Line:
    """What the line remembers from scan to scan."""

    step = "configure"
    station = 0
    pulse_before = False


line = Line()


def logic(scan: LogicScan) -> None:
    """Do one scan."""
    status = StatusView(scan.slot[1].inputs)
    outputs = scan.slot[1].outputs
    pulse = status.IN_CAPTURE and not status.MODE_CONFIG

    if line.step == "configure":
        outputs.load(CONFIGURATION.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            line.step = "leave configuration mode"

    elif line.step == "leave configuration mode":
        if not status.MODE_CONFIG:
            outputs.load(PresetPosition(STATIONS[0]).to_image())
            line.step = "preset"

    elif line.step == "preset":
        if not status.POSITION_INVALID:
            outputs.load(Idle().to_image())
            line.step = "wait for the station"

    elif line.step == "wait for the station":
        if pulse and not line.pulse_before:
            line.station = (line.station + 1) % len(STATIONS)
            move = Move(MoveKind.ABSOLUTE, STATIONS[line.station], speed=5000, acceleration=1, deceleration=1)
            outputs.load(move.to_image())
            line.step = "start"

    elif line.step == "start":
        if status.MOVING_CW or status.MOVING_CCW:
            outputs[0] = 0  # the command has been taken; the parameters may stay
            line.step = "move"

    elif line.step == "move" and status.MOVE_COMPLETE:
        line.step = "wait for the station"

    line.pulse_before = pulse
