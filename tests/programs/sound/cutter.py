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
