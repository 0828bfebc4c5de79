"""Correct programs in Python for `scanrack check`, by hand and with `await`: none of them has a finding."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

USED = "Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=500)"

BY_HAND = {
    "hand_seal.py": """\
state = {"run": False, "since": 0}


def logic(scan):
    card, lamps = scan.slot[2].inputs, scan.slot[3].outputs
    start, stop_ok = card.bit(0, 0), card.bit(0, 1)
    if not stop_ok:
        state["run"] = False
    elif start and not state["run"]:
        state["run"], state["since"] = True, scan.now_ns
    warmed = state["run"] and scan.now_ns - state["since"] >= 3_000_000_000
    lamps.set_bit(0, 0, state["run"])
    lamps.set_bit(0, 1, warmed)
""",
    "hand_toggle.py": """\
class Button:
    before = False
    lamp = False


button = Button()


def logic(scan):
    pressed = scan.slot[2].inputs.bit(0, 0)
    if pressed and not button.before:
        button.lamp = not button.lamp
    button.before = pressed
    scan.slot[3].outputs.set_bit(0, 0, button.lamp)
""",
    "hand_jog.py": f"""\
from scanrack import Configuration, Direction, Idle, InputBit, Manual, StatusView

SETTINGS = {USED}


class Panel:
    ready = False


panel = Panel()


def logic(scan):
    axis = scan.slot[1]
    status = StatusView(axis.inputs)
    right, left = scan.slot[2].inputs.bit(0, 0), scan.slot[2].inputs.bit(0, 1)
    if not panel.ready:
        axis.outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            axis.outputs.load(Idle().to_image())
            panel.ready = True
    elif right and not left:
        axis.outputs.load(Manual(Direction.CW, 1500, 20, 20).to_image())
    elif left and not right:
        axis.outputs.load(Manual(Direction.CCW, 1500, 20, 20).to_image())
    else:
        axis.outputs[0] = 0
""",
    "hand_jogbits.py": """\
CONFIGURE = (0x8434, 0x0034, 0, 500, 0, 0, 0, 0)
MANUAL_CW, MANUAL_CCW = 7, 8
ready = False


def logic(scan):
    global ready
    inputs, outputs = scan.slot[1].inputs, scan.slot[1].outputs
    buttons = scan.slot[2].inputs
    if not ready:
        for word, value in enumerate(CONFIGURE):
            outputs[word] = value
        if inputs.bit(0, 15) and not inputs.bit(0, 13):
            outputs.clear()
            ready = True
        return
    plus, minus = buttons.bit(0, 0), buttons.bit(0, 1)
    outputs[4], outputs[5] = 1, 250
    outputs[6] = outputs[7] = 30
    outputs.set_bit(0, MANUAL_CW, plus and not minus)
    outputs.set_bit(0, MANUAL_CCW, minus and not plus)
""",
    "hand_stations.py": f"""\
from scanrack import Configuration, Idle, InputBit, PresetPosition, StatusView

STOPS = (0, -2500, 4000, 8250)
SETTINGS = {USED}
ABSOLUTE = 0


def split(value):
    msw, lsw = divmod(abs(value), 1000)
    return (-msw, -lsw) if value < 0 else (msw, lsw)


class Line:
    step = "configure"
    at = 0
    before = False


line = Line()


def logic(scan):
    axis, outputs = scan.slot[1], scan.slot[1].outputs
    status = StatusView(axis.inputs)
    pressed = scan.slot[2].inputs.bit(0, 0)
    if line.step == "configure":
        outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            line.step = "leave"
    elif line.step == "leave":
        if not status.MODE_CONFIG:
            outputs.load(PresetPosition(0).to_image())
            line.step = "preset"
    elif line.step == "preset":
        if not status.POSITION_INVALID:
            outputs.clear()
            line.step = "wait"
    elif line.step == "wait":
        if pressed and not line.before:
            line.at = (line.at + 1) % len(STOPS)
            outputs[2], outputs[3] = split(STOPS[line.at])
            outputs[4], outputs[5] = 3, 500
            outputs[6] = outputs[7] = 40
            outputs.set_bit(0, ABSOLUTE, True)
            line.step = "start"
    elif line.step == "start":
        if status.MOVING_CW or status.MOVING_CCW:
            outputs.set_bit(0, ABSOLUTE, False)
            line.step = "move"
    elif line.step == "move" and status.MOVE_COMPLETE:
        line.step = "wait"
    line.before = pressed
