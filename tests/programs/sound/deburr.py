'''A deburring spindle on a slide: sequences with helpers and a blend.'''

from scanrack import (
    Axis3601, AxisError, BlendSegment, CommandAborted, Configuration, Counter, Direction, Input, InputBit, Logic,
    OffDelay, Output, Pulse, dwell, sequence, until,
)

IN = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
PROFILE = [
    BlendSegment(length=800, speed=1500, rate=20),
    BlendSegment(length=3000, speed=4000, rate=20),
    BlendSegment(length=900, speed=1200, rate=20),
]


class Deburr(Logic):
    slide = Axis3601(1, Configuration(inputs_used=IN, step_and_direction=True, starting_speed=400))
    cycle_start = Input("Local:2:I.Data.0")
    door_closed = Input("Local:2:I.Data.1")
    part_clamped = Input("Local:2:I.Data.2")
    spindle: Output = Output("Local:3:O.Data.0")
    clamp: Output = Output("Local:3:O.Data.1")
    coolant: Output = Output("Local:3:O.Data.2")
    door_lamp: Output = Output("Local:3:O.Data.3")
    run_on = OffDelay("5 s")
    grease = Pulse("2 s")
    strokes = Counter(250)
    passes = 3
    cutting = False
    dull = False

    def every_scan(self) -> None:
        self.coolant = self.run_on(self.cutting) and not self.dull
        self.dull = self.strokes(self.cutting)
        self.door_lamp = self.grease(not self.door_closed)

    @sequence
    async def work(self) -> None:
        await self.slide.configure()
        await self.slide.home(Direction.CCW, speed=900, acceleration=10, deceleration=10)
        await self.slide.program_blend(PROFILE, final_deceleration=20)
        while True:
            await self.cycle_start.rises
            await until(lambda: bool(self.door_closed))
            self.clamp = True
            await self.part_clamped.on
            try:
                await self.machine()
            except (AxisError, CommandAborted):
                await self.slide.reset()
            finally:
                self.spindle = False
                self.cutting = False
            self.clamp = False

    async def machine(self) -> None:
        self.spindle = True
        await dwell("700 ms")
        for count in range(self.passes):
            self.cutting = True
            await self.slide.run_blend(Direction.CW)
            self.cutting = False
            await self.slide.move_to(0, speed=6000, acceleration=30, deceleration=30)
            if count == 0:
                await dwell("200 ms")
