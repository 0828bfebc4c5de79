'''A gantry: x carries z; parts go from the belt to a tray of twelve places.'''

from scanrack import (
    Axis3601, AxisError, Configuration, Direction, Input, InputBit, Lock, Logic, OnDelay, Output, Rise, State,
    WaitTimeout, all_of, dwell, first_of, sequence, steady, until, within,
)

SWITCHES = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
RAPID = 9000
CAREFUL = 1200
ROWS, COLUMNS = 3, 4
PITCH_X, PITCH_Z = 700, 350
BELT = -1200


class Gantry(Logic):
    x = Axis3601(1, Configuration(inputs_used=SWITCHES, starting_speed=600))
    z = Axis3601(4, Configuration(inputs_used=SWITCHES, starting_speed=200))
    part = Input("Local:2:I.Data.0")
    vacuum_ok = Input("Local:2:I.Data.1")
    tray_new = Input("Local:2:I.Data.2")
    estop = Input("Local:2:I.Data.3")
    vacuum: Output = Output("Local:3:O.Data.0")
    belt: Output = Output("Local:3:O.Data.1")
    call_operator: Output = Output("Local:3:O.Data.2")
    blower: Output = Output("Local:3:O.Data.3")
    jam = OnDelay("6 s")
    new_tray = Rise()
    motion = Lock()
    place_number = 0
    lost = 0
    ready = False
    tray_full = False

    def every_scan(self) -> None:
        if self.new_tray(self.tray_new):
            self.place_number = 0
            self.tray_full = False
        self.belt = self.ready and not self.part
        self.call_operator = self.tray_full or self.jam(self.ready and not self.part)

    @sequence
    async def transfer(self) -> None:
        while True:
            try:
                await self.prepare()
                while True:
                    await until(lambda: bool(self.part) and not self.tray_full, "part and place")
                    async with self.motion:
                        await self.pick()
                        await self.drop()
            except AxisError:
                self.ready = False
                self.vacuum = False
                await steady(lambda: not self.estop, "1 s")

    async def prepare(self) -> None:
        for axis in (self.z, self.x):
            if axis.state == State.DISABLED:
                await axis.configure()
            if axis.state == State.ERROR_STOP:
                await axis.reset()
            await axis.home(Direction.CCW, speed=CAREFUL, acceleration=10, deceleration=10)
        self.ready = True

    async def pick(self) -> None:
        await self.x.move_to(BELT, speed=RAPID, acceleration=40, deceleration=40)
        await self.z.move_to(1800, speed=RAPID // 2, acceleration=30, deceleration=30)
        self.vacuum = True
        try:
            await within("800 ms", self.vacuum_ok.on)
        except WaitTimeout:
            self.lost += 1
        await self.z.move_to(0, speed=RAPID // 2, acceleration=30, deceleration=30)

    async def drop(self) -> None:
        row, column = divmod(self.place_number, COLUMNS)
        await all_of(
            self.x.move_to(column * PITCH_X, speed=RAPID, acceleration=40, deceleration=40),
            self.z.move_to(200, speed=CAREFUL, acceleration=10, deceleration=10),
        )
        await self.z.move_to(1000 + row * PITCH_Z, speed=CAREFUL, acceleration=10, deceleration=10)
        self.vacuum = False
        await dwell("120 ms")
        await self.z.move_to(0, speed=RAPID // 2, acceleration=30, deceleration=30)
        self.place_number += 1
        if self.place_number == ROWS * COLUMNS:
            self.tray_full = True

    @sequence
    async def clean(self) -> None:
        while True:
            await self.vacuum_ok.falls
            self.blower = True
            await first_of(dwell("300 ms"), self.estop.rises)
            self.blower = False