""",
    "hand_homing.py": f"""\
from enum import Enum, auto

from scanrack import Configuration, Direction, FindHome, Idle, InputBit, ResetErrors, StatusView

SETTINGS = {USED}
PAUSE_NS = 250_000_000
SEARCH = FindHome(Direction.CCW, speed=900, acceleration=10, deceleration=10)


class Phase(Enum):
    OFF = auto()
    CONFIGURED = auto()
    SEARCHING = auto()
    PAUSING = auto()
    CLEARING = auto()
    HOMED = auto()
    FAILED = auto()


class Homing:
    phase = Phase.OFF
    tries = 0
    since = 0


homing = Homing()


def logic(scan):
    axis = scan.slot[1]
    status = StatusView(axis.inputs)
    reset = scan.slot[2].inputs.bit(0, 0)
    match homing.phase:
        case Phase.OFF:
            axis.outputs.load(SETTINGS.to_image())
            if status.MODE_CONFIG and not status.CONFIG_ERROR:
                axis.outputs.load(Idle().to_image())
                homing.phase = Phase.CONFIGURED
        case Phase.CONFIGURED:
            if not status.MODE_CONFIG:
                homing.tries += 1
                axis.outputs.load(SEARCH.to_image())
                homing.phase = Phase.SEARCHING
        case Phase.SEARCHING:
            if status.AT_HOME:
                axis.outputs[0] = 0
                homing.phase = Phase.HOMED
            elif status.HOME_INVALID:
                axis.outputs[0] = 0
                homing.since = scan.now_ns
                homing.phase = Phase.PAUSING if homing.tries < 3 else Phase.FAILED
        case Phase.PAUSING:
            if scan.now_ns - homing.since > PAUSE_NS:
                axis.outputs.load(ResetErrors().to_image())
                homing.phase = Phase.CLEARING
        case Phase.CLEARING:
            if not status.HOME_INVALID:
                axis.outputs.load(Idle().to_image())
                homing.phase = Phase.CONFIGURED
        case Phase.FAILED:
            if reset:
                homing.tries = 0
                homing.phase = Phase.PAUSING
    scan.slot[3].outputs.set_bit(0, 0, homing.phase is Phase.HOMED)
    scan.slot[3].outputs.set_bit(0, 1, homing.phase is Phase.FAILED)
""",
    "hand_reversing.py": """\
REST_NS = 1_500_000_000


class Drive:
    direction = 0
    stopped_ns = 0


drive = Drive()


def logic(scan):
    card, out = scan.slot[2].inputs, scan.slot[3].outputs
    forward, reverse, run = card.bit(0, 0), card.bit(0, 1), card.bit(0, 2)
    if not run:
        if drive.direction:
            drive.stopped_ns = scan.now_ns
        drive.direction = 0
    elif drive.direction == 0 and scan.now_ns - drive.stopped_ns >= REST_NS:
        drive.direction = forward - reverse
    out.set_bit(0, 0, drive.direction > 0)
    out.set_bit(0, 1, drive.direction < 0)
""",
}
"""Functions of the scan by name."""

HEAD = f"""\
from scanrack import (
    Axis3601, AxisError, Configuration, Direction, Input, InputBit, Logic, OnDelay, Output, Rise, State, WaitTimeout,
    dwell, first_of, sequence, steady, until, within,
)

SETTINGS = {USED}
"""

WITH_AWAIT = {
    "wait_homing.py": f"""{HEAD}

