"""A motion: travel as a closed form of time, from its first step to its last.

    travel_at      picosteps since the start, never negative
    steps_at       whole steps: floor(travel)
    position_at    origin + direction * steps
    instant_of     the first instant at which a number of steps is made

A motion is a value: evaluating it changes nothing. At the joint of two segments the
later one applies; from `end_ns` on the axis is at rest.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence

from .segment import Segment


class Motion:
    """The plan of a step generator, from `start_ns` until another plan replaces it.

    Instants before `start_ns` are not part of it and must not be queried.

    Args:
        direction: +1 or -1.
        origin: step count at which the travel was 0.
        segments: in order of time, without gap.
        rest: the standstill after the last one, None for an endless motion.

    Raises:
        ValueError: an illegal direction.
    """

    __slots__ = (
        "_begins",
        "_ends",
        "_latest",
        "_track",
        "direction",
        "end_ns",
        "final_steps",
        "origin",
        "segments",
        "start_ns",
    )

    def __init__(
        self,
        direction: int,
        origin: int,
        start_ns: int,
        segments: Sequence[Segment],
        rest: Segment | None = None,
    ) -> None:
        if direction not in (1, -1):
            raise ValueError(f"direction {direction} is not allowed: only 1 (CW) and -1 (CCW)")
        self.direction = direction
        self.origin = origin  # step count at which the travel was 0
        self.start_ns = start_ns
        self.segments = tuple(segments)  # in order of time, without gap; empty if it ends as it begins
        self.end_ns: int | None = None  # the instant of its last step, None for an endless one
        self.final_steps: int | None = None  # whole steps it will have made, None for an endless one
        self._track = self.segments
        if rest is not None:
            self.end_ns = rest.start_ns
            self.final_steps = rest.steps_at(rest.start_ns)
            self._track += (rest,)
        self._ends = tuple(segment.until_ns for segment in self._track)
        self._begins = tuple(segment.steps_at(segment.start_ns) for segment in self._track)
        self._latest = self._track[0]

    def __repr__(self) -> str:
        steps = "endless" if self.final_steps is None else f"{self.final_steps} steps"
        return (
            f"<Motion {self.direction:+d} from {self.origin}, {steps}, "
            f"{self.start_ns} to {self.end_ns} ns, {len(self.segments)} segments>"
        )

    def segment_at(self, t_ns: int) -> Segment:
        """Return the segment that applies at an instant; from `end_ns` on, a standstill."""
        segment = self._latest
        if not segment.start_ns <= t_ns < segment.until_ns:
            segment = self._latest = self._track[bisect_right(self._ends, t_ns)]
        return segment

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the travel was 0, without sign."""
        return self.segment_at(t_ns).travel_at(t_ns)

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the travel was 0, without sign."""
        return self.segment_at(t_ns).steps_at(t_ns)

    def position_at(self, t_ns: int) -> int:
        """Return the step count: origin + direction * steps."""
        segment = self._latest
        if not segment.start_ns <= t_ns < segment.until_ns:
            segment = self.segment_at(t_ns)
        return self.origin + self.direction * segment.steps_at(t_ns)

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down; 0 from `end_ns` on."""
        return self.segment_at(t_ns).speed_at(t_ns)

    def ramp_at(self, t_ns: int) -> int:
        """Return +1 while accelerating, -1 while decelerating, 0 at constant speed and from `end_ns` on."""
        return self.segment_at(t_ns).ramp

    def on_last_ramp(self, t_ns: int) -> bool:
        """Return whether only deceleration is left; False for an endless or ended motion."""
        ramps_left = [segment.ramp for segment in self.segments if segment.until_ns > t_ns]
        return self.end_ns is not None and bool(ramps_left) and all(ramp < 0 for ramp in ramps_left)

    def instant_of(self, steps: int) -> int | None:
        """Return the first instant at which a number of whole steps is made.

        Args:
            steps: counted from the point where the travel was 0.

        Returns:
            `start_ns` for steps already made then, None for steps that the motion never makes.
        """
        index = bisect_left(self._begins, steps)
        if index == 0:
            return self.start_ns
        if index == len(self._track) and self.end_ns is not None:
            return None
        return self._track[index - 1].instant_of(steps)
