"""Two axes that share a zone: the feeder may stand in it, or the pusher; never both.

Each axis leaves home only while it has the zone. `stop` ends both strokes: each axis goes back, and then
gives the zone away. `go` begins anew.
"""

from scanrack import Axis3601, Configuration, Input, InputBit, Lock, Logic, all_of, dwell, sequence

USED = InputBit.HOME | InputBit.CW_LIMIT  # the module wants a home and an end, wired or not
PLAIN = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500)


class Pair(Logic):
    """A feeder in slot 1 and a pusher in slot 3."""

    feeder = Axis3601(1, PLAIN)
    pusher = Axis3601(3, PLAIN)
    stop = Input("Local:2:I.Data.0")
    go = Input("Local:2:I.Data.1")
    zone = Lock()

    @sequence
    async def supervise(self) -> None:
        """Start both strokes, and end and begin them by the buttons."""
        await all_of(self.feeder.configure(), self.pusher.configure())
        await all_of(self.feeder.set_position(0), self.pusher.set_position(0))
        while True:
            self.feed.restart()
            self.push.restart()
            await self.stop.rises
            self.feed.abort()
            self.push.abort()
            await self.go.rises

    @sequence(start=False)
    async def feed(self) -> None:
        """Feed again and again."""
        while True:
            async with self.zone:
                await self.stroke(self.feeder, 4000)
            await dwell("100 ms")

    @sequence(start=False)
    async def push(self) -> None:
        """Push again and again."""
        while True:
            async with self.zone:
                await self.stroke(self.pusher, 2500)
            await dwell("50 ms")

    async def stroke(self, axis: Axis3601, end: int) -> None:
        """Go to the end of a stroke and back; back even if it is aborted."""
        try:
            await axis.move_to(end, speed=5000, acceleration=20, deceleration=20)
        finally:
            await axis.move_to(0, speed=5000, acceleration=20, deceleration=20)