class Station(Logic):
    axis = Axis3601(1, SETTINGS)
    again = Input("Local:2:I.Data.0")
    failed: Output = Output("Local:3:O.Data.0")
    tries = 3

    @sequence
    async def main(self) -> None:
        await self.axis.configure()
        while True:
            if await self.find_home():
                await self.again.rises
            else:
                self.failed = True
                await self.again.rises
                self.failed = False

    async def find_home(self) -> bool:
        for attempt in range(self.tries):
            try:
                await within("30 s", self.axis.home(Direction.CCW, speed=900 + 100 * attempt, acceleration=10, deceleration=10))
            except (AxisError, WaitTimeout):
                await self.axis.halt()
                await dwell("250 ms")
                await self.axis.reset()
            else:
                return True
        return False
""",
    "wait_jog.py": f"""{HEAD}

class Panel(Logic):
    axis = Axis3601(1, SETTINGS)
    right = Input("Local:2:I.Data.0")
    left = Input("Local:2:I.Data.1")
    slow = Input("Local:2:I.Data.2")

    @sequence
    async def panel(self) -> None:
        await self.axis.configure()
        while True:
            way = await first_of(self.right.on, self.left.on)
            speed = 300 if self.slow else 2000
            self.axis.run(speed if self.right else -speed, acceleration=20, deceleration=20)
            await until(lambda: self.right == self.left)
            await self.axis.halt()
            if way is None:
                await dwell("100 ms")
""",
    "wait_pick.py": f"""{HEAD}
STOPS = {{"pick": -1500, "place": 7250}}


class Pick(Logic):
    axis = Axis3601(1, SETTINGS)
    box = Input("Local:2:I.Data.0")
    closed = Input("Local:2:I.Data.1")
    gripper: Output = Output("Local:3:O.Data.0")
    boxes = 0

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        while True:
            await self.go("pick")
            if not self.box:
                await self.box.on
            self.gripper = True
            await within("2 s", self.closed.on)
            await self.go("place")
            self.gripper = False
            while self.closed:
                await dwell("50 ms")
            self.boxes += 1

    async def go(self, name: str) -> None:
        target = STOPS[name]
        await self.axis.move_to(target, speed=4000, acceleration=30, deceleration=30)
""",
    "wait_faults.py": f"""{HEAD}

class Guarded(Logic):
    axis = Axis3601(1, SETTINGS)
    guard = Input("Local:2:I.Data.0")
    reset = Input("Local:2:I.Data.1")
    horn: Output = Output("Local:3:O.Data.0")
    pressed = Rise()
    fault = False

    def every_scan(self) -> None:
        if not self.guard:
            self.fault = True
        elif self.pressed(self.reset):
            self.fault = False
        self.horn = self.fault

    @sequence
    async def work(self) -> None:
        while True:
            try:
                await until(lambda: not self.fault, "no fault")
                if self.axis.state == State.DISABLED:
                    await self.axis.configure()
                if self.axis.state == State.ERROR_STOP:
                    await self.axis.reset()
                await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
                while not self.fault:
                    await self.axis.move_by(2500, speed=3000, acceleration=20, deceleration=20)
                    await self.axis.move_by(-2500, speed=3000, acceleration=20, deceleration=20)
            except AxisError:
                self.fault = True
                await steady(lambda: bool(self.guard), "1 s")
""",
    "wait_recipe.py": f"""{HEAD}
RECIPES = ((1200, 2500, 20), (-800, 1500, 10), (4000, 9000, 60))


class Recipes(Logic):
    axis = Axis3601(1, SETTINGS)
    go = Input("Local:2:I.Data.0")
    done: Output = Output("Local:3:O.Data.0")
    number = 0

    @sequence
    async def run(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        while True:
            await self.go.rises
            self.done = False
            distance, speed, rate = RECIPES[self.number]
            await self.axis.move_by(distance, speed=speed, acceleration=rate, deceleration=rate)
            self.number = (self.number + 1) % len(RECIPES)
            remaining = self.number
            while remaining > 0:
                remaining -= 1
            self.done = True
""",
}
"""Classes with sequences by name."""
