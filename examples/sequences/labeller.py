"""A registration labeller: the web runs until its mark comes, and stops exactly one label further.

The sensor looks at the web; print between two marks must not count, so the module ignores the sensor for the
first 2,000 steps of each feed. A feed that lasts two seconds means that the web is at its end.
"""

from scanrack import (
    Axis3601,
    AxisError,
    Configuration,
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

USED = InputBit.EXTERNAL | InputBit.HOME | InputBit.CW_LIMIT  # it wants a home and an end, wired or not


class Labeller(Logic):
    """A web drive, an applicator, and a lamp that says that the web is at its end."""

    web = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))
    refilled = Input("Local:2:I.Data.0")
    applicator: Output = Output("Local:3:O.Data.0")
    empty: Output = Output("Local:3:O.Data.1")

    limit = "2 s"
    labels = 0

    @sequence
    async def label(self) -> None:
        """Label, and begin again after an error."""
        while True:
            try:
                await self.make_ready()
                await self.feed()
            except AxisError:
                await dwell("500 ms")

    async def make_ready(self) -> None:
        """Let the applicator go, configure and reset the axis, wait until no mark is at the sensor."""
        self.applicator = self.empty = False
        if self.web.state == State.DISABLED:
            await self.web.configure()
        if self.web.state == State.ERROR_STOP:
            await self.web.reset()
        await self.web.store_minimum(2000)
        await steady(lambda: not self.web.status.IN_EXTERNAL, "20 ms", "no mark")

    async def feed(self) -> None:
        """Feed label by label."""
        while True:
            try:
                await within(self.limit, self.web.run(3000, acceleration=20, deceleration=20, register=600))
            except WaitTimeout:
                await self.wait_for_refill()
            else:
                await self.apply()

    async def apply(self) -> None:
        """Press the label on."""
        self.applicator = True
        await dwell("150 ms")
        self.applicator = False
        self.labels += 1

    async def wait_for_refill(self) -> None:
        """Bring the web to rest, and wait for a new one."""
        await self.web.halt()
        self.empty = True
        await self.refilled.rises
        self.empty = False
