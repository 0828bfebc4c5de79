from scanrack import Axis3601, Configuration, Input, InputBit, Lock, Logic, Output, dwell, sequence, until

USED = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
GEARED = Configuration(inputs_used=USED, quadrature_encoder=True, starting_speed=500)


class Follow(Logic):
    belt = Axis3601(1, GEARED)
    go = Input("Local:2:I.Data.0")
    busy: Output = Output("Local:3:O.Data.0")
    ready: Output = Output("Local:3:O.Data.1")
    lock = Lock()
    shift = 0

    @sequence
    async def follow(self) -> None:
        await self.belt.configure()
        while True:
            await self.go.rises
            async with self.lock:
                self.busy = True
                self.belt.gear(2, 1)
                await self.go.falls
                await self.belt.gear_out()
                self.busy = False

    @sequence
    async def correct(self) -> None:
        while True:
            self.ready = bool(self.belt.state)
            await until(lambda: self.shift != 0 and not self.belt.moving)
            async with self.lock:
                await self.belt.move_by(max(-100, min(self.shift, 100)), speed=800, acceleration=10, deceleration=10)
                self.shift = 0
            await dwell("20 ms")

    def every_scan(self) -> None:
        if self.belt.captured and self.belt.encoder > 1000:
            self.shift = 10
