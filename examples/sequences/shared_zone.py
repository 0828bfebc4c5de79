"""Two axes that share a zone: the feeder may be in it, or the pusher; never both.

An axis moves only while it has the zone, and gives it away at home. After `stop` each axis ends its stroke;
`go` begins again.
"""

from scanrack import (
    Axis3601,
    AxisError,
    Configuration,
    Direction,
    Input,
    InputBit,
    Lock,
    Logic,
    State,
    dwell,
    sequence,
    until,
)

USED = InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT
PLAIN = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500)


class Pair(Logic):
    """A feeder in slot 1 and a pusher in slot 3."""

    feeder = Axis3601(1, PLAIN)
    pusher = Axis3601(3, PLAIN)
    stop = Input("Local:2:I.Data.0")
    go = Input("Local:2:I.Data.1")
    zone = Lock()

    home = 0
    running = True

    def every_scan(self) -> None:
        """Obey the buttons; stop comes first."""
        if self.stop:
            self.running = False
        elif self.go:
            self.running = True

    @sequence
    async def feed(self) -> None:
        """Feed again and again."""
        await self.work(self.feeder, 4000, "100 ms")

    @sequence
    async def push(self) -> None:
        """Push again and again."""
        await self.work(self.pusher, 2500, "50 ms")

    async def work(self, axis: Axis3601, end: int, pause: str) -> None:
        """Make strokes while the pair runs; none before both axes are at rest."""
        await until(lambda: not self.feeder.moving and not self.pusher.moving, "both axes at rest")
        while True:
            await until(lambda: self.running, "running")
            async with self.zone:
                await self.stroke(axis, end)
            await dwell(pause)

    async def stroke(self, axis: Axis3601, end: int) -> None:
        """Go to the end of a stroke and back; back whatever happens."""
        try:
            await self.make_ready(axis)
            await axis.move_to(end, speed=5000, acceleration=20, deceleration=20)
        except AxisError:
            pass  # go_home makes it ready again
        await self.go_home(axis)

    async def go_home(self, axis: Axis3601) -> None:
        """Go home, however often it takes."""
        while True:
            try:
                await self.make_ready(axis)
                await axis.move_to(self.home, speed=5000, acceleration=20, deceleration=20)
            except AxisError:
                await dwell("500 ms")
            else:
                return

    async def make_ready(self, axis: Axis3601) -> None:
        """Configure, reset and search for home, as far as each is needed."""
        if axis.state == State.DISABLED:
            await axis.configure()
        if axis.state == State.ERROR_STOP:
            await axis.reset()
        if axis.status.POSITION_INVALID:
            await axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
