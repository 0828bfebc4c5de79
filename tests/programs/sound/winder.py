'''A winder with inheritance, match, a timeline of recipes and a watchdog.'''

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

from scanrack import (
    Axis3601, AxisError, CommandAborted, Configuration, Direction, Fall, Input, InputBit, InputWord, Lock, Logic,
    OnDelay, Output, Rise, WaitTimeout, dwell, first_of, sequence, steady, until, within,
)

LIMITS = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT


@dataclass(frozen=True)
class Recipe:
    turns: int
    speed: int
    pause: str = "200 ms"


RECIPES = {"thin": Recipe(40, 6000), "thick": Recipe(25, 3000, "500 ms")}
STEPS_PER_TURN = 200


class Base(Logic):
    drum = Axis3601(1, Configuration(inputs_used=LIMITS, step_and_direction=True, starting_speed=300))
    stop = Input("Local:2:I.Data.0")
    fault: Output = Output("Local:3:O.Data.0")
    error = ""

    async def prepare(self) -> None:
        await self.drum.configure()
        await self.drum.home(Direction.CCW, speed=700, acceleration=10, deceleration=10)

    async def recover(self) -> None:
        self.fault = True
        await steady(lambda: not self.stop, "2 s")
        await self.drum.reset()
        self.fault = False


class Winder(Base):
    traverse = Axis3601(4, Configuration(inputs_used=LIMITS, step_and_direction=True, starting_speed=200))
    start = Input("Local:2:I.Data.1")
    thick = Input("Local:2:I.Data.2")
    tension = InputWord("Local:2:I.Data[0]")
    clamp: Output = Output("Local:3:O.Data.1")
    lamps: Output = Output("Local:3:O.Data.2")
    slack = OnDelay("800 ms")
    started = Rise()
    released = Fall()
    guard = Lock()
    wanted = False
    layer = 0

    def every_scan(self) -> None:
        if self.started(self.start):
            self.wanted = True
        if self.released(self.start) and self.stop:
            self.wanted = False
        self.lamps = self.slack(self.tension < 100 and self.wanted)

    @sequence
    async def wind(self) -> None:
        for attempt in count(1):
            try:
                await self.prepare()
                await self.traverse.configure()
                await self.traverse.set_position(0)
                while True:
                    await until(lambda: self.wanted, "wanted")
                    await self.coil(RECIPES["thick" if self.thick else "thin"])
                    self.wanted = False
            except (AxisError, CommandAborted, WaitTimeout) as problem:
                self.error = f"{attempt}: {problem}"
        await self.recover()

    async def coil(self, recipe: Recipe) -> None:
        self.clamp = True
        try:
            for turn in range(recipe.turns):
                self.layer, side = divmod(turn, 10)
                async with self.guard:
                    move = self.drum.move_by(STEPS_PER_TURN * 4, speed=recipe.speed, acceleration=30, deceleration=30)
                    await self.traverse.move_to(side * 50, speed=400, acceleration=10, deceleration=10)
                    await within("10 s", move)
                if self.stop:
                    break
            await dwell(recipe.pause)
        finally:
            self.clamp = False

    @sequence
    async def watch(self) -> None:
        while True:
            done = await first_of(self.stop.rises, until(lambda: self.error != ""))
            match done:
                case None:
                    self.wanted = False
                case _:
                    await dwell("100 ms")
