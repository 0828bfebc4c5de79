from scanrack import (
    Axis3601, AxisError, BlendSegment, Configuration, Direction, Input, InputBit, Lock, Logic, OnDelay,
    Output, dwell, sequence, steady, until, within,
)

SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)
STATIONS = (0, 4000, 8000)
PATH = (BlendSegment(length=1000, speed=1000, rate=10), BlendSegment(length=4000, speed=8000, rate=50))


class Line(Logic):
    feeder = Axis3601(1, SETTINGS)
    pusher = Axis3601(4, SETTINGS)
    start = Input("Local:2:I.Data.0")
    stop = Input("Local:2:I.Data.1")
    full = Input("Local:2:I.Data.2")
    lamp: Output = Output("Local:3:O.Data.0")
    valve: Output = Output("Local:3:O.Data.1")
    late = OnDelay("2 s")
    zone = Lock()
    table = Lock()
    running = False
    homed = False
    speed = 3000
    parts = 0

    def every_scan(self) -> None:
        if self.stop:
            self.running = False
        elif self.start:
            self.running = True
        self.lamp = self.late(self.feeder.moving)

    @sequence
    async def feed(self) -> None:
        await self.feeder.configure()
        await self.feeder.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        self.homed = True
        while True:
            await until(lambda: self.running, "running")
            self.speed = 2000 if self.full else 3000
            for station in STATIONS:
                async with self.zone:
                    await self.stroke(station, self.speed)
            self.parts += 1

    async def stroke(self, target: int, speed: int) -> None:
        try:
            await within("5 s", self.feeder.move_to(target, speed=speed, acceleration=20, deceleration=20))
        except AxisError:
            await self.feeder.reset()
        await dwell("100 ms")

    @sequence
    async def push(self) -> None:
        await self.pusher.configure()
        await self.pusher.set_position(0)
        await self.pusher.program_blend(PATH, final_deceleration=20)
        while True:
            await until(lambda: self.running and self.homed)
            async with self.zone:
                async with self.table:
                    self.valve = True
                    await self.pusher.run_blend(Direction.CW)
                    await self.pusher.run_blend(Direction.CCW)
                    self.valve = False
            await steady(lambda: not self.full, "200 ms")
