from scanrack import (
    Abort, Axis3601, Configuration, Direction, Input, InputBit, Logic, Output, Rise, dwell, sequence, until,
)

HOME_SPEED = 1000
BASE = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)


class Station(Logic):
    axis = Axis3601(1, BASE)
    start = Input("Local:2:I.Data.0")
    estop = Input("Local:2:I.Data.1")
    door = Input("Local:2:I.Data.2")
    lamp: Output = Output("Local:3:O.Data.0")
    tool: Output = Output("Local:3:O.Data.1")
    estopped = Rise()
    rounds = 0
    offset = 0
    homed = False

    def __init__(self, far: int = 6000) -> None:
        self.far = far
        self.seen: list[int] = []

    def every_scan(self) -> None:
        if self.estopped(self.estop):
            self.cycle.restart()
            self.homed = False
        self.lamp = bool(self.door) and self.axis.moving

    @sequence
    async def cycle(self) -> None:
        if self.axis.status.CONFIG_ERROR:
            await self.axis.configure()
        if not self.homed:
            await self.axis.reset()
            await self.axis.home(Direction.CCW, speed=HOME_SPEED, acceleration=10, deceleration=10)
            self.homed = True
        try:
            while not self.estop:
                if not self.door:
                    await self.door.on
                await self.start.rises
                for target in (self.far, self.far // 2, self.offset):
                    await self.axis.move_to(target, speed=3 * HOME_SPEED, acceleration=20, deceleration=20)
                    await self.press(0.5)
                self.rounds += 1
                self.seen.append(self.axis.position)
        except Abort:
            with self.axis.stop():
                await dwell("500 ms")
            raise
        finally:
            self.tool = False

    async def press(self, seconds: float) -> None:
        self.tool = True
        await dwell(f"{seconds} s")
        self.tool = False
        await until(lambda: not self.axis.moving)


class Special(Station):
    offset = 250
