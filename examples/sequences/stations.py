"""Three stations: home, then at each press of start 0, 4000 and 8000 steps, two seconds at each.

An emergency stop ends the round; once it has been out for a second the axis searches for home again.
"""

from scanrack import (
    Axis3601,
    AxisError,
    Configuration,
    Direction,
    Input,
    InputBit,
    Logic,
    Output,
    State,
    WaitTimeout,
    dwell,
    sequence,
    steady,
    within,
)

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CCW_LIMIT | InputBit.CW_LIMIT


class Stations(Logic):
    """One axis, a start button and a lamp that is lit while the axis moves."""

    axis = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))
    start = Input("Local:2:I.Data.0")
    lamp: Output = Output("Local:3:O.Data.0")

    stations = (0, 4000, 8000)
    rounds = 0

    def every_scan(self) -> None:
        """Light the lamp."""
        self.lamp = self.axis.moving

    @sequence
    async def cycle(self) -> None:
        """Make rounds, and begin again after an error."""
        while True:
            try:
                await self.make_ready()
                while True:
                    await self.start.rises
                    await self.make_round()
                    self.rounds += 1
            except (AxisError, WaitTimeout):
                await steady(lambda: not self.axis.status.IN_ESTOP, "1 s", "estop off")

    async def make_ready(self) -> None:
        """Configure, reset, halt and search for home, as far as each is needed."""
        if self.axis.state == State.DISABLED:
            await self.axis.configure()
        if self.axis.state == State.ERROR_STOP:
            await self.axis.reset()
        if self.axis.state == State.DISCRETE_MOTION:
            await self.axis.halt()
        if self.axis.status.POSITION_INVALID:
            await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)

    async def make_round(self) -> None:
        """Go to all stations."""
        for station in self.stations:
            await within("5 s", self.axis.move_to(station, speed=5000, acceleration=10, deceleration=10))
            await dwell("2 s")
