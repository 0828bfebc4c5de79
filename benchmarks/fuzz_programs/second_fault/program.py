"""An axis goes to and fro, and finds its way back after any fault."""

from scanrack import Axis3601, AxisError, Configuration, InputBit, Logic, State, dwell, sequence

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
PLAIN = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500)


class Shuttle(Logic):
    """One axis, one sequence."""

    axis = Axis3601(1, PLAIN)
    strokes = 0

    @sequence
    async def cycle(self) -> None:
        """Make strokes; begin again after a fault."""
        while True:
            try:
                await self.make_ready()
                await self.axis.move_to(2500, speed=6000, acceleration=20, deceleration=20)
                await self.axis.move_to(0, speed=6000, acceleration=20, deceleration=20)
                self.strokes += 1
            except AxisError:
                await dwell("50 ms")

    async def make_ready(self) -> None:
        """Configure, reset and set the position, as far as each is needed."""
        if self.axis.state == State.DISABLED:
            await self.axis.configure()
        if self.axis.state == State.ERROR_STOP:
            await self.axis.reset()
        if self.axis.status.POSITION_INVALID:
            await self.axis.set_position(0)
