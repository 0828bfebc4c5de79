"""Home; then at each press of start, move to 4,000 steps and back."""

from scanrack import Axis3601, Configuration, Direction, Input, InputBit, Logic, Output, dwell, sequence

USED = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT


class Shuttle(Logic):
    """One axis, a start button and a lamp that is lit while the axis moves."""

    axis = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))
    start = Input("Local:2:I.Data.0")
    lamp: Output = Output("Local:3:O.Data.0")
    rounds = 0

    @sequence
    async def cycle(self) -> None:
        """Home once, then make a round for each press."""
        await self.axis.configure()
        await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        while True:
            await self.start.rises
            await self.axis.move_to(4000, speed=5000, acceleration=10, deceleration=10)
            await dwell("1 s")
            await self.axis.move_to(0, speed=5000, acceleration=10, deceleration=10)
            self.rounds += 1

    def every_scan(self) -> None:
        """Light the lamp."""
        self.lamp = self.axis.moving
