"""Searches for home, told by what the axis does: four kinds, either direction.

search = Search(-1, home=(3000, 3500))      # as for a clockwise search; mirrored for this one
search.command()
assert search.course(5_000) == ["ahead up", "ahead", "ahead down", "back up", ...]

"ahead" is the commanded direction, "back" the other one; "up" and "down" are the ramps.
"""

from __future__ import annotations

from bench3601 import BACKPLANE_PROXIMITY, ENCODER, HOME_CCW, HOME_CW, MARKER, Bench, configuration

PROXIMITY = 0x1000
"""Command LSW bit 12, the backplane home proximity bit."""

USE_HOME = 0x0004
USE_LIMIT = {1: 0x0010, -1: 0x0020}

HOME_SWITCH, HOME_SWITCH_PROXIMITY = "home switch", "home switch + proximity bit"
MARKER_HOME_SWITCH, MARKER_PROXIMITY = "marker + home switch", "marker + proximity bit"

KINDS = {
    HOME_SWITCH: (0, 0),
    HOME_SWITCH_PROXIMITY: (BACKPLANE_PROXIMITY, 0),
    MARKER_HOME_SWITCH: (MARKER | ENCODER, 0),
    MARKER_PROXIMITY: (MARKER | ENCODER | BACKPLANE_PROXIMITY, USE_HOME),
}
"""Configuration MSW bits added to the usual ones, and dropped [chapter 3, item 10]."""

ROUND_THE_SWITCH = ["ahead up", "ahead", "ahead down", "back up", "back", "back down", "ahead", "still"]
"""What a search does that finds a home switch that serves alone."""

MOTION = {"MOVING_CW": 1, "MOVING_CCW": -1}
RAMP = {"ACCELERATING": " up", "DECELERATING": " down"}


class Search:
    """A bench on which home is searched for, from shaft position 0.

    Args:
        direction: +1 CW, -1 CCW.
        kind: one of `KINDS`.
        home: shaft positions that operate the home switch, as for a clockwise search; None = by hand.
        ahead: the same for the end limit of the commanded direction.
        behind: the same for the other end limit.
        add: further configuration MSW bits.
        drop: configuration MSW bits left out.
        start: starting speed.
        valid: the position is preset to 0, and so valid.
        bench: what else the bench takes.
    """

    def __init__(
        self,
        direction: int = 1,
        kind: str = HOME_SWITCH,
        *,
        home: tuple[int, int | None] | None = None,
        ahead: tuple[int, int | None] | None = None,
        behind: tuple[int | None, int] | None = None,
        add: int = 0,
        drop: int = 0,
        start: int = 1000,
        valid: bool = False,
        **bench,
    ) -> None:
        self.direction = direction
        self.ahead, self.behind = ("cw_limit", "ccw_limit")[::direction]
        wiring = {"home": home, self.ahead: ahead, self.behind: behind}
        kind_add, kind_drop = KINDS[kind]
        self.bench = (Bench.ready if valid else Bench.configured)(
            config=configuration(add=kind_add | add, drop=kind_drop | drop, start=start),
            machine={name: self._mirrored(ends) for name, ends in wiring.items() if ends is not None},
            **bench,
        )

    def _mirrored(self, ends: tuple[int | None, int | None]) -> tuple[int | None, int | None]:
        first, last = (None if end is None else self.direction * end for end in ends)
        return (first, last) if self.direction > 0 else (last, first)

    def command(self, *, target: int = 0, lsw: int = 0, ms: float = 0, **parameters) -> Bench:
        """Write Find Home in the direction of the search."""
        msw = HOME_CW if self.direction > 0 else HOME_CCW
        return self.bench.command(msw, target, lsw=lsw, ms=ms, **parameters)

    def proximity(self, on: bool) -> Bench:
        """Write the backplane proximity bit, and nothing else changed."""
        msw, lsw, *rest = self.bench.outputs
        return self.bench.out(msw, lsw | PROXIMITY if on else lsw & ~PROXIMITY, *rest)

    @property
    def shaft(self) -> int:
        """Shaft position in the commanded direction: the module's count is 0 at home."""
        return self.direction * self.bench.module.machine.shaft

    @property
    def position(self) -> int:
        """The module's count, in the commanded direction."""
        return self.direction * self.bench.position

    @property
    def motion(self) -> str:
        """What the motion bits show."""
        bits = self.bench.bits
        moving = [sense for name, sense in MOTION.items() if name in bits]
        if not moving:
            return "still"
        assert len(moving) == 1
        where = "ahead" if moving[0] == self.direction else "back"
        return where + "".join(ramp for name, ramp in RAMP.items() if name in bits)

    def course(self, ms: float) -> list[str]:
        """Let time run until the search is over, at most so long; return what the axis did on the way.

        From the second scan on, time jumps to those that can show other bits, see `Bench.until`.
        """
        seen: list[str] = []
        end_ns = self.bench.now_ns + int(ms * 1_000_000)
        while self.bench.now_ns < end_ns and self.bench.bits.isdisjoint({"AT_HOME", "HOME_INVALID"}):
            self.bench.to_change(end_ns if seen else self.bench.now_ns)
            if not seen or seen[-1] != self.motion:
                seen.append(self.motion)
        return seen

    def turns(self, ms: float) -> list[str]:
        """The same without the ramps, for where less than a step of constant speed may lie between two."""
        seen: list[str] = []
        for motion in self.course(ms):
            where = motion.split()[0]
            if not seen or seen[-1] != where:
                seen.append(where)
        return seen
