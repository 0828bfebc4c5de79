"""A jog panel: two buttons that turn the axis for as long as they are held, and one that searches for home.

After an emergency stop, an end limit or a loss of power the axis is made ready again, once the emergency stop
has been out for a second.
"""

from scanrack import (
    Axis3601,
    AxisError,
    Configuration,
    Direction,
    Input,
    InputBit,
    Logic,
    State,
    first_of,
    sequence,
    steady,
)

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CCW_LIMIT | InputBit.CW_LIMIT


class Panel(Logic):
    """One axis and three buttons."""

    axis = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))
    estop = Input("slot1.status.IN_ESTOP")
    cw = Input("Local:2:I.Data.0")
    ccw = Input("Local:2:I.Data.1")
    search = Input("Local:2:I.Data.2")

    @sequence
    async def panel(self) -> None:
        """Obey the buttons, and begin again after an error."""
        while True:
            try:
                await self.make_ready()
                while True:
                    await self.obey()
            except AxisError:
                await steady(lambda: not self.estop, "1 s", "estop off")

    async def make_ready(self) -> None:
        """Configure and reset the axis, as far as each is needed."""
        if self.axis.state == State.DISABLED:
            await self.axis.configure()
        if self.axis.state == State.ERROR_STOP:
            await self.axis.reset()

    async def obey(self) -> None:
        """Do what the next button asks for."""
        cw, ccw = self.cw.on, self.ccw.on
        button = await first_of(cw, ccw, self.search.rises)
        if button is cw:
            await self.jog(self.cw, 2000)
        elif button is ccw:
            await self.jog(self.ccw, -2000)
        else:
            await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)

    async def jog(self, button: Input, speed: int) -> None:
        """Turn for as long as a button is held."""
        released = button.off
        if await first_of(self.axis.run(speed, acceleration=10, deceleration=10), released) is released:
            await self.axis.halt()
