from scanrack import Idle, InputBit, Configuration, Move, MoveKind, PresetPosition, StatusView

SPEED = 5000
SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)


class Line:
    step = "configure"
    station = 0
    before = False


line = Line()


def logic(scan):
    axis = scan.slot[1]
    status = StatusView(axis.inputs)
    outputs = axis.outputs
    pulse = scan.slot[2].inputs.bit(0, 0)
    scan.slot[3].outputs.set_bit(0, 0, status.MOVE_COMPLETE)
    if line.step == "configure":
        outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            line.step = "preset"
    elif line.step == "preset":
        outputs.load(PresetPosition(0).to_image())
        if not status.POSITION_INVALID:
            outputs.load(Idle().to_image())
            line.step = "wait"
    elif line.step == "wait":
        if pulse and not line.before:
            line.station = next_station(line.station)
            move = Move(MoveKind.ABSOLUTE, 4000 * line.station, speed=SPEED, acceleration=10, deceleration=10)
            outputs.load(move.to_image())
            line.step = "move"
    elif status.MOVE_COMPLETE:
        outputs[0] = 0
        line.step = "wait"
    line.before = pulse


def next_station(station):
    return (station + 1) % 3
