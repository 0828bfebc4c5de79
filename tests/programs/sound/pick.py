from scanrack import (
    Axis3601, AxisError, CommandAborted, Configuration, Direction, Input, InputBit, Logic, Output, State, WaitTimeout,
    all_of, dwell, first_of, sequence, until, within,
)

X_SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)
SPEED = 4000
RATES = {"acceleration": 20, "deceleration": 20}


class Picker(Logic):
    x = Axis3601(1, X_SETTINGS)
    z = Axis3601(4, X_SETTINGS)
    part = Input("Local:2:I.Data.0")
    estop = Input("Local:2:I.Data.1")
    gripped = Input("Local:2:I.Data.2")
    grip: Output = Output("Local:3:O.Data.0")
    alarm: Output = Output("Local:3:O.Data.1")
    picked = 0
    state_text = "idle"
    ready = False

    @sequence
    async def work(self) -> None:
        while True:
            try:
                await self.prepare()
                while True:
                    await self.pick()
                    await self.place()
            except (AxisError, CommandAborted) as error:
                self.state_text = str(error)
                self.grip = False
                self.alarm = True
                await until(lambda: not self.estop)
                await dwell("1 s")
                self.alarm = False

    async def prepare(self) -> None:
        self.ready = False
        for axis in (self.x, self.z):
            if axis.state == State.DISABLED:
                await axis.configure()
            if axis.state == State.ERROR_STOP:
                await axis.reset()
            await axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        self.ready = True

    async def pick(self) -> None:
        await until(lambda: self.ready and bool(self.part))
        await all_of(
            self.x.move_to(0, speed=SPEED, **RATES),
            self.z.move_to(500, speed=SPEED // 2, **RATES),
        )
        self.grip = True
        try:
            await within("500 ms", self.gripped.on)
        except WaitTimeout:
            self.grip = False
            return
        self.picked += 1

    async def place(self) -> None:
        stop = self.estop.rises
        move = self.x.move_by(6000 if self.picked % 2 else 3000, speed=SPEED, **RATES)
        if await first_of(move, stop) is stop:
            await self.x.halt()
        await self.z.move_to(0, speed=SPEED, **RATES)
        self.grip = False
