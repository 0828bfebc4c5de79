'''A dispenser: three heads, one function of the scan, helpers and a table.'''

from collections import deque
from dataclasses import dataclass
from enum import Enum, auto
from math import ceil

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, Manual, Move, MoveKind, ResetErrors, StatusView

CONFIG = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT, step_and_direction=True, starting_speed=250
)
DOSES = (("small", 600), ("medium", 1200), ("large", 2400))
SLOW, FAST = 800, 5200


class Phase(Enum):
    START = auto()
    CONFIGURED = auto()
    HOMING = auto()
    IDLE = auto()
    DOSING = auto()
    JOGGING = auto()
    ERROR = auto()


@dataclass
class Request:
    name: str
    steps: int


class Dispenser:
    def __init__(self, axis_slot, button_slot):
        self.axis_slot, self.button_slot = axis_slot, button_slot
        self.phase = Phase.START
        self.queue: deque[Request] = deque(maxlen=8)
        self.before = [False] * 4
        self.history = {}

    def edges(self, word):
        now = [bool(word >> bit & 1) for bit in range(4)]
        rising = [a and not b for a, b in zip(now, self.before)]
        self.before = now
        return rising

    def __call__(self, scan):
        axis = scan.slot[self.axis_slot]
        status = StatusView(axis.inputs)
        pressed = self.edges(scan.slot[self.button_slot].inputs[0])
        for index, (name, steps) in enumerate(DOSES):
            if pressed[index]:
                self.queue.append(Request(name, steps))
        handler = getattr(self, f"on_{self.phase.name.lower()}")
        handler(axis.outputs, status, jog=self.before[3])
        lamps = sum(1 << bit for bit, on in enumerate((self.queue, self.phase is Phase.ERROR)) if on)
        scan.slot[3].outputs[0] = lamps

    def on_start(self, outputs, status, jog):
        outputs.load(CONFIG.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.CONFIGURED

    def on_configured(self, outputs, status, jog):
        if not status.MODE_CONFIG and not jog:
            outputs.load(FindHome(Direction.CCW, SLOW, 10, 10).to_image())
            self.phase = Phase.HOMING

    def on_homing(self, outputs, status, jog):
        if status.AT_HOME and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE

    def on_idle(self, outputs, status, jog):
        if status.COMMAND_ERROR or status.INPUT_ERROR:
            self.phase = Phase.ERROR
        elif jog:
            outputs.load(Manual(Direction.CW, SLOW, 10, 10).to_image())
            self.phase = Phase.JOGGING
        elif self.queue:
            request = self.queue.popleft()
            self.history[request.name] = self.history.get(request.name, 0) + 1
            speed = FAST if request.steps > 1000 else SLOW
            ramp = max(10, ceil(speed / 100))
            outputs.load(Move(MoveKind.RELATIVE, request.steps, speed, ramp, ramp).to_image())
            self.phase = Phase.DOSING

    def on_dosing(self, outputs, status, jog):
        if status.MOVE_COMPLETE and not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE

    def on_jogging(self, outputs, status, jog):
        if not jog:
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE if not status.MOVING_CW else Phase.JOGGING

    def on_error(self, outputs, status, jog):
        outputs.load(ResetErrors().to_image())
        if not (status.COMMAND_ERROR or status.INPUT_ERROR or jog):
            outputs.load(Idle().to_image())
            self.phase = Phase.IDLE


logic = Dispenser(axis_slot=1, button_slot=2)
