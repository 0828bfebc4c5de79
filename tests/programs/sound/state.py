from dataclasses import dataclass, field

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, Move, MoveKind, StatusView

SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)


@dataclass
class State:
    step: int = 0
    queue: list = field(default_factory=list)
    since_ns: int = 0

    def go(self, step, now_ns):
        self.step = step
        self.since_ns = now_ns


state = State()


def logic(scan):
    axis, status = scan.slot[1], StatusView(scan.slot[1].inputs)
    start = scan.slot[2].inputs.bit(0, 0)
    if state.step == 0:
        axis.outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG:
            axis.outputs.load(Idle().to_image())
            state.go(1, scan.now_ns)
    elif state.step == 1 and not status.MODE_CONFIG:
        axis.outputs.load(FindHome(Direction.CCW, 1000, 10, 10).to_image())
        state.go(2, scan.now_ns)
    elif state.step == 2 and status.AT_HOME:
        axis.outputs[0] = 0
        state.queue = [4000, 0]
        state.go(3, scan.now_ns)
    elif state.step == 3 and start and state.queue:
        target = state.queue.pop(0)
        axis.outputs.load(Move(MoveKind.ABSOLUTE, target, 5000, 20, 20).to_image())
        state.go(4, scan.now_ns)
    elif state.step == 4 and status.MOVE_COMPLETE and scan.now_ns - state.since_ns > 50_000_000:
        axis.outputs.load(Idle().to_image())
        state.go(3, scan.now_ns)
    scan.slot[3].outputs.set_bit(0, 0, state.step == 4)
