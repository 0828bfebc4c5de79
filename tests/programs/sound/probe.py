from scanrack import Axis3601, AxisError, Configuration, Input, InputBit, Logic, Output, dwell, first_of, sequence

SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)


class Probe(Logic):
    axis = Axis3601(1, SETTINGS, parameters_first=True)
    go = Input("Local:2:I.Data.0")
    good: Output = Output("Local:3:O.Data.0")
    found = 0
    tries = 0

    @sequence
    async def search(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        while True:
            await self.go.rises
            self.good = False
            touch = self.axis.captured()
            run = self.axis.run(800, acceleration=10, deceleration=10)
            done = await first_of(touch, self.go.falls)
            await self.axis.halt()
            if self.found > 100 and not run.error:
                self.good = done is not None
            self.tries += 1
            await self.back()

    async def back(self) -> None:
        for attempt in range(3):
            try:
                await self.axis.move_to(0, speed=2000 + 500 * attempt, acceleration=10, deceleration=10)
            except AxisError:
                await self.axis.reset()
                await dwell("100 ms")
            else:
                break
        self.found = self.axis.position
