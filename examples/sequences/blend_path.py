"""A blend path: a slow start, a fast middle and a slow end in one motion, to and fro.

The profile is programmed once; each press of go runs it, clockwise and back by turns.
"""

from scanrack import (
    Axis3601,
    AxisError,
    BlendSegment,
    Configuration,
    Direction,
    Input,
    InputBit,
    Logic,
    State,
    dwell,
    sequence,
)

USED = InputBit.HOME | InputBit.CW_LIMIT  # the module wants a home and an end, wired or not

PATH = (
    BlendSegment(length=1000, speed=1000, rate=10),
    BlendSegment(length=4000, speed=8000, rate=50),
    BlendSegment(length=2000, speed=2000, rate=50),
)


class BlendPath(Logic):
    """One axis and a button."""

    axis = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))
    go = Input("Local:2:I.Data.0")

    @sequence
    async def path(self) -> None:
        """Run the path at each press, and begin again after an error."""
        while True:
            try:
                await self.make_ready()
                while True:
                    for way in (Direction.CW, Direction.CCW):
                        await self.go.rises
                        await self.axis.run_blend(way)
            except AxisError:
                await dwell("1 s")

    async def make_ready(self) -> None:
        """Configure and reset the axis, and program the path."""
        if self.axis.state == State.DISABLED:
            await self.axis.configure()
        if self.axis.state == State.ERROR_STOP:
            await self.axis.reset()
        await self.axis.program_blend(PATH, final_deceleration=20)
