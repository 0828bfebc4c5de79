"""Every kind of motion that a 3601 makes, each on the same timeline: for tables over all of them.

bench = Motion.of("manual cw").started()     # preset position 0, encoder configured, moving
bench.run(400)                               # 0.2 s up to 5000 steps/s, then 0.2 s at it
assert bench.position == 1_600

Starting speed 1000, speed 5000, acceleration 20, deceleration 10, all of constant acceleration:

    t (ms)      0     100     200     400
    speed    1000    3000    5000    5000
    steps       0     200     600    1600      200 = 1000 * 0.1 + 10,000 * 0.01
    stop in            400    1200    1200      v * v - Vo * Vo over 2 * 10,000
    within          200 ms  400 ms  400 ms      v - Vo over 10,000
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bench3601 import (
    ABSOLUTE,
    BLEND_CCW,
    BLEND_CW,
    ENCODER,
    HOLD,
    HOME_CCW,
    HOME_CW,
    MANUAL_CCW,
    MANUAL_CW,
    RELATIVE,
    Bench,
    configuration,
)

ENCODER_MOVE, FOLLOW, PROGRAM, TRANSMIT = 0x0004, 0x0080, 0x0100, 0x0200
FOLLOW_ONE_TO_ONE = (1, 1, 0, 0, 0, 0)
"""Output words 2 to 7 of a follower: a step a count, without ramps."""

STEPS = {100: 200, 200: 600, 400: 1_600}
"""Steps made so many ms after the start."""

TO_STOP = {100: (400, 200), 200: (1_200, 400), 400: (1_200, 400)}
"""Steps and ms that a controlled stop takes then."""

LONG = 20_000
"""Distance of a move that is still at constant speed 3 s after its start."""

REGISTERED = 3_000
"""Steps of a registration move after its input."""


@dataclass(frozen=True)
class Motion:
    """A kind of motion, and how it is started.

    Attributes:
        name: of the kind, with its direction where it has one.
        direction: +1 CW, -1 CCW, 0 where nothing moves.
        msw: its command bit.
        lsw: its command LSW.
        target: its target position.
        before: what has to be done first.
    """

    name: str
    direction: int
    msw: int
    lsw: int = 0
    target: int = 0
    before: Callable[[Bench], None] = lambda bench: None

    @staticmethod
    def of(name: str) -> Motion:
        return next(motion for motion in (*MOTIONS, *AT_REST) if motion.name == name)

    def bench(self, **kwargs) -> Bench:
        """Return a bench on which everything is ready for the start, its position 0 and valid."""
        bench = Bench.ready(config=configuration(add=ENCODER), **kwargs)
        self.before(bench)
        assert "POSITION_INVALID" not in bench.bits
        bench.fired.clear()
        return bench

    def start(self, bench: Bench) -> Bench:
        """Write the words that start it; it moves as soon as time runs."""
        if self.follows:  # somebody turns the encoder at 5 counts/ms, for 3 s
            machine = bench.module.machine
            machine.let_go(bench.now_ns)
            machine.turn_encoder(15_000, bench.now_ns, bench.now_ns + 3_000_000_000)
            return bench.out(self.msw, self.lsw, *FOLLOW_ONE_TO_ONE)
        if self.msw & (BLEND_CW | BLEND_CCW):
            return bench.out(self.msw)
        return bench.command(self.msw, self.target, lsw=self.lsw)

    def started(self, ms: float, **kwargs) -> Bench:
        """Return a bench on which it has been under way for `ms`."""
        return self.start(self.bench(**kwargs)).run(ms)

    @property
    def follows(self) -> bool:
        return bool(self.lsw & FOLLOW)

    @property
    def moving(self) -> str:
        """Name of its motion bit."""
        return "MOVING_CW" if self.direction > 0 else "MOVING_CCW"

    @property
    def shown(self) -> set[str]:
        """Bits that show it beside MODULE_OK and those of the ramps."""
        extra = {"ENC_FOLLOWER"} if self.follows else set()
        if self.msw & (BLEND_CW | BLEND_CCW):
            extra = {"BLEND_RUNNING"}
        return extra | {self.moving} if self.direction else extra

    def steps(self, ms: int) -> int:
        """Position so long after the start from 0; a follower has been turned at 5 counts/ms."""
        steps = 5 * ms if self.follows else STEPS[ms]
        return self.direction * steps


def program_blend(bench: Bench) -> None:
    """Store 20,000 steps at 5000/s and 5000 at 2000/s, rates 20 and 10, final deceleration 10."""
    blocks = [(2, 0, 0, 10, 0, 0), (20, 0, 5, 0, 20, 0), (5, 0, 2, 0, 10, 0)]
    for block in blocks:
        bench.out(0, PROGRAM | TRANSMIT, *block).run(bench.scan_ns / 1_000_000)
        assert "BLEND_ACK" in bench.bits
        bench.out(0, PROGRAM).run(bench.scan_ns / 1_000_000)
    bench.idle()
    assert bench.bits == {"MODULE_OK"}


def hold_one(bench: Bench) -> None:
    """Hold a relative move after 400 ms; it stops 1200 steps later."""
    bench.relative(LONG, ms=400)
    bench.out(HOLD).run(400)
    assert (bench.position, bench.bits) == (2_800, {"MODULE_OK", "HOLD_STATE"})
    bench.idle(bench.scan_ns / 1_000_000)


MOTIONS = (
    Motion("absolute cw", 1, ABSOLUTE, target=LONG),
    Motion("absolute ccw", -1, ABSOLUTE, target=-LONG),
    Motion("relative cw", 1, RELATIVE, target=LONG),
    Motion("relative ccw", -1, RELATIVE, target=-LONG),
    Motion("absolute encoder cw", 1, ABSOLUTE, ENCODER_MOVE, LONG),
    Motion("absolute encoder ccw", -1, ABSOLUTE, ENCODER_MOVE, -LONG),
    Motion("relative encoder cw", 1, RELATIVE, ENCODER_MOVE, LONG),
    Motion("relative encoder ccw", -1, RELATIVE, ENCODER_MOVE, -LONG),
    Motion("manual cw", 1, MANUAL_CW),
    Motion("manual ccw", -1, MANUAL_CCW),
    Motion("registration cw", 1, MANUAL_CW, target=REGISTERED),
    Motion("registration ccw", -1, MANUAL_CCW, target=REGISTERED),
    Motion("home cw", 1, HOME_CW),
    Motion("home ccw", -1, HOME_CCW),
    Motion("blend cw", 1, BLEND_CW, before=program_blend),
    Motion("blend ccw", -1, BLEND_CCW, before=program_blend),
    Motion("follower cw", 1, MANUAL_CW, FOLLOW),
    Motion("follower ccw", -1, MANUAL_CCW, FOLLOW),
)

AT_REST = (
    Motion("idle", 0, 0),
    Motion("held", 0, 0, before=hold_one),
)


def held(**kwargs) -> Bench:
    """A relative move held at 2800, with 17,200 steps to go; encoder and blend profile are there."""
    bench = Motion.of("blend cw").bench(**kwargs)
    hold_one(bench)
    return bench
