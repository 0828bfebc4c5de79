"""Further correct programs for `scanrack check`, in which a rule could see a mistake."""

from __future__ import annotations

from check_idioms_python import HEAD, USED

MORE = {
    "jogsel.rung": """\
PROGRAM jogsel
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
ALIAS Plus : Local:2:I.Data.0
ALIAS Minus : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
TAG Ready : BOOL
TAG Right : BOOL
TAG Left : BOOL
TAG Word : INT
ROUTINE Main
XIC(S:FS)OTU(Ready);
XIO(Ready)COP(Setup,axis.O.Data,8);
XIO(Ready)XIC(axis.status.MODE_CONFIG)XIO(axis.status.CONFIG_ERROR)FLL(0,axis.O.Data,8)OTL(Ready);
XIC(Plus)XIO(Left)OTE(Right);
XIC(Minus)XIO(Right)OTE(Left);
CLR(Word);
XIC(Right)MOV(128,Word);
XIC(Left)MOV(256,Word);
XIC(Ready)MOV(2,axis.O.Data[4])MOV(50,axis.O.Data[6])MOV(50,axis.O.Data[7])MOV(Word,axis.O.Data[0]);
XIC(Ready)OTE(Lamp);
END
""",
    "hand_speeds.py": f"""\
from scanrack import Configuration, Idle, InputBit, PresetPosition, StatusView

SPEEDS = {{"slow": 650, "fast": 12500}}
SETTINGS = {USED}
SPEED_NS = 2_000_000


class Feed:
    step = 0
    name = "slow"
    since = 0
    length = 1500


feed = Feed()


def put(image, word, value):
    sign = -1 if value < 0 else 1
    image[word], image[word + 1] = sign * (abs(value) // 1000), sign * (abs(value) % 1000)


def logic(scan):
    axis, buttons = scan.slot[1], scan.slot[2].inputs
    outputs, status = axis.outputs, StatusView(axis.inputs)
    if feed.step == 0:
        outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            outputs.load(Idle().to_image())
            feed.step = 1
    elif feed.step == 1:
        if not status.MODE_CONFIG:
            outputs.load(PresetPosition(0).to_image())
            feed.step = 2
    elif feed.step == 2:
        if not status.POSITION_INVALID:
            outputs.load(Idle().to_image())
            feed.step = 3
    elif feed.step == 3:
        feed.name = "fast" if buttons.bit(0, 1) else "slow"
        feed.length = -1500 if buttons.bit(0, 2) else 2500
        if buttons.bit(0, 0):
            put(outputs, 2, feed.length)
            put(outputs, 4, SPEEDS[feed.name])
            outputs[6], outputs[7] = 25, 25
            outputs[0] |= 2
            feed.step = 4
    elif feed.step == 4:
        if status.MOVING_CW or status.MOVING_CCW:
            outputs[0] &= ~2
            feed.since = scan.now_ns
            feed.step = 5
    elif feed.step == 5 and status.MOVE_COMPLETE and scan.now_ns - feed.since > 10 * SPEED_NS:
        feed.step = 3
""",
    "wait_loop.py": f"""\
{HEAD}
TABLE = ((0, 1000), (2500, 4000), (-1000, 600))


class Loop(Logic):
    axis = Axis3601(1, SETTINGS)
    go = Input("Local:2:I.Data.0")
    count = 0

    @sequence
    async def run(self) -> None:
        await self.axis.configure()
        await self.axis.home(Direction.CCW, speed=1000, acceleration=10, deceleration=10)
        while True:
            await self.go.rises
            for place, speed in TABLE:
                await self.axis.move_to(place, speed=speed, acceleration=10, deceleration=10)
            left = 10
            while left:
                left = self.less(left)
            while self.count > 5:
                self.count -= 5
            await dwell("2 ms")
            self.count += 1

    def less(self, value: int) -> int:
        return value - 1
""",
}
"""The programs by name; none of them has a finding."""
