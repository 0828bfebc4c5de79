'''Palletizer layers: two axes, one operator button per side, an andon light and statistics.'''

import math
from collections import Counter as Tally
from itertools import cycle, product

from scanrack import (
    Axis3601, AxisError, Configuration, Direction, Input, InputBit, Lock, Logic, OffDelay, OnDelay, Output, Pulse,
    Rise, State, WaitTimeout, all_of, dwell, first_of, sequence, steady, until, within,
)

SENSORS = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
GRID = tuple(product(range(3), range(2)))
PITCH = {"x": 1100, "y": 900}
HIGH_SPEED = 7000
RAMPS = dict(acceleration=25, deceleration=25)


def steps(millimeters: float) -> int:
    return math.floor(millimeters * 20 + 0.5)


class Palletizer(Logic):
    x = Axis3601(1, Configuration(inputs_used=SENSORS, step_and_direction=True, starting_speed=500))
    y = Axis3601(4, Configuration(inputs_used=SENSORS, step_and_direction=True, starting_speed=500))
    left = Input("Local:2:I.Data.0")
    right = Input("Local:2:I.Data.1")
    box = Input("Local:2:I.Data.2")
    e_stop = Input("Local:2:I.Data.3")
    gripper: Output = Output("Local:3:O.Data.0")
    green: Output = Output("Local:3:O.Data.1")
    red: Output = Output("Local:3:O.Data.2")
    horn: Output = Output("Local:3:O.Data.3")
    idle = OnDelay("30 s")
    glow = OffDelay("1 s")
    beep = Pulse("300 ms")
    pressed = Rise()
    area = Lock()
    auto = False
    side = "left"
    layers = 0

    def __init__(self) -> None:
        self.tally: Tally[str] = Tally()
        self.places = cycle(GRID)

    def every_scan(self) -> None:
        if self.pressed(self.left or self.right):
            self.auto = not self.auto
            self.side = "left" if self.left else "right"
        moving = self.x.moving or self.y.moving
        self.green = self.glow(self.auto)
        self.red = not self.auto and moving
        self.horn = self.beep(self.idle(self.auto and not moving))

    @sequence
    async def main(self) -> None:
        while True:
            try:
                await self.home_all()
                while self.auto or not self.e_stop:
                    await until(lambda: self.auto and bool(self.box), "a box")
                    column, row = next(self.places)
                    await self.carry(column, row)
                    self.tally[self.side] += 1
                    if sum(self.tally.values()) % len(GRID) == 0:
                        self.layers += 1
                        await dwell("2 s")
            except AxisError as error:
                self.gripper = False
                self.auto = False
                await steady(lambda: not self.e_stop, "500 ms", f"after {error}")
            except WaitTimeout:
                await self.stop_all()

    async def home_all(self) -> None:
        for axis in (self.x, self.y):
            if axis.state == State.DISABLED:
                await axis.configure()
            elif axis.state == State.ERROR_STOP:
                await axis.reset()
            if axis.status.POSITION_INVALID:
                await axis.home(Direction.CCW, speed=1500, **RAMPS)

    async def carry(self, column: int, row: int) -> None:
        async with self.area:
            await within("20 s", self.go(0, 0))
            self.gripper = True
            await dwell("150 ms")
            await self.go(column * PITCH["x"] + steps(1.5), row * PITCH["y"])
            self.gripper = False
            await dwell("150 ms")

    async def go(self, x: int, y: int) -> None:
        await all_of(
            self.x.move_to(x, speed=HIGH_SPEED, **RAMPS),
            self.y.move_to(y, speed=HIGH_SPEED // 2, **RAMPS),
        )

    async def stop_all(self) -> None:
        if self.x.moving:
            await self.x.halt()
        if self.y.moving:
            await self.y.halt()
        await first_of(self.left.rises, self.right.rises)
